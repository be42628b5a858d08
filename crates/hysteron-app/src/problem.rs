//! Errors of the library as problems, and its remedies in the words of the page.

use std::path::Path;

use hysteron_export::ExportError;
use hysteron_identify::IdentifyError;
use hysteron_io::{FilePart, IoError};
use hysteron_model::Advice;
use hysteron_model::advice::ColumnRole;
use hysteron_model::control::ControlError;
use hysteron_model::invert::InversionError;
use hysteron_model::model::{RunError, Unsupported};
use hysteron_model::model_file::ModelFileError;
use hysteron_model::record::{DeadBandError, RecordError};

use crate::api::{Line, Problem};

/// Lines shown on either side of the line of an error.
const AROUND: u64 = 2;
/// Characters shown of a line.
const SHOWN: usize = 120;

impl Problem {
    /// With a remedy.
    pub(crate) fn new(what: impl std::fmt::Display, advice: Option<Advice>) -> Self {
        Self { what: what.to_string(), remedy: advice.map(|advice| remedy(&advice)), ..Self::default() }
    }

    /// Of a file: place and the lines around it. The server's folder is not part of the message.
    pub(crate) fn of_file(error: &IoError, path: &Path, name: &str) -> Self {
        let what = error.to_string().replace(&path.display().to_string(), name);
        let place = error.place().map(|place| place.part).filter(|part| *part != FilePart::Whole);
        let line = match &place {
            Some(FilePart::Line(line) | FilePart::Cell { line, .. }) => Some(*line),
            _ => None,
        };
        Self {
            place: place.as_ref().map(ToString::to_string),
            around: line.map(|line| around(path, line)).unwrap_or_default(),
            ..Self::new(what, error.advice())
        }
    }
}

impl From<RecordError> for Problem {
    fn from(e: RecordError) -> Self {
        Self::new(&e, e.advice())
    }
}

impl From<IdentifyError> for Problem {
    fn from(e: IdentifyError) -> Self {
        let measure = match &e {
            IdentifyError::CannotRank { measure, .. } => Some(format!("measure {measure}")),
            _ => None,
        };
        let problem = Self::new(&e, e.advice());
        Self { remedy: measure.or(problem.remedy.clone()), ..problem }
    }
}

/// Errors without a typed remedy.
macro_rules! said {
    ($($error:ty),*) => {
        $(impl From<$error> for Problem {
            fn from(e: $error) -> Self {
                Self::new(e, None)
            }
        })*
    };
}

said!(DeadBandError, RunError, ModelFileError, Unsupported, InversionError, ControlError, ExportError);

/// The lines of a text file around one of them; none of a file that is no text.
fn around(path: &Path, line: u64) -> Vec<Line> {
    use std::io::{BufRead, BufReader, Read};
    let Ok(file) = std::fs::File::open(path) else { return Vec::new() };
    // A line far down a large file is not worth reading the file for.
    let lines = BufReader::new(file.take(64 << 20)).lines();
    let first = line.saturating_sub(AROUND).max(1);
    let counted = (1..).zip(lines).skip_while(|(number, _)| *number < first);
    let wanted = counted.take_while(|(number, text)| *number <= line + AROUND && text.is_ok());
    let shown = wanted.filter_map(|(number, text)| {
        let text = text.ok()?.chars().filter(|c| !c.is_control() || *c == '\t').take(SHOWN).collect();
        Some(Line { number, text, here: number == line })
    });
    shown.collect()
}

/// A remedy in the words of the page.
pub(crate) fn remedy(advice: &Advice) -> String {
    match advice {
        Advice::ChooseColumn { role, example } => {
            let role = match role {
                ColumnRole::LeftOut => "that is left out".to_owned(),
                role => format!("of the {role}"),
            };
            let example = example.as_ref().map_or_else(String::new, |name| format!(", for example {name}"));
            format!("Choose the column {role}{example}.")
        }
        Advice::ChooseColumns => "Choose the columns of input and output.".to_owned(),
        Advice::ChooseResponse { .. } => "Choose the response of the file.".to_owned(),
        Advice::ScaleColumn { column } => format!("Give the scale of {column}, for example 2.5um/V."),
        Advice::GiveSampleRate => "Give the sample rate of the record.".to_owned(),
        Advice::Resample => {
            "Resample the record (hysteron prepare RECORD --rate HZ), or give its sample rate.".to_owned()
        }
        Advice::ContinueRun => "Mark the records as parts of one run.".to_owned(),
        Advice::CutOtherwise => "Cut the record differently.".to_owned(),
        Advice::GiveStart { .. } => "Say in which state the device was before the record.".to_owned(),
        Advice::ScoreAll => "Score the beginning too: skip 0 s.".to_owned(),
        Advice::GivePeriod => "Give the length of the period.".to_owned(),
        Advice::NameDynamicRecord => "Give a record the role “dynamic”.".to_owned(),
        Advice::DriveRange => "Give another range of the drive.".to_owned(),
        Advice::DriveRate => "Allow a higher slew rate of the drive.".to_owned(),
        Advice::CorrectDrive => {
            "Have the drive corrected by what the device does beside the model.".to_owned()
        }
        Advice::CreepThatEnds => "Identify the model with creep of the kind kelvin-voigt.".to_owned(),
        Advice::NarrowBand => "Restrict the range of frequencies.".to_owned(),
        Advice::OtherHysteresis => "Choose another family of hysteresis.".to_owned(),
        Advice::OtherKind { kind } => format!("Identify a model of the kind {kind}."),
        Advice::DeadBand { threshold, excess } => format!(
            "Give the record a dead {} of the drive of {threshold}.",
            if *excess { "zone" } else { "band" }
        ),
        Advice::SeveralAxes { inputs, outputs } => format!(
            "Identify all actuators together: the inputs {}, the outputs {}.",
            inputs.join(", "),
            outputs.join(", ")
        ),
        Advice::FitJointly => "Take the joint fit, without sampled dynamics.".to_owned(),
        Advice::NoDynamics => "Identify without dynamics, or resample the record to an even rate.".to_owned(),
        Advice::Widen { parameter } => format!("Widen the range of {parameter}."),
        Advice::Hold { parameter: Some(parameter) } => format!("Hold {parameter} at a known value."),
        Advice::Hold { parameter: None } => "Hold a parameter that is known.".to_owned(),
        Advice::SearchLonger => "Give the search more generations, or the usual optimiser.".to_owned(),
        Advice::GiveLowestFrequency => "Give the lowest frequency to realise.".to_owned(),
        Advice::GiveExponent => "Give the exponent.".to_owned(),
    }
}
