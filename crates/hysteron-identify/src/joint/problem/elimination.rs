//! Elimination of everything linear at a candidate.

use rayon::prelude::*;

use super::super::super::layout::Role;
use super::super::record::{Derivatives, RecordWorkspace};
use super::{JointProblem, JointWorkspace};
use hysteron_numeric::non_negative_least_squares;
use hysteron_optimize::{LeastSquaresProblem, Problem};

impl JointProblem {
    /// Column `index` of the linear part over all records.
    pub(super) fn gather(&self, index: usize, records: &[RecordWorkspace], out: &mut [f64]) {
        for (r, ws) in records.iter().enumerate() {
            let samples = self.records[r].samples();
            out[self.rows(r)].copy_from_slice(&ws.columns[index * samples..(index + 1) * samples]);
        }
    }

    /// Residual after elimination of the linear parameters, into `ws.target`; the columns stay in
    /// `ws.projection`.
    pub(super) fn eliminate(&self, x: &[f64], derivatives: Derivatives<'_>, ws: &mut JointWorkspace) -> bool {
        if !self.respond(x, derivatives, ws) {
            return false;
        }
        self.gather_targets(ws);
        ws.projection.clear();
        ws.eliminated.clear();
        let JointWorkspace { records, column, target, projection, eliminated, .. } = ws;
        let mut signed = Vec::new();
        for (index, role) in self.layout.linear().enumerate() {
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
        signed.is_empty() || self.eliminate_signed(&signed, ws)
    }

    /// Eliminates the sign-constrained `signed` columns from the target by non-negative least squares, after
    /// those eliminated so far; columns with nonzero coefficients are added to these. `false` where the
    /// coefficients are not finite, and after a stop.
    fn eliminate_signed(&self, signed: &[(usize, f64)], ws: &mut JointWorkspace) -> bool {
        let JointWorkspace { records, target, projection, signed: columns, absolute, eliminated, .. } = ws;
        let count = target.len();
        columns.resize(signed.len() * count, 0.0);
        columns.par_chunks_exact_mut(count.max(1)).zip(signed).for_each(|(column, &(index, sign))| {
            self.gather(index, records, column);
            column.iter_mut().for_each(|c| *c *= sign);
            projection.project(column);
        });
        let columns: Vec<&[f64]> = columns.chunks_exact(count.max(1)).collect();
        if self.stop.is_requested() {
            return false;
        }
        let used = non_negative_least_squares(&columns, target);
        if used.iter().any(|c| c.is_nan()) {
            return false;
        }
        *absolute = used;
        for (&(index, _), _) in signed.iter().zip(&*absolute).filter(|(_, c)| **c > 0.0) {
            if self.stop.is_requested() {
                return false;
            }
            projection.push(|q| self.gather(index, records, q));
            eliminated.push(index);
        }
        projection.project(target);
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

    /// Coefficients of u, u², … and weights at `x`, after [`Self::eliminate`].
    pub(super) fn coefficients(&self, x: &[f64], ws: &mut JointWorkspace) -> Vec<f64> {
        let JointWorkspace { records, column, projection, eliminated, .. } = ws;
        let mut measured: Vec<f64> =
            records.iter().flat_map(|record| record.target.iter().copied()).collect();
        let mut coefficients: Vec<f64> =
            self.layout.linear().map(|role| role.value(x).unwrap_or(0.0)).collect();
        for (index, role) in self.layout.linear().enumerate() {
            if role.value(x).is_some() {
                self.gather(index, records, column);
                measured.iter_mut().zip(column.iter()).for_each(|(t, c)| *t -= coefficients[index] * c);
            }
        }
        for (&index, value) in eliminated.iter().zip(projection.coefficients(&measured)) {
            coefficients[index] = value;
        }
        coefficients
    }
}
