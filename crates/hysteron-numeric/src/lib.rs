//! Array kernels under the dynamics: exp(α(a + iθ)), power series, FFT plans, convolution.
//!
//! Everything here is arithmetic without physics. The kernels are bit-identical on every instruction set (no
//! fused multiply-add); FFTs and matrix products need not be across processors.

mod cholesky;
mod complex_exponential;
pub mod convolution;
mod dispatch;
pub mod display;
pub mod distribution;
mod elementary;
mod feedback_adjoint;
mod feedback_tangent;
pub mod fft;
mod filter;
mod gram;
mod inner_product;
mod least_squares;
mod non_negative;
pub mod normal;
pub mod number;
mod progress;
mod relaxation;
mod relaxation_bank;
mod resonance_bank;
mod series;
mod stop;
mod triangular;

pub use cholesky::cholesky;
pub use dispatch::{
    InstructionSet, Pass, accumulate_power, accumulate_tangent, filter_every, half_turns, multiply,
    multiply_and_add, multiply_by, multiply_quotient, quotient_parts, quotient_tangent, rotate,
    rotate_and_add, run_pass, scale,
};
pub use elementary::smooth_minimum;
pub use feedback_tangent::{FeedbackTangent, Forcing, LANES, Lanes, TangentNumber, Target};
pub use gram::gram;
pub use inner_product::{dot, project_out, root_mean_square, subtract};
pub use least_squares::{LeastSquares, least_squares};
pub use non_negative::non_negative_least_squares;
pub use progress::{Listener, Meter, Stopped, Tell};
pub use relaxation::Relaxations;
pub use relaxation_bank::{
    ABREAST, Abreast, BankWeights, PER_OCTAVE, Parabolas, RelaxationBank, relaxation_rate,
};
pub use resonance_bank::{Propagated, ResonanceBank};
pub use rustfft::num_complex::Complex;
pub use series::SeriesPanel;
pub use stop::Stop;
pub use triangular::triangular;

/// Complex number in double precision.
pub type Complex64 = Complex<f64>;
