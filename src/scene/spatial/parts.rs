//! The bodies and joints of a scene in space, as they were added.

use super::assemble::Carried;
use super::formula::Motion;
use super::inertia::Inertia;
use super::marker::Marker;
use super::vectors::Vector;
use crate::Error;
use crate::model::{Coordinate, Param};

/// A body and the joint that carries it.
#[derive(Clone, Debug)]
pub(in crate::scene) struct BodyPart {
    pub(super) name: String,
    pub(super) inertia: Inertia,
    pub(super) joint: Option<Joint>,
}

/// A joint from a marker of its outer body to one of its inner body, with the motions of its frames from the outer to the inner one.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) a: Marker,
    pub(super) b: Marker,
    pub(super) motions: Vec<Motion<Following>>,
}

impl Joint {
    /// Returns an error if an axis has no direction.
    pub(super) fn check_axes(&self, value: &dyn Fn(Param) -> f64) -> Result<(), Error> {
        for (marker, of) in [(self.a, "first"), (self.b, "second")] {
            let length = |direction: Vector| direction.map(value).iter().fold(0.0f64, |sum, x| sum.hypot(*x));
            let bad = marker.axes.directions().into_iter().map(length).find(|length| !(*length > 0.0 && length.is_finite()));
            if let Some(value) = bad {
                let what = format!("the length of an axis of the {of} marker of joint `{}`", self.name);
                return Err(Error::Parameter {
                    what,
                    value,
                    must_be: "positive, and axes must not be parallel to each other",
                });
            }
        }
        Ok(())
    }
}

/// A factor times a coordinate, plus an offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Following {
    pub(super) coordinate: Coordinate,
    pub(super) factor: Param,
    pub(super) offset: Param,
}

impl Following {
    pub(super) fn of(coordinate: Coordinate) -> Self {
        Following { coordinate, factor: 1.0.into(), offset: 0.0.into() }
    }
}

/// All bodies of a scene in space.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Bodies {
    pub(in crate::scene) all: Vec<BodyPart>,
}

impl Bodies {
    /// The numbers of all bodies, those that carry others before them.
    ///
    /// # Errors
    /// A body without a joint, or bodies that carry each other.
    pub(super) fn outward(&self) -> Result<Vec<usize>, Error> {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); self.all.len()];
        let mut order = Vec::with_capacity(self.all.len());
        for (which, body) in self.all.iter().enumerate() {
            let Some(joint) = &body.joint else { return Err(Error::NoJoint { body: body.name.clone() }) };
            match joint.a.body.0 {
                Some(parent) => children[parent.index].push(which),
                None => order.push(which),
            }
        }
        // A tree is walked as a whole, so that its coordinates follow each other.
        let mut stack: Vec<usize> = order.drain(..).rev().collect();
        while let Some(which) = stack.pop() {
            order.push(which);
            stack.extend(children[which].iter().rev());
        }
        let mut is_there = vec![false; self.all.len()];
        order.iter().for_each(|&which| is_there[which] = true);
        match is_there.iter().position(|is_there| !is_there) {
            Some(which) => Err(Error::JointsInCircle { body: self.all[which].name.clone() }),
            None => Ok(order),
        }
    }

    /// The name of the first body that one of these frames carries.
    pub(super) fn first_of(&self, frames: &[usize], carried: &[Carried]) -> &str {
        let is_among = |carried: &Carried| carried.frame.is_some_and(|frame| frames.binary_search(&frame).is_ok());
        carried.iter().position(is_among).map_or("bodies", |body| &self.all[body].name)
    }
}
