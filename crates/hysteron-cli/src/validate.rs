//! `hysteron validate`: scores of a model on records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron::validate::{OffsetTreatment, Scoring, score};
use serde::Serialize;

use crate::columns::{ColumnFlags, not_negative};
use crate::console;
use crate::failure::Failure;
use crate::model::{LoadedModel, Signal};
use crate::scores::{self, Scored};
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

    /// Seconds at the start of each record that are simulated but not scored
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = not_negative, allow_negative_numbers = true)]
    skip: f64,

    /// Compare with the model's own offset instead of estimating each record's sensor offset
    #[arg(long)]
    fixed_offset: bool,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: ColumnFlags,
}

#[derive(Serialize)]
struct Report {
    records: Vec<Scored>,
}

impl Validate {
    pub fn run(&self) -> Result<(), Failure> {
        let model = LoadedModel::read(&self.model)?;
        let records =
            self.records.iter().map(|path| self.score(&model, path)).collect::<Result<Vec<_>, _>>()?;
        if self.json { console::json(&Report { records }) } else { console::result(&self.text(&records)) }
    }

    fn score(&self, model: &LoadedModel, path: &Path) -> Result<Scored, Failure> {
        let record = self.columns.read(path)?;
        model.agreed_unit(path, Signal::Input, &record.u_unit)?;
        let unit = model.agreed_unit(path, Signal::Output, &record.y_unit)?;
        let offset = if self.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
        let scoring = Scoring { skip_s: self.skip, offset };
        let simulated = model.simulate_record(path, &record, &self.start, &scoring)?;
        let scores = score(&record, &simulated, &scoring)
            .map_err(|e| Failure::new(format!("cannot score {}", path.display())).because(e))?;
        Ok(Scored::new(&record, scores).in_unit(unit))
    }

    fn text(&self, records: &[Scored]) -> String {
        let offset = if self.fixed_offset {
            "The offset is the model's own (--fixed-offset)."
        } else {
            "The offset of each record's sensor was estimated from the record: the mean residual, added to the simulation."
        };
        let residuals =
            records.iter().filter_map(Scored::residual_tests).map(|text| text + "\n").collect::<String>();
        format!("{}\n\n{offset}\n{residuals}\n{}", scores::table(records), scores::explanation())
    }
}
