//! A model of any kind: its data and operations.
//!
//! A [`Model`] is made from the bytes of a model file ([`Model::from_json`]) or from an identification.
//! [`Model::simulate`] and [`Model::score`] take every kind; an operation that a kind does not support gives
//! the error [`Unsupported`].

mod axes_tracking;
mod capability;
mod checked_realisation;
mod corrected_drive;
mod corrected_run;
mod correction_score;
mod decoupled;
mod decoupling_request;
mod error;
mod force_run;
mod inverse_findings;
mod inverse_request;
mod inverse_summary;
mod numbers;
mod remark;
mod run;
mod score;
mod signals;
mod simulation;
mod verdict;

pub use axes_tracking::{AxesControllerSummary, AxesTrackingSummary};
pub use capability::{Capability, Unsupported};
pub use checked_realisation::{CheckedRealisation, RealisationSummary, SectionSummary, Sweep};
pub use correction_score::CorrectionScore;
pub use decoupled::{ActuatorSummary, AxisSummary, DecoupledSummary};
pub use decoupling_request::DecouplingRequest;
pub use error::{RunError, SignalRole};
#[doc(hidden)]
pub use inverse_findings::{FAR_FROM_REST, ends_apart};
pub use inverse_request::{InverseRequest, Preview};
pub use inverse_summary::{ErrorForecast, InverseSummary};
pub use remark::Remark;
pub use score::{AxesScore, BandScore, ErrorSummary, RememberingStart, RunScore, Score, ScoreSummary};
pub use signals::Signals;
pub use simulation::Simulation;
pub use verdict::{Judgement, Verdict};

use crate::axes::{CoupledHammerstein, ScheduledModes};
use crate::force::ForceModel;
use crate::hammerstein;
use crate::model_file::{
    CoupledFile, Document, ForceFile, Kind, ModelFile, ModelFileError, ModesFile, OscillatorFile, Provenance,
    SignalUnits, ValidRange, read,
};
use crate::oscillator::Oscillator;
use crate::realise::{Realisation, RealiseError, RealiseOptions, realise};
use crate::record::TimeBase;
use crate::{Advice, Finding, FindingKind};
use hysteron_numeric::display::short_to;

/// Share of the model's own error that a realisation may add, and the least and the most that this is worth.
const OF_OWN_ERROR: f64 = 0.1;
const WORTH: [f64; 2] = [1e-5, 1e-3];
/// Share of the lowest frequency of the records down to which a model with unbounded creep is realised.
const CREEP_BELOW_RECORDS: f64 = 1e-3;

/// An identified model.
#[derive(Clone, Debug, PartialEq)]
pub enum Model {
    /// Hysteresis followed by linear dynamics.
    Hammerstein(Box<Hammerstein>),
    /// A mass on a hysteretic spring.
    Oscillator(Box<Body<OscillatorFile, Oscillator>>),
    /// Force of a damper against a displacement and its rate.
    Force(Box<Body<ForceFile, ForceModel>>),
    /// Structural modes with hysteresis in feedback, of several inputs and outputs.
    Modes(Box<Body<ModesFile, ScheduledModes>>),
    /// Sums of Hammerstein branches, of several inputs and outputs.
    Branches(Box<Body<CoupledFile, CoupledHammerstein>>),
}

/// Data of a model and the law that they define.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<D, L> {
    data: D,
    law: L,
}

impl<D, L> Body<D, L> {
    /// The numbers with their units and standard errors, and how they were made.
    pub fn data(&self) -> &D {
        &self.data
    }

    /// The law, ready to compute with.
    pub fn law(&self) -> &L {
        &self.law
    }
}

/// Data and law of a Hammerstein model.
pub type Hammerstein = Body<ModelFile, hammerstein::Model>;

impl Hammerstein {
    /// Least and largest drive that the model was identified with; `None` where the data do not state it.
    pub fn drive_range(&self) -> Option<[f64; 2]> {
        self.data.valid_range.as_ref().map(|range| [range.input.low, range.input.high])
    }

    /// Remarks for the user on the inverse for a reference.
    pub fn remarks_on_reference(&self, reference: &[f64], sample_rate_hz: f64) -> Vec<Remark> {
        let time = TimeBase::uniform(sample_rate_hz);
        let fast = self.data.valid_range.as_ref().and_then(|valid| valid.exceeded_by(reference, &time));
        let remark = fast.map(|(fastest_hz, identified_hz)| Remark::Fast {
            signal: SignalRole::Reference,
            fastest_hz,
            identified_hz,
        });
        remark.into_iter().collect()
    }

    /// `options`; for unbounded creep without a lowest frequency, with a thousandth of the lowest frequency
    /// of the records it was identified from.
    pub fn realise_options(&self, sample_rate_hz: f64, options: RealiseOptions) -> RealiseOptions {
        let frequency = self.data.valid_range.as_ref().and_then(|range| range.frequency.as_ref());
        let low = frequency.map(|f| CREEP_BELOW_RECORDS * f.low).filter(|low| *low > 0.0);
        match realise(&self.law, sample_rate_hz, &options) {
            Err(RealiseError::LowestFrequency) => RealiseOptions { lowest_frequency_hz: low, ..options },
            _ => options,
        }
    }

    /// The realisation at a controller's rate \[Hz\], unbounded creep as in [`Self::realise_options`]; with
    /// what is to be said where that decided.
    ///
    /// # Errors
    /// Those of [`realise`].
    pub fn realised(
        &self,
        sample_rate_hz: f64,
        options: RealiseOptions,
    ) -> Result<(Realisation, Option<Finding>), RealiseError> {
        let used = self.realise_options(sample_rate_hz, options);
        let low = used.lowest_frequency_hz.filter(|_| options.lowest_frequency_hz.is_none());
        let finding = low.map(|low| {
            let text = format!(
                "The model creeps for ever: it is realised down to {} Hz, a thousandth of the lowest \
                 frequency of its records.",
                short_to(low, 3)
            );
            Finding::new(FindingKind::Verdict, "creep", text).with_advice(Advice::GiveLowestFrequency)
        });
        Ok((realise(&self.law, sample_rate_hz, &used)?, finding))
    }

    /// The accuracy of a realisation that the model's error is worth, as a share of the gain at rest: a tenth
    /// of its least error on a record (RMSE in strokes), to one digit, from 1e-5 to 1e-3. Of a realisation as
    /// good as that the total error grows by half a percent. `None` where the file holds no scores.
    pub fn accuracy_worth(&self) -> Option<f64> {
        let errors = self.data.scores.iter().filter_map(|score| score.rmse_percent_of_stroke);
        let least = errors.filter(|error| error.is_finite()).reduce(f64::min)?;
        let share = (OF_OWN_ERROR * least / 100.0).clamp(WORTH[0], WORTH[1]);
        let digit = 10_f64.powf(share.log10().floor());
        Some((share / digit * (1.0 + 1e-12)).floor() * digit)
    }
}

/// Reads one field that every kind's data have.
macro_rules! header {
    ($model:expr, $body:ident => $field:expr) => {
        match $model {
            Model::Hammerstein($body) => $field,
            Model::Oscillator($body) => $field,
            Model::Force($body) => $field,
            Model::Modes($body) => $field,
            Model::Branches($body) => $field,
        }
    };
}

impl Model {
    /// The model from the bytes of a model file, of version 2 or 1.
    ///
    /// # Errors
    /// [`ModelFileError`] that names the place.
    pub fn from_json(bytes: &[u8]) -> Result<Self, ModelFileError> {
        read(bytes)?.try_into()
    }

    /// Text of the model file (version 2): indented JSON with a final newline.
    ///
    /// # Errors
    /// [`ModelFileError`] for invalid data.
    pub fn to_json(&self) -> Result<String, ModelFileError> {
        header!(self, body => body.data.to_json())
    }

    /// The kind of model.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Hammerstein(_) => Kind::Hammerstein,
            Self::Oscillator(_) => Kind::Oscillator,
            Self::Force(_) => Kind::Force,
            Self::Modes(_) => Kind::Modes,
            Self::Branches(_) => Kind::Branches,
        }
    }

    /// A name for people, of the device or the experiment.
    pub fn name(&self) -> Option<&str> {
        header!(self, body => body.data.name.as_deref())
    }

    /// Units of inputs and outputs.
    pub fn units(&self) -> &SignalUnits {
        header!(self, body => &body.data.units)
    }

    /// Columns of the inputs and of the outputs, where the model names them: one of several axes does.
    pub fn channels(&self) -> Option<(&[String], &[String])> {
        match self {
            Self::Hammerstein(_) | Self::Oscillator(_) | Self::Force(_) => None,
            Self::Modes(body) => Some((&body.data.inputs, &body.data.outputs)),
            Self::Branches(body) => Some((&body.data.inputs, &body.data.outputs)),
        }
    }

    /// True if a record can start from rest at an input other than its first sample's.
    pub fn rests_at_a_voltage(&self) -> bool {
        matches!(self, Self::Hammerstein(_))
    }

    /// Sample rate that the model was identified at \[Hz\]; `None` for a static model of records without one.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        match self {
            Self::Hammerstein(body) => body.data.sample_rate_hz,
            Self::Oscillator(body) => Some(body.data.sample_rate_hz),
            Self::Force(body) => body.data.sample_rate_hz,
            Self::Modes(body) => Some(body.data.sample_rate_hz),
            Self::Branches(body) => Some(body.data.sample_rate_hz),
        }
    }

    /// Range covered by the records of the identification; outside of it the model extrapolates.
    pub fn valid_range(&self) -> Option<&ValidRange> {
        header!(self, body => body.data.valid_range.as_ref())
    }

    /// Provenance of the model.
    pub fn provenance(&self) -> Option<&Provenance> {
        header!(self, body => body.data.provenance.as_ref())
    }

    /// The Hammerstein model, for what the other kinds do not support yet.
    ///
    /// # Errors
    /// [`Unsupported`], which names the kind and `wanted`.
    pub fn hammerstein(&self, wanted: Capability) -> Result<&Hammerstein, Unsupported> {
        match self {
            Self::Hammerstein(body) => Ok(body),
            _ => Err(Unsupported { kind: self.kind(), wanted }),
        }
    }
}

impl From<Model> for Document {
    fn from(model: Model) -> Self {
        match model {
            Model::Hammerstein(body) => Self::Hammerstein(Box::new(body.data)),
            Model::Oscillator(body) => Self::Oscillator(Box::new(body.data)),
            Model::Force(body) => Self::Force(Box::new(body.data)),
            Model::Modes(body) => Self::Modes(Box::new(body.data)),
            Model::Branches(body) => Self::Branches(Box::new(body.data)),
        }
    }
}

impl TryFrom<Document> for Model {
    type Error = ModelFileError;

    fn try_from(document: Document) -> Result<Self, ModelFileError> {
        Ok(match document {
            Document::Hammerstein(data) => {
                Self::Hammerstein(Box::new(Body { law: data.to_model()?, data: *data }))
            }
            Document::Oscillator(data) => {
                Self::Oscillator(Box::new(Body { law: data.to_oscillator()?, data: *data }))
            }
            Document::Force(data) => Self::Force(Box::new(Body { law: data.to_model()?, data: *data })),
            Document::Modes(data) => Self::Modes(Box::new(Body { law: data.to_model()?, data: *data })),
            Document::Branches(data) => Self::Branches(Box::new(Body { law: data.to_model()?, data: *data })),
        })
    }
}

impl TryFrom<ModelFile> for Model {
    type Error = ModelFileError;

    fn try_from(data: ModelFile) -> Result<Self, ModelFileError> {
        Document::Hammerstein(Box::new(data)).try_into()
    }
}

impl TryFrom<OscillatorFile> for Model {
    type Error = ModelFileError;

    fn try_from(data: OscillatorFile) -> Result<Self, ModelFileError> {
        Document::Oscillator(Box::new(data)).try_into()
    }
}

impl TryFrom<ForceFile> for Model {
    type Error = ModelFileError;

    fn try_from(data: ForceFile) -> Result<Self, ModelFileError> {
        Document::Force(Box::new(data)).try_into()
    }
}

impl TryFrom<ModesFile> for Model {
    type Error = ModelFileError;

    fn try_from(data: ModesFile) -> Result<Self, ModelFileError> {
        Document::Modes(Box::new(data)).try_into()
    }
}

impl TryFrom<CoupledFile> for Model {
    type Error = ModelFileError;

    fn try_from(data: CoupledFile) -> Result<Self, ModelFileError> {
        Document::Branches(Box::new(data)).try_into()
    }
}
