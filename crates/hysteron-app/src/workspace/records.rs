//! Entries of records in the list, and a record in full.

use hysteron_identify::usual_kind;
use hysteron_io::{ReadOptions, contents, write_record};
use hysteron_model::record::{InputOutput, Inspection, Periods, Record, TimeBase, range_of, split_header};
use hysteron_report::record_curves::is_simulated;

use super::scan::{Found, Kind, file_at};
use super::{ReadRecord, Workspace, device_of};
use crate::api::{Column, ColumnUse, Command, Gap, RecordDetail, RecordEntry, RecordSettings, Role};
use crate::command;
use crate::draw::glyph;
use crate::refused::{Answer, Refused};

/// Samples above which a record is shown before it is inspected.
const LONG: usize = 200_000;

/// Fewest samples from which anything can be identified.
const FEWEST: usize = 20;

impl Workspace {
    /// Writes a record of what a model predicts or a drive made for it, which no fit may learn from; a file of
    /// this name goes to the trash folder.
    ///
    /// # Errors
    /// For a name that is none, a file that cannot be written.
    pub(crate) fn keep_predicted(&self, id: &str, record: &Record) -> Answer<()> {
        let path = self.to_write(id, Kind::Record)?;
        self.history.say_role(id, Role::Unused)?;
        write_record(&path, record).map_err(Refused::failed)
    }

    /// The records: what is known of each, at once. A record that was not read yet is marked, and the
    /// identifiers of those are returned too.
    ///
    /// # Errors
    /// If the history cannot be read.
    pub(crate) fn records(&self) -> Answer<(Vec<RecordEntry>, Vec<String>)> {
        let mut unread = Vec::new();
        let mut entries = Vec::new();
        for found in self.look().of(Kind::Record) {
            let settings = self.history.settings(&found.id)?;
            let stamp = self.stamp(found, &settings);
            let known = self.history.seen(&found.id, &stamp)?;
            entries.push(known.unwrap_or_else(|| {
                unread.push(found.id.clone());
                let bare = bare(found, settings);
                match self.in_memory(&found.id, &stamp) {
                    Some(read) => glimpsed(bare, &read),
                    None => RecordEntry { reading: true, ..bare },
                }
            }));
        }
        Ok((entries, unread))
    }

    /// The entry of a record, which is read where it is not known.
    ///
    /// # Errors
    /// If there is no such record.
    pub(crate) fn entry(&self, id: &str) -> Answer<RecordEntry> {
        let found = self.found_record(id)?;
        let settings = self.history.settings(id)?;
        let stamp = self.stamp(&found, &settings);
        if let Some(known) = self.history.seen(id, &stamp)? {
            return Ok(known);
        }
        let entry = match self.read(id) {
            Ok(read) => described(bare(&found, settings), &read),
            Err(refused) => RecordEntry { error: Some(refused.into_problem()), ..bare(&found, settings) },
        };
        self.history.keep_seen(id, &stamp, &entry)?;
        Ok(entry)
    }

    /// The entry of a record that was just read; of a long one without its inspection, which takes longer
    /// than its first curve should: it is marked as being read.
    ///
    /// # Errors
    /// If there is no such record.
    pub(crate) fn first_look(&self, id: &str) -> Answer<RecordEntry> {
        let read = match self.read(id) {
            Ok(read) if read.record.len() > LONG => read,
            _ => return self.entry(id),
        };
        if read.data.is_err() {
            return self.entry(id);
        }
        Ok(glimpsed(bare(&self.found_record(id)?, self.history.settings(id)?), &read))
    }

    /// The file of a record.
    ///
    /// # Errors
    /// If there is no such record.
    pub(crate) fn found_record(&self, id: &str) -> Answer<Found> {
        let path = self.existing(id)?;
        let found = file_at(self.folder(), &path).filter(|found| found.kind == Kind::Record);
        found.ok_or_else(|| Refused::missing(format!("`{}` is no record", super::shown(id))))
    }

    /// A record in full.
    ///
    /// # Errors
    /// If there is no such record.
    pub(crate) fn detail(&self, id: &str) -> Answer<RecordDetail> {
        let entry = self.entry(id)?;
        let options = ReadOptions { time: entry.settings.time.clone(), ..ReadOptions::default() };
        let listed = contents(&self.path(id)?, &options).unwrap_or_default();
        let mut detail = RecordDetail {
            columns: listed.into_iter().map(column).collect(),
            inspection: None,
            gaps: Vec::new(),
            notes: Vec::new(),
            prospects: None,
            command: command::inspect(std::slice::from_ref(&entry)),
            entry,
        };
        if let Ok(read) = self.read(id) {
            detail.notes.clone_from(&read.notes);
            if let (Ok(data), Ok(inspection)) = (read.data(), read.inspection()) {
                detail.inspection = Some(inspection.summary(data));
                let gaps = data.time.gaps().into_iter();
                detail.gaps = gaps.map(|gap| Gap { from_s: gap.from_s, to_s: gap.to_s }).collect();
                detail.prospects = read.prospects().ok().cloned();
                mark_used(&mut detail.columns, &detail.entry);
                mark_time(&mut detail.columns, &read.record);
            }
        }
        Ok(detail)
    }

    /// Command that prints what is known of records.
    pub(crate) fn inspect_command(&self, ids: &[String]) -> Answer<Command> {
        let entries = ids.iter().map(|id| self.entry(id)).collect::<Answer<Vec<_>>>()?;
        Ok(command::inspect(&entries))
    }
}

fn column(content: hysteron_io::Content) -> Column {
    let hysteron_io::Content { path, shape, unit, kind } = content;
    Column { path, shape, unit, kind, used_as: None }
}

/// Marks the columns that are input and output: a name is a column's path, or its end, with or without unit.
fn mark_used(columns: &mut [Column], entry: &RecordEntry) {
    let named = |path: &str, name: &str| {
        let last = path.rsplit(['/', '.', '!']).next().unwrap_or(path);
        let bare = split_header(last).0;
        path == name || last == name || bare == name
    };
    let uses = [
        (&entry.input, ColumnUse::Input),
        (&entry.output, ColumnUse::Output),
        (&entry.settings.rate, ColumnUse::Rate),
    ];
    for (name, used) in uses {
        let Some(name) = name else { continue };
        if let Some(column) = columns.iter_mut().find(|column| named(&column.path, name)) {
            column.used_as = Some(used);
        }
    }
}

/// Marks the time column: the only column of numbers that is no channel, where the record has times.
fn mark_time(columns: &mut [Column], record: &Record) {
    if record.time == TimeBase::Unknown {
        return;
    }
    let is_channel = |path: &str| {
        let (bare, _) = split_header(path);
        bare == "valid" || record.channels.iter().any(|c| c.header() == path || c.name == bare)
    };
    let mut others = columns.iter_mut().filter(|c| c.kind == "numbers" && !is_channel(&c.path));
    if let (Some(column), None) = (others.next(), others.next()) {
        column.used_as.get_or_insert(ColumnUse::Time);
    }
}

/// What is known without reading the file.
fn bare(found: &Found, settings: RecordSettings) -> RecordEntry {
    RecordEntry {
        id: found.id.clone(),
        device: device_of(&found.id).to_owned(),
        bytes: found.bytes,
        modified: found.modified(),
        reading: false,
        samples: 0,
        duration_s: None,
        rate_hz: None,
        segments: 0,
        input: None,
        input_unit: String::new(),
        output: None,
        output_unit: String::new(),
        usual_kind: None,
        settings,
        glyph: Vec::new(),
        warning: None,
        error: None,
        usable: false,
        simulated: is_simulated(found.id.rsplit('/').next().unwrap_or_default()),
    }
}

fn described(entry: RecordEntry, read: &ReadRecord) -> RecordEntry {
    let samples = read.record.len();
    let (data, inspection) = match (&read.data, read.inspection()) {
        (Ok(data), Ok(inspection)) => (data, inspection),
        (Err(problem), _) => return RecordEntry { samples, error: Some(problem.clone()), ..entry },
        (_, Err(refused)) => {
            return RecordEntry { samples, error: Some(refused.into_problem()), ..entry };
        }
    };
    RecordEntry {
        duration_s: inspection.duration_s,
        rate_hz: inspection.sample_rate_hz,
        segments: inspection.segments.len().max(1),
        glyph: glyph(data, period(inspection)),
        warning: inspection.findings.iter().find(|f| f.is_warning()).map(|f| f.text.clone()),
        ..with_channels(entry, data)
    }
}

/// What is known of a record before its inspection; it is marked as being read.
fn glimpsed(entry: RecordEntry, read: &ReadRecord) -> RecordEntry {
    let entry = RecordEntry { reading: true, ..entry };
    let Ok(data) = &read.data else { return entry };
    let extent = data.time.extent_s(data.len());
    RecordEntry {
        duration_s: extent.map(|(first, last)| last - first),
        rate_hz: data.sample_rate_hz(),
        glyph: glyph(data, None),
        ..with_channels(entry, data)
    }
}

fn with_channels(entry: RecordEntry, data: &InputOutput) -> RecordEntry {
    let moves = |samples: &[f64]| {
        let (low, high) = range_of(samples);
        high > low
    };
    RecordEntry {
        usable: data.len() >= FEWEST && moves(&data.u) && moves(&data.y),
        samples: data.len(),
        input: Some(data.input.clone()),
        input_unit: data.u_unit.to_string(),
        output: Some(data.output.clone()),
        output_unit: data.y_unit.to_string(),
        usual_kind: Some(usual_kind([data])),
        ..entry
    }
}

/// Samples of a settled period.
fn period(inspection: &Inspection) -> Option<usize> {
    let settled = |periods: &Periods| periods.count > periods.settling;
    let periods = inspection.periods.filter(settled)?;
    Some(periods.period_samples.round() as usize)
}
