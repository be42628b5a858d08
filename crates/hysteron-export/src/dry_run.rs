//! Dry runs of inverses and controllers in the number type of their source, beside double precision, before
//! they are written.

use hysteron_model::compensator::CompensatorParts;
use hysteron_rt::Real;

use crate::error::ExportError;
use crate::golden::Rounding;
use crate::inverse::{GoldenInverse, Inverse};
use crate::number::Precision;
use crate::subject::significant;

/// Samples that a source is thrown from limit to limit.
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
    /// What the rounding of its sums explains.
    pub explained: f64,
}

/// Multiple of the departure along the vectors that is stated as the accuracy where it is not explained.
const STATED: f64 = 2.0;

impl DryRun {
    /// Of a source in double precision, which departs from nothing.
    pub(crate) const NONE: Self = Self { along_vectors: 0.0, thrown: 0.0, explained: 0.0 };

    /// Runs the inverse along its vectors and from limit to limit.
    ///
    /// # Errors
    /// [`ExportError::Departs`] where it departs along its vectors by more than is explained, and by more
    /// than half of [`Rounding::NOTED`] of the range; those of [`Inverse::new`].
    pub(crate) fn new(inverse: &Inverse, golden: &GoldenInverse) -> Result<Self, ExportError> {
        if inverse.subject.precision == Precision::F64 {
            return Ok(Self::NONE);
        }
        let along = along_vectors::<f32>(inverse, golden)?;
        Self::judged(&inverse.compared(), along, golden.tolerance, || thrown::<f32>(inverse, golden))
    }

    /// A departure along vectors where rounding explains `explained`; `thrown` runs from limit to limit.
    ///
    /// # Errors
    /// [`ExportError::Departs`] as in [`Self::new`]; those of `thrown`.
    pub(crate) fn judged(
        of: &Compared<'_>,
        along_vectors: f64,
        explained: f64,
        thrown: impl FnOnce() -> Result<f64, ExportError>,
    ) -> Result<Self, ExportError> {
        let [low, high] = of.range;
        let most = explained.max(Rounding::NOTED * (high - low) / STATED);
        // NaN departs too.
        if along_vectors <= most {
            return Ok(Self { along_vectors, thrown: thrown()?, explained });
        }
        let (what, unit) = (of.what, of.unit.to_owned());
        Err(ExportError::Departs { what, departure: along_vectors, bound: most, unit })
    }

    /// The accuracy that is stated: what rounding explains, or twice what was seen where that is more.
    pub fn stated(&self) -> f64 {
        if self.drifts() { STATED * self.along_vectors } else { self.explained }
    }

    /// Whether errors add up to more than the rounding of its sums explains.
    pub fn drifts(&self) -> bool {
        self.along_vectors > self.explained
    }

    /// Whether the source departs further than its stated accuracy where it is thrown from limit to limit.
    pub fn departs(&self) -> bool {
        self.thrown > self.stated()
    }

    /// Multiple of its number type's rounding, or of a dry run, that a self-test allows.
    pub(crate) fn tolerance_in_words(&self, precision: Precision) -> &'static str {
        match precision {
            Precision::F64 => "1e-12 of their range",
            Precision::F32 if self.drifts() => "twice the departure of a dry run",
            Precision::F32 => "16 units of rounding (2^-23) of the sum of magnitudes for a voltage",
        }
    }

    /// What is to be said in the source and in messages.
    pub(crate) fn in_words(&self, compared: &Compared<'_>) -> Vec<String> {
        let Compared { what, unit, range: [low, high] } = compared;
        let of =
            |x: f64| format!("{} {unit}, {} of the range", significant(x), significant(x / (high - low)));
        let drifts = self.drifts().then(|| {
            format!(
                "In a dry run rounding errors added up: the single-precision {what} departed from the \
                 double-precision one by {}, where rounding alone explains {} {unit}; double precision does \
                 not.",
                of(self.along_vectors),
                significant(self.explained)
            )
        });
        let departs = self.departs().then(|| {
            format!(
                "Thrown from limit to limit every few samples, the single-precision {what} departs from the \
                 double-precision one by {}, where {} {unit} is stated for other references; double \
                 precision does not.",
                of(self.thrown),
                significant(self.stated())
            )
        });
        drifts.into_iter().chain(departs).collect()
    }
}

/// What a dry run compares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compared<'a> {
    /// Name for people.
    pub what: &'static str,
    /// Unit of the voltage.
    pub unit: &'a str,
    /// Least and largest voltage.
    pub range: [f64; 2],
}

/// Calls `step` with the lower or the upper end of the references, from end to end every few samples.
pub(crate) fn throw(references: &[f64], mut step: impl FnMut(f64)) {
    let ends = references.iter().fold([f64::MAX, f64::MIN], |[a, b], &r| [a.min(r), b.max(r)]);
    let mut k = 0;
    // Knuth's 64-bit congruence: the same on every machine.
    let mut seed = 1_u64;
    while k < THROWN {
        for end in ends {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            for _ in 0..=(seed >> 33) % LONGEST {
                step(end);
                k += 1;
            }
        }
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
    let mut worst = 0.0_f64;
    throw(&golden.references, |end| {
        let voltage: f64 = own.step(T::of(end)).voltage.into();
        worst = worst.max((voltage - double.step(end).voltage).abs());
    });
    Ok(worst)
}

/// A rest that the golden vectors were made from, and that this number type does not have.
pub(crate) fn still() -> ExportError {
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
        // A tolerance that single precision cannot keep: stated is what was seen.
        golden.tolerance = 1e-12;
        let seen = DryRun::new(&inverse, &golden).unwrap();
        assert!(seen.drifts() && seen.stated() == 2.0 * seen.along_vectors);
        // Vectors of another inverse.
        golden.voltages.iter_mut().for_each(|u| *u += 0.01);
        let refused = DryRun::new(&inverse, &golden).unwrap_err();
        assert!(matches!(refused, ExportError::Departs { .. }), "{refused}");
    }
}
