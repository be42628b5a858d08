//! Measured dampers, which the project does not contain: read through `HYSTERON_DATA`, skipped without.

use std::path::{Path, PathBuf};

use hysteron_identify::force::Options;
use hysteron_model::model_file::Maker;
use hysteron_model::record::{InputOutput, TimeBase, Unit};
use hysteron_model::validate::Scoring;
use hysteron_model::{Model, Start};

use crate::identify;

/// Displacement (column 2) and force (column 4) of a record, or a word that the test is skipped.
fn record(path: &str, force_unit: &str) -> Option<InputOutput> {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let Ok(text) = std::fs::read_to_string(folder.join(path)) else {
        println!("skipped: {path} not found (set HYSTERON_DATA)");
        return None;
    };
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.trim().parse().unwrap()).collect())
        .collect();
    let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f64>>();
    let time = TimeBase::from_times(path, column(0)).unwrap();
    let mut data = InputOutput::new(path, time, column(1), column(3)).unwrap();
    (data.u_unit, data.y_unit) = (Unit::new("mm"), Unit::new(force_unit));
    Some(data)
}

/// RMSE on each held-out record, in per cent of its range of force.
fn held_out(training: &[&str], unseen: &[&str], unit: &str, options: &Options) -> Option<Vec<f64>> {
    let read = |paths: &[&str]| paths.iter().map(|path| record(path, unit)).collect::<Option<Vec<_>>>();
    let (training, unseen) = (read(training)?, read(unseen)?);
    let found = identify(&training, options).unwrap();
    let maker = Maker { program: "test".to_owned(), created: None, command: None };
    let model = Model::try_from(found.model_file(options, &maker)).unwrap();
    let error = |record: &InputOutput| {
        let score = model.score(&record.clone().into(), Start::AsIdentified, &Scoring::default()).unwrap();
        score.outputs[0].rmse_percent_of_stroke.unwrap()
    };
    Some(unseen.iter().map(error).collect())
}

#[test]
fn a_magnetorheological_damper_is_predicted_at_other_amplitudes_and_frequencies() {
    let of = |name: &str| format!("mr-damper-utfsm/{name}0x5A.csv");
    let training = ["25mm0x25Hz", "10mm1Hz", "5mm3Hz"].map(of);
    let unseen = ["25mm0x1Hz", "25mm0x5Hz", "2mm5Hz"].map(of);
    let [training, unseen] = [&training, &unseen].map(|names| names.each_ref().map(String::as_str));
    let Some(mut errors) = held_out(&training, &unseen, "N", &Options::default()) else { return };
    println!("{errors:?}");
    errors.sort_by(f64::total_cmp);
    assert!(errors[1] < 4.0 && errors[2] < 9.0, "{errors:?}");
}

#[test]
fn a_friction_damper_with_backlash_is_predicted_at_another_amplitude() {
    let of = |name: &str| format!("friction-damper-brfd/{name}.csv");
    let rows = [
        (["0.25Hz_1.5in", "0.25Hz_0.5in"], "0.25Hz_1in", 5.52),
        (["0.25Hz_1in", "0.5Hz_1in"], "0.25Hz_1.5in", 6.27),
    ];
    for (training, unseen, hammerstein) in rows {
        let (training, unseen) = (training.map(of), of(unseen));
        let training = training.each_ref().map(String::as_str);
        let Some(errors) = held_out(&training, &[&unseen], "kN", &Options::default()) else { return };
        println!("{unseen}: {errors:?}");
        assert!(errors[0] < hammerstein, "{errors:?}");
    }
}
