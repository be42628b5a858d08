//! Every command of "From record to controller" runs, in order.

use std::path::Path;
use std::process::Command;

use crate::bench::Bench;

const PAGE: &str = "../../docs/tutorial/controller.md";

/// The shell blocks of a page.
fn blocks(page: &str) -> Vec<String> {
    page.split("\n```sh\n").skip(1).map(|rest| rest.split("\n```").next().unwrap().to_owned()).collect()
}

#[test]
fn from_record_to_controller() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE)).unwrap();
    let blocks = blocks(&page);
    assert!(blocks.len() >= 6, "{blocks:?}");
    let bench = Bench::new();
    let program = Path::new(env!("CARGO_BIN_EXE_hysteron")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    for block in blocks {
        let run = Command::new("bash")
            .args(["-euo", "pipefail", "-c", &block])
            .current_dir(bench.path(""))
            .env("PATH", &path)
            .output()
            .unwrap();
        let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        println!("$ {block}\n{}", said(&run.stdout));
        assert!(run.status.success(), "{block}\n{}\n{}", said(&run.stdout), said(&run.stderr));
    }
    // What it ends with: models that were made, a drive, source that passes its own test.
    for name in ["stage.json", "drive.csv", "track.csv", "firmware/stage.c", "selftest"] {
        assert!(bench.path(name).exists(), "{name}");
    }
}
