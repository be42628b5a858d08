//! `identify --inputs … --outputs …` turns records of several axes into a file that `validate` and `simulate`
//! accept. The records are simulated.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::bench::Bench;
use hysteron_model::axes::{CoupledHammerstein, LevelLaw, Path as AxesPath, ScheduledModes};
use hysteron_model::hysteresis::BoucWen;
use hysteron_model::model_file::{Document, read};
use hysteron_model::record::InterSample;
use hysteron_numeric::Complex64;
use serde_json::Value;

const RATE: f64 = 1000.0;
const PERIOD: usize = 1024;
/// Half a bandwidth is four lines or more.
const DAMPING: f64 = 0.03;
/// Records: name, level in V, seed.
pub const LEVELS: [(&str, f64, u64); 5] =
    [("low1", 0.1, 1), ("low2", 0.1, 2), ("high1", 0.5, 3), ("high2", 0.5, 4), ("between", 0.3, 5)];
const COLUMNS: &str = "--inputs u1_V,u2_V --outputs y1_nm,y2_nm";

/// Two actuators, two sensors, modes at 130 and 250 Hz that fall by 3 % up to 0.5 V rms.
pub fn device() -> ScheduledModes {
    let (modes, states) = ([(130.0, [1.0, 0.4]), (250.0, [0.5, -0.9])], 6);
    let mut d = ScheduledModes {
        inputs: 2,
        outputs: 2,
        modes: 2,
        sample_rate_hz: RATE,
        steps: 1,
        level: LevelLaw { reference: 0.5, exponent: 1.0, lowest: 0.1, highest: 0.5, time_constant_s: 2.0 },
        transition: Vec::new(),
        transition_slopes: vec![0.0; states],
        input: vec![0.0; states * 2],
        strain_input: vec![0.0; states * 2],
        output: vec![0.0; 2 * states],
        output_slopes: vec![0.0; 2 * states],
        feedthrough: vec![0.0; 4],
        feedthrough_slopes: vec![0.0; 4],
        strain_feedthrough: vec![0.0; 4],
        feedback: None,
    };
    for (k, (frequency, direction)) in modes.into_iter().enumerate() {
        let angle = TAU * frequency / RATE;
        let pole = (Complex64::new(-DAMPING, 1.0) * angle).exp();
        let slope = pole * pole.ln() * -0.03;
        d.transition.extend([pole.re, pole.im]);
        (d.transition_slopes[2 * k], d.transition_slopes[2 * k + 1]) = (slope.re, slope.im);
        for (axis, share) in direction.into_iter().enumerate() {
            d.input[2 * k * 2 + axis] = angle * share;
            d.output[axis * states + 2 * k + 1] = share;
        }
    }
    for axis in 0..2 {
        d.transition.push(0.3);
        d.input[(4 + axis) * 2 + axis] = 0.7;
        d.output[axis * states + 4 + axis] = 1.5;
    }
    d
}

/// Two periods of the device under multisines up to 400 Hz of this level, as a file, with a little noise on
/// the outputs.
pub fn csv(level: f64, seed: u64) -> String {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let lines = 400 * PERIOD / 1000;
    let mut channel = || {
        let shifts: Vec<usize> = (0..lines).map(|_| (random() * PERIOD as f64) as usize).collect();
        let at = |k: usize| -> f64 {
            let line = |(l, shift): (usize, &usize)| {
                (TAU * (((l + 1) * k + shift) % PERIOD) as f64 / PERIOD as f64).cos()
            };
            shifts.iter().enumerate().map(line).sum()
        };
        let size = level / (0.5 * lines as f64).sqrt();
        (0..PERIOD).map(|k| size * at(k)).collect::<Vec<f64>>().repeat(2)
    };
    let u = vec![channel(), channel()];
    let start = Some(PERIOD);
    let y = device().simulate(&u, RATE, InterSample::BandLimited, start).unwrap();
    let mut text = "t_s,u1_V,u2_V,y1_nm,y2_nm\n".to_owned();
    for k in 0..2 * PERIOD {
        let nm = |y: f64, noise: f64| 1e3 * y + 2.0 * (noise - 0.5);
        let (a, b) = (nm(y[0][k], random()), nm(y[1][k], random()));
        writeln!(text, "{},{},{},{a},{b}", k as f64 / RATE, u[0][k], u[1][k]).unwrap();
    }
    text
}

fn bench() -> Bench {
    let bench = Bench::new();
    for (name, level, seed) in LEVELS {
        bench.write(&format!("{name}.csv"), csv(level, seed));
    }
    bench
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// The device follows the level itself (--exponent 1), which two levels do not show.
#[test]
fn records_of_two_levels_become_a_file_that_predicts_one_between() {
    let bench = bench();
    let run = bench.run(&format!(
        "identify low1.csv low2.csv high1.csv high2.csv {COLUMNS} --modes 2 --steps 1 --plays 2 --iterations \
         2 --exponent 1 -o stage.json --json"
    ));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told = json(&run.stdout);
    assert_eq!((told["structure"].as_str(), told["interrupted"].as_bool()), (Some("modes"), Some(false)));
    // |s|/2π of the poles made above, at both levels.
    for (k, frequency) in [130.0, 250.0].into_iter().enumerate() {
        let mode = &told["modes"][k];
        let resonance = frequency * (1.0 + DAMPING * DAMPING).sqrt();
        let high = mode["highest_level"]["frequency_hz"].as_f64().unwrap();
        let low = mode["lowest_level"]["frequency_hz"].as_f64().unwrap();
        assert!((high / resonance - 1.0).abs() < 1e-3, "{mode}");
        assert!((low / high - 1.024).abs() < 2e-3, "{mode}");
    }
    let Document::Modes(file) = read(&std::fs::read(bench.path("stage.json")).unwrap()).unwrap() else {
        panic!()
    };
    assert_eq!((file.inputs, file.outputs), (vec!["u1".into(), "u2".into()], vec!["y1".into(), "y2".into()]));
    assert_eq!((file.units.input.as_str(), file.units.output.as_str()), ("V", "um"));
    assert_eq!(told["influence"].as_array().map(Vec::len), Some(2));
    // Every quantity has a standard error, in the result and in the file.
    let parameters = told["parameters"].as_array().unwrap();
    let frequency = parameters.iter().find(|p| p["of"] == "mode 1" && p["name"] == "frequency_highest_level");
    let frequency = frequency.unwrap();
    let error = frequency["std_error"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.1, "{frequency}");
    assert_eq!(file.quantities.len(), parameters.len());
    assert!(file.quantities.iter().all(|q| q.std_error.is_some()), "{:?}", file.quantities);

    // The columns are those of the file; the errors are pooled and listed.
    let run = bench.run("validate stage.json between.csv high1.csv --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told = json(&run.stdout);
    let record = &told["records"][0];
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value}"));
    assert!(number(&record["fit_percent"]) > 99.0, "{record}");
    assert!((number(&record["level"]) - 0.3).abs() < 1e-3, "{record}");
    let outputs: Vec<f64> = (0..2).map(|o| number(&record["outputs"][o]["rmse_um"])).collect();
    let pooled = (0.5 * (outputs[0] * outputs[0] + outputs[1] * outputs[1])).sqrt();
    assert!((number(&record["rmse_um"]) / pooled - 1.0).abs() < 1e-12, "{record}");
    assert!(number(&record["rmse_mean_period_um"]) < number(&record["rmse_um"]), "{record}");
    // Outputs in another order are other outputs.
    let run = bench.run("validate stage.json high1.csv --outputs y2_nm,y1_nm --json");
    assert!(number(&json(&run.stdout)["records"][0]["fit_percent"]) < 50.0, "{}", run.stdout);

    let run = bench.run("simulate stage.json between.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let text = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(text.starts_with("t_s,u1_V,u2_V,y1_um,y2_um\n"), "{}", &text[..60]);
    let run = bench.run("validate stage.json out.csv --json");
    assert!(number(&json(&run.stdout)["records"][0]["fit_percent"]) > 99.99, "{}", run.stdout);
}

/// Two axes with hysteresis and coupling, both driven at once by slow waves and low-passed noise from rest.
pub fn slow_csv(seed: u64, samples: usize) -> String {
    let actuator = |alpha, beta, gamma| BoucWen { polynomial: vec![1.0], alpha, beta, gamma, n: 1.0 };
    let path =
        |gain, natural_frequency_hz| AxesPath { gain, natural_frequency_hz, damping: 0.1, delay_s: 1e-3 };
    let stage = CoupledHammerstein {
        actuators: vec![actuator(0.25, 0.9, 0.2), actuator(0.32, 0.6, -0.15)],
        paths: vec![path(1.4, 70.0), path(-0.3, 95.0), path(0.2, 82.0), path(1.1, 60.0)],
        offsets: vec![3.0, -2.0],
        sample_rate_hz: RATE,
    };
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut drive = |slow_hz: f64| -> Vec<f64> {
        let mut low = 0.0;
        let at = |k: usize| {
            low += 0.3 * (3.0 * random() - low);
            let t = k as f64 / RATE;
            1.5 * (TAU * slow_hz * t).sin() * (0.4 + 0.4 * t) + low
        };
        (0..samples).map(at).collect()
    };
    let u = vec![drive(2.3), drive(3.1)];
    let y = stage.simulate(&u, RATE, None).unwrap();
    let mut text = "t_s,u1_V,u2_V,y1_nm,y2_nm\n".to_owned();
    for k in 0..samples {
        let nm = |y: f64, noise: f64| 1e3 * y + 10.0 * noise;
        let (a, b) = (nm(y[0][k], random()), nm(y[1][k], random()));
        writeln!(text, "{},{},{},{a},{b}", k as f64 / RATE, u[0][k], u[1][k]).unwrap();
    }
    text
}

#[test]
fn records_that_do_not_repeat_become_branches_that_predict_another() {
    let bench = Bench::new();
    bench.write("train.csv", slow_csv(1, 1200));
    bench.write("unseen.csv", slow_csv(2, 1200));
    let run =
        bench.run(&format!("identify train.csv {COLUMNS} --structure hammerstein -o stage.json --json"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told = json(&run.stdout);
    assert_eq!(told["structure"], "hammerstein");
    let parameters = told["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 22);
    let of = |of: &str, name: &str, truth: f64| {
        let found = parameters.iter().find(|p| p["of"] == of && p["name"] == name).unwrap();
        let (value, error) = (found["value"].as_f64().unwrap(), found["std_error"].as_f64().unwrap());
        assert!((value - truth).abs() < 4.5 * error, "{found}, truth {truth}");
    };
    of("u2", "alpha", 0.32);
    of("u2 to y1", "gain", -0.3);
    of("u1 to y2", "natural_frequency", 82.0);
    let run = bench.run("validate stage.json unseen.csv --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told = json(&run.stdout);
    assert!(told["records"][0]["fit_percent"].as_f64().unwrap() > 99.0, "{}", run.stdout);
    let run = bench.run("validate stage.json unseen.csv");
    assert!(run.stdout.contains("RMSE y2 [µm]"), "{}", run.stdout);
    let run = bench.run("simulate stage.json unseen.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    for (flags, words) in
        [("--modes 3", "--modes goes with"), ("--dynamics integer", "--dynamics does not go")]
    {
        let run =
            bench.run(&format!("identify train.csv {COLUMNS} --structure hammerstein -o x.json {flags}"));
        assert!(run.exit_code == 2 && run.stderr.contains(words), "{}", run.stderr);
    }
    let run = bench.run(&format!("identify train.csv {COLUMNS} -o x.json"));
    assert!(run.exit_code == 1 && run.stderr.contains("--structure hammerstein"), "{}", run.stderr);
}

#[test]
fn the_result_for_people_shows_modes_influence_and_what_is_not_known() {
    let bench = bench();
    let run = bench.run(&format!(
        "identify high1.csv high2.csv {COLUMNS} --modes 2 --steps 1 --linear -o stage.json --report \
        stage.html"
    ));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(bench.path("stage.html")).unwrap();
    for words in ["Gains at rest", "Response of y2", "Output and error: high1.csv", "±"] {
        assert!(page.contains(words), "{words}");
    }
    for words in [
        "highest level [Hz]",
        "[µm/V]",
        "RMSE y1 [µm]",
        "condition number",
        "gain at rest",
        " ± ",
        "one level",
        "parameters were fitted",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let run = bench.run("validate stage.json between.csv");
    assert!(run.stderr.contains("it extrapolates"), "{}", run.stderr);
    assert!(run.stdout.contains("of mean period [µm]"), "{}", run.stdout);
}

#[test]
fn what_cannot_be_used_is_refused() {
    let bench = bench();
    let refuse = |command: &str, exit_code: i32, words: &str| {
        let run = bench.run(command);
        assert_eq!(run.exit_code, exit_code, "{command}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{command}: {}", run.stderr);
    };
    refuse("identify high1.csv --inputs u1_V,u2_V -o s.json", 2, "--outputs");
    refuse(
        "identify high1.csv --inputs u1_V,u3_V --outputs y1 -o s.json",
        1,
        "no channel `u3_V`; there are u1_V, u2_V",
    );
    refuse("identify high1.csv --inputs u1_V,y1_nm --outputs y2 -o s.json", 1, "different units");
    refuse(&format!("identify high1.csv {COLUMNS} --structure oscillator -o s.json"), 2, "--structure modes");
    refuse(&format!("identify high1.csv {COLUMNS} --degree 2 -o s.json"), 2, "--degree does not go");
    refuse(&format!("identify high1.csv {COLUMNS} --initial rest -o s.json"), 2, "steady state");
    refuse(&format!("identify high1.csv {COLUMNS} --steps 9 -o s.json"), 2, "steps is 9");
    refuse("identify high1.csv --modes 3 --input u1 --output y1 -o s.json", 2, "--modes goes with");
    refuse(&format!("identify high1.csv {COLUMNS} --input u1 -o s.json"), 2, "cannot be used with");
    let header = csv(0.5, 3).lines().take(700).fold(String::new(), |all, line| all + line + "\n");
    bench.write("cut.csv", header);
    refuse(&format!("identify cut.csv {COLUMNS} -o s.json"), 1, "do not repeat");
    let faster = csv(0.5, 3).replace("t_s,", "t_ms,");
    bench.write("faster.csv", faster);
    refuse(&format!("identify high1.csv faster.csv {COLUMNS} -o s.json"), 1, "sample rates");
    assert!(!bench.path("s.json").exists());
    refuse("validate model.json high1.csv --inputs u1", 2, "several axes");

    let run = bench
        .run(&format!("identify high1.csv high2.csv {COLUMNS} --modes 2 --steps 1 --linear -o stage.json"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    refuse("validate stage.json high1.csv --band", 2, "--band");
    refuse("validate stage.json high1.csv --rest-voltage 1", 2, "--rest-voltage");
    refuse("validate stage.json faster.csv", 1, "identified at 1000 Hz");
    refuse("recalibrate stage.json high1.csv -o x.json", 1, "kind \"modes\"");
    let text = std::fs::read_to_string(bench.path("stage.json")).unwrap();
    bench.write("bad.json", text.replacen("\"modes\": 2", "\"modes\": 3", 1));
    refuse("validate bad.json high1.csv", 1, "transition: expected 8 numbers, found 6");
}

#[test]
fn structures_are_compared_by_what_was_held_out() {
    let bench = bench();
    let compare = format!("compare low1.csv low2.csv high1.csv high2.csv {COLUMNS}");
    let run = bench.run(&format!(
        "{compare} --candidates modes1+linear,modes2+linear -o best.json --json --report compare.html"
    ));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told = json(&run.stdout);
    assert_eq!(told["preferred"], "modes2+linear");
    assert_eq!(told["folds"].as_array().map(Vec::len), Some(2));
    let candidates = told["candidates"].as_array().unwrap();
    let error = |k: usize| candidates[k]["error"].as_f64().unwrap_or(f64::INFINITY);
    assert!(error(0) < 0.5 * error(1), "{told}");
    assert!(bench.path("best.json").exists());
    assert!(std::fs::read_to_string(bench.path("compare.html")).unwrap().contains("modes1+linear"));
    for (command, code, words) in [
        (format!("{compare} --candidates integer2"), 2, "one input and one output"),
        (format!("{compare} --quick"), 2, "--quick does not go"),
        (format!("{compare} --resume none.json"), 1, "cannot resume"),
        (format!("compare low1.csv high1.csv {COLUMNS}"), 1, "one record only"),
        ("compare model.json --candidates plays6".to_owned(), 2, "--inputs and --outputs"),
    ] {
        let run = bench.run(&command);
        assert!(run.exit_code == code && run.stderr.contains(words), "{command}: {}", run.stderr);
    }
}

#[test]
fn a_record_of_several_actuators_given_as_one_of_one_names_the_flags() {
    let bench = Bench::new();
    let mut rows = String::from("t_s,u1_V,u2_V,y1_um,y2_um\n");
    for k in 0..400 {
        let t = 5e-3 * f64::from(k);
        let [u, v] = [1.0, 1.7].map(|hz: f64| 5.0 - 5.0 * (TAU * hz * t).cos());
        writeln!(rows, "{t},{u},{v},{},{}", 2.0 * u + 1.5 * v, 2.0 * v).unwrap();
    }
    bench.write("two.csv", rows);
    let flags = "several drives move on their own; all actuators together are --inputs u1_V,u2_V --outputs y1_um,y2_um";
    // Without columns, and where one of the drives does not explain the motion.
    for columns in ["", "--input u1 --output y1"] {
        let run = bench.run(&format!("identify two.csv -o model.json {columns}"));
        assert!(run.exit_code == 1 && run.stderr.contains(flags), "{columns}: {}", run.stderr);
    }
    let run = bench.run("identify two.csv -o model.json --input nothing");
    assert!(run.exit_code == 1 && !run.stderr.contains(flags), "{}", run.stderr);
}
