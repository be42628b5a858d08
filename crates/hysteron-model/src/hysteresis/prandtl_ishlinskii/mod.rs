//! The Prandtl–Ishlinskii model: a polynomial and a weighted sum of play (backlash) operators.
//!
//! Sources: M. Brokate, J. Sprekels, *Hysteresis and Phase Transitions*, Springer 1996,
//! doi:10.1007/978-1-4612-4048-8; the inverse after P. Krejčí, K. Kuhnen, *IEE Proc. Control Theory Appl.*
//! 148 (2001) 185–192, doi:10.1049/ip-cta:20010375.

mod columns;
pub(in crate::hysteresis) mod density;
mod inverse;

pub use inverse::StepInverse;

use columns::Plays;

use hysteron_rt::{PlayBank, PlayError, play};

use super::family::{
    ColumnFamily, ColumnOperators, DriveSpan, Elements, FamilyDescription, MOST_ELEMENTS, NumberUnit,
    RuntimeOperator, Search, ShapeNumber, WHOLE_SHAPE, in_a_row,
};
use super::outputs::Columns;
use super::pass::{Every, at_rest};
use super::play_sums;
use super::{DriveGrid, Hysteresis, HysteresisError, HysteresisForm, polynomial};
use crate::start::Start;

/// Prandtl–Ishlinskii operator with a polynomial of any degree:
///
/// v = Σ_{i≥1} polynomial\[i−1\] uⁱ + Σᵢ weightsᵢ F_rᵢ\[u\],  F_r ← max(u − r, min(u + r, F_r)),
///
/// with half-widths 0 < r₁ < r₂ < … Each play is stepped exactly from sample to sample
/// ([`hysteron_rt::PlayBank`]): the result does not depend on the sample rate as long as every turning point
/// of u is a sample.
///
/// The states of the plays are the whole memory. The caller keeps them, one number \[V\] per play, in the
/// order of the thresholds.
///
/// ```
/// use hysteron_model::{Start, hysteresis::PrandtlIshlinskii};
///
/// // One play of half-width 1 V beside a straight line: on the way back nothing but the line moves for 2 V.
/// let model = PrandtlIshlinskii::new(vec![1.0], vec![1.0], vec![2.0])?;
/// let (mut plays, mut v) = ([0.0], [0.0; 4]);
/// model.simulate(&[3.0, 2.0, 1.0, 0.0], Start::Rest { voltage_v: 0.0 }, &mut plays, &mut v)?;
/// assert_eq!(v, [7.0, 6.0, 5.0, 2.0]);
/// # Ok::<(), hysteron_model::hysteresis::HysteresisError>(())
/// ```
/// The memory of a [`Start::Remembering`] is the voltage \[V\] at which the device was virgin before it moved
/// monotonically to its rest voltage. The steady state under a drive that repeats is reached exactly, to the
/// last bit, after one period. With M and m the largest and least voltage: a play with 2r ≤ M − m stands at M
/// − r whenever u passes M and at m + r whenever u passes m, whatever it did before; a wider one is within
/// \[M − r, m + r\] once u has passed both, and no voltage of the drive moves it from there. The drive does
/// not determine where in this interval a wide play is: it is set to (M + m)/2, where a drive that decayed to
/// this one from large amplitudes leaves it.
#[derive(Clone, Debug, PartialEq)]
pub struct PrandtlIshlinskii {
    /// Coefficients of u, u², … \[µm/V, µm/V², …\]; no constant term (the model's one offset is elsewhere).
    pub polynomial: Vec<f64>,
    /// Half-widths rᵢ of the plays \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
    /// Weights of the plays \[µm/V\], of any sign; one per threshold.
    pub weights: Vec<f64>,
}

impl PrandtlIshlinskii {
    /// A checked operator.
    ///
    /// # Errors
    /// Those of [`Self::validate`].
    pub fn new(
        polynomial: Vec<f64>,
        thresholds: Vec<f64>,
        weights: Vec<f64>,
    ) -> Result<Self, HysteresisError> {
        let model = Self { polynomial, thresholds, weights };
        model.validate()?;
        Ok(model)
    }

    /// Checks that the polynomial is not empty, every number finite, the thresholds positive and increasing,
    /// and that there is one weight per threshold.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        polynomial::check(&self.polynomial)?;
        self.bank().map(|_| ())
    }

    /// The streaming operator for Σ weightsᵢ F_rᵢ.
    ///
    /// # Errors
    /// [`HysteresisError::PlayCount`], [`HysteresisError::Threshold`] or [`HysteresisError::Weight`].
    pub fn bank(&self) -> Result<PlayBank<'_, f64>, HysteresisError> {
        Ok(PlayBank::new(&self.thresholds, &self.weights)?)
    }

    /// The polynomial l\[u\] = Σ polynomial\[i−1\] uⁱ \[µm\] at `u` \[V\].
    pub fn polynomial_at(&self, u: f64) -> f64 {
        polynomial::value(&self.polynomial, u)
    }

    /// Initial loading curve φ(u) = l\[u\] + Σ weightsᵢ sign(u) max(|u| − rᵢ, 0) \[µm\]: the output after a
    /// monotone move from rest at 0 V to `u` \[V\]. For a linear polynomial its inverse function is the
    /// loading curve of [`Self::inverse`].
    pub fn loading_curve(&self, u: f64) -> f64 {
        let plays = self.thresholds.iter().zip(&self.weights);
        plays.fold(self.polynomial_at(u), |v, (r, w)| v + w * (u.abs() - r).max(0.0).copysign(u))
    }

    /// v \[µm\] for the voltages `u` \[V\] into `out` (same length). `plays` has one state per play,
    /// arbitrary before and that at the last sample afterwards. Allocates nothing.
    ///
    /// # Errors
    /// Parameters as in [`Self::validate`]; [`HysteresisError::PlayStates`] and [`HysteresisError::Lengths`];
    /// [`HysteresisError::Drive`] where u, or a state before it, is not finite; [`HysteresisError::Overflow`]
    /// where v is not.
    pub fn simulate(
        &self,
        u: &[f64],
        start: Start<f64>,
        plays: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        self.simulate_every(1, u, start, plays, out)
    }

    /// [`Self::simulate`] for a drive given on a time base finer by `factor`: `out[k]` belongs to `u[k *
    /// factor]`.
    ///
    /// # Errors
    /// Those of [`Self::simulate`]; [`HysteresisError::Factor`] for 0.
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        start: Start<f64>,
        plays: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        self.validate()?;
        let bank = self.bank()?;
        match at_rest(start, u)? {
            Some((rest, None)) => plays.fill(rest),
            Some((rest, Some(virgin))) => {
                for (state, &threshold) in plays.iter_mut().zip(&self.thresholds) {
                    *state = play(threshold, virgin, rest);
                }
            }
            None => {
                let [low, high] =
                    u.iter().fold([f64::MAX, f64::MIN], |[low, high], &u| [low.min(u), high.max(u)]);
                plays.fill(0.5 * low + 0.5 * high);
                for (index, &u) in u.iter().enumerate() {
                    bank.step(plays, u).map_err(|error| HysteresisError::at(index, error))?;
                }
            }
        }
        self.run(&bank, factor, u, plays, out)
    }

    /// [`Self::simulate`] from the states that `plays` holds, e.g. those after another record.
    ///
    /// # Errors
    /// Those of [`Self::simulate`].
    pub fn resume(&self, u: &[f64], plays: &mut [f64], out: &mut [f64]) -> Result<(), HysteresisError> {
        self.validate()?;
        self.run(&self.bank()?, 1, u, plays, out)
    }

    fn run(
        &self,
        bank: &PlayBank<'_, f64>,
        factor: usize,
        u: &[f64],
        plays: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        let mut every = Every::new(factor)?;
        let expected = u.len().div_ceil(factor);
        if out.len() != expected {
            return Err(HysteresisError::Lengths { expected, found: out.len() });
        }
        if !plays.iter().all(|play| play.is_finite()) {
            return Err(HysteresisError::Drive { index: 0 });
        }
        let mut slots = out.iter_mut();
        for (index, &u) in u.iter().enumerate() {
            let sum = bank.step(plays, u).map_err(|error| HysteresisError::at(index, error))?;
            if every.take()
                && let Some(slot) = slots.next()
            {
                *slot = self.polynomial_at(u) + sum;
                if !slot.is_finite() {
                    return Err(HysteresisError::Overflow { index });
                }
            }
        }
        Ok(())
    }
}

impl HysteresisError {
    /// Error of a move of a bank of plays to sample `index`.
    pub(in crate::hysteresis) fn at(index: usize, error: PlayError<f64>) -> Self {
        match error {
            PlayError::Lengths { expected, found } => Self::PlayStates { expected, found },
            PlayError::Overflow => Self::Overflow { index },
            PlayError::History { index } => Self::PlayHistory { index },
            _ => Self::Drive { index },
        }
    }
}

/// The family, with one threshold per play.
#[derive(Debug)]
pub(super) struct Entry;

/// Thresholds at equal distances up to half the stroke, beyond which no loop moves a play.
fn thresholds(plays: usize, span: &DriveSpan) -> impl Iterator<Item = f64> {
    let distance = 0.5 * span.stroke / (plays + 1) as f64;
    (1..=plays).map(move |index| index as f64 * distance)
}

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "prandtl-ishlinskii"
    }

    fn summary(&self) -> &'static str {
        "Polynomial and plays: minor loops, exact inverse (this and all below: joint fit only)"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_i F_i, F_i <- max(u - threshold_i, min(u + threshold_i, F_i))"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 12, most: MOST_ELEMENTS })
    }

    fn weight_reach(&self) -> f64 {
        2.0
    }

    fn shape_numbers(&self, plays: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let of = |(r, index): (f64, usize)| {
            let search = Search::HeldUnlessBounded(r, [0.5 * r, 2.0 * r]);
            ShapeNumber::new(format!("threshold_{index}"), NumberUnit::INPUT, "half-width of a play", search)
        };
        thresholds(plays, span).zip(1..).map(of).collect()
    }

    fn starts(&self, plays: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        vec![thresholds(plays, span).collect()]
    }

    fn example(&self, plays: usize, span: &DriveSpan) -> Vec<f64> {
        // At distances that grow.
        thresholds(plays, span).map(|r| r * (0.8 + 0.4 * r / span.stroke)).collect()
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn is_compared_unasked(&self) -> bool {
        true
    }

    fn is_chosen_unasked(&self) -> bool {
        true
    }

    fn chain(&self, plays: usize) -> Vec<(usize, Option<usize>)> {
        in_a_row(0, plays).chain(plays.checked_sub(1).map(|last| (last, None))).collect()
    }

    fn as_plays(
        &self,
        _: usize,
        polynomial: &[f64],
        shape: &[f64],
        weights: &[f64],
    ) -> Option<PrandtlIshlinskii> {
        let (polynomial, thresholds) = (polynomial.to_vec(), shape.to_vec());
        Some(PrandtlIshlinskii { polynomial, thresholds, weights: weights.to_vec() })
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::Plays { thresholds: shape.to_vec(), weights: weights.to_vec() }
    }
}

impl ColumnFamily for Entry {
    type Kernel = Plays;

    const FIXED: usize = WHOLE_SHAPE;

    fn searched(&self) -> Option<&'static dyn ColumnOperators> {
        Some(&density::Density)
    }

    fn kernel(&self, _: usize, shape: &[f64], _: f64) -> Plays {
        Plays { thresholds: shape.to_vec() }
    }

    /// With derivatives with respect to the thresholds, of which each moves one column.
    fn run_columns(
        &self,
        (_, shape, _): (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        columns::run(shape, grid.factor, u, start, wanted, out)
    }

    fn add_columns(
        &self,
        model: &Hysteresis,
        _: f64,
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        play_sums::add_weighted((model.own_shape(), model.weights()), grid.factor, u, start, out)
    }
}

impl HysteresisForm {
    /// The Prandtl–Ishlinskii model with this number of plays.
    pub fn plays(plays: usize) -> Self {
        Self::of(&Entry, plays)
    }
}

impl From<PrandtlIshlinskii> for Hysteresis {
    fn from(PrandtlIshlinskii { polynomial, thresholds, weights }: PrandtlIshlinskii) -> Self {
        let form = HysteresisForm::of(&Entry, thresholds.len());
        Self::unchecked(polynomial, form, thresholds, weights)
    }
}
