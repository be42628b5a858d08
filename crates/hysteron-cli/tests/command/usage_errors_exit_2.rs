//! Wrong usage exits with 2, says what is wrong on standard error and prints nothing on standard output.

use crate::bench::{Bench, good_record};

#[test]
fn wrong_usage_exits_with_2_and_a_message() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    for (arguments, part) in [
        ("frobnicate", "unrecognized subcommand 'frobnicate'"),
        ("validate", "MODEL.json"),
        ("validate model.json", "RECORD"),
        ("validate model.json run.csv --skip", "--skip"),
        ("validate model.json run.csv --skip -1", "--skip"),
        ("validate model.json run.csv --skip soon", "expected a number of at least 0"),
        ("validate model.json run.csv --sample-rate 0", "expected a number above 0"),
        ("validate model.json run.csv --no-such-flag", "unexpected argument '--no-such-flag'"),
        ("simulate model.json run.csv", "--out"),
        ("completions tcsh", "tcsh"),
        ("identify run.csv", "--output-model"),
        ("identify run.csv -o model.json --degree 12", "a whole number from 1 to 9"),
        ("identify run.csv -o model.json --fix foo=1", "there is no parameter 'foo'"),
        ("identify run.csv -o model.json --fix gamma", "expected NAME=VALUE"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.exit_code, 2, "{arguments}: {run:?}");
        assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments}");
    }
}

#[test]
fn help_is_no_error_and_every_command_shows_an_example() {
    let bench = Bench::new();
    let run = bench.run("--help");
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""));
    let listed = run.stdout.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    // A command's name is indented by two blanks; what it does may run on below, further in.
    let named = listed.lines().filter_map(|l| l.strip_prefix("  ")).filter(|l| !l.starts_with(' '));
    let commands: Vec<&str> = named.filter_map(|l| l.split_whitespace().next()).collect();
    assert!(commands.contains(&"validate") && commands.contains(&"simulate"), "{commands:?}");
    for command in commands.into_iter().filter(|c| *c != "help" && !c.is_empty()) {
        let help = bench.run(&format!("{command} --help"));
        assert_eq!(help.exit_code, 0, "{command}");
        let examples = help.stdout.split("Example").nth(1).unwrap_or_default();
        assert!(examples.contains(&format!("hysteron {command} ")), "{command}:\n{}", help.stdout);
    }
}
