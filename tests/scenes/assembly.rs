//! Rods, joints and springs put together in any units, with the energy and the momenta of what comes out.
#![allow(dead_code)]

use hamiltonian_adjoint::planar::{Body, Frame, Point};
use hamiltonian_adjoint::{Coordinate, Error, Scene, System};

pub use super::by_hand::GRAVITY;

/// How many units a metre, a kilogram and a second are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    pub length: f64,
    pub mass: f64,
    pub time: f64,
}

impl Units {
    pub const SI: Units = Units { length: 1.0, mass: 1.0, time: 1.0 };

    /// A metre per second.
    pub fn speed(self) -> f64 {
        self.length / self.time
    }

    /// A newton.
    pub fn force(self) -> f64 {
        self.mass * self.length / (self.time * self.time)
    }

    /// A newton metre.
    pub fn torque(self) -> f64 {
        self.force() * self.length
    }
}

/// A part of an assembly, by its number; none is the ground.
pub type Part = Option<usize>;

/// The ground.
pub const GROUND: Part = None;

/// A rigid body, its numbers in the units of the assembly.
#[derive(Clone, Copy)]
pub struct Rigid {
    pub body: Body,
    mass: f64,
    inertia: f64,
}

/// A spring between two points of parts, in the parts' frames.
struct Spring {
    ends: [(Part, [f64; 2]); 2],
    stiffness: f64,
    length: f64,
}

/// A mechanism under construction; its methods take SI numbers.
pub struct Assembly {
    pub scene: Scene,
    pub bodies: Vec<Rigid>,
    pub units: Units,
    springs: Vec<Spring>,
    gravity: f64,
    joints: usize,
}

impl Assembly {
    /// Nothing yet, in a field of gravity (m/s²) that points down.
    pub fn new(units: Units, gravity: f64) -> Self {
        let mut scene = Scene::new();
        let gravity = gravity * units.speed() / units.time;
        scene.gravity(0.0, -gravity);
        Assembly { scene, bodies: Vec::new(), units, springs: Vec::new(), gravity, joints: 0 }
    }

    /// A body with a place (x, y, φ).
    pub fn body(&mut self, mass: f64, inertia: f64, [x, y, phi]: [f64; 3]) -> Part {
        let Units { length: l, mass: m, .. } = self.units;
        let (mass, inertia, place) = (mass * m, inertia * m * l * l, [x * l, y * l, phi]);
        let body = self.scene.body(&format!("body {}", self.bodies.len()), mass, inertia, place);
        self.bodies.push(Rigid { body, mass, inertia });
        Some(self.bodies.len() - 1)
    }

    /// A thin rod whose ends are at these places.
    pub fn rod(&mut self, mass: f64, from: [f64; 2], to: [f64; 2]) -> Part {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let centre = [from[0] + 0.5 * dx, from[1] + 0.5 * dy];
        self.body(mass, mass * (dx * dx + dy * dy) / 12.0, [centre[0], centre[1], dy.atan2(dx)])
    }

    /// The frame of a part.
    pub fn frame(&self, part: Part) -> Frame {
        part.map_or(Body::GROUND, |k| self.bodies[k].body.into())
    }

    /// The coordinates (x, y, φ) of a part other than the ground.
    pub fn coordinates(&self, part: Part) -> [Coordinate; 3] {
        self.bodies[part.expect("a body")].body.coordinates
    }

    /// Where in the frame of a part this place is at the start.
    pub fn local(&self, part: Part, at: [f64; 2]) -> [f64; 2] {
        self.scene.local(self.frame(part), at.map(|x| x * self.units.length))
    }

    /// The point of a part that is at this place at the start.
    pub fn point(&self, part: Part, [x, y]: [f64; 2]) -> Point {
        self.scene.at_world(self.frame(part), x * self.units.length, y * self.units.length)
    }

    /// A name that no joint or force had before.
    pub fn name(&mut self, kind: &str) -> String {
        self.joints += 1;
        format!("{kind} {}", self.joints)
    }

    /// A hinge at a place.
    pub fn hinge(&mut self, a: Part, b: Part, at: [f64; 2]) {
        let (name, pa, pb) = (self.name("hinge"), self.point(a, at), self.point(b, at));
        self.scene.revolute(&name, pa, pb);
    }

    /// A weld at a place.
    pub fn weld(&mut self, a: Part, b: Part, at: [f64; 2]) {
        let angle = |part: Part| part.map_or(0.0, |k| self.scene.initial(self.bodies[k].body.coordinates[2]));
        let turn = angle(b) - angle(a);
        let (name, pa, pb) = (self.name("weld"), self.point(a, at), self.point(b, at));
        self.scene.weld(&name, pa, pb, turn);
    }

    /// A rail along the ground's x axis through a place, on which a part slides without turning.
    pub fn rail(&mut self, part: Part, at: [f64; 2]) {
        let (name, a, b) = (self.name("rail"), self.point(GROUND, at), self.point(part, at));
        self.scene.prismatic(&name, a, 0.0, b, 0.0);
    }

    /// A spring (N/m, free length in m) with a damper (N s/m) between two places.
    pub fn spring(&mut self, a: (Part, [f64; 2]), b: (Part, [f64; 2]), stiffness: f64, length: f64, damping: f64) {
        let Units { mass: m, time: t, length: l } = self.units;
        let (stiffness, length, damping) = (stiffness * m / (t * t), length * l, damping * m / t);
        let (name, pa, pb) = (self.name("spring"), self.point(a.0, a.1), self.point(b.0, b.1));
        self.scene.spring_damper(&name, pa, pb, stiffness, length, damping);
        self.springs.push(Spring { ends: [a, b].map(|(part, at)| (part, self.local(part, at))), stiffness, length });
    }

    /// Compiles it.
    pub fn finish(self) -> Result<Mechanism, Error> {
        let Assembly { scene, bodies, springs, gravity, .. } = self;
        Ok(Mechanism { system: scene.compile()?, bodies, springs, gravity })
    }
}

/// A mechanism, in its units.
pub struct Mechanism {
    pub system: System,
    pub bodies: Vec<Rigid>,
    springs: Vec<Spring>,
    gravity: f64,
}

impl Mechanism {
    /// Kinetic energy of the bodies.
    pub fn kinetic(&self, v: &[f64]) -> f64 {
        let of = |rigid: &Rigid| {
            let [x, y, phi] = rigid.body.coordinates.map(|q| v[q.index()]);
            0.5 * (rigid.mass * (x * x + y * y) + rigid.inertia * phi * phi)
        };
        self.bodies.iter().map(of).sum()
    }

    /// Kinetic and potential energy.
    pub fn energy(&self, q: &[f64], v: &[f64]) -> f64 {
        let weight = |rigid: &Rigid| rigid.mass * self.gravity * q[rigid.body.coordinates[1].index()];
        let spring = |spring: &Spring| {
            let [a, b] = spring.ends.map(|(part, at)| self.place(part, at, q));
            let stretch = (b[0] - a[0]).hypot(b[1] - a[1]) - spring.length;
            0.5 * spring.stiffness * stretch * stretch
        };
        self.kinetic(v) + self.bodies.iter().map(weight).sum::<f64>() + self.springs.iter().map(spring).sum::<f64>()
    }

    /// Linear momenta in x and y and the angular momentum about the origin.
    pub fn momenta(&self, q: &[f64], v: &[f64]) -> [f64; 3] {
        self.bodies.iter().fold([0.0; 3], |[px, py, turn], rigid| {
            let at = |x: &[f64]| rigid.body.coordinates.map(|c| x[c.index()]);
            let ([x, y, _], [vx, vy, spin]) = (at(q), at(v));
            let (mx, my) = (rigid.mass * vx, rigid.mass * vy);
            [px + mx, py + my, turn + x * my - y * mx + rigid.inertia * spin]
        })
    }

    fn place(&self, part: Part, [a, b]: [f64; 2], q: &[f64]) -> [f64; 2] {
        let Some(k) = part else { return [a, b] };
        let [x, y, phi] = self.bodies[k].body.coordinates.map(|c| q[c.index()]);
        let (sin, cos) = phi.sin_cos();
        [x + cos * a - sin * b, y + sin * a + cos * b]
    }

    /// The coordinate φ of a body.
    pub fn angle(&self, body: usize) -> usize {
        self.bodies[body].body.coordinates[2].index()
    }
}
