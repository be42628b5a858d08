//! Fractional calculus of sampled data.
