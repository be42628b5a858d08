use super::super::{Document, read};
use super::*;

/// One input, two outputs, one mode.
fn model() -> ScheduledModes {
    let law = || StrainLaw {
        coefficients: vec![0.1, 0.0, 0.2],
        radii: vec![0.5],
        slopes: vec![0.3],
        variance: 1.0,
        reach: 3.0,
    };
    ScheduledModes {
        inputs: 1,
        outputs: 2,
        modes: 1,
        sample_rate_hz: 1000.0,
        steps: 2,
        level: LevelLaw { reference: 0.3, exponent: 1.0, lowest: 0.1, highest: 0.3, time_constant_s: 2.0 },
        transition: vec![0.9, 0.3, 0.5],
        transition_slopes: vec![0.01, 0.0, 0.0],
        input: vec![0.1, 0.2, 0.5],
        strain_input: vec![0.1, 0.2, 0.0],
        output: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        output_slopes: vec![0.0; 6],
        feedthrough: vec![0.1, 1.0 / 3.0],
        feedthrough_slopes: vec![0.0; 2],
        strain_feedthrough: vec![0.0; 2],
        feedback: Some(FeedbackStrain {
            drive_rows: vec![0.0, 0.0, 1.0, 0.0],
            stress_rows: vec![0.5, 0.0, 0.0, -1.0],
            drive: law(),
            stress: vec![law()],
        }),
    }
}

fn file() -> ModesFile {
    let units = SignalUnits { input: "V".into(), output: "um".into() };
    let mut file = ModesFile::new(&model(), units, vec!["u".into()], vec!["y1".into(), "y2".into()]);
    file.influence.push(InfluenceEntry::new(0.3, &InfluenceMatrix::new(1, 2, vec![3.0, 4.0])));
    file
}

fn parsed(bytes: &[u8]) -> Result<ModesFile, ModelFileError> {
    match read(bytes)? {
        Document::Modes(file) => Ok(*file),
        other => panic!("a file of the kind {}", other.kind()),
    }
}

#[test]
fn a_file_reads_back_bit_for_bit() {
    let text = file().to_json().unwrap();
    let back = parsed(text.as_bytes()).unwrap();
    assert_eq!(back, file());
    assert_eq!(back.to_model().unwrap(), model());
    let linear = ScheduledModes { feedback: None, ..model() };
    let of_linear = ModesFile::new(&linear, back.units.clone(), back.inputs, back.outputs);
    let text = of_linear.to_json().unwrap();
    assert!(text.contains("\"hysteresis\": null"));
    assert_eq!(parsed(text.as_bytes()).unwrap().to_model().unwrap(), linear);
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
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    assert!(refused("/output", json("[1, 2]")).contains("output: expected 6 numbers, found 2"));
    assert!(refused("/transition/0", json("1.5")).contains("unstable"));
    assert!(refused("/modes", json("1000000000000")).contains("at most 512"));
    assert!(refused("/modes", json("0")).contains("modes is 0"));
    assert!(refused("/steps", json("0")).contains("steps is 0"));
    assert!(refused("/sample_rate_hz", json("-1")).contains("sample_rate_hz"));
    assert!(refused("/level/lowest", json("0.4")).contains("level.lowest"));
    assert!(refused("/outputs/1", json("\"u\"")).contains("`u`"));
    assert!(refused("/hysteresis/stress", json("[]")).contains("stress: expected 1"));
    assert!(refused("/hysteresis/drive/radii/0", json("-0.5")).contains("radii"));
    assert!(refused("/hysteresis/drive/variance", json("0")).contains("variance"));
    assert!(refused("/influence/0/matrix", json("[1]")).contains("influence[0].matrix"));
    assert!(refused("/version", json("3")).contains("version"));
    assert!(refused("/input/1", json("null")).contains("input[1]"));
    let misnamed = text.replace("\"strain_input\"", "\"strain_inputs\"");
    assert!(parsed(misnamed.as_bytes()).unwrap_err().to_string().contains("strain_inputs"));
    // A number beyond the range of numbers is no number.
    let huge = text.replacen("0.9", "1e999", 1);
    assert!(parsed(huge.as_bytes()).is_err());
}

#[test]
fn a_file_of_version_1_is_read_and_written_as_version_2() {
    let text = file().to_json().unwrap();
    let old = text
        .replace("\"hysteron-model\"", "\"hysteron-modes\"")
        .replace("\"version\": 2,\n  \"kind\": \"modes\"", "\"version\": 1");
    assert!(old != text && !old.contains("\"kind\": \"modes\""), "{old}");
    assert_eq!(parsed(old.as_bytes()).unwrap(), file());
    assert_eq!(parsed(old.as_bytes()).unwrap().to_json().unwrap(), text);
}

#[test]
fn keys_of_another_kind_are_refused() {
    let text = file().to_json().unwrap();
    let other = text.replacen("\"kind\": \"modes\"", "\"kind\": \"hammerstein\"", 1);
    assert!(read(other.as_bytes()).is_err());
}
