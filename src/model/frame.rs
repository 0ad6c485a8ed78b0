//! Frames of planar bodies, of particles and of the ground, and points fixed in them.

use super::{Coordinate, Param};

/// A frame of reference: that of a body, that of a particle (which does not rotate), or the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame(pub(crate) Owner);

/// The body or particle to which a frame belongs, or the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Owner {
    Ground,
    Body([Coordinate; 3]),
    Particle([Coordinate; 2]),
}

/// A point fixed in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub(crate) frame: Frame,
    pub(crate) at: [Param; 2],
}

impl Frame {
    /// The body or particle to which the frame belongs, or the ground.
    pub(crate) fn owner(self) -> Owner {
        self.0
    }

    /// The coordinates of the body or particle; empty for the ground.
    pub(crate) fn own_coordinates(self) -> Vec<Coordinate> {
        match self.0 {
            Owner::Ground => Vec::new(),
            Owner::Body(q) => q.to_vec(),
            Owner::Particle(q) => q.to_vec(),
        }
    }

    /// The coordinates of the body; `None` for the ground and for particles.
    pub fn coordinates(self) -> Option<[Coordinate; 3]> {
        match self.0 {
            Owner::Body(coordinates) => Some(coordinates),
            Owner::Ground | Owner::Particle(_) => None,
        }
    }

    /// x, y and φ of the origin, with the value `of(q)` for each coordinate q that the frame has and 0 for the others.
    pub(crate) fn place(self, of: impl Fn(Coordinate) -> f64) -> [f64; 3] {
        match self.0 {
            Owner::Ground => [0.0; 3],
            Owner::Body(q) => q.map(of),
            Owner::Particle([x, y]) => [of(x), of(y), 0.0],
        }
    }

    /// The origin of the frame.
    pub(crate) fn origin(self) -> Point {
        Point { frame: self, at: [0.0.into(), 0.0.into()] }
    }

    /// The point (x, y) of the frame, m.
    pub fn at(self, x: impl Into<Param>, y: impl Into<Param>) -> Point {
        Point { frame: self, at: [x.into(), y.into()] }
    }
}

impl Point {
    /// The frame in which the point is fixed.
    pub fn frame(self) -> Frame {
        self.frame
    }

    /// The position of the point in its frame, m.
    pub(crate) fn at(self) -> [Param; 2] {
        self.at
    }
}
