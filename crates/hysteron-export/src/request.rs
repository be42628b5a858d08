//! An export as it is asked for, with the defaults of every front end.

use hysteron_io::NamedFile;
use hysteron_model::model::{Hammerstein, InverseRequest, Preview, Sweep};
use hysteron_model::realise::{RealiseOptions, verify};
use hysteron_model::tracking::Controller;
use hysteron_model::{Finding, FindingKind};
use serde::{Deserialize, Serialize};

use crate::closed_loop::ClosedLoop;
use crate::error::ExportError;
use crate::fmu::Platform;
use crate::form::{Around, Form, Means};
use crate::golden::Rounding;
use crate::inverse::Inverse;
use crate::number::Precision;
use crate::subject::{Subject, significant};

/// What a model is exported as; what is left out takes its default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExportRequest {
    /// Form.
    #[serde(rename = "to")]
    pub form: Form,
    /// Number type.
    pub float: Precision,
    /// Beginning of every name in the source: a to z, digits, `_`.
    pub name: String,
    /// Rate of the controller \[Hz\]; left out: that of the model's records.
    #[serde(default)]
    pub sample_rate_hz: Option<f64>,
    /// Largest error of the realised dynamics, as a share of the gain at rest; left out: what the model's own
    /// error is worth ([`Hammerstein::accuracy_worth`]).
    #[serde(default)]
    pub accuracy: Option<f64>,
    /// Frequency \[Hz\] down to which unbounded creep is realised; left out: a thousandth of the lowest one in
    /// the model's records.
    #[serde(default)]
    pub lowest_frequency_hz: Option<f64>,
    /// The inverse too: reference in, drive out.
    #[serde(default)]
    pub inverse: Option<InverseRequest>,
    /// A controller of `track` around the inverse: with a feedback law or an observer, as C99, Rust or FMUs.
    #[serde(default)]
    pub controller: Option<Controller>,
    /// SHA-256 of the model file; left out: of the file as this program writes it.
    #[serde(default)]
    pub model_sha256: Option<String>,
    /// Day in the headers; left out, the source is the same on every day.
    #[serde(default)]
    pub date: Option<String>,
}

impl ExportRequest {
    /// The model alone, in double precision, with every default.
    pub fn new(form: Form, name: &str) -> Self {
        Self {
            form,
            float: Precision::F64,
            name: name.to_owned(),
            sample_rate_hz: None,
            accuracy: None,
            lowest_frequency_hz: None,
            inverse: None,
            controller: None,
            model_sha256: None,
            date: None,
        }
    }
}

/// An export.
#[derive(Clone, Debug)]
pub struct Exported {
    /// The model at its rate.
    pub subject: Subject,
    /// Its files, and those of the inverse.
    pub files: Vec<NamedFile>,
    /// What was decided, and what to know of the source.
    pub findings: Vec<Finding>,
}

/// The files of a model as they are asked for.
///
/// # Errors
/// [`ExportError::SampleRate`] where none is known; those of [`Subject::new`], [`Inverse::new`] and
/// of the files of the form.
pub fn export(
    model: &Hammerstein,
    request: &ExportRequest,
    means: Means<'_>,
) -> Result<Exported, ExportError> {
    let (form, float) = (request.form, request.float);
    if float == Precision::F32 && !form.has_single_precision() {
        return Err(ExportError::MatlabPrecision);
    }
    let rate = request.sample_rate_hz.or(model.data().sample_rate_hz).ok_or(ExportError::SampleRate)?;
    let worth = model.accuracy_worth();
    let accuracy = request.accuracy.or(worth).unwrap_or(RealiseOptions::default().accuracy);
    let asked = RealiseOptions { accuracy, lowest_frequency_hz: request.lowest_frequency_hz };
    let (realisation, creep) = model.realised(rate, asked)?;
    let mut findings: Vec<Finding> = creep.into_iter().collect();
    let mut subject = Subject::new(&request.name, float, model.data(), realisation, accuracy)?;
    subject.accuracy_by_error = request.accuracy.is_none() && worth.is_some();
    if let Some(sha256) = &request.model_sha256 {
        subject.origin.model_sha256.clone_from(sha256);
    }
    subject.origin.date.clone_from(&request.date);
    findings.extend(coarse("displacement", &subject.output_unit, subject.rounding));
    let sweep =
        Sweep::over(model.data().valid_range.as_ref(), rate, subject.realisation.dynamics.delay_samples);
    let along = verify(&subject.realisation, &sweep.drive)?;
    findings.extend(along.finding(accuracy));
    subject.along_sweep = Some((along, sweep.frequencies_hz));
    let closed = match request.controller {
        Some(controller) => {
            let (closed, told) = controlled(model, &subject, controller, request)?;
            findings.extend(told);
            Some(closed)
        }
        None => None,
    };
    let inverse = match &request.inverse {
        // The controller's own.
        Some(_) if closed.is_some() => None,
        Some(asked) => {
            let (inverse, told) = inverted(model, &subject, asked, request.lowest_frequency_hz)?;
            findings.extend(told);
            Some(inverse)
        }
        None => None,
    };
    let around = match (&inverse, &closed) {
        (_, Some(closed)) => Around::Controller(closed),
        (Some(inverse), None) => Around::Inverse(inverse),
        (None, None) => Around::Nothing,
    };
    let mut files = form.files(&subject, around, means)?;
    subject.origin.mark(&mut files);
    if form == Form::Fmu {
        findings.extend(Platform::left_out().into_iter().map(without_binary));
    }
    Ok(Exported { subject, files, findings })
}

fn controlled(
    model: &Hammerstein,
    subject: &Subject,
    controller: Controller,
    request: &ExportRequest,
) -> Result<(ClosedLoop, Vec<Finding>), ExportError> {
    let Some(asked) = &request.inverse else { return Err(ExportError::ControllerAlone) };
    if !request.form.has_controllers() {
        return Err(ExportError::ControllerForm { form: request.form.name() });
    }
    let realise =
        RealiseOptions { accuracy: subject.accuracy, lowest_frequency_hz: request.lowest_frequency_hz };
    let closed = ClosedLoop::new(model, subject, controller, asked, realise)?;
    let mut findings: Vec<Finding> =
        Preview::from(&closed.inverse.compensation).finding(asked.preview).into_iter().collect();
    findings.extend(told(&closed.inverse));
    findings.extend(coarse("voltage of the controller", &subject.input_unit, closed.rounding));
    findings.extend(departures(closed.dry_run.in_words(&closed.compared())));
    Ok((closed, findings))
}

/// What is to be said of an inverse.
fn told(inverse: &Inverse) -> Vec<Finding> {
    let coarse = coarse("voltage", &inverse.subject.input_unit, inverse.rounding);
    coarse.into_iter().chain(departures(inverse.dry_run.in_words(&inverse.compared()))).collect()
}

/// What a dry run says.
fn departures(said: Vec<String>) -> impl Iterator<Item = Finding> {
    said.into_iter().map(|text| Finding::new(FindingKind::Verdict, "single precision", text))
}

fn inverted(
    model: &Hammerstein,
    subject: &Subject,
    asked: &InverseRequest,
    lowest_frequency_hz: Option<f64>,
) -> Result<(Inverse, Vec<Finding>), ExportError> {
    let limits = asked.limits(model)?;
    let realise = RealiseOptions { accuracy: subject.accuracy, lowest_frequency_hz };
    // As far ahead as the drive depends on the reference; a reference that is predicted is not known ahead.
    let preview = asked.predict_to_hz.map(|_| 0);
    let law = asked.law(model, subject.realisation.sample_rate_hz, realise, preview)?;
    let mut findings: Vec<Finding> = Preview::from(&law).finding(asked.preview).into_iter().collect();
    let inverse = Inverse::new(subject, law, [limits.low, limits.high], limits.slew_v_per_s)?;
    findings.extend(told(&inverse));
    Ok((inverse, findings))
}

/// What is to be said of a platform that no binary was made for.
pub(crate) fn without_binary(platform: Platform) -> Finding {
    let text = format!(
        "The units have no binary for {}, only the source: `{}` is not installed, or its C library is not.",
        platform.words(),
        platform.cross_compiler()
    );
    Finding::new(FindingKind::Verdict, "platforms", text)
}

/// What is to be said where single precision costs much.
fn coarse(what: &str, unit: &str, rounding: Rounding) -> Option<Finding> {
    (rounding.share > Rounding::NOTED).then(|| {
        let text = format!(
            "Single precision may move the {what} by {} {unit}, {} % of its range; double precision does not.",
            significant(rounding.bound),
            significant(100.0 * rounding.share)
        );
        Finding::new(FindingKind::Verdict, "single precision", text)
    })
}

/// Name in a source, of a file's name: lower case, `_` for all but letters and digits, a letter first.
pub fn name_of(stem: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let name: String = stem.chars().map(plain).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("model_{name}") }
}
