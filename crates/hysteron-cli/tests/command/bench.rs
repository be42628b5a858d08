//! Runs the command in a folder of its own and looks at what it did.

use std::path::{Path, PathBuf};
use std::process::Command;

use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::{Document, ModelFile, SignalUnits, read};
use hysteron_model::record::InterSample;
use tempfile::TempDir;

/// A folder with a model, in which commands run.
pub struct Bench(TempDir);

/// What a command did.
#[derive(Debug)]
pub struct Run {
    pub exit_code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Bench {
    /// A folder with `model.json`, a static Bouc–Wen model.
    pub fn new() -> Self {
        let bench = Bench(tempfile::tempdir().unwrap());
        bench.write_model("model.json", &static_model(), SignalUnits::default());
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub fn write_model(&self, name: &str, model: &Model, units: SignalUnits) {
        self.write(name, ModelFile::from_model(model, units).to_json().unwrap());
    }

    /// Names of the files in the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `hysteron` with these arguments, separated by blanks.
    pub fn run(&self, arguments: &str) -> Run {
        self.run_program(Path::new(env!("CARGO_BIN_EXE_hysteron")), arguments)
    }

    /// Runs another `hysteron` with these arguments, separated by blanks. A device of the simulated bench
    /// (`rig`), which is outside the model class, identified from nested loops and a sweep: `stage.json`, its
    /// truth in `rig/truth.json`.
    pub fn identify_outside_the_class(&self) {
        let plan = r#"{"sample_rate_hz": 2500.0, "loop_periods": 2.0, "sweep_s": 2.0, "validation_hz": [],
            "nested_amplitudes": [1.0, 0.75, 0.5, 0.25]}"#;
        self.write("plan.json", plan);
        self.run_well("rig --out-dir rig --plan plan.json --seed 1");
        let mut records: Vec<String> = std::fs::read_dir(self.path("rig"))
            .unwrap()
            .map(|entry| format!("rig/{}", entry.unwrap().file_name().to_str().unwrap()))
            .filter(|name| name.ends_with(".csv"))
            .collect();
        records.sort();
        self.run_well(&format!("identify {} -o stage.json", records.join(" ")));
    }

    /// [`Self::run`], which must succeed.
    pub fn run_well(&self, arguments: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.exit_code, 0, "{arguments}: {run:?}");
        run
    }

    pub fn run_program(&self, program: &Path, arguments: &str) -> Run {
        let output = Command::new(program)
            .args(arguments.split_whitespace())
            .current_dir(self.0.path())
            .output()
            .unwrap();
        Run {
            exit_code: output.status.code().unwrap(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// A Bouc–Wen model with a counter-clockwise loop and no dynamics.
pub fn static_model() -> Model {
    Model {
        hysteresis: Hysteresis::from(BoucWen {
            polynomial: vec![0.3, 1e-4],
            alpha: 0.08,
            beta: 0.05,
            gamma: 0.01,
            n: 1.0,
        }),
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

/// A drive of two periods of a 1 Hz triangle, 0 to 100 V, at 100 Hz: its samples.
pub fn triangle() -> Vec<f64> {
    (0..200)
        .map(|k| k % 100)
        .map(|k| if k < 50 { 2.0 * f64::from(k) } else { 200.0 - 2.0 * f64::from(k) })
        .collect()
}

/// A record `t_s,u_V,y_um` of the triangle and a straight line of 0.3 µm/V.
pub fn good_record() -> String {
    let rows =
        triangle().into_iter().enumerate().map(|(k, u)| format!("{},{u},{}\n", k as f64 / 100.0, 0.3 * u));
    format!("t_s,u_V,y_um\n{}", rows.collect::<String>())
}

/// The data of the Hammerstein model in a file.
pub fn model_data(path: &Path) -> ModelFile {
    match read(&std::fs::read(path).unwrap()).unwrap() {
        Document::Hammerstein(file) => *file,
        other => panic!("a model of the kind {}", other.kind()),
    }
}
