//! Several Bouc–Wen states in parallel.

use std::ops::Range;

use hysteron_rt::{BoucWen, Scalar};

use super::HysteresisError;
use super::columns::{ColumnKernel, finite, parameter, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, NumberUnit, RuntimeOperator, ShapeNumber,
};

/// Most states: three of two shape numbers each.
pub const MOST_STATES: usize = 3;

/// Columns ζₖ \[V\], each a separate Bouc–Wen state in the form with slope 1 from rest, n = 1:
///
/// dζₖ/du = 1 − βₖ s ζₖ − γₖ |ζₖ|,  s = sgn Δu.
///
/// The weight of a column is −αₖ. States of different βₖ bend at different distances from a turning point, so
/// that small and large loops have independent widths, unlike with one state. Shape: β₁, γ₁, β₂, γ₂, …
/// \[1/V\]. Every move is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParallelBoucWen {
    /// Number of states, 1 to 3.
    pub states: usize,
}

/// Present voltage and ζₖ.
#[derive(Clone, Debug, PartialEq)]
pub struct ParallelState<S> {
    u: S,
    zeta: Vec<S>,
}

impl ColumnKernel for ParallelBoucWen {
    type State<S: Scalar<Real = f64>> = ParallelState<S>;

    simulate_with_sensitivities!(2 | 4 | 6);

    fn shape_names(&self) -> &'static [&'static str] {
        const NAMES: [&str; 2 * MOST_STATES] =
            ["beta_1", "gamma_1", "beta_2", "gamma_2", "beta_3", "gamma_3"];
        NAMES.get(..2 * self.states).unwrap_or(&NAMES)
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        if !(1..=MOST_STATES).contains(&self.states) {
            let (name, must) = ("number of Bouc–Wen states", "1 to 3");
            return Err(HysteresisError::ShapeParameter { name, value: self.states as f64, must });
        }
        shape.iter().try_for_each(|&value| finite("β or γ of a Bouc–Wen state", value))
    }

    fn columns(&self) -> usize {
        self.states
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> ParallelState<S> {
        ParallelState { u, zeta: vec![S::constant(0.0); self.states] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut ParallelState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let by = (-state.u).shift(u);
        let distance = by.value();
        let s = if distance < 0.0 { -1.0 } else { 1.0 };
        for (index, zeta) in state.zeta.iter_mut().enumerate() {
            let (beta, gamma) = (parameter(shape, 2 * index), parameter(shape, 2 * index + 1));
            let end = BoucWen::advance_unit(beta, gamma, 1.0, *zeta, distance)
                .map_err(|cause| HysteresisError::RunsAway { index: 0, cause })?;
            // Shifting the start shortens the move: dζ/du at its end.
            let slope = 1.0 - beta.value() * s * end.value() - gamma.value() * end.value().abs();
            *zeta = end + by.shift(-distance).scale(slope);
        }
        state.u = S::constant(u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &ParallelState<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.zeta).for_each(|(out, zeta)| *out = *zeta);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut ParallelState<S>) -> &mut [S] {
        &mut state.zeta
    }
}

/// The family.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "parallel-bouc-wen"
    }

    fn summary(&self) -> &'static str {
        "Two Bouc-Wen states of different sharpness"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_k y_k, dy_k/du = 1 - beta_k s y_k - gamma_k |y_k|"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 2, most: MOST_STATES })
    }

    fn shape_numbers(&self, states: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let of = |k: usize| {
            let unit = NumberUnit::PER_INPUT;
            [
                ShapeNumber::new(format!("beta_{k}"), unit, "sharpness of a state", span.relaxation()),
                ShapeNumber::new(format!("gamma_{k}"), unit, "skew of a state", span.skew()),
            ]
        };
        (1..=states.min(MOST_STATES)).flat_map(of).collect()
    }

    fn starts(&self, states: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let unlike = |beta: f64| (0..states).flat_map(|k| [beta * 4f64.powi(k as i32), 0.0]).collect();
        span.bends().map(unlike).into()
    }

    /// β and γ of a state.
    fn shapes_together_with(&self, index: usize) -> Range<usize> {
        let first = index - index % 2;
        first..first + 2
    }

    fn example(&self, states: usize, span: &DriveSpan) -> Vec<f64> {
        let of = |k: usize| [3.0 * 4f64.powi(k as i32), 1.0 - 1.5 * k as f64].map(|x| x / span.stroke);
        (0..states).flat_map(of).collect()
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        // w ζ(β', γ') = −z with α = −w, β = β', γ = sign(α) γ'.
        let state = |(w, own): (&f64, &[f64])| match *own {
            [beta, gamma] => [-w, beta, -w.signum() * gamma, 1.0],
            _ => [f64::NAN; 4],
        };
        RuntimeOperator::states(weights.iter().zip(shape.chunks(2)).map(state).collect())
    }
}

impl ColumnFamily for Entry {
    type Kernel = ParallelBoucWen;

    fn kernel(&self, states: usize, _: &[f64], _: f64) -> ParallelBoucWen {
        ParallelBoucWen { states }
    }
}
