//! Every command, family and kind on small simulated records, on one thread and on two: the same bits, and what
//! is written is read again.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use hysteron_io::{ReadOptions, load_model, read_record};
use hysteron_model::hysteresis::examples;
use serde_json::Value;

use crate::bench::Bench;
use crate::several_axes_are_identified;

/// Dynamics of the joint fit, and of the two steps.
const JOINT: [&str; 6] =
    ["none", "integer", "modes", "fractional", "fractional-free-lowest", "two-fractional"];
const TWO_STEP: [&str; 4] = ["arx", "oe", "bj", "srivc"];
const OPTIMISERS: [&str; 6] = ["de-abc", "abc", "de", "pso", "cma-es", "least-squares"];

/// Models of other kinds than a Hammerstein stage.
const KINDS: [&str; 4] = [
    "identify sweep.csv --structure oscillator --least-fit 0 -o oscillator.json --report oscillator.html",
    "identify force.csv --structure force --least-fit 0 -o force.json --json",
    "identify low.csv axes.csv --inputs u1_V,u2_V --outputs y1_nm,y2_nm --modes 2 --steps 1 --plays 1 \
     --iterations 2 --least-fit 0 -o axes.json --json",
    "identify low.csv axes.csv --inputs u1_V,u2_V --outputs y1_nm,y2_nm --structure hammerstein --least-fit 0 \
     -o branches.json",
];

/// Every other command, on those models.
const OTHERS: &str = "\
identify loop.csv sweep.csv --dynamics auto --json -o auto.json --report auto.html --figures figures
compare loop.csv sweep.csv --candidates none,integer1,integer2 -o compared.json --report compared.html
frequency-response response.csv --structure integer --structure modes -o response.json --report response.html --json
inspect loop.csv sweep.csv --json
inspect loop.csv --plot loop.svg
prepare loop.csv -o prepared.csv --rate 20Hz --json
prepare loop.csv -o prepared.npz
prepare loop.csv -o prepared.mat
recalibrate integer.json loop.csv --least-fit 0 -o recalibrated.json --json
adapt integer.json sweep.csv -o adapted.json --json
validate integer.json loop.csv sweep.csv --band --json
validate integer.json sweep.csv -o scored.csv --report scored.html
validate oscillator.json sweep.csv --json
validate force.json force.csv --json
validate axes.json axes.csv --json
validate branches.json axes.csv --json
simulate integer.json sweep.csv --band model -o simulated.csv
simulate integer.json sweep.csv -o simulated.npz
simulate integer.json sweep.csv -o simulated.mat
simulate oscillator.json sweep.csv -o oscillator.csv
simulate force.json force.csv -o force_simulated.csv
simulate axes.json axes.csv -o axes_simulated.csv
simulate branches.json axes.csv -o branches_simulated.csv
invert integer.json reference.csv -o drive.csv --range 0:12 --json
track integer.json reference.csv --plant model --controller feedforward --controller pi -o track.csv --report track.html
realise integer.json --sample-rate 1000 --json
export integer.json --to c --sample-rate 1000 --date 2026-01-01 -o code/c --json
export integer.json --to c --inverse --range 0:12 --sample-rate 1000 --date 2026-01-01 -o code/inverse
export integer.json --to rust --sample-rate 1000 --date 2026-01-01 -o code/rust
export integer.json --to matlab --sample-rate 1000 --date 2026-01-01 -o code/matlab
export integer.json --to simulink --sample-rate 1000 --date 2026-01-01 -o code/simulink
export axes.json --to c --sample-rate 1000 -o code/axes
excite sine --frequency 1 --sample-rate 100 --high 10 -o sine.csv
excite nested-loops --frequency 1 --sample-rate 100 --high 10 -o loops.csv
rig --plan plan.json --out-dir bench --with-truth
rig --plan bench/plan.json --truth bench/truth.json --out-dir again
rig --drive sine.csv --out-dir played
optimizers --problem static-block --seeds 2 --budget 300 --optimizer de --optimizer pso --json
schema
";

const PLAN: &str = r#"{"sample_rate_hz": 500, "loop_hz": 5, "loop_periods": 1, "sweep_s": 0.3,
    "sweep_start_hz": 5, "sweep_end_hz": 30, "validation_hz": []}"#;

/// All command lines, in an order in which each finds what it reads.
fn lines() -> Vec<String> {
    let fit = |name: &str| format!("--degree 1 --least-fit 0 -o {name}.json");
    let mut lines: Vec<String> = Vec::new();
    let families: BTreeSet<_> =
        examples([0.0, 10.0], 40.0, 0.3).unwrap().iter().map(|h| h.form().name().to_owned()).collect();
    for family in &families {
        lines.push(format!(
            "identify loop.csv --hysteresis {family} --dynamics none --delay 0 {}",
            fit(family)
        ));
    }
    for dynamics in JOINT {
        lines.push(format!("identify loop.csv sweep.csv --dynamics {dynamics} --json {}", fit(dynamics)));
    }
    for dynamics in TWO_STEP {
        let records = "--method two-step --static loop.csv --dynamic sweep.csv";
        lines.push(format!("identify {records} --dynamics {dynamics} {}", fit(dynamics)));
    }
    for optimiser in OPTIMISERS {
        let search = format!("--optimizer {optimiser} --generations 3 --population 8");
        lines.push(format!("identify loop.csv --dynamics none {search} {}", fit(&format!("by-{optimiser}"))));
    }
    lines.extend(KINDS.map(str::to_owned));
    lines.extend(OTHERS.lines().map(str::to_owned));
    lines
}

fn table(header: &str, rows: impl Iterator<Item = Vec<f64>>) -> String {
    rows.fold(format!("{header}\n"), |mut text, row| {
        let row: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(text, "{}", row.join(",")).unwrap();
        text
    })
}

/// Noise that is no noise.
fn ripple(k: u32) -> f64 {
    0.001 * (f64::from(k * 7919 % 13) - 6.0)
}

pub fn records() -> [(&'static str, String); 5] {
    let (mut z, mut last) = (0.0, 0.0);
    let quasi_static = (0..160).map(|k| {
        let t = f64::from(k) / 40.0;
        let u = (5.0 - 2.0 * f64::from(k / 80)) * (1.0 - (TAU * 0.5 * t).cos());
        z += 0.3 * (u - last) - 0.2 * f64::abs(u - last) * z;
        last = u;
        vec![t, u, 1.5 * u - z + ripple(k)]
    });
    let quasi_static = table("t_s,u_V,y_um", quasi_static);
    let (mut x, mut v, omega) = (0.0, 0.0, TAU * 30.0);
    let (mut z, mut last) = (0.0, 0.0);
    let sweep = (0..300).map(|k| {
        let t = f64::from(k) / 500.0;
        let u = 3.0 * (1.0 - (TAU * (5.0 * t + 20.0 * t * t)).cos());
        z += 0.3 * (u - last) - 0.2 * f64::abs(u - last) * z;
        last = u;
        for _ in 0..10 {
            v += (omega * omega * (1.5 * u - z - x) - 0.3 * omega * v) / 5000.0;
            x += v / 5000.0;
        }
        vec![t, u, x + ripple(k)]
    });
    let sweep = table("t_s,u_V,y_um", sweep);
    let (mut z, mut last) = (0.0, 0.0);
    let force = (0..200).map(|k| {
        let t = f64::from(k) / 100.0;
        let x = 5.0 * (TAU * t).sin() * (0.5 + 0.25 * t);
        let rate = (x - last) * 100.0;
        last = x;
        z += (rate - 0.8 * f64::abs(rate) * z) / 100.0;
        vec![t, x, 20.0 * z + 0.4 * rate + 1.5 * x]
    });
    let force = table("t_s,u_mm,y_N", force);
    let reference =
        (0..400).map(|k| f64::from(k) / 500.0).map(|t| vec![t, 4.0 - 3.0 * (TAU * 2.5 * t).cos()]);
    let response = (1..30).map(|k| f64::from(4 * k)).map(|f| {
        let (real, imaginary) = (1.0 - (f / 60.0).powi(2), 0.1 * f / 60.0);
        vec![f, 1.0 / real.hypot(imaginary), -imaginary.atan2(real).to_degrees()]
    });
    [
        ("loop.csv", quasi_static),
        ("sweep.csv", sweep),
        ("force.csv", force),
        ("reference.csv", table("t_s,y_um", reference)),
        ("response.csv", table("f_Hz,magnitude,phase_deg", response)),
    ]
}

/// What all commands left behind.
struct Ran {
    bench: Bench,
    /// What each printed.
    printed: Vec<String>,
    /// All files afterwards: the tests, which run side by side, write others.
    files: BTreeMap<String, Vec<u8>>,
}

/// Side by side: whoever asks for it waits.
static RAN: LazyLock<[Ran; 2]> = LazyLock::new(|| {
    std::thread::scope(|scope| {
        let running = ["1", "2"].map(|threads| scope.spawn(move || all_on(threads)));
        running.map(|run| run.join().unwrap())
    })
});

fn all_on(threads: &str) -> Ran {
    let bench = Bench::new();
    records().into_iter().for_each(|(name, text)| bench.write(name, text));
    bench.write("low.csv", several_axes_are_identified::csv(0.1, 1));
    bench.write("axes.csv", several_axes_are_identified::csv(0.5, 3));
    bench.write("plan.json", PLAN);
    let run = |line: &String| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hysteron"));
        command.args(line.split_whitespace()).env("RAYON_NUM_THREADS", threads);
        let output = command.current_dir(bench.path(".")).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        made_on_one_day(&bench);
        String::from_utf8(output.stdout).unwrap()
    };
    let printed = lines().iter().map(run).collect();
    let files = files(&bench.path("."));
    Ran { bench, printed, files }
}

/// Gives all models one time of making: other files hold their hashes.
fn made_on_one_day(bench: &Bench) {
    for name in bench.files().iter().filter(|name| name.ends_with(".json")) {
        let text = std::fs::read_to_string(bench.path(name)).unwrap();
        if let Some((before, rest)) = text.split_once("\"created\": \"")
            && let Some((_, after)) = rest.split_once('"')
        {
            bench.write(name, format!("{before}\"created\": \"2026-01-01T00:00:00Z\"{after}"));
        }
    }
}

/// All files, by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// Text without what two runs on the same threads differ in: times.
fn lasting(text: &[u8]) -> String {
    if let Ok(mut value) = serde_json::from_slice::<Value>(text) {
        without_times(&mut value);
        return value.to_string();
    }
    let text = String::from_utf8_lossy(text);
    let is_timed =
        |line: &&str| [" UTC", "ns per sample", " s,", "seconds"].iter().any(|part| line.contains(part));
    text.lines().filter(|line| !is_timed(line)).collect::<Vec<_>>().join("\n")
}

fn without_times(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|key, _| !["created", "seconds", "nanoseconds_per_sample"].contains(&key.as_str()));
            map.values_mut().for_each(without_times);
        }
        Value::Array(list) => list.iter_mut().for_each(without_times),
        _ => {}
    }
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let [one, two] = &*RAN;
    // A comparison prints how long a sample takes.
    let all = lines().into_iter().zip(&one.printed).zip(&two.printed);
    for ((line, one), two) in all.filter(|((line, _), _)| !line.starts_with("compare")) {
        assert_eq!(lasting(one.as_bytes()), lasting(two.as_bytes()), "{line}");
    }
    let (one, two) = (&one.files, &two.files);
    assert!(one.keys().eq(two.keys()));
    // Pages hold times, beside numbers that are in other files.
    for (name, text) in one.iter().filter(|(name, _)| !name.ends_with(".html")) {
        assert!(lasting(text) == lasting(&two[name]), "{name} differs");
    }
}

#[test]
fn everything_written_is_read_again() {
    let [ran, _] = &*RAN;
    let mut read = BTreeMap::<&str, usize>::new();
    for (name, text) in &ran.files {
        let path = ran.bench.path(name);
        let kind = match Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("") {
            // No record: a response is read by its own command.
            "csv" if name == "response.csv" => continue,
            "csv" | "npz" | "mat" => {
                let record = read_record(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
                let mut samples = record.channels.iter().flat_map(|channel| &channel.samples);
                assert!(!record.is_empty() && samples.all(|x| x.is_finite()), "{name}");
                let run = ran.bench.run(&format!("prepare {name} -o {name}.again.csv"));
                assert_eq!(run.exit_code, 0, "{name}: {}", run.stderr);
                "records"
            }
            "json" if name.starts_with("code") => continue,
            "json"
                if text.starts_with(b"{") && String::from_utf8_lossy(text).contains("\"hysteron-model\"") =>
            {
                let model = load_model(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
                let written = model.to_json().unwrap();
                assert_eq!(written.trim_end().as_bytes(), text.trim_ascii_end(), "{name}");
                "models"
            }
            // Read by the lines of the table.
            "json" => {
                serde_json::from_slice::<Value>(text).unwrap_or_else(|e| panic!("{name}: {e}"));
                "settings"
            }
            "html" | "svg" => {
                let text = std::str::from_utf8(text).unwrap_or_else(|e| panic!("{name}: {e}"));
                assert!(
                    text.trim_end().ends_with("</html>") || text.trim_end().ends_with("</svg>"),
                    "{name}"
                );
                "pages"
            }
            _ => continue,
        };
        *read.entry(kind).or_default() += 1;
    }
    println!("read again: {read:?}");
    for (line, printed) in lines().iter().zip(&ran.printed).filter(|(line, _)| line.contains("--json")) {
        serde_json::from_str::<Value>(printed).unwrap_or_else(|e| panic!("{line}: {e}"));
    }
    assert_eq!(read.len(), 4, "{read:?}");
}
