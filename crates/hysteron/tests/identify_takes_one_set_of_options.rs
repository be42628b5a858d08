//! Options that would count for nothing are refused before anything is fitted.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron::{Error, HysteresisForm, Identify, Kind, Model, Task};

#[test]
fn options_beside_a_task_or_another_kind_are_refused() {
    let task = Task::of(Kind::Hammerstein);
    let both = Identify::new(&[]).task(task).seed(7).run();
    assert!(matches!(both, Err(Error::OptionsOfTask)), "{both:?}");
    let family = HysteresisForm::plays(8);
    let other = Identify::new(&[]).kind(Kind::Oscillator).hysteresis(family).run();
    assert!(matches!(other, Err(Error::OptionsOfKind { kind: Kind::Oscillator })), "{other:?}");
    // Without them the records are looked at.
    assert!(matches!(Identify::new(&[]).run(), Err(Error::Identify(_))));
}

/// Of a kind that cannot be a start, and of another kind than the fit's.
#[test]
fn starts_of_other_kinds_are_refused() {
    let of = |kind, records: &[hysteron::Record], model: &Model| {
        Identify::new(records).kind(kind).start(model).run().unwrap_err().to_string()
    };
    let text =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../hysteron-cli/tests/unchanged/records.json"))
            .unwrap();
    let recorded: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let model = |name: &str| {
        let path = folder.path().join(format!("{name}.json"));
        std::fs::write(&path, recorded[name]["model"].to_string()).unwrap();
        Model::load(path).unwrap()
    };
    let refused = of(Kind::Hammerstein, &[], &model("modes"));
    assert_eq!(refused, "the start of a fit is not supported for a model of the kind \"modes\" yet");
    let refused = of(Kind::Oscillator, &[], &model("bouc-wen"));
    assert!(refused.contains("begins with a model of that kind, not of \"hammerstein\""), "{refused}");
}
