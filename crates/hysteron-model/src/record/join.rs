//! Several records as one, in the order of time.

use super::{Channel, Record, RecordError, TimeBase};

/// Two pieces of one grid are a grid where they meet within this share of a period.
const SAME_GRID_PERIODS: f64 = 1e-6;

impl Record {
    /// The records one after the other, with the columns of the first. Pieces of one grid are uniform again;
    /// a pause or another rate makes the time base non-uniform. The mask is that of the records, all valid
    /// where a record has none.
    ///
    /// # Errors
    /// [`RecordError::JoinColumns`] where columns, units or the time base differ in kind;
    /// [`RecordError::JoinOrder`] where a record begins before the one before it ends;
    /// [`RecordError::NoChannels`] of no records; those of [`Record::check`].
    pub fn joined(records: &[Record]) -> Result<Record, RecordError> {
        let Some((first, others)) = records.split_first() else {
            return Err(RecordError::NoChannels { record: String::new() });
        };
        if others.is_empty() {
            return Ok(first.clone());
        }
        let mut joined = first.clone();
        joined.source = None;
        joined.name = records.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
        for (earlier, later) in records.iter().zip(others) {
            let columns = first.columns_of(later)?;
            if let (Some((_, ends_s)), Some((begins_s, _))) = (earlier.extent_s(), later.extent_s())
                && begins_s <= ends_s
            {
                return Err(RecordError::JoinOrder {
                    earlier: earlier.name.clone(),
                    later: later.name.clone(),
                    ends_s,
                    begins_s,
                });
            }
            for (to, from) in joined.channels.iter_mut().zip(columns) {
                to.samples.extend(&from.samples);
            }
        }
        if records.iter().any(|record| record.valid.is_some()) {
            let masks = records.iter().map(|r| r.valid.clone().unwrap_or_else(|| vec![true; r.len()]));
            joined.valid = Some(masks.collect::<Vec<_>>().concat());
        }
        joined.time = joined_time(&joined.name, records)?;
        joined.check()?;
        Ok(joined)
    }

    /// The channels of another record in the order of this one's.
    fn columns_of<'a>(&self, other: &'a Record) -> Result<Vec<&'a Channel>, RecordError> {
        let differ = |difference: String| RecordError::JoinColumns {
            first: self.name.clone(),
            second: other.name.clone(),
            difference,
        };
        let known = |record: &Record| !matches!(record.time, TimeBase::Unknown);
        if known(self) != known(other) {
            let without = if known(self) { other } else { self };
            return Err(differ(format!("`{}` has neither a time column nor a sample rate", without.name)));
        }
        let in_both = |of: &'a Record, channel: &Channel| {
            of.channels.iter().find(|c| c.name == channel.name && c.unit == channel.unit)
        };
        if let Some(more) =
            other.channels.iter().find(|c| !self.channels.iter().any(|own| own.name == c.name))
        {
            return Err(differ(format!("`{}` has no column {}", self.name, more.label())));
        }
        let columns = self.channels.iter().map(|own| {
            in_both(other, own).ok_or_else(|| {
                differ(match other.channels.iter().find(|c| c.name == own.name) {
                    Some(c) => {
                        format!("`{}` is in {} in the one and in {} in the other", c.name, unit(own), unit(c))
                    }
                    None => format!("`{}` has no column {}", other.name, own.label()),
                })
            })
        });
        columns.collect()
    }
}

fn unit(channel: &Channel) -> String {
    if channel.unit.symbol().is_empty() { "no unit".to_owned() } else { channel.unit.to_string() }
}

fn joined_time(name: &str, records: &[Record]) -> Result<TimeBase, RecordError> {
    if let Some(grid) = one_grid(records) {
        return Ok(grid);
    }
    let times: Vec<f64> =
        records.iter().flat_map(|r| (0..r.len()).filter_map(|k| r.time.time_s(k))).collect();
    if times.is_empty() { Ok(TimeBase::Unknown) } else { TimeBase::from_times(name, times) }
}

/// The grid that all records lie on, one after the other without a pause.
fn one_grid(records: &[Record]) -> Option<TimeBase> {
    let (mut samples, mut jitter, mut grid) = (0, 0.0_f64, None);
    for record in records {
        let TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples } = record.time else { return None };
        let (start, rate) = *grid.get_or_insert((start_s, sample_rate_hz));
        let expected_s = start + samples as f64 / rate;
        if rate != sample_rate_hz || ((start_s - expected_s) * rate).abs() > SAME_GRID_PERIODS {
            return None;
        }
        jitter = jitter.max(jitter_samples);
        samples += record.len();
    }
    let (start_s, sample_rate_hz) = grid?;
    Some(TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples: jitter })
}

#[cfg(test)]
mod tests {
    use super::super::Cut;
    use super::*;
    use proptest::prelude::*;

    fn record(name: &str, start_s: f64, headers: &[(&str, &str)]) -> Record {
        let time = TimeBase::Uniform { start_s, sample_rate_hz: 10.0, jitter_samples: 0.0 };
        let channels =
            headers.iter().map(|(name, unit)| Channel::new(name, unit, vec![start_s, 1.0, 2.0])).collect();
        Record::new(name, time, channels).unwrap()
    }

    #[test]
    fn columns_are_matched_by_name_and_a_pause_is_kept() {
        let first = record("a.csv", 0.0, &[("u", "V"), ("y", "um")]);
        let mut second = record("b.csv", 1.0, &[("y", "um"), ("u", "V")]);
        second.channels[0].samples[0] = 7.0;
        second.valid = Some(vec![false, true, true]);
        let joined = Record::joined(&[first, second]).unwrap();
        assert_eq!(joined.channels[1].samples, [0.0, 1.0, 2.0, 7.0, 1.0, 2.0]);
        assert_eq!(joined.time, TimeBase::NonUniform { times_s: vec![0.0, 0.1, 0.2, 1.0, 1.1, 1.2] });
        assert_eq!(joined.valid, Some(vec![true, true, true, false, true, true]));
        assert_eq!(joined.name, "a.csv, b.csv");
    }

    #[test]
    fn records_that_do_not_go_together_are_named() {
        let first = record("a.csv", 0.0, &[("u", "V"), ("y", "um")]);
        let refused = |second: Record| Record::joined(&[first.clone(), second]).unwrap_err().to_string();
        for (second, parts) in [
            (
                record("b.csv", 1.0, &[("u", "V"), ("y", "nm")]),
                ["`y` is in µm in the one and in nm", "b.csv"],
            ),
            (record("b.csv", 1.0, &[("u", "V")]), ["`b.csv` has no column `y` (µm)", "a.csv"]),
            (
                record("b.csv", 1.0, &[("u", "V"), ("y", "um"), ("z", "")]),
                ["`a.csv` has no column `z`", "b.csv"],
            ),
            (
                record("b.csv", 0.2, &[("u", "V"), ("y", "um")]),
                ["`b.csv` begins at 0.2 s", "`a.csv` ends at 0.2 s"],
            ),
            (
                Record { time: TimeBase::Unknown, ..record("b.csv", 1.0, &[("u", "V"), ("y", "um")]) },
                ["`b.csv` has neither a time column", "a.csv"],
            ),
        ] {
            let text = refused(second);
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
        assert!(matches!(Record::joined(&[]), Err(RecordError::NoChannels { .. })));
    }

    proptest! {
        /// The parts of a cut record, joined, are the record: to the last bit on a grid, and with the very
        /// stamps off it.
        #[test]
        fn parts_joined_are_the_record(
            steps in prop::collection::vec(0.02..1.0f64, 3..60),
            at in 0.0..1.0f64,
            rate in prop::option::of(0.1..1e5f64),
            masked in any::<bool>(),
        ) {
            let n = steps.len() + 1;
            let times: Vec<f64> = std::iter::once(0.0)
                .chain(steps.iter().scan(0.0, |t, step| {
                    *t += step;
                    Some(*t)
                }))
                .collect();
            let time = match rate {
                Some(rate) => TimeBase::uniform(rate),
                None => TimeBase::from_times("r", times).unwrap(),
            };
            let channels = vec![
                Channel::new("u", "V", (0..n).map(|k| k as f64).collect()),
                Channel::new("y", "um", steps.iter().copied().chain([0.0]).collect()),
            ];
            let mut record = Record::new("r", time, channels).unwrap();
            record.valid = masked.then(|| (0..n).map(|k| k % 3 != 0).collect());
            // Two samples to either side.
            let split = 2 + (at * (n - 4) as f64) as usize;
            let between = 0.5 * (record.time.time_s(split - 1).unwrap() + record.time.time_s(split).unwrap());
            let part = |from_s, to_s| record.cut(&Cut { from_s, to_s, ..Cut::default() }).unwrap();
            let parts = [part(None, Some(between)), part(Some(between), None)];
            prop_assert_eq!(parts[0].len(), split);
            let joined = Record::joined(&parts).unwrap();
            prop_assert_eq!(&joined.channels, &record.channels);
            prop_assert_eq!(&joined.valid, &record.valid);
            if rate.is_some() {
                prop_assert_eq!(&joined.time, &record.time);
            }
            // Off a grid, a part may pass for uniform, and its stamps move by what passed for jitter.
            let moved = |time: &TimeBase| match time {
                TimeBase::Uniform { sample_rate_hz, jitter_samples, .. } => {
                    (1.1 * jitter_samples + 2e-6) / sample_rate_hz
                }
                _ => 0.0,
            };
            let allowed =
                parts.iter().map(|part| moved(&part.time)).fold(0.0, f64::max) + moved(&joined.time);
            for k in 0..n {
                let (t, before) = (joined.time.time_s(k).unwrap(), record.time.time_s(k).unwrap());
                prop_assert!((t - before).abs() <= allowed + moved(&record.time), "{} {}", t, before);
            }
        }
    }
}
