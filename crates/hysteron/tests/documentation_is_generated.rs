//! Pages of the documentation that are made from the code say what the code says.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::path::PathBuf;

use hysteron::{Capability, HysteresisForm, Kind, Unsupported};
use hysteron_model::hysteresis::{DriveSpan, NumberUnit};
use serde_json::Value;

fn read(path: &str) -> String {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::fs::read_to_string(root.join(path)).unwrap()
}

/// What each kind of model does, as a table of Markdown.
fn table() -> String {
    let mut text = String::from("| |");
    Kind::ALL.iter().for_each(|kind| text += &format!(" `{kind}` |"));
    text += "\n| --- |";
    text += &" --- |".repeat(Kind::ALL.len());
    for capability in Capability::ALL {
        text += &format!("\n| {capability} |");
        for kind in Kind::ALL {
            text += match Unsupported::check(kind, capability) {
                Ok(()) => " yes |",
                Err(unsupported) if unsupported.reason().is_some() => " no |",
                Err(_) => " not yet |",
            };
        }
    }
    text + "\n"
}

#[test]
fn the_table_of_kinds_is_that_of_the_code() {
    let table = table();
    assert!(read("docs/kinds.md").contains(&table), "docs/kinds.md does not hold this table:\n{table}");
}

/// The first example of a source file's documentation, without its hidden lines.
fn example(source: &str) -> String {
    let (_, example) = source.split_once("//! ```\n").unwrap();
    let (example, _) = example.split_once("//! ```\n").unwrap();
    let lines = example.lines().map(|line| line.strip_prefix("//! ").unwrap_or(""));
    lines.filter(|line| !line.starts_with("# ")).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_tutorial_shows_the_example_of_the_front_page() {
    let shown = example(include_str!("../src/lib.rs"));
    assert!(read("docs/tutorial/rust.md").contains(&shown), "{shown}");
}

#[test]
fn the_readme_shows_the_example_of_the_prelude() {
    let shown = example(include_str!("../src/prelude.rs"));
    assert!(read("README.md").contains(&format!("```rust\n{shown}\n```")), "{shown}");
}

#[test]
fn the_front_page_links_every_public_type() {
    let source = include_str!("../src/lib.rs");
    let documented: String = source.lines().filter(|line| line.starts_with("//!")).collect();
    let exports = source.split("pub use ").skip(1).filter_map(|rest| rest.split_once(';'));
    let names: Vec<&str> = exports
        .flat_map(|(path, _)| path.split(|c: char| !c.is_alphanumeric()))
        .filter(|name| name.starts_with(char::is_uppercase))
        .collect();
    assert!(names.len() > 40, "only {} public types were found", names.len());
    let missing: Vec<_> = names.iter().filter(|name| !documented.contains(&format!("[`{name}`]"))).collect();
    assert!(missing.is_empty(), "the front page of the library does not link {missing:?}");
}

/// Unit of a number of a family for signals in V and µm, as model files write it.
fn unit(unit: NumberUnit) -> String {
    let powers = [("um", unit.output), ("V", unit.input), ("s", unit.time)];
    let factors = |sign: i32| -> String {
        let factors = powers.iter().filter(|(_, power)| power * sign > 0);
        let shown = factors.map(|(symbol, power)| match power.abs() {
            1 => (*symbol).to_owned(),
            power => format!("{symbol}^{power}"),
        });
        shown.collect::<Vec<_>>().join("*")
    };
    match (factors(1), factors(-1)) {
        (above, below) if below.is_empty() => {
            if above.is_empty() {
                "1".to_owned()
            } else {
                above
            }
        }
        (above, below) => format!("{}/{below}", if above.is_empty() { "1" } else { &above }),
    }
}

/// Numbered names, `a_1`, `a_2`, `a_3`, are shown by the first and the last of them.
fn numbers(numbers: impl Iterator<Item = (String, String)>) -> String {
    let mut groups: Vec<(String, Vec<String>, String)> = Vec::new();
    for (name, after) in numbers {
        let base = name.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
        match groups.iter_mut().find(|(group, _, _)| *group == base && base != name) {
            Some((_, names, _)) => names.push(name),
            None => groups.push((base, vec![name], after)),
        }
    }
    let shown = groups.iter().map(|(_, names, after)| match names.as_slice() {
        [name] => format!("`{name}` {after}"),
        names => format!("`{}` … `{}` {after}", names[0], names[names.len() - 1]),
    });
    shown.collect::<Vec<_>>().join("; ")
}

/// The families of hysteresis with the parameters of their usual number of elements, as a table of Markdown.
fn families() -> String {
    let mut text = String::from("| `kind` | in v, beside the polynomial | shape parameters | weights |\n");
    text += "| --- | --- | --- | --- |\n";
    for form in HysteresisForm::usual() {
        let family = form.description();
        let shape = form.shape_numbers(&DriveSpan::UNIT).into_iter();
        let shape = numbers(shape.map(|n| (n.name, format!("[{}], {}", unit(n.unit), n.meaning))));
        let weights = form.weight_names().into_iter().enumerate();
        let weights = numbers(weights.map(|(i, name)| (name, format!("[{}]", unit(family.weight_unit(i))))));
        let equation = family.equation().replace('|', "\\|");
        text += &format!("| `{}` | {equation} | {shape} | {weights} |\n", form.name());
    }
    text
}

#[test]
fn the_page_of_formats_has_every_family_with_its_parameters() {
    let table = families();
    assert!(read("docs/formats.md").contains(&table), "docs/formats.md does not hold this table:\n{table}");
}

/// The properties of a type of the schema and of the types in it, each with the type that it belongs to.
fn properties(schema: &Value, name: &str, seen: &mut Vec<(String, String)>) {
    fn referred(value: &Value, names: &mut Vec<String>) {
        match value {
            Value::Object(map) => map.iter().for_each(|(key, value)| match value.as_str() {
                Some(target) if key == "$ref" => {
                    names.extend(target.split('/').next_back().map(str::to_owned))
                }
                _ => referred(value, names),
            }),
            Value::Array(values) => values.iter().for_each(|value| referred(value, names)),
            _ => {}
        }
    }
    fn keys(value: &Value, out: &mut Vec<String>) {
        if let Some(map) = value.get("properties").and_then(Value::as_object) {
            for (key, value) in map {
                out.push(key.clone());
                keys(value, out);
            }
        }
    }
    let definition = &schema["$defs"][name];
    let (mut names, mut own) = (Vec::new(), Vec::new());
    referred(definition, &mut names);
    keys(definition, &mut own);
    // The parameters of the hysteresis block are those of the table of families.
    let own = own.into_iter().filter(|_| name != "Parameters").map(|key| (name.to_owned(), key));
    let new: Vec<_> = own.filter(|property| !seen.contains(property)).collect();
    if !new.is_empty() {
        seen.extend(new);
        names.iter().for_each(|name| properties(schema, name, seen));
    }
}

#[test]
fn the_page_of_formats_has_every_key_of_every_kind_of_model_file() {
    let schema: Value = serde_json::from_str(&read("docs/schema/hysteron-model-2.schema.json")).unwrap();
    let page = read("docs/formats.md");
    let (_, page) = page.split_once("\n## Model file: JSON\n").unwrap();
    let (page, _) = page.split_once("\n## ").unwrap();
    let sections: Vec<&str> = page.split("\n### ").collect();
    let common = ["Keys of every kind", "Numbers, intervals, scores"];
    let of = |title: &str| sections.iter().find(|section| section.starts_with(title)).unwrap();
    let kinds = [
        ("ModelFile", "`hammerstein`"),
        ("OscillatorFile", "`oscillator`"),
        ("ForceFile", "`force`"),
        ("ModesFile", "`modes`"),
        ("CoupledFile", "`branches`"),
    ];
    assert_eq!(schema["anyOf"].as_array().unwrap().len(), kinds.len());
    for (name, title) in kinds {
        let mut wanted = Vec::new();
        properties(&schema, name, &mut wanted);
        assert!(wanted.len() > 20, "{name}: only {} keys", wanted.len());
        let text = [of(title), of(common[0]), of(common[1])].map(|section| section.to_owned()).join("\n");
        let missing: Vec<_> = wanted.iter().filter(|(_, key)| !text.contains(&format!("`{key}`"))).collect();
        assert!(missing.is_empty(), "docs/formats.md, {title}, lacks {missing:?}");
    }
}
