//! Gradient of a weighted sum of the outputs of a bank under feedback through plays, by one pass backwards.

use super::{FeedbackTangent, Forcing, LANES, Target};

/// A parameter's direct action: parameter, place of its target among the adjoints, signal, factor.
type Action = (usize, usize, usize, f64);

impl FeedbackTangent<'_, f64> {
    /// Σ over samples and outputs of weight · ∂y/∂parameter: what [`Self::run`] gives for all parameters at
    /// once, times `weights` (outputs of a sample side by side), by the adjoint recursion. [`LANES`] numbers
    /// for every block of `forcing`, for the price of about one simulation.
    pub fn gradient(&self, forcing: &[Vec<Forcing>], weights: &[f64]) -> Vec<f64> {
        let channels = self.channels.len() / self.row.max(1);
        let states = self.transition.len();
        let outputs = self.output.len() / states.max(1);
        let actions = self.actions(forcing, channels);
        let mut gradient = vec![0.0; forcing.len() * LANES];
        let silent = vec![0.0; outputs];
        // Derivatives of the sum with respect to the channels, the strains and the next states.
        let mut adjoint = vec![0.0; channels + self.strains + states];
        let mut of_plays = vec![0.0; channels * self.plays];
        let mut before = vec![0.0; states];
        for (step, signals) in self.signals.chunks_exact(self.width).enumerate().rev() {
            let sample = step.checked_sub(self.before).filter(|k| k.is_multiple_of(self.steps));
            let of_outputs = sample.and_then(|k| weights.chunks_exact(outputs.max(1)).nth(k / self.steps));
            let of_outputs = of_outputs.unwrap_or(&silent);
            let (of_channels, rest) = adjoint.split_at_mut(channels);
            let (of_strains, of_states) = rest.split_at_mut(self.strains);
            if channels > 0 {
                of_strains.fill(0.0);
                add_transposed(self.strain_input, of_states, of_strains);
                add_transposed(self.strain_feedthrough, of_outputs, of_strains);
                self.through_laws(step, of_strains, of_channels, &mut of_plays);
            }
            for (parameter, place, signal, factor) in &actions {
                gradient[*parameter] += factor * signals[*signal] * adjoint[*place];
            }
            let (of_channels, rest) = adjoint.split_at_mut(channels);
            let of_states = &mut rest[self.strains..];
            before.fill(0.0);
            add_transposed(self.output, of_outputs, &mut before);
            for (row, of_channel) in self.channels.chunks_exact(self.row.max(1)).zip(of_channels.iter()) {
                before.iter_mut().zip(row).for_each(|(to, r)| *to += r * of_channel);
            }
            self.add_transition(of_states, &mut before);
            of_states.copy_from_slice(&before);
        }
        gradient
    }

    fn actions(&self, forcing: &[Vec<Forcing>], channels: usize) -> Vec<Action> {
        let place = |target: Target| match target {
            Target::Channel(i) => i,
            Target::Strain(i) => channels + i,
            Target::State(i) => channels + self.strains + i,
        };
        let of_block = |(block, forcing): (usize, &Vec<Forcing>)| -> Vec<Action> {
            let action = |f: &Forcing| (block * LANES + f.lane, place(f.target), f.signal, f.factor);
            forcing.iter().map(action).collect()
        };
        forcing.iter().enumerate().flat_map(of_block).collect()
    }

    /// From the strains through the laws to the channels, and to the plays of the step before.
    fn through_laws(&self, step: usize, of_strains: &[f64], of_channels: &mut [f64], of_plays: &mut [f64]) {
        let channels = of_channels.len();
        for (i, of_channel) in of_channels.iter_mut().enumerate() {
            let of_strain = of_strains[i % self.strains];
            let moved = self.moved[step * channels + i];
            let bank = i * self.plays..(i + 1) * self.plays;
            *of_channel = self.slopes[step * channels + i] * of_strain;
            for (j, (play, weight)) in of_plays[bank.clone()].iter_mut().zip(&self.weights[bank]).enumerate()
            {
                *play += weight * of_strain;
                // A play that moves follows its channel and forgets the step before.
                if moved >> j & 1 == 1 {
                    *of_channel += std::mem::take(play);
                }
            }
        }
    }

    /// to += Aᵀ · of.
    fn add_transition(&self, of: &[f64], to: &mut [f64]) {
        let (poles, lags) = self.transition.split_at(2 * self.modes);
        let (of_modes, of_lags) = of.split_at(2 * self.modes);
        let (to_modes, to_lags) = to.split_at_mut(2 * self.modes);
        let pairs = to_modes.chunks_exact_mut(2).zip(of_modes.chunks_exact(2));
        for ((to, of), p) in pairs.zip(poles.chunks_exact(2)) {
            to[0] += p[0] * of[0] + p[1] * of[1];
            to[1] += p[0] * of[1] - p[1] * of[0];
        }
        to_lags.iter_mut().zip(of_lags).zip(lags).for_each(|((to, of), a)| *to += a * of);
    }
}

/// to += matrixᵀ · of, of a matrix whose rows are as long as `to`.
fn add_transposed(matrix: &[f64], of: &[f64], to: &mut [f64]) {
    for (row, of) in matrix.chunks_exact(to.len().max(1)).zip(of) {
        to.iter_mut().zip(row).for_each(|(to, entry)| *to += entry * of);
    }
}
