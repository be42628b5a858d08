//! Model file of a corrected model.

use std::collections::BTreeMap;

use super::{FollowOptions, Followed};
use crate::IdentifyError;
use hysteron_model::model_file::{
    Maker, ModelFile, Provenance, RecordEntry, RecordRole, ScoreEntry, ScoreRole,
};
use hysteron_model::record::{InputOutput, Source};

impl Followed {
    /// Model file with the coefficients of the last sample. `old`: the file of the model that was corrected,
    /// and its source. Standard errors and covariance of the old parameters are omitted, as they do not apply
    /// to the new ones.
    ///
    /// # Errors
    /// [`IdentifyError`] where the coefficients give no valid model.
    pub fn model_file(
        &self,
        data: &InputOutput,
        options: &FollowOptions,
        (old, source): (&ModelFile, &Source),
        maker: &Maker,
    ) -> Result<ModelFile, &IdentifyError> {
        let model = self.model.as_ref()?;
        let mut named = BTreeMap::from([
            ("method".to_owned(), "adapt".to_owned()),
            ("adapted model".to_owned(), source.path.clone()),
            ("adapted model sha256".to_owned(), source.sha256.clone()),
            ("estimator".to_owned(), options.method.name().to_owned()),
            ("noise".to_owned(), options.noise.to_string()),
        ]);
        named.extend(self.paths.iter().map(|path| (path.term.to_string(), path.end.to_string())));
        let records = vec![RecordEntry::of(data, RecordRole::Both)];
        let mut file = ModelFile::from_model(model, old.units.clone());
        file.set_start(old.start());
        (file.name, file.normalisation) = (old.name.clone(), old.normalisation);
        file.valid_range = old.valid_range.clone();
        file.provenance = Some(Provenance::new(maker, records, named, None));
        file.scores =
            vec![ScoreEntry::new(&data.name, ScoreRole::Training, data.y_unit.symbol(), &self.last)];
        Ok(file)
    }
}
