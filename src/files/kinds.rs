//! [`PartKind`]: the kinds of parts that scene files can contain.

use serde_json::{Value, json};

use super::SceneFile;
use super::formulas::{COST, ELEMENTS, EVENT, OF_FUNCTIONS, OUTPUT, TERM};
use super::writer::QUANTITIES;
use crate::planar::MOTIONS;
use crate::scene::kinds::kinds;
use crate::scene::ready::{Kind, Place, Sort};

/// A kind of parts that a scene file can contain. Every part also has the entries `kind` and `name`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartKind {
    /// The entry `kind`.
    pub name: &'static str,
    /// The other entries.
    pub entries: Vec<PartEntry>,
}

/// An entry of a part in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartEntry {
    /// The name of the entry.
    pub name: &'static str,
    /// The content of the entry.
    pub what: String,
    /// True if the entry may be missing.
    pub is_optional: bool,
    /// The JSON Schema of the content.
    pub(super) schema: Value,
}

impl SceneFile {
    /// All kinds of parts with their entries.
    ///
    /// ```
    /// use hamiltonian_adjoint::SceneFile;
    ///
    /// let kind = SceneFile::kinds().find(|kind| kind.name == "spring and damper in space").expect("it exists");
    /// let names: Vec<&str> = kind.entries.iter().map(|entry| entry.name).collect();
    /// assert_eq!(names, ["a", "b", "stiffness", "free_length", "damping"]);
    /// ```
    pub fn kinds() -> impl Iterator<Item = PartKind> {
        let ready = kinds().map(|kind| PartKind { name: kind.name, entries: entries(kind) });
        let elements = ELEMENTS.into_iter().map(|(kind, _, lists)| (kind, [lists, &["like"]].concat()));
        let functions = [(COST, &["sum"][..]), (TERM, &["output", "sum"]), (EVENT, &[])];
        let functions = functions.map(|(kind, more)| (kind, [more, OF_FUNCTIONS].concat()));
        let of_formula = |(name, own): (&'static str, Vec<&str>)| {
            let has = |entry: &PartEntry| own.contains(&entry.name) || FORMULA.contains(&entry.name);
            PartKind { name, entries: of_formulas().into_iter().filter(has).collect() }
        };
        let output = PartKind { name: OUTPUT, entries: Vec::new() };
        ready.chain(elements.chain(functions).map(of_formula)).chain([output])
    }
}

/// The content of an entry in words, and its JSON Schema.
type Content = (String, Value);

/// The entries that every formula may have.
const FORMULA: [&str; 3] = ["formula", "parts", "arguments"];

/// The entries of all user-defined formulas.
fn of_formulas() -> [PartEntry; 10] {
    let formula = json!({ "anyOf": [text(), list_of(text())] });
    [
        entry("output", ("the name of an output", text()), false),
        entry("sum", content(Sort::Sum), false),
        entry("q", ("names of coordinates", list_of(text())), true),
        entry("sigma", content(Sort::Equations), true),
        entry("u", ("names of controls", list_of(text())), true),
        entry("b", ("numbers or formulas", list_of(reference("number"))), true),
        entry("like", ("the name of an element of the same kind, beside which this one is evaluated", text()), true),
        entry("formula", ("a formula, or a list of formulas", formula), false),
        entry("parts", ("formulas that precede it", list_of(text())), true),
        entry("arguments", ("the arguments of the formula in their order", list_of(text())), true),
    ]
}

fn entry(name: &'static str, (what, schema): (impl Into<String>, Value), is_optional: bool) -> PartEntry {
    PartEntry { name, what: what.into(), is_optional, schema }
}

/// The schema of what `$defs` contains under a name.
pub(super) fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

pub(super) fn text() -> Value {
    json!({ "type": "string" })
}

pub(super) fn count() -> Value {
    json!({ "type": "integer", "minimum": 0 })
}

fn list_of(items: Value) -> Value {
    json!({ "type": "array", "items": items })
}

pub(super) fn list_of_length(items: Value, length: usize) -> Value {
    json!({ "type": "array", "items": items, "minItems": length, "maxItems": length })
}

fn entries(kind: &Kind) -> Vec<PartEntry> {
    let (place, schema) = match kind.at {
        Place::Point => ("a point of a body in the plane, of a particle or of the ground", "point"),
        Place::Frame => ("a body in the plane, a particle or the ground", "frame"),
        Place::Marker => ("a marker of a body in space or of the ground", "marker"),
        Place::Body => ("a body in space", "body in space"),
    };
    let mut entries: Vec<PartEntry> =
        kind.places.iter().map(|name| entry(name, (place, reference(schema)), false)).collect();
    for list in kind.numbers.chunk_by(|a, b| a == b) {
        let (number, length) = (reference("number"), list.len());
        let content = match length {
            1 => ("a number or formula".into(), number),
            _ => (format!("{length} numbers or formulas"), list_of_length(number, length)),
        };
        entries.push(entry(list[0], content, kind.optional.contains(&list[0])));
    }
    entries.extend(kind.control.map(|name| entry(name, ("the name of a control", text()), false)));
    if kind.moves {
        let motions = json!({ "enum": MOTIONS.map(|(name, _)| name) });
        entries.push(entry("motion", ("the name of a function of time", motions), false));
        entries.push(entry("parameters", ("numbers or formulas", list_of(reference("number"))), false));
    }
    entries.extend(kind.more.iter().map(|(name, sort)| entry(name, content(*sort), *sort == Sort::Flag)));
    entries
}

fn content(sort: Sort) -> Content {
    let number = || json!({ "type": "number" });
    let (what, schema) = match sort {
        Sort::Numbers(length) => return (format!("{length} numbers"), list_of_length(number(), length)),
        Sort::Number => ("a number", number()),
        Sort::Names => ("a list of names", list_of(text())),
        Sort::Coordinate => ("the name of a coordinate", text()),
        Sort::Axis => ("the name of a coordinate, or a list of coordinates with factors", reference("axis")),
        Sort::Event => ("the name of an event", text()),
        Sort::Equation => ("the name of a constraint equation", text()),
        Sort::Equations => ("names of constraint equations", list_of(text())),
        Sort::Count => ("0, 1, 2 …", count()),
        Sort::Flag => ("true or false", json!({ "type": "boolean" })),
        Sort::Quantity => ("the name of a quantity of a marker", json!({ "enum": QUANTITIES.map(|(name, _)| name) })),
        Sort::Sum => ("the name of a rule of summation, or the number of a node or an event", reference("sum")),
    };
    (what.into(), schema)
}
