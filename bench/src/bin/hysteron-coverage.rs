//! Coverage study: do the 95 % intervals of a joint fit hold the truth in 95 of 100 campaigns, for every parameter?
//! `hysteron-coverage [CAMPAIGNS]` (`make study`; 1000 by default).
//!
//! The true records, a slow loop of nested amplitudes and a sweep, come from the simulated bench once, in continuous time
//! and through an ideal sensor; each campaign adds its own noise to them, white or coloured, and is identified from the
//! true parameters on: the study is of the intervals, not of the search.

use std::error::Error;
use std::f64::consts::TAU;
use std::io::{Write, stderr, stdout};
use std::process::ExitCode;

use hysteron::bench_rig::{BoucWenFractional, Plant, PowerTerm, Truth, measure};
use hysteron::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron::excitation::{ExcitationSpec, SweepLaw, Waveform};
use hysteron::hammerstein::Model;
use hysteron::hysteresis::{BoucWen, Hysteresis};
use hysteron::identify::{
    CampaignRecord, Choice, DynamicsChoice, Identification, Options, RecordRole, Unwatched, identify,
};
use hysteron::optimize::{Algorithm, LeastSquaresOptions};
use hysteron::record::{InputOutput, InterSample, TimeBase};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Standard deviation of the noise \[µm\].
const NOISE_UM: f64 = 0.005;
/// Quantile of the normal distribution that leaves 2.5 % above it.
const NORMAL_975: f64 = 1.959_963_984_540_054;

/// Coefficient c in e_k = c e_{k−1} + √(1 − c²) · white.
const NOISES: [(&str, f64); 2] = [("white", 0.0), ("coloured, autoregressive 0.9", 0.9)];

/// The article's device (Table 2, Eq. 13) with the gain at zero frequency put to 1, and a delay.
fn device() -> BoucWenFractional {
    let term = |coefficient, order| PowerTerm { coefficient, order };
    BoucWenFractional {
        polynomial: vec![2.0, 0.0031],
        alpha: -1.2039,
        beta: 0.1111,
        gamma: 0.0024,
        n: 1.0,
        numerator: vec![term(5.4955e6, 0.0)],
        denominator: vec![term(5.4955e6, 0.0), term(3081.0, 1.0523), term(1.0, 2.0384)],
        delay_s: 2.3e-4,
    }
}

/// The same as a model to start from.
fn model(device: &BoucWenFractional) -> Outcome<Model> {
    let terms = |terms: &[PowerTerm]| -> Vec<Term> {
        terms.iter().map(|t| Term { coefficient: t.coefficient, order: t.order }).collect()
    };
    let g = TransferFunction { numerator: terms(&device.numerator), denominator: terms(&device.denominator) };
    Ok(Model {
        hysteresis: Hysteresis::BoucWen(BoucWen::new(
            device.polynomial.clone(),
            device.alpha,
            device.beta,
            device.gamma,
            device.n,
        )?),
        dynamics: Dynamics::Fractional(g),
        offset: 0.0,
        delay_s: device.delay_s,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    })
}

/// The true values by the names of the fit.
fn true_values(model: &Model) -> Outcome<Vec<(&'static str, f64)>> {
    let Hysteresis::BoucWen(b) = &model.hysteresis;
    let (Dynamics::Fractional(g) | Dynamics::Integer(g)) = &model.dynamics else {
        return Err("the device has a transfer function".into());
    };
    let form = g.second_order()?;
    Ok(vec![
        ("linear", b.polynomial[0]),
        ("quadratic", b.polynomial[1]),
        ("alpha", b.alpha),
        ("beta", b.beta),
        ("gamma", b.gamma),
        ("natural_frequency", form.natural_frequency_hz),
        ("damping", form.damping),
        ("order2", form.alpha2),
        ("order1", form.alpha1),
        ("b", g.numerator[0].coefficient),
        ("c0", g.denominator[0].coefficient),
        ("c1", g.denominator[1].coefficient),
        ("delay", model.delay_s),
        ("memory_1", 0.0),
        ("memory_2", 0.0),
    ])
}

/// The records without noise.
fn true_records(device: BoucWenFractional) -> Outcome<Vec<CampaignRecord>> {
    let truth = Truth { plant: Plant::BoucWenFractional(device), ..Truth::default() }.with_ideal_sensor();
    let nested =
        Waveform::NestedLoops { frequency_hz: 4.0, amplitudes: vec![1.0, 0.75, 0.5, 0.25], periods_each: 1 };
    let sweep = Waveform::Sweep { law: SweepLaw::Logarithmic, start_hz: 5.0, end_hz: 200.0, duration_s: 1.5 };
    [("loop", 1_000.0, nested, RecordRole::QuasiStatic), ("sweep", 5_000.0, sweep, RecordRole::Dynamic)]
        .into_iter()
        .map(|(name, rate_hz, waveform, role)| {
            let drive = ExcitationSpec::new(rate_hz, 0.0, 10.0, waveform).generate()?;
            let run = measure(&truth, &drive, 0, 0)?;
            let data =
                InputOutput::new(name, TimeBase::uniform(rate_hz), drive.samples_v.clone(), run.y_true_um)?;
            Ok(CampaignRecord { data, role: Some(role) })
        })
        .collect()
}

/// Standard normal number (Box and Muller 1958, doi:10.1214/aoms/1177706645).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
    let radius = (((rng.next_u64() >> 11) + 1) as f64 * UNIT).ln() * -2.0;
    radius.sqrt() * ((rng.next_u64() >> 11) as f64 * UNIT * TAU).cos()
}

fn with_noise(records: &[CampaignRecord], memory: f64, seed: u64) -> Vec<CampaignRecord> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut records = records.to_vec();
    for record in &mut records {
        let mut noise = normal(&mut rng);
        for y in &mut record.data.y {
            *y += NOISE_UM * noise;
            noise = memory * noise + (1.0 - memory * memory).sqrt() * normal(&mut rng);
        }
    }
    records
}

/// What one campaign said of one parameter.
#[derive(Clone, Copy)]
struct Said {
    /// (estimate − truth)/standard error.
    error: f64,
    /// The reported interval holds the truth.
    held: bool,
    profiled: bool,
}

fn judge(found: &Identification, name: &str, truth: f64) -> Option<Said> {
    let p = found.parameters.iter().find(|p| p.name == name)?;
    let interval = p.interval?;
    Some(Said {
        error: (p.value - truth) / p.std_error?,
        held: (interval.low..=interval.high).contains(&truth),
        profiled: interval.method.name() == "profile",
    })
}

fn study(campaigns: usize) -> Outcome<()> {
    let device = device();
    let model = model(&device)?;
    let values = true_values(&model)?;
    let records = true_records(device)?;
    let once = LeastSquaresOptions { starts: 1, agreement: Some(1), ..LeastSquaresOptions::default() };
    let options = Options {
        dynamics: DynamicsChoice::Fractional,
        degree: Choice::Given(2),
        algorithm: Some(Algorithm::LeastSquares(once)),
        start: Some(model),
        threads: Some(1),
        ..Options::default()
    };
    let ideal = identify(&records, &options, &mut Unwatched, None)?;
    for record in &ideal.records {
        writeln!(
            stdout(),
            "Without noise the model differs from record '{}' by {:.5} µm (rms).",
            record.data.name,
            record.scores.rmse
        )?;
    }
    writeln!(stdout())?;
    for (number, (noise, memory)) in NOISES.into_iter().enumerate() {
        let found: Vec<Vec<Option<Said>>> = (0..campaigns)
            .into_par_iter()
            .map(|campaign| {
                let seed = (2 + number as u64) << 32 | campaign as u64;
                let found = identify(&with_noise(&records, memory, seed), &options, &mut Unwatched, None)?;
                Ok(values.iter().map(|(name, truth)| judge(&found, name, *truth)).collect())
            })
            .collect::<Outcome<_>>()?;
        let mut out = stdout().lock();
        writeln!(out, "{campaigns} campaigns, noise of {NOISE_UM} µm, {noise}")?;
        writeln!(
            out,
            "{:<18} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9}",
            "parameter", "interval", "1.96 s.e.", "mean err.", "its sd", "profiled", "without"
        )?;
        for (index, (name, _)) in values.iter().enumerate() {
            let said: Vec<Said> = found.iter().filter_map(|campaign| campaign[index]).collect();
            let count = said.len().max(1) as f64;
            let share =
                |of: &dyn Fn(&Said) -> bool| 100.0 * said.iter().filter(|s| of(s)).count() as f64 / count;
            let mean = said.iter().map(|s| s.error).sum::<f64>() / count;
            let square = said.iter().map(|s| (s.error - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
            writeln!(
                out,
                "{name:<18} {:>7.1} % {:>7.1} % {mean:>9.3} {:>8.3} {:>7.1} % {:>9}",
                share(&|s| s.held),
                share(&|s| s.error.abs() <= NORMAL_975),
                square.sqrt(),
                share(&|s| s.profiled),
                campaigns - said.len(),
            )?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn main() -> ExitCode {
    let campaigns = match std::env::args().nth(1).map_or(Ok(1000), |word| word.parse::<usize>()) {
        Ok(campaigns) if campaigns > 1 => campaigns,
        _ => {
            let _ = writeln!(stderr(), "error: hysteron-coverage: expected a number of campaigns above 1");
            return ExitCode::from(2);
        }
    };
    match study(campaigns) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(stderr(), "error: hysteron-coverage: {error}");
            ExitCode::FAILURE
        }
    }
}
