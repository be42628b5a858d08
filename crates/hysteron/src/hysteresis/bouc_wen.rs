//! The (improved) Bouc–Wen model, article Eq. 1.

/// Improved Bouc–Wen operator, article Eq. 1 with a polynomial of any degree:
///
/// v = Σ_{i≥1} polynomial\[i−1\] uⁱ − z,  ż = α u̇ − β |u̇| z |z|ⁿ⁻¹ − γ u̇ |z|ⁿ,  n ≥ 1.
#[derive(Clone, Debug, PartialEq)]
pub struct BoucWen {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\]; no constant term (the model's one offset is elsewhere).
    pub polynomial: Vec<f64>,
    /// Size of the loop \[µm/V\].
    pub alpha: f64,
    /// Shape of the loop \[µm^(1−n)/V\].. of |u̇| z |z|ⁿ⁻¹.
    pub beta: f64,
    /// Shape of the loop, of u̇ |z|ⁿ; same unit as `beta`.
    pub gamma: f64,
    /// Smoothness of the transition, ≥ 1.
    pub n: f64,
}
