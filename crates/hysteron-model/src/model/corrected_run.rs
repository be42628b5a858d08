//! The output of a device outside the model class, whose misfit is predicted.
//!
//! To the model's output m the predicted discrepancy μ of the drive ([`crate::misfit`]) is added about its
//! first value, m + μ − μ(0): a constant cannot be told from the sensor's zero, and drives that are corrected
//! by the same are met from the rest before.

use super::{Capability, CorrectionScore, Hammerstein, Model, Remark, RunError, Score, Signals, Simulation};
use crate::misfit::{MisfitModel, NotCorrected};
use crate::record::{InputOutput, Timing};
use crate::start::Start;
use crate::validate::{Scores, Scoring, score};

impl Hammerstein {
    /// The model of the misfit, where correcting by it pays: the device is outside the model class, and on
    /// left-out parts of the training records the corrected model errs less.
    ///
    /// # Errors
    /// [`NotCorrected`].
    pub fn correction(&self) -> Result<MisfitModel, NotCorrected> {
        let misfit = self.data().misfit_model().ok_or(NotCorrected::InClass)?;
        misfit.correction_left_out().map(|_| misfit)
    }
}

impl Model {
    /// [`Self::simulate`], corrected by the predicted misfit of a device outside the model class.
    ///
    /// # Errors
    /// Those of [`Self::simulate`]; [`RunError::NotCorrected`] where the device is in the class or a correction
    /// does not pay, [`RunError::Unsupported`] of another kind of model.
    pub fn simulate_corrected(&self, signals: &Signals, start: Start) -> Result<Simulation, RunError> {
        self.hammerstein(Capability::Correction)?.correction()?;
        self.corrected(signals, self.simulate(signals, start)?)
    }

    /// [`Self::score`], corrected by the predicted misfit of a device outside the model class. For
    /// [`Start::AsIdentified`] it is the better of the start that explains the record best without the
    /// correction, whose estimated memory may stand for some of the misfit, and the one that the model file
    /// assumes. The verdict is that of the model alone.
    ///
    /// # Errors
    /// Those of [`Self::score`] and [`Self::simulate_corrected`].
    pub fn score_corrected(
        &self,
        signals: &Signals,
        start: Start,
        scoring: &Scoring,
    ) -> Result<Score, RunError> {
        let left_out = self.hammerstein(Capability::Correction)?.correction()?.correction_left_out()?;
        let Signals::Single(record) = signals else { return Err(self.takes_others()) };
        let plain = self.score(signals, start, scoring)?;
        let expected = self.expected_start(record, &mut Vec::new());
        let mut best = self.rescored(signals, record, plain.simulation, scoring)?;
        let mut without_estimated_start = None;
        if start == Start::AsIdentified && best.0.start != expected {
            let simulation = self.score(signals, expected, scoring)?.simulation;
            let other = self.rescored(signals, record, simulation, scoring)?;
            if other.1.rmse <= best.1.rmse {
                best = other;
            } else if matches!(best.0.start, Start::Remembering { .. }) {
                without_estimated_start = Some(Box::new(other.1));
            }
        }
        let (simulation, scores) = best;
        let without = plain.outputs.into_iter().next();
        Ok(Score {
            correction: without.map(|without| CorrectionScore { left_out, without: Box::new(without) }),
            without_estimated_start,
            verdict: plain.verdict,
            ..Score::of_single(record, plain.unit, scores, simulation)
        })
    }

    /// The corrected form of a simulation that was scored, and its scores on the same samples.
    fn rescored(
        &self,
        signals: &Signals,
        record: &InputOutput,
        simulation: Simulation,
        scoring: &Scoring,
    ) -> Result<(Simulation, Scores), RunError> {
        let simulation = self.corrected(signals, simulation)?;
        let unscored = simulation.remarks.iter().map(|remark| match remark {
            Remark::LeftOut { samples } => *samples,
            _ => 0,
        });
        let scored = record.without_first(unscored.sum());
        let scores = score(&scored, simulation.outputs.first().map_or(&[][..], Vec::as_slice), scoring)?;
        Ok((simulation, scores))
    }

    /// A simulation of this model for the same signals, with the predicted discrepancy added.
    fn corrected(&self, signals: &Signals, simulation: Simulation) -> Result<Simulation, RunError> {
        let body = self.hammerstein(Capability::Correction)?;
        let Signals::Single(record) = signals else { return Err(self.takes_others()) };
        let (misfit, timing) = (body.correction()?, Timing::from(&record.time));
        let told = misfit.predict(body.law(), &record.u, timing, &simulation.start);
        let told = told.map_err(|error| match error.not_corrected() {
            Ok(because) => RunError::from(because),
            Err(error) => error.into(),
        })?;
        let first = told.discrepancy.first().copied().unwrap_or(0.0);
        let mut corrected = simulation;
        for y in &mut corrected.outputs {
            y.iter_mut().zip(&told.discrepancy).for_each(|(y, d)| *y += d - first);
        }
        corrected.finite()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::model::corrected_drive::tests::model;
    use crate::record::TimeBase;

    fn record(y: Vec<f64>) -> InputOutput {
        let u = (0..1500).map(|k| 5.0 - 4.0 * (f64::from(k) * 0.02).cos()).collect();
        InputOutput::new("r", TimeBase::uniform(1000.0), u, y).unwrap()
    }

    #[test]
    fn a_device_that_is_model_and_misfit_is_simulated_exactly() {
        let model = model(Some(0.3));
        let signals = |y| Signals::Single(record(y));
        let start = Start::Rest { voltage_v: 1.0 };
        let corrected = model.simulate_corrected(&signals(vec![0.0; 1500]), start).unwrap();
        let body = model.hammerstein(Capability::Correction).unwrap();
        let (drive, rate) = (record(vec![0.0; 1500]).u, Timing::Rate(1000.0));
        let told = body.correction().unwrap().predict(body.law(), &drive, rate, &start).unwrap();
        let device: Vec<f64> =
            drive.iter().zip(&told.discrepancy).map(|(u, d)| 2.0 * u + d - told.discrepancy[0]).collect();
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        assert!(corrected.outputs[0].iter().zip(&device).map(off).fold(0.0, f64::max) < 1e-9);

        let scoring = Scoring::default();
        let plain = model.score(&signals(device.clone()), start, &scoring).unwrap();
        let found = model.score_corrected(&signals(device), start, &scoring).unwrap();
        assert!(plain.rmse > 0.1 && found.rmse < 1e-9, "{} {}", plain.rmse, found.rmse);
        assert!(plain.correction.is_none() && plain.correction_in_words().is_none());
        let correction = found.correction.as_ref().unwrap();
        assert_eq!((correction.left_out, correction.without.rmse), (0.3, plain.rmse));
        assert!(found.correction_in_words().unwrap().contains("leaves 30 % of the error"));
    }

    #[test]
    fn what_does_not_pay_is_refused_before_it_is_simulated() {
        let signals = Signals::Single(record(vec![0.0; 1500]));
        for (left_out, reason) in
            [(Some(0.95), NotCorrected::NoGain { left_out: 0.95 }), (None, NotCorrected::Unknown)]
        {
            let refused = model(left_out).simulate_corrected(&signals, Start::AsIdentified).unwrap_err();
            assert!(matches!(refused, RunError::NotCorrected(found) if found == reason), "{refused}");
        }
    }
}
