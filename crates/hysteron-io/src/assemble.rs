//! Columns to record: the same rules for every format.

use std::path::Path;

use hysteron_model::Finding;
use hysteron_model::record::{Channel, Record, RecordError, Source, TimeBase};

use crate::columns::{Columns, Rate};
use crate::one_record::left_out;
use crate::place::{FilePart, Place, shown};
use crate::rename::renamed;
use crate::roles::{Chosen, Role, Roles};
use crate::{IoError, ReadOptions};

/// Most texts of a column that a message lists.
const MOST_TEXTS_LISTED: usize = 12;

/// A record of a file.
pub(crate) struct Assembled {
    pub record: Record,
    /// The channels chosen by the options.
    pub chosen: Chosen,
    /// Number of samples in the file.
    pub file_samples: usize,
    /// Notes on arrays that the reader left out by itself.
    pub notes: Vec<Finding>,
}

/// Makes a checked record of a file's columns, renamed and cut as the options say.
pub(crate) fn assemble(mut columns: Columns, options: &ReadOptions) -> Result<Assembled, IoError> {
    columns.headings = renamed(&columns.headings, &options.rename)?;
    let Roles { roles, names, chosen, cut, texts } = Roles::new(&columns.headings, options)?;
    let file_samples = check_lengths(&columns, &roles)?;
    let is_told =
        [&options.input, &options.output, &options.reference, &options.time].into_iter().any(Option::is_some);
    let skipped = |i: usize| !is_told && roles[i] == Role::Skipped;
    let notes = left_out(&columns.headings, file_samples, skipped).into_iter().collect();
    let file = columns.headings.file.clone();
    let name =
        Path::new(&file).file_name().map_or_else(|| file.clone(), |name| name.to_string_lossy().into_owned());
    let failed = |source: RecordError| IoError::Record { file: file.clone(), source: Box::new(source) };
    if !texts.is_empty() {
        retain_texts(&name, &mut columns, &texts, file_samples).map_err(failed)?;
    }
    for (column, role) in roles.iter().enumerate() {
        if cut.is_whole() || *role != Role::Channel {
            check_values(&columns, column, *role)?;
        }
    }
    let (mut times, mut valid, mut channels, mut sources) = (None, None, Vec::new(), Vec::new());
    let values = std::mem::take(&mut columns.values);
    for (index, (samples, role)) in values.into_iter().zip(&roles).enumerate() {
        match role {
            Role::Time(factor) => times = Some(in_seconds(samples, *factor)),
            Role::Mask => valid = Some(samples.iter().map(|&v| v == 1.0).collect()),
            Role::Channel => {
                let unit = columns.headings.columns[index].unit.clone();
                channels.push(Channel { name: names[index].clone(), unit, samples });
                sources.push(index);
            }
            Role::Texts | Role::Skipped => {}
        }
    }
    let rate = columns.rate.take();
    let time = match (times, options.sample_rate_hz) {
        (Some(times), Some(rate)) => TimeBase::from_times_at_rate(&name, &times, rate).map_err(failed)?,
        (Some(times), None) => {
            if let Some(rate) = rate
                && let Err(contradiction @ RecordError::RateContradictsTime { .. }) =
                    TimeBase::from_times_at_rate(&name, &times, rate.hz)
            {
                let place = Place::new(&file, FilePart::Array(rate.path.into()));
                return Err(IoError::RateContradictsTime { place, source: Box::new(contradiction) });
            }
            TimeBase::from_times(&name, times).map_err(failed)?
        }
        (None, Some(rate)) => TimeBase::uniform(rate),
        (None, None) => rate.map_or(TimeBase::Unknown, |Rate { hz: sample_rate_hz, start_s, .. }| {
            // Seconds since so long ago that no two samples have different times are of no use.
            let is_told = start_s.abs() * f64::EPSILON * sample_rate_hz < 0.1;
            let start_s = if is_told { start_s } else { 0.0 };
            TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples: 0.0 }
        }),
    };
    let source = Some(Source { path: file.clone(), sha256: std::mem::take(&mut columns.sha256) });
    let mut record = Record { name, time, channels, valid, source };
    if !cut.is_whole() {
        let kept = cut.kept(&record).map_err(failed)?;
        for (channel, column) in record.channels.iter().zip(sources) {
            if let Some(&sample) = kept.iter().find(|&&k| !channel.samples[k].is_finite()) {
                let found = channel.samples[sample].to_string();
                return Err(IoError::NotFinite { place: columns.place(column, sample), found });
            }
        }
        record = record.at(&kept).map_err(failed)?;
    }
    record.check().map_err(failed)?;
    Ok(Assembled { record, chosen, file_samples, notes })
}

/// Keeps the samples at which text columns hold the requested texts.
fn retain_texts(
    record: &str,
    columns: &mut Columns,
    asked: &[(usize, String)],
    samples: usize,
) -> Result<(), RecordError> {
    let mut keep = vec![true; samples];
    for (column, text) in asked {
        let number = columns.texts[*column].iter().position(|own| own == text).map(|number| number as f64);
        keep.iter_mut().zip(&columns.values[*column]).for_each(|(keep, own)| *keep &= Some(*own) == number);
    }
    let kept = keep.iter().filter(|keep| **keep).count();
    if kept < 2 {
        let holds = asked.iter().map(|(column, _)| {
            let own = &columns.texts[*column];
            let some: Vec<String> = own
                .iter()
                .take(MOST_TEXTS_LISTED)
                .map(|text| format!("`{}`", shown(text.as_bytes())))
                .collect();
            let more = if own.len() > some.len() { ", …" } else { "" };
            format!("{}{more} in `{}`", some.join(", "), columns.headings.header(*column))
        });
        let holds = holds.collect::<Vec<_>>().join(" and ");
        return Err(RecordError::EmptyCut { record: record.to_owned(), kept, samples, holds });
    }
    columns.retain(&keep);
    Ok(())
}

/// Checks that all columns read have one length, that of time or else of the first, of at least two samples.
fn check_lengths(columns: &Columns, roles: &[Role]) -> Result<usize, IoError> {
    let file = &columns.headings.file;
    let read = || (0..roles.len()).filter(|&i| roles[i] != Role::Skipped);
    let Some(first) = read().find(|&i| matches!(roles[i], Role::Time(_))).or_else(|| read().next()) else {
        return Ok(0);
    };
    match columns.check_lengths(first, read())? {
        0 => Err(IoError::NoSamples { place: Place::new(file, FilePart::Whole) }),
        1 => {
            let part = columns.lines.line(0).map_or(FilePart::Whole, FilePart::Line);
            Err(IoError::OneSample { place: Place::new(file, part) })
        }
        samples => Ok(samples),
    }
}

/// Finite numbers, a mask of 0 and 1, time that never decreases.
fn check_values(columns: &Columns, column: usize, role: Role) -> Result<(), IoError> {
    let Some(values) = columns.values.get(column).filter(|_| role != Role::Skipped) else { return Ok(()) };
    let at = |sample| columns.place(column, sample);
    if let Some(sample) = values.iter().position(|value| !value.is_finite()) {
        return Err(IoError::NotFinite { place: at(sample), found: values[sample].to_string() });
    }
    if role == Role::Mask
        && let Some(sample) = values.iter().position(|&value| value != 0.0 && value != 1.0)
    {
        return Err(IoError::BadMask { place: at(sample), found: values[sample].to_string() });
    }
    if let Role::Time(factor) = role
        && let Some(before) = values.windows(2).position(|two| two[1] * factor < two[0] * factor)
    {
        return Err(IoError::TimeDecreases {
            place: at(before + 1),
            before: values[before] * factor,
            after: values[before + 1] * factor,
        });
    }
    Ok(())
}

fn in_seconds(mut times: Vec<f64>, factor: f64) -> Vec<f64> {
    times.iter_mut().for_each(|time| *time *= factor);
    times
}
