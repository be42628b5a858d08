//! Measured examples, inside the program, copied into the workspace on request.

use hysteron_examples::EXAMPLES;
use hysteron_io::atomic_file::write_atomically;

use super::{Workspace, shown};
use crate::api::{ExampleOpened, RecordSettings};
use crate::refused::{Answer, Refused};

/// Copies an example into the workspace. Records of several files continue one another.
///
/// # Errors
/// For an unknown name; if a file cannot be written. One that is there is left as it is.
pub(crate) fn open_example(workspace: &Workspace, name: &str) -> Answer<ExampleOpened> {
    let example = EXAMPLES.iter().find(|example| example.name == name);
    let unknown = || Refused::missing(format!("no example is called `{}`", shown(name)));
    let example = example.ok_or_else(unknown)?;
    let folder = workspace.path(example.name)?;
    let failed = |e: &dyn std::fmt::Display| Refused::failed(format!("the example cannot be copied: {e}"));
    std::fs::create_dir_all(&folder).map_err(|e| failed(&e))?;
    let mut copied = Vec::new();
    for (file, bytes) in example.records.iter().chain([&example.licence]) {
        let path = folder.join(file);
        if !path.exists() {
            write_atomically(&path, bytes).map_err(|e| failed(&e))?;
            copied.push(*file);
        }
    }
    let ids = example.records.iter().map(|(file, _)| format!("{}/{file}", example.name));
    let records: Vec<String> = ids.collect();
    if let Some((input, output)) = example.columns {
        // What was said of a record that was there already stays.
        let is_copied = |k: &usize| copied.contains(&example.records[*k].0);
        for (k, id) in records.iter().enumerate().filter(|(k, _)| is_copied(k)) {
            let continues = k.checked_sub(1).map(|before| records[before].clone());
            let (input, output) = (Some(input.to_owned()), Some(output.to_owned()));
            let settings = RecordSettings { input, output, continues, ..RecordSettings::default() };
            workspace.history.keep_settings(id, &settings)?;
        }
    }
    workspace.look();
    Ok(ExampleOpened { records })
}
