//! The drive for a reference on a device outside the model class, whose misfit is predicted.
//!
//! With the model m and the predicted discrepancy μ of the drive ([`crate::misfit`]), the drive is sought for
//! which m(u) + μ(u) − μ(u)₀ is the reference r, μ₀ being its first value: u ← m⁻¹(r − μ(u) + μ₀(u)), from the
//! drive of the model alone. What is left contracts by the ratio of the slopes of μ and m at each repetition.

use super::Hammerstein;
use crate::invert::{InverseDrive, InverseOptions, InversionError};
use crate::misfit::MisfitError;
use crate::record::Timing;
use crate::start::Start;
use hysteron_numeric::Listener;

/// Most repetitions, and the change of the drive in units of the first at which they end.
const MOST: usize = 8;
const SETTLED: f64 = 0.01;

impl Hammerstein {
    /// The drive for a reference by model and misfit together; `predicted` is the output of both.
    ///
    /// # Errors
    /// [`InversionError`].
    pub(super) fn corrected_drive(
        &self,
        reference: &[f64],
        sample_rate_hz: f64,
        options: &InverseOptions,
        listener: Listener<'_>,
    ) -> Result<InverseDrive, InversionError> {
        let misfit = self.correction()?;
        let shift = |found: &InverseDrive| -> Result<Vec<f64>, InversionError> {
            let start = found.rest.unwrap_or(Start::settled(found.drive.len()));
            let timing = Timing::Rate(sample_rate_hz);
            let told = misfit.predict(self.law(), &found.drive, timing, &start).map_err(failed)?;
            let first = told.discrepancy.first().copied().unwrap_or(0.0);
            Ok(told.discrepancy.iter().map(|x| x - first).collect())
        };
        let part = |k: usize| k as f64 / (MOST + 1) as f64;
        let told = listener.part(0.0, part(1));
        let mut found = self.law().invert_told(reference, sample_rate_hz, options, told)?;
        let mut discrepancy = shift(&found)?;
        let mut first_move = None;
        for repetition in 1..=MOST {
            let wanted: Vec<f64> = reference.iter().zip(&discrepancy).map(|(r, d)| r - d).collect();
            let told = listener.part(part(repetition), part(repetition + 1));
            let next = self.law().invert_told(&wanted, sample_rate_hz, options, told)?;
            let squares = next.drive.iter().zip(&found.drive).map(|(to, from)| (to - from).powi(2));
            let moved = squares.sum::<f64>().sqrt();
            found = next;
            discrepancy = shift(&found)?;
            if moved <= SETTLED * *first_move.get_or_insert(moved) {
                break;
            }
        }
        found.predicted.iter_mut().zip(&discrepancy).for_each(|(y, d)| *y += d);
        Ok(found)
    }
}

fn failed(error: MisfitError) -> InversionError {
    match error.not_corrected() {
        Ok(because) => because.into(),
        Err(error) => error.into(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
pub(super) mod tests {
    use super::*;
    use crate::Model;
    use crate::dynamics::{Dynamics, Scheme};
    use crate::hammerstein;
    use crate::hysteresis::Hysteresis;
    use crate::misfit::{Basis, COLUMNS, MisfitModel};
    use crate::model::{Capability, InverseRequest};
    use crate::model_file::{MisfitEntry, ModelFile, SignalUnits};
    use crate::record::InterSample;

    /// 2 µm/V, beside which the device has a square and a play.
    pub(in crate::model) fn model(left_out: Option<f64>) -> Model {
        let law = hammerstein::Model {
            hysteresis: Hysteresis::without_memory(vec![2.0]).unwrap(),
            dynamics: Dynamics::None,
            offset: 0.0,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Hold,
            sample_rate_hz: None,
        };
        let mut file = ModelFile::from_model(&law, SignalUnits::default());
        let mut mean = vec![0.0; COLUMNS];
        // A hat over the play of half-width 0.2, and Legendre's second polynomial.
        (mean[17], mean[46]) = (0.8, 0.5);
        file.misfit = Some(MisfitEntry::from(&MisfitModel {
            basis: Basis { low_v: 0.0, high_v: 10.0, frequency_hz: 20.0 },
            noise: 0.01,
            explained: 0.9,
            left_out,
            mean,
            directions: vec![vec![0.0; COLUMNS]; COLUMNS],
            information: vec![30.0; COLUMNS],
            one_amplitude: false,
        }));
        Model::try_from(file).unwrap()
    }

    #[test]
    fn model_and_misfit_together_follow_the_reference() {
        let model = model(Some(0.3));
        let model = model.hammerstein(Capability::Inversion).unwrap();
        let reference: Vec<f64> = (0..1500).map(|k| 10.0 - 8.0 * (f64::from(k) * 0.02).cos()).collect();
        let made = |correct: bool| {
            let request = InverseRequest { range: Some([0.0, 10.0]), correct, ..InverseRequest::default() };
            model.drive_for(&reference, 1000.0, &request, None, Listener::silent()).unwrap().0
        };
        // Output of the device: model and misfit from the rest before.
        let error = |found: &InverseDrive| {
            let start = found.rest.unwrap();
            let device = model.law().simulate(&found.drive, Some(1000.0), &start).unwrap();
            let misfit = model.correction().unwrap();
            let told = misfit.predict(model.law(), &found.drive, Timing::Rate(1000.0), &start).unwrap();
            let first = told.discrepancy[0];
            let both = device.iter().zip(&told.discrepancy).map(|(y, d)| y + d - first);
            let corrected: Vec<f64> = both.collect();
            let off = corrected.iter().zip(&reference).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
            (off, corrected)
        };
        let ((plain, _), (off, corrected)) = (error(&made(false)), error(&made(true)));
        assert!(plain > 0.3 && off < 0.005 * plain, "{plain} {off}");
        assert!(corrected.iter().zip(&made(true).predicted).all(|(y, told)| (y - told).abs() < 1e-9));
    }

    #[test]
    fn what_does_not_pay_or_is_not_known_to_is_refused() {
        for (left_out, part) in [(Some(0.95), "gains nothing"), (None, "identify the model again")] {
            let model = model(left_out);
            let model = model.hammerstein(Capability::Inversion).unwrap();
            let request =
                InverseRequest { range: Some([0.0, 10.0]), correct: true, ..InverseRequest::default() };
            let refused = model.drive_for(&[10.0, 10.1], 1000.0, &request, None, Listener::silent());
            assert!(refused.unwrap_err().to_string().contains(part));
        }
    }
}
