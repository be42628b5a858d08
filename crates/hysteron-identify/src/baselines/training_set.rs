//! Training records with a held-out part for structure selection.

use super::BaselineError;
use super::regressors::{Lags, Regressors, Series};
use super::signals::Units;
use hysteron_model::record::InputOutput;

/// A record is divided into this many parts of equal length …
const PARTS: usize = 8;
/// … of which these are held out: a quarter of the record, from two places.
const HELD_BACK: [usize; 2] = [2, 5];

/// Training records at one lag interval: every sample that is a whole number of intervals after the first.
#[derive(Clone, Debug)]
pub(super) struct TrainingSet {
    pub units: Units,
    /// One of each record, all valid samples valid.
    pub series: Vec<Series>,
    /// `series` with the held-out samples not valid.
    pub fitted: Vec<Series>,
    /// Valid samples that are held out.
    pub held_back: Vec<Vec<bool>>,
}

impl TrainingSet {
    pub fn new(records: &[InputOutput], interval_s: f64) -> Result<Self, BaselineError> {
        let units = Units::of(records, interval_s)?;
        let first = |record: &InputOutput| Ok(units.phases(record)?.swap_remove(0));
        let series = records.iter().map(first).collect::<Result<Vec<Series>, BaselineError>>()?;
        let is_held = |k: usize, of: usize| HELD_BACK.contains(&(k * PARTS / of.max(1)));
        let masked = |one: &Series, held: bool| -> Vec<bool> {
            let of = one.y.len();
            one.valid.iter().enumerate().map(|(k, v)| *v && is_held(k, of) == held).collect()
        };
        let fitted = series.iter().map(|one| Series { valid: masked(one, false), ..one.clone() }).collect();
        let held_back = series.iter().map(|one| masked(one, true)).collect();
        Ok(Self { units, series, fitted, held_back })
    }
}

/// Regressors and targets of the usable rows of some series.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    /// Row by row.
    pub x: Vec<f64>,
    /// Regressors of a row.
    pub width: usize,
    pub target: Vec<f64>,
}

impl Rows {
    /// All usable rows, or about `most` of them, evenly spaced.
    ///
    /// # Errors
    /// [`BaselineError::TooFewRows`] with no more rows than regressors.
    pub fn new(regressors: &Regressors, series: &[Series], most: usize) -> Result<Self, BaselineError> {
        let usable = |lags: Lags| series.iter().flat_map(move |one| one.rows(lags).map(move |k| (one, k)));
        let found = usable(regressors.lags).count();
        let width = regressors.lags.count();
        if found <= width {
            return Err(BaselineError::TooFewRows { found, need: width + 1 });
        }
        let every = found.div_ceil(most.max(1));
        let mut rows = Self { x: Vec::new(), width, target: Vec::new() };
        for (one, k) in usable(regressors.lags).step_by(every) {
            let from = rows.x.len();
            rows.x.resize(from + width, 0.0);
            regressors.fill(one, &one.y, k, &mut rows.x[from..]);
            rows.target.push(one.y[k]);
        }
        Ok(rows)
    }

    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.x.chunks_exact(self.width)
    }

    pub fn len(&self) -> usize {
        self.target.len()
    }
}
