//! `hysteron realise`: a model as real poles and pole pairs that run sample by sample.

use std::path::PathBuf;

use clap::Args;
use hysteron_model::model::{Capability, CheckedRealisation};
use hysteron_model::realise::{RealiseError, RealiseOptions};
use hysteron_report::results::realisation::{facts, sections};

use crate::advice;
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
        let cannot = |e: RealiseError| {
            let failure = Failure::new(format!("cannot realise {}", self.model.display())).because(&e);
            with_remedy(failure, &e)
        };
        let (realisation, creep) = loaded.body().realised(self.sample_rate, options).map_err(cannot)?;
        let found = CheckedRealisation::new(realisation, loaded.body().data(), self.accuracy, &clock())
            .map_err(cannot)?;
        for finding in creep.iter().chain(&found.verification.finding(self.accuracy)) {
            console::note(&advice::text(finding));
        }
        if self.json { console::json(&found) } else { console::result(&text(&found)) }
    }
}

/// The failure with what to change, in flags.
pub fn with_remedy(failure: Failure, error: &RealiseError) -> Failure {
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
