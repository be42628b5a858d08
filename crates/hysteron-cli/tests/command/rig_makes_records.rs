//! `rig` writes the records of a simulated campaign, the same for the same seed, with the truth beside them.

use crate::bench::Bench;

/// A campaign small enough for a test.
const PLAN: &str = r#"{"sample_rate_hz": 1000, "loop_periods": 1, "sweep_s": 0.5, "validation_hz": [10],
    "validation_s": 0.2}"#;

#[test]
fn a_campaign_is_written_with_its_truth_and_repeats_by_seed() {
    let bench = Bench::new();
    bench.write("plan.json", PLAN);
    for (folder, seed) in [("a", 1), ("b", 1), ("c", 2)] {
        let run = bench.run(&format!("rig --plan plan.json --out-dir {folder} --seed {seed}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (0, ""), "{run:?}");
    }
    let names = ["simulated_loop_1hz.csv", "simulated_sweep_1_100hz.csv", "simulated_sine_10hz.csv"];
    let read = |folder: &str, name: &str| std::fs::read_to_string(bench.path(folder).join(name)).unwrap();
    for name in names {
        let text = read("a", name);
        assert!(text.starts_with('#') && text.contains("\nt_s,u_V,y_um\n"), "{name}: {}", &text[..200]);
        assert_eq!(text, read("b", name), "{name}");
        assert_ne!(text, read("c", name), "{name}");
    }
    let run = bench.run(&format!("validate model.json a/{} a/{} a/{} --json", names[0], names[1], names[2]));
    assert_eq!(run.exit_code, 0, "{run:?}");

    // What was in force can be fed in again.
    let run = bench.run("rig --truth a/truth.json --plan a/plan.json --out-dir d --seed 1");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert_eq!(read("a", names[1]), read("d", names[1]));

    // Edited, it is not replaced by the default.
    let edited = read("a", "truth.json").replace("\"oversampling\": ", "\"oversampling\": 2");
    bench.write("a/truth.json", &edited);
    let run = bench.run("rig --plan plan.json --out-dir a --seed 1");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("--truth a/truth.json simulates it"), "{}", run.stderr);
    assert_eq!(read("a", "truth.json"), edited);
}

#[test]
fn a_drive_of_ones_own_is_played_and_the_truth_shown_if_asked_for() {
    let bench = Bench::new();
    bench.run("excite sine --frequency 10 --periods 2 --sample-rate 1000 --high 10 -o drive.csv");
    let run = bench.run("rig --drive drive.csv --out-dir out --with-truth");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let text = std::fs::read_to_string(bench.path("out/simulated_drive.csv")).unwrap();
    assert!(text.contains("\nt_s,u_V,y_um,y_true_um,v_true_um\n"), "{}", &text[..300]);
    assert_eq!(text.lines().filter(|l| !l.starts_with('#')).count(), 201);
}

/// A truth with so many modes.
fn with_modes(count: usize) -> String {
    let mode = |k: usize| format!(r#"{{"frequency_hz": {}, "damping": 0.01, "share": 1}}"#, 100 + k);
    let modes: Vec<String> = (0..count).map(mode).collect();
    format!(r#"{{"plant": {{"kind": "play_stack", "modes": [{}]}}}}"#, modes.join(","))
}

#[test]
fn a_truth_that_makes_no_sense_is_refused_by_name_and_nothing_is_written() {
    let (modes, strong) = (with_modes(202), r#"{"plant": {"kind": "play_stack", "linear_um_per_v": 1e300}}"#);
    for (truth, part) in [
        (modes.as_str(), "plant.modes has 202 entries, expected at most 100"),
        (strong, "plant.linear_um_per_v is 1"),
        ("{", "the file ends within an object"),
        (r#"{"sensr": {}}"#, "unknown field `sensr`"),
        (r#"{"oversampling": 2}"#, "oversampling is 2"),
        (r#"{"sensor": {"noise_um": -1}}"#, "noise_um is -1"),
    ] {
        let bench = Bench::new();
        bench.write("truth.json", truth);
        bench.write("plan.json", PLAN);
        let run = bench.run("rig --truth truth.json --plan plan.json --out-dir out");
        assert_eq!(run.exit_code, 1, "{truth}: {run:?}");
        assert!(run.stderr.contains(part), "{truth}: {}", run.stderr);
        assert!(!bench.path("out").exists());
    }
    let bench = Bench::new();
    assert_eq!(bench.run("rig --seed 1").exit_code, 2);
    bench.write("drive.csv", "u_V\n0\n1\n0\n");
    let run = bench.run("rig --drive drive.csv --out-dir out");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("--sample-rate HZ"), "{}", run.stderr);
}
