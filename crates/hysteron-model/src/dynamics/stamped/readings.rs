//! A drive on time stamps where the output of a static block is read.

use crate::record::{Dependence, InterSample, Pace, paces_on};

/// A drive, and the places in it at which the output of the hysteresis is the output at the wanted times.
///
/// The drive is linear between its samples, or held; a hysteresis operator that depends on it by no more than
/// its values, their order and their rates is exact at every place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// Drive \[V\].
    pub drive_v: Vec<f64>,
    /// Rate and duration of the move to each value, where the hysteresis depends on either.
    pub paces: Option<Vec<Pace>>,
    /// Number of wanted times before the first sample.
    pub before: usize,
    /// Place in the drive of each wanted time from there on.
    pub places: Vec<usize>,
}

impl Readings {
    /// The drive `u` sampled at `times_s`, read at the times `read_s`, increasing \[s\].
    ///
    /// `depends_on`: dependence of the hysteresis on the drive. Where it is the order of the values, samples
    /// that the drive only passes are left out behind a time that is read. Where it is the rate and the drive
    /// slows down at a sample, that sample comes twice: the output jumps there as the plays narrow, and is
    /// read before the jump.
    pub fn new(
        times_s: &[f64],
        u: &[f64],
        rule: InterSample,
        depends_on: Dependence,
        read_s: impl ExactSizeIterator<Item = f64>,
    ) -> Self {
        let paces = (depends_on != Dependence::Order).then(|| paces_on(times_s, u));
        let rate_to =
            |sample: usize| paces.as_ref().and_then(|paces| paces.get(sample)).map_or(0.0, |to| to.rate);
        let count = u.len() + read_s.len();
        let mut readings = Self {
            drive_v: Vec::with_capacity(count),
            paces: paces.as_ref().map(|_| Vec::with_capacity(count)),
            before: 0,
            places: Vec::with_capacity(read_s.len()),
        };
        let mut read_s = read_s.peekable();
        let (Some(&first_s), Some(&first_v)) = (times_s.first(), u.first()) else { return readings };
        while read_s.next_if(|read| *read < first_s).is_some() {
            readings.before += 1;
        }
        readings.push(first_v, Pace::default());
        while read_s.next_if(|read| *read == first_s).is_some() {
            readings.read_last();
        }
        for (sample, times) in times_s.windows(2).enumerate() {
            let Some(&[from, voltage, ref after @ ..]) = u.get(sample..) else { break };
            let [mut since_s, time] = [times[0], times[1]];
            let rate = rate_to(sample + 1);
            let mut is_read_on_the_way = false;
            if rule == InterSample::Hold {
                while read_s.next_if(|read| *read < time).is_some() {
                    readings.read_last();
                }
            } else {
                if depends_on == Dependence::Rate && rate < rate_to(sample) {
                    readings.push(from, Pace { rate, interval_s: 0.0 });
                }
                let slope = (voltage - from) / (time - since_s);
                while let Some(read) = read_s.next_if(|read| *read < time) {
                    readings
                        .push(from + slope * (read - times[0]), Pace { rate, interval_s: read - since_s });
                    readings.read_last();
                    since_s = read;
                    is_read_on_the_way = true;
                }
            }
            let is_read = read_s.peek() == Some(&time);
            let is_passed = after.first().is_some_and(|next| (voltage - from) * (next - voltage) > 0.0);
            // Of an operator that steps over a move numerically no move becomes longer than two steps.
            if is_read || !(is_read_on_the_way && is_passed && depends_on == Dependence::Order) {
                readings.push(voltage, Pace { rate, interval_s: time - since_s });
                // Several samples may have one time.
                while read_s.next_if(|read| *read == time).is_some() {
                    readings.read_last();
                }
            }
        }
        let last = readings.drive_v.len() - 1;
        readings.places.extend(read_s.map(|_| last));
        readings
    }

    fn push(&mut self, drive_v: f64, pace: Pace) {
        self.drive_v.push(drive_v);
        if let Some(paces) = &mut self.paces {
            paces.push(pace);
        }
    }

    /// The value pushed last is read.
    fn read_last(&mut self) {
        self.places.push(self.drive_v.len() - 1);
    }

    /// The output at the wanted times, `v` being that of the hysteresis along the drive and `rest` that
    /// before it.
    pub fn of<'a>(&'a self, v: &'a [f64], rest: f64) -> impl Iterator<Item = f64> + 'a {
        std::iter::repeat_n(rest, self.before).chain(self.places.iter().map(|place| v[*place]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES_S: [f64; 4] = [0.0, 1.0, 2.0, 3.0];
    const DRIVE_V: [f64; 4] = [0.0, 1.0, 2.0, 0.0];

    fn readings(rule: InterSample, depends_on: Dependence, read_s: &[f64]) -> Readings {
        Readings::new(&TIMES_S, &DRIVE_V, rule, depends_on, read_s.iter().copied())
    }

    #[test]
    fn samples_that_are_passed_are_left_out_behind_a_time_that_is_read() {
        let places = |read_s| {
            let readings = readings(InterSample::Linear, Dependence::Order, read_s);
            (readings.drive_v, readings.places)
        };
        assert_eq!(places(&[0.5, 2.5]), (vec![0.0, 0.5, 2.0, 1.0, 0.0], vec![1, 3]));
        assert_eq!(places(&[2.5]), (vec![0.0, 1.0, 2.0, 1.0, 0.0], vec![3]));
        assert_eq!(places(&[0.5, 1.0]), (vec![0.0, 0.5, 1.0, 2.0, 0.0], vec![1, 2]));
        assert_eq!(places(&[0.0, 3.0, 4.0]), (vec![0.0, 1.0, 2.0, 0.0], vec![0, 3, 3]));
    }

    #[test]
    fn before_the_first_sample_the_output_is_that_at_rest() {
        let readings = readings(InterSample::Linear, Dependence::Order, &[-2.0, -1.0, 0.5]);
        let output: Vec<f64> = readings.of(&readings.drive_v, 7.0).collect();
        assert_eq!(output, [7.0, 7.0, 0.5]);
    }

    #[test]
    fn samples_of_one_time_are_read_before_the_jump_between_them() {
        let (times_s, u) = ([0.0, 0.0, 1.0, 1.0, 2.0, 2.0], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        let read_s = times_s.map(|time| time - 1.0);
        let of = |rule| {
            let readings = Readings::new(&times_s, &u, rule, Dependence::Order, read_s.into_iter());
            readings.of(&readings.drive_v, 7.0).collect::<Vec<f64>>()
        };
        assert_eq!(of(InterSample::Linear), [7.0, 7.0, 0.0, 0.0, 2.0, 2.0]);
        assert_eq!(of(InterSample::Hold), [7.0, 7.0, 0.0, 0.0, 2.0, 2.0]);
    }

    #[test]
    fn a_held_drive_is_read_at_its_samples() {
        let readings = readings(InterSample::Hold, Dependence::Order, &[0.0, 0.5, 0.9, 2.0, 2.5]);
        assert_eq!((&readings.drive_v[..], &readings.places[..]), (&DRIVE_V[..], &[0, 0, 0, 2, 2][..]));
    }

    #[test]
    fn where_the_drive_slows_down_it_is_read_before_the_jump() {
        let (times_s, u) = ([0.0, 1.0, 3.0], [0.0, 2.0, 3.0]);
        let read_s = [1.0, 2.0].into_iter();
        let readings = Readings::new(&times_s, &u, InterSample::Linear, Dependence::Rate, read_s);
        assert_eq!(readings.drive_v, [0.0, 2.0, 2.0, 2.5, 3.0]);
        assert_eq!(readings.places, [1, 3]);
        let pace = |rate, interval_s| Pace { rate, interval_s };
        let expected = [pace(0.0, 0.0), pace(2.0, 1.0), pace(0.5, 0.0), pace(0.5, 1.0), pace(0.5, 1.0)];
        assert_eq!(readings.paces, Some(expected.to_vec()));
    }
}
