//! Output-error problem with gains and offsets eliminated.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use hysteron_model::axes::{AxesRecord, CoupledHammerstein, Path, branch, start};
use hysteron_model::hysteresis::ArticleOperator;
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, Range, root_mean_square};

/// Numbers of an actuator: α, β', γ'/β'.
pub(super) const OF_ACTUATOR: usize = 3;
/// Numbers of a path: natural frequency, damping, delay.
pub(super) const OF_PATH: usize = 3;

/// A record and the end of its settled period.
#[derive(Clone, Debug)]
pub(super) struct SettledRecord<'a> {
    pub record: &'a AxesRecord,
    pub settled: Option<usize>,
}

/// The search: shapes of the actuators and of the paths; with `gains_free` also their gains, for standard
/// errors of all.
#[derive(Debug)]
pub(super) struct CoupledProblem<'a> {
    pub pieces: &'a [SettledRecord<'a>],
    pub inputs: usize,
    pub outputs: usize,
    pub gains_free: bool,
    bounds: Bounds,
    residuals: usize,
}

/// Model parameters at a point of the search.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub actuators: Vec<ArticleOperator>,
    /// With gain 1 where gains are eliminated.
    pub paths: Vec<Path>,
}

impl<'a> CoupledProblem<'a> {
    pub(super) fn new(pieces: &'a [SettledRecord<'a>], gains_free: Option<&[f64]>) -> Option<Self> {
        let first = pieces.first()?.record;
        let (inputs, outputs, rate) = (first.u.len(), first.y.len(), first.sample_rate_hz);
        let longest = pieces.iter().map(|p| p.record.len()).max()? as f64;
        let mut ranges = Vec::new();
        for n in 0..inputs {
            let values = || pieces.iter().filter_map(|p| p.record.u.get(n)).flatten();
            let high = values().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
            let low = values().fold(f64::INFINITY, |a, b| a.min(*b));
            let span = (high - low).max(f64::MIN_POSITIVE);
            ranges.push(Range::linear(&format!("alpha of input {}", n + 1), -0.9, 0.95));
            ranges.push(Range::logarithmic(&format!("beta of input {}", n + 1), 0.02 / span, 200.0 / span));
            ranges.push(Range::linear(&format!("gamma over beta of input {}", n + 1), -0.99, 0.99));
        }
        for path in 0..inputs * outputs {
            let name = |what: &str| {
                format!("{what} from input {} to output {}", path % inputs + 1, path / inputs + 1)
            };
            ranges.push(Range::logarithmic(
                &name("natural frequency"),
                (2.0 * rate / longest).min(0.01 * rate),
                0.49 * rate,
            ));
            ranges.push(Range::logarithmic(&name("damping"), 1e-3, 20.0));
            ranges.push(Range::linear(&name("delay"), 0.0, 20.0 / rate));
        }
        for gain in gains_free.unwrap_or(&[]) {
            let size = 10.0 * gain.abs() + f64::MIN_POSITIVE;
            ranges.push(Range::linear("gain", -size, size));
        }
        let residuals = pieces.iter().map(|p| p.record.len() * outputs).sum();
        Some(Self {
            pieces,
            inputs,
            outputs,
            gains_free: gains_free.is_some(),
            bounds: Bounds { ranges },
            residuals,
        })
    }

    /// The point at `x`.
    pub(super) fn point(&self, x: &[f64]) -> Point {
        let (actuators, rest) = x.split_at(OF_ACTUATOR * self.inputs);
        let (paths, gains) = rest.split_at(OF_PATH * self.inputs * self.outputs);
        let actuator = |a: &[f64]| ArticleOperator {
            polynomial: vec![1.0],
            alpha: a[0],
            beta: a[1],
            gamma: a[1] * a[2] * a[0].signum(),
            n: 1.0,
        };
        let path = |(k, p): (usize, &[f64])| Path {
            gain: if self.gains_free { gains.get(k).copied().unwrap_or(1.0) } else { 1.0 },
            natural_frequency_hz: p[0],
            damping: p[1],
            delay_s: p[2],
        };
        Point {
            actuators: actuators.chunks_exact(OF_ACTUATOR).map(actuator).collect(),
            paths: paths.chunks_exact(OF_PATH).enumerate().map(path).collect(),
        }
    }

    /// Output of the path from input `n` to output `m` over all records, centred record by record.
    pub(super) fn column(&self, point: &Point, m: usize, n: usize) -> Option<Vec<f64>> {
        let model = branch(&point.actuators[n], &point.paths[m * self.inputs + n]).ok()?;
        let mut column = Vec::new();
        for piece in self.pieces {
            let u = &piece.record.u[n];
            let y = model.simulate(u, Some(piece.record.sample_rate_hz), &start(u, piece.settled)).ok()?;
            column.extend(centred(&y, piece.record));
        }
        Some(column)
    }

    /// Columns of all paths, output by output.
    pub(super) fn columns(&self, point: &Point) -> Option<Vec<Vec<f64>>> {
        let paths: Vec<usize> = (0..self.inputs * self.outputs).collect();
        paths.par_iter().map(|path| self.column(point, path / self.inputs, path % self.inputs)).collect()
    }

    /// Residuals of output `m` and the gains of its paths.
    pub(super) fn residuals_of(
        &self,
        m: usize,
        columns: &[&Vec<f64>],
        gains: Option<&[f64]>,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut e: Vec<f64> = self.pieces.iter().flat_map(|p| centred(&p.record.y[m], p.record)).collect();
        let weights = match gains {
            Some(gains) => gains.to_vec(),
            None => least_squares(columns, &e)?,
        };
        for (column, weight) in columns.iter().zip(&weights) {
            e.iter_mut().zip(column.iter()).for_each(|(e, c)| *e -= weight * c);
        }
        e.iter().all(|e| e.is_finite()).then_some((e, weights))
    }

    /// Residuals of every output in turn, and the gains.
    pub(super) fn solve(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let columns = self.columns(&self.point(x))?;
        // With free gains the columns include them already.
        let ones = vec![1.0; self.inputs];
        let given = self.gains_free.then_some(ones.as_slice());
        let (mut residuals, mut gains) = (Vec::with_capacity(self.residuals), Vec::new());
        for m in 0..self.outputs {
            let own: Vec<&Vec<f64>> = columns[m * self.inputs..(m + 1) * self.inputs].iter().collect();
            let (e, weights) = self.residuals_of(m, &own, given)?;
            residuals.extend(e);
            gains.extend(weights);
        }
        Some((residuals, gains))
    }

    /// The model at `x`, offsets those of the first record.
    pub(super) fn model(&self, x: &[f64]) -> Option<CoupledHammerstein> {
        let (_, gains) = self.solve(x)?;
        let Point { actuators, mut paths } = self.point(x);
        paths.iter_mut().zip(&gains).for_each(|(path, gain)| path.gain *= gain);
        let first = self.pieces.first()?;
        let mut model = CoupledHammerstein {
            actuators,
            paths,
            offsets: vec![0.0; self.outputs],
            sample_rate_hz: first.record.sample_rate_hz,
        };
        let y = model.simulate(&first.record.u, first.record.sample_rate_hz, first.settled).ok()?;
        for (m, y) in y.iter().enumerate() {
            let difference: Vec<f64> = first.record.y[m].iter().zip(y).map(|(a, b)| a - b).collect();
            model.offsets[m] = valid_mean(&difference, first.record);
        }
        Some(model)
    }
}

fn is_valid(record: &AxesRecord, k: usize) -> bool {
    record.valid.as_ref().is_none_or(|mask| mask.get(k) == Some(&true))
}

fn valid_mean(x: &[f64], record: &AxesRecord) -> f64 {
    let valid = x.iter().enumerate().filter(|(k, _)| is_valid(record, *k));
    let (sum, count) = valid.fold((0.0, 0.0), |(sum, count), (_, x)| (sum + x, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Subtracts the mean over the valid samples; 0 where a sample is not valid.
fn centred(x: &[f64], record: &AxesRecord) -> Vec<f64> {
    let mean = valid_mean(x, record);
    x.iter().enumerate().map(|(k, x)| if is_valid(record, k) { x - mean } else { 0.0 }).collect()
}

/// Least-squares coefficients, by normal equations of unit columns; `None` for linearly dependent columns.
fn least_squares(columns: &[&Vec<f64>], target: &[f64]) -> Option<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let lengths: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
    if lengths.iter().any(|l| !(l.is_finite() && *l > 0.0)) {
        return None;
    }
    let count = columns.len();
    let matrix =
        DMatrix::from_fn(count, count, |i, j| dot(columns[i], columns[j]) / (lengths[i] * lengths[j]));
    let right = DVector::from_fn(count, |i, _| dot(columns[i], target) / lengths[i]);
    let solution = matrix.cholesky()?.solve(&right);
    Some(solution.iter().zip(&lengths).map(|(x, length)| x / length).collect())
}

impl Problem for CoupledProblem<'_> {
    type Workspace = ();

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], (): &mut ()) -> f64 {
        self.solve(x).map_or(f64::INFINITY, |(residuals, _)| root_mean_square(&residuals))
    }
}

impl LeastSquaresProblem for CoupledProblem<'_> {
    fn residual_count(&self) -> usize {
        self.residuals
    }

    fn residuals(&self, x: &[f64], (): &mut (), out: &mut [f64]) -> bool {
        match self.solve(x) {
            Some((residuals, _)) if residuals.len() == out.len() => {
                out.copy_from_slice(&residuals);
                true
            }
            _ => false,
        }
    }
}
