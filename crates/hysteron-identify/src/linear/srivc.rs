//! Simplified refined instrumental variables for continuous-time models.

use nalgebra::{DMatrix, DVector};

use super::covariance::{independent_samples, sandwich};
use super::roots::left_of_the_axis;
use super::variable_filter::VariableFilter;
use super::{bridged, check, is_valid};
use hysteron_model::dynamics::arx::ArxRecord;
use hysteron_model::dynamics::{DynamicsError, Term, TransferFunction};
use hysteron_model::record::InterSample;

/// Iterations from one start.
const ITERATIONS: usize = 100;
/// Iterations for comparing the starts.
const FIRST: usize = 6;
/// Number of corner frequencies of the initial filter.
const CORNERS: usize = 7;
/// Relative change of the unknowns at convergence.
const SETTLED: f64 = 1e-10;

/// Orders of a continuous-time model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SrivcOrders {
    /// Zeros of B, less than `poles`.
    pub zeros: usize,
    /// Poles, at least 1.
    pub poles: usize,
    /// Delay of the input \[samples\].
    pub delay: usize,
}

/// Result of [`fit_srivc`].
#[derive(Clone, Debug, PartialEq)]
pub struct SrivcFit {
    /// Orders.
    pub orders: SrivcOrders,
    /// b of s⁰, s¹, ….
    pub numerator: Vec<f64>,
    /// a of s⁰, s¹, …; that of the highest power is 1.
    pub denominator: Vec<f64>,
    /// Output offset of each record: measured = simulated + offset + noise.
    pub offsets: Vec<f64>,
    /// Covariance of the numerator's coefficients and the denominator's without the last, in this order; the
    /// residual may be coloured. `None` where the data do not determine them.
    pub covariance: Option<DMatrix<f64>>,
    /// Root mean square of the simulation error.
    pub rmse: f64,
    /// Effective number of independent samples of the residuals: all where they are white.
    pub independent_samples: f64,
    /// Iterations.
    pub iterations: usize,
    /// The iterations converged.
    pub converged: bool,
}

impl SrivcFit {
    /// The model, without its delay.
    pub fn transfer_function(&self) -> TransferFunction {
        let terms = |c: &[f64]| c.iter().enumerate().map(|(k, &c)| Term::new(c, k as f64)).collect();
        TransferFunction { numerator: terms(&self.numerator), denominator: terms(&self.denominator) }
    }

    /// Standard errors in the order of the covariance.
    pub fn std_error(&self) -> Option<Vec<f64>> {
        self.covariance.as_ref().map(|c| c.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect())
    }
}

/// Fits y = B(s)/A(s) v + offset to records sampled at `sample_rate_hz`; v is held or interpolated linearly
/// between its samples, and 0 before them.
///
/// Each iteration filters v, y and the model's noise-free x = B/A v by 1/A of the previous iteration, whose
/// states are the filtered derivatives, and solves sⁿ/A y = −Σ a sʲ/A y + Σ b sʲ/A v with x replacing y in
/// the instruments: x is free of the noise of y, so that the estimate is unbiased for noise of any colour.
/// The inter-sample behaviour of y does not matter at convergence, since A/A y = y there (S. Pan, J. S.
/// Welsh, R. A. González, C. R. Rojas, *Automatica* 2020). Source: P. C. Young, H. Garnier, M. Gilson, in
/// *Identification of Continuous-time Models from Sampled Data*, Springer 2008, ch. 4. Starts: linear
/// regression on signals filtered by 1/(s + λ)ⁿ for λ over the band. Unstable poles are reflected.
///
/// # Errors
/// [`DynamicsError::Parameter`] for an invalid number of poles or zeros; [`DynamicsError::SampleRate`];
/// [`DynamicsError::Length`], [`DynamicsError::InputNotFinite`], [`DynamicsError::TooFewSamples`];
/// [`DynamicsError::Dependent`] where the data do not determine the coefficients.
pub fn fit_srivc(
    records: &[ArxRecord<'_>],
    orders: SrivcOrders,
    sample_rate_hz: f64,
    between: InterSample,
) -> Result<SrivcFit, DynamicsError> {
    let SrivcOrders { zeros, poles, delay } = orders;
    let refuse =
        |name, value: usize, allowed| Err(DynamicsError::Parameter { name, value: value as f64, allowed });
    if !(1..=MOST_POLES).contains(&poles) {
        return refuse("number of poles", poles, "1 to 10");
    }
    if zeros >= poles {
        return refuse("number of zeros", zeros, "less than the number of poles");
    }
    if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
        return Err(DynamicsError::SampleRate { sample_rate_hz });
    }
    check(records, poles + zeros + 1)?;
    let regression = Regression::new(records, (zeros, poles), delay, between);
    let longest = records.iter().map(|r| r.input.len()).max().unwrap_or(1) as f64;
    // Corners from a few periods in the longest record to a large part of the Nyquist frequency, per sample.
    let (low, high) = (30.0 / longest, 1.0f64);
    let mut starts: Vec<Iterate> = (0..CORNERS)
        .filter_map(|k| {
            let corner = low * (high / low).powf(k as f64 / (CORNERS - 1) as f64);
            regression.started_at(corner)
        })
        .collect();
    starts.sort_by(|a, b| a.square.total_cmp(&b.square));
    let columns = poles + zeros + 1 + records.len();
    let dependent = DynamicsError::Dependent { column: columns - 1, columns };
    let start = starts.into_iter().next().ok_or(dependent)?;
    let (found, iterations, converged) = regression.settle(start, ITERATIONS);
    Ok(regression.result(&found, orders, sample_rate_hz, (iterations, converged)))
}

/// Most poles.
const MOST_POLES: usize = 10;

/// The records, prepared for filtering. Time is in sample periods times `unit`, which makes the coefficients
/// of A of order 1.
struct Regression<'a> {
    records: &'a [ArxRecord<'a>],
    /// Delayed inputs, and gap-filled outputs relative to their first sample.
    inputs: Vec<Vec<f64>>,
    outputs: Vec<Vec<f64>>,
    zeros: usize,
    poles: usize,
    between: InterSample,
}

/// A model with its simulation error. A and B in units of `step` per sample period.
#[derive(Clone)]
struct Iterate {
    /// Sample period in the model's unit of time.
    step: f64,
    /// a₁ … a_n, b_m … b₀, offsets.
    x: Vec<f64>,
    /// Sum of squares of the simulation error.
    square: f64,
}

/// The signals of one iteration.
struct Filtered {
    /// Derivatives of y, v and x through 1/A of each record.
    y: Vec<Vec<Vec<f64>>>,
    v: Vec<Vec<Vec<f64>>>,
}

impl<'a> Regression<'a> {
    fn new(
        records: &'a [ArxRecord<'a>],
        (zeros, poles): (usize, usize),
        delay: usize,
        between: InterSample,
    ) -> Self {
        let delayed = |record: &ArxRecord<'_>| {
            let kept = record.input.len().saturating_sub(delay);
            [&vec![0.0; record.input.len() - kept], &record.input[..kept]].concat()
        };
        let from_start = |record: &ArxRecord<'_>| {
            let y = bridged(record);
            let level = y.first().copied().unwrap_or(0.0);
            y.into_iter().map(|y| y - level).collect()
        };
        Self {
            records,
            inputs: records.iter().map(delayed).collect(),
            outputs: records.iter().map(from_start).collect(),
            zeros,
            poles,
            between,
        }
    }

    /// Start by linear regression on signals filtered by 1/(s + 1)ⁿ in a time unit that puts the corner at
    /// `corner` per sample, and a few iterations from there.
    fn started_at(&self, corner: f64) -> Option<Iterate> {
        let n = self.poles;
        let mut a = vec![0.0; n + 1];
        a[0] = 1.0;
        for _ in 0..n {
            for k in (1..=n).rev() {
                a[k] += a[k - 1];
            }
        }
        let signals = self.filtered(&a[1..], corner);
        let (regressors, target) = self.regressors(&signals, None);
        let x = solve(&regressors, &regressors, &target)?;
        let start = self.judged(corner, x)?;
        Some(self.settle(start, FIRST).0)
    }

    /// Iterates to convergence; returns the last iterate if converged, else the one with the least simulation
    /// error.
    fn settle(&self, start: Iterate, most: usize) -> (Iterate, usize, bool) {
        let mut best = start.clone();
        let mut now = start;
        for iteration in 1..=most {
            let Some((next, moved)) = self.next(&now) else { return (best, iteration, false) };
            now = next;
            if now.square <= best.square {
                best = now.clone();
            }
            if moved < SETTLED {
                return (now, iteration, true);
            }
        }
        (best, most, false)
    }

    /// One refinement, and the largest relative change of a coefficient of the transfer function.
    fn next(&self, now: &Iterate) -> Option<(Iterate, f64)> {
        // The time unit is rescaled with the model, to poles near 1.
        let now = &self.in_own_time(now);
        let (n, m) = (self.poles, self.zeros);
        let signals = self.filtered(&now.x[..n], now.step);
        let (regressors, target) = self.regressors(&signals, None);
        let noise_free = self.simulated(&signals, &now.x[n..=n + m]);
        let filter = VariableFilter::new(&now.x[..n], now.step, InterSample::Linear);
        let x: Vec<Vec<Vec<f64>>> = noise_free.iter().map(|x| filter.apply(x)).collect();
        let (instruments, _) = self.regressors(&signals, Some(&x));
        let error = &target - &regressors * DVector::from_column_slice(&now.x);
        let correction = solve(&instruments, &regressors, &error)?;
        let x: Vec<f64> = now.x.iter().zip(&correction).map(|(x, d)| x + d).collect();
        let size = |range: std::ops::Range<usize>| now.x[range].iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let (of_a, of_b) = (size(0..n).max(1.0), size(n..n + m + 1));
        let moved =
            (0..=n + m).map(|i| correction[i].abs() / if i < n { of_a } else { of_b }).fold(0.0, f64::max);
        Some((self.judged(now.step, x)?, moved))
    }

    /// This model in the time unit that makes the product of its poles 1.
    fn in_own_time(&self, now: &Iterate) -> Iterate {
        let (n, m) = (self.poles, self.zeros);
        let rate = now.x[n - 1].abs().powf(1.0 / n as f64);
        if !(rate.is_finite() && rate > 0.0) {
            return now.clone();
        }
        // a_i has the unit rate^i, the coefficient of s^j in B rate^(n − j).
        let power = |i: usize| if i < n { i + 1 } else { n - (m - (i - n)) };
        let scaled = |(i, x): (usize, &f64)| if i <= n + m { x / rate.powi(power(i) as i32) } else { *x };
        let x = now.x.iter().enumerate().map(scaled).collect();
        Iterate { step: now.step * rate, x, square: now.square }
    }

    fn filtered(&self, a: &[f64], step: f64) -> Filtered {
        let of_y = VariableFilter::new(a, step, InterSample::Linear);
        let of_v = VariableFilter::new(a, step, self.between);
        Filtered {
            y: self.outputs.iter().map(|y| of_y.apply(y)).collect(),
            v: self.inputs.iter().map(|v| of_v.apply(v)).collect(),
        }
    }

    /// B/A v from the filtered v; `b` from the highest power.
    fn simulated(&self, signals: &Filtered, b: &[f64]) -> Vec<Vec<f64>> {
        let of = |v: &Vec<Vec<f64>>| {
            let at = |k: usize| b.iter().rev().zip(v).map(|(b, v)| b * v[k]).sum();
            (0..v[0].len()).map(at).collect()
        };
        signals.v.iter().map(of).collect()
    }

    /// Columns −sⁿ⁻¹/A y … −1/A y, sᵐ/A v … 1/A v, a one for each record, and sⁿ/A y, rows of samples that
    /// are not valid 0; with `other` replacing y.
    fn regressors(
        &self,
        signals: &Filtered,
        other: Option<&Vec<Vec<Vec<f64>>>>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let (n, m) = (self.poles, self.zeros);
        let rows = self.outputs.iter().map(Vec::len).sum();
        let mut matrix = DMatrix::zeros(rows, n + m + 1 + self.records.len());
        let mut target = DVector::zeros(rows);
        let mut first = 0;
        for (index, record) in self.records.iter().enumerate() {
            let (y, v) = (&other.unwrap_or(&signals.y)[index], &signals.v[index]);
            for k in (0..record.input.len()).filter(|&k| is_valid(record, k)) {
                for i in 0..n {
                    matrix[(first + k, i)] = -y[n - 1 - i][k];
                }
                for j in 0..=m {
                    matrix[(first + k, n + j)] = v[m - j][k];
                }
                matrix[(first + k, n + m + 1 + index)] = 1.0;
                target[first + k] = y[n][k];
            }
            first += record.input.len();
        }
        (matrix, target)
    }

    /// Simulation error y − B/A v − offset, rows of samples that are not valid 0.
    fn errors(&self, step: f64, x: &[f64]) -> Vec<f64> {
        let (n, m) = (self.poles, self.zeros);
        let filter = VariableFilter::new(&x[..n], step, self.between);
        let mut errors = Vec::new();
        for (index, record) in self.records.iter().enumerate() {
            let v = filter.apply(&self.inputs[index]);
            errors.extend((0..record.input.len()).map(|k| {
                let simulated: f64 = x[n..=n + m].iter().rev().zip(&v).map(|(b, v)| b * v[k]).sum();
                let error = self.outputs[index][k] - simulated - x[n + m + 1 + index];
                if is_valid(record, k) { error } else { 0.0 }
            }));
        }
        errors
    }

    /// The model with unstable poles reflected, and its simulation error; `None` where it is not finite.
    fn judged(&self, step: f64, mut x: Vec<f64>) -> Option<Iterate> {
        if x.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let stable = left_of_the_axis(&x[..self.poles]);
        x[..self.poles].copy_from_slice(&stable);
        let square: f64 = self.errors(step, &x).iter().map(|e| e * e).sum();
        square.is_finite().then_some(Iterate { step, x, square })
    }

    fn result(
        &self,
        found: &Iterate,
        orders: SrivcOrders,
        sample_rate_hz: f64,
        (iterations, converged): (usize, bool),
    ) -> SrivcFit {
        let found = &self.in_own_time(found);
        let (n, m) = (self.poles, self.zeros);
        let errors = self.errors(found.step, &found.x);
        let segments: Vec<usize> = self.outputs.iter().map(Vec::len).collect();
        let signals = self.filtered(&found.x[..n], found.step);
        let (regressors, _) = self.regressors(&signals, None);
        let noise_free = self.simulated(&signals, &found.x[n..=n + m]);
        let filter = VariableFilter::new(&found.x[..n], found.step, InterSample::Linear);
        let filtered = noise_free.iter().map(|x| filter.apply(x)).collect();
        let (instruments, _) = self.regressors(&signals, Some(&filtered));
        let own = sandwich(&segments, &instruments, instruments.tr_mul(&regressors), &errors);
        // From the model's time unit to seconds: a coefficient of s^j is scaled by rate^(n − j).
        let rate = found.step * sample_rate_hz;
        let place =
            |i: usize| if i <= m { (n + m - i, n - i) } else { (n - 1 - (i - m - 1), n - (i - m - 1)) };
        let factor = |i: usize| rate.powi(place(i).1 as i32);
        let count = n + m + 1;
        let covariance = own.map(|own| {
            DMatrix::from_fn(count, count, |i, j| own[(place(i).0, place(j).0)] * factor(i) * factor(j))
        });
        let values: Vec<f64> = (0..count).map(|i| found.x[place(i).0] * factor(i)).collect();
        let mut denominator = values[m + 1..].to_vec();
        denominator.push(1.0);
        let level = |y: &[f64]| y.first().copied().unwrap_or(0.0);
        let offsets = (self.records.iter().zip(&found.x[count..]))
            .map(|(record, offset)| offset + level(&bridged(record)))
            .collect();
        let valid: usize =
            self.records.iter().map(|r| (0..r.input.len()).filter(|&k| is_valid(r, k)).count()).sum();
        SrivcFit {
            orders,
            numerator: values[..=m].to_vec(),
            denominator,
            offsets,
            covariance,
            rmse: (errors.iter().map(|e| e * e).sum::<f64>() / valid as f64).sqrt(),
            independent_samples: independent_samples(&segments, &errors),
            iterations,
            converged,
        }
    }
}

/// (Zᵀ Φ)⁻¹ Zᵀ y with columns scaled to unit length.
fn solve(instruments: &DMatrix<f64>, regressors: &DMatrix<f64>, target: &DVector<f64>) -> Option<Vec<f64>> {
    let norms =
        |m: &DMatrix<f64>| -> Vec<f64> { m.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect() };
    let (of_z, of_phi) = (norms(instruments), norms(regressors));
    let matrix = instruments.tr_mul(regressors).map_with_location(|i, j, x| x / (of_z[i] * of_phi[j]));
    let right = instruments.tr_mul(target).map_with_location(|i, _, x| x / of_z[i]);
    let solved = matrix.full_piv_lu().solve(&right)?;
    let x: Vec<f64> = solved.iter().zip(&of_phi).map(|(x, norm)| x / norm).collect();
    x.iter().all(|x| x.is_finite()).then_some(x)
}
