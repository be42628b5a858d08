//! Derivatives of the unit-α Bouc–Wen operator with respect to its shape and its start, in the pass that
//! simulates it.
//!
//! Exact derivatives of the exact step ([`hysteron_rt::BoucWen::simulate_with_shape`]), passages of ζ through
//! 0 included. ζ(0) of a steady state is the fixed point of the period map ζ_end(ζ(0), θ), so that by the
//! implicit function theorem ∂ζ(0)/∂θ = (∂ζ_end/∂θ)/(1 − m), m = ∂ζ_end/∂ζ(0).

use hysteron_rt::Dual;

use super::pass::pass;
use super::{BoucWenState, UnitShape, settled};
use crate::hysteresis::HysteresisError;
use crate::hysteresis::pass::{Every, at_rest};
use crate::start::Start;

/// ζ \[V\] and its derivatives at every `factor`-th sample of a drive. The buffers are kept between calls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensitivities {
    /// ζ \[V\].
    pub zeta: Vec<f64>,
    /// ∂ζ/∂β'.
    pub d_beta: Vec<f64>,
    /// ∂ζ/∂γ'.
    pub d_gamma: Vec<f64>,
    /// ∂ζ/∂n; empty unless requested.
    pub d_n: Vec<f64>,
    /// Derivative with respect to the start ζ(0), before the first sample; 0 for a steady state, which has no
    /// free start.
    pub d_start: Vec<f64>,
}

impl UnitShape {
    /// ζ \[V\] and its derivatives for the voltages `u` \[V\] given on a time base finer by `factor`: element
    /// k of each buffer of `out` belongs to `u[k * factor]`. Returns the state (u, ζ) at the last sample of
    /// u.
    ///
    /// Derivatives are those with respect to β', γ', ζ(0) and, if `exponent`, n. Those of a periodic start
    /// are total: the steady state moves with the shape. Closed forms for n = 1 and 2; with `exponent` every
    /// n goes through the series, and n = 1 costs some hundred times as much. Allocates nothing where the
    /// buffers already have their length.
    ///
    /// # Errors
    /// Those of [`super::BoucWen::simulate`]; [`HysteresisError::Factor`];
    /// [`HysteresisError::NotContracting`] where a steady state does not determine its derivatives (β' = γ' =
    /// 0, say).
    pub fn simulate_with_sensitivities(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        exponent: bool,
        out: &mut Sensitivities,
    ) -> Result<BoucWenState, HysteresisError> {
        let operator = self.operator()?;
        let mut every = Every::new(factor)?;
        out.resize(u.len().div_ceil(factor), exponent);
        let at_rest = at_rest(start, u)?;
        let state = match at_rest {
            Some((u, memory)) => BoucWenState { u, z: memory.unwrap_or(0.0) },
            None => settled(&operator, u)?,
        };
        let mut columns =
            out.zeta.iter_mut().zip(&mut out.d_beta).zip(&mut out.d_gamma).zip(&mut out.d_start);
        let mut d_n = out.d_n.iter_mut();
        let mut keep = |zeta: f64, [beta, gamma, n, start]: [f64; 4]| {
            if every.take() {
                if let Some((((z, b), g), s)) = columns.next() {
                    (*z, *b, *g, *s) = (zeta, beta, gamma, start);
                }
                if let Some(slot) = d_n.next() {
                    *slot = n;
                }
            }
        };
        let (zeta, partials) = if exponent {
            let start = (state.u, Dual::variable(state.z, 3));
            let end = operator.simulate_with_sensitivities(start, u, |z| keep(z.value, z.partials))?;
            (end.value, end.partials)
        } else {
            let without_n = |[beta, gamma, start]: [f64; 3]| [beta, gamma, 0.0, start];
            let start = (state.u, Dual::variable(state.z, 2));
            let end = pass(&operator, start, u, |z| keep(z.value, without_n(z.partials)))?;
            (end.value, without_n(end.partials))
        };
        let Some(&u_end) = u.last() else { return Ok(state) };
        if at_rest.is_none() {
            out.close_period(partials)?;
        }
        Ok(BoucWenState { u: u_end, z: zeta })
    }
}

impl Sensitivities {
    /// Resizes every buffer.
    fn resize(&mut self, samples: usize, exponent: bool) {
        for column in [&mut self.zeta, &mut self.d_beta, &mut self.d_gamma, &mut self.d_start] {
            column.resize(samples, 0.0);
        }
        self.d_n.resize(if exponent { samples } else { 0 }, 0.0);
    }

    /// Total derivatives of a steady state from those at fixed ζ(0), which have the values given at the end
    /// of the period.
    fn close_period(&mut self, [beta, gamma, n, start]: [f64; 4]) -> Result<(), HysteresisError> {
        let left = 1.0 - start;
        if left <= f64::EPSILON * self.zeta.len() as f64 {
            return Err(HysteresisError::NotContracting { slope: start });
        }
        for (column, end) in [(&mut self.d_beta, beta), (&mut self.d_gamma, gamma), (&mut self.d_n, n)] {
            let moved = end / left;
            for (own, through_start) in column.iter_mut().zip(&self.d_start) {
                *own += through_start * moved;
            }
        }
        self.d_start.fill(0.0);
        Ok(())
    }
}
