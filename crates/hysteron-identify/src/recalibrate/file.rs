//! Model files in a recalibration: prior and result.

use std::collections::BTreeMap;

use super::{Change, Prior, RecalibratedRecord, Recalibration};
use hysteron_model::hysteresis::Hysteresis;
use hysteron_model::model_file::{
    Maker, ModelFile, Provenance, Quantity, RecordEntry, RecordRole, ScoreEntry, ScoreRole, polynomial_name,
};
use hysteron_model::record::Source;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Least eigenvalue of a correlation: directions below are exactly known, such as equal parameters of the
/// model.
const LEAST: f64 = 1e-12;

impl Prior {
    /// Prior from a model file. Where it holds the covariance C of its numbers p: the covariance of (gain,
    /// delay) with all other parameters held, (Dᵀ C⁺ D)⁻¹ with D = ∂p/∂(gain, delay), as if the old records
    /// were refitted together with the new ones. Else by standard errors alone: that of `linear`, relative,
    /// for the gain, and that of the delay.
    pub fn of(file: &ModelFile) -> Self {
        let known = |s: &f64| s.is_finite() && *s > 0.0;
        let range_v = file.valid_range.as_ref().map(|range| (range.input.low, range.input.high));
        if let Some(held) = Directions::of(file) {
            let std_error = |at: Option<usize>| at.map(|i| held.prior[(i, i)].sqrt()).filter(known);
            let (gain, delay_s) = (std_error(held.gain), std_error(held.delay));
            let correlation = match (held.gain, held.delay, gain, delay_s) {
                (Some(i), Some(j), Some(a), Some(b)) => (held.prior[(i, j)] / (a * b)).clamp(-1.0, 1.0),
                _ => 0.0,
            };
            return Self { gain, delay_s, correlation, range_v };
        }
        let linear = file.hysteresis.parameters.get("linear");
        let gain = linear.and_then(|q| Some((q.std_error? / q.value).abs()));
        let delay_s = file.delay.std_error.filter(known);
        Self { gain: gain.filter(known), delay_s, correlation: 0.0, range_v }
    }
}

/// Derivatives of the numbers of a model file with respect to gain and delay.
struct Directions {
    names: Vec<String>,
    /// D, a column each.
    moves: DMatrix<f64>,
    /// (Dᵀ C⁺ D)⁻¹ = A.
    prior: DMatrix<f64>,
    /// Square root of the covariance orthogonal to gain and delay: (1 − D A Dᵀ C⁺) L with L Lᵀ = C.
    rest: DMatrix<f64>,
    /// Columns of D.
    gain: Option<usize>,
    delay: Option<usize>,
}

impl Directions {
    /// `None` where the file holds no covariance, or none of the recalibrated parameters.
    fn of(file: &ModelFile) -> Option<Self> {
        let (names, covariance) = file.covariance()?;
        let count = names.len();
        let hysteresis = file.to_model().ok()?.hysteresis;
        let value = |name: &str| file.number(name).map_or(0.0, |q| q.value);
        let gain = |name: &String| value(name) * power_of_gain(name, &hysteresis);
        let gain: Vec<f64> = names.iter().map(gain).collect();
        let delay: Vec<f64> = names.iter().map(|name| f64::from(u8::from(name == "delay"))).collect();
        let columns: Vec<&Vec<f64>> =
            [&gain, &delay].into_iter().filter(|c| c.iter().any(|x| *x != 0.0)).collect();
        let moves = DMatrix::from_fn(count, columns.len(), |i, j| columns[j][i]);
        let (has_gain, has_delay) = (gain.iter().any(|x| *x != 0.0), delay.contains(&1.0));
        // In units of the standard errors: micrometres and seconds differ by many decades.
        let errors = covariance.diagonal().map(f64::sqrt);
        let eigen = covariance.map_with_location(|i, j, c| c / (errors[i] * errors[j])).symmetric_eigen();
        let scaled = DMatrix::from_fn(count, columns.len(), |i, j| moves[(i, j)] / errors[i]);
        let mut seen = eigen.eigenvectors.transpose() * scaled;
        for (mut row, &value) in seen.row_iter_mut().zip(&eigen.eigenvalues) {
            row /= value.max(LEAST).sqrt();
        }
        let information = seen.transpose() * &seen;
        let units: Vec<f64> = information.diagonal().iter().map(|v| v.sqrt()).collect();
        let unit = information.map_with_location(|i, j, v| v / (units[i] * units[j])).try_inverse()?;
        let prior = unit.map_with_location(|i, j, v| v / (units[i] * units[j]));
        let sound = !columns.is_empty() && prior.iter().all(|v| v.is_finite());
        let root = DMatrix::from_fn(count, count, |i, k| {
            errors[i] * eigen.eigenvectors[(i, k)] * eigen.eigenvalues[k].max(0.0).sqrt()
        });
        let rest = root - &moves * &prior * seen.transpose();
        let delay = has_delay.then_some(usize::from(has_gain));
        sound.then_some(Self { names, moves, prior, rest, gain: has_gain.then_some(0), delay })
    }
}

/// Exponent of the gain by which a number of the file scales: the power of the output in its unit for those
/// of the hysteresis, 0 for those of the dynamics, the delay and the offset.
pub(super) fn power_of_gain(name: &str, hysteresis: &Hysteresis) -> f64 {
    let mut polynomial = (1..=hysteresis.polynomial().len()).map(polynomial_name);
    if polynomial.any(|own| own == name) {
        return 1.0;
    }
    let number = hysteresis.form().model_numbers().into_iter().find(|number| number.name == name);
    number.map_or(0.0, |number| number.unit.power_of_output(hysteresis.exponent()))
}

impl Recalibration {
    /// The old model's file with the new parameters and their covariance. With C and D of [`Prior::of`], the
    /// old covariance of gain and delay, D A Dᵀ with A = (Dᵀ C⁺ D)⁻¹, is replaced by the new one; the
    /// independent remainder of C is kept: the new records are assumed uninformative about it. Where the file
    /// holds no covariance: the old standard error, scaled, and that of the gain, as if independent of each
    /// other.
    pub fn file(&self, old: &ModelFile) -> ModelFile {
        let mut file = old.clone();
        let new = &self.model.hysteresis;
        let of_gain = self.gain.std_error.unwrap_or(0.0) / self.gain.value;
        let set = |quantity: Option<&mut Quantity>, value: f64, power: f64| {
            let Some(quantity) = quantity else { return };
            let scale = self.gain.value.powf(power);
            quantity.value = value;
            quantity.std_error = quantity.std_error.map(|s| (scale * s).hypot(power * value * of_gain));
        };
        let parameters = &mut file.hysteresis.parameters;
        for (index, &value) in new.polynomial().iter().enumerate() {
            set(parameters.get_mut(&polynomial_name(index + 1)), value, 1.0);
        }
        for (name, value) in new.numbers() {
            set(parameters.get_mut(&name), value, power_of_gain(&name, new));
        }
        (file.delay.value, file.delay.std_error) = (self.model.delay_s, self.delay.std_error);
        (file.offset.value, file.offset.std_error) = (self.model.offset, None);
        // The misfit is that of the old records, at the new gain.
        file.misfit = old.misfit_model().map(|misfit| (&misfit.scaled(self.gain.value)).into());
        file.correlation = None;
        if let Some(directions) = Directions::of(old) {
            let (names, covariance) = self.renewed(&directions);
            file.set_covariance(&names, &covariance);
        }
        file
    }

    /// [`Self::file`] with provenance from the model in `source`, and the scores of the records.
    pub fn model_file(&self, old: &ModelFile, source: &Source, prior: Prior, maker: &Maker) -> ModelFile {
        let mut file = self.file(old);
        let known = |s: Option<f64>| s.map_or("unknown".to_owned(), |s| s.to_string());
        let options = BTreeMap::from([
            ("method".to_owned(), "recalibrate".to_owned()),
            ("recalibrated model".to_owned(), source.path.clone()),
            ("recalibrated model sha256".to_owned(), source.sha256.clone()),
            ("gain".to_owned(), self.gain.value.to_string()),
            ("prior gain std_error".to_owned(), known(prior.gain)),
            ("prior delay std_error".to_owned(), known(prior.delay_s)),
            ("prior correlation".to_owned(), prior.correlation.to_string()),
        ]);
        let records = self.records.iter().map(|r| RecordEntry::of(&r.data, RecordRole::Both)).collect();
        file.provenance = Some(Provenance::new(maker, records, options, None));
        let score = |r: &RecalibratedRecord| {
            ScoreEntry::new(&r.data.name, ScoreRole::Training, r.data.y_unit.symbol(), &r.after)
        };
        file.scores = self.records.iter().map(score).collect();
        file
    }

    /// The result for programs.
    pub fn summary(&self, file: &ModelFile) -> RecalibrationSummary {
        let record = |r| RecordSummary::new(r, file);
        RecalibrationSummary {
            gain: ChangeSummary { change: self.gain, changed: self.gain.is_significant() },
            delay_s: ChangeSummary { change: self.delay, changed: self.delay.is_significant() },
            offset: file.offset.value,
            offset_unit: file.offset.unit.clone(),
            changed: self.gain.is_significant() || self.delay.is_significant(),
            records: self.records.iter().map(record).collect(),
        }
    }

    /// S (C − D A Dᵀ) S + D' P D'ᵀ, from roots so that it is positive, with S = ∂p'/∂p and D' = ∂p'/∂(gain,
    /// delay) at the new values p', P the covariance of these.
    fn renewed(&self, d: &Directions) -> (Vec<String>, DMatrix<f64>) {
        let gain = self.gain.value;
        let scale = |name: &String| gain.powf(power_of_gain(name, &self.model.hysteresis));
        let scales: Vec<f64> = d.names.iter().map(scale).collect();
        let rest = d.rest.map_with_location(|i, _, c| scales[i] * c);
        let moves = DMatrix::from_fn(d.moves.nrows(), d.moves.ncols(), |i, j| {
            let by = if Some(j) == d.gain { scales[i] / gain } else { 1.0 };
            d.moves[(i, j)] * by
        });
        let error = |change: &Change| change.std_error.unwrap_or(0.0);
        let mut known = DMatrix::zeros(d.prior.nrows(), d.prior.ncols());
        for (place, change) in [(d.gain, &self.gain), (d.delay, &self.delay)] {
            if let Some(i) = place {
                known[(i, i)] = error(change).powi(2);
            }
        }
        if let (Some(i), Some(j)) = (d.gain, d.delay) {
            known[(i, j)] = self.correlation * error(&self.gain) * error(&self.delay);
            known[(j, i)] = known[(i, j)];
        }
        let sum = &rest * rest.transpose() + &moves * known * moves.transpose();
        // A delay that the records do not determine is held, without a variance.
        let kept: Vec<usize> = (0..d.names.len())
            .filter(|&i| d.names[i] != "delay" || self.delay.std_error.is_some())
            .filter(|&i| d.names[i] != "offset")
            .collect();
        (kept.iter().map(|&i| d.names[i].clone()).collect(), sum.select_rows(&kept).select_columns(&kept))
    }
}

/// Changes by a recalibration, in machine-readable form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecalibrationSummary {
    gain: ChangeSummary,
    delay_s: ChangeSummary,
    offset: f64,
    offset_unit: String,
    changed: bool,
    records: Vec<RecordSummary>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct ChangeSummary {
    #[serde(flatten)]
    change: Change,
    changed: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct RecordSummary {
    record: String,
    samples: usize,
    unit: String,
    rmse_before: f64,
    rmse_after: f64,
    fit_percent: Option<f64>,
    start: String,
}

impl RecordSummary {
    fn new(r: &RecalibratedRecord, file: &ModelFile) -> Self {
        Self {
            record: r.data.label().to_owned(),
            samples: r.after.samples,
            unit: r.data.y_unit.symbol().to_owned(),
            rmse_before: r.before.rmse,
            rmse_after: r.after.rmse,
            fit_percent: r.after.fit_percent,
            start: r.start.in_words(&file.units.input, &file.units.output),
        }
    }
}
