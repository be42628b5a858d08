//! Search box and its mapping onto the unit box.

use super::OptimizeError;
use serde::{Deserialize, Serialize};

/// Search box, one entry a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// The parameters' ranges.
    pub ranges: Vec<Range>,
}

/// Range of one parameter; `low < high`, both finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Name, for messages and checkpoints.
    pub name: String,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Scaled logarithmically onto [0, 1] (needs `low > 0`).
    pub logarithmic: bool,
}

impl Range {
    /// Range scaled linearly: x = low + (high − low) t.
    pub fn linear(name: &str, low: f64, high: f64) -> Self {
        Self { name: name.to_owned(), low, high, logarithmic: false }
    }

    /// Range scaled logarithmically: x = low (high/low)^t, for a positive parameter that spans decades.
    pub fn logarithmic(name: &str, low: f64, high: f64) -> Self {
        Self { name: name.to_owned(), low, high, logarithmic: true }
    }

    /// Parameter value at `t` in [0, 1]; the ends are met exactly.
    pub fn from_unit(&self, t: f64) -> f64 {
        if t <= 0.0 {
            self.low
        } else if t >= 1.0 {
            self.high
        } else if self.logarithmic {
            (self.low * (self.high / self.low).powf(t)).clamp(self.low, self.high)
        } else {
            ((1.0 - t) * self.low + t * self.high).clamp(self.low, self.high)
        }
    }

    /// Position of the parameter value `x` in [0, 1], clipped.
    pub fn to_unit(&self, x: f64) -> f64 {
        let t = if self.logarithmic {
            (x / self.low).ln() / (self.high / self.low).ln()
        } else {
            (x - self.low) / (self.high - self.low)
        };
        // A logarithm of a value at or below zero is NaN or −∞: the lower end.
        if t > 0.0 { t.min(1.0) } else { 0.0 }
    }

    /// True if the parameter value `x` is at a bound, to 1e-9 of the range.
    pub fn is_end(&self, x: f64) -> bool {
        self.is_lower_end(x) || self.is_upper_end(x)
    }

    /// True if the parameter value `x` is at the lower bound, to 1e-9 of the range.
    pub fn is_lower_end(&self, x: f64) -> bool {
        self.to_unit(x) < 1e-9
    }

    /// True if the parameter value `x` is at the upper bound, to 1e-9 of the range.
    pub fn is_upper_end(&self, x: f64) -> bool {
        self.to_unit(x) > 1.0 - 1e-9
    }

    /// dx/dt of [`Self::from_unit`] where it takes the value `x`.
    pub fn slope(&self, x: f64) -> f64 {
        if self.logarithmic { x * (self.high / self.low).ln() } else { self.high - self.low }
    }
}

impl Bounds {
    /// Number of parameters.
    pub fn dimension(&self) -> usize {
        self.ranges.len()
    }

    /// Parameter values at the point `unit` of the unit box, into `x`.
    pub fn from_unit(&self, unit: &[f64], x: &mut [f64]) {
        for ((range, &t), x) in self.ranges.iter().zip(unit).zip(x) {
            *x = range.from_unit(t);
        }
    }

    /// Point of the unit box of the parameter values `x` (clipped), into `unit`.
    pub fn to_unit(&self, x: &[f64], unit: &mut [f64]) {
        for ((range, &x), t) in self.ranges.iter().zip(x).zip(unit) {
            *t = range.to_unit(x);
        }
    }

    /// Checks that there is a parameter, and that every range has finite ends, `low < high` and, where
    /// logarithmic, `low > 0`.
    ///
    /// # Errors
    /// [`OptimizeError::NoParameters`], [`OptimizeError::Range`].
    pub fn validate(&self) -> Result<(), OptimizeError> {
        if self.ranges.is_empty() {
            return Err(OptimizeError::NoParameters);
        }
        for range in &self.ranges {
            let width = range.high - range.low;
            let wanted = if !(width > 0.0 && width.is_finite()) {
                "low < high, both finite"
            } else if range.logarithmic && !(range.low > 0.0 && (range.high / range.low).is_finite()) {
                "low > 0 for a logarithmic scale"
            } else {
                continue;
            };
            return Err(OptimizeError::Range {
                name: range.name.clone(),
                low: range.low,
                high: range.high,
                wanted,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ends_of_a_range_are_met_exactly() {
        for range in [Range::linear("a", -0.1, 0.7), Range::logarithmic("b", 3e-4, 7e5)] {
            assert_eq!(range.from_unit(0.0), range.low);
            assert_eq!(range.from_unit(1.0), range.high);
            assert_eq!(range.to_unit(range.low), 0.0);
            assert_eq!(range.to_unit(range.high), 1.0);
        }
    }

    #[test]
    fn a_value_within_a_billionth_of_the_range_from_a_bound_is_at_it() {
        for range in [Range::linear("a", -0.1, 0.7), Range::logarithmic("b", 3e-4, 7e5)] {
            for (t, at_end) in [(0.0, true), (1e-10, true), (1e-6, false), (0.5, false), (1.0 - 1e-6, false)]
            {
                assert_eq!(range.is_end(range.from_unit(t)), at_end, "{t}");
            }
            assert!(range.is_end(range.from_unit(1.0 - 1e-10)) && range.is_end(range.high));
            assert!(range.is_upper_end(range.high) && !range.is_upper_end(range.low));
        }
    }

    #[test]
    fn middle_of_a_logarithmic_range_is_the_geometric_mean() {
        let range = Range::logarithmic("b", 1e-2, 1e4);
        assert!((range.from_unit(0.5) - 10.0).abs() < 1e-13);
        assert_eq!(range.to_unit(-1.0), 0.0);
    }

    #[test]
    fn ranges_that_cannot_be_searched_are_refused() {
        let of = |range: Range| Bounds { ranges: vec![range] }.validate();
        assert!(matches!(of(Range::linear("a", 1.0, 1.0)), Err(OptimizeError::Range { .. })));
        assert!(matches!(of(Range::linear("a", 0.0, f64::NAN)), Err(OptimizeError::Range { .. })));
        assert!(matches!(of(Range::linear("a", f64::NEG_INFINITY, 0.0)), Err(OptimizeError::Range { .. })));
        assert!(matches!(of(Range::logarithmic("a", 0.0, 1.0)), Err(OptimizeError::Range { .. })));
        assert!(matches!(Bounds { ranges: vec![] }.validate(), Err(OptimizeError::NoParameters)));
        assert!(of(Range::logarithmic("a", 1e-3, 1.0)).is_ok());
    }

    proptest! {
        #[test]
        fn unit_map_is_inverted_by_its_inverse(
            t in 0.0..=1.0_f64,
            low in 1e-6..1e3_f64,
            factor in 1.5..1e6_f64,
        ) {
            for range in [Range::linear("a", low, low * factor), Range::logarithmic("b", low, low * factor)] {
                let x = range.from_unit(t);
                prop_assert!(range.low <= x && x <= range.high);
                prop_assert!((range.to_unit(x) - t).abs() < 4e-15 * factor / (factor - 1.0));
            }
        }

        #[test]
        fn slope_is_the_derivative_of_the_map(
            t in 0.01..0.99_f64,
            low in 1e-3..1e3_f64,
            factor in 1.5..1e3_f64,
        ) {
            for range in [Range::linear("a", low, low * factor), Range::logarithmic("b", low, low * factor)] {
                let h = 1e-5;
                let difference = (range.from_unit(t + h) - range.from_unit(t - h)) / (2.0 * h);
                let slope = range.slope(range.from_unit(t));
                prop_assert!((difference / slope - 1.0).abs() < 2e-8, "{difference} {slope}");
            }
        }
    }
}
