//! `hysteron validate`: scores of a model on records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::PredictionError;
use hysteron_model::hammerstein::Start;
use hysteron_model::record::InputOutput;
use hysteron_model::validate::{OffsetTreatment, Scoring, score, unfollowed_start};
use hysteron_numeric::display::short;
use serde::Serialize;

use crate::axes::{self, AxesFlags, AxesScored, LoadedAxes};
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::model::{LoadedModel, Signal};
use crate::numbers::not_negative;
use crate::oscillator::LoadedOscillator;
use crate::scores::{self, Scored, Within};
use crate::start::StartFlags;

/// Score a model on records it may not have seen: simulation from the start of each record, not prediction.
#[derive(Args)]
#[command(
    after_help = "Each record's sensor has its own zero: unless --fixed-offset is given, the mean residual is added to the \
    simulation and printed as the offset.\n\n\
    Example: hysteron validate model.json run1.csv run2.csv --skip 0.5"
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

    /// Say how many samples lie within the 95 % band of a new measurement, from the errors in the model file
    #[arg(long)]
    band: bool,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: ColumnFlags,

    #[command(flatten)]
    axes: AxesFlags,
}

/// Masks the first samples of a record, and says so.
fn leave_out(record: &mut InputOutput, samples: usize, path: &Path) {
    if samples == 0 {
        return;
    }
    *record = record.without_first(samples);
    console::note(&format!(
        "{}: the drive starts with a jump, which a model without dynamics cannot follow: its first {samples} samples are not \
         scored (--skip 0 scores them)",
        path.display()
    ));
}

/// Fewest samples that say anything about a model: with two, and the offset estimated from them, any line fits.
const FEWEST_SAMPLES: usize = 3;
/// Variation of a simulation, over its size, that is rounding.
const ROUNDING: f64 = 1e-9;

/// A score says nothing of one or two samples, nor where nothing moves: a sensor that stood still, or a drive that did (unless the model, started
/// elsewhere, still moves towards it).
fn refuse_meaningless(record: &InputOutput, simulated: &[f64], path: &Path) -> Result<(), Failure> {
    let valid = |k: usize| record.valid.as_ref().is_none_or(|mask| mask.get(k) == Some(&true));
    let range = |x: &[f64]| {
        let scored = x.iter().enumerate().filter(|(k, _)| valid(*k)).map(|(_, x)| *x);
        scored.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let failure = || Failure::new(format!("cannot score {}", path.display()));
    let samples = (0..record.len()).filter(|&k| valid(k)).count();
    if samples < FEWEST_SAMPLES {
        let total = record.len();
        return Err(failure()
            .because(format!(
                "only {samples} of its {total} samples can be scored; need at least {FEWEST_SAMPLES}"
            ))
            .hint("record at least one loop, with a hundred samples or more"));
    }
    let ((u_low, u_high), (y_low, y_high)) = (range(&record.u), range(&record.y));
    if y_low == y_high {
        return Err(failure()
            .because(format!(
                "the output `{}` is constant ({}): no motion to compare with",
                record.output,
                short(y_low)
            ))
            .hint("check that the sensor was on; choose the column with --output"));
    }
    let (low, high) = range(simulated);
    if u_low == u_high && high - low <= ROUNDING * low.abs().max(high.abs()) {
        return Err(failure()
            .because(format!("the input `{}` is constant ({}): the model has nothing to follow", record.input, short(u_low)))
            .hint(
                "choose the column with --input; for a step from another voltage say --rest-voltage VOLTS (a model with \
                 dynamics follows it)",
            ));
    }
    Ok(())
}

#[derive(Serialize)]
struct Report {
    records: Vec<Scored>,
}

impl Validate {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(model) = LoadedAxes::recognise(&self.model)? {
            return self.run_modes(&model);
        }
        if self.axes.are_given() {
            return Err(Failure::usage("--inputs and --outputs go with models of several axes")
                .hint("choose the columns with --input and --output"));
        }
        let records = match LoadedOscillator::recognise(&self.model)? {
            Some(model) => self
                .records
                .iter()
                .map(|path| self.score_oscillator(&model, path))
                .collect::<Result<Vec<_>, _>>()?,
            None => {
                let model = LoadedModel::read(&self.model)?;
                self.records.iter().map(|path| self.score(&model, path)).collect::<Result<Vec<_>, _>>()?
            }
        };
        if self.json { console::json(&Report { records }) } else { console::result(&self.text(&records)) }
    }

    fn run_modes(&self, model: &LoadedAxes) -> Result<(), Failure> {
        if self.band {
            return Err(Failure::usage("--band does not go with models of several axes")
                .because("their file holds no correlation of its parameters"));
        }
        let settled = self.start.settled_s("models of several axes")?;
        let names = self.axes.or(&model.inputs, &model.outputs);
        let score = |path: &PathBuf| {
            let record = names.read(path, self.columns.of_drive())?;
            model.score(path, &record, &self.scoring(), settled)
        };
        let records = self.records.iter().map(score).collect::<Result<Vec<_>, Failure>>()?;
        if self.json {
            let records: Vec<_> = records.iter().map(AxesScored::json).collect();
            return console::json(&serde_json::json!({ "records": records }));
        }
        console::result(&format!(
            "{}\n\nRMSE: root mean square of y − simulation − offset over all outputs, the offset of each sensor estimated unless \
             --fixed-offset is given; of mean period: the same of the mean over the record's periods, in which noise counts less; level: rms \
             of the inputs.\n",
            axes::table(&records)
        ))
    }

    fn score_oscillator(&self, model: &LoadedOscillator, path: &Path) -> Result<Scored, Failure> {
        if self.band {
            return Err(Failure::usage("--band does not go with an oscillator")
                .because("its file holds no correlation of its parameters"));
        }
        let record = self.columns.read(path)?;
        model.agreed_unit(path, Signal::Input, &record.u_unit)?;
        let unit = model.agreed_unit(path, Signal::Output, &record.y_unit)?;
        let scoring = self.scoring();
        let simulated = model.simulate_record(path, &record, &self.start, &scoring)?;
        refuse_meaningless(&record, &simulated, path)?;
        let scores = score(&record, &simulated, &scoring)
            .map_err(|e| Failure::new(format!("cannot score {}", path.display())).because(e))?;
        Ok(Scored::new(&record, scores).in_unit(unit))
    }

    fn scoring(&self) -> Scoring {
        let offset = if self.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
        Scoring { skip_s: self.skip.unwrap_or(0.0), offset }
    }

    fn score(&self, model: &LoadedModel, path: &Path) -> Result<Scored, Failure> {
        let record = self.columns.read(path)?;
        model.agreed_unit(path, Signal::Input, &record.u_unit)?;
        let unit = model.agreed_unit(path, Signal::Output, &record.y_unit)?;
        let scoring = self.scoring();
        let (start, simulated) = model.simulate_record(path, &record, &self.start, &scoring)?;
        let mut scored = record.clone();
        if self.skip.is_none() && model.is_static() {
            leave_out(&mut scored, unfollowed_start(&record, &start), path);
        }
        refuse_meaningless(&scored, &simulated, path)?;
        let scores = score(&scored, &simulated, &scoring)
            .map_err(|e| Failure::new(format!("cannot score {}", path.display())).because(e))?;
        let band = self.band.then(|| self.within(model, path, &scored, &simulated, &start, scores.offset));
        Ok(Scored::new(&record, scores).in_unit(unit).simulated_from(start).within(band.transpose()?))
    }

    /// How well the band of a new measurement holds this one.
    fn within(
        &self,
        model: &LoadedModel,
        path: &Path,
        scored: &InputOutput,
        simulated: &[f64],
        start: &Start,
        offset: f64,
    ) -> Result<Within, Failure> {
        let band = model.band(path, &scored.u, scored.sample_rate_hz(), start)?;
        if band.noise == 0.0 {
            return Err(model.no_band(&PredictionError::NoScores));
        }
        let half = band.of_measurement();
        let skipped = (self.skip.unwrap_or(0.0) * scored.sample_rate_hz().unwrap_or(0.0)).ceil() as usize;
        let valid = |k: &usize| scored.valid.as_ref().is_none_or(|mask| mask.get(*k) == Some(&true));
        let all: Vec<usize> = (skipped..scored.len()).filter(valid).collect();
        let inside = all.iter().filter(|&&k| (scored.y[k] - simulated[k] - offset).abs() <= half[k]).count();
        Ok(Within {
            inside_percent: 100.0 * inside as f64 / all.len().max(1) as f64,
            model: band.of_output().into_iter().fold(0.0, f64::max),
            measurement: half.into_iter().fold(0.0, f64::max),
        })
    }

    fn text(&self, records: &[Scored]) -> String {
        let offset = if self.fixed_offset {
            "The offset is the model's own (--fixed-offset)."
        } else {
            "The offset of each record's sensor was estimated from the record: the mean residual, added to the simulation."
        };
        let lines = |sentence: fn(&Scored) -> Option<String>| {
            records.iter().filter_map(sentence).map(|text| text + "\n").collect::<String>()
        };
        let (starts, residuals) = (lines(Scored::estimated_start), lines(Scored::residual_tests));
        let bands = lines(Scored::within_band);
        format!(
            "{}\n\n{offset}\n{starts}{bands}{residuals}\n{}",
            scores::table(records),
            scores::explanation()
        )
    }
}
