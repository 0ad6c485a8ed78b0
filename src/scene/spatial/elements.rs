//! The elements of the energies of all trees.

use std::ops::Range;
use std::sync::Arc;

use super::formula::{Fixed, Follows, Numbers};
use super::path::{MarkerState, Path};
use super::tree::{Inertial, Kinetic, Node, Tree, Weight};
use crate::Error;
use crate::model::space::{self, Bodies, Carried, Following, Frame, Marker, Matrix, Moments, Motion, Vector};
use crate::model::{Coordinate, Param};
use crate::scene::Scene;

/// The coordinates and parameters of a formula, in the order in which it first needs them.
#[derive(Default)]
pub(super) struct Arguments {
    pub(super) q: Vec<Coordinate>,
    pub(super) b: Numbers,
}

impl Arguments {
    pub(super) fn fixed(&mut self, turn: Matrix, origin: Vector) -> Fixed {
        Fixed { turn: turn.map(|row| self.b.numbers(row)), origin: self.b.numbers(origin) }
    }

    pub(super) fn motion(&mut self, motion: &Motion<Following>) -> Motion<Follows> {
        match motion {
            Motion::Turn(axis, angle) => Motion::Turn(*axis, self.follows(angle)),
            Motion::Slide(axis, offset) => Motion::Slide(*axis, self.follows(offset)),
            Motion::Ball(e) => Motion::Ball(e.each_ref().map(|e| self.follows(e))),
        }
    }

    /// The coordinates among those of a scene.
    fn coordinates(&self, all: &[f64]) -> Vec<f64> {
        self.q.iter().map(|q| all[q.index()]).collect()
    }

    fn parameters(&self, value: &dyn Fn(Param) -> f64) -> Vec<f64> {
        self.b.0.iter().map(|param| value(*param)).collect()
    }

    fn follows(&mut self, of: &Following) -> Follows {
        let known = self.q.iter().position(|q| *q == of.coordinate);
        let q = known.unwrap_or_else(|| {
            self.q.push(of.coordinate);
            self.q.len() - 1
        });
        Follows { q, factor: self.b.number(of.factor), offset: self.b.number(of.offset) }
    }
}

/// The formulas of bodies.
impl Bodies {
    /// The path from the ground, or from another frame, to a marker.
    pub(super) fn path(&self, from: Option<usize>, to: &Carried, of: &mut Arguments) -> Path {
        let mut frame = |which: usize| {
            let Frame { turn, origin, motion, .. } = &self.frames[which];
            (of.fixed(*turn, *origin), of.motion(motion))
        };
        let frames = self.chain(from, to.frame).into_iter().map(&mut frame).collect();
        Path { frames, end: of.fixed(to.turn, to.origin) }
    }

    /// Position and motion of a marker.
    ///
    /// # Errors
    /// As [`fixed_at`](Self::fixed_at).
    pub(crate) fn state_of(
        &self,
        marker: Marker,
        value: &dyn Fn(Param) -> f64,
        [q, v, v_dot]: [&[f64]; 3],
    ) -> Result<MarkerState<f64>, Error> {
        let mut of = Arguments::default();
        let path = self.path(None, &self.fixed_at("a marker", marker, value)?, &mut of);
        let [q, v, v_dot] = [q, v, v_dot].map(|all| of.coordinates(all));
        Ok(path.state([&q, &v, &v_dot, &of.parameters(value)]))
    }

    /// Origin and axes of a marker with the coordinates `q` of the scene.
    pub(super) fn place_of(&self, at: &Carried, value: &dyn Fn(Param) -> f64, q: &[f64]) -> ([f64; 3], [[f64; 3]; 3]) {
        let mut of = Arguments::default();
        let path = self.path(None, at, &mut of);
        path.place(&of.coordinates(q), &of.parameters(value))
    }

    /// Origin and axes of a frame as a function of the coordinates.
    pub(crate) fn frame(&self, frame: usize, value: &dyn Fn(Param) -> f64) -> impl Fn(&[f64]) -> ([f64; 3], [[f64; 3]; 3]) {
        let mut of = Arguments::default();
        let path = self.path(None, &Carried::at_origin(Some(frame)), &mut of);
        let b = of.parameters(value);
        move |q| path.place(&of.coordinates(q), &b)
    }

    /// A tree, with its coordinates and parameters.
    fn tree(&self, frames: &[usize], gravity: [Param; 3]) -> (Tree, Arguments) {
        let mut of = Arguments::default();
        let (mut carried, mut weighted) = (vec![Param::from(0.0); frames.len()], vec![space::zero(); frames.len()]);
        let place = |which: usize| frames.partition_point(|frame| *frame < which);
        for (k, &which) in frames.iter().enumerate().rev() {
            let frame = &self.frames[which];
            carried[k] = space::plus(carried[k], frame.moments.mass);
            weighted[k] = space::add(weighted[k], frame.moments.first);
            if let Some(parent) = frame.parent.map(place) {
                carried[parent] = space::plus(carried[parent], carried[k]);
                weighted[parent] = space::add(weighted[parent], space::scaled(frame.origin, carried[k]));
            }
        }
        let node = |(k, &which): (usize, &usize)| {
            let Frame { parent, turn, origin, motion, moments: Moments { mass, first, second } } = &self.frames[which];
            Node {
                parent: parent.map(place),
                fixed: of.fixed(*turn, *origin),
                motion: of.motion(motion),
                body: Inertial { mass: of.b.number(*mass), first: of.b.numbers(*first), second: of.b.numbers(*second) },
                weighted: of.b.numbers(weighted[k]),
                carried: of.b.number(carried[k]),
            }
        };
        let nodes = Arc::new(frames.iter().enumerate().map(node).collect());
        (Tree { nodes, gravity: of.b.numbers(gravity) }, of)
    }
}

impl Scene {
    /// Adds the elements of all bodies in space.
    ///
    /// # Errors
    /// A body that no joint carries.
    pub(in crate::scene) fn add_trees(&mut self) -> Result<(), Error> {
        let bodies = std::mem::take(&mut self.parts.sketch.space);
        if let Some(body) = bodies.all.iter().find(|body| body.carried.is_none()) {
            return Err(Error::NoJoint { body: body.name.clone() });
        }
        self.place_cuts(&bodies);
        let gravity = self.parts.gravity.map(|g| g.unwrap_or(0.0.into()));
        let has_weight = gravity.iter().any(|g| g.constant() != Some(0.0));
        // Frames of bodies in the plane, whose energies are elements of their own, may carry nothing.
        let is_heavy = |frames: &Vec<usize>| frames.iter().any(|frame| !bodies.frames[*frame].moments.are_none());
        for frames in bodies.trees().into_iter().filter(is_heavy) {
            let (tree, Arguments { q, b }) = bodies.tree(&frames, gravity);
            let name = bodies.first_of(&frames);
            self.list_kinetic_energy(&format!("motion of {name}"), Kinetic(tree.clone()), &q, &b.0);
            if has_weight {
                self.list_potential_energy(&format!("weight of {name}"), Weight(tree), &q, &b.0);
            }
            self.join_groups(&q);
        }
        self.parts.sketch.space = bodies;
        Ok(())
    }

    /// Joins the groups of coordinates of a tree that follow each other to one group, which is eliminated as a whole.
    fn join_groups(&mut self, q: &[Coordinate]) {
        let mut is_own = vec![false; self.parts.coordinates.len()];
        q.iter().for_each(|q| is_own[q.index()] = true);
        let in_tree = |range: &Range<usize>| is_own[range.clone()].iter().all(|is_own| *is_own);
        let groups = std::mem::take(&mut self.parts.groups);
        let mut joined: Vec<(String, Range<usize>)> = Vec::with_capacity(groups.len());
        for (name, range) in groups {
            match joined.last_mut().filter(|(_, last)| last.end == range.start && in_tree(last) && in_tree(&range)) {
                Some((_, last)) => last.end = range.end,
                None => joined.push((name, range)),
            }
        }
        self.parts.groups = joined;
    }
}
