//! The files of a model, and of its inverse.

use std::collections::BTreeMap;

use hysteron_io::NamedFile;

use super::Untranslated;
use super::parse::Parser;
use super::syntax::{Expression, Initial, Named, Source, Type};
use super::tokens::{Token, tokens};
use super::write::{Writer, nothing};
use crate::c::{Numbers, core_files, filling, rows};
use crate::error::ExportError;
use crate::escape::{c_comment, matlab_string};
use crate::golden::{Golden, HELD_FROM};
use crate::inverse::{GoldenInverse, Inverse, inverse_core, inverse_filling};
use crate::number::Precision;
use crate::subject::Subject;
use crate::template::Filling;

const MODEL: &str = include_str!("../../templates/matlab/model.m");
const INVERSE: &str = include_str!("../../templates/matlab/inverse.m");
const COMMON: &str = include_str!("../../templates/matlab/common.m");
const PARAMETERS: &str = include_str!("../../templates/matlab/parameters.m");
const SELFTEST: &str = include_str!("../../templates/matlab/selftest.m");

/// Longest name of a function in MATLAB.
const LONGEST: usize = 63;
/// Names that are words of MATLAB or Octave, and of neither C nor Rust.
const WORDS: &str = " elseif end endfor endfunction endif endwhile function global otherwise parfor \
                     persistent spmd until ";

/// The model as functions of MATLAB and GNU Octave: `NAME.m`, its numbers in `NAME_parameters.m`, and
/// `NAME_selftest.m` with golden vectors. Double precision alone.
///
/// # Errors
/// [`ExportError::MatlabPrecision`], [`ExportError::MatlabName`]; those of [`crate::c_files`].
pub fn matlab_files(subject: &Subject) -> Result<Vec<NamedFile>, ExportError> {
    check(subject)?;
    let mut filling = filling(subject, Numbers::Constant)?;
    // A struct is saved as it is.
    filling.flag("saves", false);
    let code = core_files(subject, &filling)?;
    let golden = Golden::new(subject)?;
    filling
        .key("GIVEN", continued(&golden.voltages))
        .key("WANTED", continued(&golden.displacements))
        .key("TOLERANCE", literal(golden.tolerance))
        .key("REST", "given(1)")
        .key("HELD_FROM", HELD_FROM)
        .key("HOLD", golden.hold);
    written(subject, filling, subject.description(), MODEL, &code)
}

/// The inverse in the same form, as `NAME_inverse`.
///
/// # Errors
/// Those of [`matlab_files`] and [`Inverse::new`].
pub fn matlab_inverse_files(inverse: &Inverse) -> Result<Vec<NamedFile>, ExportError> {
    let subject = &inverse.subject;
    check(subject)?;
    let mut filling = inverse_filling(inverse, Numbers::Constant)?;
    filling.flag("saves", false);
    let code = inverse_core(inverse, &filling)?;
    let golden = GoldenInverse::new(inverse)?;
    let held_from = (0..golden.references.len()).find(|&k| golden.lasts(k) > 1);
    filling
        .flag("inverse", true)
        .key("GIVEN", continued(&golden.references))
        .key("WANTED", continued(&golden.voltages))
        .key("TOLERANCE", literal(golden.tolerance))
        .key("REST", literal(golden.rest_v))
        .key("HELD_FROM", held_from.unwrap_or(golden.references.len()))
        .key("HOLD", golden.hold);
    written(subject, filling, inverse.description(), INVERSE, &code)
}

fn check(subject: &Subject) -> Result<(), ExportError> {
    if subject.precision != Precision::F64 {
        return Err(ExportError::MatlabPrecision);
    }
    let name = &subject.name;
    let longest = format!("{name}_parameters").len();
    if longest > LONGEST || WORDS.contains(&format!(" {name} ")) {
        return Err(ExportError::MatlabName { name: name.clone() });
    }
    Ok(())
}

fn literal(x: f64) -> String {
    Precision::F64.c_literal(x)
}

/// Numbers of a row vector that goes over several lines.
fn continued(numbers: &[f64]) -> String {
    rows(numbers.iter().map(|&x| literal(x))).replace(",\n", ", ...\n    ")
}

fn written(
    subject: &Subject,
    mut filling: Filling,
    description: Vec<String>,
    function: &str,
    code: &[NamedFile],
) -> Result<Vec<NamedFile>, ExportError> {
    let name = &subject.name;
    let texts: Vec<_> = code.iter().map(|file| String::from_utf8_lossy(&file.bytes)).collect();
    let texts: Vec<&str> = texts.iter().map(|text| &**text).collect();
    let (tokens, macros) = tokens(&texts)?;
    let source = Parser::new(&tokens).source()?;
    let prefix = format!("{}_", name.to_ascii_uppercase());
    let own = |name: &str| name.strip_prefix(&prefix).unwrap_or(name).to_owned();
    let mut places: BTreeMap<String, String> =
        source.constants.iter().map(|c| (c.variable.name.clone(), c.variable.name.clone())).collect();
    places.extend(macros.iter().map(|(name, _)| (name.clone(), own(name))));
    let mut numbers = String::new();
    for (name, value) in &macros {
        let value = match value {
            Token::Number(text, _) => text.as_str(),
            _ => "Inf",
        };
        numbers.push_str(&format!("    par.{} = {value};\n", own(name)));
    }
    for constants in &source.constants {
        for line in constants.comment.iter().flat_map(|text| text.lines()) {
            numbers.push_str(&format!("    % {}\n", line.trim()));
        }
        let values = table(&source, &constants.variable, &constants.values)?;
        numbers.push_str(&format!("    par.{} = {values};\n", constants.variable.name));
    }
    let state = Named {
        name: "state".into(),
        of: Type::Struct(format!("{name}_state")),
        constant: false,
        pointer: false,
        sizes: Vec::new(),
    };
    let nothing = nothing(&source, &state)?.replace(", '", ", ...\n        '");
    let lines: Vec<String> =
        description.iter().map(|line| format!("% {}", c_comment(line)).trim_end().to_owned()).collect();
    let title = subject.title.clone().unwrap_or_else(|| name.clone());
    filling
        .key("NOTHING", nothing)
        .key("NUMBERS", numbers.trim_end())
        .key("DESCRIPTION", lines.join("\n"))
        .key("VERSION", env!("CARGO_PKG_VERSION"))
        .key("TITLE_STRING", matlab_string(&title))
        .key("INPUT_UNIT_STRING", matlab_string(&subject.input_unit))
        .key("OUTPUT_UNIT_STRING", matlab_string(&subject.output_unit));
    if let Some(range) = &subject.range {
        filling.key("RANGE_LOW", literal(range.input.low)).key("RANGE_HIGH", literal(range.input.high));
    }
    let functions = Writer::new(&source, &places).functions()?;
    let whole = [filling.fill(function)?, filling.fill(COMMON)?, functions].concat();
    Ok(vec![
        NamedFile::new(format!("{name}.m"), whole),
        NamedFile::new(format!("{name}_parameters.m"), filling.fill(PARAMETERS)?),
        NamedFile::new(format!("{name}_selftest.m"), filling.fill(SELFTEST)?),
    ])
}

/// A table in brackets: a row; rows of a matrix; an array of structures.
fn table(source: &Source, variable: &Named, values: &Initial) -> Result<String, Untranslated> {
    let unknown = || Untranslated::new("a table", &format!("{values:?}"));
    let Initial::List(values) = values else { return number(values).ok_or_else(unknown) };
    if let Type::Struct(name) = &variable.of {
        let members = source.structures.get(name).ok_or_else(unknown)?;
        let mut fields = Vec::new();
        for (k, member) in members.iter().enumerate() {
            let of_one = |one: &Initial| match one {
                Initial::List(values) => values.get(k).and_then(number),
                Initial::Value(_) => None,
            };
            let all: Option<Vec<String>> = values.iter().map(of_one).collect();
            fields.push(format!("'{}', {{{}}}", member.name, all.ok_or_else(unknown)?.join(", ")));
        }
        return Ok(format!("struct({})", fields.join(", ...\n        ")));
    }
    let mut matrix = Vec::new();
    let mut row = Vec::new();
    for value in values {
        match value {
            Initial::Value(_) => row.push(number(value).ok_or_else(unknown)?),
            Initial::List(inner) => {
                let inner: Option<Vec<String>> = inner.iter().map(number).collect();
                matrix.push(inner.ok_or_else(unknown)?.join(", "));
            }
        }
    }
    if matrix.is_empty() {
        return Ok(format!("[ ...\n    {}]", rows(row.into_iter()).replace(",\n", ", ...\n    ")));
    }
    Ok(format!("[ ...\n        {}]", matrix.join("; ...\n        ")))
}

fn number(value: &Initial) -> Option<String> {
    match value {
        Initial::Value(Expression::Number(text, _)) => Some(text.clone()),
        Initial::Value(Expression::Unary("-", inner)) => match &**inner {
            Expression::Number(text, _) => Some(format!("-{text}")),
            _ => None,
        },
        _ => None,
    }
}
