//! C99 source.

use hysteron_model::hysteresis::RuntimeOperator;
use hysteron_model::realise::{Coefficients, RuntimeParts, TURNS};
use hysteron_rt::{Real, Sides, c_source};

use crate::error::ExportError;
use crate::escape::{c_comment, c_string};
use crate::golden::{Golden, HELD_FROM};
use crate::number::Precision;
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
    include_str!("../templates/c/model.c")
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

/// Where the numbers of the hysteresis are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// In constant tables.
    Constant,
    /// In the state, where they may be changed.
    Tunable,
}

/// Header and source.
pub(crate) fn core_files(subject: &Subject, filling: &Filling) -> Result<Vec<NamedFile>, ExportError> {
    Ok(vec![
        NamedFile::new(format!("{}.h", subject.name), filling.fill(HEADER)?),
        NamedFile::new(format!("{}.c", subject.name), filling.fill(SOURCE)?),
    ])
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
                Precision::F32 => "16 units of rounding (2^-23) of all that is added up",
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

/// What the templates of a model are filled with.
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
        .flag("means", coefficients.joins_means)
        .flag("looks", coefficients.joins_means)
        .flag("range", subject.range.is_some());
    if let Some(range) = &subject.range {
        let literal = |x: f64| format!("({})", subject.precision.c_literal(x));
        filling.key("RANGE_LOW", literal(range.input.low)).key("RANGE_HIGH", literal(range.input.high));
    }
    for (name, constant) in [("polynomial", "POLYNOMIAL"), ("operators", "OPERATORS"), ("weight", "WEIGHT")] {
        let place = if tunable { format!("state->parameters.{name}") } else { constant.to_owned() };
        filling.coefficients(name, place);
    }
    sizes(&mut filling, &coefficients);
    if let &RuntimeOperator::Plane { intervals, .. } = coefficients.operator {
        filling.key("REAL_INTERVALS", literal(T::of(intervals as f64)));
    }
    let tables = tables(&subject.name, &coefficients, tunable, &literal);
    filling.key("TABLES", tables);
    Ok(filling)
}

fn sizes<T: Real>(filling: &mut Filling, coefficients: &Coefficients<'_, T>) {
    let sections = coefficients.sections;
    let one = T::of(1.0);
    let operators = match coefficients.operator {
        RuntimeOperator::BoucWen(operators) => &operators[..],
        _ => &[],
    };
    // One law for all: several in parallel have n = 1.
    let exponent = operators.first().map(|&[.., n]| n);
    let [linear, quadratic] = [one, T::of(2.0)].map(|n| exponent == Some(n));
    let power = exponent.is_some() && !linear && !quadratic;
    let real = real_poles(coefficients).len();
    let activated = matches!(coefficients.operator, RuntimeOperator::ActivatedPlays { .. });
    let fragment = c_fragment(coefficients.operator);
    let names = |name| words(fragment).any(|word| word == name);
    let linear_law = linear || names("increment");
    filling
        .part("shared functions", c_source::SHARED)
        .part("law of a branch", if fragment.is_empty() { String::new() } else { format!("{fragment}\n") })
        .part("operators", c_source::OPERATORS)
        .flag("branch", !fragment.is_empty())
        .flag("own_output", names("branch_output"))
        .flag("own_virgin", names("branch_virgin"))
        .flag("moments", names("moments"))
        .flag("roots", names("rising_root"))
        .flag("linear_law", linear_law)
        .flag("logs", linear_law || names("log_distance"))
        .flag("relaxes", linear_law || power || activated || names("relaxation"))
        .flag("accumulates", !operators.is_empty() || !fragment.is_empty() || real + sections.pairs.len() > 0)
        .flag("bouc_wen", !operators.is_empty())
        .flag("quadratic_law", quadratic)
        .flag("power_law", power)
        .flag("polynomial", !coefficients.polynomial.is_empty())
        .flag("real_poles", real > 0)
        .flag("pairs", !sections.pairs.is_empty())
        .flag("delay", coefficients.delay_samples > 0)
        .key("N_OPERATORS", operators.len())
        .key("N_POLYNOMIAL", coefficients.polynomial.len())
        .key("N_TAPS", sections.taps.len())
        .key("N_REAL", real)
        .key("N_PAIRS", sections.pairs.len())
        .key("N_DELAY", coefficients.delay_samples);
    operator_sizes(filling, coefficients.operator);
}

/// Flags and sizes of plays and planes.
fn operator_sizes<T: Real>(filling: &mut Filling, operator: &RuntimeOperator<T>) {
    for key in [
        "RATE_PARAMETER",
        "RATE_IN_WORDS",
        "THROUGH_PARAMETER",
        "THROUGH_IN_WORDS",
        "AT_HALF",
        "AT_END",
        "AT_REST",
        "AWAY",
    ] {
        filling.key(key, "");
    }
    match operator {
        RuntimeOperator::BoucWen(operators) => {
            filling.flag("memoryless", operators.is_empty());
        }
        RuntimeOperator::Branch { weights, .. } => {
            filling.key("N_STATES", weights.len());
        }
        RuntimeOperator::Plays { weights, .. } => {
            filling.flag("memoryless", weights.is_empty());
            filling.flag("plays", !weights.is_empty()).key("N_PLAYS", weights.len());
        }
        RuntimeOperator::SidedPlays { sides, thresholds, weights, line } => {
            let kind = match *sides {
                Sides::Even { widening } if widening > T::of(0.0) => "rate",
                Sides::Even { .. } => "even",
                Sides::Below => "below",
                Sides::Envelopes { .. } => "envelopes",
                Sides::Ramps { .. } => "ramps",
            };
            filling
                .flag("sided", true)
                .flag(kind, true)
                .flag("line", !line.slopes.is_empty())
                .key("N_PLAYS", weights.len())
                .key("N_THRESHOLDS", thresholds.len())
                .key("N_CORNERS", line.corners.len());
            if kind == "rate" {
                filling
                    .flag("moves_at_rest", true)
                    .key("AT_HALF", ", voltage - state->voltage")
                    .key("AT_END", ", voltage - state->voltage")
                    .key("AT_REST", ", 0")
                    .key("AWAY", ", away")
                    .key("RATE_PARAMETER", ", real du")
                    .key("RATE_IN_WORDS", " in a sample that moves by du")
                    .key("THROUGH_PARAMETER", "real middle, real du, ")
                    .key("THROUGH_IN_WORDS", " through `middle`, in a sample that moves by du,");
            }
        }
        RuntimeOperator::ActivatedPlays { thresholds, .. } => {
            filling
                .flag("activated", true)
                .flag("moves_at_rest", true)
                .key("N_PLAYS", thresholds.len())
                .key("AT_HALF", ", (real)0.5")
                .key("AT_END", ", 1")
                .key("AT_REST", ", 1")
                .key("AWAY", ", 1")
                .key("RATE_PARAMETER", ", real share")
                .key("RATE_IN_WORDS", " after that share of a sample");
        }
        RuntimeOperator::Plane { intervals, .. } => {
            filling.flag("plane", true).key("N_INTERVALS", intervals).key("N_TURNS", TURNS);
        }
    }
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
    let operators = |operators: &[[T; 4]]| {
        rows(operators.iter().map(|numbers| format!("{{{}}}", numbers.map(literal).join(", "))))
    };
    let mut opening = String::new();
    let on_branch = words(c_fragment(coefficients.operator)).any(|word| word == "bouc_wen");
    if on_branch || matches!(coefficients.operator, RuntimeOperator::BoucWen(_)) {
        opening = if tunable && !on_branch {
            format!("typedef {name}_bouc_wen bouc_wen;\n\n")
        } else {
            "/* A Bouc-Wen operator. */\ntypedef struct {\n    real alpha, beta, gamma, n;\n} bouc_wen;\n\n"
                .into()
        };
    }
    let polynomial = all(coefficients.polynomial);
    if tunable {
        let mut members = Vec::new();
        if !coefficients.polynomial.is_empty() {
            members.push(format!("    {{\n{polynomial}\n    }}"));
        }
        match coefficients.operator {
            RuntimeOperator::BoucWen(list) => members.push(format!("    {{\n{}\n    }}", operators(list))),
            RuntimeOperator::Plays { weights, .. }
            | RuntimeOperator::SidedPlays { weights, .. }
            | RuntimeOperator::Branch { weights, .. } => {
                members.push(format!("    {{\n{}\n    }}", all(weights)));
            }
            RuntimeOperator::ActivatedPlays { .. } | RuntimeOperator::Plane { .. } => {}
        }
        table(
            "The numbers of the hysteresis to begin with.",
            &format!("{name}_parameters DEFAULTS"),
            &members.join(",\n"),
        );
    } else if !coefficients.polynomial.is_empty() {
        table(
            "Coefficients of u, u^2, ... of the polynomial.",
            &format!("real POLYNOMIAL[{}]", coefficients.polynomial.len()),
            &polynomial,
        );
    }
    match coefficients.operator {
        RuntimeOperator::BoucWen(list) if !tunable => {
            table("alpha, beta, gamma, n.", &format!("bouc_wen OPERATORS[{}]", list.len()), &operators(list));
        }
        RuntimeOperator::BoucWen(_) => {}
        RuntimeOperator::Plays { thresholds, weights } => {
            table(
                "Half-widths of the plays.",
                &format!("real THRESHOLD[{}]", thresholds.len()),
                &all(thresholds),
            );
            if !tunable {
                table("Weights of the plays.", &format!("real WEIGHT[{}]", weights.len()), &all(weights));
            }
        }
        RuntimeOperator::Branch { law, weights } => {
            let (mut names, mut shape) = (Vec::new(), Vec::new());
            law.for_each_number(|name, number| {
                names.push(name);
                shape.push(number);
            });
            let comment = format!("Numbers of the law: {}.", names.join(", "));
            table(&comment, &format!("real SHAPE[{}]", shape.len()), &all(&shape));
            if !tunable {
                table("Weights of the states.", &format!("real WEIGHT[{}]", weights.len()), &all(weights));
            }
        }
        RuntimeOperator::SidedPlays { sides, thresholds, weights, line } => {
            if let Sides::Envelopes { right, left } = sides {
                for (comment, name, side) in [
                    ("Rise and centre of the right envelope.", "RIGHT", right),
                    ("Rise and centre of the left envelope.", "LEFT", left),
                ] {
                    table(comment, &format!("real {name}[2]"), &all(side));
                }
            }
            let (comment, size) = (of_thresholds(sides), thresholds.len());
            table(comment, &format!("real THRESHOLD[{size}]"), &all(thresholds));
            if !tunable {
                table("Weights of the plays.", &format!("real WEIGHT[{}]", weights.len()), &all(weights));
            }
            for (comment, name, numbers) in [
                ("Shares of the plays in their mean.", "SHARE", &line.shares),
                ("Corners of the line that the mean goes through.", "CORNER", &line.corners),
                ("Slopes between them, one more.", "SLOPE", &line.slopes),
            ] {
                if !numbers.is_empty() {
                    table(comment, &format!("real {name}[{}]", numbers.len()), &all(numbers));
                }
            }
        }
        RuntimeOperator::ActivatedPlays { range, thresholds, slopes, .. } => {
            for (comment, name, numbers) in [
                ("Half-widths of the plays.", "THRESHOLD", &thresholds[..]),
                ("Slopes of what they put out, three a play.", "SLOPE", slopes),
                ("Ends of the range over which these hold.", "RANGE", range),
            ] {
                table(comment, &format!("real {name}[{}]", numbers.len()), &all(numbers));
            }
        }
        RuntimeOperator::Plane { everett, .. } => {
            let comment = "Sums over the relays between two levels: (1, 0), (2, 0), (2, 1), (3, 0), ...";
            table(comment, &format!("real EVERETT[{}]", everett.len()), &all(everett));
        }
    }
    let mut constant = |comment: &str, name: &str, value: T| {
        out.push_str(&format!("/* {comment} */\nstatic const real {name} = {};\n", literal(value)));
    };
    match *coefficients.operator {
        RuntimeOperator::SidedPlays { sides: Sides::Even { widening }, .. } if widening > T::of(0.0) => {
            constant("What a half-width grows by for a move of 1 in a sample.", "WIDENING", widening);
        }
        RuntimeOperator::SidedPlays { sides: Sides::Ramps { steepness }, .. } => {
            constant("Slope of a ramp.", "STEEPNESS", steepness);
        }
        RuntimeOperator::ActivatedPlays { pace: (sigma, interval), .. } => {
            constant("Activation of the plays.", "SIGMA", sigma);
            constant("Seconds from sample to sample.", "INTERVAL", interval);
        }
        RuntimeOperator::Plane { range: [low, high], intervals, .. } => {
            let density = T::of(intervals as f64) / (high - low);
            constant("Lowest level.", "LOWEST", low);
            constant("Intervals between levels a unit of voltage.", "DENSITY", density);
        }
        _ => {}
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
        "{opening}{out}/* What the dynamics put out at rest, over their input. */\nstatic const real REST_GAIN = {};\n/* Constant of the displacement. */\nstatic const real OFFSET = {};\n",
        literal(sections.rest_gain),
        literal(coefficients.offset)
    )
}

/// The law of a branch in C; empty for other operators.
fn c_fragment<T: Real>(operator: &RuntimeOperator<T>) -> &'static str {
    match operator {
        RuntimeOperator::Branch { law, .. } => law.c_fragment(),
        _ => "",
    }
}

/// The identifiers and words of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_'))
}

/// What the thresholds of plays are.
pub(crate) fn of_thresholds<T>(sides: &Sides<T>) -> &'static str {
    match sides {
        Sides::Ramps { .. } => "Lines of the grid.",
        _ => "Half-widths of the plays.",
    }
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
