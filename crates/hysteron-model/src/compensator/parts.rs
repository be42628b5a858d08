//! Coefficients and memory of a compensator in one number type.

use hysteron_rt::{Compensator, LANES, Law, Limits, Real};

use super::{Compensation, InversionError};
use crate::hysteresis::{Hysteresis, HysteresisError};
use crate::realise::{Realisation, RealiseError, RuntimeParts};
use crate::record::Timing;

/// Loops of shrinking size on which a hysteresis without an exact invertibility condition is tested.
const TURNS: usize = 40;
const SAMPLES_A_TURN: usize = 200;

/// Coefficients and memory of a compensator that `hysteron-rt` runs.
#[derive(Clone, Debug)]
pub struct CompensatorParts<T> {
    model: RuntimeParts<T>,
    recent: Vec<T>,
    real: Vec<[T; LANES]>,
    pairs: Vec<[T; 2]>,
    reference: Vec<T>,
    ring: Vec<T>,
    limits: Limits<T>,
    offset: T,
}

impl<T: Real> CompensatorParts<T> {
    /// The parts of a law within the voltages `range_v` and the rate `slew_v_per_s` (infinite for none),
    /// rounded to `T`, limits inwards.
    ///
    /// # Errors
    /// [`InversionError::NotInvertible`] for a hysteresis that has no inverse within the range; as
    /// [`RuntimeParts::new`]; [`InversionError::Option`] for limits that leave no room.
    pub fn new(
        compensation: &Compensation,
        range_v: [f64; 2],
        slew_v_per_s: f64,
    ) -> Result<Self, InversionError> {
        let [low, high] = range_v;
        if !(low < high && (high - low).is_finite()) {
            return Err(RealiseError::from(HysteresisError::Range { low, high }).into());
        }
        if slew_v_per_s.is_nan() || slew_v_per_s <= 0.0 {
            let (value, allowed) = (slew_v_per_s, "positive");
            return Err(InversionError::Option { name: "largest rate of the drive [V/s]", value, allowed });
        }
        let model = &compensation.model;
        invertible(&model.hysteresis, range_v, 1.0 / compensation.sample_rate_hz)?;
        let mut dynamics = compensation.dynamics.clone();
        dynamics.delay_samples = 0;
        let realisation = Realisation {
            model: model.clone(),
            dynamics,
            sample_rate_hz: compensation.sample_rate_hz,
            joins_means: false,
        };
        let of = |x: f64| T::of(x);
        let (mut single, mut pairs) = (Vec::new(), Vec::new());
        for (section, [re, im]) in compensation.dynamics.sections.iter().zip(&compensation.states) {
            if section.is_pair() { pairs.push([of(*re), of(*im)]) } else { single.push(of(*re)) }
        }
        let real = single
            .chunks(LANES)
            .map(|some| {
                let mut lanes = [of(0.0); LANES];
                lanes.iter_mut().zip(some).for_each(|(lane, gain)| *lane = *gain);
                lanes
            })
            .collect();
        Ok(Self {
            model: RuntimeParts::new(&realisation)?,
            recent: compensation.recent.iter().copied().map(of).collect(),
            real,
            pairs,
            reference: compensation.reference.iter().copied().map(of).collect(),
            ring: vec![of(0.0); compensation.reference.len()],
            limits: Limits {
                low: T::at_least(low),
                high: T::at_most(high),
                step: T::at_most(slew_v_per_s / compensation.sample_rate_hz),
            },
            offset: of(model.offset),
        })
    }

    /// The compensator, at rest and virgin at the voltage of its range nearest to 0 V; clears its memory.
    ///
    /// # Errors
    /// [`RealiseError::Rounded`] where the coefficients are not finite in this number type.
    pub fn compensator(&mut self) -> Result<Compensator<'_, T>, InversionError> {
        let Self { model, recent, real, pairs, reference, ring, limits, offset } = self;
        let (hysteresis, dynamics) = model.blocks()?;
        let law = Law { recent, real, pairs, reference };
        Compensator::new(hysteresis, dynamics, law, ring, *limits, *offset)
            .map_err(|_| RealiseError::Rounded.into())
    }
}

/// Checks that the output rises with the drive within the range: by the exact condition of the family, else
/// on loops of all sizes.
fn invertible(hysteresis: &Hysteresis, [low, high]: [f64; 2], interval_s: f64) -> Result<(), InversionError> {
    let samples = TURNS * SAMPLES_A_TURN;
    let loops: Vec<f64> = (0..samples)
        .map(|k| {
            let (turn, share) = (k / SAMPLES_A_TURN, (k % SAMPLES_A_TURN) as f64 / SAMPLES_A_TURN as f64);
            let size = 1.0 - turn as f64 / TURNS as f64;
            let along = if share < 0.5 { 2.0 * share } else { 2.0 - 2.0 * share };
            0.5 * (low + high) + 0.5 * (high - low) * size * (2.0 * along - 1.0)
        })
        .collect();
    let found =
        hysteresis.invertibility(&[(&loops, Timing::Rate(1.0 / interval_s))]).map_err(RealiseError::from)?;
    if found.is_invertible() { Ok(()) } else { Err(InversionError::NotInvertible(found)) }
}
