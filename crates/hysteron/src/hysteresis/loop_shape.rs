//! Which way round a loop runs and how wide it is open; for measured and simulated loops alike.

use std::fmt::{Display, Formatter};

/// Sense in which the point (u, v) runs round the loop, u to the right, v upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LoopSense {
    /// Displacement lags voltage: the normal sense of a piezo actuator (falling branch above the rising one).
    CounterClockwise,
    /// Displacement leads voltage.
    Clockwise,
    /// No loop: the enclosed area is below a millionth of the rectangle that holds all samples.
    Closed,
}

impl Display for LoopSense {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::CounterClockwise => "counter-clockwise (displacement lags voltage)",
            Self::Clockwise => "clockwise (displacement leads voltage)",
            Self::Closed => "no loop (rising and falling branch coincide)",
        })
    }
}

/// Signed area ½ Σ (u_k v_{k+1} − u_{k+1} v_k) \[V·µm\] enclosed by the samples in order, closed from the last to the
/// first; positive counter-clockwise. Several periods add up. 0 for fewer than three samples.
pub fn loop_area(u: &[f64], v: &[f64]) -> f64 {
    let (Some((&u_first, &v_first)), Some(_)) = (u.first().zip(v.first()), u.get(2).zip(v.get(2))) else {
        return 0.0;
    };
    // About the first sample, so that a large offset costs no digits.
    let points = u.iter().zip(v).map(|(u, v)| (u - u_first, v - v_first));
    let next = points.clone().skip(1);
    0.5 * points.zip(next).map(|((u0, v0), (u1, v1))| u0 * v1 - u1 * v0).sum::<f64>()
}

/// Sense of the loop that the samples run through (one or more whole periods).
pub fn loop_sense(u: &[f64], v: &[f64]) -> LoopSense {
    let span = |x: &[f64]| {
        let (low, high) = extremes(x);
        high - low
    };
    let area = loop_area(u, v);
    if area.abs() > 1e-6 * span(u) * span(v) {
        if area > 0.0 { LoopSense::CounterClockwise } else { LoopSense::Clockwise }
    } else {
        LoopSense::Closed
    }
}

/// Signed opening of the loop at mid-range \[unit of v\]: v on the falling branch minus v on the rising branch at
/// u = (max u + min u)/2, each the mean over all passages, interpolated linearly. Positive counter-clockwise.
/// `None` where u does not pass its mid-range in both directions.
pub fn loop_opening(u: &[f64], v: &[f64]) -> Option<f64> {
    let (low, high) = extremes(u);
    let middle = 0.5 * low + 0.5 * high;
    let (mut rising, mut falling) = ((0.0, 0_u32), (0.0, 0_u32));
    for (u, v) in u.windows(2).zip(v.windows(2)) {
        if let ([u0, u1], [v0, v1]) = (u, v) {
            let branch = if *u0 < middle && *u1 >= middle {
                &mut rising
            } else if *u0 > middle && *u1 <= middle {
                &mut falling
            } else {
                continue;
            };
            branch.0 += v0 + (v1 - v0) * ((middle - u0) / (u1 - u0));
            branch.1 += 1;
        }
    }
    (rising.1 > 0 && falling.1 > 0).then(|| falling.0 / f64::from(falling.1) - rising.0 / f64::from(rising.1))
}

/// Smallest and largest sample.
fn extremes(x: &[f64]) -> (f64, f64) {
    x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}
