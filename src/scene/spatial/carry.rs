//! Joints carry bodies; markers are fixed where their bodies are.

use super::Spatial;
use crate::Error;
use crate::model::space::{self, Body, BodyPart, Carried, Following, Joint, Marker, Motion};
use crate::model::{Coordinate, Param};
use crate::scene::Scene;
use crate::scene::ready::Part;

impl Spatial<'_> {
    /// Adds a joint and returns its coordinates.
    pub(super) fn joint<const N: usize>(&mut self, name: &str, part: Part) -> [Coordinate; N] {
        let first = self.scene.parts.coordinates.len();
        self.scene.ready(name, part);
        self.scene.handles(first)
    }

    /// Lets a joint carry the body of its second marker.
    pub(super) fn join(&mut self, name: &str, part: &Part, motions: Vec<Motion<Following>>) {
        let [a, b] = part.pair();
        if !self.scene.check_marker(name, b) {
            return;
        }
        let Body(Some(body)) = b.body() else { return self.scene.report(Error::CarriesGround { joint: name.into() }) };
        if a.body() == b.body() {
            return self.scene.report(Error::NoBody { element: name.into() });
        }
        let Some(outer) = self.fixed_at(name, a) else { return };
        let scene = &mut *self.scene;
        let inner = match b.axes.checked_rotation(name, &|param| scene.present_value(param)) {
            Ok(inner) => inner,
            Err(error) => return scene.report(error),
        };
        let space = &mut scene.parts.sketch.space;
        let BodyPart { name: own, carried, .. } = &space.all[body.index];
        if carried.is_some() {
            let first = space.joints.iter().find(|joint| joint.body == body.index).map_or(own, |joint| &joint.name);
            let (joint, first, body) = (name.into(), first.clone(), own.clone());
            return scene.report(Error::SecondJoint { joint, first, body });
        }
        // The frame of the body from the marker.
        let back = space::transposed(inner);
        let origin = space::negated(space::apply(back, b.at));
        let first = space.frames.len();
        let carried = space.add_frames(outer, motions).inner(back, origin);
        space.carry(body.index, carried);
        space.joints.push(Joint { name: name.into(), body: body.index, frames: first..space.frames.len() });
    }

    /// Where a marker is fixed; `None` after an error was reported.
    pub(super) fn fixed_at(&mut self, part: &str, marker: Marker) -> Option<Carried> {
        let scene = &mut *self.scene;
        if !scene.check_marker(part, marker) {
            return None;
        }
        let at = scene.parts.sketch.space.fixed_at(part, marker, &|param| scene.present_value(param));
        at.map_err(|error| scene.report(error)).ok()
    }
}

impl Scene {
    /// The coordinate of a dependent joint.
    pub(super) fn following(&mut self, name: &str, part: &Part) -> Following {
        let (coordinate, [factor, offset]) = (part.coordinate(), part.numbers_from(0));
        self.check(name, "coordinate", [coordinate.0]);
        self.check_params(name, &[factor, offset]);
        Following { coordinate, factor, offset }
    }

    fn check_marker(&mut self, part: &str, marker: Marker) -> bool {
        self.check(part, "body", marker.body().0) && self.check_params(part, &marker.params())
    }

    /// The value of a parameter for the design variables of the scene.
    fn present_value(&self, param: Param) -> f64 {
        param.constant().unwrap_or_else(|| self.present_values()(param))
    }

    /// The values of all parameters for the design variables of the scene.
    pub(super) fn present_values(&self) -> impl Fn(Param) -> f64 + use<> {
        let designs: Vec<f64> = self.parts.designs.iter().map(|(_, value)| *value).collect();
        let expressions = self.parts.scene.expressions().evaluate(&[], &designs);
        move |param| param.present_value(&designs, &expressions)
    }
}
