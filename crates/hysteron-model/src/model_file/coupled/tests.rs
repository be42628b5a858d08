use super::super::{Document, read};
use super::*;

/// One input, two outputs.
fn model() -> CoupledHammerstein {
    let path = |gain| Path { gain, natural_frequency_hz: 70.0, damping: 0.1, delay_s: 1e-3 };
    CoupledHammerstein {
        actuators: vec![ArticleOperator {
            polynomial: vec![1.0],
            alpha: 0.25,
            beta: 0.9,
            gamma: 1.0 / 3.0,
            n: 1.0,
        }],
        paths: vec![path(1.4), path(-0.3)],
        offsets: vec![3.0, -2.0],
        sample_rate_hz: 1000.0,
    }
}

fn file() -> CoupledFile {
    let units = SignalUnits { input: "V".into(), output: "um".into() };
    let errors = CoupledErrors { actuators: vec![[0.01, 0.02, 0.03]], paths: vec![[0.1, 0.2, 0.3, 1e-5]; 2] };
    CoupledFile::new(&model(), Some(&errors), units, (vec!["u".into()], vec!["y1".into(), "y2".into()]))
}

fn parsed(bytes: &[u8]) -> Result<CoupledFile, ModelFileError> {
    match read(bytes)? {
        Document::Branches(file) => Ok(*file),
        other => panic!("a file of the kind {}", other.kind()),
    }
}

#[test]
fn a_file_reads_back_bit_for_bit() {
    let text = file().to_json().unwrap();
    assert!(text.contains("\"um/V\"") && text.contains("\"1/V\""), "{text}");
    let back = parsed(text.as_bytes()).unwrap();
    assert_eq!(back, file());
    assert_eq!(back.to_model().unwrap(), model());
    assert_eq!(back.paths[1][0].damping.std_error, Some(0.3));
}

#[test]
fn what_is_not_allowed_is_named() {
    let text = file().to_json().unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut refused = |pointer: &str, new: &str| {
        let new: serde_json::Value = serde_json::from_str(new).unwrap();
        let old = std::mem::replace(value.pointer_mut(pointer).unwrap(), new);
        let error = parsed(value.to_string().as_bytes()).unwrap_err().to_string();
        *value.pointer_mut(pointer).unwrap() = old;
        error
    };
    assert!(refused("/paths/0/0/natural_frequency/value", "0").contains("paths[0][0].natural_frequency"));
    assert!(refused("/paths/1/0/damping/value", "-0.1").contains("paths[1][0].damping"));
    assert!(refused("/paths/1/0/gain/unit", "\"nm/V\"").contains("um/V"));
    assert!(refused("/paths/1", "[]").contains("paths[1]"));
    assert!(refused("/paths", "[]").contains("one list an output"));
    assert!(refused("/actuators", "[]").contains("one entry an input"));
    assert!(refused("/offsets/0/unit", "\"V\"").contains("offsets[0]"));
    assert!(refused("/outputs/0", "\"u\"").contains("`u`"));
    assert!(refused("/sample_rate_hz", "0").contains("sample_rate_hz"));
    assert!(refused("/version", "3").contains("version"));
    let misnamed = text.replacen("\"alpha\"", "\"alfa\"", 1);
    assert!(parsed(misnamed.as_bytes()).unwrap_err().to_string().contains("alfa"));
}

#[test]
fn a_file_of_version_1_is_read_and_written_as_version_2() {
    let text = file().to_json().unwrap();
    let old = text
        .replace("\"hysteron-model\"", "\"hysteron-coupled\"")
        .replace("\"version\": 2,\n  \"kind\": \"branches\"", "\"version\": 1");
    assert!(old != text && !old.contains("\"kind\": \"branches\""), "{old}");
    assert_eq!(parsed(old.as_bytes()).unwrap(), file());
    assert_eq!(parsed(old.as_bytes()).unwrap().to_json().unwrap(), text);
}

#[test]
fn keys_of_another_kind_are_refused() {
    let text = file().to_json().unwrap();
    let other = text.replacen("\"kind\": \"branches\"", "\"kind\": \"hammerstein\"", 1);
    assert!(read(other.as_bytes()).is_err());
}
