//! From bodies and joints to trees: frames, what they carry, and the elements of their energies.

use std::ops::Range;
use std::sync::Arc;

use super::formula::{Fixed, Follows, Motion, Numbers};
use super::inertia::Moments;
use super::parts::{Bodies, Following, Joint};
use super::tree::{Inertial, Kinetic, Node, Tree, Weight};
use super::vectors::{self, Matrix, Vector};
use crate::model::{Coordinate, Param};
use crate::scene::Scene;
use crate::{Error, memory};

/// A frame in parameters.
pub(super) struct Frame {
    pub(super) parent: Option<usize>,
    pub(super) turn: Matrix,
    pub(super) origin: Vector,
    pub(super) motion: Motion<Following>,
    moments: Moments,
}

/// Where a body is fixed: in a frame, or at the ground.
#[derive(Clone, Copy)]
pub(super) struct Carried {
    pub(super) frame: Option<usize>,
    pub(super) turn: Matrix,
    pub(super) origin: Vector,
}

impl Carried {
    const fn ground(turn: Matrix, origin: Vector) -> Self {
        Carried { frame: None, turn, origin }
    }

    /// A point and axes of the body in the same frame.
    pub(super) fn inner(&self, turn: Matrix, at: Vector) -> Self {
        let origin = vectors::add(self.origin, vectors::apply(self.turn, at));
        Carried { frame: self.frame, turn: vectors::product(self.turn, turn), origin }
    }
}

/// All frames, parents first, and where the bodies are fixed.
pub(super) struct Assembled {
    pub(super) frames: Vec<Frame>,
    pub(super) carried: Vec<Carried>,
}

impl Assembled {
    /// From the bodies of a scene.
    ///
    /// # Errors
    /// A body without a joint, or joints in a circle.
    pub(super) fn new(bodies: &Bodies, value: &dyn Fn(Param) -> f64) -> Result<Self, Error> {
        let ground = Carried::ground(vectors::identity(), vectors::zero());
        let mut assembled = Assembled { frames: Vec::new(), carried: vec![ground; bodies.all.len()] };
        for which in bodies.outward()? {
            let body = &bodies.all[which];
            let Some(joint) = &body.joint else { continue };
            joint.check_axes(value)?;
            let parent = joint.a.body.0.map_or(ground, |parent| assembled.carried[parent.index]);
            let outer = parent.inner(joint.a.axes.rotation(value), joint.a.at);
            // The body's frame from the marker of its joint.
            let back = vectors::transposed(joint.b.axes.rotation(value));
            let origin = vectors::negated(vectors::apply(back, joint.b.at));
            assembled.carried[which] = assembled.push(outer, joint).inner(back, origin);
            let Carried { frame, turn, origin } = assembled.carried[which];
            if let Some(frame) = frame {
                assembled.frames[frame].moments.add(&Moments::of(&body.inertia, turn, origin));
            }
        }
        Ok(assembled)
    }

    /// Adds the frames of a joint, and returns its inner marker.
    fn push(&mut self, outer: Carried, joint: &Joint) -> Carried {
        let mut now = outer;
        for motion in &joint.motions {
            let Carried { frame: parent, turn, origin } = now;
            self.frames.push(Frame { parent, turn, origin, motion: *motion, moments: Moments::none() });
            let frame = Some(self.frames.len() - 1);
            now = Carried { frame, turn: vectors::identity(), origin: vectors::zero() };
        }
        now
    }

    /// The frames of every tree.
    fn trees(&self) -> Vec<Vec<usize>> {
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

    /// The nodes of a tree, with its coordinates and parameters.
    fn tree(&self, frames: &[usize], gravity: [Param; 3]) -> (Tree, Vec<Coordinate>, Numbers) {
        let (mut q, mut b) = (Coordinates::default(), Numbers::default());
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
        let of_node = |(k, &which): (usize, &usize)| {
            let Frame { parent, turn, origin, motion, moments: Moments { mass, first, second } } = &self.frames[which];
            Node {
                parent: parent.map(place),
                fixed: Fixed { turn: turn.map(|row| b.numbers(row)), origin: b.numbers(*origin) },
                motion: q.motion(motion, &mut b),
                body: Inertial { mass: b.number(*mass), first: b.numbers(*first), second: b.numbers(*second) },
                weighted: b.numbers(weighted[k]),
                carried: b.number(carried[k]),
            }
        };
        let nodes = Arc::new(frames.iter().enumerate().map(of_node).collect());
        (Tree { nodes, gravity: b.numbers(gravity) }, q.0, b)
    }
}

/// The coordinates of a formula.
#[derive(Default)]
pub(super) struct Coordinates(pub(super) Vec<Coordinate>);

impl Coordinates {
    pub(super) fn motion(&mut self, motion: &Motion<Following>, b: &mut Numbers) -> Motion<Follows> {
        let mut follows = |of: &Following| {
            let known = self.0.iter().position(|q| *q == of.coordinate);
            let q = known.unwrap_or_else(|| {
                self.0.push(of.coordinate);
                self.0.len() - 1
            });
            Follows { q, factor: b.number(of.factor), offset: b.number(of.offset) }
        };
        match motion {
            Motion::Turn(axis, angle) => Motion::Turn(*axis, follows(angle)),
            Motion::Slide(axis, offset) => Motion::Slide(*axis, follows(offset)),
            Motion::Ball(e) => Motion::Ball(e.each_ref().map(follows)),
        }
    }
}

impl Scene {
    /// Adds the elements of all bodies in space.
    pub(in crate::scene) fn add_trees(&mut self) -> Result<(), Error> {
        if self.space.all.is_empty() {
            return Ok(());
        }
        let bodies = std::mem::take(&mut self.space);
        let designs: Vec<f64> = self.parts.designs.iter().map(|(_, value)| *value).collect();
        let graph = self.parts.scene.expressions();
        let values = graph.evaluate(&[], &designs);
        let assembled = Assembled::new(&bodies, &|param| param.present_value(&designs, &values))?;
        let gravity = self.parts.gravity.map(|g| g.unwrap_or(0.0.into()));
        for frames in assembled.trees() {
            let (tree, q, b) = assembled.tree(&frames, gravity);
            let name = bodies.first_of(&frames, &assembled.carried).to_string();
            memory::check("the bodies of a tree", frames.len(), size_of::<Node>())?;
            let has_weight = gravity.iter().any(|g| g.constant() != Some(0.0));
            self.list_kinetic_energy(&name, Kinetic(tree.clone()), &q, &b.0);
            if has_weight {
                self.list_potential_energy(&format!("weight of {name}"), Weight(tree), &q, &b.0);
            }
            self.join_groups(&q);
        }
        self.space = bodies;
        Ok(())
    }

    /// Joins the groups of coordinates of a tree that follow each other to one group, which is eliminated as a whole.
    fn join_groups(&mut self, q: &[Coordinate]) {
        let in_tree = |range: &Range<usize>| range.clone().all(|i| q.iter().any(|q| q.index() == i));
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
