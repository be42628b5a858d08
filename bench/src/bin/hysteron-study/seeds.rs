//! Does the result depend on the seed of the search? One campaign, the default simulated bench, which lies
//! outside the model class; `identify` without options but the seed.

use std::io::{Write, stdout};

use hysteron_identify::{CampaignRecord, DynamicsChoice, Options, Watch, identify};
use hysteron_model::record::ChannelChoice;
use hysteron_rig::{CampaignPlan, Role, Truth, run_campaign};
use rayon::prelude::*;

use crate::Outcome;
use crate::optimum::SAME;
use crate::table;

/// The loop and the sweep of the default bench.
pub fn default_bench(plan: &CampaignPlan, seed: u64) -> Outcome<Vec<CampaignRecord>> {
    run_campaign(&Truth::default(), plan, seed)?
        .into_iter()
        .filter(|record| matches!(record.role, Role::QuasiStatic | Role::Sweep))
        .map(|record| {
            let data = record.run.record.input_output(&ChannelChoice::default())?;
            Ok(CampaignRecord { data, role: None })
        })
        .collect()
}

pub fn study(seeds: usize) -> Outcome<()> {
    let records = default_bench(&CampaignPlan { validation_hz: Vec::new(), ..CampaignPlan::default() }, 1)?;
    let mut rows = Vec::new();
    let mut lines = Vec::new();
    for (name, dynamics) in
        [("no option", DynamicsChoice::Auto), ("--dynamics fractional", DynamicsChoice::Fractional)]
    {
        let found: Vec<(f64, usize, usize)> = (0..seeds as u64)
            .into_par_iter()
            .map(|seed| {
                let options = Options { seed, dynamics, threads: Some(1), ..Options::default() };
                let found = identify(&records, &options, &Watch::silent(), None)?;
                let outcome = &found.searches[0].outcome;
                Ok((outcome.cost, outcome.starts.len(), found.structure.degree))
            })
            .collect::<Outcome<_>>()?;
        let best = found.iter().map(|found| found.0).fold(f64::INFINITY, f64::min);
        let worst = found.iter().map(|found| found.0).fold(0.0, f64::max);
        let starts: Vec<f64> = found.iter().map(|found| found.1 as f64).collect();
        rows.push(vec![
            name.to_owned(),
            seeds.to_string(),
            found.iter().filter(|found| found.0 <= best * (1.0 + SAME)).count().to_string(),
            format!("{:.1e}", worst / best - 1.0),
            format!("{:.0} / {:.0}", table::median(&starts), starts.iter().fold(0.0, |a: f64, &b| a.max(b))),
        ]);
        for (seed, (cost, starts, degree)) in found.iter().enumerate() {
            if *cost > best * (1.0 + SAME) {
                let excess = cost / best - 1.0;
                lines.push(format!(
                    "- {name}, seed {seed}: excess cost {excess:.2e}, degree {degree}, {starts} starts"
                ));
            }
        }
    }
    table::print(
        &["identify", "seeds", "best optimum", "worst excess cost", "starts, median / most"],
        &rows,
    )?;
    let mut out = stdout().lock();
    for line in lines {
        writeln!(out, "{line}")?;
    }
    Ok(())
}
