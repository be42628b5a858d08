//! Programs that the tests need, and what they say.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

/// Flags under which the exported C must compile without a word.
pub const STRICT: [&str; 7] =
    ["-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror"];

/// Says what is not tested, past the capture of the test's output.
pub fn skipped(what: &str, without: &str) {
    let _ = writeln!(
        std::io::stderr(),
        "\nSKIPPED: {what} is not installed, so that {without} (make test installs it where it may)"
    );
}

/// Whether a program can be started; says so where not.
pub fn is_there(program: &str, without: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    if !there {
        skipped(program, without);
    }
    there
}

/// C compilers of this machine.
pub fn c_compilers() -> Vec<&'static str> {
    ["gcc", "clang"].into_iter().filter(|c| is_there(c, "the exported C was not compiled by it")).collect()
}

/// Whether every model is to be combined with everything else (make test-exports), which takes its time.
fn is_exhaustive() -> bool {
    std::env::var_os("HYSTERON_EVERY_EXPORT").is_some()
}

/// Every third of these, or all.
pub fn thinned<T>(all: Vec<T>) -> impl Iterator<Item = T> {
    all.into_iter().step_by(if is_exhaustive() { 1 } else { 3 })
}

/// The choice (compiler, number type, flags) to take with the `k`-th model, another one with the next; or all.
pub fn choices<T: Copy>(all: &[T], k: usize) -> Vec<T> {
    if is_exhaustive() {
        return all.to_vec();
    }
    all.iter().copied().cycle().skip(k).take(1).collect()
}

/// Every pair of one of these and one of those, in which the last changes first.
pub fn pairs<A: Copy, B: Copy>(first: &[A], second: &[B]) -> Vec<(A, B)> {
    first.iter().flat_map(|a| second.iter().map(|b| (*a, *b))).collect()
}

/// Runs a program, which must succeed; its output.
pub fn run(folder: &Path, program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> String {
    let program = program.as_ref();
    let output: Output = Command::new(program).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{program:?} {arguments:?}: {}\n{}{}",
        output.status,
        text(&output.stdout),
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// Manifest of a workspace of exported crates, built once: without debug information and incremental
/// state, which take a gigabyte.
pub fn workspace_of(members: &[String]) -> String {
    format!(
        "[workspace]\nresolver = \"3\"\nmembers = [{}]\n\n\
         [profile.dev]\ndebug = false\nincremental = false\n",
        members.join(", ")
    )
}
