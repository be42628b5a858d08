//! What cannot be written is found before any work is done: exit code 1, the path and what to do about it,
//! nothing left behind, and no word of temporary files.

use crate::bench::{Bench, good_record};

/// Commands with OUT for the output.
const COMMANDS: [&str; 6] = [
    "identify run.csv -o OUT",
    "identify run.csv -o new.json --report OUT",
    "simulate model.json run.csv -o OUT",
    "inspect run.csv --plot OUT.svg",
    "optimizers --report OUT",
    "excite sine --frequency 1 --sample-rate 100 --high 1 -o OUT",
];

/// Commands with OUT for a folder.
const FOLDERS: [&str; 3] =
    ["identify run.csv -o new.json --figures OUT", "rig --out-dir OUT", "article --quick --out-dir OUT"];

fn refused(bench: &Bench, command: &str, parts: &[&str]) {
    let before = bench.files();
    let run = bench.run(command);
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{command}: {run:?}");
    assert!(run.stderr.starts_with("error: cannot write "), "{command}: {}", run.stderr);
    for part in parts.iter().chain(&["because: ", "try: "]) {
        assert!(run.stderr.contains(part), "{command}: {part} in {}", run.stderr);
    }
    assert!(!run.stderr.contains(".tmp") && !run.stderr.contains(".hysteron"), "{}", run.stderr);
    assert_eq!(bench.files(), before, "{command}");
}

#[cfg(target_os = "linux")]
#[test]
fn files_of_one_result_are_written_together_or_not_at_all() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    bench.write("kept.json", "what was there");
    for model in ["kept.json", "new.json"] {
        let before = bench.files();
        let flags = "--dynamics none --degree 1 --report /dev/full";
        let run = bench.run(&format!("identify run.csv {flags} -o {model}"));
        assert_eq!(run.exit_code, 1, "{run:?}");
        assert!(run.stderr.contains("/dev/full") && !run.stderr.contains("written to"), "{}", run.stderr);
        assert_eq!(bench.files(), before, "{model}");
        assert_eq!(std::fs::read_to_string(bench.path("kept.json")).unwrap(), "what was there");
    }
}

fn bench() -> Bench {
    let bench = Bench::new();
    // Too short a record to identify: whoever gets as far as the fit says something else.
    bench.write("run.csv", good_record().lines().take(5).map(|l| l.to_owned() + "\n").collect::<String>());
    bench
}

#[test]
fn a_folder_that_does_not_exist_is_named_with_the_remedy() {
    let bench = bench();
    for command in COMMANDS {
        refused(&bench, &command.replace("OUT", "no/such/out"), &["no/such/out", "mkdir -p no/such"]);
    }
}

#[test]
fn a_folder_is_no_file_and_a_file_no_folder() {
    let bench = bench();
    for folder in ["here", "here.svg"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    for command in COMMANDS {
        refused(&bench, &command.replace("OUT", "here"), &["here", "it is a folder, not a file"]);
    }
    for command in FOLDERS {
        for folder in ["run.csv", "run.csv/below"] {
            let command = command.replace("OUT", folder);
            refused(&bench, &command, &[folder, "run.csv is a file, not a folder"]);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_may_not_be_written_to_is_found_too() {
    let bench = bench();
    // Nobody, not even root, makes files here.
    for command in COMMANDS.iter().chain(&FOLDERS) {
        let said = ["/proc/self/out", "no file can be made in /proc/self: "];
        refused(&bench, &command.replace("OUT", "/proc/self/out"), &said);
    }
}

#[test]
fn what_can_be_written_is_not_touched_before_it_is_there() {
    let bench = bench();
    bench.write("new.json", "precious");
    let run = bench.run("identify run.csv -o new.json --report new.html --figures figures");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("need at least 20 valid samples"), "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(bench.path("new.json")).unwrap(), "precious");
    assert_eq!(bench.files(), ["model.json", "new.json", "run.csv"]);
}

/// With links of its own in the place of `/dev/stdout`, which a defect would replace for the whole machine.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_is_written_directly_be_it_a_pipe_or_a_file() {
    use std::os::unix::fs::symlink;
    use std::process::{Command, Stdio};
    let bench = bench();
    symlink("/proc/self/fd/1", bench.path("stdout")).unwrap();
    symlink("stdout", bench.path("chain")).unwrap();
    let wave = "excite sine --frequency 1 --sample-rate 100 --high 1 -o";
    assert_eq!(bench.run(&format!("{wave} drive.csv")).exit_code, 0);
    let drive = std::fs::read_to_string(bench.path("drive.csv")).unwrap();
    for link in ["stdout", "chain"] {
        let run = bench.run(&format!("{wave} {link}"));
        assert_eq!(run.exit_code, 0, "{run:?}");
        assert!(run.stdout.contains(&drive), "{run:?}");
        // Redirected to a file that holds something: nothing is lost, nothing replaced.
        std::fs::write(bench.path("log"), "before\n").unwrap();
        let log = std::fs::OpenOptions::new().append(true).open(bench.path("log")).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_hysteron"));
        command.args(wave.split(' ')).arg(link).current_dir(bench.path("."));
        assert!(command.stdout(log).stderr(Stdio::null()).status().unwrap().success());
        let log = std::fs::read_to_string(bench.path("log")).unwrap();
        assert!(log.starts_with("before\n") && log.contains(&drive), "{log}");
        assert!(bench.path(link).is_symlink(), "{link}");
    }
}
