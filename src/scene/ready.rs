//! The parts of a scene as data, in the order in which they were added: the content of a scene file.

pub(crate) use super::kind::{Entry, Kind, Part, Place, Sort};
use crate::Scene;
use crate::model::{Control, Multiplier, Output, Param, Point};
#[cfg(feature = "files")]
use crate::model::{Coordinate, Event, Frame};

/// A part of a scene: ready-made, or a formula of the user.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "read only by `files`"))]
pub(crate) enum Added {
    Part(Part),
    /// A user-defined element: its batch, and its place there.
    Element((usize, usize)),
    /// A user-defined cost, term of an output or function of an event, by its number.
    Function(usize),
    /// A user-defined output.
    Output,
}

/// What parts can refer to.
#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "used only by `files`"))]
#[derive(Clone, Copy, Debug)]
pub(crate) enum Referred {
    Coordinate,
    Equation,
    Event,
    BodyInSpace,
    Output,
    Element,
}

/// How many of each the scene has.
pub(crate) type Sizes = [usize; 6];

/// The recorded parts of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Recipe {
    /// Parts with their names.
    pub(super) added: Vec<(String, Added)>,
    /// The sizes of the scene after each of them was added.
    sizes: Vec<Sizes>,
    within: bool,
}

impl Scene {
    /// Records a part that was added, unless it belongs to a ready-made part.
    pub(super) fn note(&mut self, name: &str, added: Added) {
        if !self.recipe.within {
            let sizes = self.sizes();
            self.recipe.added.push((name.to_string(), added));
            self.recipe.sizes.push(sizes);
        }
    }

    /// Records a ready-made part, and adds its elements.
    pub(super) fn noted(&mut self, name: &str, part: Part, add: impl FnOnce(&mut Self, &Part)) {
        let outside = std::mem::replace(&mut self.recipe.within, true);
        add(self, &part);
        self.recipe.within = outside;
        self.note(name, Added::Part(part));
    }

    fn sizes(&self) -> Sizes {
        let parts = &self.parts;
        let bodies = parts.sketch.space.all.len();
        [parts.coordinates.len(), parts.equations, parts.events.len(), bodies, parts.outputs.len(), self.elements.len()]
    }

    /// Adds a ready-made part.
    pub(crate) fn ready(&mut self, name: &str, part: Part) {
        self.check_part(name, &part);
        self.noted(name, part, |scene, part| (part.kind.add)(scene, name, part));
    }

    /// Adds a ready-made part between two points.
    pub(super) fn ready_between(
        &mut self,
        name: &str,
        kind: &'static Kind,
        points: [Point; 2],
        numbers: impl Into<Vec<Param>>,
    ) {
        self.ready(name, Part { points: points.to_vec(), numbers: numbers.into(), ..Part::of(kind) });
    }

    /// Adds a ready-made part between two points that is driven by a control.
    pub(super) fn ready_driven(&mut self, name: &str, kind: &'static Kind, points: [Point; 2], axis: &[Param], by: Control) {
        let (points, numbers, control) = (points.to_vec(), axis.to_vec(), Some(by));
        self.ready(name, Part { points, numbers, control, ..Part::of(kind) });
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

    /// Adds a ready-made part and returns its outputs.
    pub(super) fn ready_outputs<const N: usize>(&mut self, name: &str, part: Part) -> [Output; N] {
        let first = self.parts.outputs.len();
        self.ready(name, part);
        std::array::from_fn(|i| Output(self.parts.scene.handle(first + i)))
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

    pub(crate) fn event_name(&self, of: Event) -> &str {
        &self.parts.events[of.index()]
    }

    /// The name of a body or a particle in the plane.
    pub(crate) fn frame_name(&self, frame: Frame) -> Option<&str> {
        self.parts.sketch.bodies.iter().find(|(_, known)| *known == frame).map(|(name, _)| name.as_str())
    }

    pub(crate) fn name_of_body_in_space(&self, index: usize) -> &str {
        &self.parts.sketch.space.all[index].name
    }

    /// All parts with their names, in the order in which they were added.
    pub(crate) fn added(&self) -> &[(String, Added)] {
        &self.recipe.added
    }

    /// The sizes of the scene after each of them was added.
    pub(crate) fn sizes_after(&self) -> &[Sizes] {
        &self.recipe.sizes
    }
}
