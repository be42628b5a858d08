//! Models of several axes and their inverses as C99 source, as a `no_std` crate and as FMUs.
//!
//! All run at the constant level of a [`DecouplingLaw`], with the arithmetic of [`HeldSimulation`] and
//! [`hysteron_model::decoupling::DecouplingController`], operation by operation; in single precision after a
//! run along their own vectors.

mod golden;
mod request;
mod single;
mod tables;

use hysteron_io::NamedFile;
use hysteron_model::axes::{HeldSimulation, ScheduledModes};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingError, DecouplingLaw};
use hysteron_model::model_file::ValidRange;

use crate::c::description_comment;
use crate::error::ExportError;
use crate::escape::{c_comment, rust_comment, toml_string};
use crate::fmu::{self, AxesUnit, InverseOfAxes};
use crate::form::Means;
use crate::number::Precision;
use crate::origin::Origin;
use crate::saved;
use crate::subject::{check_name, range_in_words, significant};
use crate::template::Filling;
use golden::Golden;
pub use request::{AxesExportRequest, AxesExported, export_axes};
use tables::{Language, Limited, Tables};

const HEADER: &str = include_str!("../../templates/c/axes_top.h");
const MODEL: &str = concat!(
    include_str!("../../templates/c/axes_model.c"),
    include_str!("../../templates/c/axes_forward.c"),
    include_str!("../../templates/c/saved.c")
);
const INVERSE: &str = concat!(
    include_str!("../../templates/c/axes_model.c"),
    include_str!("../../templates/c/axes_inverse.c"),
    include_str!("../../templates/c/saved.c")
);
const SELFTEST: &str = include_str!("../../templates/c/axes_selftest.c");
const LOOP: &str = include_str!("../../templates/c/axes_loop.c");
const RUST_MODEL: &str = include_str!("../../templates/rust/axes.rs");
const RUST_INVERSE: &str = include_str!("../../templates/rust/axes_inverse.rs");
const RUST_SAVED: &str = include_str!("../../templates/rust/axes_saved.rs");
const RUST_SELFTEST: &str = include_str!("../../templates/rust/axes_selftest.rs");

/// Remaining share of a move at which the stage counts as settled.
const SETTLED: f64 = 1e-3;

/// A model of several axes to export, at the rate and level of a law.
#[derive(Clone, Debug)]
pub struct AxesSubject {
    name: String,
    title: Option<String>,
    precision: Precision,
    input_unit: String,
    output_unit: String,
    law: DecouplingLaw,
    limits: Vec<Limits>,
    origin: Origin,
    /// Names of the actuators and of the axes, where the model has them.
    channels: (Vec<String>, Vec<String>),
    range: Option<ValidRange>,
}

impl AxesSubject {
    /// The model of a law, with the limits of its actuators, under a name; `title`: its name for people;
    /// `units`: of inputs and outputs.
    ///
    /// # Errors
    /// [`ExportError::Name`], [`ExportError::Decoupling`] for limits that do not fit.
    pub fn new(
        name: &str,
        title: Option<&str>,
        units: (&str, &str),
        law: DecouplingLaw,
        limits: Vec<Limits>,
    ) -> Result<Self, ExportError> {
        check_name(name)?;
        law.controller(&limits)?;
        let (input_unit, output_unit) = (units.0.to_owned(), units.1.to_owned());
        Ok(Self {
            name: name.to_owned(),
            title: title.map(str::to_owned),
            precision: Precision::F64,
            input_unit,
            output_unit,
            law,
            limits,
            origin: Origin::made(None),
            channels: Default::default(),
            range: None,
        })
    }

    /// The same in this number type.
    #[must_use]
    pub fn in_precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// The same, identified in this range.
    #[must_use]
    pub fn identified_in(self, range: Option<ValidRange>) -> Self {
        Self { range, ..self }
    }

    /// The law.
    pub fn law(&self) -> &DecouplingLaw {
        &self.law
    }

    fn model(&self) -> &ScheduledModes {
        &self.law.held.model
    }

    fn description(&self, inverse: bool, golden: &Golden) -> Vec<String> {
        let (law, model) = (&self.law, self.model());
        let title = self.title.as_deref().map(|t| format!(" ({t})")).unwrap_or_default();
        let (input, output) = (&self.input_unit, &self.output_unit);
        let what = if inverse {
            format!(
                "{}_inverse{title}: the drives of {} actuators in {input} for the references of {} axes in \
                 {output}.",
                self.name, model.inputs, model.outputs
            )
        } else {
            format!(
                "{}{title}: {} actuators in {input}, {} axes in {output}.",
                self.name, model.inputs, model.outputs
            )
        };
        let mut lines = vec![
            what,
            format!(
                "{} Hz, {} precision. Voltages are held from sample to sample.",
                significant(model.sample_rate_hz),
                if self.precision == Precision::F32 { "single" } else { "double" }
            ),
            format!(
                "{} modes and {} lags, at the level of {} {input} rms, at which it holds; it does not \
                 move with the drive.",
                law.held.own_modes,
                model.inputs,
                significant(law.level.clamp(model.level.lowest, model.level.highest))
            ),
        ];
        lines.splice(2..2, self.origin.lines());
        for (what, names) in [("Actuators", &self.channels.0), ("Axes", &self.channels.1)] {
            let numbered: Vec<String> =
                names.iter().enumerate().map(|(k, name)| format!("{name} [{k}]")).collect();
            if !numbered.is_empty() {
                lines.push(format!("{what}: {}.", numbered.join(", ")));
            }
        }
        lines.push(range_in_words(self.range.as_ref(), input));
        let identified = &model.level;
        lines.push(format!(
            "Its records had levels of {} to {} {input} rms.",
            significant(identified.lowest),
            significant(identified.highest)
        ));
        if law.held.error > 0.0 {
            lines.push(format!(
                "At this rate the linear response of the model file is matched to {} rms, by {} pairs of poles \
                 beside the modes.",
                significant(law.held.error),
                model.modes - law.held.own_modes
            ));
        }
        if let Some(share) = golden.departure {
            lines.push(format!(
                "Along the vectors of its self-test single precision departs from double by {} % of the \
                 range.",
                significant(100.0 * share)
            ));
        }
        if inverse {
            for (k, Limits { low, high, slew_v_per_s }) in self.limits.iter().enumerate() {
                let slew = if slew_v_per_s.is_finite() {
                    format!(", at most {} {input}/s", significant(*slew_v_per_s))
                } else {
                    String::new()
                };
                lines.push(format!(
                    "Voltage [{k}]: {} to {} {input}{slew}.",
                    significant(*low),
                    significant(*high)
                ));
            }
            lines.push(format!(
                "Follows up to {} Hz; the references are known {} samples ahead, beyond which they are taken \
                 to stay.",
                significant(law.bandwidth_hz),
                law.preview
            ));
        }
        lines
    }

    fn filling(&self, inverse: bool, language: Language, golden: &Golden) -> Filling {
        let precision = self.precision;
        let (law, model) = (&self.law, self.model());
        let simulation = HeldSimulation::new(model.clone(), law.state);
        let name = if inverse { format!("{}_inverse", self.name) } else { self.name.clone() };
        let plays = model.feedback.as_ref().map_or(0, |f| f.drive.radii.len());
        let mut tables = Tables::new(language, precision);
        // In Rust the inverse runs the model of the crate.
        if !(inverse && language == Language::Rust) {
            tables.of_model(model, law.state);
        }
        let limits = self.limited();
        if inverse {
            tables.of_law(law, &limits);
        }
        let comment = |text: &str| match language {
            Language::C => c_comment(text),
            Language::Rust => rust_comment(text),
        };
        let description = self.description(inverse, golden);
        let mut filling = Filling::new(precision);
        filling
            .key("NAME", name.to_ascii_uppercase())
            .key("name", name)
            .key("crate", &self.name)
            .key("real", precision.c_type())
            .key("float", precision.name())
            .key("WORD", if precision == Precision::F32 { "u64::from(x.to_bits())" } else { "x.to_bits()" })
            .key("BACK", if precision == Precision::F32 { "word as u32" } else { "word" })
            .key(
                "DESCRIPTION",
                match language {
                    Language::C => description_comment(&description),
                    Language::Rust => {
                        let line = |line: &String| format!("//! {}", rust_comment(line));
                        description.iter().map(line).collect::<Vec<_>>().join("\n")
                    }
                },
            )
            .key("RATE", language.literal(precision, model.sample_rate_hz))
            .key("INPUT_UNIT", comment(&self.input_unit))
            .key("OUTPUT_UNIT", comment(&self.output_unit))
            .key("N_INPUTS", model.inputs)
            .key("N_OUTPUTS", model.outputs)
            .key("N_MODES", model.modes)
            .key("N_PLAYS", plays)
            .key("N_STEPS", model.steps)
            .key(
                "N_SETTLES",
                match language {
                    Language::C => format!("{}L", simulation.settling_steps()),
                    Language::Rust => simulation.settling_steps().to_string(),
                },
            )
            .key("N_PREVIEW", law.preview)
            .key("SMOOTHING", language.literal(precision, law.smoothing))
            .key("TABLES", tables.text())
            .flag("saves", true)
            .flag("inverse", inverse)
            .flag("range", !inverse && self.range.is_some())
            .flag("strains", model.feedback.is_some())
            .flag("plays", plays > 0);
        if let Some(range) = &self.range {
            let literal = |x: f64| match language {
                Language::C => format!("({})", precision.c_literal(x)),
                Language::Rust => precision.rust_literal(x),
            };
            filling.key("RANGE_LOW", literal(range.input.low)).key("RANGE_HIGH", literal(range.input.high));
        }
        if inverse {
            let row = |of: fn(&Limited) -> f64| {
                language.row(precision, &limits.iter().map(of).collect::<Vec<f64>>())
            };
            filling
                .key("LIMITS_LOW", row(|l| l.low))
                .key("LIMITS_HIGH", row(|l| l.high))
                .key("LIMITS_STEP", row(|l| l.step));
        }
        filling
    }

    /// Lowest and highest voltage of each actuator in the source.
    fn ranges(&self) -> Vec<[f64; 2]> {
        self.limited().iter().map(|l| [l.low, l.high]).collect()
    }

    /// Limits of each actuator as the source has them.
    fn limited(&self) -> Vec<Limited> {
        let rate = self.model().sample_rate_hz;
        self.limits.iter().map(|limits| Limited::new(limits, rate, self.precision)).collect()
    }

    /// What is packed as an FMU.
    fn unit(&self, inverse: bool) -> Result<AxesUnit, ExportError> {
        let golden = if inverse { self.golden_inverse()? } else { self.golden()? };
        let Core { name, filling, files } = self.core(inverse, &golden)?;
        let of_inverse = || {
            let ranges = self.ranges();
            let rest_voltages: Vec<f64> =
                ranges.iter().map(|[low, high]| 0.0_f64.max(*low).min(*high)).collect();
            let mut simulation = HeldSimulation::new(self.model().clone(), self.law.state);
            simulation.rest_at(&rest_voltages);
            let rest_displacements = simulation.output().to_vec();
            InverseOfAxes { preview: self.law.preview, ranges, rest_voltages, rest_displacements }
        };
        Ok(AxesUnit {
            name,
            description: self.description(inverse, &golden),
            filling,
            files,
            sample_rate_hz: self.model().sample_rate_hz,
            units: [self.input_unit.clone(), self.output_unit.clone()],
            inputs: self.model().inputs,
            outputs: self.model().outputs,
            inverse: inverse.then(of_inverse),
        })
    }

    /// The C source without its self-test.
    fn core(&self, inverse: bool, golden: &Golden) -> Result<Core, ExportError> {
        let mut filling = self.filling(inverse, Language::C, golden);
        let name = filling.text("name").to_owned();
        let source = if inverse { INVERSE } else { MODEL };
        let sha256 = &self.origin.model_sha256;
        let files = saved::header_and_source(&mut filling, self.precision, (HEADER, source), sha256)?;
        Ok(Core { name, filling, files })
    }

    /// Samples to wait after a move until a thousandth of it is left, and a comment on them.
    fn settles(&self) -> (usize, String) {
        let model = self.model();
        let steps = model.settling_steps(self.law.state, -SETTLED.ln());
        let samples = steps.div_ceil(model.steps);
        let seconds = significant(samples as f64 / model.sample_rate_hz);
        (samples, format!("Samples to wait after a move, {seconds} s: {SETTLED} of the response remains."))
    }

    fn c_files(&self, inverse: bool, golden: &Golden) -> Result<Vec<NamedFile>, ExportError> {
        let Core { name, mut filling, mut files } = self.core(inverse, golden)?;
        golden.fill(&mut filling, Language::C, self.precision);
        files.push(NamedFile::new(format!("{name}_selftest.c"), filling.fill(SELFTEST)?));
        if inverse {
            let (samples, words) = self.settles();
            filling.key("SETTLES", samples).key("SETTLES_IN_WORDS", words);
            files.push(NamedFile::new(format!("{name}_loop.c"), filling.fill(LOOP)?));
        }
        Ok(files)
    }

    /// Sets the mark of saved states of a source.
    fn mark_saved(&self, filling: &mut Filling, source: &str) -> Result<(), ExportError> {
        filling.key("MARK", "0");
        let text = filling.clone().key("DESCRIPTION", "").fill(source)?;
        let sums = [&text, env!("CARGO_PKG_VERSION"), &self.origin.model_sha256];
        filling.key("MARK", format!("0x{:016x}", saved::mark(sums.into_iter())));
        Ok(())
    }
}

/// The C source of a model of several axes or its inverse, and what it was filled with.
struct Core {
    name: String,
    filling: Filling,
    files: Vec<NamedFile>,
}

/// The model as C99: `NAME.h`, `NAME.c`, and `NAME_selftest.c` with golden vectors.
///
/// # Errors
/// [`ExportError::Still`] where no axis moves.
pub fn axes_files(subject: &AxesSubject) -> Result<Vec<NamedFile>, ExportError> {
    subject.c_files(false, &subject.golden()?)
}

/// The inverse as C99: `NAME_inverse.h`, `NAME_inverse.c`, `NAME_inverse_selftest.c` with golden vectors, and
/// `NAME_inverse_loop.c`, a loop around it.
///
/// # Errors
/// [`ExportError::Still`] where no voltage moves, [`ExportError::Decoupling`].
pub fn axes_inverse_files(subject: &AxesSubject) -> Result<Vec<NamedFile>, ExportError> {
    subject.c_files(true, &subject.golden_inverse()?)
}

/// The model, and its inverse where `inverse`, as a `no_std` crate that depends on nothing: `Cargo.toml`,
/// `src/lib.rs`, `src/inverse.rs`, and tests with golden vectors.
///
/// # Errors
/// Those of [`axes_files`] and [`axes_inverse_files`].
pub fn axes_rust_files(subject: &AxesSubject, inverse: bool) -> Result<Vec<NamedFile>, ExportError> {
    let manifest = format!(
        "# Written by hysteron export {}.\n[package]\nname = {}\nversion = \"0.1.0\"\nedition = \
         \"2024\"\npublish = false\n\n[dependencies]\n\n\
         # Not part of any workspace around it.\n[workspace]\n",
        env!("CARGO_PKG_VERSION"),
        toml_string(&subject.name)
    );
    let golden = subject.golden()?;
    let mut filling = subject.filling(false, Language::Rust, &golden);
    filling.flag("has_inverse", inverse);
    subject.mark_saved(&mut filling, RUST_MODEL)?;
    let mut files = vec![
        NamedFile::new("Cargo.toml", manifest),
        NamedFile::new("src/lib.rs", filling.fill(RUST_MODEL)?),
        NamedFile::new("src/saved.rs", RUST_SAVED),
    ];
    golden.fill(&mut filling, Language::Rust, subject.precision);
    filling.key("type", "Model").key("PLACE", "Model");
    files.push(NamedFile::new("tests/selftest.rs", filling.fill(RUST_SELFTEST)?));
    if inverse {
        let golden = subject.golden_inverse()?;
        let mut filling = subject.filling(true, Language::Rust, &golden);
        subject.mark_saved(&mut filling, RUST_INVERSE)?;
        files.push(NamedFile::new("src/inverse.rs", filling.fill(RUST_INVERSE)?));
        golden.fill(&mut filling, Language::Rust, subject.precision);
        filling.key("type", "Inverse").key("PLACE", "inverse::Inverse");
        files.push(NamedFile::new("tests/inverse_selftest.rs", filling.fill(RUST_SELFTEST)?));
    }
    Ok(files)
}

/// The model, and its inverse where `inverse`, as FMUs of both versions, `NAME_fmi2.fmu` and the like, each
/// with a variable for every actuator and axis.
///
/// # Errors
/// Those of [`axes_files`] and [`axes_inverse_files`]; of a compiler; [`ExportError::Stopped`] by the
/// listener.
pub fn axes_fmu_files(
    subject: &AxesSubject,
    inverse: bool,
    means: Means<'_>,
) -> Result<Vec<NamedFile>, ExportError> {
    let Means { compiler, listener } = means;
    let of_model = if inverse { 0.5 } else { 1.0 };
    let mut files = fmu::axes_files(&subject.unit(false)?, (compiler, listener.part(0.0, of_model)))?;
    if inverse {
        files.extend(fmu::axes_files(&subject.unit(true)?, (compiler, listener.part(of_model, 1.0)))?);
    }
    Ok(files)
}

impl From<DecouplingError> for ExportError {
    fn from(error: DecouplingError) -> Self {
        Self::Decoupling(Box::new(error))
    }
}
