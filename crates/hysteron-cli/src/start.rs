//! What the device did before a record's first sample.

use std::path::Path;

use clap::Args;
use hysteron_model::hammerstein::Start;
use hysteron_model::model_file::{ModelFile, StartKind};
use hysteron_model::oscillator::RecordStart;
use hysteron_model::record::{InputOutput, TimeBase, Unit, find_periods};
use hysteron_numeric::display::short;

use crate::console;
use crate::failure::Failure;
use crate::numbers::{number, positive};

/// How a simulation starts, where the model file's own assumption does not hold.
#[derive(Args, Clone, Debug)]
pub struct StartFlags {
    /// The device rested at this voltage before the record (the model file's assumption if not given)
    #[arg(long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true, conflicts_with = "settled")]
    rest_voltage: Option<f64>,

    /// The record repeats with this period and had been running for some periods before it begins
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    settled: Option<f64>,
}

/// A drive and its time.
pub struct Drive<'a> {
    pub u: &'a [f64],
    pub time: &'a TimeBase,
}

impl Drive<'_> {
    /// Sample rate, if the time base is uniform.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        match self.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(*sample_rate_hz),
            _ => None,
        }
    }
}

impl StartFlags {
    /// Whether the flags say what the start was.
    pub fn are_given(&self) -> bool {
        self.rest_voltage.is_some() || self.settled.is_some()
    }

    /// The start that the flags give an oscillator; `None` where they give none.
    ///
    /// # Errors
    /// As [`Self::choose`], and for a rest voltage: an oscillator rests without force.
    pub fn of_oscillator(&self, path: &Path, drive: &Drive) -> Result<Option<RecordStart>, Failure> {
        if self.rest_voltage.is_some() {
            return Err(Failure::usage("--rest-voltage does not go with an oscillator")
                .because("it starts from rest without force, or settled on a period (--settled)"));
        }
        Ok(self.period_samples(path, drive)?.map(|period_samples| RecordStart::Settled { period_samples }))
    }

    /// The period given by `--settled` \[s\], for a model that knows no rest voltage; `what` it is, e.g. `an oscillator`.
    ///
    /// # Errors
    /// If a rest voltage is given.
    pub fn settled_s(&self, what: &str) -> Result<Option<f64>, Failure> {
        if self.rest_voltage.is_some() {
            return Err(Failure::usage(format!("--rest-voltage does not go with {what}"))
                .because("a drive starts from its first sample held, or settled on a period (--settled)"));
        }
        Ok(self.settled)
    }

    /// Samples of the period given by `--settled`.
    fn period_samples(&self, path: &Path, drive: &Drive) -> Result<Option<usize>, Failure> {
        let Some(period_s) = self.settled else { return Ok(None) };
        let Some(rate) = drive.sample_rate_hz() else {
            return Err(Failure::new(format!("cannot start {} settled", path.display()))
                .because("the record has no uniform sample rate, so its period has no number of samples")
                .hint("give the sample rate with --sample-rate HZ"));
        };
        Ok(Some((period_s * rate).round() as usize))
    }

    /// The start of this record: the flags', else the model file's, else at rest at the first sample.
    ///
    /// # Errors
    /// If a period is given and the record has no sample rate.
    pub fn choose(&self, file: &ModelFile, path: &Path, drive: &Drive) -> Result<Start, Failure> {
        if let Some(period_samples) = self.period_samples(path, drive)? {
            return Ok(Start::Settled { period_samples });
        }
        let first = drive.u.first().copied().unwrap_or(0.0);
        let voltage = self.rest_voltage.or(file.start.voltage.as_ref().map(|v| v.value));
        match (voltage, file.start.kind) {
            (Some(voltage_v), _) => Ok(Start::Rest { voltage_v }),
            (None, StartKind::Rest) => Ok(Start::Rest { voltage_v: first }),
            (None, StartKind::Settled) => {
                Ok(settled(path, drive).unwrap_or(Start::Rest { voltage_v: first }))
            }
        }
    }
}

/// A start settled on the drive's own period, as the model file assumes; `None`, and a remark, where it has none.
fn settled(path: &Path, drive: &Drive) -> Option<Start> {
    // Only the drive counts for its period: it stands in for the output.
    let data = InputOutput::new("drive", drive.time.clone(), drive.u.to_vec(), drive.u.to_vec()).ok()?;
    match find_periods(&data) {
        Ok(periods) => Some(Start::Settled { period_samples: periods.period_samples.round() as usize }),
        Err(_) => {
            console::note(&format!(
                "{}: the model was identified on settled periodic records; this drive does not repeat and is taken to start at \
                 rest at its first sample (--rest-voltage says otherwise)",
                path.display()
            ));
            None
        }
    }
}

/// A start in words, with the units of input and output (header symbols).
pub fn in_words(start: &Start, input: &str, output: &str) -> String {
    let quantity =
        |value: f64, unit: &str| format!("{} {}", short(value), Unit::new(unit)).trim_end().to_owned();
    match start {
        Start::Rest { voltage_v } => format!("from rest at {}", quantity(*voltage_v, input)),
        Start::Remembering { voltage_v, memory } => format!(
            "from rest at {} {}",
            quantity(*voltage_v, input),
            memory.in_words(
                &short(memory.value()),
                &Unit::new(input).to_string(),
                &Unit::new(output).to_string()
            )
        ),
        Start::Settled { period_samples } => format!("settled on its period of {period_samples} samples"),
    }
}
