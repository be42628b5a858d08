//! `schema` prints the published JSON Schema, `completions` a script for every shell.

use crate::bench::Bench;

#[test]
fn schema_prints_what_is_published() {
    let schema = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema/hysteron-model-2.schema.json");
    let run = Bench::new().run("schema");
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
    assert_eq!(run.stdout, std::fs::read_to_string(schema).unwrap());
}

#[test]
fn completions_are_there_for_every_shell_and_know_the_commands() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let run = Bench::new().run(&format!("completions {shell}"));
        assert_eq!(run.exit_code, 0, "{shell}");
        assert!(run.stdout.contains("validate") && run.stdout.contains("simulate"), "{shell}");
    }
}
