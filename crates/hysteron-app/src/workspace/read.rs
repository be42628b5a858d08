//! Records in memory, as the person chose columns, scales, cut and masks; a bound on all of them together.

use std::path::Path;
use std::sync::{Arc, OnceLock, PoisonError};

use hysteron_identify::structure::{Prospects, prospects};
use hysteron_io::{IoError, ReadOptions, holds_named_arrays, read_part, read_record};
use hysteron_model::Finding;
use hysteron_model::force::with_rate;
use hysteron_model::record::{
    ChannelChoice, Cut, InputOutput, Inspection, Record, Scale, Source, find_periods, inspect,
};

use super::Workspace;
use super::scan::{Found, file_at};
use crate::api::{Problem, RecordSettings};
use crate::refused::{Answer, Refused};

/// Bytes of a number.
const NUMBER: u64 = 8;

/// A record that was read.
pub(crate) struct ReadRecord {
    /// All channels.
    pub record: Record,
    /// Input and output, or why they cannot be decided.
    pub data: Result<InputOutput, Problem>,
    /// Choices made automatically.
    pub notes: Vec<Finding>,
    inspection: OnceLock<Inspection>,
    prospects: OnceLock<Prospects>,
    periods: OnceLock<Option<(f64, usize)>>,
}

impl ReadRecord {
    /// Input and output.
    ///
    /// # Errors
    /// If they cannot be decided.
    pub(crate) fn data(&self) -> Answer<&InputOutput> {
        self.data.as_ref().map_err(|problem| Refused::cannot(problem.clone()))
    }

    /// What is in it.
    ///
    /// # Errors
    /// Those of [`Self::data`].
    pub(crate) fn inspection(&self) -> Answer<&Inspection> {
        let data = self.data()?;
        Ok(self.inspection.get_or_init(|| inspect(data)))
    }

    /// What it determines alone.
    ///
    /// # Errors
    /// Those of [`Self::data`].
    pub(crate) fn prospects(&self) -> Answer<&Prospects> {
        let data = self.data()?;
        Ok(self.prospects.get_or_init(|| prospects(std::slice::from_ref(data))))
    }

    /// Samples of a period, and whole periods, where it repeats: less work than the inspection.
    pub(crate) fn periods(&self) -> Option<(f64, usize)> {
        let data = self.data.as_ref().ok()?;
        *self.periods.get_or_init(|| {
            let found = find_periods(data).ok()?;
            Some((found.period_samples, found.count))
        })
    }

    fn bytes(&self) -> u64 {
        let channels = self.record.channels.len() as u64 + 2;
        NUMBER * channels * self.record.len() as u64
    }
}

/// Records in memory.
pub(super) struct Cache {
    kept: Vec<Kept>,
    most_bytes: u64,
    used: u64,
}

struct Kept {
    id: String,
    stamp: String,
    read: Result<Arc<ReadRecord>, Problem>,
    bytes: u64,
    last_used: u64,
}

impl Cache {
    pub(super) fn new(most_bytes: u64) -> Self {
        Self { kept: Vec::new(), most_bytes, used: 0 }
    }

    fn get(&mut self, id: &str, stamp: &str) -> Option<Result<Arc<ReadRecord>, Problem>> {
        self.used += 1;
        let kept = self.kept.iter_mut().find(|kept| kept.id == id && kept.stamp == stamp)?;
        kept.last_used = self.used;
        Some(kept.read.clone())
    }

    /// Keeps a record, and lets those go that were used longest ago where they are too many.
    fn keep(&mut self, id: &str, stamp: &str, read: Result<Arc<ReadRecord>, Problem>) {
        self.used += 1;
        self.kept.retain(|kept| kept.id != id);
        let bytes = read.as_ref().map_or(0, |read| read.bytes());
        let (id, stamp) = (id.to_owned(), stamp.to_owned());
        self.kept.push(Kept { id, stamp, read, bytes, last_used: self.used });
        while self.kept.len() > 1 && self.kept.iter().map(|kept| kept.bytes).sum::<u64>() > self.most_bytes {
            let oldest = self.kept.iter().enumerate().min_by_key(|(_, kept)| kept.last_used);
            let Some((oldest, _)) = oldest else { break };
            self.kept.swap_remove(oldest);
        }
    }
}

impl Workspace {
    /// A text that changes with the file and with what was said of it.
    pub(super) fn stamp(&self, found: &Found, settings: &RecordSettings) -> String {
        let said = serde_json::to_string(settings).unwrap_or_default();
        format!("{} {said}", found.stamp())
    }

    /// A text that changes with the file of a record or a model and with what was said of it.
    ///
    /// # Errors
    /// If there is no such file.
    pub(crate) fn stamp_of(&self, id: &str) -> Answer<String> {
        let missing = || Refused::missing(format!("there is no `{}`", super::shown(id)));
        let found = file_at(self.folder(), &self.existing(id)?).ok_or_else(missing)?;
        Ok(format!("{id} {}", self.stamp(&found, &self.history.settings(id)?)))
    }

    /// The record, if it is in memory and its file has not changed.
    pub(super) fn in_memory(&self, id: &str, stamp: &str) -> Option<Arc<ReadRecord>> {
        self.cache.lock().unwrap_or_else(PoisonError::into_inner).get(id, stamp)?.ok()
    }

    /// The record, from memory where its file has not changed.
    ///
    /// # Errors
    /// If there is none, or it is no readable record.
    pub(crate) fn read(&self, id: &str) -> Answer<Arc<ReadRecord>> {
        let path = self.existing(id)?;
        let missing = || Refused::missing(format!("`{}` is no record", super::shown(id)));
        let found = file_at(self.folder(), &path).ok_or_else(missing)?;
        let settings = self.history.settings(id)?;
        let stamp = self.stamp(&found, &settings);
        let cached = self.cache.lock().unwrap_or_else(PoisonError::into_inner).get(id, &stamp);
        let read = cached.unwrap_or_else(|| {
            let read = read_as_said(&path, id, &settings).map(Arc::new);
            self.cache.lock().unwrap_or_else(PoisonError::into_inner).keep(id, &stamp, read.clone());
            read
        });
        read.map_err(Refused::cannot)
    }
}

impl Workspace {
    /// Keeps a record that was just read as it is, unless something else was said of its name before.
    pub(super) fn keep_read(&self, id: &str, read: ReadRecord) -> Answer<()> {
        let settings = self.history.settings(id)?;
        let found = file_at(self.folder(), &self.path(id)?);
        if let Some(found) = found.filter(|_| settings == RecordSettings::default()) {
            let stamp = self.stamp(&found, &settings);
            let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
            cache.keep(id, &stamp, Ok(Arc::new(read)));
        }
        Ok(())
    }
}

/// Reads the record at `path` as `settings` say.
pub(super) fn read_as_said(path: &Path, id: &str, settings: &RecordSettings) -> Result<ReadRecord, Problem> {
    let of_file = |e: IoError| Problem::of_file(&e, path, id);
    let all = ReadOptions {
        time: settings.time.clone(),
        sample_rate_hz: settings.sample_rate_hz,
        cut: Cut { from_s: settings.from_s, to_s: settings.to_s, ..Cut::default() },
        ..ReadOptions::default()
    };
    let choice = ChannelChoice { input: settings.input.clone(), output: settings.output.clone() };
    let chosen = ReadOptions { input: choice.input.clone(), output: choice.output.clone(), ..all.clone() };
    // Of a file of named arrays, only those that are chosen may fit together.
    let arrays = holds_named_arrays(path).map_err(of_file)?;
    let (mut record, choice) = if arrays && (choice.input.is_some() || choice.output.is_some()) {
        let part = read_part(path, &chosen).map_err(of_file)?;
        (part.record, part.chosen)
    } else {
        (read_record(path, &all).map_err(of_file)?, choice)
    };
    // Name and path as a person in the folder would give them.
    id.rsplit('/').next().unwrap_or(id).clone_into(&mut record.name);
    if let Some(Source { path, .. }) = &mut record.source {
        id.clone_into(path);
    }
    for text in &settings.scales {
        let scale: Scale = text.parse().map_err(Problem::from)?;
        record = scale.apply(&record).map_err(Problem::from)?;
    }
    let mut notes = record.select(&choice).map(|selection| selection.notes).unwrap_or_default();
    if let Some(band) = settings.band().map_err(Problem::from)? {
        let (counted, told) = record.with_dead_band(band, &choice).map_err(Problem::from)?;
        record = counted;
        notes.push(told);
    }
    let data = record.input_output(&choice).map(|data| masked(data, &settings.masks));
    let data = data.map_err(Problem::from).and_then(|data| match &settings.rate {
        Some(column) => with_rate(data, &record, column).map_err(|e| Problem::new(e, None)),
        None => Ok(data),
    });
    Ok(ReadRecord {
        data,
        record,
        notes,
        inspection: OnceLock::new(),
        prospects: OnceLock::new(),
        periods: OnceLock::new(),
    })
}

fn masked(mut data: InputOutput, masks: &[[f64; 2]]) -> InputOutput {
    if masks.is_empty() {
        return data;
    }
    let samples = data.len();
    let mut valid = data.valid.take().unwrap_or_else(|| vec![true; samples]);
    for (k, valid) in valid.iter_mut().enumerate() {
        let time = data.time.time_s(k).unwrap_or(k as f64);
        *valid &= !masks.iter().any(|[from, to]| (*from..=*to).contains(&time));
    }
    InputOutput { valid: Some(valid), ..data }
}
