//! Starts of a prediction-error search: linear regressions.

use nalgebra::{DMatrix, DVector};

use super::filter::filter;
use super::polynomial::PolynomialOrders;
use super::roots::inside_the_circle;
use super::{bridged, is_valid};
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::dynamics::arx::ArxRecord;
use hysteron_numeric::least_squares;

/// B and F.
type Polynomials = (Vec<f64>, Vec<f64>);

/// Iterations: a model of the right order converges within a few, another may not converge.
const ITERATIONS: usize = 15;
/// A diagonal element of R below this share of its (unit) column makes the column dependent.
const DEPENDENT: f64 = 1e-12;

/// B and F by ARX on signals filtered by 1/F of the previous iteration, which on convergence approximates the
/// output error; of all iterations those with the least output error.
pub(super) fn steiglitz_mcbride(
    records: &[ArxRecord<'_>],
    orders: PolynomialOrders,
) -> Result<Polynomials, DynamicsError> {
    let outputs: Vec<Vec<f64>> = records.iter().map(bridged).collect();
    let mut f = Vec::new();
    let mut best: Option<(f64, Polynomials)> = None;
    for _ in 0..ITERATIONS {
        let (b, next) = match regression(records, &outputs, orders, &f) {
            Ok(found) => found,
            Err(error) if best.is_none() => return Err(error),
            Err(_) => break,
        };
        let next = inside_the_circle(&next);
        let error = output_error(records, orders.nk, &b, &next);
        let settled = f.len() == next.len() && f.iter().zip(&next).all(|(a, b)| f64::abs(a - b) < 1e-10);
        f.clone_from(&next);
        if best.as_ref().is_none_or(|(before, _)| error < *before) {
            best = Some((error, (b, next)));
        }
        if settled {
            break;
        }
    }
    let columns = orders.nb + orders.nf + records.len();
    best.map(|(_, start)| start).ok_or(DynamicsError::Dependent { column: 0, columns })
}

/// Least squares for F y = B v + offset, both sides filtered by 1/`filter_by`.
fn regression(
    records: &[ArxRecord<'_>],
    outputs: &[Vec<f64>],
    orders: PolynomialOrders,
    filter_by: &[f64],
) -> Result<Polynomials, DynamicsError> {
    let PolynomialOrders { nb, nf, nk, .. } = orders;
    let columns = nb + nf + records.len();
    let past = nf.max((nb + nk).saturating_sub(1));
    let mut rows = Vec::new();
    let mut signals = Vec::new();
    for (index, (record, output)) in records.iter().zip(outputs).enumerate() {
        let (mut v, mut y) = (vec![0.0; output.len()], vec![0.0; output.len()]);
        filter(&[1.0], 0, filter_by, record.input, &mut v);
        // Relative to the initial level, since the filter starts from zero.
        let level = output.first().copied().unwrap_or(0.0);
        let moved: Vec<f64> = output.iter().map(|y| y - level).collect();
        filter(&[1.0], 0, filter_by, &moved, &mut y);
        signals.push((v, y));
        rows.extend((past..output.len()).filter(|&k| is_valid(record, k)).map(|k| (index, k)));
    }
    if rows.len() <= columns {
        return Err(DynamicsError::TooFewSamples { need: columns + 1, found: rows.len() });
    }
    let matrix = DMatrix::from_fn(rows.len(), columns, |row, column| {
        let (index, k) = rows[row];
        let (v, y) = &signals[index];
        if column < nb {
            k.checked_sub(nk + column).map_or(0.0, |at| v[at])
        } else if column < nb + nf {
            -y[k - 1 - (column - nb)]
        } else {
            f64::from(u8::from(column - nb - nf == index))
        }
    });
    let right = DVector::from_fn(rows.len(), |row, _| signals[rows[row].0].1[rows[row].1]);
    let x = solved(matrix, right)?;
    Ok((x[..nb].to_vec(), x[nb..nb + nf].to_vec()))
}

/// Least squares with one right-hand side.
fn solved(matrix: DMatrix<f64>, right: DVector<f64>) -> Result<Vec<f64>, DynamicsError> {
    let columns = matrix.ncols();
    let right = DMatrix::from_column_slice(right.len(), 1, right.as_slice());
    match least_squares(matrix, right, DEPENDENT) {
        Ok(found) => Ok(found.solution.as_slice().to_vec()),
        Err(column) => Err(DynamicsError::Dependent { column, columns }),
    }
}

/// Sum of squares of y − B/F v, each record's mean removed.
fn output_error(records: &[ArxRecord<'_>], nk: usize, b: &[f64], f: &[f64]) -> f64 {
    records
        .iter()
        .map(|record| {
            let mut x = vec![0.0; record.input.len()];
            filter(b, nk, f, record.input, &mut x);
            let errors: Vec<f64> =
                (0..x.len()).filter(|&k| is_valid(record, k)).map(|k| record.output[k] - x[k]).collect();
            let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>()
        })
        .sum()
}

/// C and D of the output error: innovations e from a long autoregression, then regression of w on past w and
/// e. Zeros where the regression fails.
pub(super) fn noise_start(
    records: &[ArxRecord<'_>],
    residual: &DVector<f64>,
    orders: PolynomialOrders,
) -> (Vec<f64>, Vec<f64>) {
    let (nc, nd) = (orders.nc, orders.nd);
    let zeros = || (vec![0.0; nc], vec![0.0; nd]);
    let long = 10 + 2 * (nc + nd);
    let mut segments = Vec::new();
    let mut first = 0;
    for record in records {
        let samples = record.input.len();
        segments.push(residual.as_slice()[first..first + samples].to_vec());
        first += samples;
    }
    let rows = |past: usize| -> Vec<(usize, usize)> {
        let of = |(i, w): (usize, &Vec<f64>)| (past..w.len()).map(move |k| (i, k)).collect::<Vec<_>>();
        segments.iter().enumerate().flat_map(of).collect()
    };
    let autoregression = rows(long);
    if autoregression.len() <= 4 * long {
        return zeros();
    }
    let at = |(i, k): (usize, usize)| segments[i][k];
    let lagged = DMatrix::from_fn(autoregression.len(), long, |r, j| {
        let (i, k) = autoregression[r];
        -segments[i][k - 1 - j]
    });
    let right = DVector::from_fn(autoregression.len(), |r, _| at(autoregression[r]));
    let Ok(a) = solved(lagged, right) else { return zeros() };
    let innovations: Vec<Vec<f64>> = segments
        .iter()
        .map(|w| {
            (0..w.len()).map(|k| w[k] + (0..long.min(k)).map(|j| a[j] * w[k - 1 - j]).sum::<f64>()).collect()
        })
        .collect();
    let regression = rows(long + nc.max(nd));
    let matrix = DMatrix::from_fn(regression.len(), nc + nd, |r, j| {
        let (i, k) = regression[r];
        if j < nc { innovations[i][k - 1 - j] } else { -segments[i][k - 1 - (j - nc)] }
    });
    // w + Σ d w = e + Σ c e.
    let right = DVector::from_fn(regression.len(), |r, _| {
        let (i, k) = regression[r];
        segments[i][k] - innovations[i][k]
    });
    match solved(matrix, right) {
        Ok(x) => (inside_the_circle(&x[..nc]), inside_the_circle(&x[nc..])),
        Err(_) => zeros(),
    }
}
