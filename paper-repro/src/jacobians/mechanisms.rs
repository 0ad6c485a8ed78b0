//! Two mechanisms, with motions, on which the printed blocks are tested.

use hamiltonian_adjoint::element::{CostPoint, ForcePoint, Sum};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum, CartScene};
use hamiltonian_adjoint::{Constraint, Cost, Error, Force, Scalar, Scene, System};
use hamiltonian_adjoint::{Grid, Inputs, Settings, Start, Trajectory, simulate};
use nalgebra::{DMatrix, DVector, SVector};
use std::f64::consts::{FRAC_PI_2, PI};

use crate::by_hand::{DoublePendulum, GRAVITY};

/// A mechanism with a motion.
pub struct Moving {
    pub system: System,
    pub inputs: Inputs,
    pub motion: Trajectory,
}

impl Moving {
    fn new(system: System, start: Option<(Vec<f64>, Vec<f64>)>) -> Result<Self, Error> {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
        let wave = |k: usize, i: usize| 10.0 * (0.3 + (0.9 * i as f64 + k as f64).sin());
        inputs.controls = DMatrix::from_fn(system.k(), 41, wave);
        if let Some((q, v)) = start {
            inputs.start = Start::Velocity { q: DVector::from_vec(q), v: DVector::from_vec(v) };
        }
        let motion = simulate(&system, &inputs, Settings::default())?;
        Ok(Moving { system, inputs, motion })
    }
}

/// h = ½ b u²: a running cost with a design parameter.
struct Effort;

impl Cost<0, 0, 1, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, b: &SVector<S, 1>) -> S {
        b[0] * at.u[0] * at.u[0] * 0.5
    }
}

/// The paper's class, with constant M: a cart with two links, and a damper to the ground, so that Q_v depends on q.
///
/// The only design parameter, the damping, is also the weight of the effort.
pub fn constant_mass() -> Result<Moving, Error> {
    let example = CartPendulum { gravity: GRAVITY, rail_friction: 0.0, hinge_friction: 0.0, ..CartPendulum::with_links(2) };
    let CartScene { mut scene, force, links, .. } = example.mechanism();
    let damping = scene.design("damping", 0.7);
    scene.spring_damper("strut", Body::GROUND.at(0.5, 0.3), links[1].at(0.1, 0.05), 0.0, 1.0, damping);
    for (name, link) in [("angle 1", links[0]), ("angle 2", links[1])] {
        let [_, _, angle] = link.coordinates;
        scene.cost(name, AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
    }
    scene.cost("effort", Effort, Sum::Plain, [], [], [force], [damping.into()]);
    Moving::new(scene.compile()?, None)
}

/// A torque u on the first link, and friction that depends on its angle: Q_v depends on q.
impl Force<2, 1> for DoublePendulum {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, _: &SVector<S, 0>) -> SVector<S, 2> {
        let friction = (at.q[0].cos() + 2.0) * at.v[0] * 0.1;
        SVector::from([at.u[0] - friction, S::zero()])
    }
}

/// The end of the second link stays on a vertical line.
impl Constraint<2, 1> for DoublePendulum {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([q[0].sin() + q[1].sin() - 0.5])
    }
}

/// Q_q + γ Q_v of the double pendulum by hand: gravity, torque and friction, without T_q.
pub fn double_pendulum_force_q(q: &DVector<f64>, v: &DVector<f64>, gamma: f64) -> DMatrix<f64> {
    let friction = 0.1 * (q[0].sin() * v[0] - gamma * (q[0].cos() + 2.0));
    DMatrix::from_row_slice(2, 2, &[friction - 2.0 * GRAVITY * q[0].cos(), 0.0, 0.0, -GRAVITY * q[1].cos()])
}

/// Q_v of the double pendulum by hand.
pub fn double_pendulum_force_v(q: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 2, &[-0.1 * (q[0].cos() + 2.0), 0.0, 0.0, 0.0])
}

/// A mass matrix that depends on q: not among the paper's examples, but covered by its Eq. (1).
pub fn variable_mass() -> Result<Moving, Error> {
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["φ1", "φ2"]);
    let torque = scene.control("torque");
    scene.kinetic_energy("masses", DoublePendulum, q, []);
    scene.potential_energy("weight", DoublePendulum, q, []);
    scene.force("torque and friction", DoublePendulum, q, [torque], []);
    scene.constraint("line", DoublePendulum, q, []);
    let q = vec![2.6, PI - (0.5 - 2.6f64.sin()).asin()];
    let v = vec![1.0, -q[0].cos() / q[1].cos()];
    Moving::new(scene.compile()?, Some((q, v)))
}

/// −T_q, which removes T_q from Eq. (1b).
struct WithoutTq;

impl Force<2> for WithoutTq {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, _: &SVector<S, 0>) -> SVector<S, 2> {
        let t_q = -(at.v[0] * at.v[1] * (at.q[0] - at.q[1]).sin());
        SVector::from([-t_q, t_q])
    }
}

/// The free double pendulum after 1 s from rest at (2, 1) rad: in two angles (with or without T_q) and in six coordinates of two
/// point masses on rods, where M is constant and T_q = 0.
pub fn free_fall() -> Result<[[f64; 2]; 3], Error> {
    let start = [2.0f64, 1.0];
    let angles = |with_t_q: bool| -> Result<[f64; 2], Error> {
        let mut scene = Scene::new();
        let q = scene.coordinates("pendulum", ["φ1", "φ2"]);
        scene.kinetic_energy("masses", DoublePendulum, q, []);
        scene.potential_energy("weight", DoublePendulum, q, []);
        if !with_t_q {
            scene.force("−T_q", WithoutTq, q, [], []);
        }
        let system = scene.compile()?;
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(4000, 0.00025));
        inputs.start = Start::Velocity { q: DVector::from_row_slice(&start), v: DVector::zeros(2) };
        let motion = simulate(&system, &inputs, Settings::default())?;
        Ok([motion.q[(0, 4000)], motion.q[(1, 4000)]])
    };
    Ok([angles(true)?, angles(false)?, point_masses(start)?])
}

fn point_masses(start: [f64; 2]) -> Result<[f64; 2], Error> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let (x1, y1) = (start[0].sin(), -start[0].cos());
    let (x2, y2) = (x1 + start[1].sin(), y1 - start[1].cos());
    // Masses at the ends of massless rods: the moment of inertia plays no part.
    let first = scene.body("mass 1", 1.0, 1.0, [x1, y1, 0.0]);
    let second = scene.body("mass 2", 1.0, 1.0, [x2, y2, 0.0]);
    scene.distance("rod 1", Body::GROUND.at(0.0, 0.0), first.at(0.0, 0.0), 1.0);
    scene.distance("rod 2", first.at(0.0, 0.0), second.at(0.0, 0.0), 1.0);
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(4000, 0.00025));
    let motion = simulate(&system, &inputs, Settings { position_tolerance: 1e-8, ..Settings::default() })?;
    let q = motion.q.column(4000);
    Ok([q[0].atan2(-q[1]), (q[3] - q[0]).atan2(-(q[4] - q[1]))])
}
