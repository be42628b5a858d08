//! Records that continue one another: parts of one run on one clock.

use std::ops::Range;

use super::{InputOutput, RecordError, TimeBase};

/// Consecutive records as one: the device was not reset between them.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementRun {
    /// All samples, on their common clock. Between the parts the drive is unknown and taken as linear;
    /// nothing is scored there, since there are no samples.
    pub data: InputOutput,
    /// The parts, in order.
    pub parts: Vec<RunPart>,
}

/// One record of a [`MeasurementRun`].
#[derive(Clone, Debug, PartialEq)]
pub struct RunPart {
    /// The record.
    pub data: InputOutput,
    /// Its samples within the run.
    pub samples: Range<usize>,
}

impl MeasurementRun {
    /// The records as runs: one continues the record before it unless it begins before that ends, which
    /// starts a new run.
    ///
    /// # Errors
    /// [`RecordError::NotUniform`] for a record without times; [`RecordError::JoinColumns`] for other units
    /// than those of the part before; those of [`TimeBase::from_times`].
    pub fn of(records: &[InputOutput]) -> Result<Vec<Self>, RecordError> {
        let mut groups: Vec<Vec<&InputOutput>> = Vec::new();
        for record in records {
            let (first, _) = extent_s(record)?;
            match groups.last_mut() {
                Some(group) if continues(group, first)? => group.push(record),
                _ => groups.push(vec![record]),
            }
        }
        groups.into_iter().map(|group| Self::joined(&group)).collect()
    }

    fn joined(records: &[&InputOutput]) -> Result<Self, RecordError> {
        let mut parts: Vec<RunPart> = Vec::with_capacity(records.len());
        for &record in records {
            let from = parts.last().map_or(0, |part| part.samples.end);
            if let Some(RunPart { data: before, .. }) = parts.last()
                && (&before.u_unit, &before.y_unit) != (&record.u_unit, &record.y_unit)
            {
                let units = |r: &InputOutput| format!("{} and {}", r.u_unit, r.y_unit);
                return Err(RecordError::JoinColumns {
                    first: before.name.clone(),
                    second: record.name.clone(),
                    difference: format!("{} in the one, {} in the other", units(before), units(record)),
                });
            }
            parts.push(RunPart { data: record.clone(), samples: from..from + record.len() });
        }
        let (first, last) = match (records.first(), records.last()) {
            (Some(first), Some(last)) if records.len() > 1 => (*first, *last),
            (Some(only), _) => return Ok(Self { data: (*only).clone(), parts }),
            _ => return Err(RecordError::NoChannels { record: String::new() }),
        };
        let name = format!("{} … {}", first.name, last.name);
        let all = |of: fn(&InputOutput) -> &[f64]| records.iter().flat_map(|r| of(r)).copied().collect();
        let times_s: Vec<f64> =
            records.iter().flat_map(|r| r.time.times_s(r.len()).unwrap_or_default()).collect();
        let masked = records.iter().any(|r| r.valid.is_some());
        let mask = || records.iter().flat_map(|r| r.valid.clone().unwrap_or_else(|| vec![true; r.len()]));
        let data = InputOutput {
            time: TimeBase::from_times(&name, times_s)?,
            u: all(|r| &r.u),
            y: all(|r| &r.y),
            rate: records.iter().map(|r| r.rate.clone()).collect::<Option<Vec<_>>>().map(|all| all.concat()),
            valid: masked.then(|| mask().collect()),
            name,
            source: None,
            ..first.without_samples()
        };
        Ok(Self { data, parts })
    }
}

impl MeasurementRun {
    /// The first part, with the drive of the first sample of the next one, if any, which is not valid: it
    /// gives the length of the pause between parts.
    pub fn beginning(&self) -> InputOutput {
        let Some(RunPart { samples, data }) = self.parts.first() else { return self.data.clone() };
        match self.data.cropped(0..samples.end + 1) {
            Ok(mut begun) => {
                begun.valid.get_or_insert_with(|| vec![true; samples.end + 1])[samples.end] = false;
                begun
            }
            Err(_) => data.clone(),
        }
    }
}

/// True if records follow each other on one clock, as parts of one run do: each begins after the one before
/// ends, by no more than their joint duration.
pub fn follow_each_other(records: &[&InputOutput]) -> bool {
    let extents: Option<Vec<(f64, f64)>> = records.iter().map(|r| r.time.extent_s(r.len())).collect();
    extents.is_some_and(|extents| {
        extents.len() > 1
            && extents.windows(2).all(|two| {
                let (pause, lasted) = (two[1].0 - two[0].1, two[0].1 - two[0].0 + two[1].1 - two[1].0);
                pause > 0.0 && pause <= lasted
            })
    })
}

fn continues(group: &[&InputOutput], begins_s: f64) -> Result<bool, RecordError> {
    group.last().map_or(Ok(false), |last| Ok(begins_s > extent_s(last)?.1))
}

/// Times of the first and of the last sample \[s\].
fn extent_s(record: &InputOutput) -> Result<(f64, f64), RecordError> {
    record.time.extent_s(record.len()).ok_or_else(|| RecordError::NotUniform {
        record: record.name.clone(),
        purpose: "continuing a run",
        found: record.time.description(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(name: &str, start_s: f64, rate: f64, samples: usize) -> InputOutput {
        let base = TimeBase::Uniform { start_s, sample_rate_hz: rate, jitter_samples: 0.0 };
        let u: Vec<f64> = (0..samples).map(|k| start_s + k as f64).collect();
        InputOutput::new(name, base, u.clone(), u).unwrap()
    }

    #[test]
    fn parts_on_one_clock_are_a_run_and_an_earlier_stamp_starts_another() {
        let records = [
            part("a", 0.0, 10.0, 20),
            part("b", 2.5, 100.0, 50),
            part("c", 0.0, 10.0, 20),
            part("d", 2.0, 10.0, 20),
        ];
        let runs = MeasurementRun::of(&records).unwrap();
        assert_eq!(runs.len(), 2);
        assert_eq!(runs[0].parts.iter().map(|p| p.samples.clone()).collect::<Vec<_>>(), [0..20, 20..70]);
        assert_eq!(runs[0].data.time.time_s(20), Some(2.5));
        assert!(matches!(runs[0].data.time, TimeBase::NonUniform { .. }));
        // Without a pause the rate is one.
        assert_eq!(runs[1].data.sample_rate_hz(), Some(10.0));
        assert_eq!(runs[1].parts[1].data, records[3]);
        assert!(follow_each_other(&[&records[0], &records[1]]));
        assert!(!follow_each_other(&[&records[1], &records[2]]) && !follow_each_other(&[&records[0]]));
    }
}
