//! Where a source comes from: the model file, its records, the day.

use std::path::Path;

use hysteron_io::{NamedFile, sha256};
use hysteron_model::model_file::{ModelFile, Provenance};

use crate::rust_crate::RUNTIME;

/// What a header says of its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// SHA-256 of the model file; that of the file as this program writes it where none was read.
    pub model_sha256: String,
    /// Day of the export; `None` is left out, and the source is the same on every day.
    pub date: Option<String>,
    provenance: Option<Provenance>,
}

impl Origin {
    /// Of a model's data, without a date.
    pub(crate) fn of(file: &ModelFile) -> Self {
        let model_sha256 = file.to_json().map(|text| sha256(text.as_bytes())).unwrap_or_default();
        Self { model_sha256, ..Self::made(file.provenance.as_ref()) }
    }

    /// How a model was made, without its file and a date.
    pub(crate) fn made(provenance: Option<&Provenance>) -> Self {
        Self { model_sha256: String::new(), date: None, provenance: provenance.cloned() }
    }

    /// Names model and program in every source that has no header with them: tests, examples, tables. The
    /// source of the runtime is not the model's.
    pub(crate) fn mark(&self, files: &mut [NamedFile]) {
        if self.model_sha256.is_empty() {
            return;
        }
        let own = files.iter_mut().filter(|file| !file.name.starts_with(RUNTIME));
        for file in own {
            let Some((_, extension)) = file.name.rsplit_once('.') else { continue };
            let (open, close) = match extension {
                "c" | "h" => ("/*", " */"),
                "rs" => ("//", ""),
                "m" => ("%", ""),
                "toml" => ("#", ""),
                _ => continue,
            };
            let text = String::from_utf8_lossy(&file.bytes);
            if text.contains(&self.model_sha256) {
                continue;
            }
            let mark = self.lines().into_iter().take(2).collect::<Vec<_>>().join(" ");
            // A function of MATLAB begins with its name and what it does.
            let before: usize = match extension {
                "m" => text.split_inclusive('\n').take(2).map(str::len).sum(),
                _ => 0,
            };
            let (head, rest) = text.split_at(before);
            file.bytes = format!("{head}{open} {mark}{close}\n{rest}").into_bytes();
        }
    }

    /// Lines of a header.
    pub(crate) fn lines(&self) -> Vec<String> {
        let program = format!("Written by hysteron export {}", env!("CARGO_PKG_VERSION"));
        let on = |date: &Option<String>| date.as_ref().map(|date| format!(", {date}")).unwrap_or_default();
        let mut lines = vec![format!("{program}{}.", on(&self.date))];
        if !self.model_sha256.is_empty() {
            lines.push(format!("Model file: SHA-256 {}.", self.model_sha256));
        }
        if let Some(provenance) = &self.provenance {
            lines.push(format!("Identified by {}{}, from", provenance.program, on(&provenance.created)));
            for record in &provenance.records {
                let path = Path::new(&record.path);
                let name =
                    path.file_name().map_or(record.path.as_str().into(), |name| name.to_string_lossy());
                let hash = record.sha256.as_ref().map_or("no file".into(), |hash| format!("SHA-256 {hash}"));
                lines.push(format!("  {name} ({hash})"));
            }
        }
        lines
    }
}
