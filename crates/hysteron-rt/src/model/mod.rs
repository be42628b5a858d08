//! A model that runs sample by sample: hysteresis, then linear dynamics.

mod compensator;
mod controller;
mod error;
mod feedback;
mod lms;
mod means;
mod observer;
mod operator;
mod reach;
mod sections;

pub use crate::increment::IncrementMemory;
pub use compensator::{Compensator, Drive, Law, Limited, Limits};
pub use controller::Controller;
pub use error::ModelError;
pub use feedback::{Feedback, HeldBack, Line};
pub use lms::{FilteredLms, LmsFilter, LmsMemory, LmsSettings};
pub use means::Means;
pub use observer::{Observed, Observer};
pub use operator::{Hysteresis, Operator};
pub use reach::{MOST_LOOKS, Reached};
pub use sections::{Compensated, LANES, Linear, MOST_TAPS, PolePair, RealPoles, Sections, SectionsMemory};

use crate::real::Real;
use crate::saved::{Tape, saves};

/// displacement = offset + gain (H ∗ v)(t), v = hysteresis\[voltage\]. The gain is 1 but for [`Self::trim`].
///
/// Coefficients and memory are borrowed: nothing is allocated. The linear dynamics, plays and states
/// in parallel with n = 1 and 2 cost the same number of operations whatever the voltage does, up to the
/// branches of an exponential function, everything else at most a fixed number (docs/theory/realisation.md).
/// A step cannot panic, and does not slow down at rest (states decay towards a level above the subnormal
/// numbers). Every state is advanced by compensated increments, so that poles far slower than the sample rate
/// keep their accuracy in `f32`.
///
/// ```
/// use hysteron_rt::{Hysteresis, Linear, Model, Operator, RealPoles, Sections, SectionsMemory, Compensated};
///
/// // 2 µm/V behind a lag: pole 0.9, gain 1 at rest.
/// let lag = [RealPoles { gain: [0.1, 0.0, 0.0, 0.0], weight: [1.0, 0.0, 0.0, 0.0] }];
/// let sections = Sections { taps: &[0.0], real: &lag, pairs: &[], rest_gain: 1.0 };
/// let mut states = [Compensated::zero()];
/// let memory = SectionsMemory { real: &mut states, pairs: &mut [], delay: &mut [] };
/// let hysteresis = Hysteresis::new(&[2.0], Operator::None)?;
/// let mut model = Model::new(hysteresis, Linear::new(sections, memory)?, 5.0)?;
/// assert_eq!(model.rest_at(1.0)?, 7.0);
/// assert_eq!(model.step(2.0)?, 7.0); // Behind one tap, the pole answers one sample later,
/// let next: f64 = model.step(2.0)?; // a tenth of the way.
/// assert!((next - 7.2).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Model<'a, T> {
    hysteresis: Hysteresis<'a, T>,
    dynamics: Linear<'a, T>,
    gain: T,
    offset: T,
    means: Option<Means<T>>,
}

impl<'a, T: Real> Model<'a, T> {
    /// The model, at rest and virgin at 0 V.
    ///
    /// # Errors
    /// [`ModelError::Coefficient`] for an offset that is not finite.
    pub fn new(
        hysteresis: Hysteresis<'a, T>,
        dynamics: Linear<'a, T>,
        offset: T,
    ) -> Result<Self, ModelError<T>> {
        if !offset.is_finite() {
            return Err(ModelError::Coefficient);
        }
        let mut model = Self { hysteresis, dynamics, gain: T::of(1.0), offset, means: None };
        model.rest_at(T::of(0.0))?;
        Ok(model)
    }

    /// This model with [`Means`] between the blocks: every move is evaluated half-way too, and v enters the
    /// dynamics with its mean over each sample. Twice the work of the hysteresis block.
    ///
    /// # Errors
    /// Those of [`Self::rest_at`], which puts the model at rest at its present voltage.
    pub fn with_means(mut self) -> Result<Self, ModelError<T>> {
        self.means = Some(Means::at(T::of(0.0)));
        self.rest_at(self.hysteresis.voltage())?;
        Ok(self)
    }

    /// Resets the model to steady state, its hysteresis virgin, at `voltage`; returns the displacement there.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`], [`ModelError::Overflow`]; the model is then as it was.
    pub fn rest_at(&mut self, voltage: T) -> Result<T, ModelError<T>> {
        self.rest_after(voltage, voltage)
    }

    /// [`Self::rest_at`] after a monotone move from the voltage `virgin`, where the hysteresis was virgin.
    ///
    /// # Errors
    /// Those of [`Self::rest_at`]; [`ModelError::Overflow`] leaves the hysteresis virgin.
    pub fn rest_after(&mut self, virgin: T, voltage: T) -> Result<T, ModelError<T>> {
        if !voltage.is_finite() {
            return Err(ModelError::NotFinite);
        }
        let v = self.hysteresis.rest_after(virgin, voltage)?;
        if let Some(means) = &mut self.means {
            *means = Means::at(v);
        }
        self.dynamics.rest_at(v);
        Ok(self.offset + self.gain * self.dynamics.output_at_rest())
    }

    /// [`Self::rest_at`] with the offset chosen such that the displacement there is `displacement`: bumpless
    /// start.
    ///
    /// # Errors
    /// Those of [`Self::rest_at`], and [`ModelError::Start`], which leaves the offset as it was.
    pub fn start_at(&mut self, voltage: T, displacement: T) -> Result<(), ModelError<T>> {
        if !displacement.is_finite() {
            return Err(ModelError::Start { displacement });
        }
        self.rest_at(voltage)?;
        // Not by a difference to the previous offset: a huge one would cancel all digits.
        let offset = displacement - self.gain * self.dynamics.output_at_rest();
        if !offset.is_finite() {
            return Err(ModelError::Start { displacement });
        }
        self.offset = offset;
        Ok(())
    }

    /// Displacement after a monotone move to `voltage` within one sample period.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] and [`ModelError::Overflow`]; the model is then as it was.
    #[inline]
    pub fn step(&mut self, voltage: T) -> Result<T, ModelError<T>> {
        let Some(means) = &mut self.means else {
            let v = self.hysteresis.step(voltage)?;
            return Ok(self.offset + self.gain * self.dynamics.step(v));
        };
        let (middle, v) = self.hysteresis.step_with_middle(voltage)?;
        Ok(self.offset + self.gain * self.dynamics.step(means.join(middle, v)))
    }

    /// Sets gain and offset, from the next step on: trims for a stage that has drifted since the model was
    /// identified.
    ///
    /// # Errors
    /// [`ModelError::Coefficient`] for one that is not finite, or a gain of 0; both are then as they were.
    pub fn trim(&mut self, gain: T, offset: T) -> Result<(), ModelError<T>> {
        trims_are_sound(gain, offset)?;
        (self.gain, self.offset) = (gain, offset);
        Ok(())
    }

    /// Everything that it remembers.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        self.hysteresis.each_member(tape);
        self.dynamics.each_member(tape);
        if let Some(means) = &mut self.means {
            means.each_member(tape);
        }
        tape.number(&mut self.gain);
        tape.number(&mut self.offset);
    }

    /// The hysteresis block.
    pub fn hysteresis(&self) -> &Hysteresis<'a, T> {
        &self.hysteresis
    }

    /// The dynamic block.
    pub fn dynamics(&self) -> &Linear<'a, T> {
        &self.dynamics
    }

    /// The offset \[µm\].
    pub fn offset(&self) -> T {
        self.offset
    }
}

saves!(Model);

/// Whether these may be the gain and offset of a stage.
fn trims_are_sound<T: Real>(gain: T, offset: T) -> Result<(), ModelError<T>> {
    let sound = gain.is_finite() && offset.is_finite() && gain != T::of(0.0);
    if sound { Ok(()) } else { Err(ModelError::Coefficient) }
}
