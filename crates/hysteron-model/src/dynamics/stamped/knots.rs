//! Where a drive on time stamps is followed.

use crate::record::InterSample;

/// Largest move between knots, as a share of the range of the drive: between them the output of the hysteresis is taken to go
/// along a straight line, which leaves out less than an eighth of its curvature over the move.
const LARGEST_MOVE: f64 = 1.0 / 400.0;
/// Most knots that one step is divided into.
const MOST_PARTS: f64 = 1000.0;

/// Times and values of a drive, as close as the hysteresis asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    /// Times \[s\], increasing.
    pub times_s: Vec<f64>,
    /// Drive there \[V\].
    pub drive_v: Vec<f64>,
}

impl Knots {
    /// Knots of the drive `u` sampled at `times_s`: its samples and, on straight lines, as many between them as large moves ask for
    /// (a held drive jumps). A band-limited drive is not known from uneven samples: it counts as straight lines.
    pub fn new(times_s: &[f64], u: &[f64], rule: InterSample) -> Self {
        let (low, high) = u.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
        let largest = LARGEST_MOVE * (high - low);
        let mut knots = Self { times_s: Vec::with_capacity(u.len()), drive_v: Vec::with_capacity(u.len()) };
        for (k, (&time, &voltage)) in times_s.iter().zip(u).enumerate() {
            if let (Some(before), Some(&from)) =
                (k.checked_sub(1).and_then(|k| times_s.get(k)), u.get(k.max(1) - 1))
                && rule != InterSample::Hold
            {
                let parts = ((voltage - from).abs() / largest).ceil().clamp(1.0, MOST_PARTS);
                for part in 1..parts as usize {
                    let share = part as f64 / parts;
                    knots.times_s.push(before + share * (time - before));
                    knots.drive_v.push(from + share * (voltage - from));
                }
            }
            knots.times_s.push(time);
            knots.drive_v.push(voltage);
        }
        knots
    }
}
