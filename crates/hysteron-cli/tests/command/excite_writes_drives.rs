//! `excite` writes records ready for a DAQ, inside the limits asked for, and refuses what an amplifier cannot
//! play.

use crate::bench::Bench;

const COMMON: &str = "--sample-rate 1000 --low -5 --high 10 -o drive.csv --json";

#[test]
fn every_waveform_is_written_within_its_range_and_read_back() {
    for wave in [
        "sine --frequency 2",
        "triangle --frequency 2 --periods 1.5",
        "sines --tone 3:1 --tone 7:0.5:90 --duration 1",
        "nested-loops --frequency 5 --amplitudes 1,0.5 --periods-each 1",
        "reversal-curves --curves 3 --ramp 0.1",
        "staircase --steps 3 --hold 0.1 --transition 0.02",
        "raster --line-rate 10 --lines 4",
        "decaying --frequency 10 --cycles 5",
        "sweep --from 1 --to 100 --duration 1 --law linear",
        "multisine --from 2 --to 40 --period 0.5 --periods 2 --lines odd-with-detection",
        "random --to 50 --duration 1 --seed 3",
    ] {
        let bench = Bench::new();
        let run = bench.run(&format!("excite {wave} {COMMON}"));
        assert_eq!(run.exit_code, 0, "{wave}: {}", run.stderr);
        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        let text = std::fs::read_to_string(bench.path("drive.csv")).unwrap();
        assert!(text.starts_with("t_s,u_V\n"), "{wave}");
        let u: Vec<f64> =
            text.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
        assert_eq!(json["samples"].as_u64(), Some(u.len() as u64), "{wave}");
        assert!(u.iter().all(|u| (-5.0..=10.0).contains(u)), "{wave}");
        let span = u.iter().fold(f64::MIN, |m, u| m.max(*u)) - u.iter().fold(f64::MAX, |m, u| m.min(*u));
        assert!(span > 10.0, "{wave}: {span}");
        assert_eq!(bench.run("simulate model.json drive.csv -o out.csv").exit_code, 0, "{wave}");
    }
}

#[test]
fn detection_lines_are_told_and_random_waves_repeat_by_seed() {
    let bench = Bench::new();
    let command = format!("excite multisine --from 1 --to 40 --period 1 --lines odd-with-detection {COMMON}");
    let json: serde_json::Value = serde_json::from_str(&bench.run(&command).stdout).unwrap();
    let lines = |key: &str| json[key].as_array().unwrap().len();
    // Of the 20 odd multiples of 1 Hz up to 40 Hz one in every four is left out; the 20 even ones are all
    // silent.
    assert_eq!((lines("excited_hz"), lines("odd_detection_hz"), lines("even_detection_hz")), (15, 5, 20));

    let drive = |seed: u32| {
        bench.run(&format!("excite random --to 50 --duration 1 --seed {seed} {COMMON}"));
        std::fs::read(bench.path("drive.csv")).unwrap()
    };
    assert_eq!(drive(1), drive(1));
    assert_ne!(drive(1), drive(2));
}

#[test]
fn what_the_amplifier_cannot_play_is_refused_and_not_written() {
    for (flags, part) in [
        ("--max-slew 10", "the amplifier allows 10 V/s"),
        ("--amplifier-high 8", "8 V"),
        ("--amplifier-low 0", "0 V"),
        ("--max-current 1e-3 --capacitance 1e-5", "0.001 A"),
    ] {
        let bench = Bench::new();
        let run = bench.run(&format!("excite sine --frequency 10 {COMMON} {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{flags}: {run:?}");
        assert!(run.stderr.contains("the amplifier cannot play the waveform"), "{flags}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{flags}: {}", run.stderr);
        assert_eq!(bench.files(), ["model.json"]);
    }
}

#[test]
fn impossible_waveforms_name_the_number_and_flags_their_form() {
    let bench = Bench::new();
    let run =
        bench.run("excite sweep --from 1 --to 900 --duration 1 --sample-rate 1000 --high 10 -o drive.csv");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("900") && run.stderr.contains("end_hz"), "{}", run.stderr);
    let run = bench.run("excite sine --frequency 1 --sample-rate 1000 --low 5 --high 5 -o drive.csv");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("high_v"), "{}", run.stderr);
    let run = bench.run("excite sines --tone 3 --duration 1 --sample-rate 1000 --high 5 -o drive.csv");
    assert_eq!(run.exit_code, 2);
    assert!(run.stderr.contains("expected HZ:AMPLITUDE or HZ:AMPLITUDE:DEGREES"), "{}", run.stderr);
    let run = bench.run("excite sine --frequency 1 --sample-rate 1000 --high 5 --max-current 1 -o drive.csv");
    assert_eq!(run.exit_code, 2, "{run:?}");
    assert_eq!(bench.files(), ["model.json"]);
}
