//! A joint fit linearised at a point.

use super::super::super::layout::Role;
use super::{JointProblem, JointWorkspace};
use hysteron_optimize::{LeastSquaresProblem, Problem};

/// A joint fit linearised at a point.
#[derive(Debug)]
pub(in super::super::super) struct Linearisation {
    /// Columns of the eliminated coefficients, one after the other.
    pub(in super::super::super) linear: Vec<f64>,
    /// Index of the coefficient of each column: u^(index + 1), then weights. Weights held at 0 by their sign
    /// constraint are omitted.
    pub(in super::super::super) eliminated: Vec<usize>,
    /// Derivatives along the searched numbers, one after the other.
    pub(in super::super::super) searched: Vec<f64>,
    /// Weighted residuals.
    pub(in super::super::super) residuals: Vec<f64>,
    /// Coefficients of u, u², … and weights.
    pub(in super::super::super) coefficients: Vec<f64>,
}

impl JointProblem {
    /// The fit linearised at `x`: the eliminated linear columns, the derivatives with respect to the searched
    /// numbers, and the residuals, all with local columns projected out.
    pub(in super::super::super) fn linearise(&self, x: &[f64]) -> Option<Linearisation> {
        let mut ws = self.workspace();
        if !self.is_at(x, &mut ws) && !self.evaluate(x, self.derivatives(), &mut ws) {
            return None;
        }
        let coefficients = self.coefficients(x, &mut ws);
        Some(self.collect(coefficients, &mut ws))
    }

    /// [`Self::linearise`] at coefficients of u, u², … and weights that need not be optimal at `x`.
    pub(in super::super::super) fn linearise_at(
        &self,
        x: &[f64],
        coefficients: &[f64],
        ws: &mut JointWorkspace,
    ) -> Option<Linearisation> {
        let is_free = |(index, role): &(usize, &Role)| match role {
            Role::Projected => true,
            Role::OneSided(_) => coefficients[*index] != 0.0,
            Role::Fixed(_) | Role::Searched(_) => false,
        };
        ws.eliminated = self.layout.linear().enumerate().filter(is_free).map(|(index, _)| index).collect();
        ws.set_stop(&self.stop);
        if !self.respond(x, self.derivatives(), ws) {
            return None;
        }
        self.gather_targets(ws);
        let JointWorkspace { records, column, target, .. } = &mut *ws;
        for (index, value) in coefficients.iter().enumerate() {
            self.gather(index, records, column);
            target.iter_mut().zip(column.iter()).for_each(|(t, c)| *t -= value * c);
        }
        Some(self.collect(coefficients.to_vec(), ws))
    }

    /// Weighted residuals at `x` and any coefficients of u, u², … and weights; empty where it cannot be
    /// simulated.
    pub(in super::super::super) fn residuals_at<'w>(
        &self,
        x: &[f64],
        coefficients: &[f64],
        ws: &'w mut JointWorkspace,
    ) -> &'w [f64] {
        ws.set_stop(&self.stop);
        let done = self.of_each_record(x, ws, |record, candidate, memory, dynamics, ws| {
            record.residual(self.hysteresis, candidate, memory, dynamics, coefficients, ws)
        });
        if !done {
            return &[];
        }
        self.gather_targets(ws);
        &ws.target
    }

    /// Cost at `x` with the best-fitting multiple of these coefficients of u, u², … and weights; +∞ where it
    /// cannot be simulated, or does not respond.
    pub(in super::super) fn cost_of_loop(
        &self,
        x: &[f64],
        coefficients: &[f64],
        ws: &mut JointWorkspace,
    ) -> f64 {
        if self.residuals_at(x, coefficients, ws).is_empty() {
            return f64::INFINITY;
        }
        // The response is what the residual lacks of the measured output.
        let measured = self.records.iter().flat_map(|record| &record.target);
        let (mut of_both, mut of_response) = (0.0, 0.0);
        for (measured, residual) in measured.zip(&ws.target) {
            let response = measured - residual;
            of_both += response * measured;
            of_response += response * response;
        }
        let (factor, count) = (of_both / of_response, ws.target.len() as f64);
        let squares = self.records.iter().flat_map(|record| &record.target).zip(&ws.target);
        let square: f64 = squares.map(|(m, r)| (m - factor * (m - r)).powi(2)).sum();
        let cost = (square / count).sqrt();
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// The records' targets into `ws.target`.
    pub(super) fn gather_targets(&self, ws: &mut JointWorkspace) {
        for (r, record) in ws.records.iter().enumerate() {
            ws.target[self.rows(r)].copy_from_slice(&record.target);
        }
    }

    /// Assembles the linearisation from columns and residuals.
    fn collect(&self, coefficients: Vec<f64>, ws: &mut JointWorkspace) -> Linearisation {
        let count = self.residual_count();
        let mut searched = vec![0.0; count * self.bounds.dimension()];
        self.differentiate(&coefficients, &mut ws.records, &mut searched);
        let mut eliminated = ws.eliminated.clone();
        eliminated.sort_unstable();
        let mut linear = vec![0.0; eliminated.len() * count];
        for (&index, column) in eliminated.iter().zip(linear.chunks_exact_mut(count.max(1))) {
            self.gather(index, &ws.records, column);
        }
        Linearisation { linear, eliminated, searched, residuals: ws.target.clone(), coefficients }
    }
}
