//! Derivatives of a record's output at a candidate whose columns are known.

use std::sync::Mutex;

use rayon::prelude::*;

use super::super::super::projection::Projection;
use super::{JointRecord, Lane, RecordWorkspace};
use crate::dynamics::{InputSpectrum, Response};
use crate::hysteresis::Sensitivities;

/// A direction in which a record's output is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Direction {
    /// Coefficient of u^(index + 1), or α for the index one past.
    Column(usize),
    Beta,
    Gamma,
    N,
    /// ζ(0) of this record.
    Memory,
    /// Tangent number of the response: a parameter of the dynamics, or the delay.
    Dynamics(usize),
}

/// What is known of a candidate when its derivatives are worked out.
struct Known<'a> {
    sensitivities: &'a Sensitivities,
    response: &'a Response,
    total: &'a InputSpectrum,
    local: &'a Projection,
    columns: &'a [f64],
}

impl RecordWorkspace {
    fn split(&mut self) -> (Known<'_>, &mut [Lane]) {
        let Self { sensitivities, response, total, local, columns, lanes, .. } = self;
        (Known { sensitivities, response, total, local, columns }, lanes)
    }
}

impl JointRecord {
    /// Prepares derivatives along the dynamics: the whole input Σ cᵢ uⁱ − α ζ + transients at these coefficients.
    pub(in crate::identify) fn combine(&self, coefficients: &[f64], ws: &mut RecordWorkspace) {
        ws.total.clear();
        let Some((alpha, polynomial)) = coefficients.split_last() else { return };
        for (c, power) in polynomial.iter().zip(&self.powers) {
            ws.total.add(*c, power);
        }
        ws.total.add(*alpha, &ws.zeta);
        if !self.transients.is_empty() {
            // What the transients take of the measured output, beside all else.
            let measured = ws.local.coefficients(&self.target);
            for (index, transient) in self.transients.iter().enumerate() {
                let at = self.nuisance.len() + index;
                let taken: f64 = coefficients.iter().zip(&ws.transient_shares).map(|(c, s)| c * s[at]).sum();
                ws.total.add(measured[at] - taken, transient);
            }
        }
    }

    /// ∂(Σ cᵢ Φᵢ + α Φ_ζ)/∂direction at fixed coefficients, weighted and without local columns, into the slice beside each
    /// direction; zero where there is no direction or no derivative. After [`Self::respond`] with derivatives and
    /// [`Self::combine`].
    pub(in crate::identify) fn differentiate(
        &self,
        wanted: Vec<(Option<Direction>, &mut [f64])>,
        alpha: f64,
        ws: &mut RecordWorkspace,
    ) {
        let (known, lanes) = ws.split();
        // Dealt out one by one, since some take three times as long as others.
        let deal = Mutex::new(wanted.into_iter());
        lanes.par_iter_mut().for_each(|lane| {
            while let Some((direction, out)) = deal.lock().ok().and_then(|mut deal| deal.next()) {
                let written = direction.is_some_and(|d| self.derivative(d, alpha, &known, lane, out));
                if !written {
                    out.fill(0.0);
                }
            }
        });
    }

    /// The derivative in one direction. `false` where it cannot be worked out.
    fn derivative(
        &self,
        direction: Direction,
        alpha: f64,
        known: &Known<'_>,
        lane: &mut Lane,
        out: &mut [f64],
    ) -> bool {
        let samples = self.samples();
        let (source, rest) = match direction {
            Direction::Column(index) => {
                out.copy_from_slice(&known.columns[index * samples..(index + 1) * samples]);
                return true;
            }
            Direction::Beta => (&known.sensitivities.d_beta, 0.0),
            Direction::Gamma => (&known.sensitivities.d_gamma, 0.0),
            Direction::N => (&known.sensitivities.d_n, 0.0),
            Direction::Memory => (&known.sensitivities.d_start, self.memory_before(1.0)),
            Direction::Dynamics(which) => {
                if self.plan.apply_tangent(known.response, which, known.total, &mut lane.plan, out).is_err() {
                    return false;
                }
                self.end(out);
                self.finish(known, out);
                return true;
            }
        };
        if !self.input_spectrum(source, rest, alpha, lane)
            || self.plan.apply(known.response, &lane.spectrum, &mut lane.plan, out).is_err()
        {
            return false;
        }
        self.end(out);
        if let Some(unit) = &self.rest {
            out.iter_mut().zip(unit).for_each(|(o, unit)| *o -= alpha * rest * unit);
        }
        self.finish(known, out);
        true
    }

    /// Weights a derivative and takes its part in the local columns off.
    fn finish(&self, known: &Known<'_>, out: &mut [f64]) {
        out.iter_mut().zip(&self.weight).for_each(|(o, w)| *o *= w);
        known.local.project(out);
    }
}
