//! Pages of the documentation that are made from the code say what the code says.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::path::PathBuf;

use hysteron::{Capability, Kind};

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
        Kind::ALL.iter().for_each(|kind| text += if capability.of(*kind) { " yes |" } else { " not yet |" });
    }
    text + "\n"
}

#[test]
fn the_table_of_kinds_is_that_of_the_code() {
    let table = table();
    assert!(read("docs/kinds.md").contains(&table), "docs/kinds.md does not hold this table:\n{table}");
}

#[test]
fn the_tutorial_shows_the_example_of_the_front_page() {
    let front = include_str!("../src/lib.rs");
    let (_, example) = front.split_once("//! ```\n").unwrap();
    let (example, _) = example.split_once("//! ```\n").unwrap();
    let lines = example.lines().map(|line| line.strip_prefix("//! ").unwrap_or(""));
    let shown: Vec<&str> = lines.filter(|line| !line.starts_with("# ")).collect();
    assert!(read("docs/tutorial/rust.md").contains(&shown.join("\n")), "{}", shown.join("\n"));
}
