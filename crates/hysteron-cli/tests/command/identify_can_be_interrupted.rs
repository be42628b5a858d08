//! Ctrl-C keeps the best so far; resuming gives the same final bits as a run without a break.

use crate::bench::Bench;
use std::fmt::Write;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A record whose search of 400 000 generations takes far longer than the test waits.
fn long_record() -> String {
    let mut text = "t_s,u_V,y_um\n".to_owned();
    for k in 0..2_000 {
        let t = f64::from(k) / 1_000.0;
        let u = 5.0 - 5.0 * (std::f64::consts::TAU * t).cos();
        let y = 2.0 * u + 0.03 * u * u - (std::f64::consts::TAU * t).sin();
        writeln!(text, "{t},{u},{y}").unwrap();
    }
    text
}

#[cfg(unix)]
fn start(bench: &Bench, extra: &str) -> Child {
    let flags = "--degree 2 --optimizer de --population 8 --seed 3 --threads 1";
    Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(format!("identify long.csv {flags} {extra}").split_whitespace())
        .current_dir(bench.path("."))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn an_interrupted_fit_keeps_the_best_and_resumes_to_the_same_bits() {
    let bench = Bench::new();
    bench.write("long.csv", long_record());
    let start = |extra: &str| start(&bench, extra);
    bench.write("cut.json", "precious");
    // Interrupted after the small fits that choose the start, in the search itself: wait longer on a slow
    // machine.
    let reached = [1, 3, 9].into_iter().find_map(|seconds| {
        let child = start("-o cut.json --generations 400000");
        std::thread::sleep(Duration::from_secs(seconds));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let began = Instant::now();
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(began.elapsed() < Duration::from_secs(20), "it stops soon");
        assert!(said.contains("--resume cut.partial.json"), "{said}");
        assert!(bench.path("cut.partial.json").exists(), "the best so far is kept");
        assert_eq!(
            std::fs::read_to_string(bench.path("cut.json")).unwrap(),
            "precious",
            "what was there stays"
        );
        generation(&std::fs::read_to_string(bench.path("cut.searches.json")).unwrap())
    });
    let reached = reached.unwrap();
    ends_as_without_a_break(&bench, reached, "cut.partial.json", start);
}

#[cfg(unix)]
#[test]
fn a_fit_that_is_killed_goes_on_from_its_last_state() {
    let bench = Bench::new();
    bench.write("long.csv", long_record());
    let start = |extra: &str| start(&bench, extra);
    let mut child = start("-o cut.json --generations 400000");
    let kept = bench.path("cut.searches.json");
    let begun = Instant::now();
    let reached = loop {
        assert!(begun.elapsed() < Duration::from_secs(60), "no state of the search is kept");
        std::thread::sleep(Duration::from_millis(50));
        if let Some(reached) = std::fs::read_to_string(&kept).ok().and_then(|text| generation(&text)) {
            break reached;
        }
    };
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!bench.path("cut.json").exists());
    let reached = generation(&std::fs::read_to_string(&kept).unwrap()).unwrap().max(reached);
    ends_as_without_a_break(&bench, reached, "cut.searches.json", start);
}

/// A resumed run must be of the same length; goes on from the interrupted state to the end of a run cut short.
#[cfg(unix)]
fn ends_as_without_a_break(bench: &Bench, reached: usize, from: &str, start: impl Fn(&str) -> Child) {
    let text = std::fs::read_to_string(bench.path("cut.searches.json")).unwrap();
    let total = reached + 3;
    let shorter = text.replace("\"generations\":400000", &format!("\"generations\":{total}"));
    bench.write("cut.searches.json", shorter);
    assert!(
        start(&format!("-o resumed.json --generations {total} --resume {from}")).wait().unwrap().success()
    );
    assert!(start(&format!("-o straight.json --generations {total}")).wait().unwrap().success());
    let block = |name: &str| {
        let file: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(bench.path(name)).unwrap()).unwrap();
        file["hysteresis"].to_string()
    };
    assert_eq!(block("resumed.json"), block("straight.json"));
}

#[cfg(unix)]
#[test]
fn a_terminated_fit_exits_with_143_and_its_partial_model_is_read_like_any() {
    let bench = Bench::new();
    bench.write("long.csv", long_record());
    let child = Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args("identify long.csv --optimizer de --population 8 --generations 400000 -o cut.json".split(' '))
        .current_dir(bench.path("."))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(143), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!bench.path("cut.json").exists());
    let run = bench.run("validate cut.partial.json long.csv");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
}

/// Generation that the interrupted main search had reached; `None` if it had not begun.
fn generation(searches: &str) -> Option<usize> {
    let state: serde_json::Value = serde_json::from_str(searches).unwrap();
    let (_, search) = state["searches"].as_object()?.iter().find(|(k, _)| *k == "joint fit")?;
    Some(search["ledger"]["generation"].as_u64()? as usize)
}
