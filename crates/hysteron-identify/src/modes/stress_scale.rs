//! Holds the scale of every actuator's stress while its direction is searched.
//!
//! A law of a stress a times as large, with coefficients and radii to match, is the same law. Records determine
//! a through the radii alone, so poorly that σ can shrink until the widest plays hardly move: their terms are
//! then linear, of any weight, and a drive a little larger throws the model to another position of rest. Every
//! iteration therefore adds
//!
//! ```text
//! R = h (gᵀ Δ)²/|g|²,   g = Σ σ s
//! ```
//!
//! for every actuator, summed over the records of the highest level: Δ is the step of the row of its stress σ, s
//! the signals that the row weighs, gᵀ Δ half the change of Σ σ², and h the information on a step along g.
//! Ten times as much made some searches longer or end elsewhere.

use super::columns::{Freedom, Group};
use super::normal::NormalEquations;
use hysteron_model::axes::ScheduledModes;

/// Adds half the second derivatives of R to the matrix, where the rows of the stress are free.
pub(super) fn hold(equations: &mut NormalEquations, freedom: &Freedom, model: &ScheduledModes) {
    let stress = freedom.places(model).into_iter().find(|(group, _)| *group == Group::Stress);
    let Some((_, columns)) = stress else { return };
    let NormalEquations { matrix, stress, .. } = equations;
    let mut first = columns.start;
    for direction in stress.iter() {
        let mut own = matrix.view_mut((first, first), (direction.len(), direction.len()));
        first += direction.len();
        let square = direction.norm_squared();
        let information = direction.dot(&(&own * direction)) / square;
        if information > 0.0 && information.is_finite() {
            own.ger(information / square, direction, direction, 1.0);
        }
    }
}
