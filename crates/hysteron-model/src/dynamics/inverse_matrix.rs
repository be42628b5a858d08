//! Regularised inverse of the responses from several inputs to several outputs, for references known ahead.
//!
//! The inputs v minimise
//!
//! Σ |r − P v|² + Σ_n λ_n Σ |Δ²v_n|²
//!
//! with P the plant from held samples to samples, outputs × inputs. With Λ = diag(λ) and ρ = |1 − z|⁴, v = W
//! r, W = (PᴴP + ρΛ)⁻¹Pᴴ, or, the same where there are at least as many inputs as outputs, W = Λ⁻¹Pᴴ(PΛ⁻¹Pᴴ +
//! ρ)⁻¹, which exists at rest, ρ = 0, too: surplus inputs share the motion so that Σ λ v² is least. λ_n =
//! ε/(1 − ε) ‖P_n‖²/ρ at the bandwidth, P_n the column of input n, so that a diagonal plant has the scalar
//! inverses of [`super::inverse`].

use nalgebra::DMatrix;

use super::{DynamicsError, InverseAim, Response, SimulationPlan};
use crate::dynamics_error::check_length;
use hysteron_numeric::Complex64;

/// Responses of a plan from several inputs to several outputs.
#[derive(Clone, Debug)]
pub struct ResponseMatrix {
    /// Outputs.
    pub rows: usize,
    /// Inputs.
    pub columns: usize,
    /// Rows × columns, row by row.
    pub entries: Vec<Response>,
}

/// An inverse on the frequencies of its plan.
#[derive(Clone, Debug)]
pub struct MatrixInverse {
    /// W, inputs × outputs.
    pub response: ResponseMatrix,
    /// Largest |W_nm|.
    pub peak: f64,
    /// Gain from white noise on one output's reference to the noise of one input, both rms, the largest over
    /// the inputs with noise on all outputs.
    pub noise_gain: f64,
}

impl SimulationPlan {
    /// The response of a sampled system, outputs × inputs row by row at any z outside the unit circle.
    pub fn sampled_matrix(
        &self,
        rows: usize,
        columns: usize,
        at: impl Fn(Complex64) -> Vec<Complex64>,
    ) -> ResponseMatrix {
        let mut entries = vec![self.empty_response(0); rows * columns];
        for bin in 0..self.bins() {
            let values = at(Complex64::new(self.damping, self.angle(bin)).exp());
            entries.iter_mut().zip(values).for_each(|(entry, value)| entry.values[bin] = value);
        }
        entries.iter_mut().for_each(|entry| self.make_ends_real(&mut entry.values));
        ResponseMatrix { rows, columns, entries }
    }

    /// The regularised inverse of a matrix of responses.
    ///
    /// # Errors
    /// [`DynamicsError::Length`] for responses of another plan; [`DynamicsError::Bandwidth`] for a bandwidth
    /// that is not between 0 and half the sample rate, or where an input moves no output;
    /// [`DynamicsError::Parameter`] for an error that is not between 0 and 1.
    pub fn inverse_matrix(
        &self,
        plant: &ResponseMatrix,
        aim: InverseAim,
    ) -> Result<MatrixInverse, DynamicsError> {
        let (rows, columns) = (plant.rows, plant.columns);
        check_length("entries", plant.entries.len(), rows * columns)?;
        for entry in &plant.entries {
            check_length("response", entry.values.len(), self.bins())?;
        }
        let edge = self.edge(aim)?;
        let matrix =
            |bin: usize| DMatrix::from_fn(rows, columns, |m, n| plant.entries[m * columns + n].values[bin]);
        let share = aim.error / (1.0 - aim.error) / self.roughness(edge);
        let weights: Vec<f64> =
            matrix(edge).column_iter().map(|column| share * column.norm_squared()).collect();
        let refused = || DynamicsError::Bandwidth {
            bandwidth_hz: aim.bandwidth_hz,
            highest_hz: 0.5 * self.sample_rate_hz,
        };
        if !weights.iter().all(|w| *w > 0.0 && w.is_finite()) {
            return Err(refused());
        }
        let mut entries = vec![self.empty_response(0); rows * columns];
        let (mut peak, mut sums) = (0.0_f64, vec![0.0; columns]);
        let (last, length) = (self.bins() - 1, self.transform_length());
        for bin in 0..self.bins() {
            let w = minimiser(&matrix(bin), &weights, self.roughness(bin)).ok_or_else(refused)?;
            let once = bin == 0 || (bin == last && length.is_multiple_of(2));
            for (n, row) in w.row_iter().enumerate() {
                let size = row.norm_squared();
                sums[n] += if once { size } else { 2.0 * size };
                for (m, value) in row.iter().enumerate() {
                    peak = peak.max(value.norm());
                    entries[n * rows + m].values[bin] = *value;
                }
            }
        }
        entries.iter_mut().for_each(|entry| self.make_ends_real(&mut entry.values));
        let noise_gain = sums.iter().fold(0.0_f64, |most, sum| most.max((sum / length as f64).sqrt()));
        let response = ResponseMatrix { rows: columns, columns: rows, entries };
        Ok(MatrixInverse { response, peak, noise_gain })
    }

    /// The responses to `inputs`, one list per input; one list per output.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::transform`] and [`SimulationPlan::apply`].
    pub fn apply_matrix(
        &self,
        matrix: &ResponseMatrix,
        inputs: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, DynamicsError> {
        check_length("inputs", inputs.len(), matrix.columns)?;
        let spectra = inputs.iter().map(|x| self.transform(x)).collect::<Result<Vec<_>, _>>()?;
        let mut workspace = self.workspace();
        let mut part = vec![0.0; self.samples()];
        let mut outputs = vec![vec![0.0; self.samples()]; matrix.rows];
        for (m, y) in outputs.iter_mut().enumerate() {
            for (n, spectrum) in spectra.iter().enumerate() {
                self.apply(&matrix.entries[m * matrix.columns + n], spectrum, &mut workspace, &mut part)?;
                y.iter_mut().zip(&part).for_each(|(y, part)| *y += part);
            }
        }
        Ok(outputs)
    }
}

/// W at one frequency; `None` where the plant is singular.
fn minimiser(plant: &DMatrix<Complex64>, weights: &[f64], roughness: f64) -> Option<DMatrix<Complex64>> {
    let (rows, columns) = plant.shape();
    if columns >= rows {
        let shared = DMatrix::from_fn(columns, rows, |n, m| plant[(m, n)].conj() / weights[n]);
        let mut inner = plant * &shared;
        (0..rows).for_each(|m| inner[(m, m)] += roughness);
        return Some(shared * inner.try_inverse()?);
    }
    let adjoint = plant.adjoint();
    let mut inner = &adjoint * plant;
    (0..columns).for_each(|n| inner[(n, n)] += weights[n] * roughness);
    Some(inner.try_inverse()? * adjoint)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::dynamics::Scheme;
    use crate::start::Start;

    const AIM: InverseAim = InverseAim { bandwidth_hz: 50.0, error: 1e-3 };

    fn plan() -> SimulationPlan {
        SimulationPlan::new(300, 1000.0, Scheme::BandLimited, Start::ZERO).unwrap()
    }

    /// A lag of gain g: g (1 − a)/(z − a).
    fn lag(z: Complex64, gain: f64, a: f64) -> Complex64 {
        gain * (1.0 - a) / (z - a)
    }

    #[test]
    fn a_diagonal_plant_has_the_inverses_of_its_axes() {
        let plan = plan();
        let both = plan.sampled_matrix(2, 2, |z| {
            vec![lag(z, 2.0, 0.5), Complex64::ZERO, Complex64::ZERO, lag(z, 30.0, 0.8)]
        });
        let found = plan.inverse_matrix(&both, AIM).unwrap();
        for axis in [0, 3] {
            let own = plan.inverse(&both.entries[axis], AIM).unwrap();
            for (a, b) in found.response.entries[axis].values.iter().zip(&own.response.values) {
                assert!((a - b).norm() < 1e-12 * b.norm().max(1e-12), "{a} {b}");
            }
        }
        assert!(found.response.entries[1].values.iter().all(|w| w.norm() < 1e-14));
    }

    #[test]
    fn coupled_axes_follow_slow_references_with_more_actuators_than_axes_too() {
        let plan = plan();
        let gains = [[1.0, 0.3, -0.2], [0.1, 2.0, 0.4]];
        let square = |z: Complex64| -> Vec<Complex64> {
            (0..2).flat_map(|m| (0..2).map(move |n| lag(z, gains[m][n], 0.4))).collect()
        };
        let wide = |z: Complex64| -> Vec<Complex64> {
            (0..2).flat_map(|m| (0..3).map(move |n| lag(z, gains[m][n], 0.4))).collect()
        };
        let wave = |k: usize, f: f64| (0.006 * f * k as f64).sin().powi(3);
        let r: Vec<Vec<f64>> = [3.0, 5.0].iter().map(|f| (0..300).map(|k| wave(k, *f)).collect()).collect();
        for plant in [plan.sampled_matrix(2, 2, square), plan.sampled_matrix(2, 3, wide)] {
            let inverse = plan.inverse_matrix(&plant, AIM).unwrap();
            let y = plan.apply_matrix(&plant, &plan.apply_matrix(&inverse.response, &r).unwrap()).unwrap();
            for (y, r) in y.iter().zip(&r) {
                let worst = y.iter().zip(r).take(280).fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
                assert!(worst < 1e-5, "{worst}");
            }
        }
    }

    #[test]
    fn an_input_that_moves_nothing_is_refused() {
        let plan = plan();
        let plant = plan.sampled_matrix(1, 2, |z| vec![lag(z, 1.0, 0.5), Complex64::ZERO]);
        assert!(matches!(plan.inverse_matrix(&plant, AIM), Err(DynamicsError::Bandwidth { .. })));
    }
}
