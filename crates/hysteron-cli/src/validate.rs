//! `hysteron validate`: scores of a model on records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::PredictionError;
use hysteron_model::model::{Capability, Score, Signals};
use hysteron_model::record::InputOutput;
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
use crate::result_flags::ResultFlags;
use crate::scores;
use crate::start::StartFlags;

/// Score a model on records it may not have seen: simulation from the start of each record, not prediction.
#[derive(Args)]
#[command(
    after_help = "Each record's sensor has its own zero: unless --fixed-offset is given, the mean residual is added to the \
    simulation and printed as the offset.\n\n\
    Example: hysteron validate model.json run1.csv run2.csv --skip 0.5\n\
    Example: hysteron validate model.json run1.csv --report validation.html"
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

impl Validate {
    pub fn run(&self) -> Result<(), Failure> {
        self.result.check()?;
        let loaded = Loaded::read(&self.model)?;
        if self.band {
            loaded.hammerstein(Capability::Bands)?;
        }
        let records = self.records.iter().map(|path| self.score(&loaded, path));
        let records = records.collect::<Result<Vec<_>, Failure>>()?;
        self.result.write(|| page(loaded.model(), &records, &maker()))?;
        let records: Vec<Score> = records.into_iter().map(|(_, score)| score).collect();
        if self.result.json {
            console::json(&Report { records })
        } else {
            console::result(&self.text(&records))
        }
    }

    fn score(&self, loaded: &Loaded, path: &Path) -> Result<(Signals, Score), Failure> {
        let signals = loaded.read_record(path, &self.columns, &self.axes)?;
        let offset = if self.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
        let scoring = Scoring { skip_s: self.skip, offset };
        let score = loaded.score(path, &signals, &self.start, &scoring)?;
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
            return Err(loaded.no_band(&PredictionError::NoScores));
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
