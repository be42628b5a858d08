//! Several outputs of one command: when one cannot be written, the others are what they were, and the message
//! says so.
#![cfg(target_os = "linux")]

use crate::bench::Bench;
use crate::every_command::records;

/// Commands of more than one output: KEPT comes before what a full device refuses.
const COMMANDS: [&str; 8] = [
    "identify loop.csv --dynamics none --degree 1 --least-fit 0 -o KEPT.json --report /dev/full",
    "identify loop.csv --dynamics none --degree 1 --least-fit 0 -o KEPT.json --report KEPT.html \
     --figures /dev/full",
    "identify force.csv --structure force --least-fit 0 -o KEPT.json --report /dev/full",
    "frequency-response response.csv --structure integer -o KEPT.json --report /dev/full",
    "compare loop.csv sweep.csv --candidates none,integer1,integer2 -o KEPT.json --report /dev/full",
    "validate model.json loop.csv -o KEPT.csv --report /dev/full",
    "validate model.json loop.csv -o /dev/full --report KEPT.html",
    "track model.json reference.csv --plant model --range 0:40 --controller feedforward -o KEPT.csv \
     --report /dev/full",
];

#[test]
fn what_was_there_stays_when_another_output_is_refused() {
    let bench = Bench::new();
    records().into_iter().for_each(|(name, text)| bench.write(name, text));
    for command in COMMANDS {
        // What was there, and what was not.
        for old in [Some("what was there"), None] {
            for name in ["old.json", "old.csv", "old.html"] {
                match old {
                    Some(old) => bench.write(name, old),
                    None => std::fs::remove_file(bench.path(name)).unwrap(),
                }
            }
            let before = bench.files();
            let run = bench.run(&command.replace("KEPT", "old"));
            assert_eq!(run.exit_code, 1, "{command}: {run:?}");
            assert!(run.stderr.contains("/dev/full"), "{command}: {}", run.stderr);
            assert!(!run.stderr.contains("written to"), "{command}: {}", run.stderr);
            // What a comparison found is kept, to be written elsewhere.
            let kept = bench.path("old.searches.json");
            assert_eq!(kept.exists(), command.starts_with("compare"), "{command}");
            if kept.exists() {
                assert!(run.stderr.contains("--resume old.searches.json"), "{command}: {}", run.stderr);
                std::fs::remove_file(kept).unwrap();
            }
            assert_eq!(bench.files(), before, "{command}");
            for name in before.iter().filter(|name| name.starts_with("old")) {
                assert_eq!(std::fs::read_to_string(bench.path(name)).unwrap(), "what was there", "{command}");
            }
            // The folder of the figures is refused before anything is computed.
            if !command.contains("--figures") {
                let said = "none of the files of this result was written, and what was there stays";
                assert!(run.stderr.contains(said), "{command}: {}", run.stderr);
            }
        }
    }
}
