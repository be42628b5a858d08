//! A model of several axes is inverted, exported, and played on the bench of several axes. Everything is
//! simulated.

use std::fmt::Write;

use crate::bench::Bench;
use crate::several_axes_are_identified::device;
use hysteron_model::model_file::{ModesFile, SignalUnits, ValidRange};
use serde_json::Value;

/// Slow references of two axes, in nm, from rest.
fn references(samples: usize) -> String {
    let mut text = "t_s,y1_nm,y2_nm\n".to_owned();
    for k in 0..samples {
        let t = k as f64 / 1000.0;
        let grown = 1.0 - (-(30.0 * t).powi(3)).exp();
        let (a, b) = (400.0 * grown * (20.0 * t).sin(), -250.0 * grown * (31.0 * t).sin());
        writeln!(text, "{t},{a},{b}").unwrap();
    }
    text
}

fn bench() -> Bench {
    let bench = Bench::new();
    let names = |prefix: &str| vec![format!("{prefix}1"), format!("{prefix}2")];
    let units = SignalUnits { input: "V".into(), output: "um".into() };
    let mut file = ModesFile::new(&device(), units, names("u"), names("y"));
    bench.write("stage.json", file.to_json().unwrap());
    file.valid_range = Some(ValidRange::of_inputs(&[-1.0, 1.0], "V", Some((2.0, 300.0))));
    bench.write("ranged.json", file.to_json().unwrap());
    bench.write("references.csv", references(800));
    bench
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

#[test]
fn drives_of_all_actuators_are_written_and_the_model_follows_them() {
    let bench = bench();
    for (flags, largest_nm) in [("", 0.05), ("--preview 60", 0.5)] {
        let run = bench.run(&format!(
            "invert stage.json references.csv -o drives.csv --range=-1:1,-0.8:0.8 --slew 500 --bandwidth 100 \
             --json {flags}"
        ));
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
        let told = json(&run.stdout);
        for axis in told["axes"].as_array().unwrap() {
            let error = axis["predicted_rms_error_um"].as_f64().unwrap();
            assert!(error < 1e-3 * largest_nm, "{flags}: {told}");
        }
        assert_eq!(told["actuators"][0]["samples_at_range"], 0);
        let text = std::fs::read_to_string(bench.path("drives.csv")).unwrap();
        let header = "t_s,u1_V,u2_V,y1_um,y2_um,reference_y1_um,reference_y2_um\n";
        assert!(text.starts_with(header), "{}", &text[..80]);
    }
    // The drives are a record of the model's inputs.
    let run = bench.run("simulate stage.json drives.csv -o motion.csv");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let run = bench.run("simulate stage.json drives.csv -o motion.csv --settled 0.1");
    assert!(run.exit_code == 1 && run.stderr.contains("does not repeat every 100 samples"), "{}", run.stderr);
    let run = bench.run("invert stage.json references.csv -o drives.csv --range=-1:1 --level 1e9");
    let level = "warning: the level of the inputs is 1e9 V rms, the model was identified from 0.1 to 0.5 V";
    assert!(run.stdout.contains(level), "{}", run.stdout);
    let run =
        bench.run("invert ranged.json references.csv -o drives.csv --bandwidth 320 --preview 100000 --json");
    let findings = json(&run.stdout)["findings"].to_string();
    assert!(
        findings.contains("the bandwidth is 320 Hz, the model was identified up to 300 Hz"),
        "{findings}"
    );
    assert!(findings.contains("Of the preview of 100000 samples "), "{findings}");
    let run = bench.run("invert stage.json references.csv -o drives.csv --range=-1:1 --periodic");
    assert!(run.stdout.contains("As a period the reference y2 jumps from its last sample"), "{}", run.stdout);
    let run = bench.run("invert stage.json references.csv -o drives.csv --range=-1:1");
    assert!(run.exit_code == 0 && run.stdout.contains("predicted error, rms [µm]"), "{}", run.stdout);
}

#[test]
fn what_does_not_go_with_several_axes_is_refused() {
    let bench = bench();
    let refuse = |command: &str, exit_code: i32, words: &str| {
        let run = bench.run(command);
        assert_eq!(run.exit_code, exit_code, "{command}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{command}: {}", run.stderr);
    };
    let invert = "invert stage.json references.csv -o drives.csv";
    refuse(invert, 1, "does not say which drives");
    refuse(&format!("{invert} --range=-1:1,-1:1,-1:1"), 2, "2 inputs, but there are limits for 3");
    let export = "export stage.json --to c --inverse -o out";
    refuse(export, 1, "give their limits");
    refuse(&format!("{export} --range=-1:1,-1:1,-1:1"), 2, "2 inputs, but there are limits for 3");
    refuse(&format!("{invert} --range=-1:1 --predict-to 20"), 2, "--predict-to does not go");
    refuse(&format!("{invert} --range=-1:1 --outputs y1"), 2, "2 outputs, --outputs names 1");
    refuse(&format!("{invert} --range 0.5:1"), 1, "would have to rest at");
    bench.write("short.csv", "t_s,y1_nm\n0,0\n0.001,1\n");
    refuse("invert stage.json short.csv -o drives.csv --range=-1:1", 1, "no channel `y2`");
    refuse("export stage.json --to matlab -o out", 1, "as C99, Rust or FMUs, not as matlab");
    refuse("export stage.json --to c --sample-rate 15 -o out", 1, "cannot be run at 15 Hz");
    refuse("realise stage.json --sample-rate 1000", 1, "export writes them");
    refuse("invert model.json references.csv -o drive.csv --range 0:1,0:1", 2, "several axes");
    assert!(!bench.path("drives.csv").exists() && !bench.path("out").exists());
}

#[test]
fn model_and_inverse_are_written_in_c() {
    let bench = bench();
    let run = bench.run("export stage.json --to c --inverse --range=-1:1 --sample-rate 2500 -o out --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told = json(&run.stdout);
    assert_eq!((told["inputs"].as_u64(), told["outputs"].as_u64()), (Some(2), Some(2)));
    for file in ["stage.h", "stage.c", "stage_selftest.c", "stage_inverse.h", "stage_inverse.c"] {
        assert!(bench.path("out").join(file).exists(), "{file}");
    }
    let run = bench.run("export stage.json --to c --float f32 -o single");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let test = std::fs::read_to_string(bench.path("out").join("stage_selftest.c")).unwrap();
    assert!(test.contains("Model file: SHA-256 "), "{test:.300}");
    let header = std::fs::read_to_string(bench.path("single").join("stage.h")).unwrap();
    for line in ["Actuators: u1 [0], u2 [1].", "Axes: y1 [0], y2 [1].", "had levels of 0.1 to 0.5 V rms"] {
        assert!(header.contains(line), "{header:.1000}");
    }
    assert!(header.contains("single precision departs from double by"), "{header}");
    let run = bench.run("export stage.json --to fmu -o units");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(
        bench.path("units").join("stage_fmi2.fmu").exists()
            && bench.path("units").join("stage_fmi3.fmu").exists()
    );
}

#[test]
fn the_bench_of_several_axes_makes_records_and_controllers_are_compared_on_it() {
    let bench = bench();
    bench.write("plan.json", r#"{"period_samples": 500, "periods": 2, "levels_v": [0.5, 2.0]}"#);
    let run = bench.run("rig --axes 2 --plan plan.json --seed 3 --out-dir bench2");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let text =
        std::fs::read_to_string(bench.path("bench2").join("simulated_axes_2000mV_heldout.csv")).unwrap();
    assert!(text.starts_with("# simulated") && text.contains("\nt_s,u1_V,u2_V,y1_um,y2_um\n"), "{text:.300}");
    for file in ["truth.json", "plan.json", "simulated_axes_500mV_1.csv", "simulated_axes_500mV_2.csv"] {
        assert!(bench.path("bench2").join(file).exists(), "{file}");
    }
    let run = bench.run("rig --axes 3 --truth bench2/truth.json --out-dir bench3");
    assert!(run.exit_code == 2 && run.stderr.contains("the truth has 2 axes"), "{}", run.stderr);
    // A model that is not of this bench follows badly, and says so.
    let track = "track stage.json references.csv --range=-6:6 --truth bench2/truth.json";
    let run = bench.run(&format!("{track} --json --report track.html"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(bench.path("track.html")).unwrap();
    for words in ["cross-coupling", "feedforward-integral", "Drives of the actuators", "simulated"] {
        assert!(page.contains(words), "{words}");
    }
    let told = json(&run.stdout);
    assert_eq!(told["simulated"], true);
    assert_eq!(told["controllers"].as_array().unwrap().len(), 5);
    assert_eq!(told["findings"].as_array().unwrap().len(), 0);
    let run = bench.run(&format!("{track} --bandwidth 350").replace("stage", "ranged"));
    assert!(run.stdout.contains("Bandwidth 350 Hz"), "{}", run.stdout);
    assert!(run.stdout.contains("warning: the bandwidth is 350 Hz"), "{}", run.stdout);
    let run = bench.run("track stage.json references.csv --range=-6:6 --plant model");
    assert!(run.exit_code == 2 && run.stderr.contains("--plant model does not go"), "{}", run.stderr);
}
