//! Bouc–Wen operator, one monotone move at a time.

mod error;
mod increment;
mod linear;
mod power;
mod quadratic;

pub use error::{SimulateError, StepError};

use crate::ParameterError;
use crate::dual::Dual;
use crate::real::{Real, Scalar};

/// Parameters of the Bouc–Wen operator ż = α u̇ − β |u̇| z |z|ⁿ⁻¹ − γ u̇ |z|ⁿ, n ≥ 1 (article Eq. 1).
///
/// Between two samples u moves monotonically, so z obeys dz/du = α − β s z|z|ⁿ⁻¹ − γ |z|ⁿ with s = sign Δu
/// and depends on the two voltages alone. n = 1 is solved by exponentials, n = 2 by tanh or tan, any other n
/// by Taylor series to the last place; each is split where z passes 0.
///
/// Units: u in V, z in µm; α µm/V, β and γ µm^(1−n)/V. Any other consistent set will do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoucWen<T> {
    alpha: T,
    beta: T,
    gamma: T,
    n: T,
    law: Law,
}

/// C99 templates ([`crate::c_source`]): the type of the parameters, the increment, the operator of states in
/// parallel, and its lines of the header.
pub(crate) const C_PARAMETERS: &str = include_str!("parameters.c");
pub(crate) const C_INCREMENT: &str =
    concat!(include_str!("linear.c"), include_str!("quadratic.c"), include_str!("power.c"));
pub(crate) const C_OPERATOR: &str = include_str!("operator.c");
pub(crate) const C_HEADER: &str = include_str!("operator.h");

/// Which closed form applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Law {
    Linear,
    Quadratic,
    Power,
}

fn law_of<T: Real>(n: T) -> Law {
    if n == T::of(1.0) {
        Law::Linear
    } else if n == T::of(2.0) {
        Law::Quadratic
    } else {
        Law::Power
    }
}

/// State of the operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoucWenState<T> {
    /// Present voltage \[V\].
    pub u: T,
    /// Present hysteretic displacement \[µm\].
    pub z: T,
}

/// End of a leg on which z keeps its sign.
enum Leg<S> {
    /// |z| at the end of the distance.
    End(S),
    /// z reached 0 with this much of the distance left.
    Zero { rest: S },
}

impl<T: Real> BoucWen<T> {
    /// Names of the parameters; all but the last may change while a model runs, n chooses the closed form.
    pub const PARAMETERS: [&'static str; 4] = ["alpha", "beta", "gamma", "n"];

    /// The operator with these parameters in the order of [`Self::PARAMETERS`].
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn of([alpha, beta, gamma, n]: [T; 4]) -> Result<Self, ParameterError<T>> {
        Self::new(alpha, beta, gamma, n)
    }

    /// The operator with these parameters; no restriction but finite and n ≥ 1 (an inadmissible set may make
    /// [`Self::step`] fail later).
    ///
    /// # Errors
    /// [`ParameterError`] where a parameter is not finite or n < 1.
    pub fn new(alpha: T, beta: T, gamma: T, n: T) -> Result<Self, ParameterError<T>> {
        for (name, value) in Self::PARAMETERS.into_iter().zip([alpha, beta, gamma, n]) {
            if !value.is_finite() {
                return Err(ParameterError::NotFinite { name, value });
            }
        }
        if n < T::of(1.0) {
            return Err(ParameterError::Exponent { n });
        }
        Ok(Self { alpha, beta, gamma, n, law: law_of(n) })
    }

    /// The unit-α form ζ̇ = u̇ − β' |u̇| ζ |ζ|ⁿ⁻¹ − γ' u̇ |ζ|ⁿ, z = α ζ, with β' = β|α|ⁿ⁻¹, γ' = sign(α) γ
    /// |α|ⁿ⁻¹.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn unit(beta: T, gamma: T, n: T) -> Result<Self, ParameterError<T>> {
        Self::new(T::of(1.0), beta, gamma, n)
    }

    /// α.
    pub fn alpha(&self) -> T {
        self.alpha
    }

    /// β.
    pub fn beta(&self) -> T {
        self.beta
    }

    /// γ.
    pub fn gamma(&self) -> T {
        self.gamma
    }

    /// n.
    pub fn n(&self) -> T {
        self.n
    }

    /// Moves `state` monotonically to `u_next` and returns the new z. On an error the state is left as it
    /// was.
    ///
    /// # Errors
    /// [`StepError`]: a number that is not finite, or z unbounded within the move (inadmissible parameters
    /// only).
    #[inline]
    pub fn step(&self, state: &mut BoucWenState<T>, u_next: T) -> Result<T, StepError<T>> {
        if !u_next.is_finite() || !state.u.is_finite() {
            return Err(StepError::NotFinite);
        }
        let z = self.advance(state.z, u_next - state.u)?;
        *state = BoucWenState { u: u_next, z };
        Ok(z)
    }

    /// z after a monotone move by `du` from `z`.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    #[inline]
    pub fn advance(&self, z: T, du: T) -> Result<T, StepError<T>> {
        self.finite(advance(self.law, [self.alpha, self.beta, self.gamma, self.n], z, du)?, z)
    }

    /// [`Self::advance`] with forward sensitivities: `z.partials` are ∂z/∂β, ∂z/∂γ, then any others carried
    /// by z (for its initial value, say). Exact closed forms for n = 1 and 2. In the unit-α form the first
    /// two are the ∂ζ/∂β', ∂ζ/∂γ' that a fit needs.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    pub fn advance_with_shape<const P: usize>(
        &self,
        z: Dual<T, P>,
        du: T,
    ) -> Result<Dual<T, P>, StepError<T>> {
        self.finite(advance(self.law, self.duals(false), z, du)?, z)
    }

    /// [`Self::advance`] with forward sensitivities: `z.partials` are ∂z/∂β, ∂z/∂γ, ∂z/∂n, then any others
    /// carried by z. ∂z/∂n has no closed form: every n uses the series.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    pub fn advance_with_sensitivities<const P: usize>(
        &self,
        z: Dual<T, P>,
        du: T,
    ) -> Result<Dual<T, P>, StepError<T>> {
        self.finite(advance(Law::Power, self.duals(true), z, du)?, z)
    }

    /// ζ of the unit-α form after a monotone move by `du`, with β' and γ' that carry their derivatives. n ≥ 1
    /// is a plain number: closed forms for 1 and 2.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    pub fn advance_unit<S: Scalar<Real = T>>(
        beta: S,
        gamma: S,
        n: T,
        zeta: S,
        du: T,
    ) -> Result<S, StepError<T>> {
        let constant = |value| S::constant(T::of(value));
        let unit = Self { alpha: T::of(1.0), beta: beta.value(), gamma: gamma.value(), n, law: law_of(n) };
        unit.finite(advance(unit.law, [constant(1.0), beta, gamma, S::constant(n)], zeta, du)?, zeta)
    }

    /// z along the voltages `u` into `out` (same length), from `state`, which ends at the last sample: equal
    /// to [`Self::step`] sample by sample.
    ///
    /// # Errors
    /// [`SimulateError`]: lengths that differ, or the sample and the [`StepError`] it failed with; `out` is
    /// then filled up to that sample and `state` left as it was.
    pub fn simulate(
        &self,
        state: &mut BoucWenState<T>,
        u: &[T],
        out: &mut [T],
    ) -> Result<(), SimulateError<T>> {
        self.simulate_every(1, state, u, out)
    }

    /// [`Self::simulate`] on an input sampled `factor` times faster: `out[k]` is z at `u[k * factor]`; u is
    /// followed to its end. `out` has ⌈len u / factor⌉ samples.
    ///
    /// # Errors
    /// Those of [`Self::simulate`], with the index of a sample in `u`. A factor of 0 counts as a mismatch of
    /// lengths.
    pub fn simulate_every(
        &self,
        factor: usize,
        state: &mut BoucWenState<T>,
        u: &[T],
        out: &mut [T],
    ) -> Result<(), SimulateError<T>> {
        let expected = if factor == 0 { 0 } else { u.len().div_ceil(factor) };
        if out.len() != expected || (factor == 0 && !u.is_empty()) {
            return Err(SimulateError::Lengths { expected, found: out.len() });
        }
        let Some(&u_end) = u.last() else { return Ok(()) };
        let start = (state.u, Dual { value: state.z, partials: [] });
        let mut slots = out.iter_mut();
        let mut keep = |z| {
            if let Some(slot) = slots.next() {
                *slot = z;
            }
        };
        let end = if factor == 1 {
            self.simulate_with_shape(start, u, |z| keep(z.value))
        } else {
            let mut until = 0;
            self.simulate_with_shape(start, u, |z| {
                if until == 0 {
                    until = factor;
                    keep(z.value);
                }
                until -= 1;
            })
        };
        *state = BoucWenState { u: u_end, z: end?.value };
        Ok(())
    }

    /// z with derivatives as in [`Self::advance_with_shape`] along the voltages `u`, from z at the voltage of
    /// `start`; `sink` receives each sample's in turn. Returns the last.
    ///
    /// # Errors
    /// The sample and the [`StepError`] it failed with; values passed to `sink` from that sample on are
    /// invalid.
    pub fn simulate_with_shape<const P: usize>(
        &self,
        start: (T, Dual<T, P>),
        u: &[T],
        sink: impl FnMut(Dual<T, P>),
    ) -> Result<Dual<T, P>, SimulateError<T>> {
        follow(start, u, |z, du| self.advance_with_shape(z, du), sink)
    }

    /// [`Self::simulate_with_shape`] with the sensitivities of [`Self::advance_with_sensitivities`], to n
    /// too.
    ///
    /// # Errors
    /// Those of [`Self::simulate_with_shape`].
    pub fn simulate_with_sensitivities<const P: usize>(
        &self,
        start: (T, Dual<T, P>),
        u: &[T],
        sink: impl FnMut(Dual<T, P>),
    ) -> Result<Dual<T, P>, SimulateError<T>> {
        follow(start, u, |z, du| self.advance_with_sensitivities(z, du), sink)
    }

    /// (α, β, γ, n) as duals: β is parameter 0, γ 1, and n 2 where `exponent` is set.
    #[inline(always)]
    fn duals<const P: usize>(&self, exponent: bool) -> [Dual<T, P>; 4] {
        let n = if exponent { Dual::variable(self.n, 2) } else { Dual::constant(self.n) };
        [Dual::constant(self.alpha), Dual::variable(self.beta, 0), Dual::variable(self.gamma, 1), n]
    }

    /// `end`, if its value and derivatives are finite.
    #[inline(always)]
    fn finite<S: Scalar<Real = T>>(&self, end: S, start: S) -> Result<S, StepError<T>> {
        if end.magnitude().is_finite() {
            Ok(end)
        } else if start.magnitude().is_finite() {
            Err(StepError::Overflow)
        } else {
            Err(StepError::NotFinite)
        }
    }
}

/// Change of z of the unit-α form for n = 1 in a monotone move by `du`. Not finite where there is no finite
/// result.
#[inline(always)]
pub(crate) fn unit_increment<S: Scalar>(beta: S, gamma: S, z: S, du: S) -> S {
    linear::increment(S::constant(S::Real::of(1.0)), beta, gamma, z, du)
}

/// z along the voltages `u`, one `advance` a sample.
#[inline(always)]
fn follow<T: Real, const P: usize>(
    (mut u_last, mut z): (T, Dual<T, P>),
    u: &[T],
    mut advance: impl FnMut(Dual<T, P>, T) -> Result<Dual<T, P>, StepError<T>>,
    mut sink: impl FnMut(Dual<T, P>),
) -> Result<Dual<T, P>, SimulateError<T>> {
    for (index, &u_next) in u.iter().enumerate() {
        let step = |cause| SimulateError::Step { index, cause };
        if !u_next.is_finite() || !u_last.is_finite() {
            return Err(step(StepError::NotFinite));
        }
        z = advance(z, u_next - u_last).map_err(step)?.without_vanished(0);
        u_last = u_next;
        sink(z);
    }
    Ok(z)
}

/// z after a monotone move by `du`; parameters are (α, β, γ, n).
#[inline]
fn advance<S: Scalar>(
    law: Law,
    [alpha, beta, gamma, n]: [S; 4],
    z: S,
    du: S::Real,
) -> Result<S, StepError<S::Real>> {
    if law == Law::Linear {
        return Ok(z + linear::increment(alpha, beta, gamma, z, S::constant(du)));
    }
    let zero = S::Real::of(0.0);
    if du == zero {
        return Ok(z);
    }
    let leg = |a: S, kappa: S, w: S, h: S| match law {
        Law::Quadratic => quadratic::leg(a, kappa, w, h),
        _ => power::leg(a, kappa, n, w, h),
    };
    // dz/d|u| = sα − (sign z) κ |z|ⁿ with κ = β + (s sign z) γ.
    let down = du < zero;
    let rise = if down { -alpha } else { alpha };
    let lead = if z.value() == zero { rise.value() } else { z.value() };
    let negative = lead < zero;
    let mirror = |x: S| if negative { -x } else { x };
    let kappa = if down == negative { beta + gamma } else { beta - gamma };
    let distance = du.abs();
    let signed = |after: S::Real| if down { -after } else { after };
    let rest = match leg(mirror(rise), kappa, mirror(z), S::constant(distance)) {
        Ok(Leg::End(w)) => return Ok(mirror(w)),
        Ok(Leg::Zero { rest }) => rest,
        Err(StepError::BlowUp { after }) => return Err(StepError::BlowUp { after: signed(after) }),
        Err(error) => return Err(error),
    };
    // From 0 on, z has the sign of the rise.
    let (size, kappa) = if alpha.value() < zero { (-alpha, beta - gamma) } else { (alpha, beta + gamma) };
    match leg(size, kappa, S::constant(zero), rest) {
        Ok(Leg::End(w) | Leg::Zero { rest: w }) => Ok(if rise.value() < zero { -w } else { w }),
        Err(StepError::BlowUp { after }) => {
            Err(StepError::BlowUp { after: signed(distance - rest.value() + after) })
        }
        Err(error) => Err(error),
    }
}
