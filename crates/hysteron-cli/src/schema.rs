//! `hysteron schema`: the model file's JSON Schema.

use clap::Args;
use hysteron_model::model_file::{coupled_schema, json_schema, modes_schema, oscillator_schema};

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

    /// The schema of the file of coupled branches (several axes) instead
    #[arg(long, conflicts_with_all = ["modes", "oscillator"])]
    coupled: bool,
}

impl Schema {
    pub fn run(&self) -> Result<(), Failure> {
        if self.coupled {
            return console::result(&coupled_schema());
        }
        console::result(&match (self.oscillator, self.modes) {
            (true, _) => oscillator_schema(),
            (_, true) => modes_schema(),
            _ => json_schema(),
        })
    }
}
