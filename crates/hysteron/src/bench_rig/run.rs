//! One experiment on the simulated bench.

use super::plant::HysteresisState;
use super::propagation::Propagator;
use super::sensor;
use super::truth::{Dac, Truth};
use super::{RigError, RigRun};
use crate::excitation::Excitation;
use crate::record::{Channel, Record, TimeBase, Unit};

/// What the plant did, sampled at the record's rate.
struct Response {
    y_true_um: Vec<f64>,
    hysteresis_um: Vec<f64>,
}

/// Plays one waveform on the bench, which has rested at the waveform's first voltage.
///
/// `stream` numbers the record within a campaign: with the same seed, different streams have independent noise.
///
/// # Errors
/// Any [`RigError`]: a truth or a drive that makes no sense, unstable dynamics, a diverging hysteresis.
///
/// ```
/// use hysteron::bench_rig::{Truth, measure};
/// use hysteron::excitation::{ExcitationSpec, Waveform};
///
/// let drive = ExcitationSpec::new(1_000.0, 0.0, 10.0, Waveform::Sine { frequency_hz: 5.0, periods: 2.0 }).generate()?;
/// let run = measure(&Truth::default(), &drive, 1, 0)?;
/// assert_eq!(run.record.channels[1].samples.len(), 400);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(truth: &Truth, drive: &Excitation, seed: u64, stream: usize) -> Result<RigRun, RigError> {
    truth.validate()?;
    let response = respond(truth, drive)?;
    let mut rng = sensor::stream(seed, stream);
    let (y_um, clipped_samples) =
        sensor::read(&truth.sensor, &response.y_true_um, drive.sample_rate_hz, &mut rng);
    let channel =
        |name: &str, unit: &str, samples| Channel { name: name.into(), unit: Unit::new(unit), samples };
    let mut comments = vec![
        "simulated: this record was computed by the hysteron bench rig, not measured".to_owned(),
        format!("drive: {}", drive.description),
        format!("plant: {}", truth.describe()),
        format!("seed {seed}, stream {stream}"),
    ];
    if clipped_samples > 0 {
        comments.push(format!("the converter clipped {clipped_samples} samples"));
    }
    Ok(RigRun {
        record: Record {
            name: format!("simulated_{}", drive.name),
            time: TimeBase::Uniform {
                start_s: 0.0,
                sample_rate_hz: drive.sample_rate_hz,
                jitter_samples: 0.0,
            },
            channels: vec![channel("u", "V", drive.samples_v.clone()), channel("y", "um", y_um)],
            valid: None,
            source: None,
        },
        y_true_um: response.y_true_um,
        hysteresis_um: response.hysteresis_um,
        clipped_samples,
        comments,
    })
}

/// First-order amplifier, exact for a drive that is linear over each step.
struct Amplifier {
    decay: f64,
    from_start: f64,
    from_end: f64,
}

impl Amplifier {
    fn new(corner_rad_s: f64, step_s: f64) -> Self {
        // x' = ω(u − x): x₁ = e^(−z) x₀ + (1 − e^(−z) − w) u₀ + w u₁, z = ωh, w = 1 − (1 − e^(−z))/z.
        let z = corner_rad_s * step_s;
        let filled = -(-z).exp_m1();
        let from_end = if z < 1e-4 { z * (0.5 - z / 6.0) } else { 1.0 - filled / z };
        Amplifier { decay: 1.0 - filled, from_start: filled - from_end, from_end }
    }
}

fn respond(truth: &Truth, drive: &Excitation) -> Result<Response, RigError> {
    let u = &drive.samples_v;
    let fs = drive.sample_rate_hz;
    if !(fs.is_finite() && fs > 0.0) {
        return Err(RigError::Drive { what: "sample_rate_hz", value: fs, expected: "a finite rate above 0" });
    }
    if let Some(&bad) = u.iter().find(|x| !x.is_finite()) {
        return Err(RigError::Drive { what: "a sample", value: bad, expected: "finite voltages" });
    }
    let Some(&first_v) = u.first() else {
        return Err(RigError::Drive { what: "number of samples", value: 0.0, expected: "at least 1" });
    };
    let steps = truth.oversampling as usize;
    let step_s = 1.0 / (fs * steps as f64);
    let dynamics = truth.plant.dynamics(step_s)?;

    // Output k is read at grid point k·steps − delay: `whole` points back and `fraction` of a step on.
    let delay_steps = truth.delay_s() / step_s;
    let nearest = delay_steps.round();
    let whole = if (delay_steps - nearest).abs() < 1e-9 { nearest } else { delay_steps.ceil() };
    let fraction = (whole - delay_steps).max(0.0);
    let fraction = if (delay_steps - nearest).abs() < 1e-9 { 0.0 } else { fraction };
    let whole = whole as usize;

    let mut hysteresis = truth.plant.hysteresis();
    let rest_um = hysteresis.step(first_v);
    if first_v != 0.0 && !dynamics.static_gain.is_finite() {
        return Err(RigError::NoRest { drive_v: first_v });
    }
    let mut plant = Propagator::at_rest(&dynamics, step_s, fraction, rest_um);
    let at_rest_um = if rest_um == 0.0 { 0.0 } else { plant.output(rest_um, rest_um) };
    let amplifier = truth.plant.amplifier_rad_s().map(|w| Amplifier::new(w, step_s));

    let mut y_true_um = Vec::with_capacity(u.len());
    let mut hysteresis_um = Vec::with_capacity(u.len());
    // Outputs that look back before the record see the plant at rest.
    y_true_um.resize(whole.div_ceil(steps).min(u.len()), at_rest_um);
    let mut next_read = y_true_um.len() * steps - whole.min(y_true_um.len() * steps);
    let mut amplified_v = first_v;
    let mut v = rest_um;
    for (k, &u_k) in u.iter().enumerate() {
        let next_v = match truth.dac {
            Dac::Linear => u.get(k + 1).copied().unwrap_or(u_k),
            Dac::Hold => u_k,
        };
        if amplifier.is_none() {
            // A held drive jumps here; a linear one is here already.
            v = advance(&mut hysteresis, u_k, k, fs)?;
        }
        hysteresis_um.push(v);
        for j in 0..steps {
            let at = |i: usize| {
                if i == steps { next_v } else { u_k + (next_v - u_k) * (i as f64 / steps as f64) }
            };
            let drive_v = match &amplifier {
                None => at(j + 1),
                Some(a) => {
                    amplified_v = a.decay * amplified_v + a.from_start * at(j) + a.from_end * at(j + 1);
                    amplified_v
                }
            };
            let v_next = hysteresis.step(drive_v);
            if k * steps + j == next_read && y_true_um.len() < u.len() {
                y_true_um.push(plant.output(v, v_next));
                next_read += steps;
            }
            plant.advance(v, v_next);
            v = v_next;
        }
        if !v.is_finite() {
            return Err(RigError::Diverged { time_s: k as f64 / fs, drive_v: u_k });
        }
    }
    Ok(Response { y_true_um, hysteresis_um })
}

fn advance(hysteresis: &mut HysteresisState<'_>, drive_v: f64, k: usize, fs: f64) -> Result<f64, RigError> {
    let v = hysteresis.step(drive_v);
    if v.is_finite() { Ok(v) } else { Err(RigError::Diverged { time_s: k as f64 / fs, drive_v }) }
}
