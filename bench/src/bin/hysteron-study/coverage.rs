//! Do the 95 % intervals of a joint fit hold the truth in 95 of 100 campaigns, for every parameter?
//!
//! The true records, a slow loop of nested amplitudes and a sweep, come from the simulated bench once, in continuous time
//! and through an ideal sensor; each campaign adds its own noise to them, white or coloured, and is identified from the
//! true parameters on: the study is of the intervals, not of the search.

use std::f64::consts::TAU;
use std::io::{Write, stdout};

use hysteron_identify::{CampaignRecord, Choice, Identification, Options, RecordRole, Watch, identify};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{NOISE_UM, from_truth, nested_loops, play, sweep};
use crate::device::Device;

/// Quantile of the normal distribution that leaves 2.5 % above it.
pub const NORMAL_975: f64 = 1.959_963_984_540_054;

/// Coefficient c in e_k = c e_{k−1} + √(1 − c²) · white.
const NOISES: [(&str, f64); 2] = [("white", 0.0), ("coloured, autoregressive 0.9", 0.9)];

/// The records without noise.
fn true_records(device: &Device) -> Outcome<Vec<CampaignRecord>> {
    let drives = [nested_loops(1_000.0, 4.0)?, sweep(5_000.0, 5.0, 200.0, 1.5)?];
    let mut records = play(&device.bench(0.0)?, &drives, 0)?;
    for (record, (name, role)) in
        records.iter_mut().zip([("loop", RecordRole::QuasiStatic), ("sweep", RecordRole::Dynamic)])
    {
        record.data.name = name.to_owned();
        record.role = Some(role);
    }
    Ok(records)
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

pub fn study(campaigns: usize) -> Outcome<()> {
    let device = Device::article()?;
    let values = device.values()?;
    // The exponent is not searched here.
    let values: Vec<_> = values.into_iter().filter(|(name, _)| name != "n").collect();
    let records = true_records(&device)?;
    let options = Options { degree: Choice::Given(2), ..from_truth(&device)? };
    let ideal = identify(&records, &options, &Watch::silent(), None)?;
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
                let found = identify(&with_noise(&records, memory, seed), &options, &Watch::silent(), None)?;
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
