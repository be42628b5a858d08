//! `hysteron frequency-response`: structures fitted to a measured frequency response, and compared.

mod text;

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::IdentifyError;
use hysteron_identify::frequency_response::empirical::{
    EmpiricalOptions, EmpiricalResponse, empirical_response,
};
use hysteron_identify::frequency_response::{Explained, Family, FrequencyResponse, POOR, Weighting, compare};
use hysteron_io::{IoError, ResponseOptions, read_frequency_response, read_record};
use hysteron_model::Model;
use hysteron_report::frequency_response::page;
use hysteron_report::number::significant;

use crate::advice;
use crate::choices::one_of;
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::numbers::positive;
use crate::output::{self, OutFile};
use crate::outputs::Outputs;
use crate::result_flags::ResultFlags;

/// Fit structures to a measured frequency response, or to records of periodic multisines, and compare their
/// errors.
#[derive(Args)]
#[command(
    after_help = "A frequency response has columns such as f_Hz,re,im or f_Hz,magnitude_dB,phase_deg; points \
    are weighted by a column std where there is one, else by relative error. Several responses in one file \
    (stage_re,stage_im,ampV_re,…) are chosen by name. Records of one multisine (same lines, other phases) \
    give the response, its noise and its distortion.\n\n\
    Example: hysteron frequency-response frf.csv --response stage --over ampV --band 1:30 --report \
    frf.html\n\
    Example: hysteron frequency-response run1.csv run2.csv run3.csv --structure modes -o model.json"
)]
pub struct FrequencyResponseCommand {
    /// One file with a frequency response, or records of periodic multisines
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,

    /// Structure to fit (repeatable) [default: the structures usual for this kind of response]
    #[arg(long = "structure", value_parser = one_of(Family::ALL, Family::name, Family::summary))]
    structures: Vec<Family>,

    /// Number of modes [default: as many as the response supports]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=20))]
    modes: Option<u8>,

    /// Frequency band to fit, in Hz
    #[arg(long, value_name = "LOW:HIGH", value_parser = band)]
    band: Option<(f64, f64)>,

    /// Response to fit, where the file has several
    #[arg(long, value_name = "NAME")]
    response: Option<String>,

    /// Response of the same file to divide by, e.g. the amplifier's
    #[arg(long, value_name = "NAME")]
    over: Option<String>,

    /// Unit of the response, where the file does not give it, e.g. um_per_V
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,

    /// Records: length of a period in seconds [default: detected from the input]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    period: Option<f64>,

    /// Records: settling periods discarded at the start of each [default: until the output has settled]
    #[arg(long, value_name = "N")]
    settling: Option<usize>,

    /// Model file to write: the structure with the lowest AIC among those that a model file can hold
    #[arg(short, long = "output-model", value_name = "MODEL.json")]
    out: Option<OutFile>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    columns: ColumnFlags,
}

impl FrequencyResponseCommand {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(path) = &self.out {
            output::check_file("the model", path)?;
        }
        self.result.check()?;
        let (measured, empirical) = self.measured()?;
        let response = self.prepared(measured)?;
        let weighting = Weighting::of(&response);
        let families = self.families(&response);
        let candidates = compare(&response, weighting, &families, self.modes.map(usize::from))
            .map_err(|e| Failure::new("cannot fit the frequency response").because(e))?;
        let found = Explained { response, empirical, candidates };
        let mut outputs = Outputs::default();
        let written = self.out.as_deref().map(|path| add_model(&mut outputs, path, &found)).transpose()?;
        self.result.add(&mut outputs, || page(&found, &maker()))?;
        if let Some(text) = written {
            outputs.tell(text);
        }
        outputs.finish()?;
        if self.result.json { console::json(&found) } else { console::result(&text::text(&found)) }
    }

    fn families(&self, response: &FrequencyResponse) -> Vec<Family> {
        if self.structures.is_empty() {
            return Family::for_response(response);
        }
        let mut families: Vec<Family> = Vec::new();
        for family in &self.structures {
            if !families.contains(family) {
                families.push(*family);
            }
        }
        families
    }

    /// The response of a file, or that of the records.
    fn measured(&self) -> Result<(FrequencyResponse, Option<EmpiricalResponse>), Failure> {
        if let [file] = self.files.as_slice()
            && self.is_response(file)
        {
            let options = ResponseOptions {
                response: self.response.clone(),
                over: self.over.clone(),
                max_bytes: Some(self.columns.options().max_bytes),
            };
            let response = read_frequency_response(file, &options).map_err(|e| {
                Failure::new(format!("cannot read the frequency response {}", file.display()))
                    .because(&e)
                    .advised(e.advice())
            })?;
            return Ok((response, None));
        }
        if self.response.is_some() || self.over.is_some() {
            return Err(Failure::usage(
                "--response and --over choose among the columns of one file with a frequency response; these \
                 files are records",
            ));
        }
        let records = self.columns.read_all(&self.files)?;
        let options = EmpiricalOptions { period_s: self.period, settling_periods: self.settling };
        let found = empirical_response(&records, &options).map_err(|e| {
            let play = "play a multisine (hysteron excite multisine) of at least two periods, and again with \
                        other seeds to distinguish distortion from noise";
            let flags = e.advice().map_or_else(String::new, |a| format!("; {}", advice::in_flags(&a)));
            Failure::new("cannot take a frequency response from the records")
                .because(&e)
                .hint(format!("{play}{flags}"))
        })?;
        Ok((found.response.clone(), Some(found)))
    }

    fn is_response(&self, file: &Path) -> bool {
        let named = self.response.is_some() || self.over.is_some();
        named || matches!(read_record(file, &self.columns.options()), Err(IoError::FrequencyResponse { .. }))
    }

    /// Restricts the response to the band and applies the given unit.
    fn prepared(&self, mut response: FrequencyResponse) -> Result<FrequencyResponse, Failure> {
        if let Some(unit) = &self.unit {
            response.unit.clone_from(unit);
        }
        let above_noise = response.band_above_noise();
        let Some((low, high)) = self.band.or(above_noise) else { return Ok(response) };
        if self.band.is_none() {
            let (lowest, highest) = response.range_hz();
            console::note(&format!(
                "outside of {} to {} Hz the points scatter by more than 30 % of their value: left out as \
                 noise (--band {lowest}:{highest} takes them all)",
                significant(low, 4),
                significant(high, 4)
            ));
        }
        let whole = response.range_hz();
        let part = response.band(low, high);
        if part.is_empty() {
            return Err(Failure::new(format!("no point of the response lies between {low} and {high} Hz"))
                .because(format!("its points lie between {} and {} Hz", whole.0, whole.1)));
        }
        Ok(part)
    }
}

/// Adds the candidate of lowest AIC that a model file can hold; returns a message with its limitations.
fn add_model(outputs: &mut Outputs, path: &Path, found: &Explained) -> Result<String, Failure> {
    let failure = || Failure::new(format!("cannot write the model {}", path.display()));
    let written = found.model_file(&maker()).map_err(|e| match e {
        IdentifyError::Hysteresis(_) => failure().because(e),
        e => failure().because(e).hint("fit another structure, e.g. --structure fractional"),
    })?;
    let model = Model::try_from(written.file).map_err(|e| failure().because(e))?;
    outputs.add_model(path, &model)?;
    let start = if written.is_unbounded_at_rest {
        " Its gain at zero frequency is infinite (a power law): simulate it from 0 V (--rest-voltage 0)."
    } else {
        ""
    };
    let error = significant(100.0 * written.relative_rms, 3);
    if written.relative_rms > POOR {
        console::warning(&format!(
            "{} has an error of {error} % rms: it does not describe the response",
            written.name
        ));
    }
    Ok(format!(
        "wrote {}: {} with an error of {error} % rms; the file format asks for a hysteresis block, which is \
         v = u without hysteresis here.{start}",
        path.display(),
        written.name
    ))
}

/// Parses LOW:HIGH.
fn band(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(':').and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    match ends {
        Some((low, high)) if 0.0 <= low && low < high && high < f64::INFINITY => Ok((low, high)),
        _ => Err("expected LOW:HIGH in Hz, e.g. 1:30".into()),
    }
}
