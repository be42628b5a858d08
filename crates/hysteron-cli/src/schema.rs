//! `hysteron schema`: the model file's JSON Schema.

use clap::Args;
use hysteron::model_file::{json_schema, oscillator_schema};

use crate::{console, failure::Failure};

/// Print the JSON Schema of the model file.
#[derive(Args)]
#[command(after_help = "Example: hysteron schema > hysteron-model-1.schema.json")]
pub struct Schema {
    /// The schema of an oscillator's file instead
    #[arg(long)]
    oscillator: bool,
}

impl Schema {
    pub fn run(&self) -> Result<(), Failure> {
        console::result(&if self.oscillator { oscillator_schema() } else { json_schema() })
    }
}
