//! `export` writes a model as source: all files or none, under names that compile, with what is known about
//! the model.

use std::process::Command;

use hysteron_io::sha256;
use hysteron_model::dynamics::{Dynamics, Scheme, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{Hysteresis, HysteresisForm, PrandtlIshlinskii, examples};
use hysteron_model::model_file::SignalUnits;
use serde_json::Value;

use crate::bench::{Bench, static_model};

fn stage() -> Model {
    Model {
        dynamics: Dynamics::Fractional(TransferFunction::article_eq13()),
        scheme: Scheme::Tustin,
        delay_s: 2.3e-4,
        sample_rate_hz: Some(1e4),
        ..static_model()
    }
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write_model("P-885_stage.json", &stage(), SignalUnits::default());
    bench
}

fn names(bench: &Bench, folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(bench.path(folder)).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn the_c_source_is_named_after_the_model_runs_at_its_rate_and_passes_its_selftest() {
    let bench = bench();
    let run = bench.run("export P-885_stage.json --to c -o firmware/stage");
    assert_eq!((run.exit_code, run.stderr.as_str()), (0, ""), "{run:?}");
    assert_eq!(names(&bench, "firmware"), ["stage"]);
    assert_eq!(names(&bench, "firmware/stage"), ["p_885_stage.c", "p_885_stage.h", "p_885_stage_selftest.c"]);
    let header = std::fs::read_to_string(bench.path("firmware/stage/p_885_stage.h")).unwrap();
    for part in [
        "V in, um out, 10000 Hz, double precision",
        "hysteron export 0.",
        "#define P_885_STAGE_SAMPLE_RATE_HZ 10000.0",
    ] {
        assert!(header.contains(part), "{part}: {header}");
    }
    let folder = bench.path("firmware/stage");
    let compiled = Command::new("cc")
        .args(["-std=c99", "p_885_stage.c", "p_885_stage_selftest.c", "-o", "selftest", "-lm"])
        .current_dir(&folder)
        .status();
    assert!(compiled.unwrap().success());
    assert!(Command::new(folder.join("selftest")).status().unwrap().success());
    // Again, over what is there, in single precision, for another rate.
    let run =
        bench.run("export P-885_stage.json --to c -o firmware/stage --float f32 --sample-rate 20000 --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((found["name"].as_str(), found["float"].as_str()), (Some("p_885_stage"), Some("f32")));
    assert_eq!((found["sample_rate_hz"].as_f64(), found["delay_samples"].as_u64()), (Some(2e4), Some(4)));
    assert_eq!(found["files"].as_array().unwrap().len(), 3);
    let header = std::fs::read_to_string(folder.join("p_885_stage.h")).unwrap();
    assert!(header.contains("typedef float p_885_stage_real;"), "{header}");
    let hash = sha256(&std::fs::read(bench.path("P-885_stage.json")).unwrap());
    assert!(header.contains(&format!("Model file: SHA-256 {hash}.")), "{header}");
    // The same source on every day.
    let mut sources = ["none", "2026-01-31"].map(|date| {
        let run = bench.run(&format!("export P-885_stage.json --to c -o dated --date {date}"));
        assert_eq!(run.exit_code, 0, "{run:?}");
        std::fs::read_to_string(bench.path("dated/p_885_stage.h")).unwrap()
    });
    assert!(sources[1].contains(", 2026-01-31."), "{}", sources[1]);
    sources[1] = sources[1].replace(", 2026-01-31.", ".");
    assert_eq!(sources[0], sources[1]);
    assert!(names(&bench, "firmware/stage").contains(&"selftest".to_owned()));
}

#[test]
fn the_other_forms_are_written_as_well() {
    let bench = bench();
    let run = bench.run("export P-885_stage.json --to rust -o crate --name stage");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stdout.contains("source of hysteron-rt") && run.stdout.lines().count() == 4, "{run:?}");
    assert_eq!(names(&bench, "crate"), ["Cargo.toml", "runtime", "src", "tests"]);
    let manifest = std::fs::read_to_string(bench.path("crate/Cargo.toml")).unwrap();
    assert!(manifest.contains("name = \"stage\"") && manifest.contains("path = \"runtime\""), "{manifest}");
    let run = bench.run("export P-885_stage.json --to fmu -o units");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert_eq!(names(&bench, "units"), ["p_885_stage_fmi2.fmu", "p_885_stage_fmi3.fmu"]);
    let run = bench.run("export P-885_stage.json --to matlab -o m --name stage --inverse --range 0:100");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let functions = ["stage.m", "stage_inverse.m", "stage_inverse_parameters.m", "stage_inverse_selftest.m"];
    assert_eq!(names(&bench, "m"), [&functions[..], &["stage_parameters.m", "stage_selftest.m"]].concat());
    for file in ["crate/Cargo.toml", "crate/tests/selftest.rs", "m/stage_parameters.m", "m/stage_selftest.m"]
    {
        let text = std::fs::read_to_string(bench.path(file)).unwrap();
        assert!(text.contains("Model file: SHA-256 "), "{file}: {text:.300}");
    }
    let run = bench.run("export P-885_stage.json --to simulink -o block --name stage --float f32");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert_eq!(names(&bench, "block"), ["stage.c", "stage.h", "stage_selftest.c", "stage_sfun.c"]);
}

/// Each with its inverse.
#[test]
fn every_form_is_written_over_an_earlier_export() {
    let bench = bench();
    for form in ["c", "rust", "matlab", "simulink", "fmu"] {
        for rate in ["10000", "20000"] {
            let command = format!("export P-885_stage.json --to {form} -o {form} --sample-rate {rate}");
            let run = bench.run(&command);
            assert_eq!(run.exit_code, 0, "{command}: {run:?}");
        }
    }
}

#[test]
fn every_family_is_exported() {
    let bench = bench();
    for hysteresis in examples([0.0, 100.0], 2e3, 0.3).unwrap() {
        let name = hysteresis.form().name();
        bench.write_model("family.json", &Model { hysteresis, ..stage() }, SignalUnits::default());
        let run = bench.run("export family.json --to c -o out --name stage --inverse --range 0:100");
        assert_eq!(run.exit_code, 0, "{name}: {run:?}");
    }
}

#[test]
fn what_cannot_be_exported_is_said_and_nothing_is_written() {
    let bench = bench();
    let dahl = "dahl".parse::<HysteresisForm>().unwrap().operator(vec![0.3], &[-0.5], &[20.0, 1.0]).unwrap();
    bench.write_model("dahl.json", &Model { hysteresis: dahl, ..stage() }, SignalUnits::default());
    for (arguments, exit_code, parts) in [
        ("export model.json --to c -o out", 1, ["without a sample rate", "--sample-rate HZ"]),
        (
            "export dahl.json --to c -o out --inverse --range 0:100",
            1,
            ["cannot be inverted", "does not raise the output"],
        ),
        ("export P-885_stage.json --to c -o out --name 2nd", 2, ["`2nd`", "--name stage"]),
        ("export P-885_stage.json --to c -o out --name int", 2, ["`int`", "--name stage"]),
        ("export P-885_stage.json --to fortran -o out", 2, ["fortran", "possible values"]),
        (
            "export P-885_stage.json --to matlab -o out --float f32",
            2,
            ["double precision", "leave --float out"],
        ),
        ("export P-885_stage.json --to matlab -o out --name end", 1, ["`end`", "--name stage"]),
        ("export P-885_stage.json --to c -o model.json", 1, ["model.json", "folder"]),
        ("export missing.json --to c -o out", 1, ["missing.json", "try:"]),
    ] {
        let run = bench.run(arguments);
        assert_eq!((run.exit_code, run.stdout.as_str()), (exit_code, ""), "{arguments}: {run:?}");
        for part in parts {
            assert!(run.stderr.contains(part), "{arguments}: {part}: {run:?}");
        }
        assert!(!bench.path("out").exists(), "{arguments}");
    }
    // A folder in the place of a file.
    std::fs::create_dir_all(bench.path("blocked/stage.c")).unwrap();
    let run = bench.run("export P-885_stage.json --to c -o blocked --name stage");
    assert!(run.exit_code == 1 && run.stderr.contains("stage.c failed"), "{run:?}");
    assert!(run.stderr.contains("try: name another folder"), "{run:?}");
    assert_eq!(names(&bench, "blocked"), ["stage.c"]);
    // Somebody's own file of the same name.
    std::fs::create_dir(bench.path("mine")).unwrap();
    bench.write("mine/stage.c", "int mine;\n");
    let run = bench.run("export P-885_stage.json --to c -o mine --name stage");
    assert!(run.exit_code == 1 && run.stderr.contains("was not written by an export"), "{run:?}");
    assert_eq!(names(&bench, "mine"), ["stage.c"]);
    assert_eq!(std::fs::read_to_string(bench.path("mine/stage.c")).unwrap(), "int mine;\n");
}

/// So that code for any model compiles.
#[test]
fn a_model_without_delay_says_so() {
    let bench = Bench::new();
    let run = bench.run("export model.json --to c -o out --sample-rate 1000");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let header = std::fs::read_to_string(bench.path("out/model.h")).unwrap();
    assert!(header.contains("#define MODEL_DELAY 0\n"), "{header}");
    assert!(header.contains("limit it to what the amplifier can deliver"), "{header}");
}

#[test]
fn single_precision_that_takes_too_much_is_said_or_refused() {
    let bench = bench();
    let inverse = |rate: &str, float: &str| {
        bench.run(&format!(
            "export P-885_stage.json --to c -o out --name stage --inverse --range 0:100 --sample-rate {rate} \
             --float {float}"
        ))
    };
    let run = inverse("1e4", "f32");
    assert!(run.exit_code == 0 && !run.stderr.contains("single precision"), "{run:?}");
    let header = std::fs::read_to_string(bench.path("out/stage_inverse.h")).unwrap();
    assert!(header.contains(" * Single precision may move the voltage by "), "{header}");
    let run = inverse("1e5", "f32");
    assert!(
        run.exit_code == 0 && run.stderr.contains("note: Single precision may move the voltage by"),
        "{run:?}"
    );
    let header = std::fs::read_to_string(bench.path("out/stage_inverse.h")).unwrap();
    assert!(header.contains(" * NOTE: Single precision may move the voltage by "), "{header}");
    std::fs::remove_dir_all(bench.path("out")).unwrap();
    let run = inverse("1e6", "f32");
    for part in ["single precision may move the voltage by", "% of its range", "--float f64", "--bandwidth"] {
        assert!(run.exit_code == 1 && run.stderr.contains(part), "{part}: {run:?}");
    }
    assert!(!bench.path("out").exists());
    let run = inverse("1e6", "f64");
    assert_eq!(run.exit_code, 0, "{run:?}");
}

/// As realise says it.
#[test]
fn what_lies_between_the_samples_is_noted_and_stands_in_the_header() {
    let bench = Bench::new();
    // Plays that turn between two samples.
    let plays =
        PrandtlIshlinskii { polynomial: vec![0.3], thresholds: vec![0.1, 0.3], weights: vec![0.2, 0.3] };
    let hysteresis = Hysteresis::from(plays);
    let model = Model { hysteresis, scheme: Scheme::BandLimited, ..stage() };
    bench.write_model("stage.json", &model, SignalUnits::default());
    let realised = bench.run("realise stage.json --sample-rate 1000");
    let exported = bench.run("export stage.json --to c -o out --sample-rate 1000");
    assert_eq!((realised.exit_code, exported.exit_code), (0, 0), "{realised:?} {exported:?}");
    assert!(
        exported.stderr.contains("note: Along the sweep the difference to the batch simulation is"),
        "{exported:?}"
    );
    assert_eq!(realised.stderr, exported.stderr);
    let header = std::fs::read_to_string(bench.path("out/stage.h")).unwrap();
    assert!(header.contains(" * Off the batch simulation along a sweep of 0.1 to 10 Hz"), "{header}");
}

#[test]
fn a_unit_needs_a_compiler() {
    let bench = bench();
    let output = Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(["export", "P-885_stage.json", "--to", "fmu", "-o", "units"])
        .env("CC", "no-such-compiler")
        .current_dir(bench.path(""))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(1) && said.contains("no-such-compiler") && said.contains("CC"),
        "{said}"
    );
    assert!(!bench.path("units").exists());
}

#[test]
fn the_inverse_comes_in_the_same_forms() {
    let bench = bench();
    let limits = "--inverse --range 0:100 --slew 200000 --name stage";
    let run = bench.run(&format!("export P-885_stage.json --to c -o source {limits} --preview 12"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let all = [
        "stage.c",
        "stage.h",
        "stage_inverse.c",
        "stage_inverse.h",
        "stage_inverse_loop.c",
        "stage_inverse_selftest.c",
        "stage_selftest.c",
    ];
    assert_eq!(names(&bench, "source"), all);
    let header = std::fs::read_to_string(bench.path("source/stage_inverse.h")).unwrap();
    for part in [
        "STAGE_INVERSE_PREVIEW 12",
        "STAGE_INVERSE_VOLTAGE_HIGH (100.0)",
        "STAGE_INVERSE_VOLTAGE_STEP (20.0)",
    ] {
        assert!(header.contains(part), "{part}: {header}");
    }
    let folder = bench.path("source");
    let arguments = ["-std=c99", "stage_inverse.c", "stage_inverse_selftest.c", "-o", "selftest", "-lm"];
    assert!(Command::new("cc").args(arguments).current_dir(&folder).status().unwrap().success());
    assert!(Command::new(folder.join("selftest")).status().unwrap().success());
    let header = std::fs::read_to_string(bench.path("source/stage.h")).unwrap();
    assert!(header.contains("#define STAGE_DELAY 2\n"), "{header}");
    // More preview than any voltage depends on would put the reference elsewhere in time.
    let run = bench.run(&format!("export P-885_stage.json --to c -o source {limits} --preview 100000"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let header = std::fs::read_to_string(bench.path("source/stage_inverse.h")).unwrap();
    let used = header.lines().find_map(|l| l.strip_prefix("#define STAGE_INVERSE_PREVIEW ")).unwrap();
    assert!(used.parse::<usize>().unwrap() < 5000, "{used}");
    assert!(run.stderr.contains(&format!("Of the preview of 100000 samples {used} are used")), "{run:?}");
    let run = bench.run(&format!("export P-885_stage.json --to fmu -o units {limits}"));
    assert_eq!((run.exit_code, names(&bench, "units").len()), (0, 4), "{run:?}");
    let run = bench.run(&format!("export P-885_stage.json --to rust -o crate {limits}"));
    assert_eq!((run.exit_code, bench.path("crate/src/inverse.rs").exists()), (0, true), "{run:?}");
    for (arguments, exit_code, part) in [
        ("export P-885_stage.json --to c -o out --inverse", 1, "--range LOW:HIGH"),
        ("export P-885_stage.json --to c -o out --slew 3", 2, "--inverse"),
        ("export P-885_stage.json --to c -o out --inverse --range 0:100 --bandwidth 6000", 1, "bandwidth"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.exit_code, exit_code, "{arguments}: {run:?}");
        assert!(run.stderr.contains(part) && !bench.path("out").exists(), "{arguments}: {run:?}");
    }
}

#[test]
fn a_controller_comes_with_its_inverse() {
    let bench = bench();
    let limits = "--inverse --range 0:100 --slew 200000 --name stage";
    let run = bench
        .run(&format!("export P-885_stage.json --to c -o source {limits} --controller feedforward-observer"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let header = std::fs::read_to_string(bench.path("source/stage_controller.h")).unwrap();
    for part in ["controller `feedforward-observer`", "gain margin", "Gain of the observer", "SHA-256"] {
        assert!(header.contains(part), "{part}: {header}");
    }
    let folder = bench.path("source");
    let sources =
        ["stage_observed.c", "stage_inverse.c", "stage_controller.c", "stage_controller_selftest.c"];
    let compiled = Command::new("cc")
        .arg("-std=c99")
        .args(sources)
        .args(["-o", "selftest", "-lm"])
        .current_dir(&folder)
        .status();
    assert!(compiled.unwrap().success());
    assert!(Command::new(folder.join("selftest")).status().unwrap().success());
    for (form, written) in [("c --float f32", "stage_controller.c"), ("rust", "src/controller.rs")] {
        let arguments = format!("--to {form} --controller feedforward-pi {limits}");
        let run = bench.run(&format!("export P-885_stage.json -o other {arguments}"));
        assert_eq!(run.exit_code, 0, "{form}: {run:?}");
        assert!(bench.path("other").join(written).exists(), "{form}: {run:?}");
    }
    for (arguments, exit_code, part) in [
        ("--to c --controller pi --inverse", 1, "feedforward-pi, feedforward-fractional-pi"),
        ("--to c --controller predicted-pi --inverse", 1, "--predict-to HZ"),
        ("--to matlab --controller feedforward-pi --inverse", 1, "--to c, rust or fmu"),
        ("--to c --controller feedforward-pi", 2, "--inverse"),
    ] {
        let range = if exit_code == 1 { "--range 0:100" } else { "" };
        let run = bench.run(&format!("export P-885_stage.json -o out --name stage {arguments} {range}"));
        assert_eq!(run.exit_code, exit_code, "{arguments}: {run:?}");
        assert!(run.stderr.contains(part) && !bench.path("out").exists(), "{arguments}: {run:?}");
    }
}
