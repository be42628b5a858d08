//! JSON files come back, and what is none is refused with its place.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_io::{IoError, JsonFileError, load_json, save_json};

#[test]
fn what_is_written_is_read_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("settings.json");
    for indented in [false, true] {
        save_json(&path, &vec![1.5, 2.5], indented).unwrap();
        assert_eq!(load_json::<Vec<f64>>(&path, 1000).unwrap(), [1.5, 2.5]);
        assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count() > 1, indented);
    }
    let refused = load_json::<Vec<f64>>(&path, 4);
    assert!(
        matches!(refused, Err(IoError::Json(JsonFileError::TooLarge { most_bytes: 4, .. }))),
        "{refused:?}"
    );
    std::fs::write(&path, "[1.5,\n oops]").unwrap();
    let refused = load_json::<Vec<f64>>(&path, 1000).unwrap_err().to_string();
    assert!(refused.contains("settings.json") && refused.contains("line 2"), "{refused}");
    let absent = load_json::<Vec<f64>>(&folder.path().join("absent.json"), 1000);
    assert!(matches!(absent, Err(IoError::Json(JsonFileError::Unread { .. }))));
    let nowhere = save_json(&folder.path().join("no/such/folder.json"), &1, false);
    assert!(matches!(nowhere, Err(IoError::Write(_))));
}
