//! ARX model.

/// Linear autoregressive model with exogenous input, in the sampled domain:
///
/// y_k = −Σ_{i=1}^{na} a\[i−1\] y_{k−i} + Σ_{j=0}^{nb−1} b\[j\] v_{k−j}.
#[derive(Clone, Debug, PartialEq)]
pub struct Arx {
    /// Autoregressive coefficients a₁ … a_na (the leading 1 is not stored).
    pub a: Vec<f64>,
    /// Input coefficients b₀ … b_(nb−1).
    pub b: Vec<f64>,
}
