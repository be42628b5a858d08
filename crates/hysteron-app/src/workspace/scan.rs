//! What is in the folder, by the endings of the files.

use std::collections::VecDeque;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use super::names::{DEEPEST, HISTORY, TRASH, id_of};

/// Most files listed.
const MOST: usize = 10_000;
/// Most entries looked at, so that a folder of anything does not keep a processor busy.
const MOST_ENTRIES: usize = 100_000;

/// Kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A record.
    Record,
    /// A model.
    Model,
    /// A report.
    Report,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Record => "record",
            Self::Model => "model",
            Self::Report => "report",
        }
    }
}

/// A file of the workspace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub id: String,
    pub kind: Kind,
    pub bytes: u64,
    /// Last change, since 1970 \[ns\].
    pub changed_ns: u128,
}

impl Found {
    /// A text that changes with the file.
    pub(crate) fn stamp(&self) -> String {
        format!("{} {}", self.bytes, self.changed_ns)
    }

    /// Last change (ISO 8601, UTC).
    pub(crate) fn modified(&self) -> String {
        let seconds = u64::try_from(self.changed_ns / 1_000_000_000).unwrap_or(0);
        hysteron_model::model_file::timestamp(seconds)
    }
}

/// The files of the workspace, in the order of their identifiers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Listing(Vec<Found>);

impl Listing {
    /// The files of a kind.
    pub(crate) fn of(&self, kind: Kind) -> impl Iterator<Item = &Found> {
        self.0.iter().filter(move |found| found.kind == kind)
    }
}

/// Kind of a file, by its name; `None` for a file that is not shown.
pub(super) fn kind_of(name: &str) -> Option<Kind> {
    let (_, ending) = name.rsplit_once('.')?;
    let ending = ending.to_ascii_lowercase();
    match ending.as_str() {
        // Searches of an interrupted fit, truth and plan of the bench.
        "json" if name.ends_with(".searches.json") || is_of_bench(name) => None,
        "json" => Some(Kind::Model),
        "html" | "htm" => Some(Kind::Report),
        ending if hysteron_io::record_extensions().any(|known| known == ending) => Some(Kind::Record),
        _ => None,
    }
}

/// Truth or plan of the bench: `truth.json`, `plan-2.json`.
fn is_of_bench(name: &str) -> bool {
    let stem = name.strip_suffix(".json").unwrap_or(name);
    let number =
        |rest: &str| rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.parse::<u32>().is_ok());
    ["truth", "plan"].iter().any(|word| stem.strip_prefix(word).is_some_and(number))
}

/// A file at `path`.
pub(super) fn file_at(folder: &Path, path: &Path) -> Option<Found> {
    let kind = kind_of(path.file_name()?.to_str()?)?;
    let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    let changed = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
    let changed_ns = changed.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
    Some(Found { id: id_of(folder, path)?, kind, bytes: about.len(), changed_ns })
}

pub(super) fn scan(folder: &Path) -> Listing {
    let mut found = Vec::new();
    let mut left = MOST_ENTRIES;
    // The nearest folders first.
    let mut folders = VecDeque::from([(folder.to_path_buf(), 1)]);
    while let Some((place, depth)) = folders.pop_front() {
        // A folder that cannot be read is not shown.
        let Ok(entries) = std::fs::read_dir(&place) else { continue };
        for entry in entries.flatten() {
            if left == 0 {
                break;
            }
            left -= 1;
            let name = entry.file_name();
            let Some(name) = name.to_str() else { continue };
            let reserved = depth == 1 && (name == TRASH || name.starts_with(HISTORY));
            if name.starts_with('.') || reserved || name.chars().any(char::is_control) {
                continue;
            }
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() && depth < DEEPEST {
                folders.push_back((entry.path(), depth + 1));
            } else if kind.is_file() && found.len() < MOST {
                found.extend(file_at(folder, &entry.path()));
            }
        }
    }
    found.sort_by(|a, b| a.id.cmp(&b.id));
    Listing(found)
}
