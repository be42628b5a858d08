//! Every input of the corpus, those that once broke a promise among them, taken again.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

#[test]
fn every_input_of_the_corpus_is_taken() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for entry in hysteron_fuzz::ENTRIES {
        let folder = corpus.join(entry.name);
        let mut taken = 0;
        for input in std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
            let path = input.unwrap().path();
            // Shown where the input breaks a promise.
            println!("{}", path.display());
            (entry.take)(&std::fs::read(&path).unwrap());
            taken += 1;
        }
        assert!(taken > 0, "{} has no input", folder.display());
    }
}

/// Digits in groups of three.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).unwrap()).collect();
    groups.join(" ")
}

#[test]
fn the_table_in_the_docs_is_that_of_the_counts() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    let counts: serde_json::Value = serde_json::from_str(&read("executions.json")).unwrap();
    let docs = read("../docs/trust.md");
    for entry in hysteron_fuzz::ENTRIES {
        let number = |what: &str| grouped(counts[entry.name][what].as_u64().unwrap_or(0));
        let [executions, seconds, edges] = ["executions", "seconds", "coverage"].map(number);
        let row = format!("| `{}` | {executions} | {seconds} | {edges} |\n", entry.name);
        assert!(docs.contains(&row), "scripts/fuzz.py --table prints the table of docs/trust.md: {row}");
    }
}
