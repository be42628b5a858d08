//! Ridge on the slopes of the schedule: shrinks them towards one common relative shift.
//!
//! Records of few levels determine the slopes poorly, and an error of a slope is one of every level between.
//! The penalty
//!
//! ```text
//! R = μ Σ_g min_κ Σ_j H_jj (s_j − κ b_j)²
//! ```
//!
//! over the groups g, poles and rows of the outputs, leaves free what all slopes s of a group have in
//! common: b is p ln p for a pole, whose frequency and damping rate then change by the same share κ, and the
//! coefficient itself for C and D. H_jj, the information on each slope alone, makes R independent of units.

use nalgebra::{DMatrix, DVector};

use super::columns::{Freedom, Group};
use hysteron_model::axes::ScheduledModes;
use hysteron_numeric::Complex64;

/// Slopes of one group: column, information, direction of the common shift.
struct Shrunk {
    columns: Vec<usize>,
    information: Vec<f64>,
    common: Vec<f64>,
}

/// The penalty at one model.
pub(super) struct Ridge {
    groups: Vec<Shrunk>,
    weight: f64,
}

impl Ridge {
    /// Of the slopes among the free parameters, with their information on the diagonal of `matrix`.
    pub(super) fn new(freedom: &Freedom, model: &ScheduledModes, matrix: &DMatrix<f64>, weight: f64) -> Self {
        let mut poles = Shrunk { columns: Vec::new(), information: Vec::new(), common: Vec::new() };
        let mut rows = Shrunk { columns: Vec::new(), information: Vec::new(), common: Vec::new() };
        for (group, columns) in freedom.places(model) {
            let (shrunk, common) = match group {
                Group::TransitionSlopes => (&mut poles, shifts_of_poles(model)),
                Group::OutputSlopes => (&mut rows, model.output.clone()),
                Group::FeedthroughSlopes => (&mut rows, model.feedthrough.clone()),
                _ => continue,
            };
            shrunk.information.extend(columns.clone().map(|k| matrix[(k, k)]));
            shrunk.columns.extend(columns);
            shrunk.common.extend(common);
        }
        Self { groups: vec![poles, rows], weight }
    }

    /// R at these values of the free parameters.
    pub(super) fn of(&self, values: &[f64]) -> f64 {
        let of_group = |group: &Shrunk| {
            let slopes = || group.columns.iter().map(|&k| values[k]).zip(&group.information);
            let square: f64 = slopes().map(|(s, h)| h * s * s).sum();
            let along: f64 = slopes().zip(&group.common).map(|((s, h), b)| h * s * b).sum();
            square - along * along / group.size().max(f64::MIN_POSITIVE)
        };
        self.weight * self.groups.iter().map(of_group).sum::<f64>()
    }

    /// Adds half the second derivatives of R to `matrix` and its descent at `values` to `gradient`.
    pub(super) fn add(&self, matrix: &mut DMatrix<f64>, gradient: &mut DVector<f64>, values: &[f64]) {
        for group in &self.groups {
            let size = group.size().max(f64::MIN_POSITIVE);
            let places = || group.columns.iter().zip(&group.information).zip(&group.common);
            for ((&i, h), b) in places() {
                matrix[(i, i)] += self.weight * h;
                gradient[i] -= self.weight * h * values[i];
                for ((&j, other), c) in places() {
                    let shared = self.weight * h * b * other * c / size;
                    matrix[(i, j)] -= shared;
                    gradient[i] += shared * values[j];
                }
            }
        }
    }
}

impl Shrunk {
    /// Σ H_jj b_j².
    fn size(&self) -> f64 {
        self.information.iter().zip(&self.common).map(|(h, b)| h * b * b).sum()
    }
}

/// Change of every pole and lag for a relative shift of all frequencies, p ln p.
fn shifts_of_poles(model: &ScheduledModes) -> Vec<f64> {
    let (pairs, lags) = model.transition.split_at(2 * model.modes);
    let of_pair = |p: &[f64]| {
        let p = Complex64::new(p[0], p[1]);
        let shift = p * p.ln();
        [shift.re, shift.im]
    };
    let of_lag = |a: &f64| a * a.abs().max(f64::MIN_POSITIVE).ln();
    pairs.chunks_exact(2).flat_map(of_pair).chain(lags.iter().map(of_lag)).collect()
}
