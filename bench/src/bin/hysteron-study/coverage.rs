//! Do the 95 % intervals of a joint fit hold the truth in 95 of 100 campaigns, for every parameter?
//!
//! The true records, a slow loop of nested amplitudes and a sweep, come from the simulated bench once for
//! each kind of drive (held between samples, straight, band-limited), in continuous time and through an ideal
//! sensor; each campaign adds its own noise to them, white or coloured, and is identified from the true
//! parameters on, the rule between samples from the records: the study is of the intervals, not of the
//! search.

use std::io::{Write, stdout};

use hysteron_identify::{CampaignRecord, Choice, Identification, Options, RecordRole, Watch, identify};
use hysteron_model::record::InterSample;
use rayon::prelude::*;

use crate::Outcome;
use crate::campaign::{NOISE_UM, from_truth, nested_loops, sweep, true_record, with_noise};
use crate::device::Device;

/// Quantile of the normal distribution that leaves 2.5 % above it.
pub const NORMAL_975: f64 = 1.959_963_984_540_054;

/// Coefficient c in e_k = c e_{k−1} + √(1 − c²) · white.
const NOISES: [(&str, f64); 2] = [("white", 0.0), ("coloured, autoregressive 0.9", 0.9)];

/// The records without noise, under a drive that does between its samples what `rule` says.
fn true_records(device: &Device, rule: InterSample) -> Outcome<Vec<CampaignRecord>> {
    let mut quasi_static = true_record(device, rule, 1_000.0, |rate_hz| nested_loops(rate_hz, 4.0))?;
    let mut dynamic = true_record(device, rule, 5_000.0, |rate_hz| sweep(rate_hz, 5.0, 200.0, 1.5))?;
    for (record, name, role) in
        [(&mut quasi_static, "loop", RecordRole::QuasiStatic), (&mut dynamic, "sweep", RecordRole::Dynamic)]
    {
        record.data.name = name.to_owned();
        record.role = Some(role);
    }
    Ok(vec![quasi_static, dynamic])
}

/// Estimate of one parameter by one campaign.
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

/// Campaigns under one kind of drive and one kind of noise.
struct Series {
    /// Each campaign's word on each parameter.
    said: Vec<Vec<Option<Said>>>,
    /// Campaigns whose rule between samples was found.
    recognised: usize,
}

impl Series {
    fn run(
        records: &[CampaignRecord],
        rule: InterSample,
        (memory, seed): (f64, u64),
        campaigns: usize,
        (options, values): (&Options, &[(String, f64)]),
    ) -> Outcome<Self> {
        let found: Vec<(Vec<Option<Said>>, bool)> = (0..campaigns)
            .into_par_iter()
            .map(|campaign| {
                let records = with_noise(records, memory, seed << 32 | campaign as u64);
                let found = identify(&records, options, &Watch::silent(), None)?;
                let said = values.iter().map(|(name, truth)| judge(&found, name, *truth)).collect();
                Ok((said, found.model.inter_sample == rule))
            })
            .collect::<Outcome<_>>()?;
        let recognised = found.iter().filter(|(_, recognised)| *recognised).count();
        Ok(Self { said: found.into_iter().map(|(said, _)| said).collect(), recognised })
    }

    fn print(&self, values: &[(String, f64)]) -> Outcome<()> {
        let mut out = stdout().lock();
        writeln!(
            out,
            "{:<18} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9}",
            "parameter", "interval", "1.96 s.e.", "mean err.", "its sd", "profiled", "without"
        )?;
        for (index, (name, _)) in values.iter().enumerate() {
            let said: Vec<Said> = self.said.iter().filter_map(|campaign| campaign[index]).collect();
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
                self.said.len() - said.len(),
            )?;
        }
        Ok(writeln!(out)?)
    }
}

pub fn study(campaigns: usize) -> Outcome<()> {
    let device = Device::article()?;
    let values = device.values()?;
    // The exponent is not searched here.
    let values: Vec<_> = values.into_iter().filter(|(name, _)| name != "n").collect();
    let options = Options { degree: Choice::Given(2), ..from_truth(&device)? };
    for (kind, rule) in InterSample::ALL.into_iter().enumerate() {
        let records = true_records(&device, rule)?;
        let ideal = identify(&records, &options, &Watch::silent(), None)?;
        for record in &ideal.records {
            writeln!(
                stdout(),
                "Drive {rule}: without noise the model differs from record '{}' by {:.5} µm (rms).",
                record.data.name,
                record.scores.rmse
            )?;
        }
        writeln!(stdout())?;
        for (number, (noise, memory)) in NOISES.into_iter().enumerate() {
            let seed = (2 + NOISES.len() * kind + number) as u64;
            let series = Series::run(&records, rule, (memory, seed), campaigns, (&options, &values))?;
            writeln!(
                stdout(),
                "{campaigns} campaigns, drive {rule} (recognised in {}), noise of {NOISE_UM} µm, {noise}",
                series.recognised
            )?;
            series.print(&values)?;
        }
    }
    Ok(())
}
