//! The simulated displacement with its derivatives.

use nalgebra::{Matrix3, SMatrix};

use super::simulate::{first_state, settle};
use super::step::{Motion, State};
use super::{Drive, Oscillator, OscillatorState, SimulationError};
use crate::start::Start;

/// Derivatives: with respect to the seven parameters in the order of [`Oscillator::NAMES`], then to y, ẏ and
/// z at the first sample.
pub const PARTIALS: usize = 10;
/// Number of parameters.
const PARAMETERS: usize = 7;

/// Displacements and their derivatives, reusable: a call that finds buffers of the right length allocates
/// nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    /// Displacement at every sample.
    pub y: Vec<f64>,
    /// ∂y/∂ each of the [`PARTIALS`], at every sample.
    pub partials: [Vec<f64>; PARTIALS],
}

/// Derivatives of a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent {
    pub y: [f64; PARTIALS],
    pub v: [f64; PARTIALS],
    pub z: [f64; PARTIALS],
}

/// A derivative below this has vanished: well above the subnormal numbers, which are slow to compute with.
const VANISHED: f64 = 1e-250;

impl Tangent {
    /// At the first sample: 1 with respect to the state itself.
    fn at_start() -> Self {
        let unit = |index: usize| std::array::from_fn(|j| if j == index { 1.0 } else { 0.0 });
        Self { y: unit(PARAMETERS), v: unit(PARAMETERS + 1), z: unit(PARAMETERS + 2) }
    }

    /// self + a d.
    #[inline(always)]
    pub(super) fn moved(&self, a: f64, d: &Self) -> Self {
        let sum = |x: &[f64; PARTIALS], d: &[f64; PARTIALS]| -> [f64; PARTIALS] {
            std::array::from_fn(|j| x[j] + a * d[j])
        };
        Self { y: sum(&self.y, &d.y), v: sum(&self.v, &d.v), z: sum(&self.z, &d.z) }
    }

    /// Sets vanished derivatives with respect to the first state, which keep decaying, to 0.
    fn drop_vanished(&mut self) {
        for column in [&mut self.y, &mut self.v, &mut self.z] {
            for p in column.iter_mut().skip(PARAMETERS).filter(|p| p.abs() < VANISHED) {
                *p = 0.0;
            }
        }
    }
}

impl Oscillator {
    /// Displacement with its derivatives under the force of `drive`, into `out`; returns the state at the
    /// last sample, of a force that repeats that at the end of the period. The displacement is that of
    /// [`Self::simulate`], to the last bit, and the derivatives are exact for it. From [`Start::PERIODIC`]
    /// they are those of the steady state: the ones with respect to the first state are then 0.
    ///
    /// # Errors
    /// Those of [`Self::simulate`]; [`SimulationError::NotContracting`] where a steady state has no
    /// derivatives.
    pub fn simulate_with_sensitivities(
        &self,
        drive: &Drive,
        start: Start<OscillatorState>,
        out: &mut Response,
    ) -> Result<OscillatorState, SimulationError> {
        self.validate()?;
        out.y.resize(drive.len(), 0.0);
        out.partials.iter_mut().for_each(|column| column.resize(drive.len(), 0.0));
        let at_rest = first_state(start, drive)?;
        let first = match at_rest {
            None => settle(self, drive, &mut out.y)?,
            Some(first) => first,
        };
        let (end, tangent) = follow(&Motion::of(self), drive, first, out)?;
        if at_rest.is_none() {
            close_period(&tangent, out)?;
        }
        Ok(end.into())
    }
}

/// The motion from the state `first`.
fn follow(
    motion: &Motion,
    drive: &Drive,
    first: State,
    out: &mut Response,
) -> Result<(State, Tangent), SimulationError> {
    let (mut x, mut s) = (first, Tangent::at_start());
    let h = drive.step_s();
    let mut keep = |k: usize, x: &State, s: &Tangent| {
        if let Some(y) = out.y.get_mut(k) {
            *y = x[0];
        }
        for (column, p) in out.partials.iter_mut().zip(s.y) {
            if let Some(slot) = column.get_mut(k) {
                *slot = p;
            }
        }
    };
    keep(0, &x, &s);
    for (k, interval) in drive.intervals().enumerate() {
        for u in interval.steps() {
            (x, s) = motion.step_with_tangent((&x, &s), u, h);
        }
        let sum = s.y.iter().chain(&s.v).chain(&s.z).chain(&x).sum::<f64>();
        if !sum.is_finite() {
            return Err(motion.parameters().overflow(k + 1));
        }
        s.drop_vanished();
        keep(k + 1, &x, &s);
    }
    Ok((x, s))
}

/// Total derivatives of a steady state x₀ = x(T; x₀, θ) from those at fixed x₀: ∂x₀/∂θ = (1 − ∂x(T)/∂x₀)⁻¹
/// ∂x(T)/∂θ.
fn close_period(end: &Tangent, out: &mut Response) -> Result<(), SimulationError> {
    let rows = [&end.y, &end.v, &end.z];
    let left = Matrix3::from_fn(|i, j| f64::from(u8::from(i == j)) - rows[i][PARAMETERS + j]);
    let moved = SMatrix::<f64, 3, PARAMETERS>::from_fn(|i, j| rows[i][j]);
    let first = left.lu().solve(&moved).filter(|m| m.iter().all(|x| x.is_finite()));
    let first = first.ok_or(SimulationError::NotContracting)?;
    let (parameters, states) = out.partials.split_at_mut(PARAMETERS);
    for (j, column) in parameters.iter_mut().enumerate() {
        for (i, state) in states.iter().enumerate() {
            column.iter_mut().zip(state).for_each(|(own, through)| *own += first[(i, j)] * through);
        }
    }
    states.iter_mut().for_each(|column| column.fill(0.0));
    Ok(())
}
