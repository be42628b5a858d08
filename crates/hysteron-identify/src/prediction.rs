//! Prediction bands from a model file: the covariance of its parameters propagated to the output.
//!
//! With the covariance C = Σ_k d_k d_kᵀ of the numbers (d_k the eigenvectors of their correlation, scaled),
//! the variance of the output is Σ_k (∂y/∂d_k)².
//! [`super::OutputUncertainty`] differentiates analytically but needs the fit. In both the band is that of
//! the output about its mean: a sensor has an arbitrary zero.

use super::joint::PredictionBand;
use crate::IdentifyError;
use crate::sensitivity::{directions, moved, sensitivities};
use hysteron_model::Start;
use hysteron_model::model_file::ModelFile;
use hysteron_model::record::Timing;
use hysteron_numeric::Listener;

impl PredictionBand {
    /// Band of a model file's output for `drive` \[V\]. Its `noise` is the RMSE over all scores of the file;
    /// 0 without scores, when only [`Self::of_output`] is meaningful. The file's model of the misfit, if it has
    /// one, gives the band of a measurement.
    ///
    /// # Errors
    /// [`IdentifyError`]: no correlation in the file, a drive that the model cannot be simulated on.
    pub fn of_file<'a>(
        file: &ModelFile,
        drive: &[f64],
        timing: impl Into<Timing<'a>>,
        start: &Start,
    ) -> Result<Self, IdentifyError> {
        Self::of_file_told(file, drive, timing, start, Listener::silent())
    }

    /// [`Self::of_file`], with its progress told to `listener`.
    ///
    /// # Errors
    /// Those of [`Self::of_file`]; [`IdentifyError::Stopped`] where the listener ends it.
    pub fn of_file_told<'a>(
        file: &ModelFile,
        drive: &[f64],
        timing: impl Into<Timing<'a>>,
        start: &Start,
        listener: Listener<'_>,
    ) -> Result<Self, IdentifyError> {
        let timing = timing.into();
        let model = file.to_model()?;
        let (names, covariance) = file.covariance().ok_or(IdentifyError::NoCorrelation)?;
        let directions = directions(&covariance);
        let meter = listener.meter("uncertainty", directions.len());
        let at = |k: usize, step: f64| Ok(moved(&model, &names, &directions[k], step));
        let derivatives = sensitivities(directions.len(), at, (drive, timing, start), &meter)?;
        let mut variance = vec![0.0; drive.len()];
        for derivative in derivatives {
            variance.iter_mut().zip(derivative).for_each(|(v, d)| *v += d * d);
        }
        let predicted = file.misfit_model().map(|misfit| misfit.predict(&model, drive, timing, start));
        // Where the misfit cannot be predicted (time stamps), the band is that of the class, and says so.
        let (misfit, finding) = match predicted {
            Some(Ok(misfit)) => {
                let finding = misfit.finding();
                (Some(misfit), finding)
            }
            Some(Err(error)) => (None, Some(error.finding())),
            None => (None, None),
        };
        let std_dev = variance.into_iter().map(f64::sqrt).collect();
        Ok(Self { std_dev, noise: scatter(file), misfit, findings: finding.into_iter().collect() })
    }
}

/// RMSE over all scores of the file.
pub(crate) fn scatter(file: &ModelFile) -> f64 {
    let samples: f64 = file.scores.iter().map(|s| s.samples as f64).sum();
    let square: f64 = file.scores.iter().map(|s| s.samples as f64 * s.rmse * s.rmse).sum();
    if samples > 0.0 { (square / samples).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensitivity::STEP;
    use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
    use hysteron_model::hammerstein::Model;
    use hysteron_model::hysteresis::Hysteresis;
    use hysteron_model::model_file::SignalUnits;
    use hysteron_model::record::InterSample;
    use nalgebra::{DMatrix, DVector};

    fn model() -> Model {
        let term = |coefficient, order| Term { coefficient, order };
        let g = TransferFunction {
            numerator: vec![term(1.0, 0.0)],
            denominator: vec![term(1.0, 0.0), term(0.01, 1.0)],
        };
        Model {
            hysteresis: Hysteresis::without_memory(vec![2.0]).unwrap(),
            dynamics: Dynamics::Integer(g),
            offset: 0.0,
            delay_s: 0.002,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        }
    }

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(|n| (*n).to_owned()).collect()
    }

    #[test]
    fn of_a_gain_is_its_error_times_the_drive_about_its_mean() {
        let mut file = ModelFile::from_model(&model(), SignalUnits::default());
        file.dynamics = ModelFile::from_model(
            &Model { dynamics: Dynamics::None, delay_s: 0.0, ..model() },
            SignalUnits::default(),
        )
        .dynamics;
        file.delay.value = 0.0;
        let start = Start::Rest { voltage_v: 0.0 };
        assert!(matches!(
            PredictionBand::of_file(&file, &[0.0, 1.0], None, &start),
            Err(IdentifyError::NoCorrelation)
        ));
        file.set_covariance(&names(&["linear"]), &DMatrix::from_element(1, 1, 0.01));
        let band = PredictionBand::of_file(&file, &[0.0, 1.0, 5.0], None, &start).unwrap();
        for (sd, expected) in band.std_dev.iter().zip([0.2, 0.1, 0.3]) {
            assert!((sd - expected).abs() < 1e-9, "{sd} {expected}");
        }
        assert_eq!(band.noise, 0.0);
    }

    #[test]
    fn creep_alone_stays_proper() {
        // (k + s^μ)/s^μ: μ stands in the numerator and in the denominator.
        let term = |coefficient, order| Term { coefficient, order };
        let g = TransferFunction {
            numerator: vec![term(0.05, 0.0), term(1.0, 0.1)],
            denominator: vec![term(1.0, 0.1)],
        };
        let creeping = Model { dynamics: Dynamics::Fractional(g), delay_s: 0.0, ..model() };
        let both = names(&["numerator[1].order", "denominator[0].order"]);
        // As an eigenvector has them: equal but for rounding.
        let direction = DVector::from_vec(vec![0.01 + 1e-12, 0.01]);
        let up = moved(&creeping, &both, &direction, STEP);
        let Dynamics::Fractional(g) = &up.dynamics else { panic!("{:?}", up.dynamics) };
        assert_eq!((g.numerator[1].order, g.denominator[0].order), (0.10001, 0.10001));
        up.simulate(&[0.0, 1.0, 1.0], Some(100.0), &Start::Rest { voltage_v: 0.0 }).unwrap();
    }

    #[test]
    fn numbers_that_make_up_for_each_other_leave_the_output_known() {
        // The gain at rest is linear · b / c₀: errors of both of the same sign and share cancel.
        let mut file = ModelFile::from_model(&model(), SignalUnits::default());
        let drive: Vec<f64> = (0..300).map(|k| (f64::from(k) * 0.05).sin()).collect();
        let band = |file: &ModelFile| {
            let start = Start::Rest { voltage_v: 0.0 };
            let band = PredictionBand::of_file(file, &drive, Some(1000.0), &start).unwrap();
            band.std_dev.iter().fold(0.0f64, |m, s| m.max(*s))
        };
        let of = |rho: f64| DMatrix::from_row_slice(2, 2, &[0.04, -0.02 * rho, -0.02 * rho, 0.01]);
        let both = names(&["linear", "numerator[0].coefficient"]);
        file.set_covariance(&both, &of(0.0));
        let apart = band(&file);
        file.set_covariance(&both, &of(1.0));
        assert!(apart > 0.2 && band(&file) < 1e-6 * apart, "{apart} {}", band(&file));
    }
}
