//! Columns to record: the same rules for every format.

use std::path::Path;

use hysteron_model::record::{Channel, Record, RecordError, Source, TimeBase};

use crate::columns::Columns;
use crate::place::{Part, Place};
use crate::roles::{Chosen, Role, Roles};
use crate::{IoError, ReadOptions};

/// Makes a checked record of a file's columns; also gives the channels chosen by the options.
pub(crate) fn assemble(columns: Columns, options: &ReadOptions) -> Result<(Record, Chosen), IoError> {
    let Roles { roles, chosen } = Roles::new(&columns.headings, options)?;
    check_lengths(&columns, &roles)?;
    for (column, role) in roles.iter().enumerate() {
        check_values(&columns, column, *role)?;
    }
    let Columns { headings, values, sample_rate_hz, sha256, .. } = columns;
    let file = headings.file;
    let name =
        Path::new(&file).file_name().map_or_else(|| file.clone(), |name| name.to_string_lossy().into_owned());
    let (mut times, mut valid, mut channels) = (None, None, Vec::new());
    for ((column, samples), role) in headings.columns.into_iter().zip(values).zip(roles) {
        match role {
            Role::Time(factor) => times = Some(in_seconds(samples, factor)),
            Role::Mask => valid = Some(samples.iter().map(|&v| v == 1.0).collect()),
            Role::Channel => channels.push(Channel { name: column.name, unit: column.unit, samples }),
            Role::Skipped => {}
        }
    }
    let failed = |source: RecordError| IoError::Record { file: file.clone(), source: Box::new(source) };
    let time = match (times, options.sample_rate_hz) {
        (Some(times), Some(rate)) => TimeBase::from_times_at_rate(&name, &times, rate).map_err(failed)?,
        (Some(times), None) => {
            if let Some((array, rate)) = sample_rate_hz
                && let Err(contradiction @ RecordError::RateContradictsTime { .. }) =
                    TimeBase::from_times_at_rate(&name, &times, rate)
            {
                let place = Place::new(&file, Part::Array(array.into()));
                return Err(IoError::RateContradictsTime { place, source: Box::new(contradiction) });
            }
            TimeBase::from_times(&name, times).map_err(failed)?
        }
        (None, Some(rate)) => TimeBase::uniform(rate),
        (None, None) => sample_rate_hz.map_or(TimeBase::Unknown, |(_, rate)| TimeBase::uniform(rate)),
    };
    let source = Some(Source { path: file.clone(), sha256 });
    let record = Record { name, time, channels, valid, source };
    record.check().map_err(failed)?;
    Ok((record, chosen))
}

/// All columns that are read have one length, of at least two samples. Time, else the first of them, says which.
fn check_lengths(columns: &Columns, roles: &[Role]) -> Result<(), IoError> {
    let file = &columns.headings.file;
    let read = || (0..roles.len()).filter(|&i| roles[i] != Role::Skipped);
    let Some(first) = read().find(|&i| matches!(roles[i], Role::Time(_))).or_else(|| read().next()) else {
        return Ok(());
    };
    match columns.check_lengths(first, read())? {
        0 => Err(IoError::NoSamples { place: Place::new(file, Part::Whole) }),
        1 => {
            let part = columns.lines.line(0).map_or(Part::Whole, Part::Line);
            Err(IoError::OneSample { place: Place::new(file, part) })
        }
        _ => Ok(()),
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
