//! C99 source.

use hysteron_model::realise::{Coefficients, RuntimeParts};
use hysteron_rt::{Real, StateLaw, c_source};

use crate::error::ExportError;
use crate::escape::{c_comment, c_string};
use crate::golden::{Golden, HELD_FROM};
use crate::number::Precision;
use crate::operator::{self, Constant, OperatorNumbers, Table};
use crate::saved;
use crate::subject::Subject;
use crate::template::Filling;
use hysteron_io::NamedFile;

const HEADER: &str = concat!(
    include_str!("../templates/c/model_top.h"),
    include_str!("../templates/c/parameters.h"),
    include_str!("../templates/c/model_state.h"),
    include_str!("../templates/c/members.h"),
    include_str!("../templates/c/model_bottom.h")
);
const SOURCE: &str = concat!(
    include_str!("../templates/c/opening.c"),
    include_str!("../templates/c/hysteresis.c"),
    include_str!("../templates/c/dynamics.c"),
    include_str!("../templates/c/model.c"),
    include_str!("../templates/c/saved.c")
);
const SELFTEST: &str = include_str!("../templates/c/selftest.c");

/// The model as C99: `NAME.h`, `NAME.c`, and `NAME_selftest.c` with golden vectors.
///
/// # Errors
/// [`ExportError::Realise`] where the library has no result along the golden drive.
pub fn c_files(subject: &Subject) -> Result<Vec<NamedFile>, ExportError> {
    let mut filling = filling(subject, Numbers::Constant)?;
    let name = &subject.name;
    let mut files = core_files(subject, &filling)?;
    golden_keys(&mut filling, subject, &Golden::new(subject)?, &|x| subject.precision.c_literal(x));
    files.push(NamedFile::new(format!("{name}_selftest.c"), filling.fill(SELFTEST)?));
    Ok(files)
}

/// Storage of the numbers of the hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// In constant tables.
    Constant,
    /// In the state, where they may be changed.
    Tunable,
}

/// Header and source.
pub(crate) fn core_files(subject: &Subject, filling: &Filling) -> Result<Vec<NamedFile>, ExportError> {
    saved::header_and_source(
        &mut filling.clone(),
        subject.precision,
        (HEADER, SOURCE),
        &subject.origin.model_sha256,
    )
}

/// Sets what a self-test is filled with, in literals of its language.
pub(crate) fn golden_keys(
    filling: &mut Filling,
    subject: &Subject,
    golden: &Golden,
    literal: &dyn Fn(f64) -> String,
) {
    filling
        .key("SAMPLES", golden.voltages.len())
        .key("HELD_FROM", HELD_FROM)
        .key("HOLD", golden.hold)
        .key("VOLTAGES", rows(golden.voltages.iter().map(|&x| literal(x))))
        .key("DISPLACEMENTS", rows(golden.displacements.iter().map(|&x| literal(x))))
        .key("TOLERANCE", literal(golden.tolerance))
        .key(
            "TOLERANCE_IN_WORDS",
            match subject.precision {
                Precision::F64 => "1e-12 of their range",
                Precision::F32 => "16 units of rounding (2^-23) of the sum of magnitudes",
            },
        )
        .flag("refuses_largest", golden.refuses_largest);
}

/// The comment at the head of a source.
pub(crate) fn description_comment(lines: &[String]) -> String {
    let lines: Vec<String> =
        lines.iter().map(|line| format!(" * {}", c_comment(line)).trim_end().to_owned()).collect();
    format!("/*\n{}\n */", lines.join("\n"))
}

/// Filling of a model's templates.
pub(crate) fn filling(subject: &Subject, numbers: Numbers) -> Result<Filling, ExportError> {
    match subject.precision {
        Precision::F32 => of_type::<f32>(subject, numbers),
        Precision::F64 => of_type::<f64>(subject, numbers),
    }
}

fn of_type<T: Real + Into<f64>>(subject: &Subject, numbers: Numbers) -> Result<Filling, ExportError> {
    let parts = RuntimeParts::<T>::new(&subject.realisation)?;
    let coefficients = parts.coefficients();
    let mut filling = Filling::new(subject.precision);
    let tunable = numbers == Numbers::Tunable;
    let literal = |x: T| subject.precision.c_literal(x.into());
    filling
        .key("name", &subject.name)
        .key("NAME", subject.name.to_ascii_uppercase())
        .key("real", subject.precision.c_type())
        .key("DESCRIPTION", description_comment(&subject.description()))
        .key("RATE", subject.precision.c_literal(subject.realisation.sample_rate_hz))
        .key("INPUT_UNIT", c_comment(&subject.input_unit))
        .key("OUTPUT_UNIT", c_comment(&subject.output_unit))
        .key("INPUT_UNIT_STRING", c_string(&subject.input_unit))
        .key("OUTPUT_UNIT_STRING", c_string(&subject.output_unit))
        .key("LARGEST_EXPONENT", T::LARGEST.into().log10().round())
        .key(
            "TUNED_AS_ARGUMENT_FIRST",
            if tunable { format!("const {}_state *state, ", subject.name) } else { String::new() },
        )
        .key("TUNED_FIRST", if tunable { "state, " } else { "" })
        .flag("tunable", tunable)
        .flag("saves", !tunable)
        .flag("means", coefficients.joins_means)
        .flag("looks", coefficients.joins_means)
        .flag("range", subject.range.is_some());
    if let Some(range) = &subject.range {
        let literal = |x: f64| format!("({})", subject.precision.c_literal(x));
        filling.key("RANGE_LOW", literal(range.input.low)).key("RANGE_HIGH", literal(range.input.high));
    }
    for (name, constant) in [("polynomial", "POLYNOMIAL"), ("state_laws", "STATE_LAWS"), ("weight", "WEIGHT")]
    {
        let place = if tunable { format!("state->parameters.{name}") } else { constant.to_owned() };
        filling.coefficients(name, place);
    }
    sizes(&mut filling, &coefficients);
    operator::fill(&mut filling, coefficients.operator);
    let tables = tables(&subject.name, &coefficients, tunable, &literal);
    filling.key("TABLES", tables);
    Ok(filling)
}

fn sizes<T: Real>(filling: &mut Filling, coefficients: &Coefficients<'_, T>) {
    let sections = coefficients.sections;
    let real = real_poles(coefficients).len();
    for heading in ["sizes", "members of the state", "parameters"] {
        filling.part(heading, c_source::header_lines(heading).collect::<Vec<_>>().join("\n"));
    }
    filling
        .part("type of a state", c_source::STATE_LAW)
        .part("shared functions", c_source::SHARED.concat())
        .part("operators", c_source::OPERATORS.concat())
        .flag("accumulates", real + sections.pairs.len() > 0)
        .flag("polynomial", !coefficients.polynomial.is_empty())
        .flag("real_poles", real > 0)
        .flag("pairs", !sections.pairs.is_empty())
        .flag("delay", coefficients.delay_samples > 0)
        .key("N_POLYNOMIAL", coefficients.polynomial.len())
        .key("N_TAPS", sections.taps.len())
        .key("N_REAL", real)
        .key("N_PAIRS", sections.pairs.len())
        .key("N_DELAY", coefficients.delay_samples);
}

/// Gain and weight of each real pole, without the lanes that fill up the last group.
fn real_poles<T: Real>(coefficients: &Coefficients<'_, T>) -> Vec<(T, T)> {
    let zero = T::of(0.0);
    let groups = coefficients.sections.real.iter();
    let mut poles: Vec<(T, T)> = groups.flat_map(|g| g.gain.into_iter().zip(g.weight)).collect();
    while poles.last().is_some_and(|&(gain, weight)| gain == zero && weight == zero) {
        poles.pop();
    }
    poles
}

/// The constant tables.
fn tables<T: Real>(
    name: &str,
    coefficients: &Coefficients<'_, T>,
    tunable: bool,
    literal: &dyn Fn(T) -> String,
) -> String {
    let mut out = String::new();
    let all = |numbers: &[T]| rows(numbers.iter().map(|&x| literal(x)));
    let pairs = |numbers: &mut dyn Iterator<Item = [T; 2]>| {
        rows(numbers.map(|[re, im]| format!("{{{}, {}}}", literal(re), literal(im))))
    };
    let mut table = |comment: &str, declaration: &str, content: &str| {
        out.push_str(&format!("/* {comment} */\nstatic const {declaration} = {{\n{content}\n}};\n"));
    };
    let numbers = OperatorNumbers::new(coefficients.operator);
    let states = numbers.states.as_ref().map(|(parameters, _)| {
        let own = |parameters: &[T; 4]| format!("{{{}}}", parameters.map(literal).join(", "));
        (parameters.len(), rows(parameters.iter().map(own)))
    });
    let polynomial = (coefficients.polynomial.len(), all(coefficients.polynomial));
    let weights = numbers.weights.as_ref().filter(|(_, weights)| !weights.is_empty());
    let weights = weights.map(|(what, weights)| (what, weights.len(), all(weights)));
    if tunable {
        let members = [
            Some(&polynomial.1).filter(|_| polynomial.0 > 0),
            states.as_ref().map(|(_, parameters)| parameters),
            weights.as_ref().map(|(.., weights)| weights),
        ];
        let members: Vec<String> =
            members.into_iter().flatten().map(|numbers| format!("    {{\n{numbers}\n    }}")).collect();
        table(
            "The numbers of the hysteresis to begin with.",
            &format!("{name}_parameters DEFAULTS"),
            &members.join(",\n"),
        );
    } else {
        if let (size @ 1.., numbers) = &polynomial {
            let comment = "Coefficients of u, u^2, ... of the polynomial.";
            table(comment, &format!("real POLYNOMIAL[{size}]"), numbers);
        }
        if let Some((size, parameters)) = &states {
            let comment = format!("{}.", StateLaw::<T>::PARAMETERS.join(", "));
            table(&comment, &format!("state_law STATE_LAWS[{size}]"), parameters);
        }
        if let Some((what, size, weights)) = &weights {
            table(&format!("Weights of the {what}s."), &format!("real WEIGHT[{size}]"), weights);
        }
    }
    if let Some(law) = numbers.law {
        let (mut names, mut shape) = (Vec::new(), Vec::new());
        law.for_each_number(|name, number| {
            names.push(name);
            shape.push(number);
        });
        let comment = format!("Numbers of the law: {}.", names.join(", "));
        table(&comment, &format!("real SHAPE[{}]", shape.len()), &all(&shape));
    }
    for Table { comment, name, numbers } in &numbers.tables {
        table(comment, &format!("real {name}[{}]", numbers.len()), &all(numbers));
    }
    for Constant { comment, name, value } in numbers.constants.iter().chain(&numbers.of_c) {
        out.push_str(&format!("/* {comment} */\nstatic const real {name} = {};\n", literal(*value)));
    }
    let mut table = |comment: &str, declaration: &str, content: &str| {
        out.push_str(&format!("/* {comment} */\nstatic const {declaration} = {{\n{content}\n}};\n"));
    };
    let sections = coefficients.sections;
    table(
        "Taps on the newest inputs of the dynamics.",
        &format!("real TAP[{}]", sections.taps.len()),
        &all(sections.taps),
    );
    let real = real_poles(coefficients);
    if !real.is_empty() {
        let (gains, weights): (Vec<T>, Vec<T>) = real.into_iter().unzip();
        table(
            "Real poles: x <- x + g (w - x), g.",
            &format!("real REAL_GAIN[{}]", gains.len()),
            &all(&gains),
        );
        table("Their shares of the output.", &format!("real REAL_WEIGHT[{}]", weights.len()), &all(&weights));
    }
    if !sections.pairs.is_empty() {
        let size = sections.pairs.len();
        table(
            "Pole pairs: x <- x + g (w - x), Re g and Im g.",
            &format!("real PAIR_GAIN[{size}][2]"),
            &pairs(&mut sections.pairs.iter().map(|p| p.gain)),
        );
        table(
            "Their shares of the output, Re(c x): Re c and Im c.",
            &format!("real PAIR_WEIGHT[{size}][2]"),
            &pairs(&mut sections.pairs.iter().map(|p| p.weight)),
        );
    }
    format!(
        "{out}/* Gain of the dynamics at rest. */\nstatic const real \
         REST_GAIN = {};\n/* Constant of the displacement. */\nstatic const real OFFSET = {};\n",
        literal(sections.rest_gain),
        literal(coefficients.offset)
    )
}

/// Texts in rows, separated by commas.
pub(crate) fn rows(texts: impl Iterator<Item = String>) -> String {
    let mut out = String::from("   ");
    let mut width = 3;
    let mut first = true;
    for text in texts {
        if !first {
            out.push(',');
            if width + text.len() > 110 {
                out.push_str("\n   ");
                width = 3;
            }
        }
        first = false;
        out.push(' ');
        out.push_str(&text);
        width += text.len() + 2;
    }
    out
}
