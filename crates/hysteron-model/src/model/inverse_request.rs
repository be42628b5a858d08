//! What the inverse of a model is asked for, with the defaults of every front end.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Hammerstein;
use crate::compensator::{Compensation, CompensatorOptions, Limits, Prediction};
use crate::decoupling::DecouplingLaw;
use crate::invert::{InverseDrive, InverseOptions, InversionError, LastRun};
use crate::misfit::NotCorrected;
use crate::realise::RealiseOptions;
use crate::{Finding, FindingKind, Start};
use hysteron_numeric::Listener;

/// A drive for a reference, or a controller, as it is asked for; what is left out takes its default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct InverseRequest {
    /// Least and greatest drive; left out: the range that the model was identified in.
    pub range: Option<[f64; 2]>,
    /// Largest slew rate, in the unit of the drive per second; left out: none.
    pub slew_per_s: Option<f64>,
    /// Frequency up to which the output follows \[Hz\]; left out: a twentieth of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// The reference is periods of a periodic motion.
    pub periodic: bool,
    /// Drive at rest before the reference; left out: the one that gives its first value.
    pub rest_voltage: Option<f64>,
    /// Drive at which the device was last demagnetised, before it moved to rest; left out: 0 where the range
    /// contains it, as after switching on, else that at rest.
    pub virgin_voltage: Option<f64>,
    /// Compute sample by sample, as a controller does, with so many samples of the reference known ahead;
    /// left out: the whole reference is known.
    pub preview: Option<usize>,
    /// Compute sample by sample, the reference beyond the preview predicted from its past as a random motion
    /// band-limited to this frequency \[Hz\].
    pub predict_to_hz: Option<f64>,
    /// Correct the drive by the predicted misfit of a device outside the model class.
    pub correct: bool,
}

/// How much of the reference a law that works sample by sample knows ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preview {
    /// Samples used.
    pub samples: usize,
    /// Samples beyond which more are of little use, or the most that a law takes where it is `cut`.
    pub useful: usize,
    /// True if more would be of use than a law takes.
    pub cut: bool,
}

impl Preview {
    /// The preview in a sentence.
    pub fn in_words(self) -> String {
        let Self { samples, useful, cut } = self;
        let others = if cut { "the most that there are" } else { "more are of little use" };
        format!("Computed sample by sample, with a preview of {samples} samples ({useful}: {others}).")
    }

    /// What is to be said where more samples ahead were `asked` for than affect the drive, or would be of use
    /// than a law takes.
    pub fn finding(self, asked: Option<usize>) -> Option<Finding> {
        if self.cut && self.samples >= self.useful {
            let text = format!(
                "The preview is {} samples, the most that there are. At this sample rate more would be of use: \
                 the reference is taken to stay after them. At a lower rate they reach further.",
                self.samples
            );
            return Some(Finding::new(FindingKind::Warning, "preview", text));
        }
        let asked = asked.filter(|asked| *asked > self.samples)?;
        let text = format!(
            "Of the preview of {asked} samples {used} are used: later ones do not affect the drive. A \
             controller is given the reference {used} samples ahead.",
            used = self.samples
        );
        Some(Finding::new(FindingKind::Verdict, "preview", text))
    }
}

impl From<&Compensation> for Preview {
    fn from(law: &Compensation) -> Self {
        Self { samples: law.preview, useful: law.useful_preview, cut: law.preview_is_cut }
    }
}

impl From<&DecouplingLaw> for Preview {
    fn from(law: &DecouplingLaw) -> Self {
        Self { samples: law.preview, useful: law.useful_preview, cut: law.preview_is_cut }
    }
}

impl InverseRequest {
    /// A drive or a controller within limits.
    pub fn within(limits: Limits) -> Self {
        Self {
            range: Some([limits.low, limits.high]),
            slew_per_s: Some(limits.slew_v_per_s).filter(|slew| slew.is_finite()),
            ..Self::default()
        }
    }

    /// Limits of the drive: given, else the range that the model was identified in, with any slew rate.
    ///
    /// # Errors
    /// [`InversionError::RangeUnknown`], [`InversionError::Option`].
    pub fn limits(&self, model: &Hammerstein) -> Result<Limits, InversionError> {
        let [low, high] = self.range.or(model.drive_range()).ok_or(InversionError::RangeUnknown)?;
        let wrong = |name, value, allowed| Err(InversionError::Option { name, value, allowed });
        if !(low < high && low.is_finite() && high.is_finite()) {
            return wrong("the greatest drive", high, "above the least one");
        }
        let slew_v_per_s = self.slew_per_s.unwrap_or(f64::INFINITY);
        if slew_v_per_s.is_nan() || slew_v_per_s <= 0.0 {
            return wrong("the slew rate", slew_v_per_s, "above 0");
        }
        Ok(Limits { low, high, slew_v_per_s })
    }

    /// The law of a controller at a sample rate \[Hz\], with this preview where none is asked for: `None`, as
    /// many samples as affect the drive.
    ///
    /// # Errors
    /// Those of [`Compensation::new`]; [`InversionError::NotCorrected`] where a corrected drive is asked for.
    pub fn law(
        &self,
        model: &Hammerstein,
        sample_rate_hz: f64,
        realise: RealiseOptions,
        preview: Option<usize>,
    ) -> Result<Compensation, InversionError> {
        if self.correct {
            return Err(NotCorrected::Controller.into());
        }
        let options = CompensatorOptions {
            bandwidth_hz: self.bandwidth_hz,
            preview: self.preview.or(preview),
            prediction: Prediction::up_to(self.predict_to_hz),
            realise: model.realise_options(sample_rate_hz, realise),
            ..CompensatorOptions::default()
        };
        Compensation::new(model.law(), sample_rate_hz, &options)
    }

    fn options(&self, limits: Limits) -> InverseOptions {
        let range_v = [limits.low, limits.high];
        InverseOptions {
            bandwidth_hz: self.bandwidth_hz,
            slew_v_per_s: limits.slew_v_per_s,
            start: match self.rest_voltage {
                _ if self.periodic => Start::PERIODIC,
                Some(voltage_v) => Start::Rest { voltage_v },
                None => Start::AsIdentified,
            },
            virgin_v: self.virgin_voltage.or(InverseOptions::switched_on(range_v)),
            ..InverseOptions::within(range_v)
        }
    }
}

impl Hammerstein {
    /// The drive for a reference as it is asked for, corrected by the error of the `last` run with the same
    /// reference where there is one; and the preview of a law that works sample by sample.
    ///
    /// # Errors
    /// [`InversionError`]; [`InversionError::Stopped`] where the listener ends it.
    pub fn drive_for(
        &self,
        reference: &[f64],
        sample_rate_hz: f64,
        request: &InverseRequest,
        last: Option<LastRun<'_>>,
        listener: Listener<'_>,
    ) -> Result<(InverseDrive, Option<Preview>), InversionError> {
        let options = request.options(request.limits(self)?);
        let by_sample = request.preview.is_some() || request.predict_to_hz.is_some();
        match last {
            Some(_) if request.correct => Err(NotCorrected::Learnt.into()),
            Some(_) if by_sample => Err(InversionError::LearnedBySample),
            Some(last) => Ok((self.law().learn(reference, last, sample_rate_hz, &options)?, None)),
            None if by_sample => {
                let law = request.law(self, sample_rate_hz, RealiseOptions::default(), Some(0))?;
                let preview = Preview::from(&law);
                Ok((law.follow(reference, &options)?, Some(preview)))
            }
            None if request.correct => {
                Ok((self.corrected_drive(reference, sample_rate_hz, &options, listener)?, None))
            }
            None => {
                let found = self.law().invert_told(reference, sample_rate_hz, &options, listener)?;
                Ok((found, None))
            }
        }
    }
}
