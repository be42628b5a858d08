//! `openapi.json`, made from the operations and the schemas of their types.

use schemars::SchemaGenerator;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use super::operation::{self, Answers, Operation, Takes};
use crate::api::Refusal;
use crate::clock::PROGRAM;

/// The description of the interface (OpenAPI 3.1).
pub fn document() -> Value {
    let mut settings = SchemaSettings::draft2020_12();
    "/components/schemas".clone_into(settings.definitions_path.to_mut());
    settings.meta_schema = None;
    let mut generator = SchemaGenerator::new(settings);
    let refusal = generator.subschema_for::<Refusal>();
    let mut paths = Map::new();
    for operation in operation::all() {
        let described = described(&operation, &mut generator, &refusal.clone().to_value());
        let path = paths.entry(operation.path).or_insert_with(|| json!({}));
        path[operation.method] = described;
    }
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "hysteron app",
            "version": PROGRAM.rsplit(' ').next(),
            "description": "The interface that the page of `hysteron app` uses, and nothing else.",
        },
        "paths": paths,
        "components": { "schemas": generator.take_definitions(true) },
    })
}

fn described(operation: &Operation, generator: &mut SchemaGenerator, refusal: &Value) -> Value {
    let mut parameters: Vec<Value> = operation.path.split('/').filter_map(of_path).collect();
    if let Some(query) = operation.query {
        let schema = query(generator).to_value();
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        for (name, schema) in schema["properties"].as_object().into_iter().flatten() {
            let required = required.contains(&name.as_str());
            parameters.push(json!({ "name": name, "in": "query", "required": required, "schema": schema }));
        }
    }
    let content = match operation.answers {
        Answers::Json(schema) => json!({ "application/json": { "schema": schema(generator) } }),
        Answers::Media(media) => json!({ media: {} }),
        Answers::Nothing => json!({}),
    };
    let mut described = json!({
        "summary": operation.summary,
        "parameters": parameters,
        "responses": {
            operation.status.to_string(): { "description": "Done.", "content": content },
            "default": {
                "description": "Refused.",
                "content": { "application/json": { "schema": refusal } },
            },
        },
    });
    let body = match operation.takes {
        Takes::Nothing => return described,
        Takes::Json(schema) => json!({ "application/json": { "schema": schema(generator) } }),
        Takes::Bytes => json!({ "application/octet-stream": {} }),
    };
    described["requestBody"] = json!({ "required": true, "content": body });
    described
}

fn of_path(part: &str) -> Option<Value> {
    let name = part.strip_prefix('{')?.strip_suffix('}')?;
    Some(json!({ "name": name, "in": "path", "required": true, "schema": { "type": "string" } }))
}
