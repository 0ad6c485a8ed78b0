//! The elements of the energies of all trees.

use std::ops::Range;
use std::sync::Arc;

use super::formula::{Fixed, Follows, Motion, Numbers};
use super::inertia::Moments;
use super::parts::{Bodies, Carried, Following, Frame};
use super::path::Path;
use super::tree::{Inertial, Kinetic, Node, Tree, Weight};
use super::vectors;
use crate::Error;
use crate::model::{Coordinate, Param};
use crate::scene::Scene;

/// The coordinates and parameters of a formula, in the order in which it first needs them.
#[derive(Default)]
pub(super) struct Arguments {
    pub(super) q: Vec<Coordinate>,
    pub(super) b: Numbers,
}

impl Arguments {
    pub(super) fn fixed(&mut self, turn: vectors::Matrix, origin: vectors::Vector) -> Fixed {
        Fixed { turn: turn.map(|row| self.b.numbers(row)), origin: self.b.numbers(origin) }
    }

    pub(super) fn motion(&mut self, motion: &Motion<Following>) -> Motion<Follows> {
        match motion {
            Motion::Turn(axis, angle) => Motion::Turn(*axis, self.follows(angle)),
            Motion::Slide(axis, offset) => Motion::Slide(*axis, self.follows(offset)),
            Motion::Ball(e) => Motion::Ball(e.each_ref().map(|e| self.follows(e))),
        }
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

    /// A tree, with its coordinates and parameters.
    fn tree(&self, frames: &[usize], gravity: [Param; 3]) -> (Tree, Arguments) {
        let mut of = Arguments::default();
        let (mut carried, mut weighted) = (vec![Param::from(0.0); frames.len()], vec![vectors::zero(); frames.len()]);
        let place = |which: usize| frames.partition_point(|frame| *frame < which);
        for (k, &which) in frames.iter().enumerate().rev() {
            let frame = &self.frames[which];
            carried[k] = vectors::plus(carried[k], frame.moments.mass);
            weighted[k] = vectors::add(weighted[k], frame.moments.first);
            if let Some(parent) = frame.parent.map(place) {
                carried[parent] = vectors::plus(carried[parent], carried[k]);
                weighted[parent] = vectors::add(weighted[parent], vectors::scaled(frame.origin, carried[k]));
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
        let bodies = std::mem::take(&mut self.space);
        if let Some(body) = bodies.all.iter().find(|body| body.carried.is_none()) {
            return Err(Error::NoJoint { body: body.name.clone() });
        }
        let gravity = self.parts.gravity.map(|g| g.unwrap_or(0.0.into()));
        let has_weight = gravity.iter().any(|g| g.constant() != Some(0.0));
        for frames in bodies.trees() {
            let (tree, Arguments { q, b }) = bodies.tree(&frames, gravity);
            let name = bodies.first_of(&frames);
            self.list_kinetic_energy(name, Kinetic(tree.clone()), &q, &b.0);
            if has_weight {
                self.list_potential_energy(&format!("weight of {name}"), Weight(tree), &q, &b.0);
            }
            self.join_groups(&q);
        }
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
