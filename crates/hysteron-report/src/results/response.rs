//! Structures fitted to a frequency response.

use hysteron_identify::frequency_response::{Candidate, Explained};

use super::Listing;
use crate::number::{significant, with_std_error};

/// Explanation of the criterion.
pub const ABOUT_AIC: &str = "AIC: Akaike's criterion, lower is better; it assumes independent residuals, \
    which a wrong structure does not leave, so disregard small differences.";

/// One row of the comparison.
pub fn cells(candidate: &Candidate, best: f64) -> [String; 6] {
    let fit = &candidate.fit;
    [
        candidate.name.clone(),
        fit.structure.to_string(),
        fit.parameters.len().to_string(),
        significant(100.0 * fit.relative_rms, 3),
        significant(100.0 * fit.largest.0, 3),
        format!("{:.0}", fit.aic - best),
    ]
}

/// The structures with their errors.
pub fn structures(found: &Explained) -> Listing {
    let best = found.lowest_aic();
    let mut listed = Listing::new([
        "structure",
        "formula",
        "parameters",
        "rms error [%]",
        "largest error [%]",
        "AIC above the best",
    ]);
    for candidate in &found.candidates {
        listed.push(cells(candidate, best));
    }
    listed
}

/// Their parameters.
pub fn parameters(found: &Explained) -> Listing {
    let mut parameters = Listing::new(["structure", "parameter", "value", "std. error", "unit"]);
    for candidate in &found.candidates {
        for p in &candidate.fit.parameters {
            let (value, error) = with_std_error(p.value, p.std_error);
            let error = match (p.on_edge, error.is_empty()) {
                (true, _) => "on the edge".to_owned(),
                (false, true) => "-".to_owned(),
                (false, false) => error,
            };
            parameters.push([candidate.name.clone(), p.name.clone(), value, error, p.unit.clone()]);
        }
    }
    parameters
}
