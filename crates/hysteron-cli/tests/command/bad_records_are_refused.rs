//! A record that cannot be used is refused with exit code 1, the file, the place and what to do; nothing is
//! printed on standard output and no file is written.

use crate::bench::{Bench, good_record};

/// Content of `run.csv`, flags, and what the message must contain.
const CASES: &[(&str, &str, &[&str])] = &[
    ("", "", &["`run.csv` is empty", "expected a header line such as `t_s,u_V,y_um`"]),
    ("# nothing but a comment\n\n", "", &["`run.csv` holds no data, only comments"]),
    ("t_s,u_V,y_um\n", "", &["has a header (line 1) but no samples"]),
    ("t_s,u_V,y_um\n0,1,2\n", "", &["one sample only (line 2)"]),
    ("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n0.2,3", "", &["line 4", "cut off after 2 of 3 fields"]),
    ("t_s,u_V,y_um\n0,1,2\n0.1,2\n0.2,3,4\n", "", &["line 3", "2 fields where the header (line 1) has 3"]),
    (
        "t_s,u_V,y_um\n0,1,2\n0.1,NaN,3\n0.2,3,4\n",
        "",
        &["line 3, column 2 (`u_V`)", "`NaN` is not a finite number"],
    ),
    (
        "t_s,u_V,y_um\n0,1,2\n0.1,2,-inf\n0.2,3,4\n",
        "",
        &["line 3, column 3 (`y_um`)", "`-inf` is not a finite number"],
    ),
    (
        "t_s,u_V,y_um\n0,1,2\n0.1,2,1e999\n0.2,3,4\n",
        "",
        &["line 3, column 3 (`y_um`)", "not a finite number"],
    ),
    (
        "t_s,u_V,y_um\n0,1,2\n0.1,high,3\n0.2,3,4\n",
        "",
        &["line 3, column 2 (`u_V`)", "found `high`, expected a number"],
    ),
    ("t_s,u_V,y_um\n0,1,2\n0.1,,3\n0.2,3,4\n", "", &["line 3, column 2 (`u_V`)", "empty, expected a number"]),
    ("t_s,u_V,y_um\n0,0,1,0,2,0\n0,1,2,0,3,0\n", "", &["decimal commas", "semicolons or tabs"]),
    ("t_s;u_V;y_um\n0;1,5;2\n0,1;2.5;3\n", "", &["line 3", "`2.5` mixes with the decimal comma"]),
    (
        "0,1,2\n0.1,2,3\n0.2,3,4\n",
        "",
        &["found 3 number(s) where the column names should be", "add a header line"],
    ),
    ("t_s,u_V,y_ms\n0,1,2\n0.1,2,3\n0.2,3,4\n", "", &["is in ms, which cannot be the unit of the output"]),
    ("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n0.05,3,4\n", "", &["line 4", "time runs backwards"]),
    ("t_s,u_V,y_um\n0,1,2\n0,2,3\n0,3,4\n", "", &["all 3 time stamps are 0 s"]),
    ("t_s,u_V\n0,1\n0.1,2\n0.2,3\n", "", &["only one channel besides time", "`u` (V)"]),
    ("t_s,u1_V,u2_V,y_um\n0,1,2,3\n0.1,2,3,4\n", "", &["`u1` (V), `u2` (V)", "--input u1_V"]),
    (
        "t_s,u_V,y_um\n0,1,2\n0.1,2,3\n",
        "--output z",
        &["no column `z` to be the output", "try: --output COL", "y_um"],
    ),
    ("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n0.2,3,4\n", "--sample-rate 50", &["50 Hz", "10 Hz"]),
    ("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n0.2,3,4\n", "--max-bytes 20", &["larger than 20 bytes", "line"]),
    (
        "t_s,u_V,y_um,valid\n0,1,2,1\n0.1,2,3,2\n",
        "",
        &["column 4 (`valid`)", "found `2`, expected 0 (do not score) or 1"],
    ),
    ("f_Hz,magnitude,phase_deg\n1,2,3\n2,3,4\n", "", &["frequency response"]),
];

#[test]
fn every_command_refuses_unusable_records_with_the_place_and_the_remedy() {
    for (content, flags, parts) in CASES {
        let bench = Bench::new();
        bench.write("run.csv", content);
        for command in [
            "validate model.json run.csv --json",
            "inspect run.csv --json",
            "identify run.csv -o new.json --json",
        ] {
            let run = bench.run(&format!("{command} {flags}"));
            assert_eq!(run.exit_code, 1, "{command} {content:?}: {run:?}");
            assert_eq!(run.stdout, "", "{command} {content:?}");
            assert!(
                run.stderr.starts_with("error: cannot read the record run.csv\nbecause: "),
                "{}",
                run.stderr
            );
            for part in *parts {
                assert!(
                    run.stderr.contains(part),
                    "{command} {content:?}: {part:?} is not in {}",
                    run.stderr
                );
            }
        }
        assert_eq!(bench.files(), ["model.json", "run.csv"]);
    }
}

/// Under a unit that is not the model's nothing is run: kilograms are no micrometres, inches neither.
#[test]
fn units_that_are_not_converted_are_not_taken_for_the_models() {
    for (column, unit) in [("y_kg", "kg"), ("y_in", "in"), ("y_mils", "mils"), ("y [furlong]", "furlong")] {
        let bench = Bench::new();
        bench.write("run.csv", good_record().replace("y_um", column));
        let run = bench.run("validate model.json run.csv");
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{column}: {run:?}");
        for part in [
            format!("the model's output is in µm, the record's in {unit}: expected nm, µm, mm or m"),
            format!("--scale y=2.5um/{unit}"),
        ] {
            assert!(run.stderr.contains(&part), "{column}: {part} in {}", run.stderr);
        }
        // With what it means, it is run.
        let run = bench.run(&format!("validate model.json run.csv --scale y=1um/{unit}"));
        assert_eq!(run.exit_code, 0, "{column}: {run:?}");
    }
    for (columns, note) in [("u_kg,y_um", "expected V, mV or kV"), ("u_inch,y_um", "expected V, mV or kV")] {
        let bench = Bench::new();
        bench.write("run.csv", good_record().replace("u_V,y_um", columns));
        let run = bench.run("simulate model.json run.csv -o out.csv");
        assert!(run.exit_code == 1 && run.stderr.contains(note), "{columns}: {run:?}");
    }
    for columns in ["u_command,y_filtered", "u_in,y_out", "u_V,y_micron", "u_V,y_microns"] {
        let bench = Bench::new();
        bench.write("run.csv", good_record().replace("u_V,y_um", columns));
        let run = bench.run("validate model.json run.csv --json");
        assert_eq!(run.exit_code, 0, "{columns}: {run:?}");
        assert_eq!(run.stderr.contains("no unit"), !columns.starts_with("u_V"), "{columns}: {}", run.stderr);
    }
}

#[test]
fn a_failed_simulation_writes_nothing_and_keeps_what_was_there() {
    let bench = Bench::new();
    bench.write("drive.csv", "t_s,u_V\n0,1\n0.1,abc\n");
    bench.write("out.csv", "precious");
    let run = bench.run("simulate model.json drive.csv -o out.csv");
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""));
    assert!(run.stderr.contains("line 3, column 2 (`u_V`): found `abc`"), "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(bench.path("out.csv")).unwrap(), "precious");
    assert_eq!(bench.files(), ["drive.csv", "model.json", "out.csv"]);

    bench.write("drive.csv", good_record());
    let run = bench.run("simulate model.json drive.csv -o no/such/folder/out.csv");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("cannot write the simulation to no/such/folder/out.csv"), "{}", run.stderr);
    assert_eq!(bench.files(), ["drive.csv", "model.json", "out.csv"]);
}

#[test]
fn missing_files_folders_and_binary_files_are_named() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("folder")).unwrap();
    bench.write(
        "noise.csv",
        (0..4000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect::<Vec<u8>>(),
    );
    for (file, part) in
        [("gone.csv", "cannot open `gone.csv`"), ("folder", "directory"), ("noise.csv", "noise.csv")]
    {
        let run = bench.run(&format!("validate model.json {file}"));
        assert_eq!(run.exit_code, 1, "{file}: {run:?}");
        assert!(run.stderr.contains(part), "{}", run.stderr);
    }
}

#[test]
fn records_in_which_nothing_moves_are_not_scored() {
    let rows = |row: fn(usize) -> (f64, f64)| -> String {
        let line = |k: usize| format!("{},{},{}\n", k as f64 / 100.0, row(k).0, row(k).1);
        "t_s,u_V,y_um\n".to_owned() + &(0..100).map(line).collect::<String>()
    };
    for (content, part) in [
        (
            "t_s,u_V,y_um\n0,1,2\n0.1,2,3\n".to_owned(),
            "only 2 of its 2 samples can be scored; need at least 3",
        ),
        (rows(|k| (k as f64, 5.0)), "the output `y` is constant (5): no motion to compare with"),
        (rows(|k| (5.0, k as f64)), "the input `u` is constant (5): the model has nothing to follow"),
        (rows(|_| (5.0, 5.0)), "is constant (5)"),
    ] {
        let bench = Bench::new();
        bench.write("run.csv", content);
        for flags in ["", "--fixed-offset", "--rest-voltage 0"] {
            let run = bench.run(&format!("validate model.json run.csv --json {flags}"));
            assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{part}: {run:?}");
            assert!(run.stderr.contains("error: cannot score run.csv\nbecause: "), "{}", run.stderr);
            assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
        }
        assert_eq!(bench.run("inspect run.csv").exit_code, 0);
    }
}

#[test]
fn a_step_from_rest_is_scored_by_a_model_with_dynamics() {
    let mut model = crate::bench::static_model();
    let term = |coefficient, order| hysteron_model::dynamics::Term { coefficient, order };
    model.dynamics = hysteron_model::dynamics::Dynamics::Integer(
        hysteron_model::dynamics::TransferFunction::new(
            vec![term(1.0, 0.0)],
            vec![term(1.0, 0.0), term(0.05, 1.0)],
        )
        .unwrap(),
    );
    let bench = Bench::new();
    bench.write_model("lag.json", &model, hysteron_model::model_file::SignalUnits::default());
    let line = |k: usize| {
        let t = k as f64 / 100.0;
        format!("{t},5,{}\n", 1.2 * (1.0 - (-t / 0.05).exp()))
    };
    bench.write("run.csv", "t_s,u_V,y_um\n".to_owned() + &(0..100).map(line).collect::<String>());
    let run = bench.run("validate lag.json run.csv --rest-voltage 0");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let run = bench.run("validate lag.json run.csv --rest-voltage 5");
    assert_eq!(run.exit_code, 1, "{run:?}");
}

#[test]
fn seconds_cannot_be_skipped_beyond_the_record_or_without_time() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let run = bench.run("validate model.json run.csv --skip 10");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("only 0 of 200 samples are left to score"), "{}", run.stderr);
    bench.write("run.csv", "u_V,y_um\n0,1\n1,2\n2,3\n");
    let run = bench.run("validate model.json run.csv --skip 0.1");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("neither a time column nor a sample rate"), "{}", run.stderr);
}

#[test]
fn records_that_hold_nothing_to_identify_are_refused_and_leave_no_model() {
    let constant_input: String = (0..200).map(|k| format!("{},5,{}\n", k as f64 / 100.0, k % 7)).collect();
    let constant_output: String = (0..200).map(|k| format!("{},{},5\n", k as f64 / 100.0, k % 7)).collect();
    for (rows, part) in [
        (constant_input.as_str(), "the input is constant (5)"),
        (constant_output.as_str(), "the output is constant (5)"),
        ("0,1,2\n0.1,2,3\n0.2,3,4\n", "need at least 20 valid samples but found 3"),
    ] {
        let bench = Bench::new();
        bench.write("run.csv", format!("t_s,u_V,y_um\n{rows}"));
        let run = bench.run("identify run.csv -o new.json --report new.html --json");
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{part}: {run:?}");
        assert!(
            run.stderr.contains("error: no model was identified") && run.stderr.contains(part),
            "{}",
            run.stderr
        );
        assert_eq!(bench.files(), ["model.json", "run.csv"]);
    }
}
