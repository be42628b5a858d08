//! Model files on disk.
#![allow(clippy::unwrap_used)]

use hysteron_io::{IoError, JsonFileError, load_model, save_model};
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::{ModelFile, Quantity, SignalUnits};
use hysteron_model::record::InterSample;
use hysteron_model::{Model, hammerstein};

#[test]
fn a_file_written_is_the_file_read_and_what_is_not_sound_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    let hysteresis = Hysteresis::from(BoucWen::new(vec![15.0, -0.25], 3.5, 0.6, 0.2, 1.0).unwrap());
    let law = hammerstein::Model {
        hysteresis,
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    };
    let mut file = ModelFile::from_model(&law, SignalUnits::default());
    let model = Model::try_from(file.clone()).unwrap();
    save_model(&path, &model).unwrap();
    assert_eq!(load_model(&path).unwrap(), model);
    file.delay = Quantity::new(-1.0, "s");
    assert!(Model::try_from(file).is_err());
    let full = folder.path().join("absent").join("model.json");
    assert!(matches!(save_model(&full, &model), Err(IoError::Write(_))));
    let absent = load_model(&folder.path().join("absent.json"));
    assert!(matches!(absent, Err(IoError::Json(JsonFileError::Unread { .. }))));
}
