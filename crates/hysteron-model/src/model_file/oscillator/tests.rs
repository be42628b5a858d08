use super::super::{Document, read};
use super::*;

fn oscillator() -> Oscillator {
    Oscillator { mass: 2e-6, damping: 1e-5, stiffness: 0.05, alpha: 0.05, beta: 8e-4, gamma: -1.1e-3, n: 1.0 }
}

fn file() -> OscillatorFile {
    let signals = SignalUnits { input: "N".into(), output: "um".into() };
    let mut file = OscillatorFile::new(&oscillator(), signals, InterSample::BandLimited, 750.0);
    file.parameters.mass.std_error = Some(1e-9);
    file.set_start(crate::Start::PERIODIC);
    file
}

fn parsed(bytes: &[u8]) -> Result<OscillatorFile, ModelFileError> {
    match read(bytes)? {
        Document::Oscillator(file) => Ok(*file),
        other => panic!("a file of the kind {}", other.kind()),
    }
}

#[test]
fn a_file_reads_back_bit_for_bit() {
    let text = file().to_json().unwrap();
    assert!(text.contains("\"N*s^2/um\"") && text.contains("\"1/um\""), "{text}");
    let back = parsed(text.as_bytes()).unwrap();
    assert_eq!(back, file());
    assert_eq!(back.to_oscillator().unwrap(), oscillator());
    let other = Oscillator { n: 1.5, ..oscillator() };
    let of_other = OscillatorFile::new(&other, back.units.clone(), InterSample::Linear, 750.0);
    assert_eq!(of_other.parameters.beta.unit, "N^(1-n)/um");
    assert!(of_other.to_json().is_ok());
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
    assert!(refused("/parameters/mass/value", number(0.0)).contains("parameters.mass.value"));
    assert!(refused("/parameters/n/value", number(0.5)).contains("parameters.n.value"));
    assert!(refused("/parameters/alpha/unit", serde_json::json!("V/um")).contains("N/um"));
    assert!(refused("/sample_rate_hz", number(-1.0)).contains("sample_rate_hz"));
    assert!(refused("/version", number(3.0)).contains("version"));
    assert!(refused("/offset", serde_json::json!({"value": 0.0, "units": "um"})).contains("unknown field"));
    let misnamed = text.replace("\"gamma\"", "\"gama\"");
    assert!(parsed(misnamed.as_bytes()).unwrap_err().to_string().contains("gama"));
}

#[test]
fn a_file_of_version_1_is_read_and_written_as_version_2() {
    let text = file().to_json().unwrap();
    let old = text
        .replace("\"hysteron-model\"", "\"hysteron-oscillator\"")
        .replace("\"version\": 2,\n  \"kind\": \"oscillator\"", "\"version\": 1");
    assert!(old != text && !old.contains("\"kind\": \"oscillator\""), "{old}");
    assert_eq!(parsed(old.as_bytes()).unwrap(), file());
    assert_eq!(parsed(old.as_bytes()).unwrap().to_json().unwrap(), text);
}

#[test]
fn keys_of_another_kind_are_refused() {
    let text = file().to_json().unwrap();
    let other = text.replacen("\"kind\": \"oscillator\"", "\"kind\": \"hammerstein\"", 1);
    assert!(read(other.as_bytes()).is_err());
}
