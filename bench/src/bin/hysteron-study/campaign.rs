//! Records of a device on the simulated bench.

use std::f64::consts::TAU;

use hysteron_identify::{CampaignRecord, DynamicsChoice, Options};
use hysteron_model::record::{ChannelChoice, InputOutput, InterSample, TimeBase};
use hysteron_optimize::{Algorithm, LeastSquaresOptions};
use hysteron_rig::excitation::{Excitation, ExcitationSpec, SweepLaw, Waveform};
use hysteron_rig::{Dac, Truth, measure};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::Outcome;
use crate::device::{Device, HIGH_V};

/// Standard deviation of the noise \[µm\].
pub const NOISE_UM: f64 = 0.005;

/// Points a sample of a band-limited drive, joined by straight lines: at 20 samples a cycle these leave 2e-5
/// of it out.
const FINER: usize = 20;

/// A drive from 0 V to [`HIGH_V`].
pub fn drive(rate_hz: f64, waveform: Waveform) -> Outcome<Excitation> {
    Ok(ExcitationSpec::new(rate_hz, 0.0, HIGH_V, waveform).generate()?)
}

/// A loop at 1 Hz, three periods from rest.
pub fn slow_loop(rate_hz: f64) -> Outcome<Excitation> {
    drive(rate_hz, Waveform::Sine { frequency_hz: 1.0, periods: 3.0 })
}

/// Loops of four amplitudes.
pub fn nested_loops(rate_hz: f64, frequency_hz: f64) -> Outcome<Excitation> {
    let amplitudes = vec![1.0, 0.75, 0.5, 0.25];
    drive(rate_hz, Waveform::NestedLoops { frequency_hz, amplitudes, periods_each: 1 })
}

/// A sweep.
pub fn sweep(rate_hz: f64, start_hz: f64, end_hz: f64, duration_s: f64) -> Outcome<Excitation> {
    drive(rate_hz, Waveform::Sweep { law: SweepLaw::Logarithmic, start_hz, end_hz, duration_s })
}

/// A random reference up to 100 Hz, eased into from 0 V.
pub fn random_reference(rate_hz: f64, duration_s: f64, seed: u64) -> Outcome<Excitation> {
    let waveform = Waveform::Random { low_hz: 0.0, high_hz: 100.0, duration_s };
    let spec =
        ExcitationSpec { soft_start_s: 0.2, seed, ..ExcitationSpec::new(rate_hz, 0.0, HIGH_V, waveform) };
    Ok(spec.generate()?)
}

/// The records that the bench answers to the drives, noise numbered by `seed`.
pub fn play(truth: &Truth, drives: &[Excitation], seed: u64) -> Outcome<Vec<CampaignRecord>> {
    drives
        .iter()
        .enumerate()
        .map(|(stream, drive)| {
            let run = measure(truth, drive, seed, stream)?;
            Ok(CampaignRecord { data: run.record.input_output(&ChannelChoice::default())?, role: None })
        })
        .collect()
}

/// The record without noise of a drive that does between its samples what `rule` says. `drive` makes the
/// drive at a rate.
pub fn true_record(
    device: &Device,
    rule: InterSample,
    rate_hz: f64,
    drive: impl Fn(f64) -> Outcome<Excitation>,
) -> Outcome<CampaignRecord> {
    let (dac, finer) = match rule {
        InterSample::Hold => (Dac::Hold, 1),
        InterSample::Linear => (Dac::Linear, 1),
        InterSample::BandLimited => (Dac::Linear, FINER),
    };
    let truth = Truth { dac, ..device.bench(0.0)? };
    let run = measure(&truth, &drive(rate_hz * finer as f64)?, 0, 0)?;
    let mut data = run.record.input_output(&ChannelChoice::default())?;
    let samples = |x: &[f64]| x.iter().step_by(finer).copied().collect();
    (data.u, data.y) = (samples(&data.u), samples(&data.y));
    data.time = TimeBase::uniform(rate_hz);
    Ok(CampaignRecord { data, role: None })
}

/// Standard normal number (Box and Muller 1958, doi:10.1214/aoms/1177706645).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
    let radius = (((rng.next_u64() >> 11) + 1) as f64 * UNIT).ln() * -2.0;
    radius.sqrt() * ((rng.next_u64() >> 11) as f64 * UNIT * TAU).cos()
}

/// The records with noise e_k = `memory` e_{k−1} + √(1 − `memory`²) · white, of standard deviation
/// [`NOISE_UM`].
pub fn with_noise(records: &[CampaignRecord], memory: f64, seed: u64) -> Vec<CampaignRecord> {
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

/// A record from input and output.
pub fn record(name: &str, rate_hz: f64, u: &[f64], y: &[f64]) -> Outcome<CampaignRecord> {
    let data = InputOutput::new(name, TimeBase::uniform(rate_hz), u.to_vec(), y.to_vec())?;
    Ok(CampaignRecord { data, role: None })
}

/// What `hysteron identify --dynamics fractional` does, on one thread: the campaigns of a study run beside
/// each other.
pub fn cold() -> Options {
    Options { dynamics: DynamicsChoice::Fractional, threads: Some(1), ..Options::default() }
}

/// The same from the true model on, without any other start.
pub fn from_truth(device: &Device) -> Outcome<Options> {
    let once = LeastSquaresOptions { starts: 1, agreement: Some(1), ..LeastSquaresOptions::default() };
    Ok(Options { algorithm: Some(Algorithm::LeastSquares(once)), start: Some(device.model()?), ..cold() })
}
