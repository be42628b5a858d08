//! `hysteron prepare`: records cut, joined, scaled, detrended, resampled, as one new record.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_io::{PartRead, ReadOptions, Rename, read_part, write_record};
use hysteron_model::record::{Cut, Prepare, PreparedSummary, Scale, Turns};
use hysteron_report::results::preparation;
use rayon::prelude::*;
use serde::Serialize;

use crate::columns::{TimeFlags, Unreadable};
use crate::console;
use crate::cut::CutFlags;
use crate::failure::Failure;
use crate::numbers::hertz;
use crate::output::{self, OutFile};

/// Cut, join, scale, detrend and resample records into one new record.
#[derive(Args)]
#[command(
    after_help = "The order is fixed: rename, drop; --where, --from, --to, then --turns in the part kept (of \
    every record); join, in the order given; scale; remove means, then trends; resample. The steps after \
    --rename use the new column names. All other columns are kept, except a text column that --where \
    uses.\n\n\
    Records are joined by their own time stamps, which must increase from record to record.\n\n\
    --rate applies an anti-aliasing low-pass; a column of labels (a segment's number) is held. Non-uniform \
    time stamps (segments of different rates) are interpolated; a gap, longer than three of its neighbours' \
    sample periods, is bridged by a straight line, whose samples are 0 in the column valid.\n\n\
    The file written is a header line t_s,u_V,…,valid and one line per sample, or an NPZ or MAT file of the \
    same columns. Missing and non-finite numbers in the part kept are refused.\n\n\
    Example: hysteron prepare run.csv --from 1.5s --to 20s -o steady.csv\n\
    Example: hysteron prepare scan.csv --where segment=2..7 --rate 500Hz -o scan_500.csv\n\
    Example: hysteron prepare run_1.csv run_2.csv --rename ch1=u_V --scale y=2.5um/V --detrend y -o both.npz"
)]
pub struct PrepareCommand {
    /// The records, in order of time
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// File to write
    #[arg(short, long = "out", value_name = "OUT.csv|npz|mat")]
    out: OutFile,

    /// New name of a column, e.g. ch1=u_V; no number is converted; may be repeated
    #[arg(long, value_name = "OLD=NEW", value_parser = str::parse::<Rename>)]
    rename: Vec<Rename>,

    /// Columns to leave out, by their new names
    #[arg(long, value_name = "COL,COL…", value_delimiter = ',')]
    drop: Vec<String>,

    #[command(flatten)]
    cut: CutFlags,

    /// Keep samples between two turning points of the drive, counted from 1, e.g. 1:5, 3: or :5
    #[arg(
        long, value_name = "FIRST:LAST", value_parser = str::parse::<Turns>,
        help_heading = "Part of the record",
    )]
    turns: Option<Turns>,

    /// Drive of --turns: its name, with or without unit, or its number from 1
    #[arg(long, value_name = "COL", requires = "turns", help_heading = "Part of the record")]
    input: Option<String>,

    /// Scale factor of a column, e.g. y=2.5um/V or u=15V/V; may be repeated
    #[arg(long = "scale", value_name = "COL=FACTOR", value_parser = str::parse::<Scale>)]
    scales: Vec<Scale>,

    /// Columns whose mean is removed
    #[arg(long, value_name = "COL,COL…", value_delimiter = ',')]
    remove_mean: Vec<String>,

    /// Columns whose linear trend is removed, including the mean
    #[arg(long, value_name = "COL,COL…", value_delimiter = ',')]
    detrend: Vec<String>,

    /// New sample rate, in Hz or with a unit, e.g. 500Hz or 2kHz
    #[arg(long, value_name = "RATE", value_parser = hertz, allow_hyphen_values = true)]
    rate: Option<f64>,

    /// Print what was read, done and written as one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    time: TimeFlags,
}

/// A file that was read.
#[derive(Serialize)]
struct Read {
    record: String,
    file_samples: usize,
    samples: usize,
}

/// JSON output: records read, steps done, file written.
#[derive(Serialize)]
struct Written {
    file: String,
    records: Vec<Read>,
    #[serde(flatten)]
    prepared: PreparedSummary,
}

impl PrepareCommand {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_file("the record", &self.out)?;
        let options = self.options();
        let read = |path: &PathBuf| read_part(path, &options).map_err(|e| unreadable(path, e.into()));
        let parts: Vec<PartRead> = self.records.par_iter().map(read).collect::<Result<_, _>>()?;
        let read_of = |(path, part): (&PathBuf, &PartRead)| Read {
            record: path.display().to_string(),
            file_samples: part.file_samples,
            samples: part.record.len(),
        };
        let read: Vec<Read> = self.records.iter().zip(&parts).map(read_of).collect();
        let records: Vec<_> = parts.into_iter().map(|part| part.record).collect();
        let prepared = self.prepare().run(&records).map_err(|e| {
            let names: Vec<String> = self.records.iter().map(|path| path.display().to_string()).collect();
            Failure::new(format!("cannot prepare {}", names.join(", "))).because(&e).advised(e.advice())
        })?;
        write_record(&self.out, &prepared.record).map_err(|e| {
            Failure::new(format!("cannot write the record to {}", self.out.display())).because(e)
        })?;
        let written =
            Written { file: self.out.display().to_string(), records: read, prepared: prepared.summary() };
        if self.json {
            return console::json(&written);
        }
        lines(&written).iter().for_each(|line| console::message(line));
        Ok(())
    }

    fn options(&self) -> ReadOptions {
        let turns = self.turns.clone().map(|turns| Turns { column: self.input.clone(), ..turns });
        ReadOptions {
            rename: self.rename.clone(),
            leave_out: self.drop.clone(),
            cut: Cut { turns, ..self.cut.cut() },
            ..self.time.options()
        }
    }

    fn prepare(&self) -> Prepare {
        Prepare {
            scales: self.scales.clone(),
            remove_mean: self.remove_mean.clone(),
            detrend: self.detrend.clone(),
            sample_rate_hz: self.rate,
        }
    }
}

fn unreadable(path: &Path, error: Unreadable) -> Failure {
    error.at(path, "--where COL=TEXT for a text column, --drop COL for one that is not needed")
}

/// What was kept of each record, and what was done.
fn lines(written: &Written) -> Vec<String> {
    let Written { file, records, prepared } = written;
    let kept = records
        .iter()
        .filter(|read| read.samples < read.file_samples)
        .map(|read| format!("kept {} of {} samples of {}", read.samples, read.file_samples, read.record));
    kept.chain(preparation::lines(prepared, file)).collect()
}
