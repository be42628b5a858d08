//! Knots of a drive on time stamps.

use crate::record::{Dependence, InterSample, Pace, paces_on};

/// Largest move between knots, as a share of the range of the drive: the output of the hysteresis is taken as
/// a polygon through them, in error by less than an eighth of its curvature over the move, and dynamics
/// respond to parabolas with the means of the polygon over its arcs.
const LARGEST_MOVE: f64 = 1.0 / 400.0;
/// [`LARGEST_MOVE`] for hysteresis that depends on time: where the drive speeds up, all its plays stick and
/// release together, or bend as they engage.
const LARGEST_MOVE_IN_TIME: f64 = 1.0 / 1000.0;
/// Largest number of knots per step.
const MOST_PARTS: f64 = 1000.0;
/// Largest number of intervals in an arc.
const MOST_PER_ARC: usize = 5;

/// Times of knots, and the arcs between them: stretches of equal intervals over which an input may be taken
/// as quadratic.
///
/// Arcs follow each other to the last knot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnotTimes {
    /// Times \[s\], not decreasing.
    pub times_s: Vec<f64>,
    /// Knots at which arcs end, in ascending order; the first arc begins at knot 0.
    pub arcs: Vec<usize>,
}

/// Times and values of a drive, as dense as the hysteresis requires.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knots {
    /// Times, and the arcs: parts of the steps of the drive.
    pub times: KnotTimes,
    /// Drive there \[V\].
    pub drive_v: Vec<f64>,
    /// Rate and duration of the move to each knot, where the hysteresis depends on either.
    pub paces: Option<Vec<Pace>>,
}

impl From<Vec<f64>> for KnotTimes {
    /// Knots without a knot between them: an arc to each.
    fn from(times_s: Vec<f64>) -> Self {
        Self { arcs: (1..times_s.len()).collect(), times_s }
    }
}

impl Knots {
    /// Knots of the drive `u` sampled at `times_s`: its samples and, where it is linear, as many between them
    /// as large moves require (a held drive jumps). A band-limited drive is undetermined by uneven samples:
    /// it counts as linear.
    ///
    /// `depends_on`: dependence of the hysteresis on the drive. Where it is the rate and the drive slows down
    /// at a sample, a second knot at its time represents the instant after it, at which the plays have
    /// narrowed and shifted their states: the output jumps there.
    pub fn new(times_s: &[f64], u: &[f64], rule: InterSample, depends_on: Dependence) -> Self {
        let largest = match depends_on {
            Dependence::Order => LARGEST_MOVE * range(u),
            Dependence::Time | Dependence::Rate => LARGEST_MOVE_IN_TIME * range(u),
        };
        let travel: f64 = u.windows(2).map(|two| (two[1] - two[0]).abs()).sum();
        let between = Some(travel / largest).filter(|knots| knots.is_finite() && rule != InterSample::Hold);
        let count = u.len() + between.unwrap_or(0.0) as usize;
        let paces = (depends_on != Dependence::Order).then(|| paces_on(times_s, u));
        let mut knots = Self {
            times: KnotTimes { times_s: Vec::with_capacity(count), arcs: Vec::with_capacity(u.len()) },
            drive_v: Vec::with_capacity(count),
            paces: paces.as_ref().map(|_| Vec::with_capacity(count)),
        };
        let rate_to =
            |sample: usize| paces.as_ref().and_then(|paces| paces.get(sample)).map_or(0.0, |to| to.rate);
        if let (Some(&time), Some(&voltage)) = (times_s.first(), u.first()) {
            knots.push(time, voltage, 0.0);
        }
        for (sample, times) in times_s.windows(2).enumerate() {
            let Some(&[from, voltage, ..]) = u.get(sample..) else { break };
            let [before, time] = [times[0], times[1]];
            let [rate_before, rate] = [rate_to(sample), rate_to(sample + 1)];
            if rule != InterSample::Hold {
                if depends_on == Dependence::Rate && rate < rate_before {
                    knots.push(before, from, rate);
                    knots.end_arc();
                }
                let moves = ((voltage - from).abs() / largest).clamp(0.0, MOST_PARTS);
                // Rounded up, without a call of the library.
                let parts = moves as usize + usize::from((moves as usize as f64) < moves);
                // Of few parts a division would only take time.
                let per_arc =
                    if parts > MOST_PER_ARC { parts.div_ceil(parts.div_ceil(MOST_PER_ARC)) } else { parts };
                let mut left_in_arc = per_arc;
                let (part_s, part_v) = ((time - before) / parts as f64, (voltage - from) / parts as f64);
                for part in 1..parts {
                    knots.push(before + part as f64 * part_s, from + part as f64 * part_v, rate);
                    left_in_arc -= 1;
                    if left_in_arc == 0 {
                        knots.end_arc();
                        left_in_arc = per_arc;
                    }
                }
            }
            knots.push(time, voltage, rate);
            knots.end_arc();
        }
        knots
    }

    fn end_arc(&mut self) {
        self.times.arcs.push(self.drive_v.len() - 1);
    }

    fn push(&mut self, time_s: f64, drive_v: f64, rate: f64) {
        if let Some(paces) = &mut self.paces {
            let interval_s = self.times.times_s.last().map_or(0.0, |before| time_s - before);
            paces.push(Pace { rate, interval_s });
        }
        self.times.times_s.push(time_s);
        self.drive_v.push(drive_v);
    }
}

fn range(u: &[f64]) -> f64 {
    let (low, high) = u.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_knot_stands_where_the_drive_slows_down() {
        let (times_s, u) = ([0.0, 1.0, 3.0, 4.0], [0.0, 1e-3, 1.9e-3, 1.0]);
        let plain = Knots::new(&times_s, &u, InterSample::Linear, Dependence::Order);
        let seen = Knots::new(&times_s, &u, InterSample::Linear, Dependence::Rate);
        assert_eq!(seen.times.times_s[..4], [0.0, 1.0, 1.0, 3.0]);
        assert_eq!(seen.drive_v[..4], [0.0, 1e-3, 1e-3, 1.9e-3]);
        let expected = [0.0, 1e-3, 4.5e-4, 4.5e-4];
        let paces = seen.paces.unwrap_or_default();
        assert!(paces.iter().zip(expected).all(|(pace, expected)| (pace.rate - expected).abs() < 1e-15));
        assert!(paces[4..].iter().all(|pace| (pace.rate - 0.9981).abs() < 1e-15));
        assert_eq!([paces[1], paces[2]].map(|pace| pace.interval_s), [1.0, 0.0]);
        assert!((paces.iter().map(|pace| pace.interval_s).sum::<f64>() - 4.0).abs() < 1e-12);
        assert_eq!((plain.times.times_s.len(), seen.times.times_s.len()), (4 + 399, 4 + 1 + 998));
        // A held drive jumps; it has no corners.
        assert_eq!(Knots::new(&times_s, &u, InterSample::Hold, Dependence::Rate).times.times_s, times_s);
    }

    #[test]
    fn a_drive_that_stands_still_has_its_samples_as_knots() {
        let knots = Knots::new(&[0.0, 1.0, 2.0], &[3.0; 3], InterSample::Linear, Dependence::Rate);
        assert_eq!(knots.times.times_s, [0.0, 1.0, 2.0]);
        let still = |interval_s| Pace { rate: 0.0, interval_s };
        assert_eq!(knots.paces, Some(vec![still(0.0), still(1.0), still(1.0)]));
    }
}
