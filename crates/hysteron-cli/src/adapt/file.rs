//! The corrected model as a file.

use std::collections::BTreeMap;

use clap::ValueEnum;
use hysteron_model::model_file::{ModelFile, Provenance, RecordEntry, RecordRole, ScoreEntry, ScoreRole};

use super::follow::Followed;
use super::{Adapt, Task, text};
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::LoadedModel;

/// The old file with the new numbers; the old numbers' errors say nothing of them and are left out.
pub fn corrected(
    command: &Adapt,
    old: &LoadedModel,
    task: &Task,
    found: &Followed,
) -> Result<ModelFile, Failure> {
    let no_model = |because: &dyn std::fmt::Display| {
        Failure::new("the corrected coefficients make no model").because(because)
    };
    let model = found.model.as_ref().map_err(|e| no_model(e))?;
    let bytes = std::fs::read(&command.model)
        .map_err(|e| Failure::new(format!("cannot read the model {}", command.model.display())).because(e))?;
    let mut options = BTreeMap::from([
        ("method".to_owned(), "adapt".to_owned()),
        ("adapted model".to_owned(), command.model.display().to_string()),
        ("adapted model sha256".to_owned(), hysteron_io::sha256(&bytes)),
        (
            "estimator".to_owned(),
            task.method.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned()),
        ),
        ("noise".to_owned(), task.noise.to_string()),
    ]);
    for path in &found.paths {
        options.insert(text::name(path.term), path.end.to_string());
    }
    let source = task.data.source.as_ref();
    let record = RecordEntry {
        path: source.map_or(task.data.name.clone(), |s| s.path.clone()),
        sha256: source.map(|s| s.sha256.clone()),
        samples: task.data.len() as u64,
        role: RecordRole::Both,
    };
    let previous = old.file();
    Ok(ModelFile {
        name: previous.name.clone(),
        normalisation: previous.normalisation,
        start: previous.start.clone(),
        valid_range: previous.valid_range.clone(),
        provenance: Some(Provenance::new(&maker(), vec![record], options, None)),
        scores: vec![ScoreEntry::new(
            &task.data.name,
            ScoreRole::Training,
            task.data.y_unit.symbol(),
            &found.last,
        )],
        ..ModelFile::from_model(model, previous.units.clone())
    })
}
