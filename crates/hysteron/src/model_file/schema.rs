//! The format as JSON Schema.

use super::ModelFile;

/// JSON Schema (draft 2020-12) of version 1 of the model file, indented, with a final newline.
///
/// Units, ascending orders and the relation between kind and terms are beyond it; [`ModelFile::from_slice`] checks
/// them as well.
pub fn json_schema() -> String {
    let mut schema = schemars::schema_for!(ModelFile);
    schema.insert("title".into(), "Hysteron model file, version 1".into());
    format!("{:#}\n", schema.as_value())
}
