//! Cross-validation folds: whole records where enough differ in content, else parts of them.

use std::ops::Range;

use super::super::RecordFacts;
use super::content::{Content, near, same};
use super::prospect;
use crate::IdentifyError;
use hysteron_model::record::{MeasurementRun, RunPart};

/// Fewest groups of records for holding out whole records.
const ENOUGH_RECORDS: usize = 3;
/// Number of parts of a record with varied drive: alone, and with another record.
const PARTS_ALONE: usize = 4;
const PARTS_BESIDE: usize = 2;

/// Data held out of one fit and predicted by it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fold {
    /// Name for tables: the record and its part.
    pub label: String,
    /// Amplitude and frequencies of the held-out data, in words.
    pub content: String,
    /// Held-out samples: index of the record, and ranges in it.
    pub held: Vec<(usize, Vec<Range<usize>>)>,
    /// Whole records are held out.
    pub whole: bool,
}

/// Plans the folds; an error explains why structures cannot be distinguished.
pub(super) fn plan(facts: &[RecordFacts], contents: &[Content]) -> Result<Vec<Fold>, IdentifyError> {
    let unit = &facts[0].data.u_unit.to_string();
    let groups = groups(facts, contents);
    let name = |group: &[usize]| {
        let names: Vec<&str> = group.iter().map(|&r| facts[r].data.name.as_str()).collect();
        names.join(" and ")
    };
    let mut folds = Vec::new();
    for group in &groups {
        let first = group[0];
        let parts = match (groups.len(), contents[first].varied) {
            (ENOUGH_RECORDS.., _) => 1,
            (1, true) => PARTS_ALONE,
            (2, true) => PARTS_BESIDE,
            (1, false) => continue,
            _ => 1,
        };
        for part in 0..parts {
            let held = group.iter().map(|&r| (r, ranges(&facts[r], part, parts))).collect();
            let label =
                if parts == 1 { name(group) } else { format!("{} {}/{parts}", name(group), part + 1) };
            folds.push(Fold { label, content: contents[first].describe(unit), held, whole: parts == 1 });
        }
    }
    let first = &contents[0];
    let one_wave = !contents.iter().any(|c| c.varied)
        && contents
            .iter()
            .all(|c| near(c.amplitude.1, first.amplitude.1) && near(c.frequency_hz.1, first.frequency_hz.1));
    if one_wave || folds.len() < 2 {
        return Err(IdentifyError::CannotRank {
            because: format!(
                "the records hold one amplitude and one frequency ({}), which is one experiment however \
                 often it is repeated: no held-out prediction is possible, and every structure can fit the \
                 one loop",
                first.describe(unit)
            ),
            measure: prospect::next_record(facts, contents).map(|(text, _)| text).unwrap_or_default(),
        });
    }
    Ok(folds)
}

/// One fold per part of a run: the drive of all parts is known, so that memory and creep carry over held-out
/// parts. `None` where there are fewer than two parts.
pub(super) fn of_parts(runs: &[MeasurementRun]) -> Option<Vec<Fold>> {
    let of_run = |(index, run): (usize, &MeasurementRun)| -> Vec<Fold> {
        let fold = |part: &RunPart| Fold {
            label: part.data.name.clone(),
            content: Content::of(&RecordFacts::new(part.data.clone()))
                .describe(&part.data.u_unit.to_string()),
            held: vec![(index, vec![part.samples.clone()])],
            whole: false,
        };
        run.parts.iter().map(fold).collect()
    };
    let folds: Vec<Fold> = runs.iter().enumerate().flat_map(of_run).collect();
    (folds.len() > 1).then_some(folds)
}

/// Groups of records of the same content, in the order of their first records.
fn groups(facts: &[RecordFacts], contents: &[Content]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for r in 0..facts.len() {
        let known = groups
            .iter_mut()
            .find(|group| same((&facts[group[0]], &contents[group[0]]), (&facts[r], &contents[r])));
        match known {
            Some(group) => group.push(r),
            None => groups.push(vec![r]),
        }
    }
    groups
}

/// Part `part` of `parts` of a record: of each period, where the drive repeats.
fn ranges(facts: &RecordFacts, part: usize, parts: usize) -> Vec<Range<usize>> {
    let samples = facts.data.u.len();
    let cut = |from: f64, length: f64| {
        let at = |share: usize| ((from + length * share as f64 / parts as f64).round() as usize).min(samples);
        at(part)..at(part + 1)
    };
    match facts.periods {
        Some(p) if parts > 1 && p.count >= 2 => (0..=p.count)
            .map(|m| cut(p.start as f64 + m as f64 * p.period_samples, p.period_samples))
            .filter(|range| !range.is_empty())
            .collect(),
        _ => vec![cut(0.0, samples as f64)],
    }
}

/// Limitations of the ranking.
pub(super) fn limits(contents: &[Content], folds: &[Fold]) -> Vec<String> {
    let mut notes = Vec::new();
    let (low, high) = prospect::band(contents);
    if prospect::one_amplitude(contents) {
        notes.push(
            "All records have one amplitude: polynomial degree, n and the shape of minor loops are compared \
             at that amplitude only."
                .to_owned(),
        );
    }
    if high < prospect::FAST_OVER_SLOW * low.max(f64::MIN_POSITIVE) {
        notes.push(
            "The records span less than a factor of 3 in frequency: dynamics, creep and delay are hardly \
             distinguishable from loop width."
                .to_owned(),
        );
    }
    if folds.len() < 4 {
        notes.push(format!(
            "A standard error from {} folds is itself uncertain by {:.0} %: take the ranking as a hint.",
            folds.len(),
            100.0 / (2.0 * (folds.len() as f64 - 1.0)).sqrt()
        ));
    }
    if folds.iter().any(|f| !f.whole) {
        notes.push(
            "Parts of records are held out, not whole records: differences between records (start, drift, \
             temperature) are not in the errors."
                .to_owned(),
        );
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::record::{InputOutput, TimeBase};
    use std::f64::consts::TAU;

    fn record(name: &str, drive: impl Fn(f64) -> f64, seconds: f64) -> RecordFacts {
        let rate = 1000.0;
        let u: Vec<f64> = (0..(seconds * rate) as usize).map(|k| drive(k as f64 / rate)).collect();
        RecordFacts::new(InputOutput::new(name, TimeBase::uniform(rate), u.clone(), u).unwrap())
    }

    fn sine(name: &str, amplitude: f64, f: f64, seconds: f64) -> RecordFacts {
        record(name, move |t| amplitude * (1.0 - (TAU * f * t).cos()), seconds)
    }

    fn sweep() -> RecordFacts {
        record("sweep", |t| (TAU * (t + 2.0 * t * t)).sin(), 8.0)
    }

    fn planned(facts: &[RecordFacts]) -> Result<Vec<Fold>, IdentifyError> {
        let contents: Vec<Content> = facts.iter().map(Content::of).collect();
        plan(facts, &contents)
    }

    fn labels(facts: &[RecordFacts]) -> Vec<String> {
        planned(facts).unwrap().into_iter().map(|f| f.label).collect()
    }

    #[test]
    fn whole_records_are_left_out_where_three_differ() {
        let facts = [sine("a", 1.0, 1.0, 3.0), sine("b", 1.0, 10.0, 3.0), sine("c", 0.5, 1.0, 3.0)];
        let folds = planned(&facts).unwrap();
        assert_eq!(folds.iter().map(|f| f.label.as_str()).collect::<Vec<_>>(), ["a", "b", "c"]);
        assert!(
            folds.iter().all(|f| f.whole
                && f.held.len() == 1
                && f.held[0].1.len() == 1
                && f.held[0].1[0] == (0..3000))
        );
        assert_eq!((folds[1].content.as_str(), folds[2].content.as_str()), ("1 V, 10 Hz", "0.5 V, 1 Hz"));
    }

    #[test]
    fn a_repeated_record_is_left_out_together_with_its_repetition() {
        let facts = [sine("a", 1.0, 1.0, 3.0), sine("b", 1.0, 10.0, 3.0), sine("a2", 1.0, 1.0, 4.0), sweep()];
        assert_eq!(labels(&facts), ["a and a2", "b", "sweep"]);
        let two = [sweep(), sine("a", 1.0, 1.0, 3.0), sweep()];
        assert_eq!(labels(&two), ["sweep and sweep 1/2", "sweep and sweep 2/2", "a"]);
    }

    #[test]
    fn a_sweep_alone_is_left_out_in_quarters() {
        let folds = planned(&[sweep()]).unwrap();
        let held: Vec<_> = folds.iter().map(|f| f.held[0].1[0].clone()).collect();
        assert_eq!(held, [0..2000, 2000..4000, 4000..6000, 6000..8000]);
        assert!(folds.iter().all(|f| !f.whole));
    }

    #[test]
    fn parts_of_a_repeating_drive_are_the_same_part_of_every_period() {
        // Two alternating amplitudes.
        let wave = |t: f64| if t % 2.0 < 1.0 { 1.0 } else { 0.4 } * (1.0 - (TAU * t).cos());
        let facts = record("nested", wave, 6.0);
        let period = facts.periods.unwrap();
        assert!((period.period_samples - 2000.0).abs() < 1.0 && period.count >= 2, "{period:?}");
        let folds = planned(&[facts]).unwrap();
        assert_eq!(folds.len(), 4);
        assert!(folds.iter().all(|f| f.held[0].1.len() >= 2), "{folds:?}");
        let mut covered: Vec<usize> = folds.iter().flat_map(|f| f.held[0].1.clone()).flatten().collect();
        let all = covered.len();
        covered.sort_unstable();
        covered.dedup();
        assert_eq!(covered.len(), all, "folds must not overlap");
        assert!(all >= 5000);
    }

    #[test]
    fn one_loop_however_often_repeated_is_refused() {
        for facts in [
            vec![sine("a", 1.0, 1.0, 40.0)],
            vec![sine("a", 1.0, 1.0, 5.0), sine("b", 1.0, 1.0, 5.0), sine("c", 1.0, 1.0, 5.0)],
        ] {
            let error = planned(&facts).unwrap_err();
            let IdentifyError::CannotRank { because, measure } = error else { panic!("{error}") };
            assert!(because.contains("one amplitude and one frequency (1 V, 1 Hz)"), "{because}");
            assert!(measure.contains("sweep"), "{measure}");
        }
    }

    #[test]
    fn two_frequencies_are_two_folds() {
        assert_eq!(labels(&[sine("a", 1.0, 1.0, 5.0), sine("b", 1.0, 9.0, 5.0)]), ["a", "b"]);
    }
}
