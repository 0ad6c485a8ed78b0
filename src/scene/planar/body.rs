//! Bodies: mass, inertia and weight.

use nalgebra::SVector;

use crate::model::{Frame, Owner, Point};
use crate::scene::ready::{Entry, Kind, Part, Sort};
use crate::{Coordinate, KineticEnergy, Param, PotentialEnergy, Scalar, Scene};

/// A planar rigid body of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// x and y of its centre of mass, m, and its angle φ, rad.
    pub coordinates: [Coordinate; 3],
}

/// A point mass: a body without an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// x and y, m.
    pub coordinates: [Coordinate; 2],
}

impl From<Body> for Frame {
    fn from(body: Body) -> Frame {
        Frame(Owner::Body(body.coordinates))
    }
}

impl From<Particle> for Frame {
    fn from(particle: Particle) -> Frame {
        Frame(Owner::Particle(particle.coordinates))
    }
}

impl Particle {
    /// The point at the position of the particle.
    pub fn point(self) -> Point {
        Frame::from(self).at(0.0, 0.0)
    }
}

/// T = ½ m (ẋ² + ẏ²); `b = [m]`.
#[derive(Clone, Copy, Debug)]
pub struct PointMass;

impl KineticEnergy<2, 1> for PointMass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        b[0] * (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}

impl Body {
    /// The inertial frame.
    pub const GROUND: Frame = Frame(Owner::Ground);

    /// The point (x, y) of the body's frame, m.
    pub fn at(self, x: impl Into<Param>, y: impl Into<Param>) -> Point {
        Frame::from(self).at(x, y)
    }
}

/// T = ½ m (ẋ² + ẏ²) + ½ J φ̇², b = [m, J].
#[derive(Clone, Copy, Debug)]
pub struct RigidBody;

impl KineticEnergy<3, 2> for RigidBody {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 3>, v: &SVector<S, 3>, b: &SVector<S, 2>) -> S {
        (b[0] * (v[0] * v[0] + v[1] * v[1]) + b[1] * v[2] * v[2]) * 0.5
    }
}

/// V = −m (g_x x + g_y y), b = [m, g_x, g_y].
#[derive(Clone, Copy, Debug)]
pub struct Weight;

impl PotentialEnergy<2, 3> for Weight {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 3>, _t: S) -> S {
        -(b[0] * (b[1] * q[0] + b[2] * q[1]))
    }
}

pub(super) static BODY: Kind = Kind::new("body", &["mass", "inertia"], |scene, name, part| {
    let (q, [mass, inertia]) = (scene.coordinates(name, ["x", "y", "φ"]), part.numbers_from(0));
    q.into_iter().zip(part.fixed_numbers()).for_each(|(q, value)| scene.place(q, value));
    scene.require_nonnegative(mass, format!("the mass of `{name}`"));
    scene.require_nonnegative(inertia, format!("the moment of inertia of `{name}`"));
    scene.kinetic_energy(name, RigidBody, q, [mass, inertia]);
    scene.weight(name, [q[0], q[1]], mass);
    if inertia.constant() == Some(0.0) {
        scene.parts.sketch.point_masses.push(scene.parts.sketch.bodies.len());
    }
    scene.draw_body(name, Body { coordinates: q }.into());
})
.with(&[("place", Sort::Numbers(3))]);

pub(super) static PARTICLE: Kind = Kind::new("particle", &["mass"], |scene, name, part| {
    let (q, mass) = (scene.coordinates(name, ["x", "y"]), part.number(0));
    q.into_iter().zip(part.fixed_numbers()).for_each(|(q, value)| scene.place(q, value));
    scene.require_nonnegative(mass, format!("the mass of `{name}`"));
    scene.kinetic_energy(name, PointMass, q, [mass]);
    scene.weight(name, q, mass);
    scene.draw_body(name, Particle { coordinates: q }.into());
})
.with(&[("place", Sort::Numbers(2))]);

impl Scene {
    fn weight(&mut self, name: &str, q: [Coordinate; 2], mass: Param) {
        let b = [mass, Param::gravity(0), Param::gravity(1)];
        self.potential_energy(&format!("weight of {name}"), Weight, q, b);
    }

    /// Adds a rigid body with mass (kg), moment of inertia about its centre (kg m²) and initial position (x, y, φ). Either may be 0 if joints
    /// determine the coordinates without inertia, for example for a point mass on a rod.
    pub fn body(&mut self, name: &str, mass: impl Into<Param>, inertia: impl Into<Param>, place: [f64; 3]) -> Body {
        let (first, numbers) = (self.parts.coordinates.len(), vec![mass.into(), inertia.into()]);
        self.ready(name, Part { numbers, more: vec![Entry::Numbers(place.to_vec())], ..Part::of(&BODY) });
        Body { coordinates: self.handles(first) }
    }

    /// Adds a particle with mass (kg) and initial position (x, y), m. It has no angle, so only parts between points can be attached:
    /// hinges, distances, springs, dampers, actuators and applied forces.
    pub fn particle(&mut self, name: &str, mass: impl Into<Param>, place: [f64; 2]) -> Particle {
        let (first, numbers) = (self.parts.coordinates.len(), vec![mass.into()]);
        self.ready(name, Part { numbers, more: vec![Entry::Numbers(place.to_vec())], ..Part::of(&PARTICLE) });
        Particle { coordinates: self.handles(first) }
    }

    /// The point of a body, or of the ground, that is at (x, y) in the inertial frame when the bodies are in their initial positions.
    pub fn at_world(&self, frame: impl Into<Frame>, x: f64, y: f64) -> Point {
        let frame = frame.into();
        let [along, across] = self.local(frame, [x, y]);
        frame.at(along, across)
    }

    /// Position in a body's frame of a point p of the inertial frame: R(φ)ᵀ (p − r), with the initial position r and angle φ of the body,
    /// m.
    pub fn local(&self, frame: impl Into<Frame>, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x0, y0, phi] = frame.into().place(|q| self.initial(q));
        let (dx, dy, (sin, cos)) = (x - x0, y - y0, phi.sin_cos());
        [cos * dx + sin * dy, cos * dy - sin * dx]
    }

    /// Sets the acceleration of gravity of all bodies along x and y, m/s², including those added later. The default is zero. The component along z, which
    /// acts on bodies in space only, is kept ([`Spatial::gravity`](crate::spatial::Spatial::gravity)).
    pub fn gravity(&mut self, x: impl Into<Param>, y: impl Into<Param>) {
        let z = self.parts.gravity[2].unwrap_or(0.0.into());
        self.set_gravity([x.into(), y.into(), z]);
    }
}
