//! The parts of a scene by their names.

use super::{EndState, Scene};
use crate::model::space::Body;
use crate::model::{Control, Coordinate, Design, Event, Frame, Multiplier, Output};

impl Scene {
    /// The design variable with the given name.
    pub fn design_named(&self, name: &str) -> Option<Design> {
        let at = self.parts.designs.iter().position(|(known, _)| known == name)?;
        Some(Design(self.parts.scene.handle(at)))
    }

    /// The control with the given name.
    pub fn control_named(&self, name: &str) -> Option<Control> {
        let at = self.parts.controls.iter().position(|known| known == name)?;
        Some(Control(self.parts.scene.handle(at)))
    }

    /// The coordinate with the given name, preceded by that of its group: `rod.x`.
    pub fn coordinate_named(&self, name: &str) -> Option<Coordinate> {
        let at = self.parts.coordinates.iter().position(|known| known == name)?;
        Some(Coordinate(self.parts.scene.handle(at)))
    }

    /// The output with the given name.
    pub fn output_named(&self, name: &str) -> Option<Output> {
        let at = self.parts.outputs.iter().position(|known| known == name)?;
        Some(Output(self.parts.scene.handle(at)))
    }

    /// The event with the given name.
    pub fn event_named(&self, name: &str) -> Option<Event> {
        let at = self.parts.events.iter().position(|known| known == name)?;
        Some(Event(self.parts.scene.handle(at)))
    }

    /// The outputs of [`end_state`](Self::end_state) of a coordinate; `None` if the scene does not have them.
    pub fn end_state_of(&self, coordinate: Coordinate) -> Option<EndState> {
        let of = self.parts.scene.owns(&coordinate.0).then(|| &self.parts.coordinates[coordinate.index()])?;
        let [position, rate] = EndState::names(of).map(|name| self.output_named(&name));
        Some(EndState { coordinate, position: position?, rate: rate? })
    }

    /// The multipliers of the constraint or joint with the given name.
    pub fn multipliers_named(&self, name: &str) -> Option<Vec<Multiplier>> {
        let at = self.parts.constraints.iter().position(|(known, _)| known == name)?;
        let first: usize = self.parts.constraints[..at].iter().map(|(_, count)| count).sum();
        let equations = first..first + self.parts.constraints[at].1;
        Some(equations.map(|equation| Multiplier(self.parts.scene.handle(equation))).collect())
    }

    /// The body in space with the given name.
    pub fn body_in_space_named(&self, name: &str) -> Option<Body> {
        let at = self.parts.sketch.space.all.iter().position(|body| body.name == name)?;
        Some(Body(Some(self.parts.scene.handle(at))))
    }

    /// The frame of the body or particle in the plane with the given name.
    pub fn frame_named(&self, name: &str) -> Option<Frame> {
        self.parts.sketch.bodies.iter().find(|(known, _)| known == name).map(|(_, frame)| *frame)
    }
}
