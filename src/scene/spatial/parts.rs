//! The bodies of a scene in space, the frames of their joints, and where bodies and markers are fixed.

use super::Inertia;
use super::formula::Motion;
use super::inertia::Moments;
use super::vectors::{self, Matrix, Vector};
use crate::model::{Coordinate, Param};

/// A body.
#[derive(Clone, Debug)]
pub(in crate::scene) struct BodyPart {
    pub(super) name: String,
    pub(super) inertia: Inertia,
    /// The joint that carries it, and where it is fixed; `None` until the joint is added.
    pub(super) carried: Option<(String, Carried)>,
}

/// A frame that moves relative to its parent, by a fixed rotation and origin and then by a motion.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Frame {
    /// The number of the parent; `None` for the ground.
    pub(super) parent: Option<usize>,
    pub(super) turn: Matrix,
    pub(super) origin: Vector,
    pub(super) motion: Motion<Following>,
    /// The bodies that are fixed in it.
    pub(super) moments: Moments,
}

/// Where a body or a marker is fixed: in a frame, or at the ground.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Carried {
    pub(super) frame: Option<usize>,
    pub(super) turn: Matrix,
    pub(super) origin: Vector,
}

/// A factor times a coordinate, plus an offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Following {
    pub(super) coordinate: Coordinate,
    pub(super) factor: Param,
    pub(super) offset: Param,
}

/// All bodies and frames of a scene in space. Parents are before the frames that they carry.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Bodies {
    pub(super) all: Vec<BodyPart>,
    pub(super) frames: Vec<Frame>,
}

impl Carried {
    /// At the origin of a frame, or of the ground.
    pub(super) fn at_origin(frame: Option<usize>) -> Self {
        Carried { frame, turn: vectors::identity(), origin: vectors::zero() }
    }

    /// A point and axes of a body that is fixed here.
    pub(super) fn inner(&self, turn: Matrix, at: Vector) -> Self {
        let origin = vectors::add(self.origin, vectors::apply(self.turn, at));
        Carried { frame: self.frame, turn: vectors::product(self.turn, turn), origin }
    }
}

impl Following {
    pub(super) fn of(coordinate: Coordinate) -> Self {
        Following { coordinate, factor: 1.0.into(), offset: 0.0.into() }
    }
}

impl Bodies {
    /// Adds the frames of a joint, and returns its inner marker.
    pub(super) fn add_frames(&mut self, outer: Carried, motions: Vec<Motion<Following>>) -> Carried {
        motions.into_iter().fold(outer, |Carried { frame: parent, turn, origin }, motion| {
            self.frames.push(Frame { parent, turn, origin, motion, moments: Moments::none() });
            Carried::at_origin(Some(self.frames.len() - 1))
        })
    }

    /// Lets a joint carry a body that is fixed here.
    pub(super) fn carry(&mut self, body: usize, joint: &str, at: Carried) {
        let body = &mut self.all[body];
        body.carried = Some((joint.into(), at));
        if let Some(frame) = at.frame {
            self.frames[frame].moments.add(&Moments::of(&body.inertia, at.turn, at.origin));
        }
    }

    /// The frames of every tree.
    pub(super) fn trees(&self) -> Vec<Vec<usize>> {
        let (mut trees, mut of): (Vec<Vec<usize>>, Vec<usize>) = (Vec::new(), Vec::new());
        for (which, frame) in self.frames.iter().enumerate() {
            let tree = frame.parent.map_or(trees.len(), |parent| of[parent]);
            if tree == trees.len() {
                trees.push(Vec::new());
            }
            trees[tree].push(which);
            of.push(tree);
        }
        trees
    }

    /// The frames from the ground, or from behind another frame, to a frame.
    pub(super) fn chain(&self, from: Option<usize>, to: Option<usize>) -> Vec<usize> {
        let parents = std::iter::successors(to, |frame| self.frames[*frame].parent);
        let mut chain: Vec<usize> = parents.take_while(|frame| Some(*frame) != from).collect();
        chain.reverse();
        chain
    }

    /// The last frame that carries both frames; `None` if this is the ground.
    pub(super) fn common(&self, a: Option<usize>, b: Option<usize>) -> Option<usize> {
        let [a, b] = [a, b].map(|frame| self.chain(None, frame));
        a.iter().zip(&b).take_while(|(a, b)| a == b).last().map(|(a, _)| *a)
    }

    /// The name of the first body that one of these frames carries.
    pub(super) fn first_of(&self, frames: &[usize]) -> &str {
        let is_among = |frame: usize| frames.binary_search(&frame).is_ok();
        let is_here = |body: &&BodyPart| body.carried.as_ref().and_then(|(_, at)| at.frame).is_some_and(is_among);
        self.all.iter().find(is_here).map_or("bodies", |body| &body.name)
    }
}
