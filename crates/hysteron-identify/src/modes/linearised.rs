//! A model linearised along its trajectory, for derivatives forwards and backwards.

use hysteron_model::axes::{AtLevel, ScheduledModes, Trajectory};
use hysteron_numeric::FeedbackTangent;

/// Its matrices at one S.
pub(super) struct Linearised {
    at: AtLevel,
    /// Rows of v, then of σ.
    channels: Vec<f64>,
    /// Weights of the plays, channel by channel.
    weights: Vec<f64>,
    /// Plays of a channel.
    plays: usize,
}

impl Linearised {
    pub(super) fn new(model: &ScheduledModes, s: f64) -> Self {
        let (mut channels, mut weights, mut plays) = (Vec::new(), Vec::new(), 0);
        if let Some(feedback) = &model.feedback {
            channels = [feedback.drive_rows.as_slice(), &feedback.stress_rows].concat();
            plays = feedback.drive.radii.len();
            let powers = feedback.drive.terms() - plays;
            for _ in 0..model.inputs {
                weights.extend_from_slice(&feedback.drive.coefficients[powers..]);
            }
            feedback.stress.iter().for_each(|law| weights.extend_from_slice(&law.coefficients[powers..]));
        }
        Self { at: model.at(s), channels, weights, plays }
    }

    /// Along a trajectory of the model at that S.
    pub(super) fn system<'a>(
        &'a self,
        model: &'a ScheduledModes,
        trajectory: &'a Trajectory,
    ) -> FeedbackTangent<'a> {
        FeedbackTangent {
            modes: model.modes,
            transition: &self.at.transition,
            channels: &self.channels,
            row: model.states() + model.inputs,
            weights: &self.weights,
            plays: self.plays,
            strain_input: &model.strain_input,
            strains: model.inputs,
            output: &self.at.output,
            strain_feedthrough: &model.strain_feedthrough,
            signals: &trajectory.signals,
            width: trajectory.width,
            slopes: &trajectory.slopes,
            moved: &trajectory.moved,
            before: trajectory.before,
            steps: model.steps,
        }
    }
}
