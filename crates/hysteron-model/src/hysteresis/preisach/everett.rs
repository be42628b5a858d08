//! The Everett function of a Preisach plane, from its weights and from measured first-order reversal curves.

use super::super::columns::ColumnModel;
use super::{HysteresisError, Preisach};

/// A measured first-order reversal curve: from negative saturation up to a level, there the turn, then down.
#[derive(Clone, Debug, PartialEq)]
pub struct ReversalCurve {
    /// Voltages from the turn on \[V\], decreasing.
    pub voltages_v: Vec<f64>,
    /// Displacements at these \[µm\].
    pub displacements_um: Vec<f64>,
}

impl ReversalCurve {
    /// The displacement at `u`, on straight lines between the points.
    fn at(&self, u: f64) -> Option<f64> {
        let points = self.voltages_v.iter().zip(&self.displacements_um);
        let mut before: Option<(f64, f64)> = None;
        for (&to, &y) in points {
            if to <= u {
                return match before {
                    Some((from, y_from)) => Some(y + (y_from - y) * ((u - to) / (from - to))),
                    None => (to == u).then_some(y),
                };
            }
            before = Some((to, y));
        }
        None
    }
}

impl Preisach {
    /// The model with the Everett function `table[p][q]` = E(x_p, x_q), q ≤ p, at these levels \[µm\]: half of what the output
    /// falls from the turn at x_p on the ascending limiting branch to x_q. Weights are its mixed differences.
    ///
    /// # Errors
    /// [`HysteresisError::EverettTable`] where row p does not have p + 1 finite numbers, the last one 0; and as
    /// [`ColumnModel::validate`].
    pub fn from_everett(levels: Vec<f64>, table: &[Vec<f64>]) -> Result<ColumnModel<Self>, HysteresisError> {
        if table.len() != levels.len() {
            return Err(HysteresisError::EverettTable { row: table.len().min(levels.len()) });
        }
        for (row, values) in table.iter().enumerate() {
            let zero = values.last().is_some_and(|last| *last == 0.0);
            if values.len() != row + 1 || !zero || !values.iter().all(|e| e.is_finite()) {
                return Err(HysteresisError::EverettTable { row });
            }
        }
        let at = |p: usize, q: usize| table.get(p).and_then(|row| row.get(q)).copied().unwrap_or(0.0);
        let kernel = Self { levels };
        let pairs = (0..kernel.intervals()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        // Below the diagonal E is 0.
        let weights =
            pairs.map(|(i, j)| (at(i + 1, j) - at(i, j)) - (at(i + 1, j + 1) - at(i, j + 1))).collect();
        ColumnModel::new(vec![0.0], kernel, Vec::new(), weights)
    }

    /// The model that reproduces measured first-order reversal curves: one a level from the second on, in their order, each
    /// beginning at its level and going down at least to the first level. Exact at the levels, bilinear between them. The
    /// offset of the displacements is left out.
    ///
    /// # Errors
    /// [`HysteresisError::ReversalCurve`] for a curve that does not decrease in voltage, does not begin at its level, does
    /// not reach the first one or holds numbers that are not finite; and as [`Self::from_everett`].
    pub fn from_reversal_curves(
        levels: Vec<f64>,
        curves: &[ReversalCurve],
    ) -> Result<ColumnModel<Self>, HysteresisError> {
        if curves.len() + 1 != levels.len() {
            return Err(HysteresisError::EverettTable { row: curves.len() + 1 });
        }
        let mut table = vec![vec![0.0]];
        for (index, curve) in curves.iter().enumerate() {
            let bad = HysteresisError::ReversalCurve { index };
            let falls = curve.voltages_v.windows(2).all(|pair| matches!(pair, [a, b] if b < a));
            let count = curve.voltages_v.len();
            let finite = curve.voltages_v.iter().chain(&curve.displacements_um).all(|x| x.is_finite());
            let starts = curve.voltages_v.first() == levels.get(index + 1);
            if !falls || !finite || !starts || curve.displacements_um.len() != count {
                return Err(bad);
            }
            let top = curve.displacements_um.first().copied().unwrap_or(0.0);
            let row = levels.iter().take(index + 2).map(|&x| curve.at(x).map(|y| 0.5 * (top - y)));
            let Some(row) = row.collect::<Option<Vec<f64>>>() else { return Err(bad) };
            table.push(row);
        }
        Self::from_everett(levels, &table)
    }
}

impl ColumnModel<Preisach> {
    /// Everett function E(α, β) \[µm\], α ≥ β: half of what the relays' part of the output falls from the turn at α on the
    /// ascending limiting branch to β. Continuous: bilinear between levels, linear next to the diagonal.
    pub fn everett(&self, alpha: f64, beta: f64) -> f64 {
        let share = |index: usize, u: f64| {
            let [low, high] = self.kernel.interval(index);
            ((u - low) / (high - low)).clamp(0.0, 1.0)
        };
        let pairs = (0..self.kernel.intervals()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let cells = pairs.zip(&self.weights).map(|((i, j), weight)| {
            let (above, below) = (share(i, alpha), share(j, beta));
            weight * if i == j { (above - below).max(0.0) } else { above * (1.0 - below) }
        });
        cells.sum()
    }
}
