//! Models of the workspace, read from their files and written to them.

use hysteron_io::{load_model_and_source, save_model};
use hysteron_model::Model;
use hysteron_model::model_file::ModelFile;
use hysteron_model::record::Source;

use super::{Kind, Workspace};
use crate::api::Problem;
use crate::refused::{Answer, Refused};

impl Workspace {
    /// The model of an identifier.
    ///
    /// # Errors
    /// If there is none, or its file is not sound.
    pub(crate) fn model(&self, id: &str) -> Answer<Model> {
        Ok(self.model_and_source(id)?.0)
    }

    /// A model and the file as it was read.
    ///
    /// # Errors
    /// As there.
    pub(crate) fn model_and_source(&self, id: &str) -> Answer<(Model, Source)> {
        let path = self.existing(id)?;
        let loaded = load_model_and_source(&path);
        loaded.map_err(|e| Refused::cannot(Problem::of_file(&e, &path, id)))
    }

    /// Writes a model; a file of this name goes to the trash folder.
    ///
    /// # Errors
    /// For data that make no model, a name that is none, a file that cannot be written.
    pub(crate) fn keep_model(&self, id: &str, data: ModelFile) -> Answer<()> {
        let model = Model::try_from(data).map_err(Refused::cannot)?;
        save_model(&self.to_write(id, Kind::Model)?, &model).map_err(Refused::failed)
    }
}
