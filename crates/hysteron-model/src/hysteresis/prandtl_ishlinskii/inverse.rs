//! Inverses of the Prandtl–Ishlinskii model: in closed form for a linear polynomial, move by move for any
//! increasing one.

use hysteron_rt::PlayBank;

use super::PrandtlIshlinskii;
use crate::hysteresis::{HysteresisError, Invertibility, polynomial};

impl PrandtlIshlinskii {
    /// The inverse operator of a model with a linear polynomial p₀u, again a Prandtl–Ishlinskii operator,
    /// from v \[µm\] to u \[V\] (thresholds in µm, weights in V/µm). With the partial slopes sᵢ = p₀ + w₁ + …
    /// + wᵢ and the loading curve φ,
    ///
    /// p₀' = 1/p₀,  rᵢ' = φ(rᵢ) = p₀ rᵢ + Σ_{j<i} wⱼ (rᵢ − rⱼ),  wᵢ' = 1/sᵢ − 1/sᵢ₋₁.
    ///
    /// It undoes the model exactly from states that correspond ([`Self::inverse_plays`]); virgin plays at u
    /// correspond to virgin plays at p v with p = p₀ + Σ wᵢ.
    ///
    /// # Errors
    /// Those of [`Self::validate`]; [`HysteresisError::NotLinear`]: see [`Self::step_inverse`];
    /// [`HysteresisError::PartialSlope`] where an sᵢ, i ≥ 0, is not positive: then the model does not
    /// increase with u on every branch and has no inverse.
    pub fn inverse(&self) -> Result<Self, HysteresisError> {
        self.validate()?;
        let mut slope = self.linear_coefficient()?;
        let mut inverse = Self {
            polynomial: vec![1.0 / slope],
            thresholds: Vec::with_capacity(self.thresholds.len()),
            weights: Vec::with_capacity(self.weights.len()),
        };
        positive(0, slope)?;
        let (mut last, mut height) = (0.0, 0.0);
        for ((&threshold, &weight), plays) in self.thresholds.iter().zip(&self.weights).zip(1..) {
            height += slope * (threshold - last);
            let next = slope + weight;
            positive(plays, next)?;
            inverse.thresholds.push(height);
            // 1/sᵢ − 1/sᵢ₋₁ without cancellation.
            inverse.weights.push(-weight / slope / next);
            (last, slope) = (threshold, next);
        }
        inverse.validate()?;
        Ok(inverse)
    }

    /// The states of the plays of [`Self::inverse`] that correspond to the states `plays` of this model, into
    /// `out`: fᵢ' = sᵢ fᵢ + Σ_{j>i} wⱼ fⱼ \[µm\].
    ///
    /// # Errors
    /// [`HysteresisError::NotLinear`]; [`HysteresisError::PlayStates`] where `plays` or `out` does not have
    /// one number per play.
    pub fn inverse_plays(&self, plays: &[f64], out: &mut [f64]) -> Result<(), HysteresisError> {
        let mut slope = self.linear_coefficient()?;
        for found in [plays.len(), out.len()] {
            if found != self.weights.len() {
                return Err(HysteresisError::PlayStates { expected: self.weights.len(), found });
            }
        }
        let mut wider = 0.0;
        for ((state, weight), play) in out.iter_mut().zip(&self.weights).zip(plays).rev() {
            *state = wider;
            wider += weight * play;
        }
        for ((state, weight), play) in out.iter_mut().zip(&self.weights).zip(plays) {
            slope += weight;
            *state += slope * play;
        }
        Ok(())
    }

    /// The inverse move by move, for voltages in `range` \[V\] and a polynomial of any degree.
    ///
    /// # Errors
    /// Those of [`Self::validate`]; [`HysteresisError::Range`]; [`HysteresisError::NotSteep`] where l' + w₁ +
    /// … + w_k is not positive for every k ≥ 0 throughout the range, so that some branch there does not
    /// increase with u.
    pub fn step_inverse(&self, range: [f64; 2]) -> Result<StepInverse<'_>, HysteresisError> {
        self.validate()?;
        let [low, high] = range;
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        let bank = self.bank()?;
        let least = bank.least_slope();
        if let Some(u) = polynomial::not_steeper(&self.polynomial, -least, range) {
            let slope = polynomial::value_and_slope(&self.polynomial, u).1 + least;
            return Err(HysteresisError::NotSteep { u, slope });
        }
        Ok(StepInverse { model: self, bank, range })
    }

    /// Whether every move raises the output over `range` \[V\]: the condition of [`Self::step_inverse`],
    /// exact. `None` for a model or a range that is not valid.
    pub(in crate::hysteresis) fn invertibility(&self, range: [f64; 2]) -> Option<Invertibility> {
        match self.step_inverse(range) {
            Ok(_) => Some(Invertibility::Everywhere),
            Err(HysteresisError::NotSteep { u, .. }) => Some(Invertibility::Nowhere { at_v: u }),
            Err(_) => None,
        }
    }

    fn linear_coefficient(&self) -> Result<f64, HysteresisError> {
        match self.polynomial.split_first() {
            None => Err(HysteresisError::EmptyPolynomial),
            Some((&linear, higher)) => match higher.iter().rposition(|&c| c != 0.0) {
                None => Ok(linear),
                Some(index) => Err(HysteresisError::NotLinear { degree: index + 2 }),
            },
        }
    }
}

fn positive(plays: usize, slope: f64) -> Result<(), HysteresisError> {
    if slope > 0.0 { Ok(()) } else { Err(HysteresisError::PartialSlope { plays, slope }) }
}

/// Share of the range by which a solution may lie outside and count as the end: rounding of v.
const ROUNDING: f64 = 1e-12;

/// Inverse of the model move by move: the voltage that the next move must reach for an output.
///
/// The piece of the move between two breakpoints is found by one scan of the plays ([`PlayBank::piece`]); on
/// it the equation l(u) + slope·u = rest is solved in closed form for a linear polynomial, by safeguarded
/// Newton steps to the last place otherwise. Checked when built: every branch increases throughout the range,
/// so that there is at most one solution.
#[derive(Clone, Copy, Debug)]
pub struct StepInverse<'a> {
    model: &'a PrandtlIshlinskii,
    bank: PlayBank<'a, f64>,
    range: [f64; 2],
}

impl StepInverse<'_> {
    /// The voltage \[V\] to which one monotone move from the states `plays` gives the output `v` \[µm\].
    /// Moves nothing. Allocates nothing.
    ///
    /// # Errors
    /// [`HysteresisError::PlayStates`]; [`HysteresisError::PlayHistory`] for states without a common history;
    /// [`HysteresisError::Drive`] where v or a state is not finite; [`HysteresisError::OutOfReach`] where no
    /// voltage of the range gives v. Samples named are sample 0.
    pub fn solve(&self, plays: &[f64], v: f64) -> Result<f64, HysteresisError> {
        self.solve_at(0, plays, v)
    }

    /// The drive \[V\] for the output `v` \[µm\] into `u` (same length), sample by sample from the states
    /// `plays`, which end at the last sample. Allocates nothing.
    ///
    /// # Errors
    /// Those of [`Self::solve`], with the sample; [`HysteresisError::Lengths`]. `plays` are then those at the
    /// sample before it.
    pub fn follow(&self, v: &[f64], plays: &mut [f64], u: &mut [f64]) -> Result<(), HysteresisError> {
        if u.len() != v.len() {
            return Err(HysteresisError::Lengths { expected: v.len(), found: u.len() });
        }
        for (index, (&v, u)) in v.iter().zip(u).enumerate() {
            *u = self.solve_at(index, plays, v)?;
            self.bank.step(plays, *u).map_err(|error| HysteresisError::at(index, error))?;
        }
        Ok(())
    }

    fn solve_at(&self, index: usize, plays: &[f64], v: f64) -> Result<f64, HysteresisError> {
        let [low, high] = self.range;
        // Breakpoints may lie outside the range; there the polynomial is continued by its tangent, which
        // increases.
        let polynomial = &self.model.polynomial;
        let tangent = |u: f64| {
            let end = u.clamp(low, high);
            let (value, slope) = polynomial::value_and_slope(polynomial, end);
            (value + slope * (u - end), slope)
        };
        let piece =
            self.bank.piece(plays, v, |u| tangent(u).0).map_err(|error| HysteresisError::at(index, error))?;
        let excess = |u: f64| {
            let (value, slope) = tangent(u);
            (value + (piece.slope * u - piece.rest), slope + piece.slope)
        };
        for (end, outwards) in [(low, -1.0), (high, 1.0)] {
            let (value, slope) = excess(end);
            // Distance of the solution beyond the end, on the tangent.
            let beyond = -outwards * value / slope;
            if beyond > 0.0 {
                return if beyond <= ROUNDING * (high - low) {
                    Ok(end)
                } else {
                    let [from, to] = self.reach(plays);
                    Err(HysteresisError::OutOfReach { index, v, from, to })
                };
            }
        }
        let from = piece.low.map_or(low, |from| from.clamp(low, high));
        let to = piece.high.map_or(high, |to| to.clamp(low, high));
        Ok(match polynomial.as_slice() {
            [linear] => (piece.rest / (linear + piece.slope)).max(from).min(to),
            _ => increasing_root(excess, from, to),
        })
    }

    /// Outputs of single moves from `plays` to the ends of the range.
    fn reach(&self, plays: &[f64]) -> [f64; 2] {
        self.range.map(|u| {
            let moved = self.bank.thresholds().iter().zip(self.bank.weights()).zip(plays);
            moved.fold(self.model.polynomial_at(u), |v, ((&r, w), &state)| {
                v + w * hysteron_rt::play(r, state, u)
            })
        })
    }
}

/// Steps of the root search at most; Newton's method takes a few, bisection alone reaches 2⁻²⁰⁰ of the range.
const STEPS: usize = 200;

/// The zero in \[low, high\] of an increasing function given with its derivative, to the last place or so:
/// Newton's method, bisection where a step leaves the bracket or is not at most half the one before the last.
/// The end nearer to it where the function does not change sign.
fn increasing_root(f: impl Fn(f64) -> (f64, f64), mut low: f64, mut high: f64) -> f64 {
    if f(low).0 >= 0.0 {
        return low;
    }
    if f(high).0 <= 0.0 {
        return high;
    }
    let mut u = 0.5 * (low + high);
    let mut moved = [high - low; 2];
    for _ in 0..STEPS {
        let (value, slope) = f(u);
        if value == 0.0 {
            return u;
        }
        if value > 0.0 {
            high = u
        } else {
            low = u
        }
        let newton = u - value / slope;
        if (newton - u).abs() <= f64::EPSILON * u.abs() {
            return newton.clamp(low, high);
        }
        let next = if low < newton && newton < high && (newton - u).abs() <= 0.5 * moved[0] {
            newton
        } else {
            0.5 * (low + high)
        };
        if next <= low || next >= high {
            return next;
        }
        moved = [moved[1], (next - u).abs()];
        u = next;
    }
    u
}
