//! A model as source code: its files, to look at or in an archive.

use std::io::{Cursor, Write};

use hysteron_export::{Form, Inverse, Means, NamedFile, Precision, Subject};
use hysteron_identify::Listener;
use hysteron_model::compensator::Compensation;
use hysteron_model::compensator::CompensatorOptions;
use hysteron_model::model::{Capability, Hammerstein};
use hysteron_model::realise::{RealiseOptions, realise};
use zip::write::SimpleFileOptions;

use crate::api::{DownloadQuery, ExportFile, Preview};
use crate::clock::today;
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::{Workspace, stem_of};

/// Name in the source, of the model's: lower case, `_` for all but letters and digits.
fn name_of(id: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let name: String = stem_of(id).chars().map(plain).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("model_{name}") }
}

/// The form of source code that is asked for.
fn source(query: &DownloadQuery) -> Answer<Form> {
    let none = || Refused::bad("only source code can be looked at before the download");
    query.form.source().ok_or_else(none)
}

struct Exported {
    name: String,
    files: Vec<NamedFile>,
    states: usize,
    error: f64,
}

fn exported(
    workspace: &Workspace,
    id: &str,
    query: &DownloadQuery,
    listener: Listener<'_>,
) -> Answer<Exported> {
    let form = source(query)?;
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Export).map_err(Refused::cannot)?;
    let rate = rate(body, query.sample_rate_hz)?;
    let options = body.realise_options(rate, RealiseOptions::default());
    let realisation = realise(body.law(), rate, &options).map_err(Refused::bad)?;
    let (states, error) = (realisation.dynamics.states(), realisation.dynamics.frequency_error);
    let single = query.single && form.has_single_precision();
    let precision = if single { Precision::F32 } else { Precision::F64 };
    let name = name_of(id);
    let subject = Subject::new(&name, precision, body.data(), realisation, options.accuracy);
    let mut subject = subject.map_err(Refused::cannot)?;
    subject.origin.date = Some(today());
    let inverse = if query.inverse { Some(inverted(body, &subject, rate, query)?) } else { None };
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let means = Means { compiler: &compiler, listener };
    let files = form.files(&subject, inverse.as_ref(), means).map_err(Refused::cannot)?;
    Ok(Exported { name, files, states, error })
}

/// Sample rate of the controller: given, else that of the model's records.
pub(super) fn rate(body: &Hammerstein, given: Option<f64>) -> Answer<f64> {
    if given.is_some_and(|rate| !(rate.is_finite() && rate > 0.0)) {
        return Err(Refused::bad("the sample rate of the controller must be positive"));
    }
    given.or(body.data().sample_rate_hz).ok_or_else(|| {
        Refused::bad("the model was identified from records without a sample rate")
            .hint("Give the sample rate of the controller.")
    })
}

fn inverted(body: &Hammerstein, subject: &Subject, rate: f64, query: &DownloadQuery) -> Answer<Inverse> {
    let given = query.low.zip(query.high).map(|(low, high)| [low, high]);
    let range = given.or(body.drive_range()).filter(|[low, high]| low < high).ok_or_else(|| {
        Refused::bad("the range of the inverse's voltage is not known").hint("Give its lowest and highest.")
    })?;
    let options = CompensatorOptions {
        realise: body.realise_options(rate, RealiseOptions::default()),
        ..CompensatorOptions::default()
    };
    let compensation = Compensation::new(body.law(), rate, &options).map_err(Refused::cannot)?;
    let slew = query.slew_per_s.unwrap_or(f64::INFINITY);
    Inverse::new(subject, compensation, range, slew).map_err(Refused::cannot)
}

/// The files of an export, to look at.
///
/// # Errors
/// If the model cannot be exported so.
pub(crate) fn preview(
    workspace: &Workspace,
    id: &str,
    query: &DownloadQuery,
    listener: Listener<'_>,
) -> Answer<Preview> {
    let Exported { name, files, states, error } = exported(workspace, id, query, listener)?;
    let shown = |file: NamedFile| ExportFile {
        name: file.name,
        bytes: file.bytes.len(),
        text: String::from_utf8(file.bytes).ok(),
    };
    Ok(Preview {
        files: files.into_iter().map(shown).collect(),
        states: Some(states),
        error: Some(error),
        command: command::export(id, &name, query),
    })
}

/// Name and bytes of a zip archive with the files of an export.
///
/// # Errors
/// If the model cannot be exported so.
pub(crate) fn archive(
    workspace: &Workspace,
    id: &str,
    query: &DownloadQuery,
    listener: Listener<'_>,
) -> Answer<(String, Vec<u8>)> {
    let Exported { name, files, .. } = exported(workspace, id, query, listener)?;
    workspace.history.add_action(&command::export(id, &name, query))?;
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for file in &files {
        zip.start_file(format!("{name}/{}", file.name), SimpleFileOptions::default())
            .map_err(Refused::failed)?;
        zip.write_all(&file.bytes).map_err(Refused::failed)?;
    }
    let bytes = zip.finish().map_err(Refused::failed)?.into_inner();
    let form = source(query)?.name();
    Ok((format!("{name}-{form}.zip"), bytes))
}
