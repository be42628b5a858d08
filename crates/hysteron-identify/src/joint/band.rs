//! Prediction bands: the uncertainty of the parameters propagated to the output.
//!
//! The standard deviation of the output is sd(t) = √(J(t) C J(t)ᵀ) with J its derivatives with respect to all
//! parameters and C their covariance; a measurement adds the scatter of the residual. Offset, drift and the
//! memory of a new record are not included: the band is that of the output about its mean, as it is scored.

use std::borrow::Cow;
use std::ops::Range;

use super::super::IdentifyError;
use super::super::layout::Role;
use super::super::normal::NORMAL_975;
use super::super::result::RecordFit;
use super::super::sines::{self, SineResponse};
use super::drive::{TimedDrive, cycles_before};
use super::knowledge::{Covariance, Knowledge};
use super::parameter_layout::JointLayout;
use super::problem::JointProblem;
use super::record::{Ingredients, JointRecord};
use hysteron_model::dynamics::{DynamicForm, Sampling, Scheme};
use hysteron_model::hysteresis::{HysteresisForm, RecordEnds};
use hysteron_model::misfit::MisfitPrediction;
use hysteron_model::model::{BandScore, Remark, Score};
use hysteron_model::record::{InputOutput, InterSample, Timing};
use hysteron_model::{Finding, Start};
use hysteron_numeric::normal::quantile;
use hysteron_optimize::{Bounds, Problem, Stop};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Probability of the usual band.
const LEVEL: f64 = 0.95;
/// Rows processed at a time.
const ROWS: usize = 1024;

/// Uncertainty of the output for a drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PredictionBand {
    /// Standard deviation of the model's output at each sample, from the uncertainty of the parameters
    /// \[output unit\].
    pub std_dev: Vec<f64>,
    /// Standard deviation of a measurement about the model: the rms residual of the training records \[output
    /// unit\].
    pub noise: f64,
    /// Predicted misfit of a device outside the model class, which then gives the band of a measurement; `None`
    /// in the class, and where `findings` say that it cannot be predicted.
    pub misfit: Option<MisfitPrediction>,
    /// What the band of a measurement rests on, where that is not the training records alone.
    pub findings: Vec<Finding>,
}

impl PredictionBand {
    /// The band of a part of the record.
    pub(crate) fn part(&self, samples: Range<usize>) -> Self {
        let misfit = self.misfit.as_ref().map(|misfit| misfit.part(samples.clone()));
        let std_dev = self.std_dev.get(samples).unwrap_or_default().to_vec();
        Self { std_dev, noise: self.noise, misfit, findings: self.findings.clone() }
    }

    /// The band of a model that is corrected by the predicted misfit
    /// ([`hysteron_model::Model::simulate_corrected`]).
    #[must_use]
    pub fn corrected(self) -> Self {
        Self { misfit: self.misfit.map(MisfitPrediction::possibly_remaining), ..self }
    }

    /// Half the width of the band that holds the model's true output with 95 % at each sample \[output
    /// unit\].
    pub fn of_output(&self) -> Vec<f64> {
        self.std_dev.iter().map(|sd| NORMAL_975 * sd).collect()
    }

    /// Half the width of the band that holds a measurement with 95 % at each sample \[output unit\].
    pub fn of_measurement(&self) -> Vec<f64> {
        match &self.misfit {
            Some(misfit) => misfit.half_width(LEVEL),
            None => self.std_dev.iter().map(|sd| NORMAL_975 * sd.hypot(self.noise)).collect(),
        }
    }

    /// Half the width of the band that holds a measurement with a probability of `level` at each sample
    /// \[output unit\], and of that which holds the model's true output.
    ///
    /// # Errors
    /// [`IdentifyError::Option`] for a level that is not between 0 and 1.
    pub fn at_level(&self, level: f64) -> Result<[Vec<f64>; 2], IdentifyError> {
        if !(level > 0.0 && level < 1.0) {
            return Err(IdentifyError::Option {
                option: "band",
                value: level,
                wanted: "a level between 0 and 1",
            });
        }
        let width = quantile(0.5 + 0.5 * level);
        let of = |noise: f64| self.std_dev.iter().map(|sd| width * sd.hypot(noise)).collect();
        let of_measurement = self.misfit.as_ref().map(|misfit| misfit.half_width(level));
        Ok([of_measurement.unwrap_or_else(|| of(self.noise)), of(0.0)])
    }

    /// Coverage of a scored record by the band of a measurement; the first `skip_s` are left out.
    pub fn holds(&self, record: &InputOutput, score: &Score, skip_s: f64) -> BandScore {
        let simulation = &score.simulation;
        let left_out = simulation.remarks.iter().map(|remark| match remark {
            Remark::LeftOut { samples } => *samples,
            _ => 0,
        });
        let scored = record.without_first(left_out.sum());
        let (simulated, offset) = (
            simulation.outputs.first().map_or(&[][..], Vec::as_slice),
            score.outputs.first().map_or(0.0, |s| s.offset),
        );
        let half = self.of_measurement();
        let skipped = match scored.sample_rate_hz() {
            Some(rate) => (skip_s * rate).ceil() as usize,
            None => {
                let since = |k: usize| Some(scored.time.time_s(k)? - scored.time.time_s(0)?);
                (0..scored.len()).take_while(|&k| since(k).is_some_and(|s| s < skip_s)).count()
            }
        };
        let valid = |k: &usize| scored.is_valid(*k);
        let all: Vec<usize> = (skipped..scored.len()).filter(valid).collect();
        let inside = all.iter().filter(|&&k| (scored.y[k] - simulated[k] - offset).abs() <= half[k]).count();
        BandScore {
            inside_percent: 100.0 * inside as f64 / all.len().max(1) as f64,
            model: self.of_output().into_iter().fold(0.0, f64::max),
            measurement: half.into_iter().fold(0.0, f64::max),
            findings: self.findings.clone(),
        }
    }
}

/// Uncertainty of the output for any drive, from a joint fit.
#[derive(Clone, Debug)]
pub struct OutputUncertainty {
    hysteresis: HysteresisForm,
    form: DynamicForm,
    /// Without the memory of the records, which comes last in `x`.
    layout: JointLayout,
    bounds: Bounds,
    x: Vec<f64>,
    /// Coefficients of u, u², … and weights.
    coefficients: Vec<f64>,
    /// Covariance of the eliminated coefficients and `x`, in the fit's own symbols.
    covariance: DMatrix<f64>,
    scheme: Scheme,
    inter_sample: InterSample,
    noise: f64,
}

impl OutputUncertainty {
    /// `noise`: standard deviation of the residuals.
    pub(super) fn new(
        problem: &JointProblem,
        form: &DynamicForm,
        x: &[f64],
        known: &Knowledge,
        (scheme, inter_sample): (Scheme, InterSample),
        noise: f64,
    ) -> Self {
        let mut layout = problem.layout().clone();
        let memories = layout.memory.iter().filter(|role| matches!(role, Role::Searched(_))).count();
        layout.memory.clear();
        let kept = x.len() - memories;
        let all = known.covariance.values.len() - memories;
        Self {
            hysteresis: problem.hysteresis(),
            form: *form,
            layout,
            bounds: Bounds { ranges: problem.bounds().ranges[..kept].to_vec() },
            x: x[..kept].to_vec(),
            coefficients: known.linearisation.coefficients.clone(),
            covariance: known.covariance.matrix.view((0, 0), (all, all)).into_owned(),
            scheme,
            inter_sample,
            noise,
        }
    }

    /// Band of the output for `drive` \[V\].
    ///
    /// # Errors
    /// [`IdentifyError::Simulation`] or [`IdentifyError::Dynamics`] where the drive cannot be simulated;
    /// [`IdentifyError::NotPeriodic`] for a settled start of a drive that is not a whole number of periods.
    pub fn band<'a>(
        &self,
        drive: &[f64],
        timing: impl Into<Timing<'a>>,
        start: &Start,
    ) -> Result<PredictionBand, IdentifyError> {
        let timing = timing.into();
        let weights = self.coefficients.get(self.layout.polynomial.len()..).unwrap_or_default();
        let (before, memory) = match *start {
            Start::AsIdentified => (Start::AsIdentified, 0.0),
            Start::Rest { voltage_v } => (Start::Rest { voltage_v }, 0.0),
            Start::Remembering { voltage_v, memory } => (
                Start::Remembering { voltage_v, memory: () },
                self.hysteresis.memory_of_columns(memory.value(), weights),
            ),
            Start::Settled { .. } if matches!(timing, Timing::Stamps(_)) => {
                (Start::Rest { voltage_v: drive[0] }, 0.0)
            }
            Start::Settled { period_samples, .. } => {
                let period_samples = period_samples.unwrap_or(drive.len());
                if period_samples == 0 || !drive.len().is_multiple_of(period_samples) {
                    return Err(IdentifyError::NotPeriodic {
                        record: "drive".into(),
                        found: format!(
                            "{} samples are not a whole number of periods of {period_samples} samples",
                            drive.len()
                        ),
                    });
                }
                (Start::PERIODIC, 0.0)
            }
        };
        let ends = if before == Start::PERIODIC { RecordEnds::Periodic } else { RecordEnds::Open };
        let depends_on = self.hysteresis.depends_on();
        let scheme = (self.scheme, !self.form.parameters().is_empty());
        let TimedDrive { fine, thinning, clock } = match (timing, start) {
            (Timing::Stamps(times_s), Start::Settled { period_samples, .. }) => {
                let period = period_samples.unwrap_or(drive.len());
                let cycles = cycles_before(times_s, drive, period, 0..drive.len());
                TimedDrive::on_stamps(cycles, (times_s, drive), scheme, self.inter_sample, depends_on)?
            }
            _ => TimedDrive::new((drive, ends), timing, scheme, self.inter_sample, depends_on)?,
        };
        let record = JointRecord::new(
            Ingredients {
                drive: fine.as_deref().unwrap_or(drive),
                thinning,
                factor: 1,
                every: 1,
                output: vec![0.0; drive.len()],
                weighting: vec![1.0; drive.len()].into(),
                before,
                transients: false,
                offset_is_held: false,
                nuisance: Vec::new(),
                cycles: 1,
                degree: self.layout.polynomial.len(),
                clock,
                scheme: self.scheme,
                sampling: Sampling { reconstruction: self.inter_sample, ..Sampling::of(self.scheme) },
            },
            &Stop::new(),
        )?;
        let layout = JointLayout { memory: vec![Role::Fixed(memory)], ..self.layout.clone() };
        let problem = JointProblem::new(
            vec![record].into(),
            (self.hysteresis, self.form),
            layout,
            self.bounds.clone(),
            String::new(),
        );
        let std_dev =
            problem.linearise_at(&self.x, &self.coefficients, &mut problem.workspace()).map_or_else(
                || vec![f64::NAN; drive.len()],
                |at| deviations(&[&at.linear, &at.searched], drive.len(), 0..drive.len(), &self.covariance),
            );
        Ok(PredictionBand { std_dev, noise: self.noise, ..PredictionBand::default() })
    }
}

/// Sets the bands of the training records and the errors of the model at their sines, from the linearisation
/// behind the covariance.
pub(super) fn give(problem: &JointProblem, known: &Knowledge, fits: &mut [RecordFit]) {
    let at = &known.linearisation;
    let Covariance { matrix, .. } = &known.covariance;
    let total = at.residuals.len();
    for ((index, record), fit) in problem.records().iter().enumerate().zip(fits) {
        let rows = problem.rows(index);
        let blocks = [&at.linear, &at.searched];
        let of_columns = || {
            blocks.map(|columns| {
                let own = columns.chunks_exact(total).map(|column| &column[rows.clone()]);
                let mut own = own.collect::<Vec<_>>().concat();
                own.par_chunks_exact_mut(rows.len()).for_each(|column| record.unweigh(column));
                own
            })
        };
        let (own, mut std_dev) = if record.weighs_samples_alone() && fit.sines.is_empty() {
            let mut std_dev = deviations(&blocks.map(Vec::as_slice), total, rows.clone(), matrix);
            record.unweigh(&mut std_dev);
            (None, std_dev)
        } else {
            let own = of_columns();
            let std_dev = deviations(&[&own[0], &own[1]], rows.len(), 0..rows.len(), matrix);
            (Some(own), std_dev)
        };
        // A sample without weight takes the value of the one before.
        let counts = |(_, weight): &(&mut f64, &f64)| **weight > 0.0;
        let mut last = std_dev.iter_mut().zip(record.weights()).find(counts).map_or(0.0, |(sd, _)| *sd);
        for (sd, weight) in std_dev.iter_mut().zip(record.weights()) {
            if *weight > 0.0 {
                last = *sd;
            }
            *sd = last;
        }
        let std_dev = record.at_samples(&std_dev).into_owned();
        fit.band = Some(PredictionBand { std_dev, noise: fit.scores.rmse, ..PredictionBand::default() });
        let Some(own) = own.filter(|_| !fit.sines.is_empty()) else { continue };
        let columns: Vec<Cow<'_, [f64]>> = own
            .iter()
            .flat_map(|block| block.chunks_exact(rows.len()))
            .map(|column| record.at_samples(column))
            .collect();
        let columns: Vec<&[f64]> = columns.iter().map(AsRef::as_ref).collect();
        // Derivatives are known only where samples have weight.
        let weights = record.at_samples(record.weights());
        let counts = |sine: &&mut SineResponse| {
            weights.get(sine.samples.clone()).is_some_and(|weights| weights.iter().all(|w| *w > 0.0))
        };
        let sines = fit.sines.iter_mut().filter(counts);
        sines::give_errors(sines, &fit.data, &fit.simulated, (&columns, matrix));
    }
}

/// √(J C Jᵀ) row by row over `rows` of a Jacobian whose columns, `total` long, follow one another in
/// `blocks`.
fn deviations(blocks: &[&[f64]], total: usize, rows: Range<usize>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let columns: Vec<&[f64]> =
        blocks.iter().flat_map(|b| b.chunks_exact(total)).map(|c| &c[rows.clone()]).collect();
    let mut deviations = vec![0.0; rows.len()];
    deviations.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, variance)| {
        let part = |j: usize| &columns[j][chunk * ROWS..][..variance.len()];
        let mut image = vec![0.0; variance.len()];
        let mut sum = vec![0.0; variance.len()];
        for i in 0..columns.len() {
            // C is symmetric: off-diagonal elements count twice.
            image.fill(0.0);
            for j in 0..=i {
                let c = covariance[(i, j)] * if i == j { 1.0 } else { 2.0 };
                if c != 0.0 {
                    image.iter_mut().zip(part(j)).for_each(|(to, x)| *to += c * x);
                }
            }
            sum.iter_mut().zip(part(i)).zip(&image).for_each(|((v, x), y)| *v += x * y);
        }
        variance.iter_mut().zip(sum).for_each(|(sd, v)| *sd = v.max(0.0).sqrt());
    });
    deviations
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::dynamics::{Creep, Dynamics, Modes};
    use hysteron_model::hammerstein::Model;
    use hysteron_model::hysteresis::{ArticleOperator, Hysteresis, UnitShape};
    use hysteron_optimize::Range;
    use rand::Rng;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;
    use std::f64::consts::TAU;

    /// Sum of twelve uniform numbers: mean 0, variance 1.
    fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
        (0..12).map(|_| (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64).sum::<f64>() - 6.0
    }

    #[test]
    fn agrees_with_simulations_of_drawn_parameters() {
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
        let names = ["beta", "gamma", "natural_frequency", "damping", "order2", "order1", "delay"];
        let p = [2.0, 0.02, -1.2, 0.35, 0.1, 120.0, 0.4, 1.9, 0.9, 0.0034];
        // Errors of half a percent, each correlated with the next.
        let root = DMatrix::from_fn(p.len(), p.len(), |i, j| match i.wrapping_sub(j) {
            0 => 5e-3 * p[i],
            1 => 3e-3 * p[i],
            _ => 0.0,
        });
        let known = OutputUncertainty {
            hysteresis: HysteresisForm::default(),
            form,
            layout: JointLayout {
                polynomial: vec![Role::Projected; 2],
                weights: vec![Role::Projected],
                shape: vec![Role::Searched(0), Role::Searched(1), Role::Fixed(1.0)],
                form: (2..6).map(Role::Searched).collect(),
                delay: Role::Searched(6),
                memory: Vec::new(),
            },
            bounds: Bounds { ranges: names.map(|name| Range::linear(name, -1e3, 1e3)).to_vec() },
            x: p[3..].to_vec(),
            coefficients: p[..3].to_vec(),
            covariance: &root * root.transpose(),
            scheme: Scheme::BandLimited,
            inter_sample: InterSample::Linear,
            noise: 0.1,
        };
        let drive: Vec<f64> = (0..250)
            .map(|k| 5.0 - 5.0 * (TAU * k as f64 / 100.0).cos() * (1.0 - 0.3 * (k as f64 * 0.02).sin()))
            .collect();
        let start = Start::Rest { voltage_v: drive[0] };
        let band = known.band(&drive, Some(1000.0), &start).unwrap();

        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let (mut sum, mut square) = (vec![0.0; drive.len()], vec![0.0; drive.len()]);
        let draws = 1500;
        for _ in 0..draws {
            let xi: Vec<f64> = p.iter().map(|_| normal(&mut rng)).collect();
            let q: Vec<f64> = (0..p.len())
                .map(|i| p[i] + (0..p.len()).map(|j| root[(i, j)] * xi[j]).sum::<f64>())
                .collect();
            let shape = UnitShape { beta: q[3], gamma: q[4], n: 1.0 };
            let model = Model {
                hysteresis: Hysteresis::from(
                    ArticleOperator::from_unit(q[..2].to_vec(), q[2], shape).unwrap(),
                ),
                dynamics: Dynamics::Fractional(form.transfer_function(&q[5..9]).unwrap()),
                offset: 0.0,
                delay_s: q[9],
                scheme: Scheme::BandLimited,
                inter_sample: InterSample::Linear,
                sample_rate_hz: None,
            };
            let y = model.simulate(&drive, Some(1000.0), &start).unwrap();
            let mean = y.iter().sum::<f64>() / y.len() as f64;
            for ((s, q), y) in sum.iter_mut().zip(&mut square).zip(&y) {
                *s += y - mean;
                *q += (y - mean).powi(2);
            }
        }
        let n = f64::from(draws);
        for (k, sd) in band.std_dev.iter().enumerate() {
            let drawn = ((square[k] - sum[k] * sum[k] / n) / (n - 1.0)).sqrt();
            assert!((sd / drawn - 1.0).abs() < 0.1, "{k}: {sd} {drawn}");
        }
        let (output, measured) = (band.of_output(), band.of_measurement());
        assert!((output[9] / band.std_dev[9] - 1.96).abs() < 1e-4);
        assert!((measured[9] - 1.96 * band.std_dev[9].hypot(0.1)).abs() < 1e-4);
    }

    #[test]
    fn deviations_are_the_quadratic_form_of_each_row() {
        let rows = 2 * ROWS + 37;
        let j = DMatrix::from_fn(rows, 3, |k, c| (k as f64 * (0.03 + 0.1 * c as f64)).cos());
        let root = DMatrix::from_fn(3, 3, |a, b| 0.3 * a as f64 - 0.7 * b as f64 + f64::from(a == b));
        let covariance = &root * root.transpose();
        let within = 5..rows - 7;
        let (first, others) = j.as_slice().split_at(rows);
        let found = deviations(&[first, others], rows, within.clone(), &covariance);
        for (k, sd) in within.zip(found) {
            let variance = (j.row(k) * &covariance * j.row(k).transpose())[(0, 0)];
            assert!((sd * sd - variance).abs() < 1e-13 * (1.0 + variance), "{k}: {sd}");
        }
    }

    #[test]
    fn refuses_a_settled_start_of_broken_periods() {
        let known = OutputUncertainty {
            hysteresis: HysteresisForm::default(),
            form: DynamicForm { modes: Modes::None, creep: Creep::None },
            layout: JointLayout {
                polynomial: vec![Role::Projected],
                weights: vec![Role::Fixed(0.0)],
                shape: [0.0, 0.0, 1.0].map(Role::Fixed).into(),
                form: Vec::new(),
                delay: Role::Fixed(0.0),
                memory: Vec::new(),
            },
            bounds: Bounds { ranges: Vec::new() },
            x: Vec::new(),
            coefficients: vec![2.0, 0.0],
            covariance: DMatrix::from_element(1, 1, 0.01),
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            noise: 0.0,
        };
        let broken = known.band(&[0.0, 1.0, 0.0], Some(10.0), &Start::settled(2));
        assert!(matches!(broken, Err(IdentifyError::NotPeriodic { .. })));
        // y = c u: the error of c times the drive about its mean.
        let band = known.band(&[0.0, 1.0, 5.0], Some(10.0), &Start::Rest { voltage_v: 0.0 }).unwrap();
        for (sd, expected) in band.std_dev.iter().zip([0.2, 0.1, 0.3]) {
            assert!((sd - expected).abs() < 1e-9, "{sd} {expected}");
        }
    }
}
