//! Does a cold start find the global optimum? Random devices in the class, each measured and identified
//! twice: from nothing, and from the truth on. A cold fit that is no worse than the other has reached the
//! global optimum.

use std::io::{Write, stdout};
use std::time::Instant;

use hysteron_identify::{Identification, Watch, identify};
use hysteron_rig::excitation::Excitation;
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{NOISE_UM, cold, from_truth, play, slow_loop, sweep};
use crate::device::Device;
use crate::table;

/// A cost counts as the same up to this share.
pub const SAME: f64 = 1e-6;

/// How a cold fit compares with the one from the truth.
struct Trial {
    seed: u64,
    /// Cost over the cost from the truth, less 1; or why there is no fit.
    excess: Result<f64, String>,
    /// Starts followed to their end.
    starts: usize,
    seconds: f64,
    device: Device,
}

impl Trial {
    fn run(seed: u64, drives: &[Excitation]) -> Outcome<Self> {
        let device = Device::random(seed)?;
        let records = play(&device.bench(NOISE_UM)?, drives, seed)?;
        let begun = Instant::now();
        let found = identify(&records, &cold(), &Watch::silent(), None);
        let seconds = begun.elapsed().as_secs_f64();
        let reference = identify(&records, &from_truth(&device)?, &Watch::silent(), None)?;
        let starts = found.as_ref().map_or(0, |found| found.searches[0].outcome.starts.len());
        let excess = found.map_err(|error| error.to_string()).and_then(|found| excess(&found, &reference));
        Ok(Self { seed, excess, starts, seconds, device })
    }

    fn reached(&self) -> bool {
        self.excess.as_ref().is_ok_and(|excess| *excess <= SAME)
    }
}

/// Costs of the same problem, or why they are not.
fn excess(found: &Identification, reference: &Identification) -> Result<f64, String> {
    let degree = |of: &Identification| of.structure.degree;
    if degree(found) != degree(reference) {
        return Err(format!("degree {} instead of {}", degree(found), degree(reference)));
    }
    Ok(found.searches[0].outcome.cost / reference.searches[0].outcome.cost - 1.0)
}

pub fn study(devices: usize) -> Outcome<()> {
    try_all(
        "loop of 3 s at 1 kHz, sweep of 2.5 s at 5 kHz",
        &[slow_loop(1_000.0)?, sweep(5_000.0, 1.0, 100.0, 2.5)?],
        devices,
    )
}

pub fn full_size(devices: usize) -> Outcome<()> {
    try_all(
        "loop of 3 s, sweep of 10 s, at 10 kHz",
        &[slow_loop(10_000.0)?, sweep(10_000.0, 1.0, 100.0, 10.0)?],
        devices,
    )
}

fn try_all(name: &str, drives: &[Excitation], devices: usize) -> Outcome<()> {
    let trials: Vec<Trial> =
        (0..devices as u64).into_par_iter().map(|seed| Trial::run(seed, drives)).collect::<Outcome<_>>()?;
    let of = |f: &dyn Fn(&Trial) -> f64| -> Vec<f64> { trials.iter().map(f).collect() };
    let (starts, seconds) = (of(&|t| t.starts as f64), of(&|t| t.seconds));
    let excesses = trials.iter().filter_map(|t| t.excess.as_ref().ok().copied());
    let most = |values: &[f64]| values.iter().fold(0.0, |a: f64, &b| a.max(b));
    let row = vec![
        name.to_owned(),
        devices.to_string(),
        trials.iter().filter(|trial| trial.reached()).count().to_string(),
        format!("{:.1e}", excesses.fold(f64::NEG_INFINITY, f64::max)),
        format!("{:.0} / {:.0}", table::median(&starts), most(&starts)),
        format!("{:.1} / {:.1}", table::median(&seconds), most(&seconds)),
    ];
    table::print(
        &[
            "campaign",
            "devices",
            "global optimum",
            "worst excess cost",
            "starts, median / most",
            "s a fit, median / most",
        ],
        &[row],
    )?;
    let mut out = stdout().lock();
    for trial in trials.into_iter().filter(|trial| !trial.reached()) {
        let why = trial.excess.map_or_else(|why| why, |excess| format!("excess cost {excess:.2e}"));
        writeln!(out, "- device {}: {why} ({})", trial.seed, trial.device.describe())?;
    }
    Ok(())
}
