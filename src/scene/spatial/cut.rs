//! Cuts of long chains into pieces.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::elements::Arguments;
use super::formula::minus;
use super::path::Path;
use super::quaternion::{Orientation, seen_from};
use super::{Body, Spatial};
use crate::model::space::{Bodies, Carried, Cut, Moments, Motion};
use crate::scene::Scene;
use crate::scene::ready::{Kind, Part, Place};
use crate::{Error, ListConstraint, Scalar};

/// The weld of both halves of a cut body: the pose of the second half relative to the last frame `base` that can turn freely must be that of the first.
struct Weld {
    base: Path,
    first: Path,
    second: Path,
    turns: [Orientation; 3],
}

impl ListConstraint for Weld {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], _t: S, phi: &mut [S]) {
        let (first, _) = self.first.place(q, b);
        let (second, _) = self.second.place(q, b);
        let position = minus(self.base.inward(second, q, b), first);
        let [base, first, second] = self.turns.each_ref().map(|turn| turn.at(q, b));
        let [_, turn @ ..] = seen_from(first, seen_from(base, second));
        phi.iter_mut().zip(position.into_iter().chain(turn)).for_each(|(phi, value)| *phi = value);
    }
}

pub(super) static CUT: Kind = Kind {
    at: Place::Body,
    ..Kind::of_markers("cut", &[], |scene, name, part| scene.spatial().cut_at(name, part.markers[0].body)).at(&["body"])
};

impl Spatial<'_> {
    /// Cuts a chain of joints at a body, so that the time of a step grows with the number of pieces and not with the square of the number of joints.
    ///
    /// Half of the body, with the name of the cut, stays where it is. The other half moves freely, with seven coordinates and |e| = 1, and a weld of six
    /// equations holds both halves together. The motion does not change. Joints and other parts that are attached to the body afterwards belong to the
    /// second half. The body needs mass and moments of inertia. Cut chains of more than about 50 joints at every sixth body; the time to compile is less
    /// from about 40 joints.
    ///
    /// [`System::initial_coordinates`](crate::System::initial_coordinates) contains coordinates of the second half that fit those of the joints. For
    /// another start give a guess, and [hold](crate::Start::hold) the coordinates of the joints in [`Start::assembled`](crate::Start::assembled).
    pub fn cut(&mut self, name: &str, body: Body) {
        self.scene.ready(name, Part::at_markers(&CUT, &[body.origin()], &[]));
    }

    fn cut_at(&mut self, name: &str, body: Body) {
        let Some(at) = self.fixed_at(name, body.origin()) else { return };
        let (Body(Some(whole)), Some(frame)) = (body, at.frame) else {
            return self.scene.report(Error::NothingToCut { cut: name.into() });
        };
        let half = self.scene.parts.sketch.space.all[whole.index].inertia.halved();
        let first = self.scene.add_body_in_space(name, half);
        let (free, motions) = self.free_motions(name);
        let space = &mut self.scene.parts.sketch.space;
        space.all[first].carried = Some(at);
        space.all[whole.index].inertia = half;
        space.frames[frame].moments.subtract(&Moments::of(&half, at.turn, at.origin));
        let second = space.add_frames(Carried::at_origin(None), motions);
        space.carry(whole.index, second);
        space.cuts.push(Cut { first: at, free });
        self.weld(&format!("{name} (weld)"), at, second);
    }

    fn weld(&mut self, name: &str, first: Carried, second: Carried) {
        let (value, bodies, mut of) = (self.scene.present_values(), &self.scene.parts.sketch.space, Arguments::default());
        let can_turn = |frame: &usize| matches!(bodies.frames[*frame].motion, Motion::Ball(_));
        let base = bodies.chain(None, first.frame).into_iter().rfind(can_turn);
        let all = [(None, Carried::at_origin(base)), (base, first), (None, second)];
        let [base, first, second] = all.map(|(from, to)| bodies.path(from, &to, &mut of));
        let turns = all.map(|(from, to)| bodies.orientation(from, &to, &value, &mut of));
        self.scene.list_constraint(name, Weld { base, first, second, turns }, 6, &of.q, &of.b.0);
    }
}

impl Scene {
    /// Places the second halves of cut bodies at the first ones.
    pub(super) fn place_cuts(&mut self, bodies: &Bodies) {
        let value = self.present_values();
        for Cut { first, free } in &bodies.cuts {
            let (origin, [x, y, z]) = bodies.place_of(first, &value, &self.parts.initial);
            let axes = Matrix3::from_columns(&[x.into(), y.into(), z.into()]);
            let e = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
            let places = origin.into_iter().chain([e.w, e.i, e.j, e.k]);
            for (coordinate, place) in free.iter().zip(places) {
                self.parts.initial[coordinate.index()] = place;
            }
        }
    }
}
