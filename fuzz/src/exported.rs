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

/// Largest difference in roundings of 1 µm or of the largest drive or output since the last rest or start, whichever
/// is larger: a compiler may fuse or reorder, plays subtract numbers of the size of the drive, and the dynamics
/// remember.
const ROUNDINGS: f64 = 64.0;

/// Calls that a program is sent before its answers are asked for, a change of process taking longer than a thousand
/// of them: one input's in the tests, in the fuzzer what the pipes to the program and back hold (64 KiB).
const AT_ONCE: usize = if cfg!(feature = "libfuzzer") { 2500 } else { 1 };

/// Two more calls for the driver: for the state of a program that was just started, and for the answers.
const MORE_CALLS: &str = "if (call[0] < -1.0) {
            if (fflush(stdout) != 0) {
                return 1;
            }
            continue;
        }
        if (call[0] < 0.0) {
            MODEL_init(&state);
            status = (MODEL_status)0;
        } else if (call[0] < 1.0) {";
/// The first of these calls.
const AFRESH: Call = [-1.0, 0.0, 0.0];
/// The second.
const ANSWER: Call = [-2.0, 0.0, 0.0];

/// Which, and two numbers.
type Call = [f64; 3];

/// A program around an exported model, built when first used.
struct Program {
    subject: Subject,
    runtime: Mutex<Runtime>,
    running: Mutex<Option<Running>>,
}

/// The same model in the runtime; every input begins with its memory cleared.
enum Runtime {
    F64(RuntimeParts<f64>),
    F32(RuntimeParts<f32>),
}

struct Running {
    _folder: TempDir,
    _child: Child,
    input: ChildStdin,
    output: ChildStdout,
    /// Inputs whose calls are not answered yet.
    waiting: Vec<Waiting>,
    /// Their calls in all.
    calls: usize,
}

/// The calls of an input, from the beginning.
struct Waiting {
    calls: Vec<Call>,
    /// Of each the runtime's status, and the output of a step that has one.
    expected: Vec<(f64, Option<f64>)>,
    input: Vec<u8>,
}

static PROGRAMS: LazyLock<Vec<Program>> = LazyLock::new(|| {
    let precisions = [Precision::F64, Precision::F32];
    let subjects = models::all()
        .into_iter()
        .flat_map(|(name, model)| precisions.map(|precision| models::subject(name, &model, precision)));
    let program = |subject: Subject| {
        let runtime = match subject.precision {
            Precision::F64 => RuntimeParts::new(&subject.realisation).map(Runtime::F64),
            Precision::F32 => RuntimeParts::new(&subject.realisation).map(Runtime::F32),
        };
        let runtime = Mutex::new(runtime.expect("a model of the tests"));
        Program { subject, runtime, running: Mutex::new(None) }
    };
    subjects.map(program).collect()
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
    let expected = match &mut *program.runtime.lock().unwrap_or_else(PoisonError::into_inner) {
        Runtime::F64(parts) => of_runtime(parts, &calls),
        Runtime::F32(parts) => of_runtime(parts, &calls),
    };
    let mut running = program.running.lock().unwrap_or_else(PoisonError::into_inner);
    let running = running.get_or_insert_with(|| built(&program.subject));
    running.calls += 1 + calls.len();
    running.waiting.push(Waiting { calls, expected, input: data.to_vec() });
    if running.calls >= AT_ONCE {
        running.compare(&program.subject);
    }
}

/// Status, and the output of a step that has one.
fn of_runtime<T: Real + Into<f64>>(parts: &mut RuntimeParts<T>, calls: &[Call]) -> Vec<(f64, Option<f64>)> {
    let mut model = parts.model().expect("a model of the tests");
    let answer = |[kind, first, second]: &Call| {
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
    let driver = include_str!("../../crates/hysteron-export/tests/export/driver.c")
        .replace("if (call[0] < 1.0) {", MORE_CALLS)
        .replace("MODEL", &subject.name);
    assert!(driver.contains("call[0] < 0.0"), "the driver of the tests of the exports has changed");
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
    Running { _folder: folder, _child: child, input, output, waiting: Vec::new(), calls: 0 }
}

impl Running {
    /// The answers to all that waits beside those of the runtime. The input that a fuzzer keeps for a difference is
    /// the last one: that of the difference is in its message.
    fn compare(&mut self, subject: &Subject) {
        let afresh = |waiting: &Waiting| -> Vec<Call> {
            std::iter::once(AFRESH).chain(waiting.calls.iter().copied()).collect()
        };
        let all = self.waiting.iter().flat_map(afresh).chain([ANSWER]);
        let sent: Vec<u8> = all.flatten().flat_map(f64::to_ne_bytes).collect();
        let mut answers = vec![0; 16 * self.calls];
        self.input.write_all(&sent).and_then(|()| self.output.read_exact(&mut answers)).expect("it answers");
        let number = |bytes: &[u8]| f64::from_ne_bytes(bytes.try_into().expect("eight bytes"));
        let mut answers = answers.chunks_exact(16).map(|two| [number(&two[..8]), number(&two[8..])]);
        let (name, roundings) = (&subject.name, ROUNDINGS * subject.precision.epsilon());
        for Waiting { calls, expected, input } in self.waiting.drain(..) {
            let own = answers.by_ref().skip(1).take(calls.len());
            let mut remembered = 1.0_f64;
            for (k, ([status, y], (expected, wanted))) in own.zip(expected).enumerate() {
                let place = || format!("{name}: call {k} of {calls:?}, input {input:?}");
                // The source tells extrapolation apart.
                assert_eq!(status.min(0.0), expected, "{}", place());
                if expected < 0.0 {
                    continue;
                }
                let [kind, drive, _] = calls[k];
                remembered = if kind == 0.0 { remembered } else { 1.0 }.max(drive.abs());
                if let Some(wanted) = wanted {
                    remembered = remembered.max(wanted.abs());
                    let allowed = roundings * remembered;
                    assert!((y - wanted).abs() <= allowed, "{y} instead of {wanted}, {}", place());
                }
            }
        }
        self.calls = 0;
    }
}
