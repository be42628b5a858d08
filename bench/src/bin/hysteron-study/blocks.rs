//! What limits the fit of the default bench, which lies outside the model class? The error of the whole
//! model, of its dynamics alone and of its hysteresis alone, in the pattern of the article's Table 3.
//!
//! The bench knows the true output v of its hysteresis. *Dynamics alone*: G and delay are identified with v
//! as the drive and followed from it. *Hysteresis alone*: the Bouc–Wen block is identified with v as the
//! output (with a lag for the amplifier in front of it) and what it gives is put through the true dynamics of
//! the bench.

use hysteron_identify::{CampaignRecord, Choice, Demands, DynamicsChoice, Options, Watch, identify};
use hysteron_model::Start;
use hysteron_model::dynamics::Creep;
use hysteron_model::hammerstein::Model;
use hysteron_model::record::ChannelChoice;
use hysteron_rig::excitation::Excitation;
use hysteron_rig::{CampaignPlan, Plant, PlayStack, RigRun, Role, Truth, measure, run_campaign};

use crate::Outcome;
use crate::campaign::record;
use crate::table;

/// The default bench: the loop and the sweep, then the sines with their frequencies.
struct Bench {
    fitted: Vec<RigRun>,
    sines: Vec<(f64, RigRun)>,
    rate_hz: f64,
}

impl Bench {
    fn play(seed: u64) -> Outcome<Self> {
        let plan = CampaignPlan::default();
        let mut bench = Self { fitted: Vec::new(), sines: Vec::new(), rate_hz: plan.sample_rate_hz };
        for played in run_campaign(&Truth::default(), &plan, seed)? {
            match played.role {
                Role::QuasiStatic | Role::Sweep => bench.fitted.push(played.run),
                Role::Validation { frequency_hz } => bench.sines.push((frequency_hz, played.run)),
                _ => {}
            }
        }
        Ok(bench)
    }

    /// Drive to reading.
    fn whole(&self) -> Outcome<Vec<CampaignRecord>> {
        let data = |run: &RigRun| run.record.input_output(&ChannelChoice::default());
        self.fitted.iter().map(|run| Ok(CampaignRecord { data: data(run)?, role: None })).collect()
    }

    /// True hysteresis output to reading.
    fn dynamics(&self) -> Outcome<Vec<CampaignRecord>> {
        self.fitted
            .iter()
            .map(|run| record(&run.record.name, self.rate_hz, &run.hysteresis_um, reading(run)))
            .collect()
    }

    /// Drive to true hysteresis output.
    fn hysteresis(&self) -> Outcome<Vec<CampaignRecord>> {
        self.fitted
            .iter()
            .map(|run| record(&run.record.name, self.rate_hz, drive(run), &run.hysteresis_um))
            .collect()
    }
}

fn drive(run: &RigRun) -> &[f64] {
    &run.record.channels[0].samples
}

fn reading(run: &RigRun) -> &[f64] {
    &run.record.channels[1].samples
}

/// The bench without hysteresis, amplifier and sensor: its drive is v.
fn true_dynamics() -> Outcome<Truth> {
    let truth = Truth::default().with_ideal_sensor();
    let Plant::PlayStack(stack) = truth.plant else {
        return Err("the default bench is a stack of plays".into());
    };
    let plant = Plant::PlayStack(PlayStack {
        amplifier_corner_hz: None,
        linear_um_per_v: 1.0,
        plays: Vec::new(),
        quadratic_per_um: 0.0,
        cubic_per_um2: 0.0,
        ..stack
    });
    Ok(Truth { plant, ..truth })
}

fn through_true_dynamics(v: Vec<f64>, rate_hz: f64) -> Outcome<Vec<f64>> {
    let drive = Excitation::of_samples("v".into(), "output of a hysteresis block".into(), v, rate_hz);
    Ok(measure(&true_dynamics()?, &drive, 0, 0)?.y_true_um)
}

/// Largest error and RMSE, the mean error taken off (the bench creeps), as in Table 3.
fn errors(simulated: &[f64], measured: &[f64]) -> String {
    let mean = simulated.iter().zip(measured).map(|(a, b)| a - b).sum::<f64>() / measured.len() as f64;
    let left = || simulated.iter().zip(measured).map(|(a, b)| a - b - mean);
    format!("{:.3} / {:.4}", left().fold(0.0, |worst: f64, e| worst.max(e.abs())), table::rms(left()))
}

/// A model, and how the output of a sine follows from it.
struct Row {
    name: &'static str,
    fit: Fit,
    simulate: fn(&Fit, &RigRun, f64) -> Outcome<Vec<f64>>,
}

/// A model, and the start of its first record: the bench starts every record alike.
struct Fit {
    model: Model,
    start: Start,
}

fn simulate(Fit { model, start }: &Fit, drive: &[f64], rate_hz: f64) -> Outcome<Vec<f64>> {
    let start = match *start {
        Start::Remembering { memory, .. } => Start::Remembering { voltage_v: drive[0], memory },
        _ => Start::Rest { voltage_v: drive[0] },
    };
    Ok(model.simulate(drive, Some(rate_hz), &start)?)
}

fn fit(records: &[CampaignRecord], options: &Options) -> Outcome<Fit> {
    let found = identify(records, options, &Watch::silent(), None)?;
    let start = found.records.first().ok_or("a fit has a record")?.start;
    Ok(Fit { model: found.model, start })
}

fn rows(bench: &Bench) -> Outcome<Vec<Row>> {
    use DynamicsChoice::{Fractional, Integer, None as Static};
    let whole = |fit: &Fit, run: &RigRun, rate_hz| simulate(fit, drive(run), rate_hz);
    let dynamics_alone = |fit: &Fit, run: &RigRun, rate_hz| simulate(fit, &run.hysteresis_um, rate_hz);
    let hysteresis_alone = |fit: &Fit, run: &RigRun, rate_hz| {
        through_true_dynamics(simulate(fit, drive(run), rate_hz)?, rate_hz)
    };
    // v goes straight into G: no loop, no polynomial.
    let hold = |name: &str| (name.to_owned(), 0.0);
    let fixed = ["alpha", "beta", "gamma", "memory_1", "memory_2"].map(hold).to_vec();
    let straight = Demands { fixed, ..Demands::default() };
    let with = |dynamics, creep| Options { dynamics, creep, ..Options::default() };
    let alone = |dynamics, creep| Options {
        degree: Choice::Given(1),
        demands: straight.clone(),
        ..with(dynamics, creep)
    };
    let lag = Options { order: 1, ..with(Integer, Creep::None) };
    let (all, from_v, to_v) = (bench.whole()?, bench.dynamics()?, bench.hysteresis()?);
    Ok(vec![
        Row { name: "whole: no dynamics", fit: fit(&all, &with(Static, Creep::None))?, simulate: whole },
        Row { name: "whole: integer order", fit: fit(&all, &with(Integer, Creep::None))?, simulate: whole },
        Row { name: "whole: fractional", fit: fit(&all, &with(Fractional, Creep::None))?, simulate: whole },
        Row {
            name: "whole: fractional with creep",
            fit: fit(&all, &with(Fractional, Creep::Fractional))?,
            simulate: whole,
        },
        Row {
            name: "dynamics alone: integer order",
            fit: fit(&from_v, &alone(Integer, Creep::None))?,
            simulate: dynamics_alone,
        },
        Row {
            name: "dynamics alone: fractional",
            fit: fit(&from_v, &alone(Fractional, Creep::None))?,
            simulate: dynamics_alone,
        },
        Row {
            name: "dynamics alone: fractional with creep",
            fit: fit(&from_v, &alone(Fractional, Creep::Fractional))?,
            simulate: dynamics_alone,
        },
        Row { name: "hysteresis alone: n = 1", fit: fit(&to_v, &lag)?, simulate: hysteresis_alone },
        Row {
            name: "hysteresis alone: n free",
            fit: fit(&to_v, &Options { n: Choice::Auto, ..lag })?,
            simulate: hysteresis_alone,
        },
    ])
}

pub fn study(seed: usize) -> Outcome<()> {
    let bench = Bench::play(seed as u64)?;
    let mut lines = Vec::new();
    for row in rows(&bench)? {
        let mut line = vec![row.name.to_owned()];
        for (_, run) in &bench.sines {
            line.push(errors(&(row.simulate)(&row.fit, run, bench.rate_hz)?, reading(run)));
        }
        lines.push(line);
    }
    let frequencies: Vec<String> = bench.sines.iter().map(|(f, _)| format!("{f} Hz")).collect();
    let header: Vec<&str> =
        ["max error / RMSE [µm]"].into_iter().chain(frequencies.iter().map(String::as_str)).collect();
    table::print(&header, &lines)
}
