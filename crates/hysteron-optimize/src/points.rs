//! A list of points of the unit box in one buffer.

use serde::{Deserialize, Serialize};

/// Points of the unit box, one after the other in one buffer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Points {
    dimension: usize,
    values: Vec<f64>,
}

impl Points {
    pub(super) fn new(dimension: usize) -> Self {
        Self { dimension, values: Vec::new() }
    }

    pub(super) fn len(&self) -> usize {
        self.values.len().checked_div(self.dimension).unwrap_or(0)
    }

    pub(super) fn clear(&mut self) {
        self.values.clear();
    }

    pub(super) fn truncate(&mut self, count: usize) {
        self.values.truncate(count * self.dimension);
    }

    /// Appends a copy of `point` and returns it.
    pub(super) fn push(&mut self, point: &[f64]) -> &mut [f64] {
        let start = self.values.len();
        self.values.extend_from_slice(point);
        &mut self.values[start..]
    }

    pub(super) fn get(&self, i: usize) -> &[f64] {
        &self.values[i * self.dimension..(i + 1) * self.dimension]
    }

    pub(super) fn get_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.dimension..(i + 1) * self.dimension]
    }

    /// True for `count` points of this dimension in the unit box.
    pub(super) fn are_in_unit_box(&self, count: usize, dimension: usize) -> bool {
        self.are_within(1.0, count, dimension) && self.values.iter().all(|&t| t >= 0.0)
    }

    /// True for `count` vectors of this dimension with every component in ± `largest`.
    pub(super) fn are_within(&self, largest: f64, count: usize, dimension: usize) -> bool {
        self.dimension == dimension
            && Some(self.values.len()) == count.checked_mul(dimension)
            && self.values.iter().all(|t| t.abs() <= largest)
    }
}
