//! Elimination of everything linear at a candidate.

use rayon::prelude::*;

use super::super::super::layout::Role;
use super::super::record::{Derivatives, RecordWorkspace};
use super::{JointProblem, JointWorkspace};
use hysteron_numeric::{dot, non_negative_least_squares, subtract};
use hysteron_optimize::{LeastSquaresProblem, Problem};

/// Sign-constrained columns shorter than this share of the longest have no weight: operators that the drive does
/// not move respond to the unknown memory alone, and a memory near 0 with a weight without bound would stand for
/// a transient.
const NOTHING: f64 = 1e-6;

impl JointProblem {
    /// Column `index` of the linear part over all records.
    pub(super) fn gather(&self, index: usize, records: &[RecordWorkspace], out: &mut [f64]) {
        for (r, ws) in records.iter().enumerate() {
            let samples = self.records[r].samples();
            out[self.rows(r)].copy_from_slice(&ws.columns[index * samples..(index + 1) * samples]);
        }
    }

    /// Residual after elimination of the linear parameters, into `ws.target`; the columns stay in
    /// `ws.projection`, the sign-constrained ones in `ws.signed`. `false` where it cannot be simulated, and after a
    /// stop.
    pub(super) fn eliminate(&self, x: &[f64], derivatives: Derivatives<'_>, ws: &mut JointWorkspace) -> bool {
        ws.coefficients.clear();
        if !self.respond(x, derivatives, ws) {
            return false;
        }
        self.gather_targets(ws);
        ws.projection.clear();
        ws.eliminated.clear();
        let JointWorkspace { records, column, target, projection, absolute, eliminated, .. } = ws;
        let mut signed = Vec::new();
        for (index, role) in self.layout.linear().enumerate() {
            // A column of millions of samples takes a tenth of a second.
            if self.stop.is_requested() {
                return false;
            }
            match role {
                Role::Projected => {
                    projection.push(|q| self.gather(index, records, q));
                    eliminated.push(index);
                }
                Role::OneSided(sign) => signed.push((index, *sign)),
                Role::Fixed(_) | Role::Searched(_) => {
                    let value = role.value(x).unwrap_or(0.0);
                    self.gather(index, records, column);
                    target.iter_mut().zip(column.iter()).for_each(|(t, c)| *t -= value * c);
                }
            }
        }
        projection.project(target);
        absolute.clear();
        signed.is_empty() || self.eliminate_signed(&signed, ws)
    }

    /// Eliminates the sign-constrained `signed` columns from the target by non-negative least squares, after
    /// those of the projection; columns with nonzero coefficients count as eliminated. `false` where the
    /// coefficients are not finite, and after a stop.
    fn eliminate_signed(&self, signed: &[(usize, f64)], ws: &mut JointWorkspace) -> bool {
        let JointWorkspace { records, target, projection, signed: columns, absolute, eliminated, .. } = ws;
        let count = target.len();
        columns.resize(signed.len() * count, 0.0);
        columns.par_chunks_exact_mut(count.max(1)).zip(signed).for_each(|(column, &(index, sign))| {
            if !self.stop.is_requested() {
                self.gather(index, records, column);
                column.iter_mut().for_each(|c| *c *= sign);
                projection.project(column);
            }
        });
        if self.stop.is_requested() {
            return false;
        }
        let norms: Vec<f64> = columns.par_chunks_exact(count.max(1)).map(|c| dot(c, c).sqrt()).collect();
        let longest = norms.iter().copied().fold(0.0, f64::max);
        let short =
            columns.chunks_exact_mut(count.max(1)).zip(norms).filter(|(_, norm)| *norm < NOTHING * longest);
        short.for_each(|(column, _)| column.fill(0.0));
        let columns: Vec<&[f64]> = columns.chunks_exact(count.max(1)).collect();
        let used = non_negative_least_squares(&columns, target);
        if used.iter().any(|c| c.is_nan()) {
            return false;
        }
        *absolute = used;
        let used = signed.iter().zip(&*absolute).zip(columns).filter(|((_, c), _)| **c > 0.0);
        for ((&(index, _), &c), column) in used {
            subtract(target, c, column);
            eliminated.push(index);
        }
        true
    }

    /// Weighted columns of u, u², … and of the weights at `x`, one after the other, and the target, all with
    /// the records' local columns projected out.
    pub(in super::super) fn linear_columns(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut ws = self.workspace();
        if !self.respond(x, None, &mut ws) {
            return None;
        }
        let count = self.residual_count();
        let mut columns = vec![0.0; count * self.layout.linear().count()];
        for (index, column) in columns.chunks_exact_mut(count.max(1)).enumerate() {
            self.gather(index, &ws.records, column);
        }
        let target = ws.records.iter().flat_map(|record| record.target.iter().copied()).collect();
        Some((columns, target))
    }

    /// Coefficients of u, u², … and weights at `x`; `None` where it cannot be simulated.
    pub(in super::super) fn linear_coefficients(&self, x: &[f64]) -> Option<Vec<f64>> {
        let mut ws = self.workspace();
        self.evaluate(x, None, &mut ws).then(|| self.coefficients(x, &mut ws))
    }

    /// Coefficients of u, u², … and weights at `x`, after [`Self::eliminate`].
    pub(super) fn coefficients(&self, x: &[f64], ws: &mut JointWorkspace) -> Vec<f64> {
        if !ws.coefficients.is_empty() {
            return ws.coefficients.clone();
        }
        let JointWorkspace { records, column, projection, absolute, eliminated, .. } = ws;
        let mut measured: Vec<f64> =
            records.iter().flat_map(|record| record.target.iter().copied()).collect();
        let mut coefficients: Vec<f64> =
            self.layout.linear().map(|role| role.value(x).unwrap_or(0.0)).collect();
        let signs = self.layout.linear().enumerate().filter_map(|(index, role)| match role {
            Role::OneSided(sign) => Some((index, sign)),
            _ => None,
        });
        signs.zip(&*absolute).for_each(|((index, sign), c)| coefficients[index] = sign * c);
        for (index, &value) in coefficients.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            self.gather(index, records, column);
            subtract(&mut measured, value, column);
        }
        for (&index, value) in eliminated.iter().zip(projection.coefficients(&measured)) {
            coefficients[index] = value;
        }
        ws.coefficients.clone_from(&coefficients);
        coefficients
    }
}
