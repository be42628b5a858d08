//! A model file that cannot be trusted is refused with exit code 1 and the place in the file.

use crate::bench::{Bench, good_record};

#[test]
fn every_way_to_spoil_a_model_file_is_named() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let good = std::fs::read_to_string(bench.path("model.json")).unwrap();
    let cut = &good[..good.len() / 2];
    for (content, part) in [
        (String::new(), "the file is empty"),
        ("t_s,u_V\n0,1\n".into(), "line 1"),
        (cut.into(), "the file ends within"),
        (
            good.replace("hysteron-model", "other-model"),
            r#"format: expected "hysteron-model", found "other-model""#,
        ),
        (good.replace("\"version\": 2", "\"version\": 3"), "this program reads versions 1 and 2, found 3"),
        (good.replace("\"scheme\"", "\"shceme\""), "unknown field `shceme`"),
        (good.replace("\"value\": 0.3,", ""), "hysteresis.parameters.linear: missing field `value`"),
        (good.replace("0.3", "1e999"), "number out of range"),
        (good.replace("0.3", "NaN"), "expected value at line"),
        (good.replace("0.3", "\"0.3\""), "hysteresis.parameters.linear.value: invalid type: string"),
        (
            good.replace("um/V^2", "nm/V^2"),
            "hysteresis.parameters.quadratic.unit: expected the unit \"um/V^2\", found \"nm/V^2\"",
        ),
        ("[".repeat(1_000_000), "line 1"),
        (format!("{{\"format\": {}", "[".repeat(1_000_000)), "recursion limit exceeded"),
    ] {
        bench.write("model.json", &content);
        for command in ["validate model.json run.csv --json", "simulate model.json run.csv -o out.csv"] {
            let run = bench.run(command);
            assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{part}: {run:?}");
            assert!(
                run.stderr.starts_with("error: cannot read the model model.json\nbecause: "),
                "{}",
                run.stderr
            );
            assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
            assert!(run.stderr.contains("\ntry: "), "{}", run.stderr);
        }
        assert_eq!(bench.files(), ["model.json", "run.csv"]);
    }
    assert!(bench.run("validate gone.json run.csv").stderr.contains("cannot read gone.json"));
}

#[test]
fn a_file_far_larger_than_any_model_is_not_read() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let file = std::fs::File::create(bench.path("huge.json")).unwrap();
    file.set_len(1 << 40).unwrap();
    let run = bench.run("validate huge.json run.csv");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("this is not a model file"), "{}", run.stderr);
}
