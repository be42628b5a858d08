//! Plays whose widths grow with the rate of the voltage.
//!
//! Source: M. Al Janaideh, P. Krejčí, "Inverse rate-dependent Prandtl–Ishlinskii model for feedforward
//! compensation of hysteresis in a piezomicropositioning actuator", *IEEE/ASME Trans. Mechatronics* 18 (2013)
//! 1498–1507, doi:10.1109/TMECH.2012.2205265.

use hysteron_rt::{Scalar, Sides};

use super::HysteresisError;
use super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, MOST_ELEMENTS, NumberUnit, RuntimeOperator, Search,
    ShapeNumber,
};
use super::plays::{PlayStates, check_thresholds, evenly_below, scaled};
use crate::record::{Dependence, Pace};

/// Columns Fⱼ ← max(u − ρⱼ, min(u + ρⱼ, Fⱼ)) \[V\], ρⱼ = scale · `thresholds`\[j\] + λ |u̇|.
///
/// Loops get wider with frequency and amplitude, without dynamics behind them. λ = 0 is
/// [`super::PlaySum`]. All thresholds shift equally, so that their order and Al Janaideh and
/// Krejčí's condition for an inverse (distances of thresholds that do not shrink) hold for every rate. The
/// operator is *not* rate independent.
///
/// Shape: `scale`, 1 for unscaled thresholds; `rate_gain` λ ≥ 0 \[s\]. The rate is that of the straight line
/// between two samples; the first move of a device at rest has none. A virgin play stands at its voltage. For
/// unevenly spaced samples the rates are given with the drive ([`super::DriveGrid::paces`]).
#[derive(Clone, Debug, PartialEq)]
pub struct RateDependentPlays {
    /// Half-widths at rest \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
    /// Time from one sample to the next \[s\], where the rates are not given.
    pub interval_s: f64,
}

/// States of the plays, the voltage of the previous sample, if any, and the rate of the next move \[V/s\], if
/// given.
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
        let thresholds = scaled(&self.thresholds, parameter(shape, 0));
        let widening = parameter(shape, 1);
        let _ =
            Sides::Even { widening }.advance(thresholds, &mut state.plays.plays, [S::constant(u); 2], rate);
        Ok(())
    }

    fn preceded<S: Scalar<Real = f64>>(state: &mut RateDependentPlayStates<S>, by: Option<f64>) {
        state.before = by;
    }

    fn paced<S: Scalar<Real = f64>>(state: &mut RateDependentPlayStates<S>, pace: Pace) {
        state.rate = Some(pace.rate);
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &RateDependentPlayStates<S>, out: &mut [S]) {
        state.plays.read(out);
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

/// The family: half-widths `scale` · j/(plays + 1) at rest.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "rate-dependent-plays"
    }

    fn summary(&self) -> &'static str {
        "12 plays that get wider with the rate of the drive"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j F_j, F_j <- max(u - r_j, min(u + r_j, F_j)), r_j = scale j/(number + 1) + rate_gain \
         |du/dt|"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 12, most: MOST_ELEMENTS })
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let scale = Search::Held(0.5 * span.stroke);
        // A play at the fastest drive is wider by λ times its rate.
        let gain = Search::Linear(0.0, 1.0 / span.fastest_rate);
        vec![
            ShapeNumber::new("scale", NumberUnit::INPUT, "half-width beyond the widest play", scale),
            ShapeNumber::new("rate_gain", NumberUnit::TIME, "half-width gained by the rate", gain),
        ]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        [0.0, 0.1, 0.4].map(|wider| vec![0.5 * span.stroke, wider / span.fastest_rate]).into()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![0.31 * span.stroke, 0.1 / span.fastest_rate]
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn depends_on(&self) -> Dependence {
        Dependence::Rate
    }

    /// By λ/T − 1 for each volt of a move, T the time between samples: the plays that it widens.
    fn pushes_back(&self, shape: &[f64], weights: &[f64], interval_s: Option<f64>) -> Option<f64> {
        let rate_gain: f64 = parameter(shape, 1);
        Some(weights.iter().sum::<f64>() * (rate_gain / interval_s? - 1.0).max(0.0))
    }

    fn runtime(
        &self,
        plays: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        sample_rate_hz: f64,
    ) -> RuntimeOperator {
        let [scale, rate_gain] = [0, 1].map(|index| parameter::<f64>(shape, index));
        let thresholds = evenly_below(scale, plays);
        RuntimeOperator::sided(Sides::Even { widening: rate_gain * sample_rate_hz }, thresholds, weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = RateDependentPlays;

    fn kernel(&self, plays: usize, _: &[f64], interval_s: f64) -> RateDependentPlays {
        RateDependentPlays { thresholds: evenly_below(1.0, plays), interval_s }
    }
}
