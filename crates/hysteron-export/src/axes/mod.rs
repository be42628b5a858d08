//! Models of several axes and their inverses as C99 source and as a `no_std` crate.
//!
//! Both run at the constant level of a [`DecouplingLaw`], in double precision, with the arithmetic of
//! [`HeldSimulation`] and [`DecouplingController`], operation by operation.

mod request;
mod tables;

use hysteron_io::NamedFile;
use hysteron_model::axes::{HeldSimulation, ScheduledModes};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingController, DecouplingError, DecouplingLaw};

use crate::c::{description_comment, rows};
use crate::error::ExportError;
use crate::escape::{c_comment, rust_comment, toml_string};
use crate::number::Precision;
use crate::origin::Origin;
use crate::saved;
use crate::subject::{check_name, significant};
use crate::template::Filling;
pub use request::{AxesExportRequest, export_axes};
use tables::{Language, Tables, literal};

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
const RUST_MODEL: &str = include_str!("../../templates/rust/axes.rs");
const RUST_INVERSE: &str = include_str!("../../templates/rust/axes_inverse.rs");
const RUST_SAVED: &str = include_str!("../../templates/rust/axes_saved.rs");
const RUST_SELFTEST: &str = include_str!("../../templates/rust/axes_selftest.rs");

const PRECISION: Precision = Precision::F64;
/// Golden vectors; the last are steps.
const VECTORS: usize = 240;
/// Vectors that a preview is passed in.
const WITHIN: usize = 60;
/// Largest difference, as a share of the range: sums in another order.
const TOLERANCE: f64 = 1e-9;

/// A model of several axes to export, at the rate and level of a law.
#[derive(Clone, Debug)]
pub struct AxesSubject {
    name: String,
    title: Option<String>,
    input_unit: String,
    output_unit: String,
    law: DecouplingLaw,
    limits: Vec<Limits>,
    origin: Origin,
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
            input_unit,
            output_unit,
            law,
            limits,
            origin: Origin::made(None),
        })
    }

    /// The law.
    pub fn law(&self) -> &DecouplingLaw {
        &self.law
    }

    fn model(&self) -> &ScheduledModes {
        &self.law.held.model
    }

    fn description(&self, inverse: bool) -> Vec<String> {
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
                "{} Hz, double precision. Voltages are held from sample to sample.",
                significant(model.sample_rate_hz)
            ),
            format!(
                "{} modes and {} lags, at the level of {} {input} rms, at which it holds; it does not \
                 move with the drive.",
                model.modes,
                model.inputs,
                significant(law.level)
            ),
        ];
        lines.splice(2..2, self.origin.lines());
        if law.held.error > 0.0 {
            lines.push(format!(
                "At this rate the linear response of the model file is matched to {} rms.",
                significant(law.held.error)
            ));
        }
        if inverse {
            lines.push(format!(
                "Follows up to {} Hz; the references are known {} samples ahead, beyond which they are taken \
                 to stay.",
                significant(law.bandwidth_hz),
                law.preview
            ));
        }
        lines
    }

    fn filling(&self, inverse: bool, language: Language) -> Filling {
        let (law, model) = (&self.law, self.model());
        let simulation = HeldSimulation::new(model.clone(), law.state);
        let name = if inverse { format!("{}_inverse", self.name) } else { self.name.clone() };
        let plays = model.feedback.as_ref().map_or(0, |f| f.drive.radii.len());
        let mut tables = Tables::new(language);
        // In Rust the inverse runs the model of the crate.
        if !(inverse && language == Language::Rust) {
            tables.of_model(model, law.state);
        }
        if inverse {
            tables.of_law(law, &self.limits);
        }
        let comment = |text: &str| match language {
            Language::C => c_comment(text),
            Language::Rust => rust_comment(text),
        };
        let description = self.description(inverse);
        let mut filling = Filling::new(PRECISION);
        filling
            .key("NAME", name.to_ascii_uppercase())
            .key("name", name)
            .key("crate", &self.name)
            .key("real", PRECISION.c_type())
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
            .key("RATE", literal(model.sample_rate_hz))
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
            .key("SMOOTHING", literal(law.smoothing))
            .key("TABLES", tables.text())
            .flag("saves", true)
            .flag("inverse", inverse)
            .flag("strains", model.feedback.is_some())
            .flag("plays", plays > 0);
        filling
    }

    fn c_files(&self, inverse: bool, golden: &Golden) -> Result<Vec<NamedFile>, ExportError> {
        let mut filling = self.filling(inverse, Language::C);
        let name = filling.text("name").to_owned();
        let source = if inverse { INVERSE } else { MODEL };
        saved::fill(&mut filling, PRECISION, (HEADER, source), &[&self.origin.model_sha256])?;
        let mut files = vec![
            NamedFile::new(format!("{name}.h"), filling.fill(HEADER)?),
            NamedFile::new(format!("{name}.c"), filling.fill(source)?),
        ];
        golden.fill(&mut filling, Language::C);
        files.push(NamedFile::new(format!("{name}_selftest.c"), filling.fill(SELFTEST)?));
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

    /// Vectors of the model.
    fn golden(&self) -> Result<Golden, ExportError> {
        let mut simulation = HeldSimulation::new(self.model().clone(), self.law.state);
        let drive = |k: usize, i: usize| {
            let Limits { low, high, .. } = self.limits[i];
            0.5 * (low + high) + 0.4 * (high - low) * wave(k, i)
        };
        let given: Vec<Vec<f64>> =
            (0..VECTORS).map(|k| (0..self.limits.len()).map(|i| drive(k, i)).collect()).collect();
        let wanted = given
            .iter()
            .map(|u| {
                simulation.advance();
                simulation.apply(u).to_vec()
            })
            .collect();
        Golden::new(given, wanted, 1)
    }

    /// Vectors of the inverse.
    fn golden_inverse(&self) -> Result<Golden, ExportError> {
        let mut controller: DecouplingController = self.law.controller(&self.limits)?;
        let rest = controller.output().to_vec();
        // The motion that a good part of the limits moves each axis by.
        let mut simulation = HeldSimulation::new(self.model().clone(), self.law.state);
        let middle: Vec<f64> = self.limits.iter().map(|l| 0.5 * (l.low + l.high)).collect();
        let top: Vec<f64> = self.limits.iter().map(|l| 0.75 * l.high + 0.25 * l.low).collect();
        simulation.rest_at(&middle);
        let from = simulation.output().to_vec();
        simulation.rest_at(&top);
        let strokes: Vec<f64> = simulation.output().iter().zip(&from).map(|(a, b)| (a - b).abs()).collect();
        let reference = |k: usize, m: usize| rest[m] + 0.5 * strokes[m] * wave(k, m);
        let given: Vec<Vec<f64>> =
            (0..VECTORS).map(|k| (0..rest.len()).map(|m| reference(k, m)).collect()).collect();
        let hold = self.law.preview.div_ceil(WITHIN).max(1);
        let wanted = given
            .iter()
            .map(|r| {
                (1..hold).for_each(|_| {
                    controller.step(r);
                });
                controller.step(r).to_vec()
            })
            .collect();
        Golden::new(given, wanted, hold)
    }
}

/// The model as C99: `NAME.h`, `NAME.c`, and `NAME_selftest.c` with golden vectors.
///
/// # Errors
/// [`ExportError::Still`] where no axis moves.
pub fn axes_files(subject: &AxesSubject) -> Result<Vec<NamedFile>, ExportError> {
    subject.c_files(false, &subject.golden()?)
}

/// The inverse as C99: `NAME_inverse.h`, `NAME_inverse.c`, and `NAME_inverse_selftest.c` with golden vectors.
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
    let mut filling = subject.filling(false, Language::Rust);
    filling.flag("has_inverse", inverse);
    subject.mark_saved(&mut filling, RUST_MODEL)?;
    let mut files = vec![
        NamedFile::new("Cargo.toml", manifest),
        NamedFile::new("src/lib.rs", filling.fill(RUST_MODEL)?),
        NamedFile::new("src/saved.rs", RUST_SAVED),
    ];
    subject.golden()?.fill(&mut filling, Language::Rust);
    filling.key("type", "Model").key("PLACE", "Model");
    files.push(NamedFile::new("tests/selftest.rs", filling.fill(RUST_SELFTEST)?));
    if inverse {
        let mut filling = subject.filling(true, Language::Rust);
        subject.mark_saved(&mut filling, RUST_INVERSE)?;
        files.push(NamedFile::new("src/inverse.rs", filling.fill(RUST_INVERSE)?));
        subject.golden_inverse()?.fill(&mut filling, Language::Rust);
        filling.key("type", "Inverse").key("PLACE", "inverse::Inverse");
        files.push(NamedFile::new("tests/inverse_selftest.rs", filling.fill(RUST_SELFTEST)?));
    }
    Ok(files)
}

/// Between −1 and 1: a growing sine of its own for every channel, then steps.
fn wave(k: usize, channel: usize) -> f64 {
    let phase = (0.05 + 0.013 * channel as f64) * k as f64;
    if k < 3 * VECTORS / 4 { phase.sin() * (k as f64 / 60.0).min(1.0) } else { phase.sin().signum() * 0.8 }
}

struct Golden {
    given: Vec<Vec<f64>>,
    /// At the end of every vector.
    wanted: Vec<Vec<f64>>,
    /// Samples that a vector lasts.
    hold: usize,
    tolerance: f64,
}

impl Golden {
    fn new(given: Vec<Vec<f64>>, wanted: Vec<Vec<f64>>, hold: usize) -> Result<Self, ExportError> {
        let all = wanted.iter().flatten();
        let ends = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let span = ends.1 - ends.0;
        if !(span > 0.0 && span.is_finite()) {
            return Err(ExportError::Still { what: "output of the several axes" });
        }
        Ok(Self { given, wanted, hold, tolerance: TOLERANCE * span })
    }

    /// Sets what a self-test is filled with.
    fn fill(&self, filling: &mut Filling, language: Language) {
        let lines = |lists: &[Vec<f64>]| rows(lists.iter().map(|list| language.row(list)));
        filling
            .key("VECTORS", self.given.len())
            .key("HOLD", self.hold)
            .key("N_GIVEN", self.given.first().map_or(0, Vec::len))
            .key("N_FOUND", self.wanted.first().map_or(0, Vec::len))
            .key("GIVEN", lines(&self.given))
            .key("WANTED", lines(&self.wanted))
            .key("TOLERANCE", literal(self.tolerance));
    }
}

impl From<DecouplingError> for ExportError {
    fn from(error: DecouplingError) -> Self {
        Self::Decoupling(Box::new(error))
    }
}
