//! A joint fit with the memory of its records held.

use std::sync::Arc;

use hysteron_optimize::Bounds;

use super::super::super::layout::Role;
use super::JointProblem;

impl JointProblem {
    /// This problem with the memory of every record held at its value in `x`; `None` where no memory is
    /// searched, or where searched shape numbers require rerunning the operators anyway.
    pub(in super::super::super) fn holding_memory(&self, x: &[f64]) -> Option<Self> {
        let mut layout = self.layout.clone();
        // The memories come last in the search vector.
        let rest = layout.memory.iter().filter_map(|role| role.index()).min()?;
        if rest == 0 || self.searches_shape() {
            return None;
        }
        for role in &mut layout.memory {
            *role = Role::Fixed(role.value(x)?);
        }
        let bounds = Bounds { ranges: self.bounds.ranges[..rest].to_vec() };
        let held = Self::new(
            Arc::clone(&self.records),
            (self.hysteresis, self.form),
            layout,
            bounds,
            format!(
                "{} with memory held {:x?}",
                self.identity,
                x[rest..].iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            ),
        );
        Some(held.normalised_at(self.normalisation_hz).stopped_by(&self.stop).sharing(&self.spare))
    }
}
