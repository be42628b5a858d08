//! `article` writes a page, figures, tables and all numbers, and a rehearsal says that it is one.

use crate::bench::Bench;

#[test]
fn a_rehearsal_writes_everything_and_says_that_it_is_one() {
    let bench = Bench::new();
    let run = bench.run("article --out-dir out --quick --seed 3 --json");
    // On a busy machine it may take long enough for a line of progress.
    assert!(run.stderr.lines().all(|line| line.starts_with("progress: ")), "{run:?}");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let printed: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(printed["plan"]["quick"], true);
    assert_eq!(printed["plan"]["seed"], 3);
    let claims = printed["claims"].as_array().unwrap();
    assert!(claims.iter().all(|c| ["holds", "partly", "fails"].contains(&c["verdict"].as_str().unwrap())));
    for file in printed["files"].as_array().unwrap() {
        assert!(bench.path(file.as_str().unwrap()).is_file(), "{file}");
    }
    let read = |name: &str| std::fs::read_to_string(bench.path(name)).unwrap();
    let page = read("out/index.html");
    for part in ["A rehearsal", "simulated bench", "Figure 6.", "Figure 11.", "Table 3.", "contradict"] {
        assert!(page.contains(part), "{part}");
    }
    let all: serde_json::Value = serde_json::from_str(&read("out/article.json")).unwrap();
    assert_eq!(all["claims"], printed["claims"]);
    assert_eq!(all["models"]["curves"].as_array().unwrap().len(), 4);
    // Frequency by model, and a header.
    let table = read("out/tables/table_3_models.csv");
    assert_eq!(table.lines().count(), 1 + 4 * 8, "{table}");
    assert!(table.lines().all(|line| line.split(',').count() >= 8), "{table}");
    let figures = std::fs::read_dir(bench.path("out/figures")).unwrap().count();
    assert_eq!(figures, 9);
}

#[test]
fn a_folder_that_cannot_be_made_is_named_before_any_work_is_done() {
    let bench = Bench::new();
    let run = bench.run("article --out-dir model.json/out");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("cannot write the reproduction to model.json/out"), "{}", run.stderr);
}
