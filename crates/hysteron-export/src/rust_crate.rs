//! A `no_std` Rust crate.

use hysteron_model::compensator::CompensatorParts;
use hysteron_model::realise::RuntimeParts;
use hysteron_rt::{Branch, LANES, Real, StateLaw};

use crate::c::{Numbers, filling, golden_keys, rows};
use crate::closed_loop::{ClosedLoop, controller_modules};
use crate::error::ExportError;
use crate::escape::{rust_comment, toml_string};
use crate::golden::Golden;
use crate::inverse::{Inverse, golden_inverse_keys};
use crate::number::Precision;
use crate::operator::{Constant, OperatorNumbers, Table};
use crate::origin::Origin;
use crate::saved;
use crate::subject::Subject;
use crate::template::Filling;
use hysteron_io::NamedFile;

const SOURCE: &str = include_str!("../templates/rust/model.rs");
const SELFTEST: &str = include_str!("../templates/rust/selftest.rs");
const INVERSE_SELFTEST: &str = include_str!("../templates/rust/inverse_selftest.rs");

/// Folder of the runtime in the exported crate.
pub const RUNTIME: &str = "runtime";

/// The model, and its inverse where there is one, as a `no_std` crate: `Cargo.toml`, `src/lib.rs`,
/// `src/inverse.rs`, tests with golden vectors, and the source of `hysteron-rt` under `runtime`.
///
/// # Errors
/// Those of [`crate::c_files`].
pub fn rust_files(subject: &Subject, inverse: Option<&Inverse>) -> Result<Vec<NamedFile>, ExportError> {
    crate_files(subject, inverse, None)
}

/// [`rust_files`], with a controller around the inverse: `src/controller.rs`, with its feedback law and the
/// model of its observer below, and a test.
pub(crate) fn crate_files(
    subject: &Subject,
    inverse: Option<&Inverse>,
    controller: Option<&ClosedLoop>,
) -> Result<Vec<NamedFile>, ExportError> {
    let mut files = vec![NamedFile::new("Cargo.toml", manifest(subject))];
    files.push(NamedFile::new(format!("{RUNTIME}/Cargo.toml"), runtime_manifest()));
    let sources = hysteron_rt::rust_source::FILES.iter();
    // The line tells a later export that it may replace the file.
    let copied = |text| format!("// Copied by hysteron export.\n{text}");
    files.extend(sources.map(|(name, text)| NamedFile::new(format!("{RUNTIME}/src/{name}"), copied(text))));
    let literal = |x: f64| subject.precision.rust_literal(x);
    let mut filling = common(subject, subject.description(), numbers(subject)?)?;
    filling
        .flag("root", true)
        .flag("has_inverse", inverse.is_some())
        .flag("has_controller", controller.is_some());
    let bytes = match subject.precision {
        Precision::F32 => model_bytes::<f32>(subject)?,
        Precision::F64 => model_bytes::<f64>(subject)?,
    };
    mark_saved(&mut filling, &subject.origin, bytes)?;
    files.push(NamedFile::new("src/lib.rs", filling.fill(SOURCE)?));
    golden_keys(&mut filling, subject, &Golden::new(subject)?, &literal);
    files.push(NamedFile::new("tests/selftest.rs", filling.fill(SELFTEST)?));
    if let Some(inverse) = inverse {
        let tables = numbers(&inverse.subject)? + &law(inverse);
        let mut filling = common(&inverse.subject, inverse.description(), tables)?;
        filling
            .flag("inverse", true)
            .key("crate", &subject.name)
            .key("N_PREVIEW", inverse.compensation.preview);
        let bytes = match inverse.subject.precision {
            Precision::F32 => inverse_bytes::<f32>(inverse)?,
            Precision::F64 => inverse_bytes::<f64>(inverse)?,
        };
        mark_saved(&mut filling, &inverse.subject.origin, bytes)?;
        files.push(NamedFile::new("src/inverse.rs", filling.fill(SOURCE)?));
        golden_inverse_keys(&mut filling, inverse, &literal)?;
        files.push(NamedFile::new("tests/inverse_selftest.rs", filling.fill(INVERSE_SELFTEST)?));
    }
    if let Some(controller) = controller {
        files.extend(controller_modules(controller, &subject.name)?);
    }
    Ok(files)
}

/// Bytes of a saved state of the model.
fn model_bytes<T: Real>(subject: &Subject) -> Result<usize, ExportError> {
    Ok(RuntimeParts::<T>::new(&subject.realisation)?.model()?.saved_bytes())
}

/// Bytes of a saved state of the inverse.
fn inverse_bytes<T: Real>(inverse: &Inverse) -> Result<usize, ExportError> {
    let parts = CompensatorParts::<T>::new(&inverse.compensation, inverse.range_v, inverse.slew_v_per_s);
    Ok(parts?.compensator()?.saved_bytes())
}

/// Source of a part of a controller, under one of the template's flags.
pub(crate) fn module(
    subject: &Subject,
    flag: &'static str,
    description: Vec<String>,
    keys: impl FnOnce(&mut Filling),
) -> Result<String, ExportError> {
    let tables = if flag == "law" { linear_numbers(subject)? } else { numbers(subject)? };
    let mut filling = common(subject, description, tables)?;
    // A law has no hysteresis.
    let states = filling.has("states") && flag != "law";
    filling.flag(flag, true).flag("states", states);
    keys(&mut filling);
    filling.fill(SOURCE)
}

/// Sets what a source says of saved states of so many bytes.
fn mark_saved(filling: &mut Filling, origin: &Origin, bytes: usize) -> Result<(), ExportError> {
    let (one, streams) =
        if filling.has("inverse") { ("compensator", "Compensator") } else { ("model", "Model") };
    filling.key("one", one).key("Streams", streams).key("SAVED_BYTES", bytes).key("MARK", "0");
    let mut plain = filling.clone();
    let text = plain.key("DESCRIPTION", "").fill(SOURCE)?;
    let mark = saved::mark([&text, env!("CARGO_PKG_VERSION"), &origin.model_sha256].into_iter());
    filling.key("MARK", format!("0x{mark:016x}"));
    Ok(())
}

/// Comment at the head of a source.
pub(crate) fn head(description: &[String]) -> String {
    let line = |line: &String| format!("//! {}", rust_comment(line)).trim_end().to_owned();
    description.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Filling common to all source files.
fn common(subject: &Subject, description: Vec<String>, tables: String) -> Result<Filling, ExportError> {
    let mut filling = filling(subject, Numbers::Constant)?;
    let literal = |x: f64| subject.precision.rust_literal(x);
    filling
        .key("DESCRIPTION", head(&description))
        .key("INPUT_UNIT", rust_comment(&subject.input_unit))
        .key("OUTPUT_UNIT", rust_comment(&subject.output_unit))
        .key("real", subject.precision.name())
        .key("RATE", literal(subject.realisation.sample_rate_hz))
        .key("TABLES", tables);
    if let Some(range) = &subject.range {
        filling.key("RANGE_LOW", literal(range.input.low)).key("RANGE_HIGH", literal(range.input.high));
    }
    Ok(filling)
}

fn numbers(subject: &Subject) -> Result<String, ExportError> {
    match subject.precision {
        Precision::F32 => tables::<f32>(subject),
        Precision::F64 => tables::<f64>(subject),
    }
}

fn linear_numbers(subject: &Subject) -> Result<String, ExportError> {
    match subject.precision {
        Precision::F32 => linear_tables::<f32>(subject),
        Precision::F64 => linear_tables::<f64>(subject),
    }
}

/// The tables of a law.
fn law(inverse: &Inverse) -> String {
    let literal = |x: f64| inverse.subject.precision.rust_literal(x);
    let list = |numbers: &[f64]| numbers.iter().map(|&x| literal(x)).collect::<Vec<_>>().join(", ");
    let law = &inverse.compensation;
    let sections = || law.dynamics.sections.iter().zip(&law.states);
    let single: Vec<f64> = sections().filter(|(s, _)| !s.is_pair()).map(|(_, [re, _])| *re).collect();
    let groups = single.chunks(LANES).map(|some| {
        let mut lanes = [0.0; LANES];
        lanes.iter_mut().zip(some).for_each(|(lane, gain)| *lane = *gain);
        format!("[{}]", list(&lanes))
    });
    let pairs = sections().filter(|(s, _)| s.is_pair()).map(|(_, gains)| format!("[{}]", list(gains)));
    let table = |comment: &str, name: &str, kind: &str, entries: Vec<String>| {
        let content = if entries.is_empty() {
            "[]".to_owned()
        } else {
            format!("[\n{},\n]", rows(entries.iter().cloned()))
        };
        format!("/// {comment}\nstatic {name}: [{kind}; {}] = {content};\n", entries.len())
    };
    let plain = |numbers: &[f64]| numbers.iter().map(|&x| literal(x)).collect::<Vec<_>>();
    let [low, high, step] = inverse.limits();
    let step = if step.is_finite() { literal(step) } else { "Real::INFINITY".into() };
    [
        table(
            "Gains on the outputs of the hysteresis before the last.",
            "LAW_RECENT",
            "Real",
            plain(&law.recent),
        ),
        table("Gains on the real poles.", "LAW_REAL", "[Real; 4]", groups.collect()),
        table("Gains on the pole pairs.", "LAW_PAIRS", "[Real; 2]", pairs.collect()),
        table("Gains on the reference, the newest first.", "LAW_REFERENCE", "Real", plain(&law.reference))
            .replace("static", "const"),
        format!(
            "/// Least and largest voltage, and its largest change in a sample.\nconst LIMITS: [Real; 3] = \
             [{}, {}, {step}];\n",
            literal(low),
            literal(high)
        ),
    ]
    .concat()
}

fn manifest(subject: &Subject) -> String {
    format!(
        "# Written by hysteron export {}.\n[package]\nname = {}\nversion = \"0.1.0\"\nedition = \
         \"2024\"\npublish = false\n\n\
         [dependencies]\n# Several exported crates in one workspace share one such folder.\n\
         hysteron-rt = {{ path = \"{RUNTIME}\" }}\n\n# Not part of any workspace around it.\n[workspace]\n",
        env!("CARGO_PKG_VERSION"),
        toml_string(&subject.name)
    )
}

fn runtime_manifest() -> String {
    format!(
        "# Copied by hysteron export.\n[package]\nname = \"hysteron-rt\"\nversion = \"{}\"\nedition = \"2024\"\n\
         license = \"MIT OR Apache-2.0\"\npublish = false\n\n\
         [features]\n# Elementary functions of the standard library in place of libm.\nstd = []\n\n\
         [dependencies]\nlibm = \"0.2\"\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// The law as an expression.
fn law_in_rust<T: Real>(law: Branch<T>, literal: &dyn Fn(T) -> String) -> String {
    let mut numbers = Vec::new();
    law.for_each_number(|name, number| numbers.push(format!("{name}: {}", literal(number))));
    let (name, numbers) = (law.name(), numbers.join(", "));
    format!("Branch::{name}(branch::{name} {{ {numbers} }})")
}

fn tables<T: Real + Into<f64>>(subject: &Subject) -> Result<String, ExportError> {
    let parts = RuntimeParts::<T>::new(&subject.realisation)?;
    let coefficients = parts.coefficients();
    let literal = |x: T| subject.precision.rust_literal(x.into());
    let all = |numbers: &[T]| rows(numbers.iter().map(|&x| literal(x)));
    let mut out = String::new();
    let mut table = |comment: &str, name: &str, kind: &str, size: usize, content: &str| {
        let content = if size == 0 { "[]".to_owned() } else { format!("[\n{content},\n]") };
        out.push_str(&format!("/// {comment}\nstatic {name}: [{kind}; {size}] = {content};\n"));
    };
    let polynomial = coefficients.polynomial;
    table(
        "Coefficients of u, u², … of the polynomial.",
        "POLYNOMIAL",
        "Real",
        polynomial.len(),
        &all(polynomial),
    );
    let numbers = OperatorNumbers::new(coefficients.operator);
    if let Some((parameters, _)) = &numbers.states {
        let own = |parameters: &[T; 4]| format!("[{}]", parameters.map(literal).join(", "));
        let comment = format!("{}.", StateLaw::<T>::PARAMETERS.join(", "));
        table(&comment, "STATES", "[Real; 4]", parameters.len(), &rows(parameters.iter().map(own)));
    }
    if let Some((what, weights)) = &numbers.weights
        && !weights.is_empty()
    {
        table(&format!("Weights of the {what}s."), "WEIGHT", "Real", weights.len(), &all(weights));
    }
    for Table { comment, name, numbers } in &numbers.tables {
        table(comment, name, "Real", numbers.len(), &all(numbers));
    }
    for Constant { comment, name, value } in numbers.constants.iter().chain(&numbers.of_rust) {
        out.push_str(&format!("/// {comment}\nconst {name}: Real = {};\n", literal(*value)));
    }
    if let Some(law) = numbers.law {
        let law = law_in_rust(law, &literal);
        out.push_str(&format!("/// The law.\nconst LAW: Branch<Real> = {law};\n"));
    }
    out.push_str(&linear_tables::<T>(subject)?);
    let offset = literal(coefficients.offset);
    out.push_str(&format!("/// Constant of the displacement.\nconst OFFSET: Real = {offset};\n"));
    Ok(out.replace("static STATES", "const STATES"))
}

/// Tables of the linear dynamics.
fn linear_tables<T: Real + Into<f64>>(subject: &Subject) -> Result<String, ExportError> {
    let parts = RuntimeParts::<T>::new(&subject.realisation)?;
    let sections = parts.coefficients().sections;
    let literal = |x: T| subject.precision.rust_literal(x.into());
    let all = |numbers: &[T]| rows(numbers.iter().map(|&x| literal(x)));
    let mut out = String::new();
    let mut table = |comment: &str, name: &str, kind: &str, size: usize, content: &str| {
        let content = if size == 0 { "[]".to_owned() } else { format!("[\n{content},\n]") };
        out.push_str(&format!("/// {comment}\nstatic {name}: [{kind}; {size}] = {content};\n"));
    };
    let list = |numbers: &[T]| numbers.iter().map(|&x| literal(x)).collect::<Vec<_>>().join(", ");
    let section = |kind: &str, gain: &[T], weight: &[T]| {
        format!("{kind} {{ gain: [{}], weight: [{}] }}", list(gain), list(weight))
    };
    table(
        "Taps on the newest inputs of the dynamics.",
        "TAP",
        "Real",
        sections.taps.len(),
        &all(sections.taps),
    );
    if !sections.real.is_empty() {
        let real = sections.real.iter().map(|p| section("RealPoles", &p.gain, &p.weight));
        table("Real poles.", "REAL", "RealPoles<Real>", sections.real.len(), &rows(real));
    }
    if !sections.pairs.is_empty() {
        let pairs = sections.pairs.iter().map(|p| section("PolePair", &p.gain, &p.weight));
        table("Pole pairs.", "PAIRS", "PolePair<Real>", sections.pairs.len(), &rows(pairs));
    }
    let rest_gain = literal(sections.rest_gain);
    out.push_str(&format!("/// Gain of the dynamics at rest.\nconst REST_GAIN: Real = {rest_gain};\n"));
    Ok(out)
}
