//! The parts of a scene as data, in the order in which they were added: the content of a scene file.

use crate::Scene;
use crate::model::{Control, Coordinate, Frame, Multiplier, Param, Point};

/// A part of a scene: ready-made, or a formula of the user.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "read only by `files`"))]
pub(crate) enum Added {
    Control,
    Design(f64),
    /// The names of the coordinates of a group, without the name of the group.
    Coordinates(Vec<String>),
    /// The initial value of a coordinate.
    Place(Coordinate, f64),
    /// Gravity along x, y and z, m/s².
    Gravity([Param; 3]),
    /// Mass and moment of inertia; x, y, φ.
    Body([Param; 2], [f64; 3]),
    /// Mass; x, y.
    Particle(Param, [f64; 2]),
    Part(Part),
    Cost(ReadyCost),
    /// A user-defined element: its batch, and its place there.
    Element((usize, usize)),
    /// A user-defined cost, term of an output or function of an event, by its number.
    Function(usize),
    /// A user-defined output.
    Output,
}

/// A ready-made cost or output.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "read only by `files`"))]
pub(crate) enum ReadyCost {
    Effort { control: Control, weight: Param },
    Time { weight: Param },
    EndState { coordinate: Coordinate },
    Reading { coordinate: Coordinate, node: usize, value: f64, weight: f64 },
}

/// A part between two frames.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) kind: &'static Kind,
    /// Points, as many as the kind has places; a frame without a point is represented by its origin.
    pub(crate) points: Vec<Point>,
    pub(crate) numbers: Vec<Param>,
    pub(crate) control: Option<Control>,
    /// Name and parameters of a ready-made function of time.
    pub(crate) motion: Option<(&'static str, Vec<Param>)>,
}

impl Part {
    /// The number `i`.
    pub(crate) fn number(&self, i: usize) -> Param {
        self.numbers[i]
    }

    /// Both points.
    pub(crate) fn both(&self) -> [Point; 2] {
        [self.points[0], self.points[1]]
    }

    /// The control that drives the part, for kinds that have a control.
    pub(crate) fn by(&self) -> [Control; 1] {
        self.control.map_or_else(|| unreachable!("a part of this kind has a control"), |control| [control])
    }

    /// The frames of both points.
    pub(crate) fn frames(&self) -> (Frame, Frame) {
        (self.points[0].frame, self.points[1].frame)
    }
}

/// A kind of ready-made parts.
#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "read only by `files`"))]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Names of the places at which the part is attached.
    pub(crate) places: &'static [&'static str],
    /// True if the places are points, false if they are frames.
    pub(crate) at_points: bool,
    /// Names of the numbers.
    pub(crate) numbers: &'static [&'static str],
    /// Name of the control, if there is one.
    pub(crate) control: Option<&'static str>,
    /// True if the part depends on a function of time.
    pub(crate) moves: bool,
    /// Adds the elements of a part. As a function of this crate it is compiled once, for all programs that use it.
    pub(crate) add: fn(&mut Scene, &str, &Part),
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Kind {
    /// A kind between a point of a and a point of b.
    pub(crate) const fn of_points(
        name: &'static str,
        numbers: &'static [&'static str],
        add: fn(&mut Scene, &str, &Part),
    ) -> Self {
        Kind { name, places: &["a", "b"], at_points: true, numbers, control: None, moves: false, add }
    }

    /// A kind between the frames a and b.
    pub(crate) const fn of_frames(
        name: &'static str,
        numbers: &'static [&'static str],
        add: fn(&mut Scene, &str, &Part),
    ) -> Self {
        Kind { at_points: false, ..Kind::of_points(name, numbers, add) }
    }

    pub(crate) const fn driven_by(self, control: &'static str) -> Self {
        Kind { control: Some(control), ..self }
    }

    pub(crate) const fn moving(self) -> Self {
        Kind { moves: true, ..self }
    }

    pub(crate) const fn at(self, places: &'static [&'static str]) -> Self {
        Kind { places, ..self }
    }
}

/// The recorded parts of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Recipe {
    /// Parts with their names.
    pub(super) added: Vec<(String, Added)>,
    /// Names of parts that a file cannot store.
    pub(super) own: Vec<String>,
    within: bool,
}

impl Recipe {
    pub(super) fn note(&mut self, name: &str, added: impl FnOnce() -> Added) {
        if !self.within {
            self.added.push((name.to_string(), added()));
        }
    }

    pub(super) fn note_own(&mut self, name: &str) {
        if !self.within {
            self.own.push(name.to_string());
        }
    }
}

impl Scene {
    /// Records a ready-made part, and adds its elements.
    pub(super) fn noted<R>(&mut self, name: &str, added: Added, add: impl FnOnce(&mut Self, &Added) -> R) -> R {
        let outside = std::mem::replace(&mut self.recipe.within, true);
        let result = add(self, &added);
        self.recipe.within = outside;
        self.recipe.note(name, || added);
        result
    }

    /// Adds a ready-made part.
    pub(crate) fn ready(&mut self, name: &str, part: Part) {
        self.check_part(name, &part);
        self.noted(name, Added::Part(part), |scene, added| {
            if let Added::Part(part) = added {
                (part.kind.add)(scene, name, part);
            }
        });
    }

    /// Adds a ready-made part between two points.
    pub(super) fn ready_between(
        &mut self,
        name: &str,
        kind: &'static Kind,
        points: [Point; 2],
        numbers: impl Into<Vec<Param>>,
    ) {
        self.ready(name, Part { kind, points: points.to_vec(), numbers: numbers.into(), control: None, motion: None });
    }

    /// Adds a ready-made part between two points that is driven by a control.
    pub(super) fn ready_driven(&mut self, name: &str, kind: &'static Kind, points: [Point; 2], axis: &[Param], by: Control) {
        self.ready(name, Part { kind, points: points.to_vec(), numbers: axis.to_vec(), control: Some(by), motion: None });
    }

    /// Adds a ready-made joint and returns its multipliers.
    pub(super) fn ready_joint<const M: usize>(
        &mut self,
        name: &str,
        kind: &'static Kind,
        points: [Point; 2],
        numbers: impl Into<Vec<Param>>,
    ) -> [Multiplier; M] {
        self.multipliers_of(|scene| scene.ready_between(name, kind, points, numbers))
    }

    /// The multipliers of the equations added by `add`.
    pub(super) fn multipliers_of<const M: usize>(&mut self, add: impl FnOnce(&mut Self)) -> [Multiplier; M] {
        let first = self.parts.equations;
        add(self);
        match self.parts.equations == first + M {
            true => self.multipliers(first),
            false => self.no_multipliers(),
        }
    }
}

/// Access for scene files.
#[cfg(feature = "files")]
impl Scene {
    /// The first error found.
    pub(crate) fn problem(&self) -> Option<&crate::Error> {
        self.problem.as_ref()
    }

    pub(crate) fn design_names(&self) -> Vec<&str> {
        self.parts.designs.iter().map(|(name, _)| name.as_str()).collect()
    }

    pub(crate) fn coordinate_names(&self) -> &[String] {
        &self.parts.coordinates
    }

    pub(crate) fn control_names(&self) -> &[String] {
        &self.parts.controls
    }

    pub(crate) fn coordinate_name(&self, of: Coordinate) -> &str {
        &self.parts.coordinates[of.index()]
    }

    pub(crate) fn control_name(&self, of: Control) -> &str {
        &self.parts.controls[of.index()]
    }

    /// Bodies and particles with their names.
    pub(crate) fn sketched(&self) -> impl Iterator<Item = (&str, Frame)> {
        self.parts.sketch.bodies.iter().map(|(name, frame)| (name.as_str(), *frame))
    }

    /// All parts with their names, in the order in which they were added.
    pub(crate) fn added(&self) -> &[(String, Added)] {
        &self.recipe.added
    }

    /// Names of parts that a file cannot store.
    pub(crate) fn own(&self) -> &[String] {
        &self.recipe.own
    }
}
