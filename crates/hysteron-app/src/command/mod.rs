//! The commands that do what the page does, for a shell in the workspace's folder and in Python.

mod fit;
mod model;
mod operation;
mod script;

pub(crate) use fit::{compare, compare_axes, identify};
pub(crate) use model::{decouple, design, export, invert, track, track_axes, validate};
pub(crate) use operation::{adapt, frequency_response, prepare, realise, recalibrate, simulate};
pub(crate) use script::scripts;

use hysteron_report::shell;

use crate::api::{Command, RecordEntry, RecordSettings, Role};

/// A text as a Python string.
pub(crate) fn text(value: &str) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// A command line being written.
#[derive(Default)]
struct Words(Vec<String>);

impl Words {
    fn new(command: &str) -> Self {
        Self(vec!["hysteron".to_owned(), command.to_owned()])
    }

    fn word(mut self, word: &str) -> Self {
        // A name that looks like a flag.
        let word = if word.starts_with('-') { format!("./{word}") } else { word.to_owned() };
        self.0.push(shell::word(&word));
        self
    }

    fn words<'a>(self, words: impl IntoIterator<Item = &'a str>) -> Self {
        words.into_iter().fold(self, Self::word)
    }

    fn flag(mut self, flag: &str) -> Self {
        self.0.push(flag.to_owned());
        self
    }

    fn with(mut self, flag: &str, value: impl ToString) -> Self {
        self.0.push(flag.to_owned());
        self.0.push(shell::word(&value.to_string()));
        self
    }

    fn maybe(self, flag: &str, value: Option<impl ToString>) -> Self {
        match value {
            Some(value) => self.with(flag, value),
            None => self,
        }
    }

    fn when(self, flag: &str, condition: bool) -> Self {
        if condition { self.flag(flag) } else { self }
    }

    /// Columns, scales, dead band and cut of the first record; [`beside`] says so where others have their own.
    fn columns(self, records: &[RecordEntry]) -> Self {
        let Some(first) = records.first().map(|record| &record.settings) else { return self };
        let mut words = self
            .maybe("--time", first.time.as_ref())
            .maybe("--input", first.input.as_ref())
            .maybe("--output", first.output.as_ref())
            .maybe("--sample-rate", first.sample_rate_hz)
            .maybe("--from", first.from_s)
            .maybe("--to", first.to_s);
        for scale in &first.scales {
            words = words.with("--scale", scale);
        }
        words.maybe("--dead-band", first.dead_band).maybe("--dead-zone", first.dead_zone)
    }

    fn done(self) -> String {
        self.0.join(" ")
    }
}

/// Arguments of a Python call being written.
#[derive(Default)]
struct Arguments(Vec<String>);

impl Arguments {
    fn text(mut self, name: &str, value: Option<&String>) -> Self {
        self.0.extend(value.map(|value| format!("{name}={}", text(value))));
        self
    }

    fn value(mut self, name: &str, value: Option<impl ToString>) -> Self {
        self.0.extend(value.map(|value| format!("{name}={}", value.to_string())));
        self
    }

    fn when(mut self, name: &str, condition: bool) -> Self {
        self.0.extend(condition.then(|| format!("{name}=True")));
        self
    }

    fn plain(mut self, value: String) -> Self {
        self.0.push(value);
        self
    }

    fn done(self) -> String {
        self.0.join(", ")
    }
}

/// `hy.read([…])` of records.
fn read(records: &[RecordEntry]) -> String {
    let ids: Vec<String> = records.iter().map(|record| text(&record.id)).collect();
    let settings = records.first().map(|record| record.settings.clone()).unwrap_or_default();
    let arguments = Arguments::default()
        .plain(format!("[{}]", ids.join(", ")))
        .text("time", settings.time.as_ref())
        .text("input", settings.input.as_ref())
        .text("output", settings.output.as_ref())
        .value("fs", settings.sample_rate_hz)
        .value("start", settings.from_s)
        .value("stop", settings.to_s)
        .value("dead_band", settings.dead_band)
        .value("dead_zone", settings.dead_zone);
    format!("hy.read({})", arguments.done())
}

/// Texts separated by commas; `None` where there is none.
fn joined(texts: &[String]) -> Option<String> {
    (!texts.is_empty()).then(|| texts.join(","))
}

fn ids(records: &[RecordEntry]) -> impl Iterator<Item = &str> {
    records.iter().map(|record| record.id.as_str())
}

/// A command, with a comment on what is said of the records and is no part of it.
fn beside(command: Command, records: &[RecordEntry]) -> Command {
    let settings = || records.iter().map(|record| &record.settings);
    let of_one = |one: &RecordSettings| RecordSettings {
        masks: Vec::new(),
        role: Role::default(),
        continues: None,
        ..one.clone()
    };
    let differ = settings().zip(settings().skip(1)).any(|(one, next)| of_one(one) != of_one(next));
    let own = differ.then_some("columns, cut and scales are those of the first record");
    let masks = settings().any(|one| !one.masks.is_empty()).then_some("masks are left out");
    let scales = settings().any(|one| !one.scales.is_empty()).then_some("scales are left out");
    let noted = |text: String, left: &[Option<&str>]| match left.iter().flatten().copied().collect::<Vec<_>>()
    {
        left if left.is_empty() => text,
        left => format!("{text}  # {}", left.join("; ")),
    };
    let Command { shell, python } = command;
    Command { shell: noted(shell, &[own, masks]), python: noted(python, &[own, masks, scales]) }
}

/// `hysteron inspect`.
pub(crate) fn inspect(records: &[RecordEntry]) -> Command {
    let shell = Words::new("inspect").words(ids(records)).columns(records).done();
    beside(Command { shell, python: format!("print(hy.inspect({}))", read(records)) }, records)
}

/// `hysteron rig`.
pub(crate) fn rig(folder: &str, seed: u64, truth: &str, plan: &str) -> Command {
    let words = Words::new("rig").with("--out-dir", folder).with("--seed", seed);
    let shell = words.with("--truth", truth).with("--plan", plan).done();
    let python = format!("# {shell}");
    Command { shell, python }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_cannot_end_its_word() {
        assert_eq!(shell::word("a b'; rm *.csv"), r"'a b'\''; rm *.csv'");
        assert_eq!(Words::new("inspect").word("-x.csv").done(), "hysteron inspect ./-x.csv");
        assert_eq!(text("a\"\n"), r#""a\"\n""#);
    }

    #[test]
    fn what_is_no_part_of_a_command_stands_beside_it() {
        let entry = |settings| RecordEntry { id: "run.csv".into(), settings, ..RecordEntry::default() };
        let plain = inspect(&[entry(RecordSettings::default()), entry(RecordSettings::default())]);
        assert_eq!(plain.shell, "hysteron inspect run.csv run.csv");
        let masked = RecordSettings { masks: vec![[0.0, 1.0]], ..RecordSettings::default() };
        assert!(inspect(&[entry(masked)]).shell.ends_with("  # masks are left out"));
        let cut = RecordSettings { from_s: Some(1.0), ..RecordSettings::default() };
        let both = inspect(&[entry(RecordSettings::default()), entry(cut)]);
        assert!(both.python.ends_with("  # columns, cut and scales are those of the first record"));
    }
}
