//! The (improved) Bouc–Wen model, article Eq. 1.
//!
//! Sources: article Eq. 1; Y.-K. Wen, *J. Eng. Mech. Div. ASCE* 102 (1976) 249–263; the unit-α form and the
//! bounded class after F. Ikhouane, J. Rodellar, *Systems with Hysteresis*, Wiley 2007,
//! doi:10.1002/9780470513200.

mod admissibility;
mod family;
mod pass;
mod sensitivities;

pub use admissibility::Admissibility;
pub(super) use family::Entry;
pub use sensitivities::Sensitivities;

use hysteron_rt::Dual;

use self::pass::pass;
use super::pass::{Every, at_rest};
use super::{HysteresisError, polynomial};
use crate::start::Start;

/// State of a Bouc–Wen operator: present voltage u \[V\] and hysteretic displacement z \[µm\].
pub type BoucWenState = hysteron_rt::BoucWenState<f64>;

impl From<BoucWenState> for Start<f64> {
    /// At rest at u with the memory z.
    fn from(state: BoucWenState) -> Self {
        Self::Remembering { voltage_v: state.u, memory: state.z }
    }
}

/// Improved Bouc–Wen operator, article Eq. 1 with a polynomial of any degree:
///
/// v = Σ_{i≥1} polynomial\[i−1\] uⁱ − z,  ż = α u̇ − β |u̇| z |z|ⁿ⁻¹ − γ u̇ |z|ⁿ,  n ≥ 1.
///
/// z is stepped exactly from sample to sample ([`hysteron_rt::BoucWen`]): the result does not depend on the
/// sample rate as long as every turning point of u is a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct BoucWen {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\]; no constant term (the model's one offset is elsewhere).
    pub polynomial: Vec<f64>,
    /// Size of the loop \[µm/V\].
    pub alpha: f64,
    /// Shape of the loop \[µm^(1−n)/V\], factor of |u̇| z |z|ⁿ⁻¹.
    pub beta: f64,
    /// Shape of the loop, factor of u̇ |z|ⁿ; same unit as `beta`.
    pub gamma: f64,
    /// Smoothness of the transition, ≥ 1.
    pub n: f64,
}

/// The numbers that enter a Bouc–Wen model nonlinearly: ζ̇ = u̇ − β' |u̇| ζ |ζ|ⁿ⁻¹ − γ' u̇ |ζ|ⁿ, z = α ζ
/// (`docs/theory/bouc-wen.md`).
///
/// ζ is in V; β' and γ' in V⁻ⁿ. The output v = Σ polynomial\[i−1\] uⁱ − α ζ is linear in everything else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitShape {
    /// β' = β|α|ⁿ⁻¹ \[V⁻ⁿ\].
    pub beta: f64,
    /// γ' = sign(α) γ |α|ⁿ⁻¹ \[V⁻ⁿ\].
    pub gamma: f64,
    /// n ≥ 1.
    pub n: f64,
}

impl BoucWen {
    /// A checked operator.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn new(
        polynomial: Vec<f64>,
        alpha: f64,
        beta: f64,
        gamma: f64,
        n: f64,
    ) -> Result<Self, HysteresisError> {
        let model = Self { polynomial, alpha, beta, gamma, n };
        model.validate()?;
        Ok(model)
    }

    /// The operator with loop size `alpha` and the shape of a unit-α form: β = β'|α|¹⁻ⁿ, γ = sign(α)
    /// γ'|α|¹⁻ⁿ.
    ///
    /// # Errors
    /// Those of [`Self::validate`]; with α = 0 the article's β and γ exist for n = 1 only.
    pub fn from_unit(polynomial: Vec<f64>, alpha: f64, shape: UnitShape) -> Result<Self, HysteresisError> {
        let UnitShape { beta, gamma, n } = shape.scaled(alpha, 1.0 - shape.n);
        Self::new(polynomial, alpha, beta, gamma, n)
    }

    /// The shape of the unit-α form: β' = β|α|ⁿ⁻¹, γ' = sign(α) γ |α|ⁿ⁻¹.
    pub fn unit_shape(&self) -> UnitShape {
        UnitShape { beta: self.beta, gamma: self.gamma, n: self.n }.scaled(self.alpha, self.n - 1.0)
    }

    /// Checks that every parameter is finite, n ≥ 1 and the polynomial not empty.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        polynomial::check(&self.polynomial)?;
        self.operator().map(|_| ())
    }

    /// The streaming operator for z.
    ///
    /// # Errors
    /// [`HysteresisError::Parameter`] or [`HysteresisError::Exponent`].
    pub fn operator(&self) -> Result<hysteron_rt::BoucWen<f64>, HysteresisError> {
        Ok(hysteron_rt::BoucWen::new(self.alpha, self.beta, self.gamma, self.n)?)
    }

    /// Boundedness of z.
    pub fn admissibility(&self) -> Admissibility {
        self.unit_shape().admissibility()
    }

    /// The anhysteretic polynomial l\[u\] = Σ polynomial\[i−1\] uⁱ \[µm\] at `u` \[V\].
    pub fn polynomial_at(&self, u: f64) -> f64 {
        polynomial::value(&self.polynomial, u)
    }

    /// v = l\[u\] − z \[µm\] for the voltages `u` \[V\] into `out` (same length); returns the state at the
    /// last sample. Allocates nothing.
    ///
    /// # Errors
    /// Parameters as in [`Self::validate`]; [`HysteresisError::Lengths`]; [`HysteresisError::Drive`] where u
    /// is not finite; [`HysteresisError::RunsAway`] for inadmissible parameters;
    /// [`HysteresisError::NotSettled`] for [`Start::PERIODIC`].
    pub fn simulate(
        &self,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<BoucWenState, HysteresisError> {
        self.simulate_every(1, u, start, out)
    }

    /// [`Self::simulate`] for a drive given on a time base finer by `factor`: `out[k]` belongs to `u[k *
    /// factor]`.
    ///
    /// # Errors
    /// Those of [`Self::simulate`].
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<BoucWenState, HysteresisError> {
        self.validate()?;
        let end = run(&self.operator()?, factor, u, start, out, |z, slot| *slot = z)?;
        for (v, &u) in out.iter_mut().zip(u.iter().step_by(factor)) {
            *v = self.polynomial_at(u) - *v;
        }
        Ok(end)
    }
}

impl UnitShape {
    /// β and γ times |α| to this power, and γ times the sign of α.
    fn scaled(self, alpha: f64, power: f64) -> Self {
        let size = alpha.abs().powf(power);
        Self { beta: self.beta * size, gamma: sign(alpha) * self.gamma * size, n: self.n }
    }

    /// The streaming operator for ζ.
    ///
    /// # Errors
    /// [`HysteresisError::Parameter`] or [`HysteresisError::Exponent`].
    pub fn operator(&self) -> Result<hysteron_rt::BoucWen<f64>, HysteresisError> {
        Ok(hysteron_rt::BoucWen::unit(self.beta, self.gamma, self.n)?)
    }

    /// ζ \[V\] into `out` for the voltages `u` \[V\] given on a time base finer by `factor`: `out[k]` belongs
    /// to `u[k * factor]`. Returns the state (u, ζ) at the last sample of u. Allocates nothing.
    ///
    /// # Errors
    /// Those of [`BoucWen::simulate`].
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<BoucWenState, HysteresisError> {
        run(&self.operator()?, factor, u, start, out, |zeta, slot| *slot = zeta)
    }

    /// Boundedness of ζ.
    pub fn admissibility(&self) -> Admissibility {
        Admissibility::of(*self)
    }
}

/// +1 for α ≥ 0, −1 for α < 0.
fn sign(alpha: f64) -> f64 {
    if alpha < 0.0 { -1.0 } else { 1.0 }
}

/// z along `u` from any start, each value `put` into its place of `out`.
fn run(
    operator: &hysteron_rt::BoucWen<f64>,
    factor: usize,
    u: &[f64],
    start: Start<f64>,
    out: &mut [f64],
    put: impl Fn(f64, &mut f64),
) -> Result<BoucWenState, HysteresisError> {
    let mut every = Every::new(factor)?;
    let expected = u.len().div_ceil(factor);
    if out.len() != expected {
        return Err(HysteresisError::Lengths { expected, found: out.len() });
    }
    let state = match at_rest(start, u)? {
        Some((u_rest, memory)) => BoucWenState { u: u_rest, z: memory.unwrap_or(0.0) },
        None => settled(operator, u)?,
    };
    let mut slots = out.iter_mut();
    let end = pass(operator, (state.u, Dual { value: state.z, partials: [] }), u, |z| {
        if every.take()
            && let Some(slot) = slots.next()
        {
            put(z.value, slot);
        }
    })?;
    Ok(BoucWenState { u: u.last().copied().unwrap_or(state.u), z: end.value })
}

/// Periods simulated at most to find a steady state.
const PERIODS: usize = 200;

/// State at the beginning of a period in steady state, by the secant method on z(end of period) − z(start):
/// the return map is increasing and, in the bounded class, a contraction, often so weak (small loops) that
/// mere repetition would take thousands of periods.
fn settled(operator: &hysteron_rt::BoucWen<f64>, u: &[f64]) -> Result<BoucWenState, HysteresisError> {
    let Some(&u_last) = u.last() else {
        return Ok(BoucWenState { u: 0.0, z: 0.0 });
    };
    let mut before: Option<(f64, f64)> = None;
    let mut z: f64 = 0.0;
    let mut change = f64::INFINITY;
    for _ in 0..PERIODS {
        let mut size = z.abs();
        let start = (u_last, Dual { value: z, partials: [] });
        let end = pass(operator, start, u, |z: Dual<f64, 0>| size = size.max(z.value.abs()))?.value;
        change = end - z;
        if change.abs() <= 1e-13 * size {
            return Ok(BoucWenState { u: u_last, z });
        }
        let secant = match before {
            Some((z_before, change_before)) if change.abs() < change_before.abs() => {
                z - change * (z - z_before) / (change - change_before)
            }
            _ => end,
        };
        before = Some((z, change));
        z = if secant.is_finite() { secant } else { end };
    }
    Err(HysteresisError::NotSettled { periods: PERIODS, change })
}
