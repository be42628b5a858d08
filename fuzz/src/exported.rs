//! The exported C beside the runtime, call by call: the same statuses, the same outputs.

use std::io::{Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{LazyLock, Mutex, PoisonError};

use hysteron_export::{Precision, Subject, c_files, write_folder};
use hysteron_model::realise::RuntimeParts;
use hysteron_rt::{ModelError, Real};
use tempfile::TempDir;

use crate::numbers::Bytes;

#[allow(dead_code, clippy::unwrap_used, reason = "shared with the tests of the exports")]
#[path = "../../crates/hysteron-export/tests/export/models.rs"]
pub mod models;

/// Largest difference over the output's size or 1 µm, in roundings: a compiler may fuse or reorder.
const ROUNDINGS: f64 = 64.0;

/// One more call for the driver: the state of a program that was just started.
const AFRESH: &str = "if (call[0] < 0.0) {
            MODEL_init(&state);
            status = (MODEL_status)0;
        } else if (call[0] < 1.0) {";

/// A program around an exported model, built when first used.
struct Program {
    subject: Subject,
    running: Mutex<Option<Running>>,
}

struct Running {
    _folder: TempDir,
    _child: Child,
    input: ChildStdin,
    output: ChildStdout,
}

static PROGRAMS: LazyLock<Vec<Program>> = LazyLock::new(|| {
    let precisions = [Precision::F64, Precision::F32];
    let subjects = models::all()
        .into_iter()
        .flat_map(|(name, model)| precisions.map(|precision| models::subject(name, &model, precision)));
    subjects.map(|subject| Program { subject, running: Mutex::new(None) }).collect()
});

/// Which program, then calls.
pub fn steps(data: &[u8]) {
    let mut bytes = Bytes(data);
    let program = &PROGRAMS[usize::from(bytes.byte()) % PROGRAMS.len()];
    let mut calls = vec![[1.0, 0.0, 0.0]];
    while !bytes.is_empty() && calls.len() < 64 {
        calls.push(match bytes.byte() % 16 {
            0 => [1.0, bytes.number(100.0), 0.0],
            1 => [2.0, bytes.number(100.0), bytes.number(50.0)],
            _ => [0.0, bytes.number(100.0), 0.0],
        });
    }
    let precision = program.subject.precision;
    let expected = match precision {
        Precision::F64 => of_runtime::<f64>(&program.subject, &calls),
        Precision::F32 => of_runtime::<f32>(&program.subject, &calls),
    };
    let mut running = program.running.lock().unwrap_or_else(PoisonError::into_inner);
    let running = running.get_or_insert_with(|| built(&program.subject));
    let answers = running.answers(&calls);
    for (k, ([status, y], expected)) in answers.into_iter().zip(expected).enumerate() {
        // The source tells extrapolation apart.
        assert_eq!(status.min(0.0), expected.0, "{}: call {k} of {calls:?}", program.subject.name);
        if let Some(wanted) = expected.1 {
            let allowed = ROUNDINGS * precision.epsilon() * wanted.abs().max(1.0);
            assert!(
                (y - wanted).abs() <= allowed,
                "{}: {y} instead of {wanted}, call {k} of {calls:?}",
                program.subject.name
            );
        }
    }
}

/// Status, and the output of a step that has one.
fn of_runtime<T: Real + Into<f64>>(subject: &Subject, calls: &[[f64; 3]]) -> Vec<(f64, Option<f64>)> {
    let mut parts = RuntimeParts::<T>::new(&subject.realisation).expect("a model of the tests");
    let mut model = parts.model().expect("a model of the tests");
    let answer = |[kind, first, second]: &[f64; 3]| {
        let found = match *kind {
            0.0 => model.step(T::of(*first)).map(Some),
            1.0 => model.rest_at(T::of(*first)).map(Some),
            _ => model.start_at(T::of(*first), T::of(*second)).map(|()| None),
        };
        match found {
            Ok(y) => (0.0, y.map(Into::into)),
            Err(ModelError::NotFinite | ModelError::Start { .. }) => (-1.0, None),
            Err(_) => (-2.0, None),
        }
    };
    calls.iter().map(answer).collect()
}

fn built(subject: &Subject) -> Running {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = c_files(subject).expect("a model of the tests");
    write_folder(folder.path(), &files).expect("a temporary folder takes files");
    // Answers at once, where the one of the tests is asked everything first.
    let driver = include_str!("../../crates/hysteron-export/tests/export/driver.c")
        .replace("1, stdout) != 1", "1, stdout) != 1 || fflush(stdout) != 0")
        .replace("if (call[0] < 1.0) {", AFRESH)
        .replace("MODEL", &subject.name);
    assert!(
        driver.contains("fflush") && driver.contains("call[0] < 0.0"),
        "the driver of the tests of the exports has changed"
    );
    std::fs::write(folder.path().join("driver.c"), driver).expect("a temporary folder takes files");
    let source = format!("{}.c", subject.name);
    let made = Command::new("cc")
        .args(["-std=c99", "-O1", "-ffp-contract=off", &source, "driver.c", "-o", "driver", "-lm"])
        .current_dir(folder.path())
        .status();
    assert!(made.is_ok_and(|status| status.success()), "cc does not build {source}");
    let mut child = Command::new(folder.path().join("driver"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let (input, output) = (child.stdin.take(), child.stdout.take());
    let (input, output) = (input.expect("a pipe"), output.expect("a pipe"));
    Running { _folder: folder, _child: child, input, output }
}

impl Running {
    /// From the beginning, and all at once, which the pipes hold: a change of process for each call takes
    /// longest.
    fn answers(&mut self, calls: &[[f64; 3]]) -> Vec<[f64; 2]> {
        let all = std::iter::once(&[-1.0, 0.0, 0.0]).chain(calls);
        let sent: Vec<u8> = all.flatten().flat_map(|x| x.to_ne_bytes()).collect();
        let mut answers = vec![0; 16 * (1 + calls.len())];
        self.input.write_all(&sent).and_then(|()| self.output.read_exact(&mut answers)).expect("it answers");
        let number = |bytes: &[u8]| f64::from_ne_bytes(bytes.try_into().expect("eight bytes"));
        answers.chunks_exact(16).skip(1).map(|answer| [number(&answer[..8]), number(&answer[8..])]).collect()
    }
}
