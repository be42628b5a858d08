use super::super::{Document, read};
use super::*;
use crate::hysteresis::HysteresisForm;

fn model() -> ForceModel {
    let dahl: HysteresisForm = "dahl".parse().unwrap();
    ForceModel {
        offset: 1.25,
        hysteresis: dahl.operator(vec![1e-3], &[0.05], &[300.0, 1.0]).unwrap(),
        viscous: 4e-3,
        saturating: vec![Saturation { force: 548.0, rate: 9.9e3, reach: 157.0 }],
        rate_window_s: 0.006,
    }
}

fn file() -> ForceFile {
    let signals = SignalUnits { input: "um".into(), output: "N".into() };
    let mut file = ForceFile::new(&model(), signals, Some(1000.0));
    file.quantity_mut("saturating_rate").unwrap().std_error = Some(500.0);
    file
}

fn parsed(bytes: &[u8]) -> Result<ForceFile, ModelFileError> {
    match read(bytes)? {
        Document::Force(file) => Ok(*file),
        other => panic!("a file of the kind {}", other.kind()),
    }
}

#[test]
fn a_file_reads_back_bit_for_bit() {
    let text = file().to_json().unwrap();
    for unit in ["\"N*s/um\"", "\"um/s\"", "\"N/um\"", "\"um\"", "\"N\""] {
        assert!(text.contains(unit), "{unit}: {text}");
    }
    let back = parsed(text.as_bytes()).unwrap();
    assert_eq!(back, file());
    assert_eq!(back.to_model().unwrap(), model());
}

#[test]
fn every_number_of_the_model_has_a_quantity() {
    let mut file = file();
    for (name, value) in model().numbers() {
        assert_eq!(file.quantity_mut(&name).unwrap().value, value, "{name}");
    }
    assert!(file.quantity_mut("mass").is_none());
}

#[test]
fn what_is_not_allowed_is_named() {
    let text = file().to_json().unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut refused = |pointer: &str, new: serde_json::Value| {
        let old = std::mem::replace(value.pointer_mut(pointer).unwrap(), new);
        let error = parsed(value.to_string().as_bytes()).unwrap_err().to_string();
        *value.pointer_mut(pointer).unwrap() = old;
        error
    };
    let number = |x: f64| serde_json::json!(x);
    assert!(refused("/saturating/0/rate/value", number(0.0)).contains("saturating[0].rate.value"));
    assert!(refused("/saturating/0/reach/value", number(-1.0)).contains("saturating[0].reach.value"));
    assert!(refused("/viscous/unit", serde_json::json!("N/um")).contains("N*s/um"));
    assert!(refused("/hysteresis/parameters/reach/value", number(0.0)).contains("reach"));
    assert!(refused("/hysteresis/parameters/linear/unit", serde_json::json!("N")).contains("N/um"));
    assert!(refused("/rate_window/value", number(-1.0)).contains("rate_window.value"));
    assert!(refused("/sample_rate_hz", number(0.0)).contains("sample_rate_hz"));
    let misnamed = text.replace("\"viscous\"", "\"viscosity\"");
    assert!(parsed(misnamed.as_bytes()).unwrap_err().to_string().contains("viscosity"));
}
