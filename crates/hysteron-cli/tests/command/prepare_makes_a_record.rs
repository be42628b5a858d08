//! `prepare` makes one record of parts of records, which every other command reads; a part is taken inline by
//! those that read records.

use crate::bench::{Bench, good_record};

/// A record of three segments: 1 s at 100 Hz, 0.1 s at 1 kHz, and 1 s at 100 Hz behind a pause of 5 s. The
/// output is 0.3 µm/V and a drift of 2 µm/s.
fn segments() -> String {
    let mut text = "t_s,drive_V,y_um,segment\n".to_owned();
    let parts = [(0.0, 100, 0.01), (1.0, 100, 0.001), (6.1, 100, 0.01)];
    for (segment, (start, samples, period)) in parts.into_iter().enumerate() {
        for k in 0..samples {
            let t = start + f64::from(k) * period;
            let u = 5.0 - 5.0 * (std::f64::consts::TAU * t).cos();
            text += &format!("{t},{u},{},{segment}\n", 0.3 * u + 2.0 * t);
        }
    }
    text
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    bench.write("segments.csv", segments());
    bench
}

/// Header and rows of a file written.
fn table(bench: &Bench, name: &str) -> (String, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(bench.path(name)).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_owned();
    (header, lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect())
}

#[test]
fn every_step_is_done_in_the_stated_order_and_told() {
    let bench = bench();
    let run = bench.run(
        "prepare segments.csv -o out.csv --rename drive=u --where segment=0..2 --from 200ms --scale \
         y=1000nm/um --detrend y --remove-mean u --rate 50Hz --json",
    );
    assert_eq!(run.exit_code, 0, "{run:?}");
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["records"][0]["record"], "segments.csv");
    assert_eq!(
        (&json["records"][0]["file_samples"], &json["records"][0]["samples"]),
        (&300.into(), &280.into())
    );
    let steps: Vec<&str> =
        json["steps"].as_array().unwrap().iter().map(|step| step["step"].as_str().unwrap()).collect();
    assert_eq!(steps, ["scaled", "mean-removed", "detrended", "resampled"]);
    assert_eq!((&json["steps"][3]["gaps"], &json["gaps"][0]["to_s"]), (&1.into(), &6.1.into()));
    assert_eq!((&json["sample_rate_hz"], &json["start_s"]), (&50.0.into(), &0.2.into()));
    let (header, rows) = table(&bench, "out.csv");
    assert_eq!(header, "t_s,u_V,y_nm,segment,valid");
    assert_eq!(json["samples"], rows.len());
    // 1.099 s to 6.1 s is the gap.
    for row in &rows {
        assert_eq!(row[4] == 0.0, row[0] > 1.0991 && row[0] < 6.0999, "{row:?}");
        assert!([0.0, 1.0, 2.0].contains(&row[3]), "a label is held: {row:?}");
    }
    assert_eq!(json["masked_samples"], rows.iter().filter(|row| row[4] == 0.0).count());
    let run = bench.run("validate model.json out.csv --from 6.5");
    assert_eq!(run.exit_code, 0, "{run:?}");
}

#[test]
fn a_segment_is_uniform_and_its_parts_join_to_it() {
    let bench = bench();
    for command in [
        "prepare segments.csv --where segment=1 -o middle.csv",
        "prepare middle.csv --to 1.0495 -o first.csv",
        "prepare middle.csv --from 1.0495 -o second.npz",
        "prepare first.csv second.npz -o again.csv",
        "prepare run.csv --turns 1:3 -o turns.csv",
    ] {
        let run = bench.run(command);
        assert_eq!((run.exit_code, run.stdout.as_str()), (0, ""), "{command}: {run:?}");
        assert!(run.stderr.contains("wrote "), "{command}: {}", run.stderr);
    }
    let read = |name: &str| std::fs::read_to_string(bench.path(name)).unwrap();
    assert_eq!(read("again.csv"), read("middle.csv"));
    let run = bench.run("inspect middle.csv --json");
    assert!(run.stdout.contains("\"sample_rate_hz\":1000.0"), "{}", run.stdout);
    // From the first maximum of the triangle, at 0.5 s, to the second.
    let (_, rows) = table(&bench, "turns.csv");
    assert_eq!((rows[0][0], rows.last().unwrap()[0], rows.len()), (0.5, 1.5, 101));
}

#[test]
fn a_part_is_taken_inline() {
    let bench = bench();
    bench.write(
        "words.csv",
        good_record().replace('\n', ",run\n").replacen(",run", ",mode", 1) + "2,9,9,off\n2.5,9,9,off\n",
    );
    let json = |command: &str| -> serde_json::Value {
        let run = bench.run(command);
        assert_eq!(run.exit_code, 0, "{command}: {run:?}");
        serde_json::from_str(&run.stdout).unwrap()
    };
    let inspected = json("inspect run.csv --from 0.5s --to 1.5 --json");
    assert_eq!(inspected["records"][0]["samples"], 101);
    assert_eq!(json("inspect words.csv --where mode=run --json")["records"][0]["samples"], 200);
    assert_eq!(json("validate model.json run.csv --from 1 --json")["records"][0]["samples"], 100);
    let run = bench.run("simulate model.json segments.csv --where segment=1 -o out.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert_eq!(table(&bench, "out.csv").1.len(), 100);
    let run = bench.run(
        "identify run.csv --from 1 --dynamics none --degree 1 --generations 2 --least-fit -1e9 -o new.json \
                         --json",
    );
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stdout.contains("\"samples\":100"), "{}", run.stdout);
    let run = bench.run("compare run.csv --from 1.99 --candidates none");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("keeps 1 of 200 samples"), "{}", run.stderr);
}

/// Flags of `prepare run.csv -o out.csv`, and what the refusal must contain.
const REFUSED: &[(&str, &[&str])] = &[
    ("--from 30", &["keeps 0 of 200 samples", "time from 0 to 1.99 s", "try: another --from, --to"]),
    ("--from 1 --to 0.5", &["keeps 0 of 200 samples"]),
    ("--where speed=2", &["no column `speed`", "`t_s`, `u_V`, `y_um`", "try: --where"]),
    ("--where u=500..600", &["keeps 0 of 200 samples", "`u_V` from 0 to 100"]),
    ("--where u=ramp", &["keeps 0 of 200 samples", "in `u_V`"]),
    ("--turns 2:9", &["`u` turns 3 times", "turning point 9"]),
    ("--rename z=u", &["no column `z`", "try: --rename OLD=NEW"]),
    ("--rename y=y_V", &["`y_um` is in µm", "`y_V`"]),
    ("--rename y=u_V", &["`u_V`"]),
    ("--scale z=2um/V", &["no channel `z`", "try: --scale COL=FACTOR"]),
    ("--detrend z", &["no channel `z`", "try: --detrend"]),
    ("--drop z", &["no column `z`", "try: --drop COL"]),
    ("--rate 0.1", &["resampling to this rate needs at least 2"]),
    ("--rate 1e12", &["below 2^29 samples"]),
];

#[test]
fn what_cannot_be_done_is_refused_with_what_there_is_and_writes_nothing() {
    let bench = bench();
    let before = bench.files();
    for (flags, parts) in REFUSED {
        let run = bench.run(&format!("prepare run.csv -o out.csv {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{flags}: {run:?}");
        for part in *parts {
            assert!(run.stderr.contains(part), "{flags}: `{part}` in {}", run.stderr);
        }
    }
    for flags in
        ["--from soon", "--rate 0", "--where u", "--turns 3:1", "--rename u", "--scale y=2", "--input u"]
    {
        assert_eq!(bench.run(&format!("prepare run.csv -o out.csv {flags}")).exit_code, 2, "{flags}");
    }
    assert_eq!(bench.files(), before);
}

/// Content of `bad.csv`, flags, and what the refusal must contain.
const BAD: &[(&str, &str, &[&str])] = &[
    (
        "t_s,u_V,y_um\n0,1,2\n1,NaN,3\n2,3,4\n",
        "",
        &["line 3, column 2 (`u_V`)", "`NaN` is not a finite number"],
    ),
    ("t_s,u_V,y_um\n0,1,2\n1,,3\n2,3,4\n", "--to 1", &["line 3, column 2 (`u_V`)"]),
    ("t_s,u_V,note\n0,1,a\n1,2,b\n", "", &["found `a`, expected a number", "--drop COL"]),
    ("t_s,u_V\n5,1\n5,2\n5,3\n", "", &["all 3 time stamps are 5 s"]),
    ("t_s,u_V\n0,1\n1,2\n2,3\n2,3\n", "--from 2", &["all 2 time stamps are 2 s"]),
    ("u_V\n1\n2\n", "--from 1", &["a cut by time needs time stamps", "try: --sample-rate HZ"]),
    ("u_V\n1\n2\n", "--rate 10", &["resampling needs time stamps", "try: --sample-rate HZ"]),
    ("u_V\n1\n2\n", "--detrend u", &["a trend per second needs time stamps"]),
];

#[test]
fn unusable_records_are_refused_with_the_place() {
    for (content, flags, parts) in BAD {
        let bench = Bench::new();
        bench.write("bad.csv", content);
        let run = bench.run(&format!("prepare bad.csv -o out.csv {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{content:?}: {run:?}");
        for part in *parts {
            assert!(run.stderr.contains(part), "{content:?} {flags}: `{part}` in {}", run.stderr);
        }
        assert!(!bench.path("out.csv").exists());
    }
    // The missing number is cut away.
    let bench = Bench::new();
    bench.write("bad.csv", BAD[0].0);
    assert_eq!(bench.run("prepare bad.csv -o out.csv --from 2 --to 3 --where u=3").exit_code, 1);
    bench.write("bad.csv", "t_s,u_V\n0,1\n1,NaN\n2,3\n3,4\n");
    let run = bench.run("prepare bad.csv -o out.csv --from 2");
    assert_eq!((run.exit_code, table(&bench, "out.csv").1.len()), (0, 2), "{run:?}");
}

#[test]
fn records_are_joined_in_order_or_refused_by_name() {
    let bench = bench();
    bench.write("later.csv", "y_um,t_s,u_V\n1,5,2\n3,5.01,4\n");
    bench.write("millimetres.csv", "t_s,u_V,y_mm\n5,1,2\n6,2,3\n");
    bench.write("short.csv", "t_s,u_V\n5,1\n6,2\n");
    let run = bench.run("prepare run.csv later.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stderr.contains("joined 2 records") && run.stderr.contains("1 gap"), "{}", run.stderr);
    let (header, rows) = table(&bench, "out.csv");
    assert_eq!(
        (header.as_str(), rows.len(), rows[201].as_slice()),
        ("t_s,u_V,y_um", 202, &[5.01, 4.0, 3.0][..])
    );
    for (records, parts) in [
        ("later.csv run.csv", ["`run.csv` begins at 0 s", "`later.csv` ends at 5.01 s"]),
        (
            "run.csv millimetres.csv",
            ["`run.csv` and `millimetres.csv` cannot be joined", "in µm in the one and in mm"],
        ),
        ("run.csv short.csv", ["`short.csv` has no column `y` (µm)", "`run.csv`"]),
    ] {
        let run = bench.run(&format!("prepare {records} -o new.csv"));
        assert_eq!(run.exit_code, 1, "{records}: {run:?}");
        assert!(parts.iter().all(|part| run.stderr.contains(part)), "{records}: {}", run.stderr);
    }
}

#[test]
fn stamps_that_are_not_uniform_are_answered_with_the_command_that_resamples() {
    let bench = bench();
    let run = bench.run("frequency-response segments.csv --input drive --output y");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("hysteron prepare RECORD --rate HZ -o OUT.csv"), "{}", run.stderr);
    let run = bench.run("inspect segments.csv --input drive");
    assert!(run.stdout.contains("hysteron prepare RECORD --rate HZ -o OUT.csv"), "{}", run.stdout);
}
