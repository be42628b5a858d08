//! Least-squares fit of an ARX model.

use nalgebra::DMatrix;

use super::Arx;
use crate::dynamics::DynamicsError;
use crate::dynamics_error::{check_finite, check_length};
use hysteron_numeric::least_squares;

/// A diagonal element of R below this fraction of its (unit) column makes the column dependent.
const DEPENDENT: f64 = 1e-12;

/// Orders of an ARX model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ArxOrders {
    /// Number of output coefficients.
    pub na: usize,
    /// Number of input coefficients.
    pub nb: usize,
    /// Delay: b starts at v_{k − nk}.
    pub nk: usize,
}

impl ArxOrders {
    /// Samples of a record that only serve as the past of later ones.
    pub fn past(self) -> usize {
        self.na.max((self.nb + self.nk).saturating_sub(1))
    }
}

/// One record of a fit; all at the same sample rate.
#[derive(Clone, Copy, Debug)]
pub struct ArxRecord<'a> {
    /// Input of the model (hysteresis output).
    pub input: &'a [f64],
    /// Measured output.
    pub output: &'a [f64],
    /// Samples to use; `None`: all.
    pub valid: Option<&'a [bool]>,
}

/// Result of [`fit`].
#[derive(Clone, Debug, PartialEq)]
pub struct ArxFit {
    /// The model.
    pub model: Arx,
    /// Output offset of each record: measured = simulated + offset.
    pub offsets: Vec<f64>,
    /// Standard errors of a₁ …, from the residual variance.
    pub a_std_error: Vec<f64>,
    /// Standard errors of b, zero at the leading zeros of the delay.
    pub b_std_error: Vec<f64>,
    /// Root mean square of the one-step prediction error.
    pub prediction_rmse: f64,
    /// Equations used.
    pub equations: usize,
}

/// Fits an ARX model of given orders to records by linear least squares (QR) of the equation error
///
/// y_k + Σ a_i y_{k−i} = Σ b_j v_{k−nk−j} + c_record,
///
/// one constant per record for its sensor offset. The first [`ArxOrders::past`] samples serve as past only,
/// so nothing is assumed about the time before a record; an equation with any sample not `valid` is left out.
/// The estimate is biased where the output is noisy (Ljung 1999, §7.3): judge it by simulation.
///
/// # Errors
/// [`DynamicsError::NoInputCoefficients`] for nb = 0, [`DynamicsError::Length`],
/// [`DynamicsError::InputNotFinite`], [`DynamicsError::TooFewSamples`] for no more equations than unknowns,
/// [`DynamicsError::Dependent`] where the data do not determine a coefficient.
pub fn fit(records: &[ArxRecord<'_>], orders: ArxOrders) -> Result<ArxFit, DynamicsError> {
    fit_after(records, orders, orders.past())
}

/// [`fit`] with the first `skip` ≥ past samples of each record left out, so that fits of several orders use
/// the same equations.
pub(super) fn fit_after(
    records: &[ArxRecord<'_>],
    orders: ArxOrders,
    skip: usize,
) -> Result<ArxFit, DynamicsError> {
    let ArxOrders { na, nb, nk } = orders;
    if nb == 0 {
        return Err(DynamicsError::NoInputCoefficients);
    }
    let mut equations = Vec::new();
    for (index, record) in records.iter().enumerate() {
        check_length("output", record.output.len(), record.input.len())?;
        check_finite("input", record.input)?;
        check_finite("output", record.output)?;
        if let Some(valid) = record.valid {
            check_length("valid mask", valid.len(), record.input.len())?;
        }
        let usable =
            |k: &usize| record.valid.is_none_or(|valid| valid[k - orders.past()..=*k].iter().all(|v| *v));
        equations.extend((skip..record.input.len()).filter(usable).map(|k| (index, k)));
    }
    let unknowns = na + nb + records.len();
    if equations.len() <= unknowns {
        return Err(DynamicsError::TooFewSamples { need: unknowns + 1, found: equations.len() });
    }
    let entry = |row: usize, column: usize| {
        let (index, k) = equations[row];
        let record = &records[index];
        if column < na {
            -record.output[k - 1 - column]
        } else if column < na + nb {
            record.input[k - nk - (column - na)]
        } else if column - na - nb == index {
            1.0
        } else {
            0.0
        }
    };
    let matrix = DMatrix::from_fn(equations.len(), unknowns, entry);
    let right = DMatrix::from_fn(equations.len(), 1, |row, _| {
        let (index, k) = equations[row];
        records[index].output[k]
    });
    let dependent = |column| DynamicsError::Dependent { column, columns: unknowns };
    let found = least_squares(matrix, right, DEPENDENT).map_err(dependent)?;
    let theta = found.solution.as_slice();
    let residual_squared = found.left.first().copied().unwrap_or(0.0);
    let sigma = (residual_squared / (equations.len() - unknowns) as f64).sqrt();
    let deviations = found.deviations().ok_or_else(|| dependent(unknowns - 1))?;
    let std_error: Vec<f64> = deviations.iter().map(|deviation| sigma * deviation).collect();
    let a: Vec<f64> = theta[..na].to_vec();
    let delayed = |values: &[f64]| [vec![0.0; nk], values.to_vec()].concat();
    let level = 1.0 + a.iter().sum::<f64>();
    Ok(ArxFit {
        model: Arx { b: delayed(&theta[na..na + nb]), a },
        offsets: theta[na + nb..].iter().map(|c| c / level).collect(),
        a_std_error: std_error[..na].to_vec(),
        b_std_error: delayed(&std_error[na..na + nb]),
        prediction_rmse: (residual_squared / equations.len() as f64).sqrt(),
        equations: equations.len(),
    })
}
