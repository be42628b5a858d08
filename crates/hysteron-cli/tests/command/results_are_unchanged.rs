//! Fits, scores and simulations are those on record in `tests/unchanged/`, for every family, dynamics, kind
//! and method. The models on record are of version 1 of the file format. How records are made anew stands
//! beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::bench::Bench;
use crate::{oscillators_are_identified as oscillators, several_axes_are_identified as several_axes};

/// Largest distance of a simulation, as a share of its stroke.
const OF_STROKE: f64 = 1e-9;
/// Largest distance of a parameter, in its standard errors.
const OF_STD_ERROR: f64 = 1e-3;
/// Largest relative distance of a score.
const OF_SCORE: f64 = 1e-6;
/// Samples of a simulation on record, spread over it.
const SAMPLES: usize = 12;
/// What a model on record is read and simulated without; left in the first of them.
const NOT_ON_RECORD: [&str; 5] = ["correlation", "misfit", "provenance", "scores", "valid_range"];

const RIG: &str = "simulated_nested_loops.csv simulated_sweep_1_90hz.csv";
const SWEEP: &str = "simulated_sweep_1_90hz.csv";
const STACK: &str = "p885.csv";
const AXES: &str = "--inputs u1_V,u2_V --outputs y1_nm,y2_nm";

/// A model identified by one command.
struct Campaign {
    name: &'static str,
    /// Records and flags of `identify`.
    arguments: String,
    /// Record that the model is simulated along.
    drive: &'static str,
}

fn campaigns() -> Vec<Campaign> {
    let on = |records: &'static str, drive: &'static str| {
        move |(name, flags): (&'static str, &str)| Campaign {
            name,
            arguments: format!("{records} {flags}"),
            drive,
        }
    };
    let rig = [
        ("bouc-wen", "--dynamics integer"),
        ("prandtl-ishlinskii", "--hysteresis prandtl-ishlinskii --elements 6 --dynamics integer"),
        ("dahl", "--hysteresis dahl --dynamics integer"),
        ("maxwell-slip", "--hysteresis maxwell-slip --elements 6 --dynamics integer"),
        ("one-sided-plays", "--hysteresis one-sided-plays --elements 6 --dynamics integer"),
        ("rate-dependent-plays", "--hysteresis rate-dependent-plays --elements 5 --dynamics integer"),
        ("generalised-plays", "--hysteresis generalised-plays --elements 4 --dynamics integer"),
        ("preisach", "--hysteresis preisach --elements 5 --dynamics integer"),
        ("modes5", "--dynamics modes --order 5"),
        ("arx", "--dynamics arx"),
        ("oe", "--dynamics oe"),
        ("srivc", "--dynamics srivc"),
        ("fractional-free-lowest", "--dynamics fractional-free-lowest"),
        ("fractional-creep", "--dynamics integer --creep fractional"),
        ("kelvin-voigt-creep", "--dynamics integer --creep kelvin-voigt --creep-elements 1"),
        ("two-step", "--method two-step --dynamics fractional"),
    ];
    let stack = [
        ("parallel-bouc-wen", "--hysteresis parallel-bouc-wen"),
        ("non-symmetric-bouc-wen", "--hysteresis non-symmetric-bouc-wen"),
        ("song-der-kiureghian", "--hysteresis song-der-kiureghian"),
        ("duhem", "--hysteresis duhem"),
        ("dead-zone-plays", "--hysteresis dead-zone-plays --elements 5"),
        ("krasnoselskii-pokrovskii", "--hysteresis krasnoselskii-pokrovskii --elements 3"),
        ("preisach-density", "--hysteresis preisach-density --degree 1"),
        ("jiles-atherton", "--hysteresis jiles-atherton"),
        ("de-abc", "--optimizer de-abc --generations 10 --population 8"),
    ];
    let scheduled = format!("{AXES} --modes 2 --steps 1 --plays 2 --iterations 2");
    let branches = format!("{AXES} --structure hammerstein");
    let mut all: Vec<Campaign> = rig.into_iter().map(on(RIG, SWEEP)).collect();
    all.extend(stack.into_iter().map(on(STACK, STACK)));
    all.push(on("force.csv", "force.csv")(("oscillator", "--structure oscillator")));
    all.push(on("low1.csv low2.csv high1.csv high2.csv", "high1.csv")(("modes", &scheduled)));
    all.push(on("axes.csv", "axes.csv")(("branches", &branches)));
    all
}

/// A folder with the records of all campaigns.
fn bench(program: &Path) -> Bench {
    let bench = Bench::new();
    let plays: Vec<Value> = (0..8)
        .map(|k| {
            let weight = 0.2 * 0.8_f64.powi(k);
            let k = f64::from(k);
            json!({"rising_v": 0.3 + 0.5 * k, "falling_v": 0.25 + 0.45 * k, "weight_um_per_v": weight})
        })
        .collect();
    let truth = json!({
        "plant": {
            "kind": "play_stack", "amplifier_corner_hz": 400, "linear_um_per_v": 1.7, "plays": plays,
            "quadratic_per_um": 0.004, "cubic_per_um2": -6e-5,
            "modes": [{"frequency_hz": 70, "damping": 0.15, "share": 0.9},
                      {"frequency_hz": 190, "damping": 0.05, "share": 0.1}],
            "creep": {"strength": 0.08, "order": 0.15, "corner_hz": 0.001}, "delay_s": 0.00123
        },
        "sensor": {"noise_um": 0.005, "adc": {"bits": 16, "low_um": -30, "high_um": 100}}
    });
    let plan = json!({
        "sample_rate_hz": 500, "loop_hz": 2, "loop_periods": 1.5, "sweep_end_hz": 90, "sweep_s": 1.2,
        "validation_hz": [20], "validation_s": 0.2, "nested_amplitudes": [1, 0.6, 0.3]
    });
    bench.write("truth.json", truth.to_string());
    bench.write("plan.json", plan.to_string());
    done(&bench, program, "rig --out-dir . --seed 1 --truth truth.json --plan plan.json");
    let stack =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/piezo-p885-200hz/identification_1hz.csv");
    let stack = std::fs::read_to_string(stack).unwrap();
    bench.write(STACK, stack.lines().take(801).fold(String::new(), |all, line| all + line + "\n"));
    bench.write("force.csv", oscillators::settled_record());
    for (name, level, seed) in several_axes::LEVELS {
        bench.write(&format!("{name}.csv"), several_axes::csv(level, seed));
    }
    bench.write("axes.csv", several_axes::slow_csv(1, 600));
    bench
}

fn on_record() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/unchanged/records.json")
}

fn records() -> Map<String, Value> {
    serde_json::from_slice(&std::fs::read(on_record()).unwrap()).unwrap()
}

/// Value and standard error of every parameter that has one, by name.
fn parameters(told: &Value) -> BTreeMap<String, [f64; 2]> {
    fn walk(value: &Value, path: &str, found: &mut BTreeMap<String, [f64; 2]>) {
        if let (Some(number), Some(error)) = (value["value"].as_f64(), value["std_error"].as_f64()) {
            let part = |key: &str| value[key].as_str().map(|name| format!(" {name}")).unwrap_or_default();
            found.insert(format!("{path}{}{}", part("of"), part("name")).trim().to_owned(), [number, error]);
        } else if let Some(object) = value.as_object() {
            object.iter().for_each(|(key, value)| walk(value, &format!("{path} {key}"), found));
        } else if let Some(list) = value.as_array() {
            let named = list.iter().all(|value| value["name"].is_string());
            for (k, value) in list.iter().enumerate() {
                walk(value, &if named { path.to_owned() } else { format!("{path} {k}") }, found);
            }
        }
    }
    let mut found = BTreeMap::new();
    match &told["parameters"] {
        Value::Null => {
            ["hysteresis", "dynamics", "delay"].iter().for_each(|part| walk(&told[part], part, &mut found));
        }
        all => walk(all, "", &mut found),
    }
    found
}

/// What `identify --json` told of each record, by record.
fn scores(told: &Value) -> Vec<[f64; 2]> {
    let score = |record: &Value| ["rmse_um", "fit_percent"].map(|key| record[key].as_f64().unwrap());
    told["records"].as_array().unwrap().iter().map(score).collect()
}

/// The columns of the model's output, `rows[k][output]`.
fn output(csv: &str) -> Vec<Vec<f64>> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let is_output = |name: &str| name.starts_with('y') && !name.starts_with("y_measured");
    let of = |line: &str| -> Vec<f64> {
        let cells = names.iter().zip(line.split(','));
        cells.filter(|(name, _)| is_output(name)).map(|(_, y)| y.parse().unwrap()).collect()
    };
    lines.map(of).collect()
}

/// The rows on record of so many.
fn sampled(rows: usize) -> impl Iterator<Item = usize> {
    (1..=SAMPLES).map(move |k| k * (rows - 1) / SAMPLES)
}

/// Runs a command that has to end well.
fn done(bench: &Bench, program: &Path, arguments: &str) -> String {
    let run = bench.run_program(program, arguments);
    assert_eq!(run.exit_code, 0, "{arguments}: {}", run.stderr);
    run.stdout
}

fn this_program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_hysteron"))
}

fn identify(bench: &Bench, program: &Path, campaign: &Campaign) -> Value {
    let Campaign { name, arguments, .. } = campaign;
    let told = done(
        bench,
        program,
        &format!("identify {arguments} --least-fit 0 --seed 1 -o identified-{name}.json --json"),
    );
    serde_json::from_str(&told).unwrap()
}

/// Simulates this model along the campaign's drive.
fn simulate(bench: &Bench, program: &Path, campaign: &Campaign, model: &Value) -> Vec<Vec<f64>> {
    let Campaign { name, drive, .. } = campaign;
    bench.write(&format!("{name}.json"), model.to_string());
    done(bench, program, &format!("simulate {name}.json {drive} -o {name}.csv"));
    output(&std::fs::read_to_string(bench.path(&format!("{name}.csv"))).unwrap())
}

#[test]
fn models_on_record_are_read_and_simulate_as_they_did() {
    let (bench, records, mut wrong) = (bench(this_program()), records(), Vec::new());
    for campaign in campaigns() {
        let record = &records[campaign.name];
        assert_eq!(record["model"]["version"], 1, "{}: the models on record are of version 1", campaign.name);
        let rows = simulate(&bench, this_program(), &campaign, &record["model"]);
        let expected: Vec<Vec<f64>> = serde_json::from_value(record["simulated"].clone()).unwrap();
        assert_eq!(expected.len(), SAMPLES, "{}", campaign.name);
        for axis in 0..expected[0].len() {
            let y = || rows.iter().map(|row| row[axis]);
            let stroke = y().fold(f64::MIN, f64::max) - y().fold(f64::MAX, f64::min);
            for (k, expected) in sampled(rows.len()).zip(&expected) {
                let distance = (rows[k][axis] - expected[axis]).abs() / stroke;
                if distance.is_nan() || distance > OF_STROKE {
                    wrong.push(format!(
                        "{}: sample {k} of output {axis} moved by {distance:.1e} of the stroke",
                        campaign.name
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn fits_and_scores_are_those_on_record() {
    let (bench, records, mut wrong) = (bench(this_program()), records(), Vec::new());
    for campaign in campaigns() {
        let (name, record) = (campaign.name, &records[campaign.name]);
        let told = identify(&bench, this_program(), &campaign);
        let found = parameters(&told);
        let expected: BTreeMap<String, [f64; 2]> =
            serde_json::from_value(record["parameters"].clone()).unwrap();
        if !found.keys().eq(expected.keys()) {
            wrong.push(format!("{name}: {:?} instead of {:?}", found.keys(), expected.keys()));
            continue;
        }
        for (parameter, [value, error]) in &expected {
            let distance = (found[parameter][0] - value).abs() / error;
            if distance > OF_STD_ERROR {
                wrong.push(format!("{name}: {parameter} moved by {distance:.1e} standard errors"));
            }
            let [_, now] = found[parameter];
            if (now / error - 1.0).abs() > OF_STD_ERROR {
                wrong.push(format!("{name}: the standard error of {parameter} is {now}, was {error}"));
            }
        }
        let expected: Vec<[f64; 2]> = serde_json::from_value(record["scores"].clone()).unwrap();
        let found = scores(&told);
        assert_eq!(found.len(), expected.len(), "{name}");
        for (now, was) in found.iter().flatten().zip(expected.iter().flatten()) {
            if (now / was - 1.0).abs() > OF_SCORE {
                wrong.push(format!("{name}: a score is {now}, was {was}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// `number` to so many significant digits.
fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits - 1).parse().unwrap()
}

/// Leaves out what the format lets be left out and no simulation reads.
fn shorten(model: &mut Value) {
    fn round_errors(value: &mut Value) {
        match value {
            Value::Object(object) => {
                object.retain(|key, value| key != "std_error" || !value.is_null());
                for (key, value) in object.iter_mut() {
                    match value.as_f64() {
                        Some(error) if key == "std_error" => *value = json!(rounded(error, 5)),
                        _ => round_errors(value),
                    }
                }
            }
            Value::Array(list) => list.iter_mut().for_each(round_errors),
            _ => {}
        }
    }
    model.as_object_mut().unwrap().retain(|key, _| !NOT_ON_RECORD.contains(&key.as_str()));
    round_errors(model);
}

/// Keeps the models that are on record: only what they and the fits give is made anew. `HYSTERON_RECORD_WITH`
/// names another program to make it with.
#[test]
#[ignore = "writes the records that the other tests here compare with"]
fn records_are_made_anew() {
    let program =
        std::env::var_os("HYSTERON_RECORD_WITH").map_or_else(|| this_program().to_owned(), PathBuf::from);
    let (bench, before) = (bench(&program), if on_record().exists() { records() } else { Map::new() });
    let mut lines = Vec::new();
    for (k, campaign) in campaigns().iter().enumerate() {
        let told = identify(&bench, &program, campaign);
        let model = before.get(campaign.name).map_or_else(
            || {
                let file = bench.path(&format!("identified-{}.json", campaign.name));
                let mut model: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
                if k > 0 {
                    shorten(&mut model);
                }
                model
            },
            |record| record["model"].clone(),
        );
        let rows = simulate(&bench, &program, campaign, &model);
        let simulated: Vec<Vec<f64>> =
            sampled(rows.len()).map(|k| rows[k].iter().map(|y| rounded(*y, 11)).collect()).collect();
        let parameters: BTreeMap<String, [f64; 2]> = parameters(&told)
            .into_iter()
            .map(|(name, [value, error])| (name, [rounded(value, 11), rounded(error, 5)]))
            .collect();
        let scores: Vec<[f64; 2]> = scores(&told).iter().map(|pair| pair.map(|s| rounded(s, 9))).collect();
        let record =
            json!({"parameters": parameters, "scores": scores, "simulated": simulated, "model": model});
        lines.push(format!("{}: {record}", json!(campaign.name)));
    }
    std::fs::create_dir_all(on_record().parent().unwrap()).unwrap();
    std::fs::write(on_record(), format!("{{\n{}\n}}\n", lines.join(",\n"))).unwrap();
}
