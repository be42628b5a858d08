//! `hysteron realise`: a model as real poles and pole pairs that run sample by sample.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_model::model::{Capability, CheckedRealisation, Sweep};
use hysteron_model::realise::{Realisation, RealiseError, RealiseOptions, Verification, realise, verify};
use hysteron_report::number::significant;
use hysteron_report::results::realisation::{facts, sections};

use crate::console;
use crate::console::clock;
use crate::failure::Failure;
use crate::model::LoadedModel;
use crate::numbers::{positive, share};

/// Turn a model into a fixed number of real poles and pole pairs for a controller's sample rate.
#[derive(Args)]
#[command(
    after_help = "The poles of the dynamics are kept; a branch cut is approximated by real poles, as many as \
    make the frequency response match the batch simulation's to the accuracy, a fraction of the range. \
    Printed: taps and sections x <- x + g (w - x), output c x (real parts for a pair), the largest error of \
    the response over the band, that against the simulation of a sweep over the model's range, and the time \
    per sample on this machine. --json holds every number to all digits.\n\nA model with unbounded creep is \
    realised down to --lowest-frequency (else a thousandth of the lowest frequency of the records it was \
    identified from); each further decade costs two or three states.\n\nExample: hysteron realise model.json \
    --sample-rate 10000 --accuracy 1e-5"
)]
pub struct Realise {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// Sample rate of the controller
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    sample_rate: f64,

    /// Maximum error, as a fraction of the range
    #[arg(
        long, value_name = "SHARE", default_value_t = 1e-5, value_parser = share, allow_hyphen_values = true,
    )]
    accuracy: f64,

    /// Lowest frequency to realise, for a model with unbounded creep
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    lowest_frequency: Option<f64>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Realise {
    pub fn run(&self) -> Result<(), Failure> {
        let loaded = LoadedModel::read(&self.model, Capability::Realisation)?;
        let options = RealiseOptions { accuracy: self.accuracy, lowest_frequency_hz: self.lowest_frequency };
        let realisation = realised(&self.model, &loaded, self.sample_rate, &options)?;
        let found = CheckedRealisation::new(realisation, loaded.body().data(), self.accuracy, &clock())
            .map_err(|e| cannot(&self.model, &e))?;
        remark_sweep(&found.verification, self.accuracy);
        if self.json { console::json(&found) } else { console::result(&text(&found)) }
    }
}

/// Deviation of a realisation from the batch simulation along a sweep over the model's range, and the sweep's
/// frequencies \[Hz\]; with a note if the deviation exceeds the accuracy.
///
/// # Errors
/// Those of [`verify`].
pub fn along_sweep(
    path: &Path,
    loaded: &LoadedModel,
    realisation: &Realisation,
    accuracy: f64,
) -> Result<(Verification, (f64, f64)), Failure> {
    let sweep = Sweep::over(loaded.body().data().valid_range.as_ref(), realisation.sample_rate_hz);
    let found = verify(realisation, &sweep.drive).map_err(|e| cannot(path, &e))?;
    remark_sweep(&found, accuracy);
    Ok((found, sweep.frequencies_hz))
}

fn remark_sweep(found: &Verification, accuracy: f64) {
    if found.largest > accuracy {
        console::note(&format!(
            "along the sweep the difference to the batch simulation is {} of the range, more than {}: the \
             excess over the error of the dynamics arises between the samples (see \
             docs/theory/realisation.md)",
            significant(found.largest, 2),
            significant(accuracy, 2)
        ));
    }
}

/// The realisation of a loaded model. With unbounded creep and no lowest frequency given, that is derived
/// from its records.
///
/// # Errors
/// Those of [`realise`], with a remedy.
pub fn realised(
    path: &Path,
    loaded: &LoadedModel,
    sample_rate_hz: f64,
    options: &RealiseOptions,
) -> Result<Realisation, Failure> {
    let stopped = where_creep_stops(loaded, sample_rate_hz, *options);
    if let (None, Some(low)) = (options.lowest_frequency_hz, stopped.lowest_frequency_hz) {
        console::note(&format!(
            "the model creeps for ever; realised down to {} Hz, a thousandth of the lowest frequency of its \
             records (--lowest-frequency says otherwise)",
            significant(low, 3)
        ));
    }
    realise(loaded.law(), sample_rate_hz, &stopped).map_err(|e| cannot(path, &e))
}

/// `options`, with a lowest frequency from the model's records if its creep is unbounded and none is given.
pub fn where_creep_stops(
    loaded: &LoadedModel,
    sample_rate_hz: f64,
    options: RealiseOptions,
) -> RealiseOptions {
    loaded.body().realise_options(sample_rate_hz, options)
}

fn cannot(model: &Path, error: &RealiseError) -> Failure {
    let failure = Failure::new(format!("cannot realise {}", model.display())).because(error);
    match error {
        RealiseError::LowestFrequency => failure
            .hint("give --lowest-frequency HZ, e.g. the inverse of the longest time the controller runs"),
        RealiseError::SampleRate { scheme: "ARX", .. } => failure.hint(
            "identify the model from records of the controller's rate, or with dynamics valid at any rate",
        ),
        RealiseError::SampleRate { .. } => {
            failure.hint("identify it with --scheme tustin, which is valid at other rates")
        }
        RealiseError::Accuracy { .. } => failure.hint("ask for less with --accuracy"),
        _ => failure,
    }
}

fn text(found: &CheckedRealisation) -> String {
    format!("{}\n\n{}\n", console::listed(&sections(found)), console::listed(&facts(found)))
}
