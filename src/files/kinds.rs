//! [`PartKind`]: the kinds of parts that scene files can contain.

use super::SceneFile;
use super::formulas::{COST, ELEMENTS, EVENT, OUTPUT, TERM};
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
        let functions = [
            (COST, vec!["sum", "q", "sigma", "u", "b"]),
            (TERM, vec!["output", "sum", "q", "sigma", "u", "b"]),
            (EVENT, vec!["q", "sigma", "u", "b"]),
        ];
        let of_formula = |(name, entries): (&'static str, Vec<&str>)| {
            let all = [entries, vec!["formula", "parts", "arguments"]].concat();
            let has = |(known, ..): &(&str, &str, bool)| all.contains(known);
            let entries = FORMULA.into_iter().filter(has).map(|(name, what, is_optional)| entry(name, what, is_optional));
            PartKind { name, entries: entries.collect() }
        };
        let output = PartKind { name: OUTPUT, entries: Vec::new() };
        ready.chain(elements.chain(functions).map(of_formula)).chain([output])
    }
}

/// The entries of user-defined formulas, and whether they may be missing.
const FORMULA: [(&str, &str, bool); 10] = [
    ("output", "the name of an output", false),
    ("sum", "the name of a rule of summation, or the number of a node or an event", false),
    ("q", "names of coordinates", true),
    ("sigma", "names of constraint equations", true),
    ("u", "names of controls", true),
    ("b", "numbers or formulas", true),
    ("like", "the name of an element with the same formula", true),
    ("formula", "a formula, or a list of formulas", false),
    ("parts", "formulas that precede it", true),
    ("arguments", "the arguments of the formula in their order", true),
];

fn entry(name: &'static str, what: &str, is_optional: bool) -> PartEntry {
    PartEntry { name, what: what.into(), is_optional }
}

fn entries(kind: &Kind) -> Vec<PartEntry> {
    let place = match kind.at {
        Place::Point => "a point of a body in the plane, of a particle or of the ground",
        Place::Frame => "a body in the plane, a particle or the ground",
        Place::Marker => "a marker of a body in space or of the ground",
        Place::Body => "a body in space",
    };
    let mut entries: Vec<PartEntry> = kind.places.iter().map(|name| entry(name, place, false)).collect();
    for list in kind.numbers.chunk_by(|a, b| a == b) {
        let what =
            if list.len() == 1 { "a number or formula".into() } else { format!("{} numbers or formulas", list.len()) };
        entries.push(entry(list[0], &what, kind.optional.contains(&list[0])));
    }
    entries.extend(kind.control.map(|name| entry(name, "the name of a control", false)));
    if kind.moves {
        entries.push(entry("motion", "the name of a function of time", false));
        entries.push(entry("parameters", "numbers or formulas", false));
    }
    entries.extend(kind.more.iter().map(|(name, sort)| entry(name, &what(*sort), *sort == Sort::Flag)));
    entries
}

fn what(sort: Sort) -> String {
    let what = match sort {
        Sort::Numbers(count) => return format!("{count} numbers"),
        Sort::Number => "a number",
        Sort::Names => "a list of names",
        Sort::Coordinate => "the name of a coordinate",
        Sort::Axis => "the name of a coordinate, or a list of coordinates with factors",
        Sort::Event => "the name of an event",
        Sort::Equation => "the name of a constraint equation",
        Sort::Equations => "names of constraint equations",
        Sort::Count => "0, 1, 2 …",
        Sort::Flag => "true or false",
        Sort::Quantity => "the name of a quantity of a marker",
        Sort::Sum => "the name of a rule of summation, or the number of a node or an event",
    };
    what.into()
}
