//! Scores of records as a table and in sentences.

use std::collections::HashSet;
use std::path::Path;

use comfy_table::Table;
use hysteron_model::model::{BandScore, Score};
use hysteron_model::validate::{CorrelationTest, Definition, definitions};
use hysteron_report::number::significant;

use crate::advice;
use crate::console;

/// The scores shown in the table, by key.
const SHOWN: [&str; 10] = [
    "samples",
    "skipped_samples",
    "offset",
    "rmse",
    "max_abs_error",
    "rmse_percent_of_stroke",
    "max_percent_of_stroke",
    "fit_percent",
    "relative_error",
    "loop_width_error_percent",
];

/// Coverage of the record by the band, in a sentence; `None` without a band.
pub fn within_band(score: &Score) -> Option<String> {
    let BandScore { inside_percent, measurement, model, findings } = score.band.as_ref()?;
    let unit = score.unit.to_string();
    let held = format!(
        "{}: {} % of the samples lie within the 95 % band of a new measurement, ± {} {unit} at its widest (± \
         {} {unit} of it from the errors of the parameters).",
        score.record,
        significant(*inside_percent, 3),
        significant(*measurement, 3),
        significant(*model, 2)
    );
    let rests_on = findings.iter().map(advice::text);
    Some(std::iter::once(held).chain(rests_on).collect::<Vec<_>>().join(" "))
}

/// What a correction by the predicted misfit gained, in a sentence; `None` without one.
pub fn correction(score: &Score) -> Option<String> {
    score.correction_in_words().map(|words| format!("{}: {words}", score.record))
}

/// Estimated start of the record, in a sentence; `None` where nothing was estimated.
pub fn estimated_start(score: &Score) -> Option<String> {
    let (voltage_v, memory) = score.estimated_memory()?;
    let memory = memory.in_words(
        &significant(memory.value(), 4),
        &score.simulation.input_unit.to_string(),
        &score.unit.to_string(),
    );
    Some(format!(
        "{}: simulated from rest at its first input, {}, {memory}, estimated from the record.",
        score.record,
        significant(voltage_v, 4)
    ))
}

/// The scores shown, in their order.
fn values(score: &Score) -> Vec<String> {
    let Some(s) = score.outputs.first() else { return Vec::new() };
    let ratio = |x: Option<f64>, digits: usize| {
        x.map_or("-".to_owned(), |x| format!("{x:.digits$}").replace('-', "−"))
    };
    // An offset at rounding level is shown as 0.
    let offset = if s.offset.abs() < 1e-9 * s.stroke { 0.0 } else { s.offset };
    vec![
        s.samples.to_string(),
        s.skipped_samples.to_string(),
        significant(offset, 4),
        significant(s.rmse, 4),
        significant(s.max_abs_error, 4),
        ratio(s.rmse_percent_of_stroke, 3),
        ratio(s.max_percent_of_stroke, 3),
        ratio(s.fit_percent, 2),
        ratio(s.relative_error, 5),
        ratio(s.loop_width_error_percent, 3),
    ]
}

/// Result of the residual tests, in a sentence; `None` for a record too short for them.
pub fn residual_tests(score: &Score) -> Option<String> {
    let outside = |test: &CorrelationTest| {
        let CorrelationTest { outside, lags, largest, largest_lag, .. } = test;
        format!("{outside} of {lags} lags (largest {largest:.3} at lag {largest_lag})")
    };
    let scores = score.outputs.first()?;
    let own = scores.whiteness.as_ref()?;
    let input = scores.input_correlation.as_ref()?;
    Some(format!(
        "{}: the residual's autocorrelation leaves its 99 % bounds at {}, its correlation with the input at \
         {}.",
        score.record,
        outside(own),
        outside(input)
    ))
}

/// Most records with one column each in the table of a fit: it then fits a narrow terminal.
const SIDE_BY_SIDE: usize = 3;

/// Table of a fit: one column per record for a few records, one row per record for more and for several
/// outputs.
pub fn table(records: &[Score]) -> Table {
    let scored: Vec<(&str, &Score)> = records.iter().map(|score| ("", score)).collect();
    let (header, rows) = cells(&scored);
    if records.len() > SIDE_BY_SIDE || records.iter().any(|r| r.axes.is_some()) {
        return table_of_models(&scored);
    }
    let names = rows.iter().filter_map(|row| row.first().map(String::as_str));
    let mut table = console::table(&std::iter::once("score").chain(names).collect::<Vec<_>>());
    for (metric, name) in header.iter().enumerate().skip(1) {
        table.add_row(std::iter::once(name.clone()).chain(rows.iter().map(|row| row[metric].clone())));
    }
    table
}

/// Table with one row per record and model, grouped by record, and a column of model names if there are
/// several.
pub fn table_of_models(scored: &[(&str, &Score)]) -> Table {
    if scored.iter().any(|(_, score)| score.axes.is_some()) {
        return axes_table(scored);
    }
    let (header, rows) = cells(scored);
    let mut table = console::table(&header.iter().map(String::as_str).collect::<Vec<_>>());
    rows.into_iter().for_each(|row| {
        table.add_row(row);
    });
    table
}

/// Column names, and one row per record and model: record, model where there are several, scores.
fn cells(scored: &[(&str, &Score)]) -> (Vec<String>, Vec<Vec<String>>) {
    let records: Vec<&Score> = scored.iter().map(|(_, score)| *score).collect();
    let one_unit = records.windows(2).all(|pair| pair[0].unit == pair[1].unit);
    let unit = records.first().map(|r| r.unit.to_string()).filter(|unit| one_unit && !unit.is_empty());
    let metrics = shown().map(|d| match (d.unit, &unit) {
        ("output", unit) => console::in_unit(d.name, unit.as_deref().unwrap_or("")),
        ("1", _) => d.name.to_owned(),
        (unit, _) => console::in_unit(d.name, unit),
    });
    let several = several_models(scored);
    let mut header = vec!["record".to_owned()];
    header.extend(several.then(|| "model".to_owned()));
    header.extend(metrics);
    header.extend((!one_unit).then(|| "unit".to_owned()));
    let names = short_names(records.iter().map(|r| r.record.clone()).collect());
    let row = |k: usize| {
        let (model, score) = scored[k];
        let mut row = vec![names[k].clone()];
        row.extend(several.then(|| model.to_owned()));
        row.extend(values(score));
        row.extend((!one_unit).then(|| score.unit.to_string()));
        row
    };
    let rows = by_record(&records).into_iter().map(row).collect();
    (header, rows)
}

fn several_models(scored: &[(&str, &Score)]) -> bool {
    scored.windows(2).any(|pair| pair[0].0 != pair[1].0)
}

/// Indices of the scores grouped by record, records in the order of first appearance.
fn by_record(records: &[&Score]) -> Vec<usize> {
    let first = |k: usize| records.iter().position(|r| r.record == records[k].record);
    let mut places: Vec<usize> = (0..records.len()).collect();
    places.sort_by_key(|&k| first(k));
    places
}

/// Table of records with several outputs, one row per record and model.
fn axes_table(scored: &[(&str, &Score)]) -> Table {
    let records: Vec<&Score> = scored.iter().map(|(_, score)| *score).collect();
    let several = several_models(scored);
    let unit = records.first().map_or_else(String::new, |r| r.unit.to_string());
    let in_unit = |name: &str| console::in_unit(name, &unit);
    let mut header = vec!["record".to_owned()];
    header.extend(several.then(|| "model".to_owned()));
    header.extend([
        "level".to_owned(),
        in_unit("RMSE"),
        in_unit("of mean period"),
        in_unit("max error"),
        "fit [%]".to_owned(),
    ]);
    if let Some(axes) = records.first().and_then(|first| first.axes.as_ref()) {
        header.extend(axes.outputs.iter().map(|name| in_unit(&format!("RMSE {name}"))));
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = console::table(&header);
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 4));
    let names = short_names(records.iter().map(|r| r.record.clone()).collect());
    for k in by_record(&records) {
        let (model, r) = scored[k];
        let axes = r.axes.as_ref();
        let mut row = vec![names[k].clone()];
        row.extend(several.then(|| model.to_owned()));
        row.extend([
            number(axes.and_then(|a| a.level)),
            number(Some(r.rmse)),
            number(axes.and_then(|a| a.mean_period_rmse)),
            number(Some(r.max_abs_error)),
            number(r.fit_percent),
        ]);
        row.extend(r.outputs.iter().map(|s| number(Some(s.rmse))));
        table.add_row(row);
    }
    table
}

/// The score from the start that the model file assumes, in a sentence; `None` where the record was simulated
/// from it.
pub fn without_estimated_start(score: &Score) -> Option<String> {
    let without = score.without_estimated_start.as_ref()?;
    Some(without_help(score, without.rmse, without.max_abs_error))
}

/// [`without_estimated_start`] of a run, whose start is estimated from its first record.
pub fn run_without_estimated_start(without: &Score) -> String {
    without_help(without, without.rmse, without.max_abs_error) + "\n"
}

fn without_help(score: &Score, rmse: f64, max_abs_error: f64) -> String {
    let unit = score.unit.to_string();
    format!(
        "{}: from the start that the model file assumes, without the one estimated from the record: {} {}, \
         {} {}.",
        score.record,
        console::in_unit("RMSE", &unit),
        significant(rmse, 4),
        console::in_unit("max error", &unit),
        significant(max_abs_error, 4),
    )
}

/// Verdict on device and range, in a sentence; `None` where the model file lacks the scores of its training.
pub fn verdict(score: &Score) -> Option<String> {
    let verdict = score.verdict.as_ref()?;
    Some(format!("{}: {}: {}.", score.record, verdict.judgement.name(), verdict.why))
}

/// Explanation of the scores of several outputs.
pub const AXES_EXPLANATION: &str = "RMSE: root mean square of y − simulation − offset over all outputs, the \
    offset of each sensor estimated unless --fixed-offset is given; of mean period: the same of the average \
    over the record's periods, which reduces noise; level: rms of the inputs.";

/// File names if they are unique, else the paths as given.
pub fn short_names(paths: Vec<String>) -> Vec<String> {
    let short =
        paths.iter().map(|path| Path::new(path).file_name().and_then(|name| name.to_str()).unwrap_or(path));
    let short: Vec<String> = short.map(str::to_owned).collect();
    let count = |names: &[String]| names.iter().collect::<HashSet<_>>().len();
    if count(&short) == count(&paths) { short } else { paths }
}

/// Definitions of the scores in the table, one per line.
pub fn explanation() -> String {
    let line = |d: &Definition| {
        format!("{} [{}]: {}\n", d.name, if d.unit == "output" { "unit" } else { d.unit }, d.meaning)
    };
    shown().map(line).collect()
}

fn shown() -> impl Iterator<Item = &'static Definition> {
    SHOWN.iter().filter_map(|key| definitions().iter().find(|d| d.key == *key))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use hysteron_model::Start;
    use hysteron_model::model::Simulation;
    use hysteron_model::record::{InputOutput, Source, TimeBase, Unit};
    use hysteron_model::validate::{Scoring, score};

    fn scored(path: &str) -> Score {
        let (u, y) = (vec![0.0, 1.0, 2.0, 1.0, 0.0], vec![0.0, 2.0, 5.0, 3.0, 0.5]);
        let mut data = InputOutput::new("r", TimeBase::uniform(10.0), u, y).unwrap();
        let scores = score(&data, &[0.0, 2.1, 4.8, 3.0, 0.5], &Scoring::default()).unwrap();
        data.source = Some(Source { path: path.into(), sha256: String::new() });
        let simulation =
            Simulation::of_single(vec![0.0, 2.1, 4.8, 3.0, 0.5], Start::AsIdentified, Unit::new("V"));
        Score::of_single(&data, data.y_unit.clone(), scores, simulation)
    }

    #[test]
    fn a_record_has_a_row_whatever_their_number_and_the_models_of_a_record_stand_together() {
        let (x, y) = (scored("a/x.csv"), scored("b/y.csv"));
        let one = table_of_models(&[("", &x)]).to_string();
        let two = table_of_models(&[("", &x), ("", &y)]).to_string();
        let (one, two): (Vec<_>, Vec<_>) = (one.lines().collect(), two.lines().collect());
        assert_eq!((one[0], one.len(), two.len()), (two[0], 3, 4));
        assert!(one[0].contains("RMSE [µm]") && one[2].starts_with("| x.csv "), "{one:?}");
        let models = table_of_models(&[("m", &x), ("m", &y), ("n", &x), ("n", &y)]).to_string();
        let begins: Vec<String> =
            models.lines().skip(2).map(|line| line.split('|').take(3).collect::<Vec<_>>().join("")).collect();
        assert!(begins[1].contains("x.csv") && begins[1].contains('n'), "{models}");
        assert_eq!(begins.len(), 4);
    }

    #[test]
    fn a_few_records_of_a_fit_stand_side_by_side_and_many_in_rows() {
        let text = table(&[scored("a/x.csv"), scored("b/y.csv")]).to_string();
        assert!(text.starts_with("| score "), "{text}");
        assert!(text.contains("RMSE [µm]") && text.contains("x.csv") && !text.contains("a/x.csv"), "{text}");
        let many: Vec<Score> = ["p.csv", "q.csv", "r.csv", "s.csv"].iter().map(|p| scored(p)).collect();
        let text = table(&many).to_string();
        assert!(text.starts_with("| record "), "{text}");
        assert_eq!(text.lines().count(), 6, "{text}");
    }

    #[test]
    fn records_of_one_name_are_told_apart_by_their_folders() {
        let text = table(&[scored("a/x.csv"), scored("b/x.csv")]).to_string();
        assert!(text.contains("a/x.csv") && text.contains("b/x.csv"), "{text}");
    }

    #[test]
    fn records_of_different_units_name_them_in_a_row() {
        let text =
            table(&[scored("x.csv"), Score { unit: Unit::new("urad"), ..scored("y.csv") }]).to_string();
        assert!(!text.contains("RMSE [µm]") && text.contains(" unit ") && text.contains("µrad"), "{text}");
    }
}
