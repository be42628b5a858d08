//! Correction of a model by its predicted misfit.

use hysteron_model::misfit::NotCorrected;
use hysteron_model::model::Capability;

use crate::failure::Failure;
use crate::model::Loaded;

impl Loaded {
    /// Refuses a model that is not corrected by its misfit.
    ///
    /// # Errors
    /// If it is of another kind, its records show no device outside the class, or a correction does not pay.
    pub fn check_correction(&self) -> Result<(), Failure> {
        let body = self.hammerstein(Capability::Correction)?;
        body.correction().map(drop).map_err(|e| self.cannot_correct(e))
    }

    /// Failure for a model that is not corrected.
    pub fn cannot_correct(&self, because: NotCorrected) -> Failure {
        Failure::new(format!("cannot correct {} by its predicted misfit", self.path().display()))
            .because(because)
            .hint("leave --correct out: these records support the model alone")
    }
}
