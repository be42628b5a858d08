//! Does the stage follow? The default bench, which lies outside the model class, behind a converter that holds its output, is
//! identified from nested loops and a sweep; then references that nobody has measured are followed by feedforward alone.
//! Errors are of the true displacement, its mean taken off (the sensor has a zero of its own), in per cent of the reference's
//! stroke, rms, over the last three quarters.

use std::f64::consts::TAU;

use hysteron::bench_rig::{CampaignPlan, Dac, Role, Truth, measure, run_campaign};
use hysteron::excitation::Excitation;
use hysteron::hammerstein::Model;
use hysteron::hysteresis::HysteresisForm;
use hysteron::identify::{CampaignRecord, Options, Unwatched, identify};
use hysteron::invert::{Before, InverseOptions, LastRun};
use hysteron::record::{ChannelChoice, InterSample};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::Outcome;
use crate::table;

pub(crate) const RATE_HZ: f64 = 10_000.0;
pub(crate) const SAMPLES: usize = 20_000;
const CENTRE_UM: f64 = 14.0;
const AMPLITUDE_UM: f64 = 10.0;
/// Drive of the bench \[V\].
pub(crate) const RANGE_V: [f64; 2] = [0.0, 10.5];

/// Grows from rest to the full motion in 0.3 s.
pub(crate) fn reference(motion: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |k: usize| {
        let t = k as f64 / RATE_HZ;
        let grown = (t / 0.3).min(1.0);
        CENTRE_UM + AMPLITUDE_UM * grown * grown * (3.0 - 2.0 * grown) * motion(t)
    };
    (0..SAMPLES).map(at).collect()
}

/// 200 lines of one size from 0.5 to 100 Hz, phases at random, largest value 1.
pub(crate) fn random(seed: u64) -> impl Fn(f64) -> f64 {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let lines: Vec<(f64, f64)> = (1..=200).map(|k| (0.5 * f64::from(k), TAU * uniform())).collect();
    let sum = move |t: f64| lines.iter().map(|(f, phase)| (TAU * f * t + phase).sin()).sum::<f64>();
    let largest = (0..SAMPLES).map(|k| sum(k as f64 / RATE_HZ).abs()).fold(0.0, f64::max);
    move |t| sum(t) / largest
}

pub(crate) fn truth() -> Truth {
    Truth { dac: Dac::Hold, ..Truth::default() }
}

pub(crate) fn campaign(seed: u64) -> Outcome<Vec<CampaignRecord>> {
    let plan = CampaignPlan { nested_amplitudes: vec![1.0, 0.75, 0.5, 0.25], ..CampaignPlan::default() };
    run_campaign(&truth(), &plan, seed)?
        .iter()
        .filter(|played| matches!(played.role, Role::NestedLoops | Role::Sweep))
        .map(|played| {
            let data = played.run.record.input_output(&ChannelChoice::default())?;
            Ok(CampaignRecord { data, role: None })
        })
        .collect()
}

/// What the sensor reads and what is true, the bench having rested where the drive begins.
fn play(rest_v: f64, drive: &[f64], seed: u64, run: usize) -> Outcome<(Vec<f64>, Vec<f64>)> {
    const RESTED: usize = 1000;
    let rested = std::iter::repeat_n(rest_v, RESTED).chain(drive.iter().copied()).collect();
    let excitation = Excitation::of_samples("drive".into(), "drive for a reference".into(), rested, RATE_HZ);
    let run = measure(&truth(), &excitation, seed, run)?;
    let reading = run.record.channels.get(1).ok_or("a run has a reading")?;
    Ok((reading.samples[RESTED..].to_vec(), run.y_true_um[RESTED..].to_vec()))
}

fn error_percent(true_um: &[f64], reference: &[f64]) -> f64 {
    let from = SAMPLES / 4;
    let errors = || true_um.iter().zip(reference).skip(from).map(|(y, r)| y - r);
    let mean = errors().sum::<f64>() / (SAMPLES - from) as f64;
    let (low, high) =
        reference.iter().skip(from).fold((f64::MAX, f64::MIN), |(low, high), r| (low.min(*r), high.max(*r)));
    let squares = errors().map(|e| (e - mean) * (e - mean)).sum::<f64>() / (SAMPLES - from) as f64;
    100.0 * squares.sqrt() / (high - low)
}

/// u = (r − a)/b with the straight line y = a + b u through the slow loops.
fn straight(slow: &CampaignRecord) -> impl Fn(&[f64]) -> Vec<f64> {
    let (u, y) = (&slow.data.u, &slow.data.y);
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (u_mean, y_mean) = (mean(u), mean(y));
    let products: f64 = u.iter().zip(y).map(|(u, y)| (u - u_mean) * (y - y_mean)).sum();
    let squares: f64 = u.iter().map(|u| (u - u_mean) * (u - u_mean)).sum();
    let slope = products / squares;
    move |r: &[f64]| r.iter().map(|r| (u_mean + (r - y_mean) / slope).clamp(RANGE_V[0], RANGE_V[1])).collect()
}

/// Errors of the inverse, and after each of `runs` runs that are learned from.
fn followed(model: &Model, reference: &[f64], runs: usize, seed: u64) -> Outcome<Vec<f64>> {
    let before = Before::Rest { voltage_v: None, virgin_v: Some(0.0) };
    let options = InverseOptions { before, ..InverseOptions::within(RANGE_V) };
    let made = model.invert(reference, RATE_HZ, &options)?;
    let rest_v = made.rest.and_then(|start| start.voltage_v()).ok_or("a reference begins at rest")?;
    let mut drive = made.drive;
    let mut errors = Vec::new();
    for run in 0..=runs {
        let (measured, true_um) = play(rest_v, &drive, seed, run)?;
        errors.push(error_percent(&true_um, reference));
        let last = LastRun { drive: &drive, measured: &measured };
        drive = model.learn(reference, last, RATE_HZ, &options)?.drive;
    }
    Ok(errors)
}

pub fn study(seed: usize) -> Outcome<()> {
    let seed = seed as u64;
    let records = campaign(seed)?;
    let fit = |hysteresis| -> Outcome<Model> {
        let options = Options { hysteresis, inter_sample: InterSample::Hold, ..Options::default() };
        Ok(identify(&records, &options, &mut Unwatched, None)?.model)
    };
    let plays = fit(HysteresisForm::PrandtlIshlinskii { plays: 20 })?;
    let bouc_wen = fit(HysteresisForm::BoucWen)?;
    let line = straight(records.first().ok_or("a campaign has records")?);
    let sines = [1.0, 10.0, 20.0, 50.0, 100.0];
    let mut references: Vec<(String, Vec<f64>)> =
        sines.iter().map(|f| (format!("{f} Hz"), reference(|t| (TAU * f * t).sin()))).collect();
    references.push(("random 0.5–100 Hz".to_owned(), reference(random(seed))));
    let names = ["straight line", "Bouc–Wen", "20 plays", "20 plays, one run learned", "two runs"];
    let mut lines: Vec<Vec<String>> = names.iter().map(|name| vec![(*name).to_owned()]).collect();
    for (_, reference) in &references {
        let drive = line(reference);
        let (_, uncompensated) = play(drive[0], &drive, seed, 0)?;
        let mut errors = vec![error_percent(&uncompensated, reference)];
        errors.extend(followed(&bouc_wen, reference, 0, seed)?);
        errors.extend(followed(&plays, reference, 2, seed)?);
        for (line, error) in lines.iter_mut().zip(errors) {
            line.push(format!("{error:.3}"));
        }
    }
    let header: Vec<&str> = ["error, % of stroke rms"]
        .into_iter()
        .chain(references.iter().map(|(name, _)| name.as_str()))
        .collect();
    table::print(&header, &lines)
}
