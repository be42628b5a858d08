//! Models of the workspace, read from their files.

use hysteron_io::load_model_and_source;
use hysteron_model::Model;

use super::Workspace;
use crate::api::Problem;
use crate::refused::{Answer, Refused};

impl Workspace {
    /// The model of an identifier.
    ///
    /// # Errors
    /// If there is none, or its file is not sound.
    pub(crate) fn model(&self, id: &str) -> Answer<Model> {
        let path = self.existing(id)?;
        let loaded = load_model_and_source(&path).map(|(model, _)| model);
        loaded.map_err(|e| Refused::cannot(Problem::of_file(&e, &path, id)))
    }
}
