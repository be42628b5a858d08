//! The format as JSON Schema.

use super::Document;

/// JSON Schema (draft 2020-12) of version 2 of the model file, of every kind, indented, with a final newline.
///
/// Units, ascending orders and the relation between kind and terms are beyond it; [`read`](super::read)
/// checks them as well.
pub fn json_schema() -> String {
    let mut schema = schemars::schema_for!(Document);
    schema.insert("title".into(), "Hysteron model file, version 2".into());
    format!("{:#}\n", schema.as_value())
}
