//! The JSON Schema of scene files, generated from the table of kinds.

use serde_json::{Map, Value, json};

use super::SceneFile;
use super::formulas::{COST, ELEMENTS, EVENT, OF_FUNCTIONS, OUTPUT, SUMS, TERM};
use super::scene::{FORMAT, OLD, VERSION};
use super::writer::QUANTITIES;
use crate::planar::MOTIONS;
use crate::scene::kinds::kinds;
use crate::scene::ready::{Kind, Place, Sort};

/// The lists that a formula may read, of which `v`, `lambda` and others have no entry of their own.
const LISTS: [&str; 4] = ["q", "sigma", "u", "b"];

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
        let ready = kinds().map(|kind| part(kind.name, entries(kind)));
        let elements = ELEMENTS
            .into_iter()
            .map(|(name, _, lists)| part(name, of_formula(lists, &[("like", json!({ "type": "string" }), false)])));
        let sum = || ("sum", reference("sum"), true);
        let functions =
            [(COST, vec![sum()]), (TERM, vec![("output", json!({ "type": "string" }), true), sum()]), (EVENT, Vec::new())];
        let functions = functions.into_iter().map(|(name, more)| part(name, of_formula(OF_FUNCTIONS, &more)));
        let parts: Vec<Value> = ready.chain(elements).chain(functions).chain([part(OUTPUT, Vec::new())]).collect();
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

/// The name of an entry, its schema, and whether it is required.
type Entry = (&'static str, Value, bool);

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

fn names() -> Value {
    json!({ "type": "array", "items": { "type": "string" } })
}

fn list_of(items: Value, count: usize) -> Value {
    json!({ "type": "array", "items": items, "minItems": count, "maxItems": count })
}

/// The parts of one kind.
fn part(kind: &str, entries: Vec<Entry>) -> Value {
    let mut properties = Map::new();
    properties.insert("kind".into(), json!({ "const": kind }));
    properties.insert("name".into(), json!({ "type": "string" }));
    let required =
        ["kind", "name"].into_iter().chain(entries.iter().filter(|(.., is_required)| *is_required).map(|(name, ..)| *name));
    let required: Vec<&str> = required.collect();
    properties.extend(entries.into_iter().map(|(name, schema, _)| (name.to_string(), schema)));
    json!({ "type": "object", "title": kind, "properties": properties, "required": required, "additionalProperties": false })
}

fn entries(kind: &Kind) -> Vec<Entry> {
    let place = match kind.at {
        Place::Point => "point",
        Place::Frame => "frame",
        Place::Marker => "marker",
        Place::Body => "body in space",
    };
    let mut entries: Vec<Entry> = kind.places.iter().map(|name| (*name, reference(place), true)).collect();
    for list in kind.numbers.chunk_by(|a, b| a == b) {
        let number = reference("number");
        let schema = if list.len() == 1 { number } else { list_of(number, list.len()) };
        entries.push((list[0], schema, !kind.optional.contains(&list[0])));
    }
    entries.extend(kind.control.map(|name| (name, json!({ "type": "string" }), true)));
    if kind.moves {
        entries.push(("motion", json!({ "enum": MOTIONS.map(|(name, _)| name) }), true));
        entries.push(("parameters", json!({ "type": "array", "items": reference("number") }), true));
    }
    // What a part belongs to is its name.
    let others = kind.more.iter().filter(|(name, _)| *name != "name");
    entries.extend(others.map(|(name, sort)| (*name, of_sort(*sort), *sort != Sort::Flag)));
    entries
}

fn of_sort(sort: Sort) -> Value {
    match sort {
        Sort::Coordinate | Sort::Event | Sort::Equation => json!({ "type": "string" }),
        Sort::Equations | Sort::Names => names(),
        Sort::Axis => reference("axis"),
        Sort::Count => json!({ "type": "integer", "minimum": 0 }),
        Sort::Flag => json!({ "type": "boolean" }),
        Sort::Quantity => json!({ "enum": QUANTITIES.map(|(name, _)| name) }),
        Sort::Sum => reference("sum"),
        Sort::Number => json!({ "type": "number" }),
        Sort::Numbers(count) => list_of(json!({ "type": "number" }), count),
    }
}

/// The entries of a formula that may read these lists.
fn of_formula(lists: &[&str], more: &[Entry]) -> Vec<Entry> {
    let list = |name: &'static str| match name {
        "b" => (name, json!({ "type": "array", "items": reference("number") }), false),
        _ => (name, names(), false),
    };
    let is_read = |name: &&str| lists.contains(name) || *name == "sigma" && lists.contains(&"lambda");
    let formula = json!({ "anyOf": [{ "type": "string" }, names()] });
    let own = [("formula", formula, true), ("parts", names(), false), ("arguments", names(), false)];
    more.iter().cloned().chain(LISTS.into_iter().filter(is_read).map(list)).chain(own).collect()
}

fn definitions() -> Value {
    let body = json!({ "type": "string", "description": "The name of a body; the ground if it is missing." });
    let vector = list_of(reference("number"), 3);
    let named: Vec<&str> = SUMS.iter().map(|(name, _)| *name).collect();
    let at_one = ["node", "event", "after event"].map(|name| {
        json!({ "type": "object", "properties": { name: of_sort(Sort::Count) }, "required": [name], "additionalProperties": false })
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
            "properties": { "body": body, "at": list_of(reference("number"), 2) },
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
