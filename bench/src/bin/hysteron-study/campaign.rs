//! Records of a device on the simulated bench.

use hysteron_identify::{CampaignRecord, DynamicsChoice, Options};
use hysteron_model::record::{ChannelChoice, InputOutput, TimeBase};
use hysteron_optimize::{Algorithm, LeastSquaresOptions};
use hysteron_rig::excitation::{Excitation, ExcitationSpec, SweepLaw, Waveform};
use hysteron_rig::{Truth, measure};

use crate::Outcome;
use crate::device::{Device, HIGH_V};

/// Standard deviation of the noise \[µm\].
pub const NOISE_UM: f64 = 0.005;

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

/// A record from input and output.
pub fn record(name: &str, rate_hz: f64, u: &[f64], y: &[f64]) -> Outcome<CampaignRecord> {
    let data = InputOutput::new(name, TimeBase::uniform(rate_hz), u.to_vec(), y.to_vec())?;
    Ok(CampaignRecord { data, role: None })
}

/// What `hysteron identify --dynamics fractional` does, on one thread: the campaigns of a study run beside each other.
pub fn cold() -> Options {
    Options { dynamics: DynamicsChoice::Fractional, threads: Some(1), ..Options::default() }
}

/// The same from the true model on, without any other start.
pub fn from_truth(device: &Device) -> Outcome<Options> {
    let once = LeastSquaresOptions { starts: 1, agreement: Some(1), ..LeastSquaresOptions::default() };
    Ok(Options { algorithm: Some(Algorithm::LeastSquares(once)), start: Some(device.model()?), ..cold() })
}
