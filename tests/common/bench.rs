//! A scene under test: every constant in it is a design variable, and a cost that uses everything a cost may use.

use hamiltonian_adjoint::planar::{Body, Frame, Harmonic, Point};
use hamiltonian_adjoint::{
    Control, Cost, CostPoint, Design, Grid, Inputs, Multiplier, Scalar, Scene, Settings, Start, Sum, System, simulate,
};
use nalgebra::SVector;

/// A function of q, v, p*, ṗ*, σ, u, t and b in which no two of them can stand in for each other.
pub struct Everything;

impl Cost<3, 1, 1, 1> for Everything {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 1, 1>, b: &SVector<S, 1>) -> S {
        let mut sum = at.sigma[0] * at.sigma[0] * at.q[0].cos() + at.u[0] * at.u[0] * at.t + at.u[0] * at.v[2];
        for i in 0..3 {
            let weight = b[0] * (1.0 + i as f64);
            sum += (at.q[i] + at.t).sin() * weight + at.v[i] * at.v[i] * 0.3;
            sum += at.p_star[i] * at.v[i] * 0.2 + at.p_star[i] * at.sigma[0] * 0.1 + at.p_star_dot[i] * at.q[i] * 0.05;
        }
        sum
    }
}

/// A body (or the ground) and its place (x, y, φ) at the start.
#[derive(Clone, Copy)]
pub struct Part {
    pub body: Frame,
    pub place: [f64; 3],
}

impl Part {
    pub const GROUND: Part = Part { body: Body::GROUND, place: [0.0; 3] };

    pub fn angle(&self) -> f64 {
        self.place[2]
    }
}

/// A scene with one control, whose constants are all bound.
pub struct Bench {
    pub scene: Scene,
    pub control: Control,
    pub parts: Vec<Part>,
    pub multipliers: Vec<Multiplier>,
    constants: usize,
}

impl Bench {
    pub fn new() -> Self {
        let mut scene = Scene::new();
        let control = scene.control("u");
        let mut bench = Bench { scene, control, parts: Vec::new(), multipliers: Vec::new(), constants: 0 };
        let (x, y) = (bench.bound(0.4), bench.bound(-9.81));
        bench.scene.gravity(x, y);
        bench
    }

    /// A design variable of this value.
    pub fn bound(&mut self, value: f64) -> Design {
        self.constants += 1;
        self.scene.design(&format!("b{}", self.constants), value)
    }

    pub fn body(&mut self, place: [f64; 3]) -> Part {
        let k = self.parts.len() as f64;
        let (mass, inertia) = (self.bound(0.8 + 0.3 * k), self.bound(0.05 + 0.02 * k));
        let body = self.scene.body(&format!("body {}", self.parts.len()), mass, inertia, place);
        let part = Part { body: body.into(), place };
        self.parts.push(part);
        part
    }

    /// A rod whose ends are at these points of the plane.
    pub fn rod(&mut self, from: [f64; 2], to: [f64; 2]) -> Part {
        let angle = (to[1] - from[1]).atan2(to[0] - from[0]);
        self.body([0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), angle])
    }

    /// The point of a part that is at this place of the plane at the start.
    pub fn point(&mut self, part: Part, at: [f64; 2]) -> Point {
        let [along, across] = self.scene.local(part.body, at).map(|x| self.bound(x));
        part.body.at(along, across)
    }

    /// A hinge of two parts at this place of the plane.
    pub fn hinge(&mut self, a: Part, b: Part, at: [f64; 2]) {
        let (a, b) = (self.point(a, at), self.point(b, at));
        let name = format!("hinge {}", self.multipliers.len());
        let sigma = self.scene.revolute(&name, a, b);
        self.multipliers.extend(sigma);
    }

    /// A torque of the control between two parts.
    pub fn drive(&mut self, a: Part, b: Part) {
        self.scene.torque_actuator("drive", a.body, b.body, self.control);
    }

    /// A crank on the ground that is driven, a coupler and a rocker.
    pub fn four_bar(&mut self) {
        let [a, b, c, d] = [[0.0, 0.0], [0.1, 0.4], [0.9, 0.7], [1.0, 0.0]];
        let (crank, coupler, rocker) = (self.rod(a, b), self.rod(b, c), self.rod(d, c));
        self.hinge(Part::GROUND, crank, a);
        self.hinge(crank, coupler, b);
        self.hinge(coupler, rocker, c);
        self.hinge(Part::GROUND, rocker, d);
        self.drive(Part::GROUND, crank);
    }

    /// Four rods on two feet; the angle of one crank is prescribed as a function of time, the other one is driven.
    pub fn five_bar(&mut self) {
        let [a, b, c, d, e] = [[0.0, 0.0], [0.1, 0.4], [0.6, 0.8], [1.0, 0.5], [1.2, 0.0]];
        let (crank, left, right, rocker) = (self.rod(a, b), self.rod(b, c), self.rod(c, d), self.rod(e, d));
        self.hinge(Part::GROUND, crank, a);
        self.hinge(crank, left, b);
        self.hinge(left, right, c);
        self.hinge(right, rocker, d);
        self.hinge(Part::GROUND, rocker, e);
        let constants = [crank.angle(), 0.3, 3.0, 0.0].map(|x| self.bound(x).into());
        let sigma = self.scene.driven_angle("prescribed", Body::GROUND, crank.body, Harmonic, constants);
        self.multipliers.extend(sigma);
        self.drive(Part::GROUND, rocker);
    }

    /// Adds costs on every body and every multiplier: along the motion, summed like this, and at its end.
    pub fn compile(mut self, running: Sum) -> System {
        let count = self.parts.len().max(self.multipliers.len());
        for (k, sum) in (0..count).flat_map(|k| [(k, running), (k, Sum::Terminal)]) {
            let part = self.parts[k % self.parts.len()];
            let sigma = self.multipliers[k % self.multipliers.len()];
            let b = self.bound(0.5 + 0.1 * k as f64);
            let q = part.body.coordinates().expect("a body");
            self.scene.cost(&format!("cost {k} {sum:?}"), Everything, sum, q, [sigma], [self.control], [b.into()]);
        }
        self.scene.compile().unwrap_or_else(|error| panic!("{error}"))
    }
}

/// The same seemingly random number in [−1, 1] for the same k.
pub fn number(k: usize) -> f64 {
    (12.9898 * (k + 1) as f64).sin()
}

/// Inputs with momenta, controls and unequal steps in no particular pattern; the velocities follow, so they are consistent.
pub fn lively(system: &System, steps: usize, dt: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= 1.0 + 0.3 * number(i));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 2.0 * number(i + 7));
    let p_star = nalgebra::DVector::from_fn(system.n(), |i, _| 0.5 * number(i + 3));
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
    inputs
}

/// The same motion, started with its velocities.
pub fn from_velocity(system: &System, inputs: &Inputs) -> Inputs {
    let motion = simulate(system, inputs, Settings::default()).unwrap_or_else(|error| panic!("{error}"));
    let v = motion.v.column(0).into_owned();
    Inputs { start: Start::Velocity { q: inputs.start.q().clone(), v }, ..inputs.clone() }
}
