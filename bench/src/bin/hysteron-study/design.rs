//! Does a designed drive do what it promises? Devices drawn at random, each known from a short loop and a
//! short sweep; the next drive is designed for one purpose after the other. The standard errors that the
//! design predicts are compared with the scatter of the estimates over noise seeds, for the designed drive,
//! for a loop and a sweep of the same length, and for a designed drive of half the length.

use std::io::{Write, stderr, stdout};
use std::ops::ControlFlow;

use hysteron_identify::design::{Design, DesignBasis, DesignOptions, Purpose, design, quantities};
use hysteron_identify::{
    CampaignRecord, Choice, Event, FitRecords, Listener, Options, Task, Watch, fit, identify,
};
use hysteron_model::Start;
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::Maker;
use hysteron_model::record::InterSample;
use hysteron_rig::excitation::{Excitation, Waveform};
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{drive, from_truth, play, sweep, with_noise};
use crate::device::{Device, HIGH_V};
use crate::table;

const RATE_HZ: f64 = 5000.0;
/// Slew rate of the amplifier \[V/s\]: a sine of 95 Hz over the range.
const SLEW: f64 = 3000.0;
/// Length of the designed drive \[s\].
const TIME_S: f64 = 2.0;
/// Last stage of a fit.
const INTERVALS: &str = "standard errors";
/// Noise seeds of a series.
const SEEDS: u64 = 50;
/// Purposes in turn; devices of this class have no creep.
const PURPOSES: [Purpose; 4] = [Purpose::Delay, Purpose::Resonance, Purpose::MinorLoops, Purpose::Prediction];

/// A device with the records so far, without noise.
struct Bench {
    device: Device,
    options: Options,
    before: Vec<Excitation>,
}

impl Bench {
    fn new(seed: u64) -> Outcome<Self> {
        let device = Device::random(seed)?;
        let degree = Choice::Given(device.hysteresis.polynomial.len());
        // The rule of the bench between samples.
        let inter_sample = Choice::Given(InterSample::Linear);
        let options = Options { degree, n: Choice::Given(1.0), inter_sample, ..from_truth(&device)? };
        let slow = drive(RATE_HZ, Waveform::Sine { frequency_hz: 4.0, periods: 3.0 })?;
        Ok(Self { device, options, before: vec![slow, sweep(RATE_HZ, 1.0, 95.0, 1.0)?] })
    }

    /// The records of these drives without noise.
    fn records(&self, drives: &[Excitation]) -> Outcome<Vec<CampaignRecord>> {
        play(&self.device.bench(0.0)?, drives, 0)
    }

    /// The design from the records so far with noise.
    fn designed(&self, purpose: Purpose, time_s: f64, seed: u64) -> Outcome<Design> {
        let records = with_noise(&self.records(&self.before)?, 0.0, seed << 32);
        let maker = Maker { program: "hysteron-study".to_owned(), created: None, command: None };
        let task = Task::Hammerstein(Box::new(self.options.clone()));
        let fit = fit(&FitRecords::Single(records), &task, &Watch::silent(), None, &maker)?;
        let options = DesignOptions {
            range: Some([0.0, HIGH_V]),
            slew_per_s: Some(SLEW),
            sample_rate_hz: Some(RATE_HZ),
            seed,
            ..DesignOptions::new(purpose, time_s)
        };
        Ok(design(&DesignBasis::of_fit(&fit)?, &options, Listener::silent())?)
    }

    /// Standard deviation over noise seeds after the records so far and this drive: of the quantities of the
    /// purpose, or rms along `motion` of the output about its mean.
    fn scatter(
        &self,
        purpose: Purpose,
        (samples, motion, time_s): (&[f64], &[f64], f64),
        stream: u64,
    ) -> Outcome<Vec<f64>> {
        let next = Excitation::of_samples("next".to_owned(), String::new(), samples.to_vec(), RATE_HZ);
        let drives: Vec<Excitation> = self.before.iter().cloned().chain([next]).collect();
        let records = self.records(&drives)?;
        let found = (0..SEEDS)
            .into_par_iter()
            .map(|seed| {
                let records = with_noise(&records, 0.0, (stream << 32) + seed + 1);
                // The estimates are all that is needed: a stop before the intervals leaves them.
                let enough = |event: &Event<'_>| match event.stage.starts_with(INTERVALS) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                let found = identify(&records, &self.options, &Watch::new(enough), None)?;
                of_model(purpose, &found.model, motion, time_s)
            })
            .collect::<Outcome<Vec<Vec<f64>>>>()?;
        let count = found.len() as f64;
        let deviation = |k: usize| {
            let mean = found.iter().map(|f| f[k]).sum::<f64>() / count;
            (found.iter().map(|f| (f[k] - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt()
        };
        let all: Vec<f64> = (0..found.first().map_or(0, Vec::len)).map(deviation).collect();
        Ok(if motion.is_empty() { all } else { vec![table::rms(all.into_iter())] })
    }
}

/// Quantities of the purpose, or the output along the motion about its mean.
fn of_model(purpose: Purpose, model: &Model, motion: &[f64], time_s: f64) -> Outcome<Vec<f64>> {
    if motion.is_empty() {
        let found: Option<Vec<f64>> = quantities(purpose, model, time_s).into_iter().collect();
        return Ok(found.ok_or("a fit has no resonance")?);
    }
    let from_rest = Start::Rest { voltage_v: motion[0] };
    let y = model.simulate(motion, Some(RATE_HZ), &from_rest)?;
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    Ok(y.into_iter().map(|y| y - mean).collect())
}

/// Figures of one bench.
struct Figures {
    purpose: Purpose,
    /// Scatter over prediction, of each quantity: designed, usual.
    honest: [Vec<f64>; 2],
    /// Geometric mean of the errors that were seen: designed, usual, designed in half the time.
    seen: [f64; 3],
    /// Repetitions of loop and sweep for the same, as predicted.
    repetitions: Option<f64>,
}

fn bench(number: usize) -> Outcome<Figures> {
    let purpose = PURPOSES[number % PURPOSES.len()];
    let bench = Bench::new(number as u64)?;
    let seed = number as u64 + 1;
    let whole = bench.designed(purpose, TIME_S, seed)?;
    let half = bench.designed(purpose, 0.5 * TIME_S, seed)?;
    let of = |drive: &[f64], stream: u64| {
        bench.scatter(purpose, (drive, &whole.motion, TIME_S), 1000 + 10 * seed + stream)
    };
    let seen = [of(&whole.drive, 0)?, of(&whole.usual, 1)?, of(&half.drive, 2)?];
    let aims: Vec<_> = whole.expected.iter().filter(|e| e.aim).collect();
    let over = |seen: &[f64], predicted: Vec<f64>| seen.iter().zip(predicted).map(|(a, b)| a / b).collect();
    let honest = [
        over(&seen[0], aims.iter().map(|e| e.designed).collect()),
        over(&seen[1], aims.iter().map(|e| e.usual).collect()),
    ];
    let geometric =
        |errors: &Vec<f64>| (errors.iter().map(|e| e.ln()).sum::<f64>() / errors.len().max(1) as f64).exp();
    let figures = Figures {
        purpose,
        honest,
        seen: seen.each_ref().map(geometric),
        repetitions: whole.usual_repetitions,
    };
    writeln!(
        stderr(),
        "bench {number}, {}: seen/predicted {:.2?} {:.2?}, seen {}, repetitions {:.2?}",
        purpose.name(),
        figures.honest[0],
        figures.honest[1],
        figures.seen.map(|e| format!("{e:.3e}")).join(" "),
        figures.repetitions
    )?;
    Ok(figures)
}

pub fn study(benches: usize) -> Outcome<()> {
    let all: Vec<Figures> = (0..benches).map(bench).collect::<Outcome<_>>()?;
    let row = |name: &str, of: &[&Figures]| {
        let ratios =
            |which: usize| -> Vec<f64> { of.iter().flat_map(|f| f.honest[which].iter().copied()).collect() };
        let words = |ratios: &[f64]| {
            let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
            let most = ratios.iter().copied().fold(0.0, f64::max);
            format!("{:.2} ({least:.2} to {most:.2})", table::median(ratios))
        };
        let both: Vec<f64> = ratios(0).into_iter().chain(ratios(1)).collect();
        let within = both.iter().filter(|r| (r.ln()).abs() <= 1.2f64.ln()).count();
        let less: Vec<f64> = of.iter().map(|f| f.seen[1] / f.seen[0]).collect();
        let half: Vec<f64> = of.iter().map(|f| f.seen[2] / f.seen[1]).collect();
        let times: Vec<f64> = of.iter().map(|f| f.repetitions.unwrap_or(f64::INFINITY)).collect();
        vec![
            name.to_owned(),
            of.len().to_string(),
            words(&ratios(0)),
            words(&ratios(1)),
            format!("{within} of {}", both.len()),
            format!("{:.2}", table::median(&less)),
            format!("{:.2}", table::median(&half)),
            format!("{} of {}", half.iter().filter(|r| **r <= 1.0).count(), half.len()),
            format!("{:.1}", table::median(&times)),
        ]
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    for purpose in PURPOSES {
        let of: Vec<&Figures> = all.iter().filter(|f| f.purpose == purpose).collect();
        if !of.is_empty() {
            rows.push(row(purpose.name(), &of));
        }
    }
    rows.push(row("all", &all.iter().collect::<Vec<_>>()));
    table::print(
        &[
            "for",
            "benches",
            "scatter / predicted, designed",
            "scatter / predicted, usual",
            "within 20 %",
            "error usual / designed",
            "error designed in half the time / usual",
            "half the time suffices",
            "repetitions of usual, predicted",
        ],
        &rows,
    )?;
    writeln!(stdout(), "{SEEDS} noise seeds a series; devices outside the class are not in this table.")?;
    Ok(())
}
