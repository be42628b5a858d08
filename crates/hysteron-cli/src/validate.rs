//! `hysteron validate`: scores of a model on records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::IdentifyError;
use hysteron_model::model::{Capability, RunScore, Score, Signals};
use hysteron_model::record::{InputOutput, MeasurementRun};
use hysteron_model::validate::{OffsetTreatment, Scoring};
use hysteron_report::validation::{Validated, page};
use serde::Serialize;

use crate::axes::AxesFlags;
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::Loaded;
use crate::numbers::not_negative;
use crate::output;
use crate::outputs::Outputs;
use crate::result_flags::ResultFlags;
use crate::scores;
use crate::start::StartFlags;

/// Score models on held-out records by simulation in free run, not by one-step prediction.
#[derive(Args)]
#[command(
    after_help = "Each record's sensor has its own zero: unless --fixed-offset is given, the mean residual \
    is added to the simulation and printed as the offset. A record that cannot be scored does not stop the \
    others; the exit code then is 1.\n\n\
    Example: hysteron validate model.json run1.csv run2.csv --skip 0.5\n\
    Example: hysteron validate old.json new.json run1.csv --report validation.html\n\
    Example: hysteron validate model.json run1.csv -o scored.csv"
)]
pub struct Validate {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// The records; model files (.json) among them are scored on the same records, side by side
    #[arg(value_name = "RECORD", required = true)]
    files: Vec<PathBuf>,

    /// Seconds at the start of each record that are simulated but not scored [default: 0; a quarter of a
    /// period for a model without dynamics where the drive starts with a jump]
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    skip: Option<f64>,

    /// Use the offset in the model instead of estimating the sensor offset of each record
    #[arg(long)]
    fixed_offset: bool,

    /// The records are consecutive parts of one run on one clock: simulated without interruption from the
    /// start of the first, with one offset
    #[arg(long, conflicts_with = "band")]
    continued: bool,

    /// Report the coverage of the 95 % prediction band, from the standard errors in the model file
    #[arg(long)]
    band: bool,

    /// Score the model corrected by the predicted misfit of a device outside the model class, with the score
    /// of the model alone beside it; refused where it gains nothing on left-out parts of the training records
    #[arg(long, conflicts_with = "continued")]
    correct: bool,

    /// File for the samples of the record, those before the scoring begins too: drive, measured output, model,
    /// residual (CSV, or NPZ or MAT by extension); one record, or one run
    #[arg(short, long = "output-file", value_name = "OUT.csv|npz|mat")]
    out: Option<PathBuf>,

    /// Column of the rate of the input, for a model of the kind force: its name, with or without unit
    /// [default: the rate is that of the displacement]
    #[arg(long, value_name = "COL", conflicts_with = "continued")]
    rate: Option<String>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: ColumnFlags,

    #[command(flatten)]
    axes: AxesFlags,
}

/// A model with its scores.
struct Scored {
    loaded: Loaded,
    /// Scores in tables and pages: each record, or each part of a run and the run.
    shown: Vec<(Signals, Score)>,
    /// Scores of runs, with `--continued`.
    runs: Vec<RunScore>,
    /// Records that could not be scored.
    failed: Vec<Failed>,
}

/// A record that could not be scored, with the reason.
#[derive(Serialize)]
struct Failed {
    record: String,
    error: String,
    #[serde(skip)]
    failure: Failure,
}

/// JSON output: the scores of one model.
#[derive(Serialize)]
#[serde(untagged)]
enum Scores<'a> {
    Records {
        records: Vec<&'a Score>,
        #[serde(skip_serializing_if = "<[_]>::is_empty")]
        failed: &'a [Failed],
    },
    Run(&'a RunScore),
    Runs {
        runs: &'a [RunScore],
    },
}

#[derive(Serialize)]
struct ScoresOfModel<'a> {
    model: String,
    #[serde(flatten)]
    scores: Scores<'a>,
}

#[derive(Serialize)]
struct ScoresOfModels<'a> {
    models: Vec<ScoresOfModel<'a>>,
}

impl Scored {
    fn json(&self) -> Scores<'_> {
        match self.runs.as_slice() {
            [] => Scores::Records {
                records: self.shown.iter().map(|(_, score)| score).collect(),
                failed: &self.failed,
            },
            [only] => Scores::Run(only),
            runs => Scores::Runs { runs },
        }
    }
}

/// Whether a file is a model rather than a record: no record is JSON.
fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

impl Validate {
    pub fn run(&self) -> Result<(), Failure> {
        self.result.check()?;
        if let Some(out) = &self.out {
            output::check_file("the series", out)?;
        }
        let (others, records): (Vec<&PathBuf>, Vec<&PathBuf>) =
            self.files.iter().partition(|path| is_model(path));
        if records.is_empty() {
            return Err(Failure::usage("no record is given").hint("name the records behind the model files"));
        }
        let models = std::iter::once(&self.model).chain(others).map(|path| Loaded::read(path));
        let models = models.collect::<Result<Vec<_>, Failure>>()?;
        let scored = models.into_iter().map(|loaded| self.scored(loaded, &records));
        let mut scored = scored.collect::<Result<Vec<_>, Failure>>()?;
        if scored.iter().all(|s| s.shown.is_empty()) {
            let first = scored.iter_mut().find_map(|s| s.failed.drain(..).next());
            return Err(first.map_or_else(|| Failure::new("nothing was scored"), |failed| failed.failure));
        }
        let mut outputs = Outputs::default();
        self.result.add(&mut outputs, || {
            let models: Vec<_> = scored
                .iter()
                .map(|s| Validated { path: s.loaded.path(), model: s.loaded.model(), records: &s.shown })
                .collect();
            page(&models, &maker())
        })?;
        self.add_series(&mut outputs, &scored)?;
        outputs.finish()?;
        if self.result.json {
            match scored.as_slice() {
                [only] => console::json(&only.json())?,
                several => {
                    let of = |s: &'_ Scored| s.loaded.path().display().to_string();
                    let models =
                        several.iter().map(|s| ScoresOfModel { model: of(s), scores: s.json() }).collect();
                    console::json(&ScoresOfModels { models })?;
                }
            }
        } else {
            console::result(&self.text(&scored))?;
        }
        let failed = scored.iter().map(|s| s.failed.len()).sum::<usize>();
        let all = failed + scored.iter().map(|s| s.shown.len()).sum::<usize>();
        match failed {
            0 => Ok(()),
            _ => Err(Failure::new(format!("{failed} of {all} could not be scored, see above"))),
        }
    }

    /// Scores of a model. Errors in the flags or in the model itself abort.
    fn scored(&self, loaded: Loaded, records: &[&PathBuf]) -> Result<Scored, Failure> {
        if self.band {
            loaded.hammerstein(Capability::Bands)?;
        }
        if self.correct {
            loaded.check_correction()?;
        }
        if self.rate.is_some() {
            loaded.check_rate()?;
        }
        if self.continued {
            return self.of_runs(loaded, records);
        }
        let (mut shown, mut failed) = (Vec::new(), Vec::new());
        for path in records {
            match self.score(&loaded, path) {
                Ok(scored) => shown.push(scored),
                Err(failure) if failure.is_usage() => return Err(failure),
                Err(failure) => {
                    if records.len() > 1 {
                        console::message(&failure.to_string());
                    }
                    let record = path.display().to_string();
                    failed.push(Failed { record, error: failure.in_a_line(), failure });
                }
            }
        }
        Ok(Scored { loaded, shown, runs: Vec::new(), failed })
    }

    /// Scores of the records as parts of runs: one that cannot be read leaves a gap in its run, so nothing is
    /// scored.
    fn of_runs(&self, loaded: Loaded, paths: &[&PathBuf]) -> Result<Scored, Failure> {
        loaded.hammerstein(Capability::Runs)?;
        let part = |path: &&PathBuf| loaded.read_part(path, &self.columns, &self.axes);
        let records = paths.iter().map(part).collect::<Result<Vec<_>, Failure>>()?;
        let found =
            MeasurementRun::of(&records).map_err(|e| Failure::new("the records are no runs").because(e))?;
        let path = paths[0];
        let (mut runs, mut shown) = (Vec::new(), Vec::new());
        for run in found {
            let start = self.start.start(path, &run.data.time)?;
            let score = loaded.score_run(path, &run, start, &self.scoring())?;
            let parts = run.parts.iter().zip(&score.records);
            shown.extend(parts.map(|(part, score)| (Signals::Single(part.data.clone()), score.clone())));
            shown.push((Signals::Single(run.data), score.whole.clone()));
            runs.push(score);
        }
        Ok(Scored { loaded, shown, runs, failed: Vec::new() })
    }

    /// Adds the scored samples of one record or one run, if a file for them is given.
    fn add_series(&self, outputs: &mut Outputs, scored: &[Scored]) -> Result<(), Failure> {
        let Some(out) = &self.out else { return Ok(()) };
        let one = match scored {
            [Scored { shown, runs, .. }] if runs.len() == 1 => shown.last(),
            [Scored { shown, .. }] if shown.len() == 1 => shown.first(),
            _ => None,
        };
        let Some((signals, score)) = one else {
            return Err(Failure::usage("-o takes one model and one record, or one run (--continued)")
                .hint("validate one record at a time, each with its own -o"));
        };
        let failure = || Failure::new(format!("cannot write the series to {}", out.display()));
        let series = score.series(signals).map_err(|e| failure().because(e))?;
        outputs.add_record("the series", out, &series)?;
        outputs.tell(format!("wrote {} samples to {}", series.len(), out.display()));
        Ok(())
    }

    fn scoring(&self) -> Scoring {
        let offset = if self.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
        Scoring { skip_s: self.skip, offset }
    }

    fn score(&self, loaded: &Loaded, path: &Path) -> Result<(Signals, Score), Failure> {
        let signals = match (loaded.read_record(path, &self.columns, &self.axes)?, &self.rate) {
            (Signals::Single(data), Some(column)) => {
                self.columns.of_drive().with_rate(path, data, column)?.into()
            }
            (signals, _) => signals,
        };
        let score = loaded.score(path, &signals, &self.start, &self.scoring(), self.correct)?;
        let score = match &signals {
            Signals::Single(record) if self.band => self.with_band(loaded, path, record, score)?,
            _ => score,
        };
        Ok((signals, score))
    }

    /// The score with the coverage of the record by the band of a new measurement.
    fn with_band(
        &self,
        loaded: &Loaded,
        path: &Path,
        record: &InputOutput,
        score: Score,
    ) -> Result<Score, Failure> {
        let band = loaded.band(path, &record.u, &record.time, &score.simulation.start)?;
        let band = if self.correct { band.corrected() } else { band };
        if band.noise == 0.0 {
            return Err(loaded.no_band(&IdentifyError::NoScores));
        }
        let held = band.holds(record, &score, self.skip.unwrap_or(0.0));
        Ok(Score { band: Some(held), ..score })
    }

    fn text(&self, scored: &[Scored]) -> String {
        let names =
            scores::short_names(scored.iter().map(|s| s.loaded.path().display().to_string()).collect());
        let named = scored.iter().zip(&names);
        let rows: Vec<(&str, &Score)> =
            named.flat_map(|(s, name)| s.shown.iter().map(|(_, score)| (name.as_str(), score))).collect();
        let table = scores::table_of_models(&rows);
        if rows.iter().any(|(_, score)| score.axes.is_some()) {
            return format!("{table}\n\n{}\n", scores::AXES_EXPLANATION);
        }
        let offset = if self.fixed_offset {
            "The offset is the model's own (--fixed-offset)."
        } else {
            "The offset of each record's sensor was estimated from the record: the mean residual, added to \
             the simulation."
        };
        let lines = |sentence: fn(&Score) -> Option<String>| {
            let line = |(model, score): &(&str, &Score)| {
                let of = if scored.len() > 1 { format!("{model}: ") } else { String::new() };
                sentence(score).map(|text| format!("{of}{text}\n"))
            };
            rows.iter().filter_map(line).collect::<String>()
        };
        let verdicts = lines(scores::verdict);
        let starts = lines(scores::estimated_start) + &lines(scores::without_estimated_start);
        let runs =
            scored.iter().flat_map(|s| &s.runs).filter_map(|run| run.whole_without_estimated_start.as_ref());
        let runs: String = runs.map(scores::run_without_estimated_start).collect();
        let corrections = lines(scores::correction);
        let (bands, residuals) = (lines(scores::within_band), lines(scores::residual_tests));
        let sentences = [verdicts, offset.to_owned() + "\n", corrections, starts, runs, bands, residuals];
        format!("{table}\n\n{}\n{}", sentences.concat(), scores::explanation())
    }
}
