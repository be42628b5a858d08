//! A dry run of the inverse in the number type of its source, beside double precision, before it is written.

use hysteron_model::compensator::CompensatorParts;
use hysteron_rt::Real;

use crate::error::ExportError;
use crate::golden::Rounding;
use crate::inverse::{GoldenInverse, Inverse};
use crate::number::Precision;
use crate::subject::significant;

/// Samples that the inverse is thrown from limit to limit.
const THROWN: usize = 4000;
/// Longest time at a limit \[samples\].
const LONGEST: u64 = 12;

/// Largest differences between the voltages in the number type of an export and those in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryRun {
    /// Along the golden vectors.
    pub along_vectors: f64,
    /// Where steps of the reference throw it from limit to limit every few samples.
    pub thrown: f64,
}

impl DryRun {
    /// Runs the inverse along its vectors and from limit to limit; nothing departs in double precision.
    ///
    /// # Errors
    /// [`ExportError::Departs`] where it departs along its vectors by more than their tolerance; those of
    /// [`Inverse::new`].
    pub(crate) fn new(inverse: &Inverse, golden: &GoldenInverse) -> Result<Self, ExportError> {
        match inverse.subject.precision {
            Precision::F64 => Ok(Self { along_vectors: 0.0, thrown: 0.0 }),
            Precision::F32 => {
                let along_vectors = along_vectors::<f32>(inverse, golden)?;
                // NaN departs too.
                if along_vectors <= golden.tolerance {
                    return Ok(Self { along_vectors, thrown: thrown::<f32>(inverse, golden)? });
                }
                Err(ExportError::Departs {
                    departure: along_vectors,
                    bound: golden.tolerance,
                    unit: inverse.subject.input_unit.clone(),
                })
            }
        }
    }

    /// Whether the source departs further than its stated accuracy where it is thrown from limit to limit.
    pub fn departs(&self, rounding: Rounding) -> bool {
        self.thrown > rounding.bound
    }

    /// In words, for the source and for messages.
    pub(crate) fn in_words(&self, inverse: &Inverse) -> String {
        let unit = &inverse.subject.input_unit;
        let [low, high] = inverse.range_v;
        format!(
            "Thrown from limit to limit every few samples, the single-precision inverse departs from the \
             double-precision one by {} {unit}, {} of the range, where {} {unit} is stated for smooth \
             references; double precision does not.",
            significant(self.thrown),
            significant(self.thrown / (high - low)),
            significant(inverse.rounding.bound)
        )
    }
}

fn parts<T: Real>(inverse: &Inverse) -> Result<CompensatorParts<T>, ExportError> {
    Ok(CompensatorParts::new(&inverse.compensation, inverse.range_v, inverse.slew_v_per_s)?)
}

fn along_vectors<T: Real + Into<f64>>(inverse: &Inverse, golden: &GoldenInverse) -> Result<f64, ExportError> {
    let mut parts = parts::<T>(inverse)?;
    let mut compensator = parts.compensator()?;
    compensator.rest_at(T::of(golden.rest_v)).map_err(|_| still())?;
    let mut worst = 0.0_f64;
    for (k, (&reference, &voltage)) in golden.references.iter().zip(&golden.voltages).enumerate() {
        for _ in 1..golden.lasts(k) {
            compensator.step(T::of(reference));
        }
        let own: f64 = compensator.step(T::of(reference)).voltage.into();
        worst = worst.max((own - voltage).abs());
    }
    Ok(worst)
}

fn thrown<T: Real + Into<f64>>(inverse: &Inverse, golden: &GoldenInverse) -> Result<f64, ExportError> {
    let (mut own, mut double) = (parts::<T>(inverse)?, parts::<f64>(inverse)?);
    let (mut own, mut double) = (own.compensator()?, double.compensator()?);
    own.rest_at(T::of(golden.rest_v)).map_err(|_| still())?;
    double.rest_at(golden.rest_v).map_err(|_| still())?;
    let ends = golden.references.iter().fold([f64::MAX, f64::MIN], |[a, b], &r| [a.min(r), b.max(r)]);
    let (mut worst, mut k) = (0.0_f64, 0);
    // Knuth's 64-bit congruence: the same on every machine.
    let mut seed = 1_u64;
    while k < THROWN {
        for end in ends {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            for _ in 0..=(seed >> 33) % LONGEST {
                let voltage: f64 = own.step(T::of(end)).voltage.into();
                worst = worst.max((voltage - double.step(end).voltage).abs());
                k += 1;
            }
        }
    }
    Ok(worst)
}

/// A rest that the golden vectors were made from, and that this number type does not have.
fn still() -> ExportError {
    ExportError::Realise(hysteron_model::realise::RealiseError::Rounded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::compensator::{Compensation, CompensatorOptions};
    use hysteron_model::dynamics::{Dynamics, TransferFunction};
    use hysteron_model::fractional::Scheme;
    use hysteron_model::hammerstein::Model;
    use hysteron_model::hysteresis::{BoucWen, Hysteresis};
    use hysteron_model::model_file::{ModelFile, SignalUnits};
    use hysteron_model::realise::{RealiseOptions, realise};
    use hysteron_model::record::InterSample;

    use crate::Subject;

    #[test]
    fn an_inverse_that_would_fail_its_own_test_is_refused() {
        let shape = BoucWen { polynomial: vec![0.3], alpha: 0.08, beta: 0.05, gamma: 0.01, n: 1.0 };
        let model = Model {
            hysteresis: Hysteresis::from(shape),
            dynamics: Dynamics::Fractional(TransferFunction::article_eq13()),
            offset: 0.0,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: Some(1e4),
        };
        let realisation = realise(&model, 1e4, &RealiseOptions::default()).unwrap();
        let file = ModelFile::from_model(&model, SignalUnits::default());
        let subject = Subject::new("stage", Precision::F32, &file, realisation, 1e-5).unwrap();
        let law = Compensation::new(&model, 1e4, &CompensatorOptions::default()).unwrap();
        let inverse = Inverse::new(&subject, law, [0.0, 1.0], 2e3).unwrap();
        let mut golden = GoldenInverse::new(&inverse).unwrap();
        assert!(DryRun::new(&inverse, &golden).is_ok());
        // A tolerance that single precision cannot keep.
        golden.tolerance = 1e-12;
        let refused = DryRun::new(&inverse, &golden).unwrap_err();
        assert!(matches!(refused, ExportError::Departs { bound: 1e-12, .. }), "{refused}");
    }
}
