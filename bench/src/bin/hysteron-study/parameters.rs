//! How well are devices of the class recovered? Parameters in standard errors, and the model's error on a
//! record that no fit has seen against the truth without noise.

use std::time::Instant;

use hysteron_identify::{Choice, Options, Watch, identify};
use hysteron_model::Start;
use hysteron_model::dynamics::SecondOrder;
use hysteron_model::hysteresis::BoucWen;
use hysteron_rig::excitation::Excitation;
use hysteron_rig::measure;
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{NOISE_UM, cold, nested_loops, play, random_reference, sweep};
use crate::device::Device;
use crate::table;

/// Standard errors within which 99.7 % of normal estimates lie.
const WITHIN: f64 = 3.0;

/// A device by its numbers: polynomial; α, β, γ, n; natural frequency, damping, orders; delay.
fn device(l: &[f64], [alpha, beta, gamma, n]: [f64; 4], g: [f64; 4], delay_s: f64) -> Outcome<Device> {
    let [natural_frequency_hz, damping, alpha2, alpha1] = g;
    Ok(Device {
        hysteresis: BoucWen::new(l.to_vec(), alpha, beta, gamma, n)?,
        dynamics: SecondOrder { gain: 1.0, natural_frequency_hz, damping, alpha2, alpha1, alpha0: 0.0 },
        delay_s,
    })
}

/// Devices unlike each other; the exponent of the last one is not 1 and is searched (`--n free`).
fn devices() -> Outcome<Vec<(&'static str, Device)>> {
    Ok(vec![
        ("the article's, delay 0.23 ms", Device::article()?),
        (
            "stiff, lightly damped",
            device(&[3.2, -0.02], [0.9, 0.35, 0.1, 1.0], [900.0, 0.03, 2.0, 1.0], 1e-4)?,
        ),
        ("soft, well damped", device(&[3.0], [0.8, 0.6, -0.2, 1.0], [150.0, 0.7, 1.9, 0.9], 3e-4)?),
        (
            "wide loop, bent",
            device(&[2.5, 0.06, -0.003], [1.2, 0.25, 0.1, 1.0], [400.0, 0.2, 1.95, 0.8], 0.0)?,
        ),
        ("narrow loop", device(&[1.5, 0.01], [0.15, 0.5, 0.3, 1.0], [300.0, 0.1, 2.05, 1.1], 2e-4)?),
        ("exponent 1.6, free", device(&[3.0, 0.02], [0.9, 0.3, 0.1, 1.6], [450.0, 0.1, 2.0, 1.0], 2e-4)?),
    ])
}

/// Estimates of one campaign.
struct Trial {
    /// (estimate − truth)/standard error by name.
    errors: Vec<(String, f64)>,
    /// Model minus truth on the unseen record, rms \[µm\].
    unseen_um: f64,
    degree_is_right: bool,
    seconds: f64,
}

impl Trial {
    fn run(device: &Device, drives: &[Excitation], unseen: &Excitation, seed: u64) -> Outcome<Self> {
        let truth = device.bench(NOISE_UM)?;
        let records = play(&truth, drives, seed)?;
        let n = if device.hysteresis.n == 1.0 { Choice::Given(1.0) } else { Choice::Auto };
        let begun = Instant::now();
        let found = identify(&records, &Options { n, ..cold() }, &Watch::silent(), None)?;
        let seconds = begun.elapsed().as_secs_f64();
        let mut errors = Vec::new();
        for (name, value) in device.values()? {
            let parameter = found.parameters.iter().find(|p| p.name == name);
            if let Some((p, std_error)) = parameter.and_then(|p| Some((p, p.std_error?))) {
                errors.push((name, (p.value - value) / std_error));
            }
        }
        let y = measure(&truth, unseen, 0, 0)?.y_true_um;
        let from_rest = Start::Rest { voltage_v: unseen.samples_v[0] };
        let simulated = found.model.simulate(&unseen.samples_v, Some(unseen.sample_rate_hz), &from_rest)?;
        Ok(Self {
            errors,
            unseen_um: table::rms(simulated.iter().zip(&y).map(|(a, b)| a - b)),
            degree_is_right: found.structure.degree == device.hysteresis.polynomial.len(),
            seconds,
        })
    }
}

pub fn study(campaigns: usize) -> Outcome<()> {
    let drives = [nested_loops(5_000.0, 4.0)?, sweep(10_000.0, 1.0, 200.0, 2.5)?];
    let unseen = random_reference(10_000.0, 2.0, 1)?;
    let mut rows = Vec::new();
    for (name, device) in devices()? {
        let trials: Vec<Trial> = (0..campaigns as u64)
            .into_par_iter()
            .map(|seed| Trial::run(&device, &drives, &unseen, seed))
            .collect::<Outcome<_>>()?;
        let errors: Vec<&(String, f64)> = trials.iter().flat_map(|trial| &trial.errors).collect();
        let within = errors.iter().filter(|(_, error)| error.abs() <= WITHIN).count();
        let furthest = errors.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let unseen: Vec<f64> = trials.iter().map(|t| 100.0 * t.unseen_um / NOISE_UM).collect();
        rows.push(vec![
            name.to_owned(),
            campaigns.to_string(),
            errors.len().to_string(),
            format!("{:.2}", 100.0 * within as f64 / errors.len() as f64),
            furthest.map_or(String::new(), |(name, error)| format!("{error:.1} ({name})")),
            format!("{:.1}", table::rms(errors.iter().map(|(_, error)| *error))),
            format!("{:.1} / {:.1}", table::median(&unseen), unseen.iter().fold(0.0, |a: f64, &b| a.max(b))),
            trials.iter().filter(|trial| trial.degree_is_right).count().to_string(),
            format!("{:.1}", table::median(&trials.iter().map(|t| t.seconds).collect::<Vec<_>>())),
        ]);
    }
    table::print(
        &[
            "device",
            "campaigns",
            "estimates",
            "within 3 s.e. [%]",
            "furthest [s.e.]",
            "rms [s.e.]",
            "unseen record, error / noise [%], median / worst",
            "degree right",
            "s a fit",
        ],
        &rows,
    )
}
