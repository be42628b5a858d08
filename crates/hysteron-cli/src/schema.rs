//! `hysteron schema`: the model file's JSON Schema.

use clap::Args;
use hysteron::model_file::{json_schema, modes_schema, oscillator_schema};

use crate::{console, failure::Failure};

/// Print the JSON Schema of the model file.
#[derive(Args)]
#[command(after_help = "Example: hysteron schema > hysteron-model-1.schema.json")]
pub struct Schema {
    /// The schema of an oscillator's file instead
    #[arg(long, conflicts_with = "modes")]
    oscillator: bool,

    /// The schema of the file of scheduled modes (several axes) instead
    #[arg(long)]
    modes: bool,
}

impl Schema {
    pub fn run(&self) -> Result<(), Failure> {
        console::result(&match (self.oscillator, self.modes) {
            (true, _) => oscillator_schema(),
            (_, true) => modes_schema(),
            _ => json_schema(),
        })
    }
}
