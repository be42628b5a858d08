//! Plays whose widths grow with the rate of the voltage.
//!
//! Source: M. Al Janaideh, P. Krejčí, "Inverse rate-dependent Prandtl–Ishlinskii model for feedforward compensation of
//! hysteresis in a piezomicropositioning actuator", *IEEE/ASME Trans. Mechatronics* 18 (2013) 1498–1507,
//! doi:10.1109/TMECH.2012.2205265.

use hysteron_rt::Scalar;

use super::columns::{ColumnKernel, between, parameter, positive, simulate_with_sensitivities};
use super::pass::{Every, at_rest};
use super::plays::{PlayStates, check_thresholds};
use super::{HysteresisError, polynomial};
use crate::start::Start;

/// Prandtl–Ishlinskii operator with thresholds that move with the rate:
///
/// v = Σ_{i≥1} polynomial\[i−1\] uⁱ + Σᵢ weightsᵢ Fᵢ,  Fᵢ ← max(u − ρᵢ, min(u + ρᵢ, Fᵢ)),  ρᵢ = rᵢ + λ |u̇|.
///
/// Loops get wider with frequency and amplitude, without dynamics behind them. λ = 0 is [`super::PrandtlIshlinskii`]. All
/// thresholds move by the same, so that their order and what Al Janaideh and Krejčí ask for an inverse (a distance of thresholds
/// that does not shrink) hold for every rate.
///
/// It is *not* rate independent: the rate is that of the straight line between two samples, and the drive is to be sampled so
/// finely that this is its rate.
#[derive(Clone, Debug, PartialEq)]
pub struct RateDependentPrandtlIshlinskii {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\].
    pub polynomial: Vec<f64>,
    /// Half-widths rᵢ at rest \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
    /// Weights of the plays \[µm/V\], of any sign; one a threshold.
    pub weights: Vec<f64>,
    /// λ ≥ 0 \[s\]: what a threshold grows for 1 V/s.
    pub rate_gain_s: f64,
}

/// Columns Fⱼ ← max(u − ρⱼ, min(u + ρⱼ, Fⱼ)) \[V\], ρⱼ = scale · `thresholds`\[j\] + λ |u̇|: the plays of
/// [`RateDependentPrandtlIshlinskii`].
///
/// Shape: `scale`, 1 for the thresholds as they are; `rate_gain` λ ≥ 0 \[s\]. The rate is that of the straight line between two
/// samples; the first move of a device at rest has none. A virgin play stands at its voltage. Where samples are not an equal time
/// apart, their rates are given with the drive ([`super::DriveGrid::rates`]).
#[derive(Clone, Debug, PartialEq)]
pub struct RateDependentPlays {
    /// Half-widths at rest \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
    /// Time from one sample to the next \[s\], where the rates are not given.
    pub interval_s: f64,
}

/// Where plays stand, the voltage of the sample before, if there was one, and the rate of the next move \[V/s\], where it is told.
#[derive(Clone, Debug, PartialEq)]
pub struct RateDependentPlayStates<S> {
    plays: PlayStates<S>,
    before: Option<f64>,
    rate: Option<f64>,
}

impl ColumnKernel for RateDependentPlays {
    type State<S: Scalar<Real = f64>> = RateDependentPlayStates<S>;

    simulate_with_sensitivities!(2);

    fn shape_names(&self) -> &'static [&'static str] {
        &["scale", "rate_gain"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        check_thresholds(&self.thresholds)?;
        positive("time between samples", self.interval_s)?;
        positive("scale of the thresholds", parameter(shape, 0))?;
        check_rate_gain(parameter(shape, 1))
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> RateDependentPlayStates<S> {
        RateDependentPlayStates { plays: PlayStates::at(self.thresholds.len(), u), before: None, rate: None }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut RateDependentPlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let told = state.rate.take();
        let own = state.before.replace(u).map_or(0.0, |before| (u - before).abs() / self.interval_s);
        let rate = told.unwrap_or(own);
        let [scale, wider] = [parameter(shape, 0), parameter(shape, 1).scale(rate)];
        for (play, &threshold) in state.plays.plays.iter_mut().zip(&self.thresholds) {
            let r = scale.scale(threshold) + wider;
            *play = between((-r).shift(u), *play, r.shift(u));
        }
        Ok(())
    }

    fn preceded<S: Scalar<Real = f64>>(state: &mut RateDependentPlayStates<S>, by: Option<f64>) {
        state.before = by;
    }

    fn paced<S: Scalar<Real = f64>>(state: &mut RateDependentPlayStates<S>, rate: f64) {
        state.rate = Some(rate);
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &RateDependentPlayStates<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.plays.plays).for_each(|(out, play)| *out = *play);
    }
}

/// λ ≥ 0.
fn check_rate_gain(value: f64) -> Result<(), HysteresisError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        let (name, must) = ("rate gain λ", "finite and not negative");
        Err(HysteresisError::ShapeParameter { name, value, must })
    }
}

impl RateDependentPrandtlIshlinskii {
    /// A checked operator.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn new(
        polynomial: Vec<f64>,
        thresholds: Vec<f64>,
        weights: Vec<f64>,
        rate_gain_s: f64,
    ) -> Result<Self, HysteresisError> {
        let model = Self { polynomial, thresholds, weights, rate_gain_s };
        model.validate()?;
        Ok(model)
    }

    /// Checks that the polynomial is not empty, every number finite, the thresholds positive and increasing, one weight a
    /// threshold, and λ ≥ 0.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        polynomial::check(&self.polynomial)?;
        check_thresholds(&self.thresholds)?;
        let (thresholds, weights) = (self.thresholds.len(), self.weights.len());
        if thresholds != weights {
            return Err(HysteresisError::PlayCount { thresholds, weights });
        }
        if let Some(index) = self.weights.iter().position(|w| !w.is_finite()) {
            return Err(HysteresisError::Weight { index, value: self.weights[index] });
        }
        check_rate_gain(self.rate_gain_s)
    }

    /// v \[µm\] for the voltages `u` \[V\] at `sample_rate_hz`, of which every `factor`-th is put out: `out[k]` belongs to
    /// `u[k * factor]`. `plays` has one state \[V\] a play, as in [`super::PrandtlIshlinskii::simulate`].
    ///
    /// The first sample is reached without rate from rest; with [`Start::PERIODIC`] it follows the last one.
    /// A period takes the state of a play to what lies next to it in one interval, so that the steady state is reached
    /// after the first; what no sample moves stands in the middle of the drive's range. Allocates nothing.
    ///
    /// # Errors
    /// As [`super::PrandtlIshlinskii::simulate_every`]; [`HysteresisError::ShapeParameter`] for a sample rate that is not
    /// positive.
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        sample_rate_hz: f64,
        start: Start<f64>,
        plays: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        self.validate()?;
        positive("sample rate", sample_rate_hz)?;
        let mut every = Every::new(factor)?;
        let expected = u.len().div_ceil(factor);
        if out.len() != expected {
            return Err(HysteresisError::Lengths { expected, found: out.len() });
        }
        if plays.len() != self.weights.len() {
            return Err(HysteresisError::PlayStates { expected: self.weights.len(), found: plays.len() });
        }
        if let Some(index) = u.iter().position(|u| !u.is_finite()) {
            return Err(HysteresisError::Drive { index });
        }
        let (Some(&first), Some(&last)) = (u.first(), u.last()) else { return Ok(()) };
        let mut before = first;
        match at_rest(start, u)? {
            Some((rest, None)) => plays.fill(rest),
            Some((rest, Some(virgin))) => {
                // Without rate, as the first sample is reached.
                for (play, &r) in plays.iter_mut().zip(&self.thresholds) {
                    *play = hysteron_rt::play(r, virgin, rest);
                }
            }
            None => {
                let [low, high] = u.iter().fold([first; 2], |[low, high], &u| [low.min(u), high.max(u)]);
                plays.fill(0.5 * low + 0.5 * high);
                before = last;
                for &u in u {
                    self.step(plays, before, u, sample_rate_hz);
                    before = u;
                }
            }
        }
        if !plays.iter().all(|play| play.is_finite()) {
            return Err(HysteresisError::Drive { index: 0 });
        }
        let mut slots = out.iter_mut();
        for (index, &u) in u.iter().enumerate() {
            let sum = self.step(plays, before, u, sample_rate_hz);
            before = u;
            if every.take()
                && let Some(slot) = slots.next()
            {
                *slot = polynomial::value(&self.polynomial, u) + sum;
                if !slot.is_finite() {
                    return Err(HysteresisError::Overflow { index });
                }
            }
        }
        Ok(())
    }

    /// Moves the plays from the voltage `before` to `u` within one sample and returns Σ wᵢ Fᵢ.
    fn step(&self, plays: &mut [f64], before: f64, u: f64, sample_rate_hz: f64) -> f64 {
        let wider = self.rate_gain_s * ((u - before) * sample_rate_hz).abs();
        let mut sum = 0.0;
        for ((play, r), weight) in plays.iter_mut().zip(&self.thresholds).zip(&self.weights) {
            *play = hysteron_rt::play(r + wider, *play, u);
            sum += weight * *play;
        }
        sum
    }
}
