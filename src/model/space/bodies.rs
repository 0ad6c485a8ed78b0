//! The bodies of a scene in space, the frames of their joints, and where bodies and markers are fixed.

use std::ops::Range;

use super::inertia::{Inertia, Moments};
use super::marker::{Body, Marker};
use super::vectors::{self, Matrix, Vector};
use crate::Error;
use crate::model::{Coordinate, Param};

/// A body.
#[derive(Clone, Debug)]
pub(crate) struct BodyPart {
    pub(crate) name: String,
    pub(crate) inertia: Inertia,
    /// Where it is fixed; `None` until a joint carries it.
    pub(crate) carried: Option<Carried>,
}

/// A joint, the body that it carries, and its frames.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    pub(crate) name: String,
    pub(crate) body: usize,
    pub(crate) frames: Range<usize>,
}

/// A spring, a ram, a rod or a joint between two markers, as it is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Connection {
    pub(crate) name: String,
    pub(crate) ends: [Carried; 2],
    pub(crate) kind: ConnectionKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ConnectionKind {
    /// A line between both markers, with a width in units of marks.
    Line(f64),
    /// A ball at the first marker.
    Ball,
    /// A hinge about the z axis of the first marker.
    Hinge,
}

/// A body that is cut: where its first half is fixed, and the coordinates of the second half, which moves freely.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    pub(crate) first: Carried,
    pub(crate) free: [Coordinate; 7],
}

/// A frame that moves relative to its parent, by a fixed rotation and origin and then by a motion.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// The number of the parent; `None` for the ground.
    pub(crate) parent: Option<usize>,
    pub(crate) turn: Matrix,
    pub(crate) origin: Vector,
    pub(crate) motion: Motion<Following>,
    /// The bodies that are fixed in it.
    pub(crate) moments: Moments,
}

/// Where a body or a marker is fixed: in a frame, or at the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    pub(crate) frame: Option<usize>,
    pub(crate) turn: Matrix,
    pub(crate) origin: Vector,
}

/// The motion of an inner frame relative to an outer one: about or along one of its axes (0, 1, 2), or a rotation by Euler parameters e, which need
/// not have the length 1.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion<C> {
    Turn(usize, C),
    Slide(usize, C),
    Ball([C; 4]),
}

/// A factor times a coordinate, plus an offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Following {
    pub(crate) coordinate: Coordinate,
    pub(crate) factor: Param,
    pub(crate) offset: Param,
}

/// All bodies and frames of a scene in space. Parents are before the frames that they carry.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bodies {
    pub(crate) all: Vec<BodyPart>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) cuts: Vec<Cut>,
    pub(crate) connections: Vec<Connection>,
}

impl Carried {
    /// At the origin of a frame, or of the ground.
    pub(crate) fn at_origin(frame: Option<usize>) -> Self {
        Carried { frame, turn: vectors::identity(), origin: vectors::zero() }
    }

    /// A point and axes of a body that is fixed here.
    pub(crate) fn inner(&self, turn: Matrix, at: Vector) -> Self {
        let origin = vectors::add(self.origin, vectors::apply(self.turn, at));
        Carried { frame: self.frame, turn: vectors::product(self.turn, turn), origin }
    }
}

impl Following {
    pub(crate) fn of(coordinate: Coordinate) -> Self {
        Following { coordinate, factor: 1.0.into(), offset: 0.0.into() }
    }
}

impl Bodies {
    /// Adds the frames of a joint, and returns its inner marker.
    pub(crate) fn add_frames(&mut self, outer: Carried, motions: Vec<Motion<Following>>) -> Carried {
        motions.into_iter().fold(outer, |Carried { frame: parent, turn, origin }, motion| {
            self.frames.push(Frame { parent, turn, origin, motion, moments: Moments::none() });
            Carried::at_origin(Some(self.frames.len() - 1))
        })
    }

    /// Where a marker is fixed, with the present values of parameters.
    ///
    /// # Errors
    /// An axis without a direction, or a body that no joint carries.
    pub(crate) fn fixed_at(&self, part: &str, marker: Marker, value: &dyn Fn(Param) -> f64) -> Result<Carried, Error> {
        let axes = marker.axes.checked_rotation(part, value)?;
        let Body(Some(body)) = marker.body else { return Ok(Carried::at_origin(None).inner(axes, marker.at)) };
        let BodyPart { name, carried, .. } = &self.all[body.index];
        match carried {
            Some(carried) => Ok(carried.inner(axes, marker.at)),
            None => Err(Error::NotCarried { part: part.into(), body: name.clone() }),
        }
    }

    /// Fixes a body here.
    pub(crate) fn carry(&mut self, body: usize, at: Carried) {
        let body = &mut self.all[body];
        body.carried = Some(at);
        if let Some(frame) = at.frame {
            self.frames[frame].moments.add(&Moments::of(&body.inertia, at.turn, at.origin));
        }
    }

    /// The frames of every tree.
    pub(crate) fn trees(&self) -> Vec<Vec<usize>> {
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

    /// The frames from the ground, or those after another frame, to a frame.
    pub(crate) fn chain(&self, from: Option<usize>, to: Option<usize>) -> Vec<usize> {
        let parents = std::iter::successors(to, |frame| self.frames[*frame].parent);
        let mut chain: Vec<usize> = parents.take_while(|frame| Some(*frame) != from).collect();
        chain.reverse();
        chain
    }

    /// The last frame that carries both frames; `None` if this is the ground.
    pub(crate) fn common(&self, a: Option<usize>, b: Option<usize>) -> Option<usize> {
        let [a, b] = [a, b].map(|frame| self.chain(None, frame));
        a.iter().zip(&b).take_while(|(a, b)| a == b).last().map(|(a, _)| *a)
    }

    /// The name of the first body that one of these frames carries.
    pub(crate) fn first_of(&self, frames: &[usize]) -> &str {
        let is_among = |frame: usize| frames.binary_search(&frame).is_ok();
        let is_here = |body: &&BodyPart| body.carried.and_then(|at| at.frame).is_some_and(is_among);
        self.all.iter().find(is_here).map_or("bodies", |body| &body.name)
    }
}
