//! Computing time on uneven time stamps: one evaluation of the joint objective with derivatives and one
//! simulation, on one thread, relative to the same drive at one rate.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::io::{Write, stdout};
use std::time::Instant;

use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, FamilyChoice, Initial, JointObjective, Options, RecordRole,
};
use hysteron_model::Start;
use hysteron_model::dynamics::{Creep, DynamicForm, Dynamics, Modes, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, HysteresisForm, PrandtlIshlinskii};
use hysteron_model::record::{InputOutput, InterSample, TimeBase, Timing};
use hysteron_optimize::{Derivative, LeastSquaresProblem, Problem};

use crate::Outcome;
use crate::table;

const SAMPLES: usize = 100_000;
const RATE_HZ: f64 = 10_000.0;
/// The slow drive moves by less than 1/400 of its range from one sample to the next: on stamps every sample
/// is a knot; the fast one asks for four or five knots a sample.
const FREQUENCIES_HZ: [f64; 2] = [5.0, 50.0];
const PLAYS: usize = 12;
const DEGREE: usize = 2;

/// When the samples were taken.
#[derive(Clone, Copy, PartialEq)]
enum Stamps {
    /// At one rate.
    Uniform,
    /// At two rates in turn, with a pause behind every pair.
    TwoRates,
    /// Every step another one.
    Jittered,
}

impl Stamps {
    const ALL: [Self; 3] = [Self::Uniform, Self::TwoRates, Self::Jittered];

    fn times_s(self) -> Vec<f64> {
        let step = |k: usize| match self {
            Self::TwoRates if k.is_multiple_of(20_000) => 2000.0,
            Self::TwoRates if k % 20_000 >= 10_000 => 5.0,
            Self::Uniform | Self::TwoRates => 1.0,
            // A share of the golden section: no two are equal.
            Self::Jittered => 0.7 + 0.6 * (0.618_033_988_749_895 * k as f64).fract(),
        };
        let mut ticks = 0.0;
        let stamp = |k| {
            ticks += if k == 0 { 0.0 } else { step(k) };
            ticks / RATE_HZ
        };
        (0..SAMPLES).map(stamp).collect()
    }
}

const DELAY_S: f64 = 1.2e-4;
/// f, ζ, α, β of fractional dynamics; integer ones have the first two.
const FRACTIONAL: [f64; 4] = [318.0, 0.65, 1.94, 1.05];

/// Name of a kind of dynamics, what it is fitted as, and its parameters.
type Kind = (&'static str, DynamicsChoice, Dynamics, &'static [f64]);

fn dynamics() -> Outcome<[Kind; 3]> {
    let tf = |modes, p: &[f64]| DynamicForm { modes, creep: Creep::None }.transfer_function(p);
    let (integer, fractional) = (&FRACTIONAL[..2], &FRACTIONAL[..]);
    Ok([
        ("none", DynamicsChoice::None, Dynamics::None, &[]),
        (
            "integer",
            DynamicsChoice::Integer,
            Dynamics::Integer(tf(Modes::Integer { order: 2 }, integer)?),
            integer,
        ),
        (
            "fractional",
            DynamicsChoice::Fractional,
            Dynamics::Fractional(tf(Modes::Fractional, fractional)?),
            fractional,
        ),
    ])
}

fn operators() -> Outcome<[(&'static str, HysteresisForm, Hysteresis); 2]> {
    let thresholds = (1..=PLAYS).map(|j| 5.0 * j as f64 / (PLAYS + 1) as f64).collect();
    let plays = PrandtlIshlinskii::new(vec![3.2, -0.02], thresholds, vec![0.1; PLAYS])?;
    Ok([
        (
            "Bouc–Wen",
            HysteresisForm::bouc_wen(),
            Hysteresis::from(BoucWen::new(vec![3.2, -0.02], 1.1, 0.35, 0.08, 1.0)?),
        ),
        ("12 plays", HysteresisForm::plays(PLAYS), Hysteresis::from(plays)),
    ])
}

/// One time base: the record, the problem and the shortest times so far.
struct Bench {
    times_s: Option<Vec<f64>>,
    u: Vec<f64>,
    objective: JointObjective,
    x: Vec<f64>,
    /// Of a simulation and of an evaluation \[s\].
    shortest: [f64; 2],
}

impl Bench {
    /// `known`: the parameters of the dynamics, at which the objective is evaluated; the hysteresis has those
    /// of the first start.
    fn new(
        model: &Model,
        known: &[f64],
        options: &Options,
        frequency_hz: f64,
        stamps: Stamps,
    ) -> Outcome<Self> {
        let times_s = stamps.times_s();
        // At the lower of two rates the drive is slower, too.
        let phase = |(k, t): (usize, &f64)| match stamps {
            Stamps::TwoRates => TAU * frequency_hz * k as f64 / RATE_HZ,
            Stamps::Uniform | Stamps::Jittered => TAU * frequency_hz * t,
        };
        let amplitude = |k: usize| 5.0 - 2.0 * k as f64 / SAMPLES as f64;
        let u: Vec<f64> =
            times_s.iter().enumerate().map(|(k, t)| amplitude(k) * (1.0 - phase((k, t)).cos())).collect();
        let uneven = (stamps != Stamps::Uniform).then_some(times_s);
        let y = simulate(model, &u, uneven.as_deref())?;
        let time = match &uneven {
            None => TimeBase::uniform(RATE_HZ),
            Some(times_s) => TimeBase::NonUniform { times_s: times_s.clone() },
        };
        let noisy = y.iter().enumerate().map(|(k, y)| y + 0.01 * (1e4 * (k as f64).sin()).fract()).collect();
        let data = InputOutput::new("record", time, u.clone(), noisy)?;
        let campaign = [CampaignRecord { data, role: Some(RecordRole::Dynamic) }];
        let objective = JointObjective::new(&campaign, options, false)?;
        let mut x = objective.starts().first().cloned().ok_or("no start")?;
        if !known.is_empty() {
            let known = known.iter().chain(&[DELAY_S]);
            x.iter_mut().zip(known).for_each(|(x, known)| *x = *known);
        }
        Ok(Self { times_s: uneven, u, objective, x, shortest: [f64::INFINITY; 2] })
    }

    /// Does both once.
    fn run(&mut self, model: &Model) -> Outcome<()> {
        let begin = Instant::now();
        black_box(simulate(model, &self.u, self.times_s.as_deref())?);
        let simulated = begin.elapsed().as_secs_f64();
        let count = self.objective.residual_count();
        let mut workspace = self.objective.workspace();
        let (mut residuals, mut jacobian) = (vec![0.0; count], vec![0.0; count * self.x.len()]);
        // Memory is touched and spectra are planned before the time counts.
        for again in [false, true] {
            // A point where nothing has been worked out yet.
            self.x[0] *= 1.0 + 1e-12;
            let begin = Instant::now();
            let feasible = self.objective.residuals(&self.x, &mut workspace, &mut residuals);
            let written = self.objective.jacobian(&self.x, &mut workspace, &mut jacobian);
            if !feasible || written != Derivative::Written {
                return Err("the joint objective cannot be evaluated".into());
            }
            if again {
                self.shortest[1] = self.shortest[1].min(begin.elapsed().as_secs_f64());
            }
        }
        self.shortest[0] = self.shortest[0].min(simulated);
        Ok(())
    }
}

fn simulate(model: &Model, u: &[f64], times_s: Option<&[f64]>) -> Outcome<Vec<f64>> {
    let timing = times_s.map_or(Timing::Rate(RATE_HZ), Timing::Stamps);
    Ok(model.simulate(u, timing, &Start::Rest { voltage_v: u[0] })?)
}

fn compare(frequency_hz: f64, repetitions: usize) -> Outcome<Vec<Vec<String>>> {
    let mut rows = Vec::new();
    for (family, form, hysteresis) in operators()? {
        for (name, choice, dynamics, known) in dynamics()? {
            let model = Model {
                hysteresis: hysteresis.clone(),
                dynamics,
                offset: 0.0,
                delay_s: DELAY_S,
                scheme: Scheme::BandLimited,
                inter_sample: InterSample::Linear,
                sample_rate_hz: None,
            };
            let options = Options {
                hysteresis: FamilyChoice::Given(form),
                dynamics: choice,
                degree: Choice::Given(DEGREE),
                scheme: Choice::Given(Scheme::BandLimited),
                inter_sample: Choice::Given(InterSample::Linear),
                initial: Initial::Zero,
                ..Options::default()
            };
            let benches = Stamps::ALL.map(|stamps| Bench::new(&model, known, &options, frequency_hz, stamps));
            let mut benches = benches.into_iter().collect::<Outcome<Vec<_>>>()?;
            // In turn, so that what else the machine does hits all alike.
            for _ in 0..repetitions {
                benches.iter_mut().try_for_each(|bench| bench.run(&model))?;
            }
            let [uniform, stamped @ ..] = benches.as_slice() else { continue };
            let mut row = vec![family.to_owned(), name.to_owned()];
            for which in [0, 1] {
                row.push(format!("{:.0}", 1e9 * uniform.shortest[which] / SAMPLES as f64));
                let ratio = |bench: &Bench| format!("{:.1}", bench.shortest[which] / uniform.shortest[which]);
                row.extend(stamped.iter().map(ratio));
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

pub fn study(repetitions: usize) -> Outcome<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    writeln!(
        stdout(),
        "{SAMPLES} samples, one thread, shortest of {repetitions}: ns per sample at one rate, and times that \
         at two rates with pauses and where every step is another one.\n"
    )?;
    let header = [
        "hysteresis",
        "dynamics",
        "simulation [ns]",
        "two rates",
        "every step",
        "with derivatives [ns]",
        "two rates",
        "every step",
    ];
    for frequency_hz in FREQUENCIES_HZ {
        let rows = pool.install(|| compare(frequency_hz, repetitions))?;
        writeln!(stdout(), "Drive of {frequency_hz} Hz, 10 kHz.\n")?;
        table::print(&header, &rows)?;
    }
    Ok(())
}
