//! `hysteron validate`: scores of a model on records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::PredictionError;
use hysteron_model::model::{Capability, Remark, Score, Signals};
use hysteron_model::record::InputOutput;
use hysteron_model::validate::{OffsetTreatment, Scoring};
use serde::Serialize;

use crate::axes::{self, AxesFlags, AxesScored};
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::model::Loaded;
use crate::numbers::not_negative;
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

#[derive(Serialize)]
struct Report {
    records: Vec<Scored>,
}

impl Validate {
    pub fn run(&self) -> Result<(), Failure> {
        let loaded = Loaded::read(&self.model)?;
        if self.band {
            loaded.hammerstein(Capability::Bands)?;
        }
        let scores = self.records.iter().map(|path| self.score(&loaded, path));
        let scores = scores.collect::<Result<Vec<_>, Failure>>()?;
        if loaded.model().channels().is_some() {
            return self.show_axes(scores.into_iter().map(|(score, _)| score));
        }
        let records =
            scores.into_iter().filter_map(|(score, within)| Some(Scored::of(score)?.within(within)));
        let records: Vec<Scored> = records.collect();
        if self.json { console::json(&Report { records }) } else { console::result(&self.text(&records)) }
    }

    fn score(&self, loaded: &Loaded, path: &Path) -> Result<(Score, Option<Within>), Failure> {
        let signals = loaded.read_record(path, &self.columns, &self.axes)?;
        let offset = if self.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
        let scoring = Scoring { skip_s: self.skip, offset };
        let score = loaded.score(path, &signals, &self.start, &scoring)?;
        let within = match &signals {
            Signals::Single(record) if self.band => Some(self.within(loaded, path, record, &score)?),
            _ => None,
        };
        Ok((score, within))
    }

    fn show_axes(&self, scores: impl Iterator<Item = Score>) -> Result<(), Failure> {
        let records: Vec<AxesScored> = scores.map(AxesScored::of).collect();
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

    /// How well the band of a new measurement holds this one.
    fn within(
        &self,
        loaded: &Loaded,
        path: &Path,
        record: &InputOutput,
        score: &Score,
    ) -> Result<Within, Failure> {
        let simulation = &score.simulation;
        let band = loaded.band(path, &record.u, record.sample_rate_hz(), &simulation.start)?;
        if band.noise == 0.0 {
            return Err(loaded.no_band(&PredictionError::NoScores));
        }
        let left_out = simulation.remarks.iter().map(|remark| match remark {
            Remark::LeftOut { samples } => *samples,
            _ => 0,
        });
        let scored = record.without_first(left_out.sum());
        let (simulated, offset) = (
            simulation.outputs.first().map_or(&[][..], Vec::as_slice),
            score.outputs.first().map_or(0.0, |s| s.offset),
        );
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
