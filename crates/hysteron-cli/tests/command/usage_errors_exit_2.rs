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
        ("identify run.csv -o model.json --hysteresis auto --elements 4", "families at their usual size"),
        ("identify run.csv -o model.json --creep slow", "kelvin-voigt"),
        ("identify run.csv -o model.json --creep-elements 3", "belongs to --creep kelvin-voigt"),
        ("identify run.csv -o model.json --creep kelvin-voigt --creep-elements 5", "from 1 to 4"),
        (
            "identify run.csv -o model.json --creep logarithmic --dynamics oe",
            "creep belongs to the joint fit",
        ),
        ("identify run.csv -o model.json --dynamics integer --order 13", "from 1 to 12"),
        ("identify run.csv -o model.json --dynamics modes --order 1", "from 2 to 12"),
        ("identify run.csv -o model.json --fix foo=1", "there is no parameter 'foo'"),
        ("identify run.csv -o model.json --fix gamma", "expected NAME=VALUE"),
        ("identify run.csv -o model.json --delay -1", "0 to 10 seconds"),
        ("identify run.csv -o model.json --delay -1e-3", "0 to 10 seconds"),
        ("identify run.csv -o model.json --delay --json", "expected a number or auto"),
        ("identify run.csv -o model.json --degree -1", "expected a whole number or auto"),
        ("identify run.csv -o model.json --n -1", "1 ≤ n ≤ 10"),
        ("identify run.csv -o model.json --fix x=-1", "there is no parameter 'x'"),
        ("identify run.csv -o model.json --fix -1", "expected NAME=VALUE"),
        ("identify run.csv -o model.json --bound beta=1:-1", "LOW < HIGH"),
        ("identify run.csv -o model.json --generations -3", "expected a whole number above 0"),
        ("identify run.csv -o model.json --population 0", "expected a whole number above 0"),
        ("identify run.csv -o model.json --threads -1", "expected a whole number above 0"),
        ("identify run.csv -o model.json --seed -1", "expected a whole number of at least 0"),
        ("identify run.csv -o model.json --sample-rate -.5", "expected a number above 0"),
        ("validate model.json run.csv --skip -1e-3", "expected a number of at least 0"),
        ("validate model.json run.csv --settled -1", "expected a number above 0"),
        ("validate model.json run.csv --rest-voltage nan", "expected a number"),
        ("optimizers --seeds -1", "expected a whole number of at least 0"),
        ("excite sine --frequency -1 --sample-rate 10 --high 1 -o x.csv", "expected a number above 0"),
        ("realise model.json --sample-rate 0", "expected a number above 0"),
        ("realise model.json --sample-rate -1", "expected a number above 0"),
        ("realise model.json --sample-rate 100 --accuracy 0", "expected a number above 0 and below 1"),
        ("realise model.json --sample-rate 100 --accuracy -1", "expected a number above 0 and below 1"),
        ("realise model.json --sample-rate 100 --lowest-frequency 0", "expected a number above 0"),
        ("export model.json --to c -o x --sample-rate 0", "expected a number above 0"),
        ("export model.json --to c -o x --sample-rate -1", "expected a number above 0"),
        (
            "export model.json --to c -o x --sample-rate 100 --accuracy 2",
            "expected a number above 0 and below 1",
        ),
        ("export model.json --to c -o x --sample-rate 100 --lowest-frequency 0", "expected a number above 0"),
        ("export model.json --to c -o x --sample-rate 100 --name 9x", "a letter first"),
        ("export model.json --to c -o x --inverse --preview -1", "expected a whole number of at least 0"),
        ("invert model.json run.csv -o x.csv --preview -1", "expected a whole number of at least 0"),
        ("invert model.json run.csv -o x.csv --preview some", "expected a whole number of at least 0"),
        ("rig --out-dir x --seed -1", "expected a whole number of at least 0"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.exit_code, 2, "{arguments}: {run:?}");
        assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments}");
    }
}

#[test]
fn negative_values_are_values_where_they_make_sense() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    for voltage in ["-1", "-.5", "-1e-3"] {
        let run = bench.run(&format!("validate model.json run.csv --rest-voltage {voltage}"));
        assert_eq!(run.exit_code, 0, "{voltage}: {run:?}");
    }
    let run =
        bench.run("excite sine --frequency 1 --periods 1 --sample-rate 100 --low -.5 --high 1 -o drive.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stderr.contains("-0.5 V to 1 V"), "{}", run.stderr);
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
