//! `hysteron invert`: the drive that makes a model's output follow a reference.

mod several;

use std::path::PathBuf;

use clap::Args;
use hysteron_identify::{ForecastDrive, Listener, drive_for};
use hysteron_io::write_record;
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::invert::{BANDWIDTH_SHARE, InverseDrive, InversionError, LastRun};
use hysteron_model::model::{Capability, ErrorForecast, InverseRequest, InverseSummary, SignalRole};
use hysteron_model::record::{Channel, Record, TimeBase, Unit};
use hysteron_model::{Advice, FindingKind};
use hysteron_numeric::display::short;
use hysteron_report::number::significant;

use crate::advice;
use crate::axes::AxesReferenceFlags;
use crate::columns::ReferenceFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::model::{Loaded, LoadedModel};
use crate::numbers::{number, positive, whole};
use crate::output::{self, OutFile};
use crate::progress;
use crate::remarks;

/// Compute the drive that makes a model's output follow a reference
#[derive(Args)]
#[command(
    after_help = "The file written holds the time, the drive, the output that the model predicts for it and \
    the reference, e.g. t_s,u_V,y_um,reference_um. The reference's sample rate is the controller's; each \
    voltage is held for one period, which the inverse takes into account, as it does the model's delay. The \
    inverse is not causal: the whole reference must be known, unless --preview or --predict-to selects the \
    law of a controller with limited preview or none.\n\n\
    The output follows up to the bandwidth; above it the inverse rolls off, so that noise and rounding of \
    the reference are not amplified. A higher bandwidth follows faster references and passes more noise.\n\n\
    Where the drive is at a limit, the rest of the reference is followed as well as possible; the number of \
    samples at a limit is printed. Exit code 1: the reference cannot be followed at all, or the model has no \
    inverse.\n\n\
    A model of several axes takes a file with the reference of every axis, in columns named as the model's \
    outputs (or --outputs), and gives the drives of all actuators, decoupled.\n\n\
    Example: hysteron invert model.json scan.csv -o drive.csv --range 0:100 --slew 20000\n\
    Example: hysteron invert mirror.json scan.csv -o drives.csv --range=-1:1,-1:1,-0.5:0.5"
)]
pub struct Invert {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// File with the reference, in the unit of the model's output
    #[arg(value_name = "REFERENCE.csv")]
    reference_file: PathBuf,

    /// File to write
    #[arg(short, long = "out", value_name = "DRIVE.csv")]
    out: OutFile,

    /// Minimum and maximum drive, or one per actuator: LOW:HIGH,LOW:HIGH… [default: the range the model was
    /// identified in]
    #[arg(
        long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true,
        value_delimiter = ',',
    )]
    range: Vec<[f64; 2]>,

    /// Maximum slew rate of the drive, in its unit per second, or one per actuator [default: none]
    #[arg(
        long, value_name = "PER_SECOND", value_parser = positive, allow_hyphen_values = true,
        value_delimiter = ',',
    )]
    slew: Vec<f64>,

    /// Level of the drive (rms) for modes that move with it [default: that of the drive found; with
    /// --preview: the highest identified]
    #[arg(long, value_name = "VOLTS", value_parser = positive, allow_hyphen_values = true)]
    level: Option<f64>,

    /// Frequency up to which the output follows, in Hz [default: a twentieth of the sample rate, for
    /// several axes at most of the rate of the model's steps]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    bandwidth: Option<f64>,

    /// Voltage at rest before the reference begins [default: the one that gives its first value]
    #[arg(
        long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true,
        conflicts_with = "periodic",
    )]
    rest_voltage: Option<f64>,

    /// Voltage at which the device was last demagnetised, before it moved to the voltage at rest [default: 0
    /// where --range contains it, as after switching on; else the voltage at rest]
    #[arg(
        long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true,
        conflicts_with = "periodic",
    )]
    virgin_voltage: Option<f64>,

    /// The reference is one or more periods of a periodic motion, as in scanning: compute the steady-state
    /// drive
    #[arg(long)]
    periodic: bool,

    /// Record (drive and measured output) of a run with the same reference, whose error corrects the next
    /// drive (iterative learning control, as in scanning)
    #[arg(long, value_name = "RUN.csv")]
    learn_from: Option<PathBuf>,

    /// Compute the drive sample by sample, as a controller does, with this preview of the reference in
    /// samples; 0: the current sample only [default: the whole reference is known; with --predict-to: 0]
    #[arg(
        long, value_name = "SAMPLES", value_parser = whole::<usize>, allow_hyphen_values = true,
        conflicts_with_all = ["periodic", "learn_from"],
    )]
    preview: Option<usize>,

    /// Compute the drive sample by sample, and predict the reference beyond the preview from its past as a
    /// random motion band-limited to this frequency
    #[arg(
        long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true,
        conflicts_with_all = ["periodic", "learn_from"],
    )]
    predict_to: Option<f64>,

    /// Correct the drive by what the device does beside its model, where the records show a device outside the
    /// model class and left-out parts of them are predicted better so
    #[arg(long, conflicts_with_all = ["preview", "predict_to", "learn_from"])]
    correct: bool,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    columns: ReferenceFlags,

    #[command(flatten)]
    axes: AxesReferenceFlags,
}

/// `LOW:HIGH`.
pub fn range(text: &str) -> Result<[f64; 2], String> {
    let wrong = || "expected LOW:HIGH, e.g. 0:100".to_owned();
    let (low, high) = text.split_once(':').ok_or_else(wrong)?;
    match (number(low.trim()), number(high.trim())) {
        (Ok(low), Ok(high)) if low < high => Ok([low, high]),
        _ => Err(wrong()),
    }
}

impl Invert {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_file("the drive", &self.out)?;
        let loaded = Loaded::read(&self.model)?;
        if loaded.model().channels().is_some() {
            return self.several_axes(&loaded);
        }
        self.refuse_flags_of_axes()?;
        let model = LoadedModel::of(loaded, Capability::Inversion)?;
        let reference = self.columns.read(&self.reference_file)?;
        let unit = model.agreed_unit(&self.reference_file, SignalRole::Reference, &reference.unit)?;
        let failure = || {
            Failure::new(format!(
                "cannot follow {} with {}",
                self.reference_file.display(),
                self.model.display()
            ))
        };
        let TimeBase::Uniform { sample_rate_hz, .. } = reference.time else {
            return Err(failure()
                .because("the reference has no uniform sample rate, which sets the controller's")
                .advised(Some(Advice::Resample)));
        };
        let remarks = model.body().remarks_on_reference(&reference.samples, sample_rate_hz);
        remarks::tell(&self.reference_file, model.model(), &remarks);
        let run = self.learn_from.as_ref().map(|path| self.columns.read_run(path)).transpose()?;
        let last = run.as_ref().map(|run| LastRun { drive: &run.u, measured: &run.y });
        let interrupt = Interrupt::listen("no drive is written")?;
        let watch = progress::watch(&interrupt);
        let teller = watch.teller();
        let listener = Listener::new(&teller);
        let found =
            drive_for(model.body(), &reference.samples, sample_rate_hz, &self.request(), last, listener);
        drop(teller);
        drop(watch);
        let input = Unit::new(&model.body().data().units.input);
        let ForecastDrive { drive, summary } = found.map_err(|e| {
            if e == InversionError::Stopped {
                return interrupt.told(Failure::new("the computation was interrupted"));
            }
            with_remedy(failure().because(e.in_units(&input, &unit)), &e)
        })?;
        self.write(reference.time, &reference.samples, &unit, input.symbol(), drive)?;
        if self.json { console::json(&summary) } else { console::result(&text(&summary)) }
    }

    fn request(&self) -> InverseRequest {
        InverseRequest {
            range: self.range.first().copied(),
            slew_per_s: self.slew.first().copied(),
            bandwidth_hz: self.bandwidth,
            periodic: self.periodic,
            rest_voltage: self.rest_voltage,
            virgin_voltage: self.virgin_voltage,
            preview: self.preview,
            predict_to_hz: self.predict_to,
            correct: self.correct,
        }
    }

    fn write(
        &self,
        time: TimeBase,
        reference: &[f64],
        unit: &Unit,
        input: &str,
        found: InverseDrive,
    ) -> Result<(), Failure> {
        let failure = || Failure::new(format!("cannot write the drive to {}", self.out.display()));
        let channels = vec![
            Channel::new("u", input, found.drive),
            Channel::new("y", unit.symbol(), found.predicted),
            Channel::new("reference", unit.symbol(), reference.to_vec()),
        ];
        let record =
            Record::new(&self.out.display().to_string(), time, channels).map_err(|e| failure().because(e))?;
        write_record(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }
}

/// The failure with what to change, in flags.
fn with_remedy(failure: Failure, error: &InversionError) -> Failure {
    match error {
        InversionError::RangeUnknown => failure.hint("e.g. --range 0:100"),
        InversionError::Begins { .. } => failure.hint(
            "change the reference's offset, widen --range, or say where the device rests with --rest-voltage \
             VOLTS",
        ),
        InversionError::Simulation(SimulationError::SampleRate { model_hz, .. }) => failure.hint(format!(
            "sample the reference at {model_hz} Hz, or identify the model without --scheme \
             grunwald-letnikov and ARX"
        )),
        InversionError::Dynamics(DynamicsError::InfiniteDcGain { .. }) => failure
            .because(
                "the model's creep is unbounded: under a periodic drive its output drifts, so there is no \
                 periodic steady state",
            )
            .hint(
                "leave --periodic out and give several periods of the reference, or identify the model with \
                 bounded creep (--creep kelvin-voigt, or --dynamics integer)",
            ),
        InversionError::Dynamics(DynamicsError::Bandwidth { .. }) => failure.hint(format!(
            "the bandwidth is {} of the sample rate unless --bandwidth HZ says otherwise",
            short(BANDWIDTH_SHARE)
        )),
        _ => failure,
    }
}

fn text(s: &InverseSummary) -> String {
    let (input, output) = (Unit::new(&s.input_unit), Unit::new(&s.output_unit));
    let mut lines = vec![match s.rest {
        Some(rest) => {
            format!("The device rests at {} {input} before the first sample.", significant(rest, 4))
        }
        None => "The reference repeats; the drive is that of its steady state.".to_owned(),
    }];
    if let Some(preview) = s.preview {
        lines.push(preview.in_words());
    }
    lines.push(format!(
        "Drive: {} to {} {input}, at most {} {input}/s, each value held for {} s.",
        significant(s.drive_low, 4),
        significant(s.drive_high, 4),
        significant(s.fastest_drive_per_s, 3),
        short(1.0 / s.sample_rate_hz)
    ));
    for (samples, what) in [(s.samples_at_range, "--range"), (s.samples_at_slew, "--slew")] {
        if samples > 0 {
            lines.push(format!("Limited by {what}: {samples} of {} samples.", s.samples));
        }
    }
    lines.push(format!(
        "Predicted error, assuming an exact model: {} {output} rms ({} % of the reference's stroke), {} \
         {output} at most.",
        significant(s.predicted_rms_error, 3),
        significant(s.predicted_rms_percent_of_stroke, 3),
        significant(s.predicted_max_error, 3)
    ));
    match &s.forecast {
        Some(forecast) => lines.extend(forecast_in_words(forecast, &output)),
        None => lines.push("The model file gives no parameter uncertainty.".to_owned()),
    }
    match (s.bandwidth_hz, s.error_at_bandwidth, s.noise_gain) {
        (Some(bandwidth), Some(error), Some(gain)) => lines.push(format!(
            "Bandwidth: {} Hz, where {} % of the reference is missing. White noise on the reference is \
             amplified {} times at the output of the hysteresis: 5 nm become {} nm.",
            significant(bandwidth, 3),
            significant(100.0 * error, 2),
            significant(gain, 2),
            significant(5.0 * gain, 2)
        )),
        _ => lines.push("The model is static: its inverse is exact at every frequency.".to_owned()),
    }
    lines.extend(s.findings.iter().map(|finding| {
        let severity = if finding.kind == FindingKind::Warning { "warning" } else { "note" };
        format!("{severity}: {}", advice::text(finding))
    }));
    lines.join("\n") + "\n"
}

/// Uncertainty of the parameters, and the error to expect on the device.
fn forecast_in_words(forecast: &ErrorForecast, output: &Unit) -> Vec<String> {
    let ErrorForecast { band_of_model, band_of_measurement, expected_rms, .. } = forecast;
    let parameters =
        format!("Parameter uncertainty: up to ± {} {output} (95 %).", significant(*band_of_model, 3));
    let device = band_of_measurement.zip(*expected_rms).map(|(band, rms)| {
        format!(
            "Expected error on the device: {} {output} rms; its 95 % band is ± {} {output} at its widest.",
            significant(rms, 3),
            significant(band, 3)
        )
    });
    std::iter::once(parameters).chain(device).collect()
}
