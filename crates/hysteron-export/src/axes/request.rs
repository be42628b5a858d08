//! An export of a model of several axes as it is asked for, with the defaults of every front end.

use hysteron_io::NamedFile;
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::DecouplingLaw;
use hysteron_model::model::{Capability, DecouplingRequest, Preview};
use hysteron_model::tracking::Controller;
use hysteron_model::{Finding, Model};
use serde::{Deserialize, Serialize};

use super::{AxesSubject, axes_files, axes_fmu_files, axes_inverse_files, axes_rust_files};
use crate::error::ExportError;
use crate::fmu::Platform;
use crate::form::{Form, Means};
use crate::number::Precision;
use crate::origin::Origin;
use crate::request::without_binary;

/// What a model of several axes is exported as; what is left out takes its default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxesExportRequest {
    /// Form: C99, Rust or FMUs.
    #[serde(rename = "to")]
    pub form: Form,
    /// Number type.
    pub float: Precision,
    /// Beginning of every name in the source: a to z, digits, `_`.
    pub name: String,
    /// Rate of the controller \[Hz\]; left out: the model's.
    #[serde(default)]
    pub sample_rate_hz: Option<f64>,
    /// The inverse too: references in, drives out.
    #[serde(default)]
    pub inverse: bool,
    /// Level, and for the inverse limits, bandwidth and preview.
    #[serde(default)]
    pub decoupling: DecouplingRequest,
    /// A controller of `track`: refused, with the reason.
    #[serde(default)]
    pub controller: Option<Controller>,
    /// SHA-256 of the model file; left out: not in the headers.
    #[serde(default)]
    pub model_sha256: Option<String>,
    /// Day in the headers; left out, the source is the same on every day.
    #[serde(default)]
    pub date: Option<String>,
}

/// An export of a model of several axes.
#[derive(Clone, Debug)]
pub struct AxesExported {
    /// The model at its rate and level.
    pub subject: AxesSubject,
    /// Its files, and those of the inverse.
    pub files: Vec<NamedFile>,
    /// What to know of them.
    pub findings: Vec<Finding>,
}

/// The files of a model of several axes as they are asked for.
///
/// # Errors
/// [`ExportError::Unsupported`] for a model without such an export, [`ExportError::OneAxis`] for a form that
/// is not there for it, [`ExportError::AxesController`] for a controller; those of [`DecouplingLaw::new`] and [`AxesSubject::new`].
pub fn export_axes(
    model: &Model,
    request: &AxesExportRequest,
    means: Means<'_>,
) -> Result<AxesExported, ExportError> {
    if !matches!(request.form, Form::C | Form::Rust | Form::Fmu) {
        return Err(ExportError::OneAxis { form: request.form.name().to_owned() });
    }
    if let Some(controller) = request.controller {
        return Err(ExportError::AxesController { controller: controller.name() });
    }
    let modes = model.scheduled_modes(Capability::Export)?;
    let rate = request.sample_rate_hz.unwrap_or(modes.sample_rate_hz);
    let law = DecouplingLaw::new(modes, rate, &request.decoupling.law())?;
    let limits = match request.decoupling.limits(model) {
        // The model alone has no limits.
        Err(_) if !request.inverse => vec![Limits::range(-1.0, 1.0); modes.inputs],
        limits => limits?,
    };
    let units = model.units();
    let mut subject =
        AxesSubject::new(&request.name, model.name(), (&units.input, &units.output), law, limits)?
            .in_precision(request.float)
            .identified_in(model.valid_range().cloned());
    subject.origin = Origin::made(model.provenance());
    subject.origin.model_sha256 = request.model_sha256.clone().unwrap_or_default();
    subject.origin.date.clone_from(&request.date);
    if let Some((inputs, outputs)) = model.channels() {
        subject.channels = (inputs.to_vec(), outputs.to_vec());
    }
    let law = &subject.law;
    let bandwidth_hz = if request.inverse { law.bandwidth_hz } else { 0.0 };
    let ends = subject.limits.iter().map(|limit| (limit.low, limit.high));
    let ends = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).filter(|_| request.inverse);
    let mut findings = model.decoupling_findings(law.level, ends, bandwidth_hz);
    if request.inverse {
        findings.extend(Preview::from(law).finding(request.decoupling.preview));
    }
    let mut files = match request.form {
        Form::Rust => axes_rust_files(&subject, request.inverse)?,
        Form::Fmu => {
            findings.extend(Platform::left_out().into_iter().map(without_binary));
            axes_fmu_files(&subject, request.inverse, means)?
        }
        _ => {
            let mut files = axes_files(&subject)?;
            if request.inverse {
                files.extend(axes_inverse_files(&subject)?);
            }
            files
        }
    };
    subject.origin.mark(&mut files);
    Ok(AxesExported { subject, files, findings })
}
