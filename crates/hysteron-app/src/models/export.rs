//! A model as source code: its files, to look at or in an archive.

use std::io::{Cursor, Write};

use hysteron_export::{
    AxesExportRequest, AxesExported, ExportRequest, Exported, Form, Means, NamedFile, Precision, export,
    export_axes, name_of,
};
use hysteron_identify::Listener;
use hysteron_model::Finding;
use hysteron_model::model::{Capability, Hammerstein};
use zip::write::SimpleFileOptions;

use crate::api::{DownloadQuery, ExportFile, Preview};
use crate::clock::today;
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::{Workspace, stem_of};

/// Beginning of every name in the source: given, else from the model's name.
fn name_for(id: &str, query: &DownloadQuery) -> String {
    query.name.clone().unwrap_or_else(|| name_of(stem_of(id)))
}

/// The form of source code that is asked for.
fn source(query: &DownloadQuery) -> Answer<Form> {
    let none = || Refused::bad("only source code can be looked at before the download");
    query.form.source().ok_or_else(none)
}

/// The files of an export, and what is said of them.
struct Source {
    name: String,
    files: Vec<NamedFile>,
    states: usize,
    error: f64,
    findings: Vec<Finding>,
}

fn exported(
    workspace: &Workspace,
    id: &str,
    query: &DownloadQuery,
    listener: Listener<'_>,
) -> Answer<Source> {
    let form = source(query)?;
    let (model, read) = workspace.model_and_source(id)?;
    let single = query.single && form.has_single_precision();
    let float = if single { Precision::F32 } else { Precision::F64 };
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    if model.channels().is_some() {
        let request = AxesExportRequest {
            form,
            float,
            name: name_for(id, query),
            sample_rate_hz: query.sample_rate_hz,
            inverse: query.inverse,
            decoupling: query.decoupling_request(),
            controller: query.controller,
            model_sha256: Some(read.sha256),
            date: Some(today()),
        };
        let means = Means { compiler: &compiler, listener };
        let found = export_axes(&model, &request, means).map_err(Refused::cannot)?;
        let AxesExported { subject, files, findings } = found;
        let held = &subject.law().held;
        let (states, error) = (held.model.states(), held.error);
        return Ok(Source { name: request.name, files, states, error, findings });
    }
    if !query.ranges.is_empty() || query.level.is_some() {
        return Err(Refused::bad("several ranges and a level go with models of several axes"));
    }
    let body = model.hammerstein(Capability::Export).map_err(Refused::cannot)?;
    let request = ExportRequest {
        float,
        sample_rate_hz: query.sample_rate_hz,
        accuracy: query.accuracy,
        lowest_frequency_hz: query.lowest_frequency_hz,
        inverse: query.inverse.then(|| query.inverse_request()),
        controller: query.controller,
        model_sha256: Some(read.sha256),
        date: Some(today()),
        ..ExportRequest::new(form, &name_for(id, query))
    };
    let found = export(body, &request, Means { compiler: &compiler, listener }).map_err(Refused::cannot)?;
    let Exported { subject, files, findings } = found;
    let dynamics = &subject.realisation.dynamics;
    let (states, error) = (dynamics.states(), dynamics.frequency_error);
    Ok(Source { name: subject.name, files, states, error, findings })
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
    let Source { name, files, states, error, findings } = exported(workspace, id, query, listener)?;
    let shown = |file: NamedFile| ExportFile {
        name: file.name,
        bytes: file.bytes.len(),
        text: String::from_utf8(file.bytes).ok(),
    };
    Ok(Preview {
        files: files.into_iter().map(shown).collect(),
        states: Some(states),
        error: Some(error),
        findings,
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
    let Source { name, files, .. } = exported(workspace, id, query, listener)?;
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
