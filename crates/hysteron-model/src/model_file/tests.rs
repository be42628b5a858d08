mod any_file;
mod covariance;

use nalgebra::DMatrix;
use proptest::prelude::*;
use serde_json::Value;

use super::*;
use crate::dynamics::{Arx, Dynamics, Term, TransferFunction};
use crate::hammerstein::Model;
use crate::hysteresis::{ArticleOperator, Hysteresis, HysteresisForm, examples};
use crate::record::InterSample;

fn term(coefficient: f64, order: f64) -> Term {
    Term { coefficient, order }
}

/// Table 2 and Eq. 13 of the article.
fn article() -> Model {
    Model {
        hysteresis: Hysteresis::from(ArticleOperator {
            polynomial: vec![2.0, 0.0031],
            alpha: -1.2039,
            beta: 0.1111,
            gamma: 0.0024,
            n: 1.0,
        }),
        dynamics: Dynamics::Fractional(TransferFunction {
            numerator: vec![term(5.2589e6, 0.0)],
            denominator: vec![term(5.4955e6, 0.0), term(3081.0, 1.0523), term(1.0, 2.0384)],
        }),
        offset: -0.25,
        delay_s: 0.01,
        scheme: Scheme::GrunwaldLetnikov,
        inter_sample: InterSample::Hold,
        sample_rate_hz: Some(10_000.0),
    }
}

fn complete() -> ModelFile {
    let mut file = ModelFile::from_model(&article(), SignalUnits::default());
    file.name = Some("stage x".into());
    file.hysteresis.parameters.get_mut("alpha").unwrap().std_error = Some(1e-3);
    file.valid_range = Some(ValidRange {
        input: Interval { low: 0.0, high: 100.0, unit: "V".into() },
        frequency: Some(Interval { low: 1.0, high: 100.0, unit: "Hz".into() }),
        rate: Some(Interval { low: 0.0, high: 6e4, unit: "V/s".into() }),
    });
    file.set_start(crate::Start::Rest { voltage_v: 0.0 });
    file.provenance = Some(Provenance {
        program: "hysteron 0.1.0".into(),
        created: Some(timestamp(0)),
        records: vec![RecordEntry {
            path: "loop.csv".into(),
            sha256: Some("ab".repeat(32)),
            samples: 8,
            role: RecordRole::Both,
        }],
        options: [("degree".to_owned(), "auto: 3".to_owned())].into(),
        seed: Some(u64::MAX),
        command: Some("hysteron identify loop.csv".into()),
    });
    file.scores = vec![ScoreEntry {
        record: "loop.csv".into(),
        role: ScoreRole::Training,
        unit: "um".into(),
        samples: 8,
        skipped_samples: 0,
        offset: 0.1,
        rmse: 0.2,
        max_abs_error: 0.3,
        rmse_percent_of_stroke: Some(1.0),
        max_percent_of_stroke: Some(2.0),
        fit_percent: None,
        relative_error: None,
        loop_width_error_percent: None,
    }];
    let names = ["alpha", "denominator[0].coefficient", "denominator[2].coefficient", "denominator[2].order"]
        .map(String::from);
    let root = DMatrix::from_row_slice(
        4,
        4,
        &[1e-3, 0.0, 0.0, 0.0, 3e3, 1e4, 0.0, 0.0, -1e-4, 2e-4, 1e-5, 0.0, 1e-6, 0.0, 1e-6, 1e-6],
    );
    file.set_covariance(&names, &(&root * root.transpose()));
    file
}

fn parsed(bytes: &[u8]) -> Result<ModelFile, ModelFileError> {
    match super::read(bytes)? {
        Document::Hammerstein(file) => Ok(*file),
        other => panic!("a file of the kind {}", other.kind()),
    }
}

fn read(text: &str) -> Result<ModelFile, ModelFileError> {
    parsed(text.as_bytes())
}

/// The complete file with the value at a JSON pointer replaced (or removed), read again.
fn refused(pointer: &str, replacement: Option<Value>) -> String {
    let mut json = serde_json::to_value(complete()).unwrap();
    match replacement {
        Some(value) => *json.pointer_mut(pointer).expect(pointer) = value,
        None => {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            json.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key).expect(pointer);
        }
    }
    read(&json.to_string()).unwrap_err().to_string()
}

#[test]
fn a_model_comes_back_equal_from_its_file_for_every_kind_of_dynamics() {
    let integer = TransferFunction {
        numerator: vec![term(1.0, 0.0)],
        denominator: vec![term(1.0, 0.0), term(0.01, 1.0)],
    };
    for dynamics in [
        Dynamics::None,
        Dynamics::Integer(integer),
        Dynamics::Arx(Arx { a: vec![-1.5, 0.7], b: vec![0.0, 0.1, 0.2] }),
        Dynamics::Arx(Arx { a: vec![], b: vec![1.0] }),
        article().dynamics,
    ] {
        let model = Model { dynamics, ..article() };
        let text = ModelFile::from_model(&model, SignalUnits::default()).to_json().unwrap();
        assert_eq!(read(&text).unwrap().to_model().unwrap(), model);
    }
}

#[test]
fn the_file_has_the_keys_and_units_that_are_promised() {
    let json: Value = serde_json::from_str(&complete().to_json().unwrap()).unwrap();
    let at = |pointer: &str| json.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing")).clone();
    let quantity =
        |value: f64, unit: &str| serde_json::json!({"value": value, "unit": unit, "std_error": null});
    assert_eq!(at("/format"), "hysteron-model");
    assert_eq!(at("/version"), 2);
    assert_eq!(at("/kind"), "hammerstein");
    assert_eq!(at("/hysteresis/kind"), HysteresisForm::default().name());
    assert_eq!(at("/hysteresis/parameters/linear"), quantity(2.0, "um/V"));
    assert_eq!(at("/hysteresis/parameters/quadratic"), quantity(0.0031, "um/V^2"));
    assert_eq!(
        at("/hysteresis/parameters/alpha"),
        serde_json::json!({"value": -1.2039, "unit": "um/V", "std_error": 1e-3})
    );
    assert_eq!(at("/hysteresis/parameters/beta"), quantity(0.1111, "1/V"));
    assert_eq!(at("/hysteresis/parameters/gamma"), quantity(0.0024, "1/V"));
    assert_eq!(at("/hysteresis/parameters/n"), quantity(1.0, "1"));
    assert_eq!(at("/dynamics/kind"), "fractional");
    assert_eq!(at("/dynamics/numerator/0/coefficient"), quantity(5.2589e6, "1"));
    assert_eq!(at("/dynamics/denominator/1/coefficient"), quantity(3081.0, "s^1.0523"));
    assert_eq!(at("/dynamics/denominator/1/order"), quantity(1.0523, "1"));
    assert_eq!(at("/delay"), quantity(0.01, "s"));
    assert_eq!(at("/offset"), quantity(-0.25, "um"));
    assert_eq!(at("/scheme"), "grunwald-letnikov");
    assert_eq!(at("/sample_rate_hz"), 10_000.0);
    for key in ["/valid_range", "/provenance", "/scores/0/rmse"] {
        assert!(!at(key).is_null());
    }
}

#[test]
fn polynomial_names_run_on_beyond_the_named_degrees() {
    let names: Vec<_> = (1..=7).map(polynomial_name).collect();
    assert_eq!(names, ["linear", "quadratic", "cubic", "quartic", "quintic", "degree_6", "degree_7"]);
    let mut model = article();
    *model.hysteresis.polynomial_mut() = (1..=12).map(f64::from).collect();
    let text = ModelFile::from_model(&model, SignalUnits::default()).to_json().unwrap();
    assert!(text.contains("\"degree_12\"") && text.contains("um/V^12"));
    assert_eq!(read(&text).unwrap().to_model().unwrap(), model);
}

#[test]
fn beta_and_gamma_carry_the_exponent_where_n_is_not_one() {
    let mut model = article();
    *model.hysteresis.number_mut("n").unwrap() = 1.7;
    let file = ModelFile::from_model(&model, SignalUnits::default());
    assert_eq!(file.hysteresis.parameters.get("beta").unwrap().unit, "um^(1-n)/V");
    assert!(file.check().is_ok());
}

#[test]
fn a_short_file_written_by_hand_is_enough() {
    let q = |value: f64, unit: &str| format!("{{\"value\": {value}, \"unit\": \"{unit}\"}}");
    let text = format!(
        r#"{{"format": "hysteron-model", "version": 1,
            "hysteresis": {{"kind": "{}", "parameters":
                {{"gamma": {}, "linear": {}, "n": {}, "alpha": {}, "beta": {}}}}},
            "dynamics": {{"kind": "none"}}, "delay": {}, "offset": {}, "scheme": "tustin",
            "sample_rate_hz": null}}"#,
        HysteresisForm::default().name(),
        q(0.5, "um^(1-n)/V"),
        q(2.0, "um/V"),
        q(1.0, "1"),
        q(1.0, "um/V"),
        q(0.6, "1/V"),
        q(0.0, "s"),
        q(3.0, "um"),
    );
    let model = read(&text).unwrap().to_model().unwrap();
    assert_eq!((model.offset, model.dynamics), (3.0, Dynamics::None));
}

#[test]
fn every_refusal_names_the_place_and_what_is_expected() {
    use serde_json::json;
    let cases: &[(&str, Option<Value>, &str)] = &[
        ("/format", Some(json!("other")), r#"format: expected "hysteron-model", found "other""#),
        ("/format", None, r#"format: expected "hysteron-model", found no such key"#),
        ("/version", Some(json!(3)), "version: this program reads versions 1 and 2, found 3"),
        ("/version", Some(json!("2")), "version: this program reads versions 1 and 2, found \"2\""),
        (
            "/kind",
            Some(json!("other")),
            "kind: expected \"hammerstein\", \"oscillator\", \"force\", \"modes\", \"branches\", \
             found \"other\"",
        ),
        ("/kind", None, "found no such key"),
        ("/scheme", Some(json!("euler")), "scheme: unknown variant `euler`, expected one of `tustin`"),
        (
            "/hysteresis/kind",
            Some(json!("plasticity")),
            "hysteresis.kind: no hysteresis family is called `plasticity`: expected one of ",
        ),
        ("/delay", None, "missing field `delay`"),
        ("/sample_rate_hz", None, "missing field `sample_rate_hz`"),
        ("/delay/value", None, "delay: missing field `value`"),
        (
            "/delay/value",
            Some(json!("fast")),
            "delay.value: invalid type: string \"fast\", expected a number",
        ),
        ("/delay/value", Some(json!(null)), "delay.value: invalid type: null, expected a number"),
        (
            "/delay/value",
            Some(json!(-0.1)),
            "delay.value: expected a number that is not negative, found -0.1",
        ),
        ("/delay/unit", Some(json!("ms")), "delay.unit: expected the unit \"s\", found \"ms\""),
        ("/delay/std_error", Some(json!(-1)), "delay.std_error: expected a number that is not negative"),
        ("/offset", Some(json!(5)), "offset: invalid type: integer `5`, expected an object {\"value\""),
        ("/offset/unit", Some(json!("mm")), "offset.unit: expected the unit \"um\""),
        ("/units/output", Some(json!("mm")), "hysteresis.parameters.linear.unit: expected the unit \"mm/V\""),
        (
            "/hysteresis/parameters/n/value",
            Some(json!(0.5)),
            "hysteresis.parameters.n.value: expected a number of at least 1, found 0.5",
        ),
        ("/hysteresis/parameters/n", None, "hysteresis.parameters: `n` is missing"),
        ("/hysteresis/parameters/alpha", None, "hysteresis.parameters: `alpha` is missing"),
        ("/hysteresis/parameters/linear", None, "hysteresis.parameters: `linear` is missing"),
        ("/hysteresis/parameters/alpha/unit", Some(json!("nm/V")), "hysteresis.parameters.alpha.unit"),
        ("/sample_rate_hz", Some(json!(0)), "sample_rate_hz: expected a rate from 1e-9 to 1e12 Hz, found 0"),
        (
            "/dynamics/denominator/1/order/value",
            Some(json!(-1.0)),
            "dynamics.denominator[1].order.value: expected a number that is not negative",
        ),
        (
            "/dynamics/denominator/2/order/value",
            Some(json!(1.0523)),
            "dynamics.denominator[2].order.value: expected orders in ascending order",
        ),
        (
            "/dynamics/denominator/2/coefficient/value",
            Some(json!(0)),
            "dynamics.denominator[2].coefficient.value: expected a coefficient of the highest order that is \
             not 0",
        ),
        (
            "/dynamics/denominator/2/coefficient/unit",
            Some(json!("s")),
            "dynamics.denominator[2].coefficient.unit: expected the unit \"s^2.0384\"",
        ),
        (
            "/dynamics/denominator",
            Some(json!([])),
            "dynamics.denominator: expected at least one term, found 0 terms",
        ),
        (
            "/dynamics/kind",
            Some(json!("none")),
            "dynamics.numerator: expected no terms for the kind \"none\", found 1 terms",
        ),
        (
            "/dynamics/kind",
            Some(json!("integer")),
            "dynamics.denominator[1].order.value: expected a whole number",
        ),
        (
            "/dynamics/kind",
            Some(json!("arx")),
            "dynamics.denominator[1].order.value: expected the powers 0, 1, 2",
        ),
        (
            "/valid_range/input/high",
            Some(json!(-1)),
            "valid_range.input.high: expected a number from `low` to 1e100",
        ),
        ("/start/voltage/unit", Some(json!("mV")), "start.voltage.unit: expected the unit \"V\""),
        (
            "/start/kind",
            Some(json!("settled")),
            "start.voltage: expected null for a start of the kind \"settled\"",
        ),
        ("/valid_range/rate/unit", Some(json!("V")), "valid_range.rate.unit: expected the unit \"V/s\""),
        ("/provenance/records/0/role", Some(json!("x")), "provenance.records[0].role: unknown variant `x`"),
        ("/provenance/seed", Some(json!(-1)), "provenance.seed: invalid value"),
        ("/scores/0/rmse", Some(json!("low")), "scores[0].rmse: invalid type"),
    ];
    for (pointer, replacement, expected) in cases {
        let message = refused(pointer, replacement.clone());
        assert!(message.contains(expected), "{pointer}: {message}");
    }
}

#[test]
fn unknown_and_duplicate_keys_are_refused_at_every_level() {
    for pointer in [
        "",
        "/units",
        "/hysteresis",
        "/dynamics",
        "/dynamics/numerator/0",
        "/delay",
        "/valid_range",
        "/start",
        "/valid_range/input",
        "/provenance",
        "/provenance/records/0",
        "/scores/0",
        "/correlation",
    ] {
        let mut json = serde_json::to_value(complete()).unwrap();
        json.pointer_mut(pointer).unwrap().as_object_mut().unwrap().insert("extra".into(), 1.into());
        let message = read(&json.to_string()).unwrap_err().to_string();
        assert!(message.contains("unknown field `extra`"), "{pointer}: {message}");
    }
    let mut json = serde_json::to_value(complete()).unwrap();
    json["hysteresis"]["parameters"]["quartic"] = json["hysteresis"]["parameters"]["linear"].clone();
    let message = read(&json.to_string()).unwrap_err().to_string();
    assert!(message.contains("unknown parameter `quartic`") && message.contains("without gaps"), "{message}");

    let text = complete().to_json().unwrap();
    let twice = text.replacen("\"alpha\":", "\"linear\":", 1);
    assert!(read(&twice).unwrap_err().to_string().contains("duplicate parameter `linear`"));
    let twice = text.replacen("\"scheme\":", "\"scheme\": \"bdf2\",\n  \"scheme\":", 1);
    assert!(read(&twice).unwrap_err().to_string().contains("duplicate field `scheme`"));
}

#[test]
fn what_is_not_json_is_refused_with_line_and_column() {
    let message = |text: &str| read(text).unwrap_err().to_string();
    assert_eq!(message(""), "the file is empty");
    assert!(message("[]").contains("expected a model file (a JSON object)"));
    let text = complete().to_json().unwrap();
    let half = text[..text.len() / 2].rfind('\n').unwrap();
    assert!(message(&text[..half]).contains("the file ends within"));
    assert!(message(&(text.clone() + "x")).contains("trailing characters"));
    assert!(message(&text.replacen("0.01", "NaN", 1)).contains("line"));
    assert!(message(&text.replacen("0.01", "1e999", 1)).contains("number out of range"));
    assert!(message(&"[".repeat(100_000)).contains("line 1"));
    let nested = format!("{{\"format\": {}", "[".repeat(100_000));
    assert!(message(&nested).contains("recursion limit exceeded"));
    let big = vec![b' '; MAX_BYTES as usize + 1];
    assert!(matches!(parsed(&big), Err(ModelFileError::TooLarge { limit_bytes: MAX_BYTES })));
}

#[test]
fn arx_needs_a_leading_one_and_a_sample_rate() {
    let arx = Dynamics::Arx(Arx { a: vec![-0.5], b: vec![0.5] });
    let mut file = ModelFile::from_model(&Model { dynamics: arx, ..article() }, SignalUnits::default());
    file.sample_rate_hz = None;
    assert!(matches!(file.check(), Err(ModelFileError::ArxWithoutSampleRate)));
    file.sample_rate_hz = Some(1.0);
    file.dynamics.denominator[0].coefficient.value = 2.0;
    let message = file.check().unwrap_err().to_string();
    assert!(message.starts_with("dynamics.denominator[0].coefficient.value: expected 1"), "{message}");
}

#[test]
fn a_file_that_could_not_be_read_back_is_not_written() {
    let mut file = complete();
    file.scores[0].fit_percent = Some(f64::NAN);
    assert!(
        file.to_json()
            .unwrap_err()
            .to_string()
            .starts_with("scores[0].fit_percent: expected a finite number")
    );
    file = complete();
    file.offset.value = f64::INFINITY;
    assert!(file.to_json().is_err());
}

#[test]
fn timestamps_agree_with_known_dates() {
    // Seconds since 1970 of known instants, leap days and the ends of centuries among them.
    for (seconds, text) in [
        (0, "1970-01-01T00:00:00Z"),
        (951_782_399, "2000-02-28T23:59:59Z"),
        (951_782_400, "2000-02-29T00:00:00Z"),
        (1_000_000_000, "2001-09-09T01:46:40Z"),
        (1_709_251_199, "2024-02-29T23:59:59Z"),
        (4_107_542_400, "2100-03-01T00:00:00Z"),
    ] {
        assert_eq!(timestamp(seconds), text);
    }
}

#[test]
fn the_published_schema_is_up_to_date() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema/hysteron-model-2.schema.json");
    let published = std::fs::read_to_string(path).expect(path);
    assert!(
        published == json_schema(),
        "write it anew: hysteron schema > docs/schema/hysteron-model-2.schema.json"
    );
}
