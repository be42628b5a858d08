//! Selection of a file's named arrays for one record.

use std::collections::{BTreeMap, HashMap};

use hysteron_model::advice::Advice;
use hysteron_model::record::{Channel, Record, TimeBase};
use hysteron_model::{Finding, FindingKind};

use crate::IoError;
use crate::columns::{Heading, Headings, list_arrays};
use crate::place::{FilePart, Place};

/// For each column, whether it is outside of the record of the chosen ones: of another length, of a name that
/// the record has from a nearer group, or not readable. Without a choice, all columns must make one record.
/// In a text, all do.
///
/// # Errors
/// [`IoError::ChooseArrays`] where nothing is chosen and lengths or names rule out one record.
pub(crate) fn set_apart(
    headings: &Headings,
    chosen: &[Option<usize>],
    left_out: &[Option<usize>],
) -> Result<Vec<bool>, IoError> {
    let columns = &headings.columns;
    let length = |i: usize| columns.get(i).and_then(|c| c.array.as_ref()).and_then(|array| array.length);
    let is_named = |i: usize| chosen.contains(&Some(i)) || left_out.contains(&Some(i));
    let mut apart: Vec<bool> = columns.iter().map(|_| false).collect();
    if columns.iter().all(|column| column.array.is_none()) {
        return Ok(apart);
    }
    let nothing_is_chosen = chosen.iter().all(Option::is_none);
    let is_candidate = |i: &usize| !is_named(*i) && !columns[*i].is_unreadable() && !columns[*i].is_alias();
    let candidates: Vec<usize> = (0..columns.len()).filter(is_candidate).collect();
    let samples = match chosen.iter().flatten().next() {
        Some(&first) => length(first),
        None => common_length(headings, &candidates)?,
    };
    for (i, column) in columns.iter().enumerate().filter(|(i, _)| !is_named(*i)) {
        // Without a choice an array of texts that is as long as the record is refused, not passed over, as in
        // a text.
        let is_passed_over = column.is_alias() || (column.is_unreadable() && !nothing_is_chosen);
        apart[i] = length(i) != samples || is_passed_over;
    }
    let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (i, column) in columns.iter().enumerate().filter(|(i, _)| !apart[*i] && !left_out.contains(&Some(*i)))
    {
        by_name.entry(&column.name).or_default().push(i);
    }
    let chosen: Vec<usize> = chosen.iter().flatten().copied().collect();
    for same in
        columns.iter().enumerate().filter_map(|(i, c)| by_name.get(c.name.as_str()).filter(|s| s[0] == i))
    {
        if let [first, second, ..] = same[..]
            && nothing_is_chosen
        {
            let other = &columns[second].header;
            let problem = format!("`{other}` has the same name and length, and nothing says which is meant");
            return Err(choose(headings, &columns[first], problem));
        }
        // The chosen ones, else those next to them.
        let nearness =
            |i: &usize| if chosen.contains(i) { usize::MAX } else { nearness(columns, *i, &chosen) };
        let nearest = same.iter().map(nearness).max();
        for i in same.iter().filter(|i| Some(nearness(i)) != nearest) {
            apart[*i] = true;
        }
    }
    // A column with its own rate takes no time from elsewhere, e.g. from another curve of a force map.
    let has_rate = |i: &usize| columns[*i].array.as_ref().is_some_and(|array| array.has_rate);
    if chosen.iter().any(has_rate) {
        for (i, column) in columns.iter().enumerate().filter(|(i, _)| !is_named(*i)) {
            apart[i] |= column.is_named_as_time() && nearness(columns, i, &chosen) == 0;
        }
    }
    Ok(apart)
}

/// Length of a column's group path plus one where a chosen column is in this group, else 0.
fn nearness(columns: &[Heading], column: usize, chosen: &[usize]) -> usize {
    let group = columns[column].group();
    let holds = |i: &usize| columns.get(*i).is_some_and(|own| own.header.starts_with(group));
    if chosen.iter().any(holds) { group.len() + 1 } else { 0 }
}

/// Common length of all candidates, else that of the only ones whose names make a record; empty arrays are
/// ignored beside others.
fn common_length(headings: &Headings, candidates: &[usize]) -> Result<Option<usize>, IoError> {
    let columns = &headings.columns;
    let mut by_length: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &i in candidates {
        if let Some(length) = columns[i].array.as_ref().and_then(|array| array.length) {
            by_length.entry(length).or_default().push(i);
        }
    }
    if by_length.len() > 1 {
        by_length.remove(&0);
    }
    if by_length.len() <= 1 {
        return Ok(by_length.keys().next().copied());
    }
    let mut named = by_length.values().filter(|own| names_a_record(columns, own, candidates));
    if let (Some(own), None) = (named.next(), named.next()) {
        return Ok(own.first().and_then(|&i| columns[i].array.as_ref()?.length));
    }
    let length = |i: usize| columns[i].array.as_ref().and_then(|array| array.length).filter(|&n| n > 0);
    let mut known = candidates.iter().filter_map(|&i| Some((i, length(i)?)));
    let Some((first, samples)) = known.next() else { return Ok(None) };
    let Some((other, own)) = known.find(|(_, own)| *own != samples) else { return Ok(Some(samples)) };
    let first = &columns[first].header;
    Err(choose(headings, &columns[other], format!("{own} samples where `{first}` has {samples}")))
}

/// Whether columns of one length include an input and an output by name or unit, and do not lack a time that
/// others have.
fn names_a_record(columns: &[Heading], own: &[usize], all: &[usize]) -> bool {
    let is_time = |i: &usize| columns[*i].is_named_as_time();
    let has_rate = |i: &usize| columns[*i].array.as_ref().is_some_and(|array| array.has_rate);
    if !own.iter().any(is_time) && !own.iter().all(has_rate) && all.iter().any(is_time) {
        return false;
    }
    let is_channel = |i: &&usize| !is_time(i) && !columns[**i].name.eq_ignore_ascii_case("valid");
    let channel = |i: &usize| Channel {
        name: columns[*i].name.clone(),
        unit: columns[*i].unit.clone(),
        samples: Vec::new(),
    };
    let channels = own.iter().filter(is_channel).map(channel).collect();
    let (name, time) = (String::new(), TimeBase::Unknown);
    Record { name, time, channels, valid: None, source: None }.names_input_and_output()
}

/// The note that arrays of other lengths than the record's are no part of it, if there are any among those
/// skipped.
pub(crate) fn left_out(
    headings: &Headings,
    samples: usize,
    is_skipped: impl Fn(usize) -> bool,
) -> Option<Finding> {
    let is_other = |column: &Heading| {
        let length = column.array.as_ref().and_then(|array| array.length);
        !column.is_unreadable() && !column.is_alias() && length.is_some_and(|n| n != samples && n > 0)
    };
    let others = headings.columns.iter().enumerate().filter(|(i, column)| is_skipped(*i) && is_other(column));
    let others: Vec<&Heading> = others.map(|(_, column)| column).collect();
    let text = format!(
        "the record is of the arrays of {samples} samples; of other lengths, and left out, are {}",
        list_arrays(others.iter().copied())
    );
    let note = Finding::new(FindingKind::Verdict, "channels", text).with_advice(Advice::ChooseColumns);
    (!others.is_empty()).then_some(note)
}

/// Error for a file without a channel.
pub(crate) fn no_channels(headings: &Headings) -> IoError {
    let place = headings.place();
    if headings.columns.iter().all(|column| column.array.is_none()) {
        return IoError::NoChannels { place, found: headings.list() };
    }
    let problem = "it holds no column of numbers besides time and mask".to_owned();
    IoError::ChooseArrays { place, problem, held: list_arrays(&headings.columns) }
}

fn choose(headings: &Headings, column: &Heading, problem: String) -> IoError {
    IoError::ChooseArrays {
        place: Place::new(&headings.file, FilePart::Array(column.header.as_str().into())),
        problem,
        held: list_arrays(&headings.columns),
    }
}
