//! Fractional calculus of sampled signals.
//!
//! Everything follows from one idea, convolution quadrature (Lubich 1986, doi:10.1137/0517050): an
//! operator K(s) acts on samples with step h as the power series K(δ(z)/h), where δ belongs to the
//! [`Scheme`]. For K = sᵅ and δ = 1 − z that is the Grünwald–Letnikov sum, article Eq. 3.
//!
//! - [`weights`]: the series of δ(z)ᵅ.
//! - [`differintegral`]: Dᵅ of samples, any real α, O(N log N); [`differintegral_direct`] is its O(N²)
//!   oracle.
//! - [`simulate_recursion`]: article Eq. 4, the O(N²) oracle of every simulator; [`simulate_causal`] is the
//!   same recursion in O(N log² N), exact for unstable systems too.
//! - [`convolution_weights`]: the series of any K(δ(z)/h).

mod causal;
mod operator;
mod quadrature;
mod recursion;
mod scheme;
mod weights;

pub use causal::simulate_causal;
pub use operator::{differintegral, differintegral_direct};
pub use quadrature::convolution_weights;
pub use recursion::simulate_recursion;
pub use scheme::Scheme;
pub use weights::{grunwald_letnikov_weights, weights};

/// One term `coefficient · s^order` of an operator polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Coefficient, in units that make the polynomial homogeneous (rad/s to the missing power).
    pub coefficient: f64,
    /// Real order ≥ 0.
    pub order: f64,
}

impl Term {
    /// `coefficient · s^order`.
    pub const fn new(coefficient: f64, order: f64) -> Self {
        Self { coefficient, order }
    }
}
