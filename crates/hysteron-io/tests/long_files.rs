//! Long files, read in blocks of lines: the numbers and the messages are those of reading line by line.
#![allow(clippy::unwrap_used, clippy::panic)]

use hysteron_io::{FilePart, IoError, Place, ReadOptions, read_record_bytes};

/// Rows of a file of about 4 MiB.
const ROWS: usize = 100_000;

/// A value with as many digits as a double has.
fn value(k: usize) -> f64 {
    (k as f64 * 0.7).sin() * 10f64.powi((k % 40) as i32 - 20)
}

/// The file, row `at` (from 0; it stands in line `at` + 2) replaced.
fn file(at: usize, row: &str) -> String {
    let mut text = String::from("t_s,u_V,y_um\n");
    for k in 0..ROWS {
        if k == at {
            text += row;
        } else {
            text += &format!("{},{},{:e}", k as f64 / 1000.0, value(k), value(k + 1));
        }
        text += "\n";
    }
    text
}

fn read(text: &str) -> Result<(Vec<f64>, Vec<f64>), IoError> {
    let record = read_record_bytes("long.csv", text.as_bytes(), &ReadOptions::default())?;
    let samples = |name: &str| record.channel(name).unwrap().samples.clone();
    Ok((samples("u"), samples("y")))
}

fn cell(line: u64, column: u32, name: &str) -> Place {
    Place { file: "long.csv".into(), part: FilePart::Cell { line, column, name: name.into() } }
}

#[test]
fn every_number_is_the_nearest_double() {
    let plain = file(ROWS, "");
    let (u, y) = read(&plain).unwrap();
    assert_eq!(u, (0..ROWS).map(value).collect::<Vec<_>>());
    assert_eq!(y, (0..ROWS).map(|k| value(k + 1)).collect::<Vec<_>>());
    for other in [plain.replace('\n', "\r\n"), plain.replace(',', ", "), plain.replace('\n', ",\n")] {
        assert_eq!(read(&other).unwrap(), (u.clone(), y.clone()));
    }
    // Decimal commas, which are read line by line.
    let commas = plain.replace(',', ";").replace('.', ",");
    assert_eq!(read(&commas).unwrap(), (u.clone(), y.clone()));
    // No line end after the last line.
    assert_eq!(read(plain.trim_end()).unwrap(), (u, y));
}

#[test]
fn a_line_that_is_not_plain_changes_nothing_but_itself() {
    let at = ROWS / 2;
    for row in ["# a remark, with a delimiter", "", "50,\"1.5\",2"] {
        let (u, y) = read(&file(at, row)).unwrap();
        let kept = if row.starts_with('5') { ROWS } else { ROWS - 1 };
        assert_eq!((u.len(), y.len()), (kept, kept));
        assert_eq!(u.last(), Some(&value(ROWS - 1)));
        assert_eq!(u[at - 1], value(at - 1));
        assert_eq!(y[at], if kept == ROWS { 2.0 } else { value(at + 2) });
    }
}

#[test]
fn an_error_is_named_by_its_line_wherever_it_is() {
    for at in [1, 30_000, 67_891, ROWS - 1] {
        let line = at as u64 + 2;
        let refused = |row: &str| read(&file(at, row)).unwrap_err();
        let time = at as f64 / 1000.0;
        assert!(matches!(refused(&format!("{time},x,1")),
            IoError::NotANumber { place, .. } if place == cell(line, 2, "u_V")));
        assert!(matches!(refused(&format!("{time},1,inf")),
            IoError::NotFinite { place, .. } if place == cell(line, 3, "y_um")));
        assert!(matches!(refused(&format!("{time},1")),
            IoError::Ragged { place, found: 2, .. } if place.part == FilePart::Line(line)));
        assert!(matches!(refused("-1,1,1"),
            IoError::TimeDecreases { place, after: -1.0, .. } if place == cell(line, 1, "t_s")));
    }
}

#[test]
fn limits_hold_within_a_block() {
    let text = file(ROWS, "");
    let with = |options: ReadOptions| read_record_bytes("long.csv", text.as_bytes(), &options).unwrap_err();
    let few = with(ReadOptions { max_values: 3 * 40_000 + 1, ..ReadOptions::default() });
    assert!(
        matches!(&few, IoError::TooManyValues { place, limit: 120_001, .. }
            if place.part == FilePart::Line(40_002)),
        "{few}"
    );
    let short = with(ReadOptions { max_bytes: text.len() as u64 - 1, ..ReadOptions::default() });
    assert!(matches!(short, IoError::TooLarge { .. }), "{short}");
    let masked = text.replace("y_um\n", "valid\n");
    let wrong = read_record_bytes("long.csv", masked.as_bytes(), &ReadOptions::default()).unwrap_err();
    assert!(matches!(&wrong, IoError::BadMask { place, .. } if *place == cell(2, 3, "valid")), "{wrong}");
}
