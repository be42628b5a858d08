//! No file is both read and written, and none written twice: exit code 2 before anything is done, with the
//! name of the file.

use crate::bench::{Bench, good_record};

/// Commands that write to IN what they read from it.
const COMMANDS: [&str; 23] = [
    "identify IN -o IN",
    "identify IN -o new.json --report IN",
    "identify --static IN --dynamic run.csv -o IN",
    "identify run.csv --start IN -o IN",
    "compare IN -o IN",
    "compare IN --report IN",
    "inspect IN --plot IN",
    "prepare IN -o IN",
    "prepare run.csv IN -o IN",
    "recalibrate model.json IN -o IN",
    "recalibrate IN run.csv -o IN",
    "adapt model.json IN -o IN",
    "adapt IN run.csv -o IN",
    "frequency-response IN --report IN",
    "frequency-response IN -o IN",
    "simulate model.json IN -o IN",
    "simulate IN run.csv -o IN",
    "invert model.json IN -o IN --range 0:100",
    "invert IN run.csv -o IN --range 0:100",
    "invert model.json run.csv --learn-from IN -o IN --range 0:100",
    "track model.json IN -o IN --range 0:100",
    "track IN run.csv --report IN --range 0:100",
    "track model.json run.csv --truth IN -o IN --range 0:100",
];

fn refused(bench: &Bench, command: &str, named: &str) {
    let before = bench.files();
    let run = bench.run(command);
    assert_eq!((run.exit_code, run.stdout.as_str()), (2, ""), "{command}: {run:?}");
    for part in [named, "because: ", "try: name another file"] {
        assert!(run.stderr.contains(part), "{command}: {part} in {}", run.stderr);
    }
    assert_eq!(bench.files(), before, "{command}");
    assert_eq!(std::fs::read_to_string(bench.path("same.svg")).unwrap(), good_record(), "{command}");
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    bench.write("same.svg", good_record());
    std::fs::create_dir(bench.path("folder")).unwrap();
    bench
}

#[test]
fn what_is_read_is_not_written_over_whatever_the_way_it_is_named() {
    let bench = bench();
    for command in COMMANDS {
        refused(&bench, &command.replace("IN", "same.svg"), "same.svg would be written over same.svg");
    }
    let twice = "simulate model.json same.svg -o folder/../same.svg";
    refused(&bench, twice, "folder/../same.svg would be written over same.svg");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("same.svg", bench.path("link.csv")).unwrap();
        refused(
            &bench,
            "simulate model.json same.svg -o link.csv",
            "link.csv would be written over same.svg",
        );
        refused(
            &bench,
            "simulate model.json link.csv -o same.svg",
            "same.svg would be written over link.csv",
        );
    }
}

#[test]
fn a_drive_is_not_replaced_by_what_the_bench_answers_to_it() {
    let bench = bench();
    bench.write("folder/same.csv", good_record());
    let run = bench.run("rig --drive folder/same.csv --out-dir folder");
    assert_eq!(run.exit_code, 2, "{run:?}");
    assert!(run.stderr.contains("folder/same.csv would be written over folder/same.csv"), "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(bench.path("folder/same.csv")).unwrap(), good_record());
    assert_eq!(std::fs::read_dir(bench.path("folder")).unwrap().count(), 1);
}

#[test]
fn two_results_do_not_share_a_file_that_is_new() {
    let bench = bench();
    for command in ["identify run.csv -o new --report ./new", "compare run.csv -o folder/../new --report new"]
    {
        refused(&bench, command, "new is named twice as the file to write");
    }
}

#[cfg(unix)]
#[test]
fn what_keeps_nothing_may_be_named_twice() {
    let bench = bench();
    let run = bench.run("compare /dev/null -o /dev/null --report /dev/null");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("cannot read the record /dev/null"), "{}", run.stderr);
}
