//! Model files on disk.
#![allow(clippy::unwrap_used)]

use hysteron_io::{ModelDiskError, read_model_file, write_model_file};
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::{ModelFile, SignalUnits};
use hysteron_model::record::InterSample;

#[test]
fn a_file_written_is_the_file_read_and_a_rejected_one_leaves_the_old() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    let hysteresis = Hysteresis::BoucWen(BoucWen::new(vec![15.0, -0.25], 3.5, 0.6, 0.2, 1.0).unwrap());
    let model = Model {
        hysteresis,
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    };
    let file = ModelFile::from_model(&model, SignalUnits::default());
    write_model_file(&path, file.to_json()).unwrap();
    assert_eq!(read_model_file(&path, ModelFile::from_slice).unwrap(), file);
    let mut broken = file.clone();
    broken.delay.value = -1.0;
    assert!(matches!(write_model_file(&path, broken.to_json()), Err(ModelDiskError::Content(_))));
    assert_eq!(read_model_file(&path, ModelFile::from_slice).unwrap(), file);
    let absent = read_model_file(&folder.path().join("absent.json"), ModelFile::from_slice);
    assert!(matches!(absent, Err(ModelDiskError::Unreadable { .. })));
}
