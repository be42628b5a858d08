//! Models of several axes and their inverses as C99 source.
//!
//! Both run at the constant level of a [`DecouplingLaw`], in double precision, with the arithmetic of
//! [`HeldSimulation`] and [`DecouplingController`], operation by operation.

use hysteron_io::NamedFile;
use hysteron_model::axes::{HeldSimulation, ScheduledModes};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingController, DecouplingError, DecouplingLaw};

use crate::c::{description_comment, rows};
use crate::error::ExportError;
use crate::escape::c_comment;
use crate::number::Precision;
use crate::subject::{check_name, significant};
use crate::template::Filling;

const HEADER: &str = include_str!("../templates/c/axes_top.h");
const MODEL: &str =
    concat!(include_str!("../templates/c/axes_model.c"), include_str!("../templates/c/axes_forward.c"));
const INVERSE: &str =
    concat!(include_str!("../templates/c/axes_model.c"), include_str!("../templates/c/axes_inverse.c"));
const SELFTEST: &str = include_str!("../templates/c/axes_selftest.c");

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
                number(model.sample_rate_hz)
            ),
            format!("Written by hysteron export {}.", env!("CARGO_PKG_VERSION")),
            format!(
                "{} modes and {} lags, at the level of {} {input} rms, at which it holds; it does not \
                 move with the drive.",
                model.modes,
                model.inputs,
                number(law.level)
            ),
        ];
        if law.held.error > 0.0 {
            lines.push(format!(
                "At this rate the linear response of the model file is matched to {} rms.",
                number(law.held.error)
            ));
        }
        if inverse {
            lines.push(format!(
                "Follows up to {} Hz; the references are known {} samples ahead, beyond which they are taken \
                 to stay.",
                number(law.bandwidth_hz),
                law.preview
            ));
        }
        lines
    }

    fn filling(&self, inverse: bool) -> Filling {
        let (law, model) = (&self.law, self.model());
        let simulation = HeldSimulation::new(model.clone(), law.state);
        let name = if inverse { format!("{}_inverse", self.name) } else { self.name.clone() };
        let plays = model.feedback.as_ref().map_or(0, |f| f.drive.radii.len());
        let mut tables = tables_of(model, law.state);
        if inverse {
            tables += &self.tables_of_law();
        }
        let mut filling = Filling::new(PRECISION);
        filling
            .key("NAME", name.to_ascii_uppercase())
            .key("name", name)
            .key("real", PRECISION.c_type())
            .key("DESCRIPTION", description_comment(&self.description(inverse)))
            .key("RATE", literal(model.sample_rate_hz))
            .key("INPUT_UNIT", c_comment(&self.input_unit))
            .key("OUTPUT_UNIT", c_comment(&self.output_unit))
            .key("N_INPUTS", model.inputs)
            .key("N_OUTPUTS", model.outputs)
            .key("N_MODES", model.modes)
            .key("N_PLAYS", plays)
            .key("N_STEPS", model.steps)
            .key("N_SETTLES", format!("{}L", simulation.settling_steps()))
            .key("N_PREVIEW", law.preview)
            .key("SMOOTHING", literal(law.smoothing))
            .key("TABLES", tables)
            .flag("inverse", inverse)
            .flag("strains", model.feedback.is_some())
            .flag("plays", plays > 0);
        filling
    }

    fn tables_of_law(&self) -> String {
        let (law, model) = (&self.law, self.model());
        let (n, m, states) = (model.inputs, model.outputs, model.states());
        let mut out = String::new();
        let mut table = |comment: &str, name: &str, width: usize, numbers: &[f64]| {
            out += &matrix(comment, name, width, numbers);
        };
        table("The law: gains on the states.", "LAW_STATES", states, &law.states);
        table("On the last voltages.", "LAW_LAST", n, &law.recent[0]);
        table("On those before.", "LAW_BEFORE", n, &law.recent[1]);
        table("On the strains.", "LAW_STRAINS", n, &law.strains);
        table("On their change in a sample.", "LAW_RATES", n, &law.strain_rates);
        let references: Vec<String> =
            law.reference.iter().map(|gains| format!("    {{{}}}", braces(gains, m))).collect();
        out += &format!(
            "/* On the references, from the present one to the end of the preview. */\nstatic const real \
             LAW_REFERENCES[{}][{n}][{m}] = {{\n{}\n}};\n",
            law.reference.len(),
            references.join(",\n")
        );
        let step = |limit: &Limits| {
            let step = limit.slew_v_per_s / model.sample_rate_hz;
            if step.is_finite() { step } else { f64::MAX }
        };
        for (comment, name, of) in [
            ("Least voltages.", "LOW", &(|l: &Limits| l.low) as &dyn Fn(&Limits) -> f64),
            ("Largest voltages.", "HIGH", &|l: &Limits| l.high),
            ("Largest changes from one sample to the next.", "STEP", &step),
        ] {
            out += &list(comment, name, &self.limits.iter().map(of).collect::<Vec<_>>());
        }
        out
    }

    fn files(&self, inverse: bool, golden: &Golden) -> Result<Vec<NamedFile>, ExportError> {
        let mut filling = self.filling(inverse);
        let name = filling.text("name").to_owned();
        let source = if inverse { INVERSE } else { MODEL };
        let mut files = vec![
            NamedFile::new(format!("{name}.h"), filling.fill(HEADER)?),
            NamedFile::new(format!("{name}.c"), filling.fill(source)?),
        ];
        let lines = |lists: &[Vec<f64>]| {
            let line = |list: &Vec<f64>| format!("{{{}}}", joined(list));
            rows(lists.iter().map(line))
        };
        filling
            .key("VECTORS", golden.given.len())
            .key("HOLD", golden.hold)
            .key("N_GIVEN", golden.given.first().map_or(0, Vec::len))
            .key("N_FOUND", golden.wanted.first().map_or(0, Vec::len))
            .key("GIVEN", lines(&golden.given))
            .key("WANTED", lines(&golden.wanted))
            .key("TOLERANCE", literal(golden.tolerance));
        files.push(NamedFile::new(format!("{name}_selftest.c"), filling.fill(SELFTEST)?));
        Ok(files)
    }
}

/// The model as C99: `NAME.h`, `NAME.c`, and `NAME_selftest.c` with golden vectors.
///
/// # Errors
/// [`ExportError::Still`] where no axis moves.
pub fn axes_files(subject: &AxesSubject) -> Result<Vec<NamedFile>, ExportError> {
    let mut simulation = HeldSimulation::new(subject.model().clone(), subject.law.state);
    let drive = |k: usize, i: usize| {
        let Limits { low, high, .. } = subject.limits[i];
        0.5 * (low + high) + 0.4 * (high - low) * wave(k, i)
    };
    let given: Vec<Vec<f64>> =
        (0..VECTORS).map(|k| (0..subject.limits.len()).map(|i| drive(k, i)).collect()).collect();
    let wanted = given
        .iter()
        .map(|u| {
            simulation.advance();
            simulation.apply(u).to_vec()
        })
        .collect();
    subject.files(false, &Golden::new(given, wanted, 1)?)
}

/// The inverse as C99: `NAME_inverse.h`, `NAME_inverse.c`, and `NAME_inverse_selftest.c` with golden vectors.
///
/// # Errors
/// [`ExportError::Still`] where no voltage moves, [`ExportError::Decoupling`].
pub fn axes_inverse_files(subject: &AxesSubject) -> Result<Vec<NamedFile>, ExportError> {
    let mut controller: DecouplingController = subject.law.controller(&subject.limits)?;
    let rest = controller.output().to_vec();
    // The motion that a good part of the limits moves each axis by.
    let mut simulation = HeldSimulation::new(subject.model().clone(), subject.law.state);
    let middle: Vec<f64> = subject.limits.iter().map(|l| 0.5 * (l.low + l.high)).collect();
    let top: Vec<f64> = subject.limits.iter().map(|l| 0.75 * l.high + 0.25 * l.low).collect();
    simulation.rest_at(&middle);
    let from = simulation.output().to_vec();
    simulation.rest_at(&top);
    let strokes: Vec<f64> = simulation.output().iter().zip(&from).map(|(a, b)| (a - b).abs()).collect();
    let reference = |k: usize, m: usize| rest[m] + 0.5 * strokes[m] * wave(k, m);
    let given: Vec<Vec<f64>> =
        (0..VECTORS).map(|k| (0..rest.len()).map(|m| reference(k, m)).collect()).collect();
    let hold = subject.law.preview.div_ceil(WITHIN).max(1);
    let wanted = given
        .iter()
        .map(|r| {
            (1..hold).for_each(|_| {
                controller.step(r);
            });
            controller.step(r).to_vec()
        })
        .collect();
    subject.files(true, &Golden::new(given, wanted, hold)?)
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
}

fn tables_of(model: &ScheduledModes, s: f64) -> String {
    let (at, n, states) = (model.at(s), model.inputs, model.states());
    let mut out = list("Poles, real and imaginary parts; then the lags.", "TRANSITION", &at.transition);
    out += &matrix("States on voltages.", "INPUT", n, &model.input);
    out += &matrix("States on strains.", "STRAIN_INPUT", n, &model.strain_input);
    out += &matrix("Outputs on states.", "OUTPUT", states, &at.output);
    out += &matrix("Outputs on voltages.", "FEEDTHROUGH", n, &at.feedthrough);
    out += &matrix("Outputs on strains.", "STRAIN_FEEDTHROUGH", n, &model.strain_feedthrough);
    let Some(feedback) = &model.feedback else { return out };
    let signals = [feedback.drive_rows.clone(), feedback.stress_rows.clone()].concat();
    out += &matrix("Free strokes, then stresses, on states and voltages.", "ROWS", states + n, &signals);
    let laws: Vec<_> = std::iter::repeat_n(&feedback.drive, n).chain(&feedback.stress).collect();
    let all = |of: &dyn Fn(usize) -> Vec<f64>| (0..laws.len()).flat_map(of).collect::<Vec<f64>>();
    out += &matrix("Square and cube.", "POWERS", 2, &all(&|i| laws[i].coefficients[..2].to_vec()));
    out += &list("Mean squares.", "VARIANCE", &all(&|i| vec![laws[i].variance]));
    let plays = feedback.drive.radii.len();
    if plays > 0 {
        out += &matrix("Plays: weights.", "WEIGHTS", plays, &all(&|i| laws[i].coefficients[2..].to_vec()));
        out += &matrix("Radii.", "RADII", plays, &all(&|i| laws[i].radii.clone()));
        out += &matrix("Mean slopes.", "SLOPES", plays, &all(&|i| laws[i].slopes.clone()));
    }
    out
}

fn literal(x: f64) -> String {
    PRECISION.c_literal(x)
}

fn number(x: f64) -> String {
    significant(x)
}

fn joined(numbers: &[f64]) -> String {
    numbers.iter().map(|x| literal(*x)).collect::<Vec<_>>().join(", ")
}

fn braces(numbers: &[f64], width: usize) -> String {
    numbers.chunks(width).map(|row| format!("{{{}}}", joined(row))).collect::<Vec<_>>().join(", ")
}

fn list(comment: &str, name: &str, numbers: &[f64]) -> String {
    let content = rows(numbers.iter().map(|x| literal(*x)));
    format!("/* {comment} */\nstatic const real {name}[{}] = {{\n{content}\n}};\n", numbers.len())
}

fn matrix(comment: &str, name: &str, width: usize, numbers: &[f64]) -> String {
    let content: Vec<String> = numbers
        .chunks(width)
        .map(|row| format!("    {{\n{}\n    }}", rows(row.iter().map(|x| literal(*x)))))
        .collect();
    format!(
        "/* {comment} */\nstatic const real {name}[{}][{width}] = {{\n{}\n}};\n",
        numbers.len() / width,
        content.join(",\n")
    )
}

impl From<DecouplingError> for ExportError {
    fn from(error: DecouplingError) -> Self {
        Self::Decoupling(Box::new(error))
    }
}
