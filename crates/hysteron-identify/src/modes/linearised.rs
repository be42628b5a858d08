//! A model linearised along its trajectory, for derivatives forwards and backwards.

use nalgebra::RealField;

use hysteron_model::axes::{ScheduledModes, Trajectory};
use hysteron_numeric::FeedbackTangent;

/// Its matrices at one S, and the signals of its trajectory, in double or single precision.
pub(super) struct Linearised<T> {
    transition: Vec<T>,
    /// Rows of v, then of σ.
    channels: Vec<T>,
    /// Weights of the plays, channel by channel.
    weights: Vec<T>,
    strain_input: Vec<T>,
    output: Vec<T>,
    strain_feedthrough: Vec<T>,
    signals: Vec<T>,
    slopes: Vec<T>,
}

impl<T: RealField + Copy> Linearised<T> {
    pub(super) fn new(model: &ScheduledModes, s: f64, trajectory: &Trajectory) -> Self {
        let (mut channels, mut weights) = (Vec::new(), Vec::new());
        if let Some(feedback) = &model.feedback {
            channels = [feedback.drive_rows.as_slice(), &feedback.stress_rows].concat();
            let powers = feedback.drive.terms() - feedback.drive.radii.len();
            for _ in 0..model.inputs {
                weights.extend_from_slice(&feedback.drive.coefficients[powers..]);
            }
            feedback.stress.iter().for_each(|law| weights.extend_from_slice(&law.coefficients[powers..]));
        }
        let at = model.at(s);
        let converted = |values: &[f64]| values.iter().map(|x| nalgebra::convert(*x)).collect();
        Self {
            transition: converted(&at.transition),
            channels: converted(&channels),
            weights: converted(&weights),
            strain_input: converted(&model.strain_input),
            output: converted(&at.output),
            strain_feedthrough: converted(&model.strain_feedthrough),
            signals: converted(&trajectory.signals),
            slopes: converted(&trajectory.slopes),
        }
    }

    /// The system, of the model and the trajectory that it was made of.
    pub(super) fn system<'a>(
        &'a self,
        model: &ScheduledModes,
        trajectory: &'a Trajectory,
    ) -> FeedbackTangent<'a, T> {
        FeedbackTangent {
            modes: model.modes,
            transition: &self.transition,
            channels: &self.channels,
            row: model.states() + model.inputs,
            weights: &self.weights,
            plays: model.feedback.as_ref().map_or(0, |f| f.drive.radii.len()),
            strain_input: &self.strain_input,
            strains: model.inputs,
            output: &self.output,
            strain_feedthrough: &self.strain_feedthrough,
            signals: &self.signals,
            width: trajectory.width,
            slopes: &self.slopes,
            moved: &trajectory.moved,
            before: trajectory.before,
            steps: model.steps,
        }
    }
}
