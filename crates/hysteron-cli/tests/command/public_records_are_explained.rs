//! Measured records of others, read where they lie: as good a model as the class gives, or a plain word that
//! it does not fit. Their licences do not let all of them be copied here; without the folder of
//! `HYSTERON_DATA` the tests say that they skip.

use crate::bench::Bench;
use hysteron_numeric::display::short;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn public(file: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let file = folder.join(file);
    if file.exists() {
        return Some(file);
    }
    println!("skipped: no file {}; set HYSTERON_DATA to the public data", file.display());
    None
}

fn scores(bench: &Bench, command: &str, key: &str) -> Vec<f64> {
    let run = bench.run(command);
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    told["records"].as_array().unwrap().iter().map(|record| record[key].as_f64().unwrap()).collect()
}

/// Two cycles to fit, the next four to check. Published and measured elsewhere, rms in % of stroke: Bouc–Wen
/// n = 1 0.59, n free 0.32, with a cubic 0.216; a sparse regression of its authors 0.254.
#[test]
fn one_hertz_loop_is_predicted_as_well_as_bouc_wen_can() {
    let Some(file) = public("piezo-sine-1hz/sine_1hz_150v.csv") else { return };
    let text = std::fs::read_to_string(file).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let bench = Bench::new();
    for (name, part) in [("fit.csv", &rows[20_000..30_000]), ("check.csv", &rows[30_000..50_000])] {
        bench.write(name, format!("{header}\n{}\n", part.join("\n")));
    }
    for (flags, least) in [("--degree 1 --n 1", 0.59), ("--degree 1 --n free", 0.32), ("", 0.216)] {
        scores(&bench, &format!("identify fit.csv {flags} -o loop.json --json"), "rmse_um");
        let percent = scores(&bench, "validate loop.json check.csv --json", "rmse_percent_of_stroke");
        assert!(percent[0] <= least, "{flags}: {} %, others {least} %", percent[0]);
    }
}

/// Noise of both records, from their second differences: 0.0033 to 0.0035.
#[test]
fn fractional_process_with_a_dead_band_is_fitted_to_its_noise() {
    let Some(file) = public("fractional-proc/identification.csv") else { return };
    let bench = Bench::new();
    std::fs::copy(file.with_file_name("validation.csv"), bench.path("steps.csv")).unwrap();
    std::fs::copy(file, bench.path("ramps.csv")).unwrap();
    let command =
        "identify ramps.csv steps.csv --dynamics fractional --fix alpha=0 --dead-band 0.25 -o process.json";
    let run = bench.run(command);
    assert!(run.stderr.contains("the drive of 600 samples is below 0.25 and counts as 0"), "{}", run.stderr);
    let rmse = scores(&bench, "validate process.json ramps.csv steps.csv --dead-band 0.25 --json", "rmse");
    assert!(rmse.iter().all(|rmse| *rmse < 0.0035), "{rmse:?}");
    // Elsewhere: 0.6711 ± 0.0010 for the order that these records determine.
    let model: Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("process.json")).unwrap()).unwrap();
    let order = model["dynamics"]["denominator"][1]["order"]["value"].as_f64().unwrap();
    assert!((order - 0.671).abs() < 0.015, "{order}");
}

/// A soft electrostatic actuator, whose force grows with the square of the voltage: another thing than a
/// piezo stack. The joint optimum, which CMA-ES reaches too, leaves a third of the fastest record.
#[test]
fn soft_actuator_is_said_to_be_described_poorly() {
    let Some(file) = public("hasel-multifreq/sine_0p5Hz.csv") else { return };
    let bench = Bench::new();
    for name in ["sine_0p5Hz.csv", "sine_1p5Hz.csv", "sine_3p5Hz.csv"] {
        std::fs::copy(file.with_file_name(name), bench.path(name)).unwrap();
    }
    let command = "identify sine_0p5Hz.csv sine_1p5Hz.csv sine_3p5Hz.csv --input u_meas_V --dynamics \
                   fractional --degree 3 -o soft.json --json";
    let refused = bench.run(command);
    assert_eq!(refused.exit_code, 1, "{}", refused.stderr);
    for part in ["does not describe record 'sine_3p5Hz.csv'", "--least-fit 0"] {
        assert!(refused.stderr.contains(part), "{part} in {}", refused.stderr);
    }
    assert!(!refused.stderr.contains("implausible"), "{}", refused.stderr);
    assert!(!bench.path("soft.json").exists());
    let run = bench.run(&format!("{command} --least-fit 0"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    for name in ["sine_0p5Hz.csv", "sine_1p5Hz.csv", "sine_3p5Hz.csv"] {
        let part = format!("Record '{name}' is described poorly");
        assert!(run.stdout.contains(&part), "{part} in {}", run.stdout);
    }
}

/// One sine and steps do not determine a fractional resonance: no number has an error bar that is rounding,
/// no correlation leaves ±1. With both its orders the same, natural frequency and damping are one number:
/// they have no error bar at all.
#[test]
fn what_records_do_not_determine_has_no_error_bar() {
    let Some(sine) = public("hasel-multifreq/sine_1p5Hz.csv") else { return };
    let bench = Bench::new();
    std::fs::copy(sine.with_file_name("steps.csv"), bench.path("steps.csv")).unwrap();
    std::fs::copy(sine, bench.path("sine.csv")).unwrap();
    let one_number = "--dynamics fractional --creep fractional --fix order2=1.3 --fix order1=1.3";
    for (flags, without_error) in [
        ("--dynamics fractional --creep fractional", None),
        (one_number, Some(["natural_frequency", "damping"])),
    ] {
        let run =
            bench.run(&format!("identify sine.csv steps.csv --least-fit 0 {flags} -o hasel.json --json"));
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
        let told: Value = serde_json::from_str(&run.stdout).unwrap();
        let findings = told["findings"].to_string();
        for p in told["parameters"].as_array().unwrap() {
            let (value, error) = (p["value"].as_f64().unwrap(), p["std_error"].as_f64());
            assert!(value.is_finite() && error.is_none_or(|error| error < 1e3 * value.abs()), "{p}");
            let name = p["name"].as_str().unwrap();
            if without_error.is_some_and(|names| names.contains(&name)) {
                assert_eq!(error, None, "{p}");
                let said = format!("{name} ({} is one of many values that fit equally well)", short(value));
                assert!(findings.contains(&said), "{said} in {findings}");
            } else if name == "natural_frequency" {
                assert!(error.is_none_or(|error| error > 0.5 * value), "{p}");
                assert!(findings.contains("natural_frequency ("), "{findings}");
            }
        }
        assert!(findings.contains("not determined by these records"), "{findings}");
        let file: Value =
            serde_json::from_str(&std::fs::read_to_string(bench.path("hasel.json")).unwrap()).unwrap();
        for row in file["correlation"]["matrix"].as_array().unwrap() {
            assert!(row.as_array().unwrap().iter().all(|c| c.as_f64().unwrap().abs() <= 1.0), "{row}");
        }
    }
}

/// A third of the points of this response is noise: left out, and said.
#[test]
fn a_response_under_noise_is_fitted_where_it_says_something() {
    let Some(file) = public("piezo-npxy100a-frf/frf_x_axis.csv") else { return };
    let bench = Bench::new();
    std::fs::copy(file, bench.path("frf.csv")).unwrap();
    let of = |flags: &str| {
        let run =
            bench.run(&format!("frequency-response frf.csv --response stage --over ampV --json {flags}"));
        assert_eq!(run.exit_code, 0, "{run:?}");
        let told: Value = serde_json::from_str(&run.stdout).unwrap();
        let errors: Vec<f64> = told["structures"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|s| s["name"].as_str().unwrap().contains("mode"))
            .map(|s| s["rms_error_percent"].as_f64().unwrap())
            .collect();
        (errors, told["findings"].to_string(), run.stderr)
    };
    let (errors, _, stderr) = of("");
    assert!(stderr.contains("left out as noise"), "{stderr}");
    assert!(errors.windows(2).all(|two| two[1] <= two[0] * 1.001) && errors[0] < 9.0, "{errors:?}");
    let (errors, findings, _) = of("--band 1:12194");
    assert!(errors[0] > 30.0 && findings.contains("scatter by more than 30 %"), "{findings}");
    assert!(findings.contains("none of these describes the response"), "{findings}");
}

/// Stages under servo: the output is straight, the drive carries the hysteresis. Open-loop records are not
/// taken for such.
#[test]
fn a_record_under_servo_is_recognised() {
    let closed = "piezo-afm-cellhesion-100um/jpk00842_2016-06-15_50um_hold5s.csv";
    let open = "piezo-afm-z15um/ramps_0p2s_01.csv";
    for (file, servo) in [(closed, true), (open, false)] {
        let Some(file) = public(file) else { return };
        let bench = Bench::new();
        std::fs::copy(file, bench.path("record.csv")).unwrap();
        let run = bench.run("inspect record.csv --input u_V --output y_um");
        assert_eq!(run.exit_code, 0, "{run:?}");
        assert_eq!(run.stdout.contains("taken under servo"), servo, "{}", run.stdout);
    }
}
