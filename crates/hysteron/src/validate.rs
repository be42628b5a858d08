//! Metrics and residual tests, defined once.
