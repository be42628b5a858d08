//! Dynamic block: linear time-invariant dynamics behind the hysteresis block.

pub mod arx;
mod transfer_function;

pub use arx::Arx;
pub use transfer_function::{Term, TransferFunction};

/// The dynamic block of a Hammerstein model. The pure delay is not here: it belongs to the model.
#[derive(Clone, Debug, PartialEq)]
pub enum Dynamics {
    /// Static model: output = hysteresis output.
    None,
    /// Integer-order transfer function (every order a whole number), in s.
    Integer(TransferFunction),
    /// Linear autoregressive model with exogenous input, in z at the model's sample rate.
    Arx(Arx),
    /// Fractional-order transfer function (article Eq. 6), in s.
    Fractional(TransferFunction),
}

/// How a transfer function in s is simulated on sampled data (convolution quadrature: s → δ(z)/h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Scheme {
    /// δ = 2(1 − z)/(1 + z).
    #[default]
    Tustin,
    /// δ = 1 − z: the article's (Eq. 3). Parameters belong to the sample rate they were identified at.
    GrunwaldLetnikov,
    /// δ = (1 − z) + (1 − z)²/2.
    Bdf2,
    /// No substitution: G at s = σ + iω by damped Fourier inversion.
    BandLimited,
}

/// Assumption about the dynamic block before a record's first sample (SPEC §3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum InitialCondition {
    /// At rest at the first sample's input: simulate v − v(0), add G(0)·v(0).
    #[default]
    Rest,
    /// Steady state of the record repeated for ever.
    Periodic,
    /// All signals zero before the first sample (the article).
    Zero,
}
