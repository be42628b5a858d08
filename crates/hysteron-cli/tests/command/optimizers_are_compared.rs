//! `optimizers` compares as a table, as JSON and as a page; the result depends on the seed and not on the
//! threads.

use serde_json::Value;

use crate::bench::Bench;

/// Few short runs on the quick problem.
const SMALL: &str =
    "optimizers --problem static-block --optimizer de-abc --optimizer de --seeds 2 --budget 300";

#[test]
fn json_holds_every_run_whatever_the_number_of_threads() {
    let bench = Bench::new();
    let study = |flags: &str| {
        let run = bench.run(&format!("{SMALL} --json {flags}"));
        assert_eq!(run.exit_code, 0, "{run:?}");
        run.stdout
    };
    let one = study("--threads 1");
    assert_eq!(one, study("--threads 2"));
    assert_ne!(one, study("--seed 77"));
    let json: Value = serde_json::from_str(&one).unwrap();
    let rows = json["problems"][0]["rows"].as_array().unwrap();
    let names: Vec<&Value> = rows.iter().map(|r| &r["competitor"]).collect();
    assert_eq!(names, ["de-abc", "de"]);
    for run in rows.iter().flat_map(|r| r["runs"].as_array().unwrap()) {
        assert!(
            run["evaluations"].as_u64().unwrap() <= 300 && run["best_rmse"].as_f64().unwrap() > 0.0,
            "{run}"
        );
    }
}

#[test]
fn people_get_a_table_and_a_page_with_convergence() {
    let bench = Bench::new();
    let run = bench.run(&format!("{SMALL} --report study.html"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(
        run.stdout.contains("DE-ABC, all dimensions") && run.stdout.contains("DE/rand/1/bin"),
        "{}",
        run.stdout
    );
    let page = std::fs::read_to_string(bench.path("study.html")).unwrap();
    assert!(page.contains("DE-ABC, all dimensions") && page.contains("<svg"));
}

#[test]
fn unknown_names_and_impossible_budgets_are_wrong_usage() {
    let bench = Bench::new();
    for (flags, part) in [
        ("--problem static-block --problem knapsack", "unknown variant `knapsack`"),
        ("--optimizer harmony-search", "unknown variant `harmony-search`"),
        ("--seeds 0", "option seeds of the optimiser study is 0"),
        ("--budget 10", "option budget of the optimiser study is 10"),
        ("--threads 0", "option threads of the optimiser study is 0"),
    ] {
        let run = bench.run(&format!("optimizers {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (2, ""), "{flags}: {run:?}");
        assert!(run.stderr.contains(part), "{flags}: {}", run.stderr);
    }
}
