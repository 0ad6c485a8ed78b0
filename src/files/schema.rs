//! The JSON Schema of scene files, generated from the table of kinds.

use serde_json::{Map, Value, json};

use super::kinds::{count, list_of_length, reference, text};
use super::scene::{FORMAT, OLD, VERSION};
use super::sums::SUMS;
use super::{PartEntry, PartKind, SceneFile};

impl SceneFile {
    /// The JSON Schema (draft 2020-12) of scene files, with which editors complete and check them.
    ///
    /// ```
    /// use hamiltonian_adjoint::SceneFile;
    ///
    /// let schema = SceneFile::schema();
    /// assert!(schema.contains("spring and damper in space"));
    /// ```
    pub fn schema() -> String {
        let parts: Vec<Value> = Self::kinds().map(part).collect();
        let file = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": FORMAT,
            "type": "object",
            "required": ["format", "version", "parts", "left_out"],
            "additionalProperties": false,
            "properties": {
                "format": { "const": FORMAT },
                "version": { "enum": [OLD, VERSION] },
                "parts": { "type": "array", "items": { "oneOf": parts } },
                "left_out": { "type": "array", "items": { "type": "string" } },
            },
            "$defs": definitions(),
        });
        format!("{file:#}")
    }
}

/// The parts of one kind.
fn part(PartKind { name, entries }: PartKind) -> Value {
    let mut properties = Map::new();
    properties.insert("kind".into(), json!({ "const": name }));
    properties.insert("name".into(), text());
    // The event or coordinate that some parts belong to is their name.
    let others = || entries.iter().filter(|entry| entry.name != "name");
    properties.extend(others().map(|PartEntry { name, schema, .. }| (name.to_string(), schema.clone())));
    let required = others().filter(|entry| !entry.is_optional).map(|entry| entry.name);
    let required: Vec<&str> = ["kind", "name"].into_iter().chain(required).collect();
    json!({ "type": "object", "title": name, "properties": properties, "required": required, "additionalProperties": false })
}

fn definitions() -> Value {
    let body = json!({ "type": "string", "description": "The name of a body; the ground if it is missing." });
    let vector = list_of_length(reference("number"), 3);
    let named: Vec<&str> = SUMS.iter().map(|(name, _)| *name).collect();
    let at_one = ["node", "event", "after event"].map(|name| {
        json!({ "type": "object", "properties": { name: count() }, "required": [name], "additionalProperties": false })
    });
    let sum: Vec<Value> = [json!({ "enum": named })].into_iter().chain(at_one).collect();
    let term = json!({
        "type": "object", "required": ["coordinate", "factor"], "additionalProperties": false,
        "properties": { "coordinate": { "type": "string" }, "factor": reference("number") },
    });
    json!({
        "number": {
            "description": "A number, or a formula of design variables.",
            "anyOf": [{ "type": "number" }, { "type": "string" }],
        },
        "point": {
            "type": "object", "required": ["at"], "additionalProperties": false,
            "properties": { "body": body, "at": list_of_length(reference("number"), 2) },
        },
        "frame": { "type": "object", "properties": { "body": body }, "additionalProperties": false },
        "body in space": { "type": "object", "properties": { "body": body }, "additionalProperties": false },
        "marker": {
            "type": "object", "additionalProperties": false,
            "properties": { "body": body, "at": vector, "turned": vector, "along": vector, "toward": vector },
        },
        "axis": { "anyOf": [{ "type": "string" }, { "type": "array", "items": term }] },
        "sum": { "anyOf": sum },
    })
}
