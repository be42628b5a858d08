//! `frequency-response` fits structures to a response or to multisine records, says what each explains, and
//! writes the one a model file can hold.

use crate::bench::model_data;
use hysteron_model::Start;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use hysteron_model::dynamics::{Dynamics, Scheme, SimulationPlan, TransferFunction};
use hysteron_rig::excitation::{ExcitationSpec, Lines, Phases, Waveform};
use serde_json::Value;

use crate::bench::Bench;

/// 0.13 e^{−0.03 i} s^−0.036 from 1 to 30 Hz.
fn lossy() -> String {
    let rows = (0..30).map(|k| {
        let f = 30f64.powf(f64::from(k) / 29.0);
        let phase = -0.03 - 0.036 * TAU / 4.0;
        format!("{f},{},{}\n", 0.13 * (TAU * f).powf(-0.036), phase.to_degrees())
    });
    format!("f_Hz,magnitude,phase_deg\n{}", rows.collect::<String>())
}

fn stage() -> String {
    let f: Vec<f64> = (0..120).map(|k| 2000f64.powf(f64::from(k) / 119.0)).collect();
    let values = TransferFunction::article_eq13().frequency_response(&f, 1e-4);
    let rows = f.iter().zip(&values).map(|(f, g)| format!("{f},{},{}\n", g.re, g.im));
    format!("f_Hz,re_um_per_V,im_um_per_V\n{}", rows.collect::<String>())
}

fn json(run: &crate::bench::Run) -> Value {
    assert_eq!((run.exit_code, run.stdout.trim_end().lines().count()), (0, 1), "{run:?}");
    serde_json::from_str(&run.stdout).unwrap()
}

fn structure<'a>(found: &'a Value, name: &str) -> &'a Value {
    let list = found["structures"].as_array().unwrap();
    list.iter().find(|s| s["name"] == name).unwrap_or_else(|| panic!("{name}: {found}"))
}

fn parameter(structure: &Value, name: &str) -> f64 {
    let list = structure["parameters"].as_array().unwrap();
    list.iter().find(|p| p["name"] == name).and_then(|p| p["value"].as_f64()).unwrap()
}

#[test]
fn a_loss_angle_is_found_and_no_model_file_can_hold_it() {
    let bench = Bench::new();
    bench.write("frf.csv", lossy());
    let run = bench.run("frequency-response frf.csv --json");
    let found = json(&run);
    let loss = structure(&found, "loss angle");
    assert!((parameter(loss, "loss_angle") - 0.03).abs() < 1e-8);
    assert!((parameter(loss, "exponent") - 0.036).abs() < 1e-8);
    assert!(loss["rms_error_percent"].as_f64().unwrap() < 1e-7);
    for other in ["power law", "fractional", "integer"] {
        assert!(structure(&found, other)["rms_error_percent"].as_f64().unwrap() > 0.1, "{other}");
    }
    let run = bench.run("frequency-response frf.csv --structure loss-angle -o new.json");
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{run:?}");
    assert!(run.stderr.contains("no causal linear system") && run.stderr.contains("try: "), "{}", run.stderr);
    assert!(!bench.path("new.json").exists());
    // With the others beside it the best of those is written, and it says which.
    let run = bench.run("frequency-response frf.csv -o new.json --report frf.html");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stderr.contains("wrote new.json: power law"), "{}", run.stderr);
    assert!(run.stdout.contains("further constant phase of −1.72°, a loss angle"), "{}", run.stdout);
    let page = std::fs::read_to_string(bench.path("frf.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("loss angle"));
}

#[test]
fn the_articles_stage_goes_into_a_model_file_that_simulates() {
    let bench = Bench::new();
    bench.write("frf.csv", stage());
    let run = bench.run("frequency-response frf.csv --structure fractional --band 1:1500 -o new.json --json");
    let found = json(&run);
    assert_eq!(found["unit"], "um_per_V");
    let fit = structure(&found, "fractional");
    for (name, expected) in [("order2", 2.0384), ("order1", 1.0523), ("delay", 1e-4)] {
        assert!((parameter(fit, name) / expected - 1.0).abs() < 1e-6, "{name}: {fit}");
    }
    let file = model_data(&bench.path("new.json"));
    assert_eq!((file.units.input.as_str(), file.units.output.as_str()), ("V", "um"));
    let Dynamics::Fractional(g) = file.to_model().unwrap().dynamics else { panic!("not fractional") };
    assert!((g.dc_gain() - 5.2589 / 5.4955).abs() < 1e-6, "{g}");
    bench.write("drive.csv", "t_s,u_V\n0,0\n0.001,1\n0.002,1\n0.003,1\n");
    let run = bench.run("simulate new.json drive.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
}

#[test]
fn multisine_records_give_response_noise_and_distortion() {
    let bench = Bench::new();
    let mut exact = 0;
    for seed in 0..3 {
        let waveform = Waveform::Multisine {
            low_hz: 2.0,
            high_hz: 150.0,
            period_s: 0.5,
            periods: 4,
            lines: Lines::Odd,
            phases: Phases::Random,
        };
        let drive =
            ExcitationSpec { seed, ..ExcitationSpec::new(2000.0, 0.0, 4.0, waveform) }.generate().unwrap();
        let u = drive.samples_v;
        let plan = SimulationPlan::new(u.len(), 2000.0, Scheme::BandLimited, Start::PERIODIC).unwrap();
        let mut y = vec![0.0; u.len()];
        plan.simulate(&TransferFunction::article_eq13(), &u, &mut plan.workspace(), &mut y).unwrap();
        // A little of the square shows at even lines, a little noise everywhere.
        let rows = u.iter().zip(&y).enumerate().map(|(k, (u, y))| {
            let noise = 1e-4 * ((k * k % 7919) as f64 * 0.7).sin();
            format!("{},{u},{}\n", k as f64 / 2000.0, y + 0.01 * u * u + noise)
        });
        bench.write(&format!("run{seed}.csv"), format!("t_s,u_V,y_um\n{}", rows.collect::<String>()));
        exact = drive.excited_hz.len();
    }
    let run = bench.run("frequency-response run0.csv run1.csv run2.csv --structure power-law --json");
    let found = json(&run);
    assert_eq!(
        (&found["weighting"], found["points"].as_u64()),
        (&Value::from("uncertainty"), Some(exact as u64))
    );
    let measured = &found["empirical"];
    assert_eq!(
        (&measured["realisations"], &measured["period_samples"]),
        (&Value::from(3), &Value::from(1000))
    );
    let of = |pointer: &str| measured.pointer(pointer).and_then(Value::as_f64).unwrap();
    assert!(of("/noise_percent") > 0.0 && of("/noise_percent") < 1.0, "{measured}");
    assert!(of("/even_detection/amplitude_rms") > 10.0 * of("/even_detection/noise_rms"), "{measured}");
    let run = bench.run("frequency-response run0.csv --structure power-law --report frf.html");
    assert!(run.stdout.contains("would distinguish nonlinear distortion from noise"), "{}", run.stdout);
    assert!(std::fs::read_to_string(bench.path("frf.html")).unwrap().contains("Noise and distortion"));
}

#[test]
fn what_cannot_be_used_is_refused_with_the_remedy() {
    let bench = Bench::new();
    bench.write("frf.csv", lossy());
    bench.write("bad.csv", "f_Hz,re,im\n1,2,3\n2,x,4\n");
    bench.write("run.csv", crate::bench::good_record());
    for (arguments, code, part) in [
        ("frequency-response bad.csv", 1, "line 3, column 2 (`re`): found `x`"),
        ("frequency-response frf.csv --response stage", 1, "no response `stage`"),
        ("frequency-response frf.csv --band 40:50", 1, "no point of the response lies between 40 and 50 Hz"),
        (
            "frequency-response frf.csv --band 1:1.2 --structure modes --modes 3",
            1,
            "take a wider band or a simpler structure",
        ),
        ("frequency-response run.csv --period 0.333", 1, "not a whole number"),
        ("frequency-response run.csv frf.csv", 1, "frequency response"),
        ("frequency-response frf.csv run.csv --response a", 2, "--response and --over choose"),
        ("frequency-response frf.csv --band 30", 2, "expected LOW:HIGH"),
        ("frequency-response frf.csv --structure cubic", 2, "cubic"),
        ("frequency-response", 2, "FILE"),
    ] {
        let run = bench.run(arguments);
        assert_eq!((run.exit_code, run.stdout.as_str()), (code, ""), "{arguments}: {run:?}");
        assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
    }
}

/// The measured stage over its amplifier's voltage, 1 to 30 Hz.
#[test]
fn the_measured_stage_has_a_loss_angle_besides_its_power_law() {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let file = folder.join("piezo-npxy100a-frf/frf_x_axis.csv");
    if !file.exists() {
        println!("skipped: no file {}; set HYSTERON_DATA to the public data", file.display());
        return;
    }
    let file = file.canonicalize().unwrap();
    let found = json(&Bench::new().run(&format!(
        "frequency-response {} --response stage --over ampV --band 1:30 --json",
        file.display()
    )));
    for (name, percent) in [("power law", 1.146), ("integer", 1.818), ("loss angle", 0.593)] {
        let rms = structure(&found, name)["rms_error_percent"].as_f64().unwrap();
        assert!((rms - percent).abs() < 1e-3, "{name}: {rms}");
    }
}
