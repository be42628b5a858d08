//! `hysteron realise`: a model as real poles and pole pairs that run sample by sample.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_model::model::Capability;
use hysteron_model::model_file::ValidRange;
use hysteron_model::realise::{
    LinearRealisation, Realisation, RealiseError, RealiseOptions, Section, StreamParts, Verification,
    nanoseconds_per_sample, realise, sweep, verify,
};
use hysteron_report::number::significant;
use serde::Serialize;

use crate::console;
use crate::console::clock;
use crate::failure::Failure;
use crate::model::LoadedModel;
use crate::numbers::{positive, share};

/// Turn a model into a fixed number of real poles and pole pairs for a controller's sample rate.
#[derive(Args)]
#[command(
    after_help = "The poles of the dynamics are kept, a branch cut becomes real poles, their number grown until the response follows the batch \
    simulation's to the accuracy, a share of the range. Printed: taps and sections x <- x + g (w - x), output c x (real parts for a pair), the \
    largest error of the response over the band, that against a simulation of a sweep over the model's own range, and the time a sample took on \
    this machine. --json holds every number to all digits.\n\n\
    A model that creeps for ever is realised down to --lowest-frequency (else a thousandth of the lowest frequency of the records it was identified \
    from); a decade more costs two or three states.\n\n\
    Example: hysteron realise model.json --sample-rate 10000 --accuracy 1e-5"
)]
pub struct Realise {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// Sample rate of the controller
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    sample_rate: f64,

    /// Largest error, as a share of the range
    #[arg(long, value_name = "SHARE", default_value_t = 1e-5, value_parser = share, allow_hyphen_values = true)]
    accuracy: f64,

    /// Frequency down to which a model that creeps for ever is realised
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    lowest_frequency: Option<f64>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Samples of the sweep that is compared and timed, and passes of the clock.
const SAMPLES: usize = 20_000;
const ROUNDS: usize = 20;

/// What was found out, for text and JSON.
struct Found {
    realisation: Realisation,
    verification: Verification,
    voltages: (f64, f64),
    frequencies_hz: (f64, f64),
    nanoseconds: f64,
    accuracy: f64,
    units: (String, String),
}

impl Realise {
    pub fn run(&self) -> Result<(), Failure> {
        let loaded = LoadedModel::read(&self.model, Capability::Realisation)?;
        let range = loaded.file().valid_range.as_ref();
        let failed = |e: RealiseError| cannot(&self.model, &e);
        let options = RealiseOptions { accuracy: self.accuracy, lowest_frequency_hz: self.lowest_frequency };
        let realisation = realised(&self.model, &loaded, self.sample_rate, &options)?;
        let voltages = voltages(range);
        let frequencies_hz = frequencies(range, self.sample_rate);
        let drive = drive(range, self.sample_rate);
        let verification = verify(&realisation, &drive).map_err(failed)?;
        let mut parts = StreamParts::new(&realisation).map_err(failed)?;
        let mut streams = [parts.stream().map_err(failed)?];
        let timed = drive.get(..SAMPLES).unwrap_or(&drive);
        let times = nanoseconds_per_sample(&mut streams, timed, ROUNDS, &clock()).map_err(failed)?;
        let units = &loaded.file().units;
        let found = Found {
            realisation,
            verification,
            voltages,
            frequencies_hz,
            nanoseconds: times.first().copied().unwrap_or(f64::NAN),
            accuracy: self.accuracy,
            units: (units.input.clone(), units.output.clone()),
        };
        remark_sweep(&found.verification, self.accuracy);
        if self.json { console::json(&Summary::new(&found)) } else { console::result(&text(&found)) }
    }
}

/// The sweep over a model's own range: two periods of its lowest frequency, within reason.
fn drive(range: Option<&ValidRange>, sample_rate_hz: f64) -> Vec<f64> {
    let frequencies_hz = frequencies(range, sample_rate_hz);
    let samples = ((2.0 * sample_rate_hz / frequencies_hz.0) as usize).clamp(SAMPLES, 20 * SAMPLES);
    sweep(voltages(range), frequencies_hz, sample_rate_hz, samples)
}

fn voltages(range: Option<&ValidRange>) -> (f64, f64) {
    range.map_or((0.0, 1.0), |r| (r.input.low, r.input.high))
}

/// What a realisation is off the batch simulation along that sweep, and its frequencies \[Hz\]; with a remark where that is more than the accuracy.
///
/// # Errors
/// As [`verify`].
pub fn along_sweep(
    path: &Path,
    loaded: &LoadedModel,
    realisation: &Realisation,
    accuracy: f64,
) -> Result<(Verification, (f64, f64)), Failure> {
    let range = loaded.file().valid_range.as_ref();
    let rate = realisation.sample_rate_hz;
    let found = verify(realisation, &drive(range, rate)).map_err(|e| cannot(path, &e))?;
    remark_sweep(&found, accuracy);
    Ok((found, frequencies(range, rate)))
}

fn remark_sweep(found: &Verification, accuracy: f64) {
    if found.largest > accuracy {
        console::note(&format!(
            "along the sweep the difference to the batch simulation is {} of the range, more than {}: what is beyond the dynamics' error lies between \
             the samples (see docs/theory/realisation.md)",
            significant(found.largest, 2),
            significant(accuracy, 2)
        ));
    }
}

/// The realisation of a loaded model. Where it creeps for ever and nobody names a lowest frequency, down to one that its records suggest.
///
/// # Errors
/// As [`realise`], with what to do about it.
pub fn realised(
    path: &Path,
    loaded: &LoadedModel,
    sample_rate_hz: f64,
    options: &RealiseOptions,
) -> Result<Realisation, Failure> {
    let stopped = where_creep_stops(loaded, sample_rate_hz, *options);
    if let (None, Some(low)) = (options.lowest_frequency_hz, stopped.lowest_frequency_hz) {
        console::note(&format!(
            "the model creeps for ever; realised down to {} Hz, a thousandth of the lowest frequency of its records \
             (--lowest-frequency says otherwise)",
            significant(low, 3)
        ));
    }
    realise(loaded.model(), sample_rate_hz, &stopped).map_err(|e| cannot(path, &e))
}

/// The same, with a lowest frequency from the model's records where it creeps for ever and nobody names one.
pub fn where_creep_stops(
    loaded: &LoadedModel,
    sample_rate_hz: f64,
    options: RealiseOptions,
) -> RealiseOptions {
    loaded.body().realise_options(sample_rate_hz, options)
}

/// The sweep that is compared: the frequencies of the records, within what the sample rate carries.
fn frequencies(range: Option<&ValidRange>, sample_rate_hz: f64) -> (f64, f64) {
    let most = 0.01 * sample_rate_hz;
    let own = range.and_then(|r| r.frequency.as_ref()).map(|f| (f.low, f.high));
    let (low, high) = own.unwrap_or((0.01 * most, most));
    let high = if high > 0.0 { high.min(0.1 * sample_rate_hz) } else { most };
    (if low > 0.0 { low.clamp(1e-4 * high, high) } else { 0.01 * high }, high)
}

fn cannot(model: &Path, error: &RealiseError) -> Failure {
    let failure = Failure::new(format!("cannot realise {}", model.display())).because(error);
    match error {
        RealiseError::LowestFrequency => {
            failure.hint("give --lowest-frequency HZ, e.g. the inverse of the longest time the controller runs")
        }
        RealiseError::SampleRate { scheme: "ARX", .. } => failure
            .hint("identify the model from records of the controller's rate, or with dynamics that hold at any rate"),
        RealiseError::SampleRate { .. } => failure.hint("identify it with --scheme tustin, which holds at other rates"),
        RealiseError::Accuracy { .. } => failure.hint("ask for less with --accuracy"),
        _ => failure,
    }
}

fn text(found: &Found) -> String {
    let (linear, check) = (&found.realisation.dynamics, &found.verification);
    let rate = found.realisation.sample_rate_hz;
    let number = |x: f64| significant(x, 6);
    let mut sections = console::table(&["section", "forgets at [rad/s]", "g", "c"]);
    let taps = linear.taps.iter().enumerate();
    for (j, tap) in taps {
        sections.add_row([
            format!("tap, {} samples ago", linear.delay_samples + j),
            "-".into(),
            "-".into(),
            number(*tap),
        ]);
    }
    for section in &linear.sections {
        let complex = |re: f64, im: f64| {
            if section.is_pair() {
                format!("{} {} {}i", number(re), if im < 0.0 { "−" } else { "+" }, number(im.abs()))
            } else {
                number(re)
            }
        };
        sections.add_row([
            if section.is_pair() { "pole pair" } else { "real pole" }.to_owned(),
            significant(section.rate(rate), 4),
            complex(section.gain.re, section.gain.im),
            complex(section.weight.re, section.weight.im),
        ]);
    }
    let band = if linear.band_hz.0 > 0.0 {
        format!("{} Hz to {} Hz", significant(linear.band_hz.0, 3), significant(linear.band_hz.1, 4))
    } else {
        format!("rest to {} Hz", significant(linear.band_hz.1, 4))
    };
    let mut facts = console::table(&["", ""]);
    for (what, value) in [
        ("states", linear.states().to_string()),
        ("taps", linear.taps.len().to_string()),
        ("delay", format!("{} samples and what the taps hold", linear.delay_samples)),
        ("gain at rest", significant(linear.rest_gain, 6)),
        ("accuracy asked for [share of range]", significant(found.accuracy, 2)),
        ("largest error of the response", format!("{}, {band}", significant(linear.frequency_error, 2))),
        (
            "against the batch simulation",
            format!(
                "{} largest, {} rms: sweep {} to {} Hz, {} to {} {}",
                significant(check.largest, 2),
                significant(check.rms, 2),
                significant(found.frequencies_hz.0, 3),
                significant(found.frequencies_hz.1, 3),
                significant(found.voltages.0, 4),
                significant(found.voltages.1, 4),
                found.units.0
            ),
        ),
        ("weights over gain (rounding is amplified by)", significant(linear.amplification(), 3)),
        (
            "time a sample, double precision, this machine",
            format!("{} ns", significant(found.nanoseconds, 3)),
        ),
    ] {
        facts.add_row([what.to_owned(), value]);
    }
    format!("{sections}\n\n{facts}\n")
}

#[derive(Serialize)]
struct Summary<'a> {
    sample_rate_hz: f64,
    accuracy: f64,
    states: usize,
    delay_samples: usize,
    taps: &'a [f64],
    sections: Vec<SectionEntry>,
    rest_gain: f64,
    offset: f64,
    moves_half_way: bool,
    band_hz: [f64; 2],
    frequency_error: f64,
    reference_gain: f64,
    weights_over_gain: f64,
    batch_difference_largest: f64,
    batch_difference_rms: f64,
    range: f64,
    output_unit: &'a str,
    nanoseconds_per_sample: f64,
}

#[derive(Serialize)]
struct SectionEntry {
    kind: &'static str,
    rate_rad_per_s: f64,
    gain: [f64; 2],
    weight: [f64; 2],
}

impl SectionEntry {
    fn new(section: &Section, rate: f64) -> Self {
        SectionEntry {
            kind: if section.is_pair() { "pair" } else { "real" },
            rate_rad_per_s: section.rate(rate),
            gain: [section.gain.re, section.gain.im],
            weight: [section.weight.re, section.weight.im],
        }
    }
}

impl<'a> Summary<'a> {
    fn new(found: &'a Found) -> Self {
        let realisation = &found.realisation;
        let linear: &LinearRealisation = &realisation.dynamics;
        let rate = realisation.sample_rate_hz;
        Summary {
            sample_rate_hz: rate,
            accuracy: found.accuracy,
            states: linear.states(),
            delay_samples: linear.delay_samples,
            taps: &linear.taps,
            sections: linear.sections.iter().map(|s| SectionEntry::new(s, rate)).collect(),
            rest_gain: linear.rest_gain,
            offset: realisation.model.offset,
            moves_half_way: realisation.joins_means,
            band_hz: [linear.band_hz.0, linear.band_hz.1],
            frequency_error: linear.frequency_error,
            reference_gain: linear.reference_gain,
            weights_over_gain: linear.amplification(),
            batch_difference_largest: found.verification.largest,
            batch_difference_rms: found.verification.rms,
            range: found.verification.range,
            output_unit: &found.units.1,
            nanoseconds_per_sample: found.nanoseconds,
        }
    }
}
