//! The normal distribution.

/// Quantile that leaves 2.5 % above it.
pub(crate) const NORMAL_975: f64 = 1.959_963_984_540_054;
