//! `hysteron schema`: the model file's JSON Schema.

use clap::Args;
use hysteron_model::model_file::json_schema;

use crate::{console, failure::Failure};

/// Print the JSON Schema of the model file.
#[derive(Args)]
#[command(after_help = "Example: hysteron schema > hysteron-model-2.schema.json")]
pub struct Schema {}

impl Schema {
    pub fn run(&self) -> Result<(), Failure> {
        console::result(&json_schema())
    }
}
