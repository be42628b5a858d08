//! The subject of an export: a realised model with its facts.

use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::model_file::{ModelFile, ScoreEntry, ScoreRole, ValidRange};
use hysteron_model::realise::{Realisation, RuntimeParts, Verification};
use hysteron_rt::Real;

use crate::error::ExportError;
use crate::golden::{Golden, Rounding};
use crate::number::Precision;
use crate::origin::Origin;

/// A model to export.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Beginning of every name in the source.
    pub name: String,
    /// Number type of the source.
    pub precision: Precision,
    /// The model at its rate.
    pub realisation: Realisation,
    /// Unit of the input, as in the model file.
    pub input_unit: String,
    /// Unit of the output, as in the model file.
    pub output_unit: String,
    /// Name of the model for people.
    pub title: Option<String>,
    /// Where the model comes from.
    pub origin: Origin,
    /// Range that the records covered.
    pub range: Option<ValidRange>,
    /// Scores of the model on its records.
    pub scores: Vec<ScoreEntry>,
    /// The accuracy the realisation was asked for.
    pub accuracy: f64,
    /// True if it follows from the model's own error.
    pub accuracy_by_error: bool,
    /// Bound on the rounding error of the displacement.
    pub rounding: Rounding,
    /// Deviation of the realisation from the batch simulation along a sweep between two frequencies \[Hz\],
    /// where it was compared.
    pub along_sweep: Option<(Verification, (f64, f64))>,
}

impl Subject {
    /// The realisation of the model in `file`, to be exported under `name`.
    ///
    /// # Errors
    /// [`ExportError::Name`]; [`ExportError::Realise`] where the numbers cannot be rounded to `precision`;
    /// [`ExportError::Rounding`] where it is too coarse for the displacement; [`ExportError::Still`] where
    /// the displacement is constant.
    pub fn new(
        name: &str,
        precision: Precision,
        file: &ModelFile,
        realisation: Realisation,
        accuracy: f64,
    ) -> Result<Self, ExportError> {
        check_name(name)?;
        match precision {
            Precision::F32 => check_numbers::<f32>(&realisation)?,
            Precision::F64 => check_numbers::<f64>(&realisation)?,
        }
        let mut subject = Self {
            name: name.to_owned(),
            precision,
            realisation,
            input_unit: file.units.input.clone(),
            output_unit: file.units.output.clone(),
            title: file.name.clone(),
            origin: Origin::of(file),
            range: file.valid_range.clone(),
            scores: file.scores.clone(),
            accuracy,
            accuracy_by_error: false,
            rounding: Rounding { bound: 0.0, share: 0.0 },
            along_sweep: None,
        };
        let golden = Golden::new(&subject)?;
        subject.rounding =
            Rounding::new("displacement", &subject.output_unit, golden.tolerance, golden.span)?;
        Ok(subject)
    }

    /// Lowest and highest voltage of the model's range; 0 to 1 where the file gives none.
    pub fn voltages(&self) -> (f64, f64) {
        self.range.as_ref().map_or((0.0, 1.0), |range| (range.input.low, range.input.high))
    }

    /// Description for the heads of the sources, line by line: text that each language has yet to escape.
    pub(crate) fn description(&self) -> Vec<String> {
        let linear = &self.realisation.dynamics;
        let (input, output) = (&self.input_unit, &self.output_unit);
        let number = significant;
        let title = self.title.as_deref().map(|t| format!(" ({t})")).unwrap_or_default();
        let mut lines = vec![format!(
            "{}{title}: {input} in, {output} out, {} Hz, {} precision.",
            self.name,
            number(self.realisation.sample_rate_hz),
            match self.precision {
                Precision::F32 => "single",
                Precision::F64 => "double",
            }
        )];
        lines.extend(self.origin.lines());
        lines.extend([
            String::new(),
            "displacement = offset + (H * v)(t), v = l[u] + memory, u the voltage:".into(),
            operator_in_words(self.realisation.model.hysteresis.form()),
            format!(
                "  H = {}(sum of {} tap(s) + {} states behind them); gain at rest {}.",
                match linear.delay_samples {
                    0 => String::new(),
                    samples => format!("z^-{samples} "),
                },
                linear.taps.len(),
                linear.states(),
                number(linear.rest_gain)
            ),
        ]);
        if self.realisation.joins_means {
            lines.push(
                "  Every move is also evaluated half-way: v enters H with its mean over each sample.".into(),
            );
        }
        lines.push(format!(
            "Accuracy of H: {} of the gain over {} to {} Hz ({}{}).",
            number(linear.frequency_error),
            number(linear.band_hz.0),
            number(linear.band_hz.1),
            number(self.accuracy),
            match self.accuracy_by_error {
                true => ", a tenth of the model's own error on its records",
                false => " asked for",
            }
        ));
        if let Some((found, (low, high))) = &self.along_sweep {
            lines.push(format!(
                "Off the batch simulation along a sweep of {} to {} Hz over its range: {} of the range at \
                 most, {} rms.",
                number(*low),
                number(*high),
                number(found.largest),
                number(found.rms)
            ));
        }
        if self.precision == Precision::F32 {
            lines.push(self.rounding.in_words("displacement", output));
        }
        lines.push(range_in_words(self.range.as_ref(), input));
        lines.push(format!(
            "The code does not limit its {input}: limit it to what the amplifier can deliver before it is \
             passed in. After a value far outside, the output comes back only as fast as the model's creep \
             decays."
        ));
        for score in &self.scores {
            let of = match score.role {
                ScoreRole::Training => "fitted to",
                ScoreRole::Validation => "held out",
            };
            let percent = score.rmse_percent_of_stroke.map(|p| format!(", {} % of the stroke", number(p)));
            lines.push(format!(
                "Error on {} ({of}): {} {} rms{}.",
                score.record,
                number(score.rmse),
                score.unit,
                percent.unwrap_or_default()
            ));
        }
        lines
    }
}

/// The range that a model was identified in, for the head of a source.
pub(crate) fn range_in_words(range: Option<&ValidRange>, input_unit: &str) -> String {
    let number = significant;
    let Some(range) = range else {
        return "The model file does not say which range it was identified in.".into();
    };
    let frequency = range.frequency.as_ref().map(|f| match f.low == f.high {
        true => format!(", at {} Hz", number(f.low)),
        false => format!(", {} to {} Hz", number(f.low), number(f.high)),
    });
    format!(
        "Identified from {} to {} {input_unit}{}; it extrapolates beyond.",
        number(range.input.low),
        number(range.input.high),
        frequency.unwrap_or_default()
    )
}

/// Four significant digits.
pub(crate) fn significant(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let text = format!("{:.*}", (3 - x.abs().max(1e-3).log10().floor() as i32).max(0) as usize, x);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn operator_in_words(form: HysteresisForm) -> String {
    let (name, weights) = (form.name(), form.columns());
    format!("  memory = {}, s = sign du ({name}, {weights} weight(s)).", form.description().equation())
}

fn check_numbers<T: Real>(realisation: &Realisation) -> Result<(), ExportError> {
    Ok(RuntimeParts::<T>::new(realisation).and_then(|mut parts| parts.model().map(drop))?)
}

/// Words that names must not be, in C, C++ or Rust; those with a capital or a leading _ are no names in here
/// anyway.
const KEYWORDS: &str = " as asm auto bool break case catch char class const continue crate default delete do \
                        double else enum explicit export extern false final float fn for friend goto if impl \
                        in inline int let long loop main match mod move mut namespace new operator override \
                        private protected pub public ref register restrict return self short signed sizeof \
                        static struct super switch template test this throw trait true try type typedef \
                        typename union unsafe unsigned use using virtual void volatile where while async \
                        await dyn ";

pub(crate) fn check_name(name: &str) -> Result<(), ExportError> {
    let first = name.starts_with(|c: char| c.is_ascii_lowercase());
    let rest = name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    if first && rest && name.len() <= 48 && !KEYWORDS.contains(&format!(" {name} ")) {
        Ok(())
    } else {
        Err(ExportError::Name { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers_of_both_languages() {
        for good in ["stage", "p_885", "x2"] {
            assert!(check_name(good).is_ok(), "{good}");
        }
        for bad in ["", "2x", "_x", "Stage", "a-b", "a b", "int", "fn", "é", &"a".repeat(49)] {
            assert!(check_name(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn figures_have_four_digits() {
        for (x, text) in [
            (10_000.0, "10000"),
            (0.957, "0.957"),
            (1.234567, "1.235"),
            (1e-5, "1.000e-5"),
            (0.0, "0"),
            (-123.4567, "-123.5"),
        ] {
            assert_eq!(significant(x), text);
        }
    }
}
