//! `hysteron validate`: scores of a model on records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::IdentifyError;
use hysteron_io::write_record;
use hysteron_model::model::{Capability, RunScore, Score, Signals};
use hysteron_model::record::{InputOutput, Run};
use hysteron_model::validate::{OffsetTreatment, Scoring};
use hysteron_report::validation::page;
use serde::Serialize;

use crate::axes::AxesFlags;
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::Loaded;
use crate::numbers::not_negative;
use crate::output;
use crate::result_flags::ResultFlags;
use crate::scores;
use crate::start::StartFlags;

/// Score a model on records it may not have seen: simulation from the start of each record, not prediction.
#[derive(Args)]
#[command(
    after_help = "Each record's sensor has its own zero: unless --fixed-offset is given, the mean residual is added to the \
    simulation and printed as the offset.\n\n\
    Example: hysteron validate model.json run1.csv run2.csv --skip 0.5\n\
    Example: hysteron validate model.json run1.csv --report validation.html\n\
    Example: hysteron validate model.json run1.csv -o scored.csv"
)]
pub struct Validate {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// The records
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Seconds at the start of each record that are simulated but not scored [default: 0; a quarter period where a model
    /// without dynamics meets a drive that starts with a jump]
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    skip: Option<f64>,

    /// Compare with the model's own offset instead of estimating each record's sensor offset
    #[arg(long)]
    fixed_offset: bool,

    /// The records are consecutive parts of one run on one clock: simulated at one go from the start of the first, with one offset
    #[arg(long, conflicts_with = "band")]
    continued: bool,

    /// Say how many samples lie within the 95 % band of a new measurement, from the errors in the model file
    #[arg(long)]
    band: bool,

    /// File for the samples that were scored: drive, measured output, model, residual (CSV, or NPZ by its name); one record, or
    /// one run
    #[arg(short, long = "output-file", value_name = "OUT.csv")]
    out: Option<PathBuf>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: ColumnFlags,

    #[command(flatten)]
    axes: AxesFlags,
}

#[derive(Serialize)]
struct Report {
    records: Vec<Score>,
}

/// Scores of several runs, as JSON.
#[derive(Serialize)]
struct Runs<'a> {
    runs: &'a [RunScore],
}

impl Validate {
    pub fn run(&self) -> Result<(), Failure> {
        self.result.check()?;
        if let Some(out) = &self.out {
            output::check_file("the series", out)?;
        }
        let loaded = Loaded::read(&self.model)?;
        if self.band {
            loaded.hammerstein(Capability::Bands)?;
        }
        if self.continued {
            return self.run_continued(&loaded);
        }
        let records = self.records.iter().map(|path| self.score(&loaded, path));
        let records = records.collect::<Result<Vec<_>, Failure>>()?;
        self.result.write(|| page(loaded.model(), &records, &maker()))?;
        self.write_series(&records)?;
        let records: Vec<Score> = records.into_iter().map(|(_, score)| score).collect();
        if self.result.json {
            console::json(&Report { records })
        } else {
            console::result(&self.text(&records))
        }
    }

    /// Scores of the records as parts of runs.
    fn run_continued(&self, loaded: &Loaded) -> Result<(), Failure> {
        loaded.hammerstein(Capability::Runs)?;
        let mut records = Vec::new();
        for path in &self.records {
            match loaded.read_record(path, &self.columns, &self.axes)? {
                Signals::Single(record) => records.push(record),
                Signals::Several(_) => {
                    return Err(Failure::usage("--continued takes models of one input and one output"));
                }
            }
        }
        let runs = Run::of(&records).map_err(|e| Failure::new("the records are no runs").because(e))?;
        let path = &self.records[0];
        let scores = runs.iter().map(|run| {
            let start = self.start.start(path, &run.data.time)?;
            loaded.score_run(path, run, start, &self.scoring())
        });
        let scores = scores.collect::<Result<Vec<RunScore>, Failure>>()?;
        let pairs =
            runs.iter().zip(&scores).map(|(run, s)| (Signals::Single(run.data.clone()), s.whole.clone()));
        let pairs: Vec<(Signals, Score)> = pairs.collect();
        self.result.write(|| page(loaded.model(), &pairs, &maker()))?;
        self.write_series(&pairs)?;
        if self.result.json {
            return match scores.as_slice() {
                [only] => console::json(only),
                several => console::json(&Runs { runs: several }),
            };
        }
        let shown: Vec<Score> =
            scores.iter().flat_map(|s| s.records.iter().chain([&s.whole]).cloned()).collect();
        let mut text = self.text(&shown);
        for without in scores.iter().filter_map(|s| s.whole_without_estimated_start.as_ref()) {
            text += &scores::without_estimated_start(without);
        }
        console::result(&text)
    }

    /// The samples that were scored, where a file for them was named.
    fn write_series(&self, scored: &[(Signals, Score)]) -> Result<(), Failure> {
        let Some(out) = &self.out else { return Ok(()) };
        let [(signals, score)] = scored else {
            return Err(Failure::usage("-o takes one record, or one run (--continued)")
                .hint("validate one record at a time, each with its own -o"));
        };
        let failure = || Failure::new(format!("cannot write the series to {}", out.display()));
        let series = score.series(signals).map_err(|e| failure().because(e))?;
        write_record(out, &series).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", series.len(), out.display()));
        Ok(())
    }

    fn scoring(&self) -> Scoring {
        let offset = if self.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
        Scoring { skip_s: self.skip, offset }
    }

    fn score(&self, loaded: &Loaded, path: &Path) -> Result<(Signals, Score), Failure> {
        let signals = loaded.read_record(path, &self.columns, &self.axes)?;
        let score = loaded.score(path, &signals, &self.start, &self.scoring())?;
        let score = match &signals {
            Signals::Single(record) if self.band => self.with_band(loaded, path, record, score)?,
            _ => score,
        };
        Ok((signals, score))
    }

    /// The score with how the band of a new measurement holds the record.
    fn with_band(
        &self,
        loaded: &Loaded,
        path: &Path,
        record: &InputOutput,
        score: Score,
    ) -> Result<Score, Failure> {
        let band = loaded.band(path, &record.u, &record.time, &score.simulation.start)?;
        if band.noise == 0.0 {
            return Err(loaded.no_band(&IdentifyError::NoScores));
        }
        let held = band.holds(record, &score, self.skip.unwrap_or(0.0));
        Ok(Score { band: Some(held), ..score })
    }

    fn text(&self, records: &[Score]) -> String {
        if records.iter().any(|r| r.axes.is_some()) {
            return format!("{}\n\n{}\n", scores::table(records), scores::AXES_EXPLANATION);
        }
        let offset = if self.fixed_offset {
            "The offset is the model's own (--fixed-offset)."
        } else {
            "The offset of each record's sensor was estimated from the record: the mean residual, added to the simulation."
        };
        let lines = |sentence: fn(&Score) -> Option<String>| {
            records.iter().filter_map(sentence).map(|text| text + "\n").collect::<String>()
        };
        let (starts, residuals) = (lines(scores::estimated_start), lines(scores::residual_tests));
        let bands = lines(scores::within_band);
        format!(
            "{}\n\n{offset}\n{starts}{bands}{residuals}\n{}",
            scores::table(records),
            scores::explanation()
        )
    }
}
