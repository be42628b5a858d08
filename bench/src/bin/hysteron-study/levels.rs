//! Is a level right at which nothing was measured? The bench of three axes with records at 0.5, 1 and 2 V, with
//! other phases and noise in every campaign: modes identified from the outer levels and from all three, both
//! scored on the record of every level that is held out.

use hysteron_identify::Watch;
use hysteron_identify::modes::{Options, identify};
use hysteron_model::axes::{AxesRecord, AxesScores, ScheduledModes, SteadyPeriod};
use hysteron_model::validate::Scoring;
use hysteron_rig::axes::{AxesPlan, AxesRole, AxesRun, AxesTruth, run_axes_campaign};

use crate::Outcome;
use crate::table;

const AXES: usize = 3;

fn record(run: &AxesRun) -> Outcome<AxesRecord> {
    let names = |prefix: char| (1..=AXES).map(|k| format!("{prefix}{k}")).collect::<Vec<String>>();
    Ok(AxesRecord::new(&run.record, &names('u'), &names('y'))?)
}

/// rms error over the outputs of the mean period \[µm\].
fn error_on(held_out: &AxesRecord, model: &ScheduledModes) -> Outcome<f64> {
    let steady = SteadyPeriod::find(held_out, false)?;
    let one = model.simulate_period(&steady.u)?;
    let samples = held_out.y.first().map_or(0, Vec::len);
    let simulated: Vec<Vec<f64>> = (0..AXES)
        .map(|output| one.iter().skip(output).step_by(AXES).copied().cycle().take(samples).collect())
        .collect();
    let scores = AxesScores::new(held_out, &simulated, &Scoring::default(), Some(&steady))?;
    scores.mean_period_rmse.ok_or_else(|| "a record that does not repeat".into())
}

pub fn study(campaigns: usize) -> Outcome<()> {
    let truth = AxesTruth::with_axes(AXES)?;
    let plan = AxesPlan::default();
    let mut header = vec!["campaign".to_owned(), "iterations".into()];
    header.extend(plan.levels_v.iter().map(|level| format!("{level} V: without, with 1 V [nm]")));
    header.push("1 V: without over with".into());
    let settings = [Options::default(), Options { iterations: 30, ..Options::default() }];
    let (mut rows, mut ratios) = (Vec::new(), vec![Vec::new(); settings.len()]);
    for number in 1..=campaigns {
        let runs = run_axes_campaign(&truth, &plan, number as u64)?;
        let of = |role: AxesRole| -> Outcome<Vec<AxesRecord>> {
            runs.iter().filter(|run| run.role == role).map(record).collect()
        };
        let (trained, held_out) = (of(AxesRole::Identification)?, of(AxesRole::Validation)?);
        let outer = [&trained[..AXES], &trained[2 * AXES..]].concat();
        for (options, ratios) in settings.iter().zip(&mut ratios) {
            let errors = |records: &[AxesRecord]| -> Outcome<Vec<f64>> {
                let model = identify(records, options, &Watch::silent(), None)?.model;
                held_out.iter().map(|record| error_on(record, &model)).collect()
            };
            let (without, with) = (errors(&outer)?, errors(&trained)?);
            let mut row = vec![number.to_string(), options.iterations.to_string()];
            row.extend(without.iter().zip(&with).map(|(a, b)| format!("{:.1}, {:.1}", 1e3 * a, 1e3 * b)));
            ratios.push(without[1] / with[1]);
            row.push(format!("{:.2}", without[1] / with[1]));
            rows.push(row);
        }
    }
    for (options, ratios) in settings.iter().zip(&ratios) {
        let mut row = vec!["median".to_owned(), options.iterations.to_string()];
        row.extend(plan.levels_v.iter().map(|_| String::new()));
        row.push(format!("{:.2}", table::median(ratios)));
        rows.push(row);
    }
    table::print(&header.iter().map(String::as_str).collect::<Vec<_>>(), &rows)
}
