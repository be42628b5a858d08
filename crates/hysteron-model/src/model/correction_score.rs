//! What a correction by the predicted misfit gains on a record.

use hysteron_numeric::display::short_to;

use super::Score;
use crate::validate::Scores;

/// Scores of the model alone, beside which a corrected one is scored.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectionScore {
    /// Error of the corrected model over that of the model alone, on left-out parts of the training records.
    pub left_out: f64,
    /// Scores of the model alone on this record.
    pub without: Box<Scores>,
}

impl Score {
    /// What the correction gained on left-out parts of the training records and on this record, in a
    /// sentence; `None` where the model was not corrected.
    pub fn correction_in_words(&self) -> Option<String> {
        let CorrectionScore { left_out, without } = self.correction.as_ref()?;
        let unit = self.unit.spaced();
        Some(format!(
            "Corrected by the predicted misfit, which leaves {} % of the error on left-out parts of the \
             training records, and {} % of it here: the model alone has RMSE {}{unit}, max error {}{unit}.",
            short_to(100.0 * left_out, 2),
            short_to(100.0 * self.rmse / without.rmse, 3),
            short_to(without.rmse, 4),
            short_to(without.max_abs_error, 4),
        ))
    }
}
