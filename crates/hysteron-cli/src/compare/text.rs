//! The comparison for people.

use hysteron_identify::structure::{Comparison, Entry, Standing};
use hysteron_report::number::significant;

use super::{Found, baselines};
use crate::console;

/// One row: candidate, parameters, error on left-out data ± its standard error, difference to the best ± its standard
/// error, training error, AIC and BIC above their lowest, time of a sample, whether its hysteresis has an inverse.
pub fn cells(found: &Found, index: usize) -> [String; 9] {
    let comparison = &found.comparison;
    let costs = found.costs.get(index);
    let entry = &comparison.entries[index];
    let missing = || "-".to_owned();
    let standing = standing(comparison, index);
    [
        entry.candidate.to_string(),
        entry.parameters.to_string(),
        standing.map_or_else(missing, |s| with_error(s.mean, s.std_error)),
        standing.map_or_else(missing, |s| match s.difference {
            0.0 => "best".to_owned(),
            difference => with_error(difference, s.difference_std_error),
        }),
        entry.training_rmse.map_or_else(missing, |x| significant(x, 3)),
        above(comparison, entry, |e| e.aic),
        above(comparison, entry, |e| e.bic),
        costs.and_then(|c| c.cost).map_or_else(missing, |c| significant(c.nanoseconds, 2)),
        costs.and_then(|c| c.inverse).map_or_else(missing, |inverse| inverse.word().to_owned()),
    ]
}

pub fn header(unit: &str) -> [String; 9] {
    let error = |what: &str| console::in_unit(what, unit);
    [
        "structure".into(),
        "parameters".into(),
        error("error on unseen data"),
        error("above the best"),
        error("training RMSE"),
        "AIC".into(),
        "BIC".into(),
        "ns a sample".into(),
        "inverse".into(),
    ]
}

/// Candidates in the order of the ranking, those without a place at the end.
pub fn order(comparison: &Comparison) -> Vec<usize> {
    let mut order = comparison.ranking.as_ref().map_or(Vec::new(), |r| r.order.clone());
    order.extend((0..comparison.entries.len()).filter(|&i| standing(comparison, i).is_none()));
    order
}

pub fn standing(comparison: &Comparison, index: usize) -> Option<Standing> {
    comparison.ranking.as_ref().and_then(|r| r.standings[index])
}

pub fn with_error(value: f64, error: f64) -> String {
    format!("{} ± {}", significant(value, 3), significant(error, 2))
}

fn above(comparison: &Comparison, entry: &Entry, of: impl Fn(&Entry) -> Option<f64>) -> String {
    let lowest = comparison.entries.iter().filter_map(&of).fold(f64::INFINITY, f64::min);
    of(entry).map_or_else(|| "-".to_owned(), |x| format!("{:.0}", x - lowest))
}

/// Which structure, and why, in plain words.
pub fn verdict(found: &Found) -> Vec<String> {
    let comparison = &found.comparison;
    let mut lines = Vec::new();
    if let Some(ranking) = &comparison.ranking {
        let name = |i: usize| comparison.entries[i].candidate.to_string();
        let (best, preferred) = (ranking.best, ranking.preferred);
        let error = |i: usize| standing(comparison, i).map_or(f64::NAN, |s| s.mean);
        let unit = if found.unit.is_empty() { String::new() } else { format!(" {}", found.unit) };
        let floor = significant(error(preferred) / comparison.noise_floor, 2);
        lines.push(if best == preferred {
            format!(
                "Preferred: {}. It has the smallest error on unseen data, {}{unit}, {floor} times the noise floor, and no simpler structure is within \
                 one standard error of it.",
                name(best),
                significant(error(best), 3)
            )
        } else {
            format!(
                "Preferred: {} ({} parameters, {}{unit} on unseen data, {floor} times the noise floor). {} is smallest ({}{unit}, {} parameters), but not \
                 by more than one standard error of the difference.",
                name(preferred),
                comparison.entries[preferred].parameters,
                significant(error(preferred), 3),
                name(best),
                significant(error(best), 3),
                comparison.entries[best].parameters
            )
        });
        let as_good: Vec<String> = ranking
            .order
            .iter()
            .filter(|&&i| i != preferred && standing(comparison, i).is_some_and(|s| s.as_good_as_best))
            .map(|&i| name(i))
            .collect();
        if !as_good.is_empty() {
            lines.push(format!("These records do not tell it from: {}.", as_good.join(", ")));
        }
    }
    lines.extend(comparison.notes.iter().cloned());
    for entry in &comparison.entries {
        lines.extend(entry.failures.iter().map(|why| format!("{} has no place: {why}.", entry.candidate)));
    }
    for (entry, cost) in comparison.entries.iter().zip(&found.costs) {
        if let Some(why) = &cost.why_not {
            lines.push(format!("{} was not timed sample by sample: {why}.", entry.candidate));
        }
    }
    if comparison.interrupted {
        lines.push("Interrupted: the candidates that were not finished are missing.".to_owned());
    }
    lines
}

/// How the numbers came about.
pub fn about(found: &Found) -> String {
    let comparison = &found.comparison;
    format!(
        "Error on unseen data: mean over {} folds of the RMSE of a simulation of what the fit left out, offset estimated, ± standard error over the folds. \
         Above the best: mean ± standard error of the paired differences. Noise floor {} {}. AIC and BIC are above their lowest, over {:.0} independent \
         samples (of {}) that the residuals are worth. ns a sample: of the realisation to 1e-5 of the range (double precision, this machine, all \
         candidates in turns along one drive; shorter by chance as well as by merit). Inverse: of the hysteresis block.",
        comparison.folds.len(),
        significant(comparison.noise_floor, 3),
        found.unit,
        comparison.independent_samples,
        comparison.samples
    )
}

pub fn text(found: &Found) -> String {
    let comparison = &found.comparison;
    let header = header(&found.unit);
    let mut table = console::table(&header.each_ref().map(String::as_str));
    for index in order(comparison) {
        table.add_row(cells(found, index));
    }
    let mut by_fold = console::table(&["left out", "what it holds", "smallest error", "of"]);
    for (f, fold) in comparison.folds.iter().enumerate() {
        let errors = comparison.entries.iter().filter_map(|e| Some((e.fold_rmse[f]?, e.candidate)));
        let (error, best) = errors.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(
            || ("-".to_owned(), "-".to_owned()),
            |(error, candidate)| (significant(error, 3), candidate.to_string()),
        );
        by_fold.add_row([fold.label.clone(), fold.content.clone(), error, best]);
    }
    let verdict: String = verdict(found).into_iter().map(|line| line + "\n").collect();
    format!("{table}\n\n{verdict}\n{by_fold}\n\n{}\n{}", about(found), baselines::table(found))
}
