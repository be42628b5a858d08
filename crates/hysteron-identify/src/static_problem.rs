//! Step 1, the static block (article §4.3, step 1): the operator of Eq. 1 from quasi-static records, as a
//! least-squares problem.
//!
//! Output of one record at a candidate (unit-α form z = α ζ, `docs/theory`, page of Eq. 1):
//!
//! y = offset + F\[ Σ cᵢ uⁱ − α ζ(β', γ', n) \],  F = delay ► first-order lag 1/(T s + 1),
//!
//! with the offset of every record, and by default all cᵢ and α, eliminated by linear least squares. Delay
//! and lag are searched only where a record carries dynamic information (a start from rest).

use super::layout::Role;
use super::projection::Projection;
use hysteron_model::Start;
use hysteron_model::dynamics::Scheme;
use hysteron_model::dynamics::delay::delay_in_place;
use hysteron_model::hysteresis::{ArticleOperator, UnitShape};
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, root_mean_square};

/// One record prepared for the static step.
#[derive(Clone, Debug)]
pub(super) struct StaticRecord {
    /// Drive \[V\]: a prologue that settles the hysteresis (possibly empty), then the record.
    pub(super) input: Vec<f64>,
    /// Samples of the prologue.
    pub(super) prologue: usize,
    /// Voltage at which the device rested before `input` \[V\].
    pub(super) rest_voltage_v: f64,
    /// Measured output \[µm\].
    pub(super) output: Vec<f64>,
    /// Samples of the record that are scored, ascending.
    pub(super) scored: Vec<usize>,
    /// Sample rate \[Hz\]; needed for delay and lag only.
    pub(super) sample_rate_hz: Option<f64>,
    /// Scheme that the lag is simulated by: the model's.
    pub(super) scheme: Scheme,
    /// Allows for a slow creep ln(1 + t/1 s) in addition to the offset.
    pub(super) creep: bool,
    /// Offset held at this value, without creep; it is subtracted from `output`.
    pub(super) held_offset: Option<f64>,
}

impl StaticRecord {
    /// Every `factor`-th sample, the first one included; the prologue must be a multiple of `factor`.
    pub(super) fn thinned(self, factor: usize) -> Self {
        let factor = factor.max(1);
        let every = |x: &[f64]| x.iter().copied().step_by(factor).collect();
        Self {
            input: every(&self.input),
            prologue: self.prologue / factor,
            output: every(&self.output),
            scored: self.scored.iter().filter(|&k| k.is_multiple_of(factor)).map(|k| k / factor).collect(),
            sample_rate_hz: self.sample_rate_hz.map(|rate| rate / factor as f64),
            scheme: self.scheme,
            ..self
        }
    }
}

/// Roles of the parameters of the static step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StaticLayout {
    /// Coefficients of u, u², …
    pub(super) polynomial: Vec<Role>,
    pub(super) alpha: Role,
    pub(super) beta: Role,
    pub(super) gamma: Role,
    pub(super) n: Role,
    pub(super) delay: Role,
    pub(super) lag: Role,
}

/// Values of all parameters of the static step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StaticSolution {
    pub(super) hysteresis: ArticleOperator,
    pub(super) delay_s: f64,
    pub(super) lag_s: f64,
    /// Offset of each record \[µm\].
    pub(super) offsets: Vec<f64>,
    /// Creep of each record \[µm per e-fold of 1 s + t\], 0 where not allowed for.
    pub(super) creeps: Vec<f64>,
}

/// The static step as a problem for [`hysteron_optimize`].
#[derive(Debug)]
pub(super) struct StaticProblem {
    records: Vec<StaticRecord>,
    layout: StaticLayout,
    bounds: Bounds,
    identity: String,
    /// Orthonormal nuisance columns (offset, creep) of each record over its scored samples.
    nuisance: Vec<Projection>,
    /// Scored outputs of all records with the nuisance projected out.
    target: Vec<f64>,
    /// u, u², … of each record.
    powers: Vec<Vec<Vec<f64>>>,
    /// Columns of u, u², … computed once where delay and lag are held.
    held_columns: Vec<Vec<f64>>,
}

/// Scratch of one evaluation.
#[derive(Debug)]
pub struct StaticWorkspace {
    zeta: Vec<f64>,
    column: Vec<f64>,
    target: Vec<f64>,
    projection: Projection,
}

/// The nonlinear part of a candidate.
struct Shape {
    unit: UnitShape,
    delay_s: f64,
    lag_s: f64,
}

impl StaticProblem {
    pub(super) fn new(
        records: Vec<StaticRecord>,
        layout: StaticLayout,
        bounds: Bounds,
        identity: String,
    ) -> Self {
        let nuisance = records
            .iter()
            .map(|record| {
                let mut projection = Projection::new(record.scored.len(), 2);
                if record.held_offset.is_some() {
                    return projection;
                }
                projection.push(|column| column.fill(1.0));
                if record.creep {
                    projection.push(|column| {
                        for (c, &k) in column.iter_mut().zip(&record.scored) {
                            *c = creep_at(record, k);
                        }
                    });
                }
                projection
            })
            .collect();
        let powers = records.iter().map(|r| powers(&r.input, layout.polynomial.len())).collect();
        let target = Vec::with_capacity(records.iter().map(|r| r.scored.len()).sum());
        let held_columns = Vec::new();
        let mut problem = Self { records, layout, bounds, identity, nuisance, target, powers, held_columns };
        for (record, nuisance) in problem.records.iter().zip(&problem.nuisance) {
            let at = problem.target.len();
            problem.target.extend(record.scored.iter().map(|&k| record.output[k]));
            nuisance.project(&mut problem.target[at..]);
        }
        if let (Role::Fixed(delay_s), Role::Fixed(lag_s)) = (problem.layout.delay, problem.layout.lag) {
            problem.hold_columns(delay_s, lag_s);
        }
        problem
    }

    fn hold_columns(&mut self, delay_s: f64, lag_s: f64) {
        let longest = self.records.iter().map(|r| r.input.len()).max().unwrap_or(0);
        let mut signal = vec![0.0; longest];
        self.held_columns = (0..self.layout.polynomial.len())
            .map(|index| {
                let mut column = vec![0.0; self.target.len()];
                self.power_column(index, delay_s, lag_s, &mut signal, &mut column);
                column
            })
            .collect();
    }

    /// The column of u^(index + 1) after delay and lag, nuisance projected out.
    fn power_column(&self, index: usize, delay_s: f64, lag_s: f64, signal: &mut [f64], column: &mut [f64]) {
        let mut at = 0;
        for ((record, nuisance), powers) in self.records.iter().zip(&self.nuisance).zip(&self.powers) {
            let signal = &mut signal[..record.input.len()];
            signal.copy_from_slice(&powers[index]);
            let rest = record.rest_voltage_v.powi(index as i32 + 1);
            at += finish(record, nuisance, (delay_s, lag_s), rest, signal, &mut column[at..]);
        }
    }

    /// β', γ' in the unit-α form. With α eliminated the search is in β', γ' themselves.
    fn shape(&self, x: &[f64]) -> Option<Shape> {
        let StaticLayout { alpha, beta, gamma, n, delay, lag, .. } = &self.layout;
        let (mut b, mut g, n) = (beta.value(x)?, gamma.value(x)?, n.value(x)?);
        if let Some(alpha) = alpha.value(x) {
            let scale = alpha.abs().powf(n - 1.0);
            b *= scale;
            g *= alpha.signum() * scale;
        }
        let unit = UnitShape { beta: b, gamma: g, n };
        Some(Shape { unit, delay_s: delay.value(x)?, lag_s: lag.value(x)? })
    }

    /// Calls `write` with every column of the linear part, in the order u, u², …, −ζ; `write` gets the
    /// column's role, and its values on the scored samples of all records.
    fn columns(
        &self,
        shape: &Shape,
        ws: &mut StaticWorkspace,
        mut write: impl FnMut(Role, &[f64], &mut Projection, &mut [f64]),
    ) -> bool {
        let StaticWorkspace { zeta, column, target, projection } = ws;
        for (index, &role) in self.layout.polynomial.iter().enumerate() {
            if let Some(held) = self.held_columns.get(index) {
                write(role, held, projection, target);
                continue;
            }
            self.power_column(index, shape.delay_s, shape.lag_s, zeta, column);
            write(role, column, projection, target);
        }
        let mut at = 0;
        for (record, nuisance) in self.records.iter().zip(&self.nuisance) {
            let signal = &mut zeta[..record.input.len()];
            let start = Start::Rest { voltage_v: record.rest_voltage_v };
            if shape.unit.simulate_every(1, &record.input, start, signal).is_err() {
                return false;
            }
            let here = &mut column[at..];
            let done = finish(record, nuisance, (shape.delay_s, shape.lag_s), 0.0, signal, here);
            here[..done].iter_mut().for_each(|c| *c = -*c);
            at += done;
        }
        write(self.layout.alpha, column, projection, target);
        true
    }

    /// Residual after elimination of everything linear, in `ws.target`; the columns stay in `ws.projection`.
    fn eliminate(&self, x: &[f64], ws: &mut StaticWorkspace) -> bool {
        let Some(shape) = self.shape(x) else { return false };
        ws.target.copy_from_slice(&self.target);
        ws.projection.clear();
        let done = self.columns(&shape, ws, |role, column, projection, target| match role.value(x) {
            Some(value) => target.iter_mut().zip(column.iter()).for_each(|(t, c)| *t -= value * c),
            None => projection.push(|q| q.copy_from_slice(column)),
        });
        if done {
            ws.projection.project(&mut ws.target);
        }
        done
    }

    /// All parameter values at the candidate `x`, the eliminated ones by linear least squares.
    pub(super) fn solve(&self, x: &[f64]) -> Option<StaticSolution> {
        let mut ws = self.workspace();
        let shape = self.shape(x)?;
        if !self.eliminate(x, &mut ws) {
            return None;
        }
        // Coefficients of the projected columns, fitted to the target less the fixed columns.
        let mut known = self.workspace();
        let mut measured = self.target.clone();
        let mut roles = Vec::new();
        self.columns(&shape, &mut known, |role, column, _, _| {
            roles.push(role);
            if let Some(value) = role.value(x) {
                measured.iter_mut().zip(column.iter()).for_each(|(t, c)| *t -= value * c);
            }
        });
        let mut eliminated = ws.projection.coefficients(&measured).into_iter();
        let values: Vec<f64> =
            roles.iter().map(|role| role.value(x).or_else(|| eliminated.next())).collect::<Option<_>>()?;
        let (alpha, polynomial) = values.split_last()?;
        let hysteresis = ArticleOperator::from_unit(polynomial.to_vec(), *alpha, shape.unit).ok()?;
        let mut solution = StaticSolution {
            hysteresis,
            delay_s: shape.delay_s,
            lag_s: shape.lag_s,
            offsets: Vec::new(),
            creeps: Vec::new(),
        };
        for (record, nuisance) in self.records.iter().zip(&self.nuisance) {
            let simulated = simulate(record, &solution)?;
            let rest: Vec<f64> = record.scored.iter().map(|&k| record.output[k] - simulated[k]).collect();
            let found = nuisance.coefficients(&rest);
            solution.offsets.push(match record.held_offset {
                Some(offset) => offset,
                None => found.first().copied()?,
            });
            solution.creeps.push(found.get(1).copied().unwrap_or(0.0));
        }
        Some(solution)
    }

    /// Derivatives of the residuals at `x` with respect to a lag of the whole output \[µm/s\]: the velocity
    /// of the model's output by central differences. `None` for records without a rate.
    pub(super) fn along_a_lag(&self, x: &[f64]) -> Option<Vec<f64>> {
        let solution = self.solve(x)?;
        let mut columns = Vec::with_capacity(self.target.len());
        for (record, nuisance) in self.records.iter().zip(&self.nuisance) {
            let rate_hz = record.sample_rate_hz?;
            let y = simulate(record, &solution)?;
            let velocity = |&k: &usize| {
                let (before, after) = (k.saturating_sub(1), (k + 1).min(y.len() - 1));
                (y[after] - y[before]) * rate_hz / (after - before).max(1) as f64
            };
            let mut column: Vec<f64> = record.scored.iter().map(velocity).collect();
            nuisance.project(&mut column);
            columns.extend(column);
        }
        Some(columns)
    }
}

/// Output of `record` by the solution, without offset and creep.
pub(super) fn simulate(record: &StaticRecord, solution: &StaticSolution) -> Option<Vec<f64>> {
    let mut v = vec![0.0; record.input.len()];
    solution
        .hysteresis
        .simulate(&record.input, Start::Rest { voltage_v: record.rest_voltage_v }, &mut v)
        .ok()?;
    let rest = solution.hysteresis.polynomial_at(record.rest_voltage_v);
    if let Some(rate) = record.sample_rate_hz {
        delay_in_place(&mut v, solution.delay_s * rate, rest);
        lag(&mut v, rest, solution.lag_s * rate, record.scheme);
    }
    Some(v.split_off(record.prologue))
}

/// Delays and lags `signal`, at rest at `rest` before, and writes its scored samples, nuisance projected out,
/// to the front of `column`; returns their number.
fn finish(
    record: &StaticRecord,
    nuisance: &Projection,
    (delay_s, lag_s): (f64, f64),
    rest: f64,
    signal: &mut [f64],
    column: &mut [f64],
) -> usize {
    if let Some(rate) = record.sample_rate_hz {
        delay_in_place(signal, delay_s * rate, rest);
        lag(signal, rest, lag_s * rate, record.scheme);
    }
    let column = &mut column[..record.scored.len()];
    for (c, &k) in column.iter_mut().zip(&record.scored) {
        *c = signal[record.prologue + k];
    }
    nuisance.project(column);
    column.len()
}

/// u, u², … up to `degree`.
fn powers(u: &[f64], degree: usize) -> Vec<Vec<f64>> {
    let mut powers: Vec<Vec<f64>> = Vec::with_capacity(degree);
    for _ in 0..degree {
        let next = match powers.last() {
            Some(last) => last.iter().zip(u).map(|(p, u)| p * u).collect(),
            None => u.to_vec(),
        };
        powers.push(next);
    }
    powers
}

/// ln(1 + t / 1 s) of sample `k`; without a sample rate, over the record's length.
fn creep_at(record: &StaticRecord, k: usize) -> f64 {
    match record.sample_rate_hz {
        Some(rate) => (k as f64 / rate).ln_1p(),
        None => k as f64 / record.output.len() as f64,
    }
}

/// First-order lag 1/(T s + 1) in place, at rest at `before`; `samples` = T in sample periods. The recursions
/// of the schemes for this one pole; `band-limited` has none and is replaced by the exact response to
/// straight lines between samples, which it equals for a drive that is slow against the sample rate.
pub(super) fn lag(x: &mut [f64], before: f64, samples: f64, scheme: Scheme) {
    if samples <= 0.0 {
        return;
    }
    let (mut previous, mut state) = (before, before);
    match scheme {
        Scheme::Tustin => {
            let gain = 1.0 / (2.0 * samples + 1.0);
            let decay = (2.0 * samples - 1.0) * gain;
            for x in x.iter_mut() {
                state = decay * state + gain * (*x + previous);
                previous = *x;
                *x = state;
            }
        }
        Scheme::GrunwaldLetnikov => {
            let gain = 1.0 / (samples + 1.0);
            for x in x.iter_mut() {
                state += gain * (*x - state);
                *x = state;
            }
        }
        Scheme::Bdf2 => {
            let gain = 1.0 / (1.5 * samples + 1.0);
            let mut earlier = before;
            for x in x.iter_mut() {
                let next = gain * (samples * (2.0 * state - 0.5 * earlier) + *x);
                earlier = state;
                state = next;
                *x = state;
            }
        }
        Scheme::BandLimited => {
            let decay = (-1.0 / samples).exp();
            let slope = 1.0 - (1.0 - decay) * samples;
            for x in x.iter_mut() {
                state = decay * state + (1.0 - decay) * previous + slope * (*x - previous);
                previous = *x;
                *x = state;
            }
        }
    }
}

impl Problem for StaticProblem {
    type Workspace = StaticWorkspace;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> StaticWorkspace {
        let longest = self.records.iter().map(|r| r.input.len()).max().unwrap_or(0);
        StaticWorkspace {
            zeta: vec![0.0; longest],
            column: vec![0.0; self.target.len()],
            target: vec![0.0; self.target.len()],
            projection: Projection::new(self.target.len(), self.layout.polynomial.len() + 1),
        }
    }

    fn cost(&self, x: &[f64], ws: &mut StaticWorkspace) -> f64 {
        if self.eliminate(x, ws) { root_mean_square(&ws.target) } else { f64::INFINITY }
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

impl LeastSquaresProblem for StaticProblem {
    fn residual_count(&self) -> usize {
        self.target.len()
    }

    fn residuals(&self, x: &[f64], ws: &mut StaticWorkspace, out: &mut [f64]) -> bool {
        let done = self.eliminate(x, ws);
        out.copy_from_slice(&ws.target);
        done
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::dynamics::{SimulationPlan, Term, TransferFunction};

    #[test]
    fn the_lag_of_a_fit_is_the_lag_of_the_model_under_every_scheme() {
        let term = |coefficient, order| Term { coefficient, order };
        let g = TransferFunction::new(vec![term(1.0, 0.0)], vec![term(1.0, 0.0), term(0.0143, 1.0)]).unwrap();
        for scheme in Scheme::ALL {
            // A start with a jump, except for the scheme that requires smooth drives.
            let smooth = scheme == Scheme::BandLimited;
            let wave = |t: f64| if smooth { 1.0 - t.cos() } else { 1.0 + t.sin() };
            let x: Vec<f64> = (0..400).map(|k| wave(0.031 * f64::from(k))).collect();
            let mut ours = x.clone();
            lag(&mut ours, 0.0, 0.0143 * 200.0, scheme);
            let plan = SimulationPlan::new(x.len(), 200.0, scheme, Start::ZERO).unwrap();
            let mut reference = vec![0.0; x.len()];
            plan.simulate(&g, &x, &mut plan.workspace(), &mut reference).unwrap();
            let tolerance = if smooth { 1e-3 } else { 1e-9 };
            for (k, (a, b)) in ours.iter().zip(&reference).enumerate() {
                assert!((a - b).abs() < tolerance, "{scheme:?} at {k}: {a} {b}");
            }
        }
    }
}
