//! The Duhem model of Coleman and Hodgdon.
//!
//! Sources: B. D. Coleman, M. L. Hodgdon, "A constitutive relation for rate-independent hysteresis in
//! ferromagnetically soft materials", *Int. J. Eng. Sci.* 24 (1986) 897–919; "On a class of constitutive
//! relations for ferromagnetic hysteresis", *Arch. Rational Mech. Anal.* 99 (1987) 375–396,
//! doi:10.1007/BF00282052.

use hysteron_rt::Scalar;
use hysteron_rt::branch::{self, BranchLaw, MOST_MOMENTS};

use super::HysteresisError;
use super::columns::{ColumnKernel, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, NumberUnit, RuntimeOperator, ShapeNumber,
};

/// Highest power of u in a slope.
const MOST: usize = MOST_MOMENTS - 1;

/// Columns of the Coleman–Hodgdon model dv/du = ±b (f(u) − v) + g(u), + where u rises.
///
/// With e = f(u) − v this is de/du = f'(u) − g(u) ∓ b e: only the difference f' − g of the two functions
/// makes hysteresis. So v = f(u) + Σ wⱼ yⱼ, wⱼ = gⱼ − (j + 1) fⱼ₊₁, with the columns
///
/// dyⱼ/du = uʲ ∓ b yⱼ,  j = 0 … degree,  yⱼ = 0 on a virgin device,
///
/// in Vʲ⁺¹, and the polynomial f. Coefficients of f *and* of g beside a polynomial would be redundant. Shape:
/// b \[1/V\]. y₀ is the column of the article's Eq. 1 for n = 1, γ = 0; y₁, y₂, … make it grow with the
/// voltage.
///
/// A move from u₀ by Δ is exact: yⱼ e^(−b|Δ|) + Δ Σₖ (j over k) u₀ʲ⁻ᵏ Δᵏ mₖ(b|Δ|), mₖ(x) = ∫₀¹ θᵏ e^(−x(1−θ))
/// dθ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duhem {
    /// Highest power of u, at most 9; there is one column more.
    pub degree: usize,
}

/// Present voltage and columns.
#[derive(Clone, Debug, PartialEq)]
pub struct DuhemState<S> {
    u: S,
    y: Vec<S>,
}

impl ColumnKernel for Duhem {
    type State<S: Scalar<Real = f64>> = DuhemState<S>;

    simulate_with_sensitivities!(1);

    fn shape_names(&self) -> &'static [&'static str] {
        branch::Duhem::<f64>::NUMBERS
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        if self.degree > MOST {
            return Err(HysteresisError::ShapeParameter {
                name: "degree of the Duhem columns",
                value: self.degree as f64,
                must: "at most 9",
            });
        }
        Ok(branch::Duhem::of(shape).check()?)
    }

    fn columns(&self) -> usize {
        self.degree + 1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> DuhemState<S> {
        DuhemState { u, y: vec![S::constant(0.0); self.columns()] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut DuhemState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let to = S::constant(u);
        let (own, lost) = branch::Duhem::of(shape).relaxation(state.y.len(), state.u, to);
        for (y, own) in state.y.iter_mut().zip(&own) {
            *y = *y + (*own - lost * *y);
        }
        state.u = to;
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &DuhemState<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.y).for_each(|(out, y)| *out = *y);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut DuhemState<S>) -> &mut [S] {
        &mut state.y
    }
}

/// The family.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "duhem"
    }

    fn summary(&self) -> &'static str {
        "Coleman's and Hodgdon's equation with slopes up to u^2"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j y_j, dy_j/du = u^(j-1) - rate s y_j (Coleman and Hodgdon)"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 2, most: MOST })
    }

    fn columns(&self, degree: usize) -> usize {
        degree + 1
    }

    fn weight_unit(&self, index: usize) -> NumberUnit {
        NumberUnit { input: -(index as i32 + 1), ..NumberUnit::OUTPUT }
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        vec![ShapeNumber::new("rate", NumberUnit::PER_INPUT, "sharpness of the loop", span.relaxation())]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        span.bends().map(|bend| vec![bend]).into()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![7.0 / span.stroke]
    }

    fn is_compared_unasked(&self) -> bool {
        true
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::branch(branch::Duhem::of(shape), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = Duhem;

    fn kernel(&self, degree: usize, _: &[f64], _: f64) -> Duhem {
        Duhem { degree }
    }
}
