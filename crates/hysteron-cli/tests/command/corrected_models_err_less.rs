//! `simulate --correct` and `validate --correct` add the predicted misfit of a device outside the model class
//! where that pays, and refuse elsewhere.

use crate::bench::Bench;
use serde_json::Value;

fn scores(bench: &Bench, arguments: &str) -> Value {
    let run = bench.run_well(&format!("validate stage.json held.csv --json {arguments}"));
    let mut scores: Value = serde_json::from_str(&run.stdout).unwrap();
    scores["records"][0].take()
}

/// On a device of the simulated bench, which shares no code with the model, by the commands alone.
#[test]
fn the_error_on_a_record_of_another_kind_falls() {
    let bench = Bench::new();
    bench.identify_outside_the_class();
    bench.run_well(
        "excite random --to 50 --duration 1 --sample-rate 2500 --low 2 --high 8 --soft-start 0.2 --seed 5 \
         --out drive.csv",
    );
    bench.run_well("rig --truth rig/truth.json --drive drive.csv --out-dir played --seed 2");
    std::fs::copy(bench.path("played/simulated_drive.csv"), bench.path("held.csv")).unwrap();

    let plain = scores(&bench, "--band");
    let corrected = scores(&bench, "--band --correct");
    let of = |scores: &Value, key: &str| scores[key].as_f64().unwrap();
    let [before, after] = [&plain, &corrected].map(|scores| of(scores, "rmse_um"));
    let inside = of(&corrected, "within_band_percent");
    let widths = [&plain, &corrected].map(|scores| of(scores, "band_of_measurement_um"));
    println!(
        "RMSE {before} µm, corrected {after} µm; left-out parts {}; in the band {inside} %, ± {widths:?} µm",
        corrected["left_out"]
    );
    assert!(after < 0.6 * before, "{before} {after}");
    assert!(of(&corrected, "left_out") < 0.9, "{corrected}");
    assert_eq!(corrected["without_correction"]["rmse_um"], plain["rmse_um"]);
    assert!(inside > 90.0 && widths[1] < widths[0], "{corrected} {plain}");
    let text = bench.run_well("validate stage.json held.csv --correct").stdout;
    assert!(text.contains("Corrected by the predicted misfit, which leaves "), "{text}");

    // The output written is the one scored.
    bench.run_well("simulate stage.json held.csv --correct --band measurement -o out.csv");
    let rows = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    let mut lines = rows.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(lines.next().unwrap(), "t_s,u_V,y_um,y_low_um,y_high_um,y_measured_um");
    let errors: Vec<f64> = lines
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>())
        .map(|cells| cells[5] - cells[2])
        .collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let rms = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
    assert!((rms / after - 1.0).abs() < 0.05, "{rms} {after}");

    // A model that gained nothing, one of a device in the class, a run in parts.
    let file: Value = serde_json::from_slice(&std::fs::read(bench.path("stage.json")).unwrap()).unwrap();
    let (mut no_gain, mut in_class) = (file.clone(), file);
    no_gain["misfit"]["left_out"] = 0.95.into();
    in_class.as_object_mut().unwrap().remove("misfit");
    for (name, file, because) in [
        ("no_gain.json", no_gain, "leaves 95 % of the error"),
        ("in_class.json", in_class, "no device outside the model class"),
    ] {
        bench.write(name, file.to_string());
        for command in ["validate MODEL held.csv", "simulate MODEL held.csv -o refused.csv"] {
            let run = bench.run(&format!("{} --correct", command.replace("MODEL", name)));
            assert_eq!(run.exit_code, 1, "{run:?}");
            assert!(run.stderr.contains(because) && run.stderr.contains("try: "), "{}", run.stderr);
            assert!(!bench.files().contains(&"refused.csv".to_owned()));
        }
    }
    assert_eq!(bench.run("validate stage.json held.csv --correct --continued").exit_code, 2);
}
