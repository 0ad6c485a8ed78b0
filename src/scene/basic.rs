//! Coordinates, controls, design variables, initial values and gravity of a scene.

use super::Scene;
use super::ready::{Entry, Kind, Part, Sort};
use crate::model::{Control, Coordinate, Design, Param};

static COORDINATES: Kind = Kind::new("coordinates", &[], |scene, group, part| {
    let (first, names) = (scene.parts.coordinates.len(), part.names());
    scene.parts.scene.begin_part();
    scene.parts.coordinates.extend(names.iter().map(|name| format!("{group}.{name}")));
    scene.parts.initial.resize(first + names.len(), 0.0);
    scene.parts.groups.push((group.to_string(), first..first + names.len()));
})
.with(&[("coordinates", Sort::Names)]);

static INITIAL_VALUE: Kind = Kind::new("initial value", &[], |scene, _, part| {
    scene.parts.initial[part.coordinate().index()] = part.fixed_numbers()[0];
})
.with(&[("name", Sort::Coordinate), ("value", Sort::Number)]);

static CONTROL: Kind = Kind::new("control", &[], |scene, name, _| {
    scene.parts.scene.begin_part();
    scene.parts.controls.push(name.to_string());
});

static DESIGN: Kind = Kind::new("design variable", &[], |scene, name, part| {
    scene.parts.scene.begin_part();
    scene.parts.designs.push((name.to_string(), part.fixed_numbers()[0]));
})
.with(&[("value", Sort::Number)]);

static GRAVITY: Kind = Kind {
    optional: &["z"],
    ..Kind::new("gravity", &["x", "y", "z"], |scene, name, part| {
        if scene.check_params(name, &part.numbers) {
            scene.parts.gravity = part.numbers_from(0).map(Some);
        }
    })
};

/// The kinds of what belongs to no body.
#[cfg(feature = "files")]
pub(super) static KINDS: [&Kind; 5] = [&COORDINATES, &INITIAL_VALUE, &CONTROL, &DESIGN, &GRAVITY];

impl Scene {
    /// Adds generalized coordinates that belong together (a body, a whole mechanism), in m or rad.
    ///
    /// The coordinates of a group are eliminated together in the linear solves, so put closely coupled coordinates into one group.
    pub fn coordinates<const N: usize>(&mut self, group: &str, names: [&str; N]) -> [Coordinate; N] {
        let first = self.coordinate_group(group, &names);
        self.handles(first)
    }

    /// The coordinates from the number `first` on.
    pub(super) fn handles<const N: usize>(&self, first: usize) -> [Coordinate; N] {
        std::array::from_fn(|i| Coordinate(self.parts.scene.handle(first + i)))
    }

    /// Adds a group of coordinates and returns the number of the first.
    pub(crate) fn coordinate_group(&mut self, group: &str, names: &[&str]) -> usize {
        let first = self.parts.coordinates.len();
        let names = names.iter().map(|name| name.to_string()).collect();
        self.ready(group, Part { more: vec![Entry::Names(names)], ..Part::of(&COORDINATES) });
        first
    }

    /// Sets the initial value of a coordinate, m or rad ([`System::initial_coordinates`](crate::System::initial_coordinates)).
    pub fn place(&mut self, coordinate: Coordinate, value: f64) {
        if self.check("the initial coordinates", "coordinate", [coordinate.0]) {
            let name = self.parts.coordinates[coordinate.index()].clone();
            let more = vec![Entry::Coordinate(coordinate), Entry::Numbers(vec![value])];
            self.ready(&name, Part { more, ..Part::of(&INITIAL_VALUE) });
        }
    }

    /// The initial value of a coordinate, m or rad; NaN for a coordinate of another scene.
    pub fn initial(&self, coordinate: Coordinate) -> f64 {
        if self.parts.scene.owns(&coordinate.0) { self.parts.initial[coordinate.0.index] } else { f64::NAN }
    }

    /// Adds a control channel.
    pub fn control(&mut self, name: &str) -> Control {
        self.ready(name, Part::of(&CONTROL));
        Control(self.parts.scene.handle(self.parts.controls.len() - 1))
    }

    /// Adds a design variable with its value; use its handle instead of a number in elements.
    pub fn design(&mut self, name: &str, value: f64) -> Design {
        self.ready(name, Part { more: vec![Entry::Numbers(vec![value])], ..Part::of(&DESIGN) });
        Design(self.parts.scene.handle(self.parts.designs.len() - 1))
    }

    pub(crate) fn set_gravity(&mut self, gravity: [Param; 3]) {
        self.ready("gravity", Part { numbers: gravity.to_vec(), ..Part::of(&GRAVITY) });
    }
}
