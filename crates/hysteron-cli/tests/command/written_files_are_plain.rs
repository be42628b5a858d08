//! CSV that any command writes is plain: pandas, numpy, Excel and MATLAB read it without options.

use crate::bench::{Bench, good_record};

/// One line of names, then numbers in every cell, as many a line as names; no comments, no quotes.
fn is_plain(text: &str) {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    for name in &names {
        let is_word = name.chars().all(|c| c.is_ascii_alphanumeric() || "_%/^.-".contains(c));
        assert!(is_word && name.starts_with(|c: char| c.is_ascii_alphabetic()), "{name}");
    }
    let mut rows = 0;
    for line in lines {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!(cells.len() == names.len() && cells.iter().all(|x| x.is_finite()), "{line}");
        rows += 1;
    }
    assert!(rows > 1);
}

#[test]
fn every_csv_file_is_plain() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let reference: String =
        (0..200).map(|k| format!("{},{}\n", f64::from(k) / 100.0, f64::from(k % 50) * 0.1)).collect();
    bench.write("reference.csv", format!("t_s,r_um\n{reference}"));
    for (arguments, file) in [
        ("simulate model.json run.csv -o simulated.csv", "simulated.csv"),
        ("validate model.json run.csv -o scored.csv", "scored.csv"),
        ("prepare run.csv --rate 50Hz -o prepared.csv", "prepared.csv"),
        ("invert model.json reference.csv --range 0:100 -o drive.csv", "drive.csv"),
        ("excite sine --frequency 1 --high 10 --sample-rate 100 -o excited.csv", "excited.csv"),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.exit_code, 0, "{arguments}: {run:?}");
        is_plain(&std::fs::read_to_string(bench.path(file)).unwrap());
    }
}
