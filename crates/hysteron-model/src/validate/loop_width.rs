//! Opening of a hysteresis loop at mid-range input.

/// Fraction of the input range by which the input must pass the middle, on both sides, for a passage to
/// count: a noisy input that dithers about the middle makes no additional passages.
const CLEARANCE: f64 = 0.05;

/// Opening of the loop at mid-range input: mean output of the downward passages through the middle of the
/// input's range minus that of the upward passages, in the output's unit, over the samples where `scored`
/// holds.
///
/// Positive for a counter-clockwise loop (the output lags the input, as in a piezo actuator), negative for a
/// clockwise one. The output at the middle is interpolated linearly; where the input crosses the middle more
/// than once in one passage, the crossings are averaged. `None` without at least one passage each way.
pub fn loop_opening(u: &[f64], y: &[f64], scored: &[bool]) -> Option<f64> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (u, _) in u.iter().zip(scored).filter(|(_, s)| **s) {
        low = low.min(*u);
        high = high.max(*u);
    }
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return None;
    }
    let middle = low + 0.5 * range;
    let clearance = CLEARANCE * range;

    let mut up = Mean::default();
    let mut down = Mean::default();
    let mut side = Side::Neither;
    let mut crossings = Mean::default();
    let mut previous: Option<(f64, f64)> = None;
    for ((&u, &y), &scored) in u.iter().zip(y).zip(scored) {
        if !scored {
            (side, crossings, previous) = (Side::Neither, Mean::default(), None);
            continue;
        }
        let distance = u - middle;
        if let Some((before, y_before)) = previous
            && (before < 0.0) != (distance < 0.0)
        {
            crossings.add(y_before + (y - y_before) * before / (before - distance));
        }
        previous = Some((distance, y));
        let reached = match distance {
            d if d >= clearance => Side::Above,
            d if d <= -clearance => Side::Below,
            _ => continue,
        };
        if let Some(passage) = crossings.value() {
            match (side, reached) {
                (Side::Below, Side::Above) => up.add(passage),
                (Side::Above, Side::Below) => down.add(passage),
                _ => {}
            }
        }
        (side, crossings) = (reached, Mean::default());
    }
    Some(down.value()? - up.value()?)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Neither,
    Below,
    Above,
}

/// Running mean.
#[derive(Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, x: f64) {
        self.sum += x;
        self.count += 1;
    }

    fn value(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curved loop of few samples: upwards y passes the middle half-way from 1 to 2, downwards from 2.6 to 1.8.
    #[test]
    fn opening_is_read_between_the_samples_beside_the_middle() {
        let u = [-1.0, -0.3, 0.3, 1.0, 0.3, -0.3, -1.0];
        let y = [0.0, 1.0, 2.0, 3.0, 2.6, 1.8, 0.0];
        let found = loop_opening(&u, &y, &[true; 7]).unwrap();
        assert!((found - (2.2 - 1.5)).abs() < 1e-14, "{found}");
        let reversed: Vec<f64> = y.iter().rev().copied().collect();
        assert!((loop_opening(&u, &reversed, &[true; 7]).unwrap() + found).abs() < 1e-14);
        assert_eq!(loop_opening(&u, &y, &[true, true, true, true, true, false, true]), None);
    }
}
