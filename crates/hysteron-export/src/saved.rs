//! Saved states: the members of a state in the C source, written to bytes and read from them.
//!
//! The members are read off their declarations, so that none is left out. A declaration is a number
//! (`NAME_real`), a pair of trims (`NAME_trims`), the state of another export (`OTHER_state`), or a whole
//! number (`int32_t`, `uint32_t`, `bool`). Whole numbers are indices and flags: a comment `/* below N` behind
//! an index says what a restored one must be below.

use hysteron_io::NamedFile;

use crate::error::ExportError;
use crate::number::Precision;
use crate::template::Filling;

const SIZE: &str = include_str!("../templates/c/saved_size.h");
const FUNCTIONS: &str = include_str!("../templates/c/saved.h");
/// Bytes before the members: `HYST` and the mark.
const HEAD: usize = 12;
/// Keys of the templates of saved states.
const KEYS: [&str; 8] = [
    "MARK_LOW",
    "MARK_HIGH",
    "SAVED_BYTES",
    "SAVED_NUMBERS_AT",
    "BITS",
    "SAVE_MEMBERS",
    "CHECK_MEMBERS",
    "RESTORE_MEMBERS",
];

/// A member of a state.
#[derive(Clone, Debug, PartialEq)]
struct Member {
    /// Its place in the state.
    name: String,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    /// Numbers, in an array of these sizes.
    Numbers { sizes: Vec<String> },
    /// An index or a flag: its type, and what it is below.
    Whole { of: String, bound: String },
    /// The state of another export: the beginning of its names.
    State { of: String },
}

/// Sets what the sources of a saved state are filled with: `header` and `source` are the templates of the
/// export, the former with the state in it, and `identity` what else makes it another export.
///
/// # Errors
/// [`ExportError::Template`] for a declaration of another form.
fn fill(
    filling: &mut Filling,
    precision: Precision,
    (header, source): (&str, &str),
    identity: &[&str],
) -> Result<(), ExportError> {
    let mut plain = filling.clone();
    plain.part("size of a saved state", "").part("functions of a saved state", "").key("DESCRIPTION", "");
    for key in KEYS {
        plain.key(key, "");
    }
    let header = plain.fill(header)?;
    let members = members(&header, filling.text("name"))?;
    let source = plain.fill(source)?;
    let mark = mark([&[header.as_str(), &source, env!("CARGO_PKG_VERSION")], identity].concat().into_iter());
    let (wholes, others): (Vec<&Member>, Vec<&Member>) =
        members.iter().partition(|m| matches!(m.kind, Kind::Whole { .. }));
    let (width, bits) = match precision {
        Precision::F32 => (4, "uint32_t"),
        Precision::F64 => (8, "uint64_t"),
    };
    let name = filling.text("NAME").to_owned();
    let sizes: Vec<String> = others.iter().map(|m| m.bytes(width)).collect();
    let numbers_at = HEAD + 4 * wholes.len();
    let places = || (HEAD..).step_by(4).zip(&wholes);
    let has_rows = |m: &&Member| matches!(&m.kind, Kind::Numbers { sizes } if sizes.len() > 1);
    let restored = places().map(|(at, m)| m.restored(at)).chain(others.iter().map(|m| m.restored(0)));
    filling
        .part("size of a saved state", SIZE)
        .part("functions of a saved state", FUNCTIONS)
        .key("MARK_LOW", format!("0x{:08X}u", mark & 0xffff_ffff))
        .key("MARK_HIGH", format!("0x{:08X}u", mark >> 32))
        .key("SAVED_BYTES", format!("{} + {}", numbers_at + 4, broken(&sizes)))
        .key("SAVED_NUMBERS_AT", format!("{numbers_at}u"))
        .key("BITS", bits)
        .key("SAVE_MEMBERS", lines(wholes.iter().chain(&others).map(|m| m.saved())))
        .key("CHECK_MEMBERS", lines(places().map(|(at, m)| m.checked(at, &name))))
        .key("RESTORE_MEMBERS", lines(restored))
        .flag("saved_rows", others.iter().any(has_rows));
    Ok(())
}

/// Header and source of an export with saved states, of which `filling` is told: `NAME.h` and `NAME.c`.
///
/// # Errors
/// Those of [`fill`].
pub(crate) fn header_and_source(
    filling: &mut Filling,
    precision: Precision,
    (header, source): (&str, &str),
    model_sha256: &str,
) -> Result<Vec<NamedFile>, ExportError> {
    fill(filling, precision, (header, source), &[model_sha256])?;
    let name = filling.text("name").to_owned();
    Ok(vec![
        NamedFile::new(format!("{name}.h"), filling.fill(header)?),
        NamedFile::new(format!("{name}.c"), filling.fill(source)?),
    ])
}

/// 64-bit FNV-1a sum of texts and their ends.
pub(crate) fn mark<'a>(texts: impl Iterator<Item = &'a str>) -> u64 {
    texts
        .flat_map(|text| text.bytes().chain([0]))
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn lines(all: impl Iterator<Item = String>) -> String {
    all.collect::<Vec<_>>().join("\n")
}

/// A sum over several lines of a macro.
fn broken(terms: &[String]) -> String {
    terms.chunks(3).map(|some| some.join(" + ")).collect::<Vec<_>>().join(" \\\n    + ")
}

/// The members of the state in a header.
fn members(header: &str, name: &str) -> Result<Vec<Member>, ExportError> {
    let odd = |place: &str| ExportError::Template { place: format!("member of a state: {place}") };
    let end = format!("}} {name}_state;");
    let before = header.split(&end).next().unwrap_or_default();
    let body = before.rsplit("typedef struct {").next().unwrap_or_default();
    let mut all = Vec::new();
    for line in body.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("/*")) {
        let Some((declared, comment)) = line.split_once(';') else {
            // The last line of a comment.
            if line.ends_with("*/") {
                continue;
            }
            return Err(odd(line));
        };
        let (of, places) = declared.split_once(' ').ok_or_else(|| odd(line))?;
        for place in places.split(',').map(str::trim) {
            let mut parts = place.split('[');
            let own = parts.next().unwrap_or_default().to_owned();
            let sizes: Vec<String> = parts.map(|size| size.trim_end_matches(']').to_owned()).collect();
            let numbers = |name: String| Member { name, kind: Kind::Numbers { sizes: sizes.clone() } };
            let whole = |name: String, bound: &str| {
                let kind = Kind::Whole { of: of.to_owned(), bound: bound.to_owned() };
                Member { name, kind }
            };
            match of.strip_prefix(name).unwrap_or(of) {
                "_real" if sizes.len() <= 2 => all.push(numbers(own)),
                "_trims" => all.extend(["gain", "offset"].map(|x| numbers(format!("{own}.{x}")))),
                "bool" if sizes.is_empty() => all.push(whole(own, "2")),
                "int32_t" | "uint32_t" if sizes.is_empty() => {
                    let bound = comment.split_once("/* below ").ok_or_else(|| odd(line))?.1;
                    all.push(whole(own, bound.split(':').next().unwrap_or_default()));
                }
                // Of units of FMI, which save their whole memory.
                "_parameters" => {}
                _ if sizes.is_empty() && of.ends_with("_state") => {
                    let of = of.trim_end_matches("_state").to_owned();
                    all.push(Member { name: own, kind: Kind::State { of } });
                }
                _ => return Err(odd(line)),
            }
        }
    }
    if all.is_empty() { Err(odd(name)) } else { Ok(all) }
}

/// Bytes of a saved state of the export `of`.
fn bytes_of(of: &str) -> String {
    format!("{}_SAVED_BYTES", of.to_ascii_uppercase())
}

impl Member {
    /// Its bytes, with numbers of this width.
    fn bytes(&self, width: usize) -> String {
        let own = |size: &String| if size.contains(' ') { format!("({size})") } else { size.clone() };
        match &self.kind {
            Kind::Numbers { sizes } => {
                [width.to_string()].into_iter().chain(sizes.iter().map(own)).collect::<Vec<_>>().join(" * ")
            }
            Kind::Whole { .. } => "4".into(),
            Kind::State { of } => format!("({})", bytes_of(of)),
        }
    }

    /// The lines that take numbers one way or the other by `function`.
    fn numbers(&self, sizes: &[String], function: &str) -> String {
        let name = &self.name;
        match sizes {
            [] => format!("    at = {function}(bytes, at, &state->{name}, 1);"),
            [size] => format!("    at = {function}(bytes, at, state->{name}, {size});"),
            [rows, size, ..] => format!(
                "    for (i = 0; i < {rows}; i++) {{\n        at = {function}(bytes, at, state->{name}[i], \
                 {size});\n    }}"
            ),
        }
    }

    fn saved(&self) -> String {
        let name = &self.name;
        match &self.kind {
            Kind::Numbers { sizes } => self.numbers(sizes, "put_reals"),
            Kind::Whole { of, .. } if of == "bool" => {
                format!("    at = put_whole(bytes, at, state->{name} ? 1u : 0u);")
            }
            Kind::Whole { .. } => format!("    at = put_whole(bytes, at, (uint32_t)state->{name});"),
            Kind::State { of } => {
                format!("    {of}_save(&state->{name}, &bytes[at]);\n    at += (uint32_t)({});", bytes_of(of))
            }
        }
    }

    fn checked(&self, at: usize, name: &str) -> String {
        let bound = if let Kind::Whole { bound, .. } = &self.kind { bound } else { "0" };
        format!(
            "    if (whole_at(bytes, {at}u) >= (uint32_t)({bound})) {{\n        return \
             {name}_NOT_SAVED;\n    }}"
        )
    }

    /// `at`: where a whole number stands.
    fn restored(&self, at: usize) -> String {
        let name = &self.name;
        match &self.kind {
            Kind::Numbers { sizes } => self.numbers(sizes, "take_reals"),
            Kind::Whole { of, .. } if of == "bool" => {
                format!("    state->{name} = whole_at(bytes, {at}u) != 0u;")
            }
            Kind::Whole { of, .. } => format!("    state->{name} = ({of})whole_at(bytes, {at}u);"),
            // The checksum over all has passed, and so does that over this part.
            Kind::State { of } => format!(
                "    (void){of}_restore(&state->{name}, &bytes[at]);\n    at += (uint32_t)({});",
                bytes_of(of)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_declaration_is_a_member_or_an_error() {
        let header = |lines: &str| format!("typedef struct {{ x\ntypedef struct {{\n{lines}\n}} s_state;");
        let text = "s_real a, b[4 + 1]; /* c */\nint32_t k; /* below K + 1: d */\nbool r;\ns_x_state x;";
        let found = members(&header(text), "s").unwrap();
        let member = |name: &str, kind| Member { name: name.into(), kind };
        let numbers = |sizes: &[&str]| Kind::Numbers { sizes: sizes.iter().map(|&s| s.into()).collect() };
        let whole = |of: &str, bound: &str| Kind::Whole { of: of.into(), bound: bound.into() };
        assert_eq!(
            found,
            [
                member("a", numbers(&[])),
                member("b", numbers(&["4 + 1"])),
                member("k", whole("int32_t", "K + 1")),
                member("r", whole("bool", "2")),
                member("x", Kind::State { of: "s_x".into() }),
            ]
        );
        assert_eq!(found[1].bytes(4), "4 * (4 + 1)");
        for bad in ["int32_t k;", "char c;", "s_real a"] {
            assert!(members(&header(bad), "s").is_err(), "{bad}");
        }
    }
}
