//! The format as JSON Schema.

use schemars::JsonSchema;

use super::ModelFile;

/// JSON Schema (draft 2020-12) of version 1 of the model file, indented, with a final newline.
///
/// Units, ascending orders and the relation between kind and terms are beyond it; [`ModelFile::from_slice`] checks
/// them as well.
pub fn json_schema() -> String {
    of::<ModelFile>("Hysteron model file, version 1")
}

/// The schema of a file, indented, with a final newline.
pub(super) fn of<T: JsonSchema>(title: &str) -> String {
    let mut schema = schemars::schema_for!(T);
    schema.insert("title".into(), title.into());
    format!("{:#}\n", schema.as_value())
}
