//! The correlation of the estimates in the file.

use super::*;

#[test]
fn a_covariance_comes_back_from_the_file() {
    let file = read(&complete().to_json().unwrap()).unwrap();
    let (names, covariance) = file.covariance().unwrap();
    assert_eq!(
        names,
        ["alpha", "denominator[0].coefficient", "denominator[2].coefficient", "denominator[2].order"]
    );
    // By hand: rows of the root times each other.
    for ((i, j), expected) in
        [((0, 0), 1e-6), ((1, 1), 1.09e8), ((1, 2), 1.7), ((3, 0), 1e-9), ((2, 3), -9e-11)]
    {
        assert!((covariance[(i, j)] / expected - 1.0).abs() < 1e-12, "{i} {j}: {}", covariance[(i, j)]);
    }
    assert!(
        (file.number("denominator[0].coefficient").unwrap().std_error.unwrap() - 1.09e8f64.sqrt()).abs()
            < 1e-8
    );
    assert_eq!(file.number("linear").unwrap().std_error, None);
    // A row of the matrix on one line.
    let text = file.to_json().unwrap();
    assert!(text.lines().any(|line| line.trim_start().starts_with("[1.0,")), "{text}");
}

#[test]
fn a_covariance_leaves_out_what_is_not_known() {
    let mut file = ModelFile::from_model(&article(), SignalUnits::default());
    let names = ["alpha", "n", "no such number", "delay"].map(String::from);
    let diagonal = nalgebra::DVector::from_column_slice(&[4.0, 0.0, 1.0, f64::NAN]);
    file.set_covariance(&names, &DMatrix::from_diagonal(&diagonal));
    assert_eq!(file.correlation.as_ref().unwrap().names, ["alpha"]);
    assert_eq!(file.number("alpha").unwrap().std_error, Some(2.0));
    assert!(file.check().is_ok());
}

#[test]
fn a_covariance_that_rounding_spoiled_is_written_and_read() {
    // Three indistinguishable parameters: the lowest eigenvalue of the correlation is about -1e-7, not 0.
    let off = 1.0 - 1e-7;
    let spoiled = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 1.0, 1.0, 1.0, off, 1.0, off, 1.0]);
    assert!(spoiled.clone().symmetric_eigenvalues().min() < -1e-8);
    let mut file = ModelFile::from_model(&article(), SignalUnits::default());
    file.set_covariance(&["alpha", "delay", "linear"].map(String::from), &spoiled);
    let read = read(&file.to_json().unwrap()).unwrap();
    let (_, covariance) = read.covariance().unwrap();
    let moved = (covariance - spoiled).abs().max();
    assert!(moved < 1e-6, "{moved}");
}

#[test]
fn a_correlation_that_is_none_is_refused() {
    use serde_json::json;
    let names = |list: &[&str]| Some(json!(list));
    for (pointer, value, expected) in [
        ("/correlation/names", names(&["alpha", "alpha", "delay", "beta"]), "`alpha` is named twice"),
        (
            "/correlation/names",
            names(&["alpha", "denominator[9].order", "delay", "beta"]),
            "has no number `den",
        ),
        ("/correlation/names", names(&["alpha", "beta", "delay", "gamma"]), "`beta` has no standard error"),
        (
            "/correlation/names",
            names(&["alpha", "denominator[2].order"]),
            "expected 2 rows of 2 coefficients, found 4",
        ),
        ("/correlation/names", names(&[]), "expected 1 to 200 names, found 0"),
        ("/correlation/names", names(&["alpha"; 201]), "more than 200 entries"),
        ("/correlation/matrix/1", Some(json!(vec![0.0; 5])), "expected 4 rows of 4 coefficients, found 5"),
        ("/correlation/matrix/1/1", Some(json!(0.9)), "matrix[1][1]: expected 1, found 0.9"),
        (
            "/correlation/matrix/3/0",
            Some(json!(1.5)),
            "matrix[3][0]: expected a number from -1 to 1, found 1.5",
        ),
        ("/correlation/matrix/3/0", Some(json!(0.1)), "not symmetric: matrix[3][0] is 0.1"),
        ("/correlation/matrix/3/0", Some(json!(null)), "correlation.matrix[3][0]: invalid type: null"),
        ("/correlation/matrix", None, "missing field `matrix`"),
        (
            "/correlation/matrix",
            // Two that go together, and a third with one of them and against the other.
            Some(json!([
                [1.0, 1.0, 0.9, 0.0],
                [1.0, 1.0, -0.9, 0.0],
                [0.9, -0.9, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0]
            ])),
            "negative eigenvalue",
        ),
    ] {
        let message = refused(pointer, value);
        assert!(message.contains(expected), "{pointer}: {message}");
    }
}
