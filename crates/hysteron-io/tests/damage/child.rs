//! One file read in a process of its own, so that its memory and time can be told.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use hysteron_io::{ReadOptions, contents, read_record};

use super::{LONGEST, MOST_MEMORY_KB, peak_memory_kb, processor_time};

/// The file that the other process reads.
const FILE: &str = "HYSTERON_HOSTILE_FILE";
/// Begins the line in which it tells what came of it.
const MARK: &str = "came of it: ";
/// Readings of a file in the other process.
const READINGS: u32 = 3;
/// Times as long as on a machine of its own, on one that does other work as well.
const BUSY: u32 = 6;
/// No reader needs as much; a machine without it would swap \[kB\].
const MOST_ADDRESSES_KB: u64 = 8 << 20;

/// What came of reading a file.
pub struct Reading {
    pub peak_kb: u64,
    pub took: Duration,
    /// Refusals of its contents, of its record, and of its record with the first column as input; empty where
    /// it was read.
    pub refusals: Vec<String>,
}

/// Reads the file in a process that runs `test` of this binary, which must be [`read_given`]. Panics where it
/// takes more memory or time than reading may.
pub fn read_apart(path: &Path, test: &str) -> Reading {
    let mut command = if cfg!(unix) {
        let mut limited = Command::new("sh");
        limited.args(["-c", &format!("ulimit -v {MOST_ADDRESSES_KB}; exec \"$0\" \"$@\"")]);
        limited.arg(std::env::current_exe().unwrap());
        limited
    } else {
        Command::new(std::env::current_exe().unwrap())
    };
    command.args([test, "--exact", "--ignored", "--nocapture"]).env(FILE, path);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > BUSY * READINGS * LONGEST {
            child.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    let text =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}, {:?}: {text}", path.display(), start.elapsed());
    let told = text.lines().find_map(|line| Some(line.split_once(MARK)?.1)).unwrap();
    let (peak_kb, took, refusals): (u64, f64, Vec<String>) = serde_json::from_str(told).unwrap();
    let took = Duration::from_secs_f64(took);
    assert!(peak_kb < MOST_MEMORY_KB, "{}: {peak_kb} kB of memory", path.display());
    assert!(took < LONGEST, "{}: {took:?}", path.display());
    Reading { peak_kb, took, refusals }
}

/// Reads the file that the process is given, if it is given one, and tells what came of it.
pub fn read_given() {
    let Some(path) = std::env::var_os(FILE) else { return };
    let path = Path::new(&path);
    let first = ReadOptions { input: Some("1".to_owned()), ..ReadOptions::default() };
    let mut longest = Duration::ZERO;
    let begun = Instant::now();
    let now = || processor_time().unwrap_or_else(|| begun.elapsed());
    let mut timed = |read: &dyn Fn() -> Result<(), hysteron_io::IoError>| {
        let start = now();
        let refusal = read().err().map(|error| error.to_string()).unwrap_or_default();
        longest = longest.max(now() - start);
        refusal
    };
    let refusals = vec![
        timed(&|| contents(path, &ReadOptions::default()).map(drop)),
        timed(&|| read_record(path, &ReadOptions::default()).map(drop)),
        timed(&|| read_record(path, &first).map(drop)),
    ];
    let told = (peak_memory_kb().unwrap_or_default(), longest.as_secs_f64(), refusals);
    println!("{MARK}{}", serde_json::to_string(&told).unwrap());
}

/// A hostile file: what it is, its bytes, and what one of its refusals must say, if anything.
pub type Bomb = (&'static str, Box<dyn Fn() -> Vec<u8>>, Option<&'static str>);

/// Reads each as a file of this name, in a process that runs the binary's `reads_the_file_given`. Panics
/// where one takes more memory or time than reading may, is not refused as it must be, or gives a message
/// that nobody reads.
pub fn each_within_limits(file: &str, bombs: impl IntoIterator<Item = Bomb>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(file);
    for (name, make, due) in bombs {
        let bytes = make();
        std::fs::write(&path, &bytes).unwrap();
        let (read, kb) = (read_apart(&path, "reads_the_file_given"), bytes.len() / 1000);
        drop(bytes);
        let refusal = &read.refusals[1];
        println!("{name}: {kb} kB, {} MB of memory, {:?}; {refusal}", read.peak_kb / 1000, read.took);
        if let Some(due) = due {
            assert!(read.refusals.iter().any(|refusal| refusal.contains(due)), "{name}: {refusal}");
        }
        assert!(refusal.len() < 4000, "{name}: a message of {} bytes", refusal.len());
    }
}
