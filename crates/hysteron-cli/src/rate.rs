//! The measured rate of a displacement, of which a force depends.

use std::path::Path;

use hysteron_model::force;
use hysteron_model::model_file::Kind;
use hysteron_model::record::InputOutput;

use crate::columns::InputFlags;
use crate::failure::Failure;
use crate::model::Loaded;

impl Loaded {
    /// Refuses a column of the rate for a model that takes none.
    ///
    /// # Errors
    /// If the model is of another kind than force.
    pub fn check_rate(&self) -> Result<(), Failure> {
        match self.model().kind() {
            Kind::Force => Ok(()),
            _ => Err(Failure::usage("--rate goes with a model of the kind \"force\"")),
        }
    }
}

impl InputFlags {
    /// The record with the rate of its input, from the column of this name.
    ///
    /// # Errors
    /// If the file is not a readable record, or the column is not such a rate.
    pub fn with_rate(&self, path: &Path, data: InputOutput, column: &str) -> Result<InputOutput, Failure> {
        let record = self.read_record(path)?;
        force::with_rate(data, &record, column).map_err(|e| {
            Failure::new(format!("cannot take the rate from {}", path.display()))
                .because(e)
                .hint("name a column with --rate, or leave it out: the rate is then that of the displacement")
        })
    }
}
