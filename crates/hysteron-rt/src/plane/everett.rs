//! Output of a Preisach plane by its Everett function.

use crate::ParameterError;
use crate::real::Real;

/// A Preisach plane on `n` equal intervals between two voltages: relays of uniform density in each cell (row
/// α, column β < α), without hysteresis in the cells on the diagonal.
///
/// Stored as half of its Everett function E, the weight of all relays that switch between β and α, at the
/// levels: E(x_p, x_q), q < p, in the order (1, 0), (2, 0), (2, 1), (3, 0), …. Between levels E is bilinear,
/// in the interval of the diagonal linear in α − β, both exactly. A move from a turn at t to u changes the
/// output by ±2 E (I. D. Mayergoyz, *Mathematical Models of Hysteresis*, 1991,
/// doi:10.1007/978-1-4612-3028-1): a few operations, whatever the number of relays. There are no relays
/// beyond the levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<'a, T> {
    low: T,
    /// Intervals a volt.
    density: T,
    intervals: usize,
    everett: &'a [T],
}

/// Position on an axis: interval, and fraction within it.
type Place<T> = (usize, T);

impl<'a, T: Real> Plane<'a, T> {
    /// The plane between two voltages in `intervals` intervals, with its sums.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn new([low, high]: [T; 2], intervals: usize, everett: &'a [T]) -> Result<Self, ParameterError<T>> {
        let density = T::of(intervals as f64) / (high - low);
        if !(low < high && density.is_finite() && density > T::of(0.0)) {
            return Err(ParameterError::Range);
        }
        let expected = intervals.saturating_mul(intervals.saturating_add(1)) / 2;
        if everett.len() != expected || expected == 0 {
            return Err(ParameterError::Sums { expected, found: everett.len() });
        }
        if !everett.iter().all(|e| e.is_finite()) {
            return Err(ParameterError::Sum);
        }
        Ok(Self { low, density, intervals, everett })
    }

    /// Intervals a volt.
    pub fn density(&self) -> T {
        self.density
    }

    /// Output of the plane, virgin at `rest`: relays with α + β < 2 `rest` are up.
    pub fn output_at_rest(&self, rest: T) -> T {
        let last = T::of(self.intervals as f64);
        self.node(self.intervals, 0) - T::of(2.0) * self.virgin_sum(false, self.scaled(rest), last)
    }

    /// Change of the output by a move to `u` from `rest`, where the plane was virgin.
    #[inline]
    pub(super) fn virgin_change(&self, rest: T, u: T) -> T {
        let last = T::of(self.intervals as f64);
        let (rest, u) = (self.scaled(rest), self.scaled(u));
        if u > rest {
            T::of(2.0) * self.virgin_sum(false, rest, u)
        } else {
            T::of(-2.0) * self.virgin_sum(true, last - rest, last - u)
        }
    }

    /// Change of the output by a move to `u` from the turning point `turn`.
    #[inline]
    pub(super) fn change(&self, turn: T, u: T) -> T {
        if u > turn {
            T::of(2.0) * self.sum(self.scaled(u), self.scaled(turn))
        } else {
            T::of(-2.0) * self.sum(self.scaled(turn), self.scaled(u))
        }
    }

    /// Voltage in intervals from the lowest level.
    #[inline(always)]
    fn scaled(&self, u: T) -> T {
        (u - self.low) * self.density
    }

    /// Position clamped to the levels.
    #[inline(always)]
    fn place(&self, x: T) -> Place<T> {
        let last = T::of(self.intervals as f64);
        let held = if x > last { last } else { x };
        let held = if held > T::of(0.0) { held } else { T::of(0.0) };
        let interval = held.truncated().min(self.intervals - 1);
        (interval, held - T::of(interval as f64))
    }

    /// Half of the Everett function at levels p and q; 0 on the diagonal.
    #[inline(always)]
    fn node(&self, p: usize, q: usize) -> T {
        if p <= q {
            return T::of(0.0);
        }
        self.everett.get(p * (p - 1) / 2 + q).copied().unwrap_or(T::of(0.0))
    }

    /// Half of the Everett function at α ≥ β, both scaled.
    #[inline(always)]
    fn sum(&self, alpha: T, beta: T) -> T {
        let ((i, a), (j, b)) = (self.place(alpha), self.place(beta));
        if i == j {
            return self.node(i + 1, i) * (a - b);
        }
        let row = |p: usize| {
            let (first, second) = (self.node(p, j), self.node(p, j + 1));
            first + b * (second - first)
        };
        let (first, second) = (row(i), row(i + 1));
        first + a * (second - first)
    }

    /// Weight of the relays with α up to `to` above the antidiagonal through `rest`; of the mirrored plane
    /// for a falling move. ∂E/∂α is integrated along the antidiagonal cell by cell: linear in β, so that the
    /// midpoint rule is exact.
    fn virgin_sum(&self, mirrored: bool, rest: T, to: T) -> T {
        let (zero, half, one) = (T::of(0.0), T::of(0.5), T::of(1.0));
        let n = self.intervals;
        let last = T::of(n as f64);
        let node = |p: usize, q: usize| if mirrored { self.node(n - q, n - p) } else { self.node(p, q) };
        let to = if to > last { last } else { to };
        let mut x = if rest > zero { rest } else { zero };
        let (mut i, _) = self.place(x);
        // β goes down from α.
        let first = rest + rest - x;
        let (mut j, _) = self.place(first);
        let (mut row, mut column) = (T::of(i as f64), T::of(j as f64));
        let mut below = first <= zero;
        let mut sum = zero;
        for _ in 0..2 * n + 2 {
            if x >= to || i >= n {
                break;
            }
            // Where α leaves its interval, and where β does.
            let (row_end, column_end) = (row + one, rest + rest - column);
            let by_column = !below && column_end < row_end;
            let end = if by_column { column_end } else { row_end };
            let end = if end < to { end } else { to };
            if end > x {
                let middle = half * (x + end);
                let beta = if below { zero } else { rest + rest - middle };
                let slope = if i == j {
                    node(i + 1, i)
                } else {
                    let b = if below { zero } else { beta - column };
                    let rise = |q: usize| node(i + 1, q) - node(i, q);
                    let (first, second) = (rise(j), rise(j + 1));
                    first + b * (second - first)
                };
                sum = sum + (end - x) * slope;
                x = end;
            }
            if by_column {
                below = j == 0;
                j -= usize::from(j > 0);
                column = T::of(j as f64);
            } else {
                i += 1;
                row = row + one;
            }
        }
        sum
    }
}
