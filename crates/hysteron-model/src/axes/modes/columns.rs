//! The matrices of a step column by column: its sums run side by side, each in the order of its row.

use super::ScheduledModes;

/// Channels whose sums are computed side by side.
const ABREAST: usize = 8;

/// The matrices of a model column by column: the sums of a step then run side by side, each in the order of
/// its row.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// Columns of (x, u) for every [`ABREAST`] rows of v, then of σ; padded by zeros.
    channels: Vec<Vec<[f64; ABREAST]>>,
    /// B, then H: N columns each.
    forces: Vec<Vec<f64>>,
}

impl Columns {
    pub(super) fn new(model: &ScheduledModes) -> Self {
        let (n, row) = (model.inputs, model.states() + model.inputs);
        let rows: Vec<&[f64]> = model.feedback.as_ref().map_or_else(Vec::new, |f| {
            f.drive_rows.chunks_exact(row).chain(f.stress_rows.chunks_exact(row)).collect()
        });
        let side_by_side = |rows: &[&[f64]]| {
            let entry = |k: usize| std::array::from_fn(|r| rows.get(r).map_or(0.0, |row| row[k]));
            (0..row).map(entry).collect()
        };
        let column = |matrix: &[f64], i: usize| matrix.iter().skip(i).step_by(n).copied().collect();
        let of = |matrix: &[f64]| -> Vec<Vec<f64>> { (0..n).map(|i| column(matrix, i)).collect() };
        Self {
            channels: rows.chunks(ABREAST).map(side_by_side).collect(),
            forces: [of(&model.input), of(&model.strain_input)].concat(),
        }
    }

    /// v, then σ.
    pub(super) fn channels(&self, x: &[f64], u: &[f64], z: &mut [f64]) {
        for (z, columns) in z.chunks_mut(ABREAST).zip(&self.channels) {
            let (of_x, of_u) = columns.split_at(x.len());
            let (x, u) = (combined(of_x, x), combined(of_u, u));
            z.iter_mut().zip(x.iter().zip(&u)).for_each(|(z, (x, u))| *z = x + u);
        }
    }

    /// to = B u + H w.
    pub(super) fn force(&self, u: &[f64], w: &[f64], to: &mut [f64]) {
        let (of_u, of_w) = self.forces.split_at(u.len());
        to.fill(0.0);
        for (column, value) in of_u.iter().zip(u).chain(of_w.iter().zip(w)) {
            to.iter_mut().zip(column).for_each(|(to, entry)| *to += entry * value);
        }
    }
}

/// Σ of the columns times the values.
fn combined(columns: &[[f64; ABREAST]], values: &[f64]) -> [f64; ABREAST] {
    let mut sum = [0.0; ABREAST];
    for (column, value) in columns.iter().zip(values) {
        sum.iter_mut().zip(column).for_each(|(sum, entry)| *sum += entry * value);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axes::{FeedbackStrain, LevelLaw, StrainLaw};

    #[test]
    fn the_sums_are_those_of_the_rows() {
        // Five inputs: ten channels, more than one group of rows.
        let (n, modes) = (5, 2);
        let states = 2 * modes + n;
        let numbers = |count: usize, seed: f64| -> Vec<f64> {
            (0..count).map(|k| (seed + 1.7 * k as f64).sin()).collect()
        };
        let law = || StrainLaw {
            coefficients: vec![],
            radii: vec![],
            slopes: vec![],
            variance: 1.0,
            reach: f64::INFINITY,
        };
        let model = ScheduledModes {
            inputs: n,
            outputs: 1,
            modes,
            sample_rate_hz: 1000.0,
            steps: 1,
            level: LevelLaw {
                reference: 1.0,
                exponent: 1.0,
                lowest: 1.0,
                highest: 1.0,
                time_constant_s: 1.0,
            },
            transition: vec![0.0; states],
            transition_slopes: vec![0.0; states],
            input: numbers(states * n, 0.1),
            strain_input: numbers(states * n, 0.2),
            output: vec![0.0; states],
            output_slopes: vec![0.0; states],
            feedthrough: vec![0.0; n],
            feedthrough_slopes: vec![0.0; n],
            strain_feedthrough: vec![0.0; n],
            feedback: Some(FeedbackStrain {
                drive_rows: numbers(n * (states + n), 0.3),
                stress_rows: numbers(n * (states + n), 0.4),
                drive: law(),
                stress: (0..n).map(|_| law()).collect(),
            }),
        };
        let (x, u, w) = (numbers(states, 0.5), numbers(n, 0.6), numbers(n, 0.7));
        let columns = Columns::new(&model);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut z = vec![f64::NAN; 2 * n];
        columns.channels(&x, &u, &mut z);
        let feedback = model.feedback.as_ref().unwrap();
        let state = [x.clone(), u.clone()].concat();
        for (k, z) in z.iter().enumerate() {
            let rows = if k < n { &feedback.drive_rows } else { &feedback.stress_rows };
            let expected = dot(&rows[k % n * (states + n)..][..states + n], &state);
            assert!((z - expected).abs() < 1e-14, "{z} {expected}");
        }
        let mut force = vec![f64::NAN; states];
        columns.force(&u, &w, &mut force);
        for (k, force) in force.iter().enumerate() {
            let expected = dot(&model.input[k * n..][..n], &u) + dot(&model.strain_input[k * n..][..n], &w);
            assert!((force - expected).abs() < 1e-14, "{force} {expected}");
        }
    }
}
