//! Is a level right at which nothing was measured? The bench of three axes with records at 0.5, 1 and 2 V, with
//! other phases and noise in every campaign: modes identified from the outer levels and from all three, both
//! scored on the record of every level that is held out.

use hysteron_identify::modes::Options;
use hysteron_identify::{FitRecords, Task, Watch, fit};
use hysteron_model::axes::AxesRecord;
use hysteron_model::model::Signals;
use hysteron_model::model_file::Maker;
use hysteron_model::validate::Scoring;
use hysteron_model::{Model, Start};
use hysteron_rig::axes::{AxesPlan, AxesRole, AxesRun, AxesTruth, run_axes_campaign};

use crate::Outcome;
use crate::table;

const AXES: usize = 3;

fn record(run: &AxesRun) -> Outcome<AxesRecord> {
    let names = |prefix: char| (1..=AXES).map(|k| format!("{prefix}{k}")).collect::<Vec<String>>();
    Ok(AxesRecord::new(&run.record, &names('u'), &names('y'))?)
}

/// rms error over the outputs of the mean period \[µm\].
fn error_on(held_out: &AxesRecord, model: &Model) -> Outcome<f64> {
    let signals = Signals::Several(held_out.clone());
    let score = model.score(&signals, Start::AsIdentified, &Scoring::default())?;
    score.axes.and_then(|axes| axes.mean_period_rmse).ok_or_else(|| "a record that does not repeat".into())
}

pub fn study(campaigns: usize) -> Outcome<()> {
    let truth = AxesTruth::with_axes(AXES)?;
    let plan = AxesPlan::default();
    let maker = Maker { program: "hysteron-study".to_owned(), created: None, command: None };
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
        let outer = FitRecords::Several([&trained[..AXES], &trained[2 * AXES..]].concat());
        let trained = FitRecords::Several(trained);
        for (options, ratios) in settings.iter().zip(&mut ratios) {
            let errors = |records: &FitRecords| -> Outcome<Vec<f64>> {
                let task = Task::Modes(options.clone());
                let model = fit(records, &task, &Watch::silent(), None, &maker)?.model;
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
