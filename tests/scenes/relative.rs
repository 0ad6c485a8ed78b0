//! Mechanisms in relative coordinates whose kinetic energy is one formula: a tree of bodies in the plane, and a robot arm in space.

use hamiltonian_adjoint::{
    Coordinate, KineticEnergy, ListCost, ListKineticEnergy, ListPoint, ListPotentialEnergy, Param, PotentialEnergy, Scalar,
    Scene, Sum,
};
use nalgebra::SVector;

/// A tree of bodies in relative angles: body i turns about the end of its parent.
#[derive(Clone)]
struct Tree {
    parents: Vec<Option<usize>>,
}

impl Tree {
    fn new(bodies: usize) -> Self {
        Tree { parents: (0..bodies).map(|i| i.checked_sub(1).map(|i| i / 2)).collect() }
    }

    /// The bodies from the root to one of them.
    fn path(&self, body: usize) -> Vec<usize> {
        let mut path: Vec<usize> = std::iter::successors(Some(body), |&i| self.parents[i]).collect();
        path.reverse();
        path
    }
}

/// ½ m |v|² + ½ I ω² of the last body of a path.
fn energy_of_last<S: Scalar>(q: impl Iterator<Item = S>, v: impl Iterator<Item = S>, b: &[S]) -> S {
    let (mut angle, mut rate, mut velocity, mut last) = (S::zero(), S::zero(), [S::zero(); 2], [S::zero(); 2]);
    for (q, v) in q.zip(v) {
        velocity = [velocity[0] + last[0], velocity[1] + last[1]];
        (angle, rate) = (angle + q, rate + v);
        let (sin, cos) = angle.sin_cos();
        last = [-sin * rate, cos * rate];
    }
    let centre = [velocity[0] + last[0] * 0.5, velocity[1] + last[1] * 0.5];
    (b[0] * (centre[0] * centre[0] + centre[1] * centre[1]) + b[1] * rate * rate) * 0.5
}

impl ListKineticEnergy for Tree {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        let of = |body: usize| {
            let path = self.path(body);
            energy_of_last(path.iter().map(|&i| q[i]), path.iter().map(|&i| v[i]), b)
        };
        (0..self.parents.len()).map(of).sum()
    }
}

/// One body at the end of a path.
struct Body;

impl ListKineticEnergy for Body {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        energy_of_last(q.iter().copied(), v.iter().copied(), b)
    }
}

/// Σ ½ c (q − 0.2)².
struct Springs;

impl ListPotentialEnergy for Springs {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], _t: S) -> S {
        q.iter().map(|q| (*q - 0.2).powi(2) * b[0]).sum()
    }
}

/// Σ sin² q + b Σ u².
struct Lean;

impl ListCost for Lean {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        at.q.iter().map(|q| q.sin().powi(2)).sum::<S>() + at.u.iter().map(|u| u.powi(2)).sum::<S>() * at.b[0]
    }
}

/// Coordinates q0, q1, … with different initial values.
fn coordinates(scene: &mut Scene, count: usize) -> Vec<Coordinate> {
    let names: Vec<String> = (0..count).map(|i| format!("q{i}")).collect();
    let q = scene.list_coordinates("relative", &names.iter().map(String::as_str).collect::<Vec<_>>());
    q.iter().enumerate().for_each(|(i, q)| scene.place(*q, 0.1 * (1.7 * i as f64).sin()));
    q
}

/// A tree of bodies whose kinetic energy is one formula, or one for each body.
pub fn tree(bodies: usize, is_one: bool) -> Scene {
    let (mut scene, tree) = (Scene::new(), Tree::new(bodies));
    let q = coordinates(&mut scene, bodies);
    let b = [scene.design("mass", 1.3), scene.design("inertia", 0.1)].map(Param::from);
    if is_one {
        scene.list_kinetic_energy("T", tree, &q, &b);
    } else {
        for body in 0..bodies {
            let path: Vec<_> = tree.path(body).into_iter().map(|i| q[i]).collect();
            scene.list_kinetic_energy(&format!("T of {body}"), Body, &path, &b);
        }
    }
    scene.list_potential_energy("V", Springs, &q, &[5.0.into()]);
    let u = scene.control("u");
    scene.list_cost("h", Lean, Sum::Integral, &q, &[], &[u], &[1.0.into()]);
    scene
}

/// Number of joints of the arm.
const JOINTS: usize = 7;

/// An arm of seven joints with the proportions of a common robot: twists of ± 90° between the axes, offset links, and bodies with full tensors of
/// inertia. The numbers are made up.
#[derive(Clone, Copy)]
struct Arm;

type Vector<S> = [S; 3];

fn dot<S: Scalar>(a: Vector<S>, b: Vector<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn sum<S: Scalar>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn constant<S: Scalar>(x: [f64; 3]) -> Vector<S> {
    x.map(S::from)
}

impl Arm {
    /// The twist about x before joint i: its cosine and sine are 0 and ± 1.
    fn twist(i: usize) -> f64 {
        [0.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0][i]
    }

    /// The origin of joint i in the frame of the body before it, m.
    fn origin(i: usize) -> [f64; 3] {
        [[0.0, 0.0, 0.33], [0.0; 3], [0.0, -0.32, 0.0], [0.08, 0.0, 0.0], [-0.08, 0.38, 0.0], [0.0; 3], [0.09, 0.0, 0.0]][i]
    }

    fn mass(i: usize) -> f64 {
        4.0 - 0.5 * i as f64
    }

    /// The centre of mass of body i in its frame, m.
    fn centre(i: usize) -> [f64; 3] {
        let k = i as f64;
        [0.01 + 0.01 * k, 0.03 - 0.02 * k, -0.05 + 0.01 * k]
    }

    /// The tensor of inertia of body i about its centre of mass, kg m²: diagonal, and xy, xz, yz.
    fn inertia(i: usize) -> ([f64; 3], [f64; 3]) {
        let k = 1.0 / (1.0 + i as f64);
        ([0.05 * k, 0.06 * k, 0.03 * k], [0.004 * k, -0.003 * k, 0.002 * k])
    }

    /// A vector of the frame before joint i in the frame of body i, which is turned by the twist about x, then by q about z.
    fn turn<S: Scalar>(i: usize, q: S, a: Vector<S>) -> Vector<S> {
        let (sin, cos) = q.sin_cos();
        let twist = Self::twist(i);
        let [x, y, z] = if twist == 0.0 { a } else { [a[0], a[2] * twist, -a[1] * twist] };
        [cos * x + sin * y, cos * y - sin * x, z]
    }

    fn kinetic_energy<S: Scalar>(q: &[S], v: &[S], payload: S) -> S {
        let (mut omega, mut velocity, mut energy) = (constant::<S>([0.0; 3]), constant::<S>([0.0; 3]), S::zero());
        for i in 0..JOINTS {
            let moved = sum(velocity, cross(omega, constant(Self::origin(i))));
            (omega, velocity) = (Self::turn(i, q[i], omega), Self::turn(i, q[i], moved));
            omega[2] += v[i];
            let centre = sum(velocity, cross(omega, constant(Self::centre(i))));
            let (diagonal, products) = Self::inertia(i);
            let mass = if i + 1 == JOINTS { payload + Self::mass(i) } else { S::from(Self::mass(i)) };
            let squares = (0..3).map(|k| omega[k] * omega[k] * diagonal[k]).sum::<S>();
            let pairs = [(0, 1), (0, 2), (1, 2)].into_iter().zip(products);
            let mixed = pairs.map(|((k, l), product)| omega[k] * omega[l] * (2.0 * product)).sum::<S>();
            energy += (mass * dot(centre, centre) + squares + mixed) * 0.5;
        }
        energy
    }

    /// m g z of all bodies; the vertical is carried from frame to frame.
    fn potential_energy<S: Scalar>(q: &[S], payload: S) -> S {
        let (mut up, mut height, mut energy) = (constant::<S>([0.0, 0.0, 1.0]), S::zero(), S::zero());
        for (i, angle) in q.iter().enumerate() {
            height += dot(up, constant(Self::origin(i)));
            up = Self::turn(i, *angle, up);
            let mass = if i + 1 == JOINTS { payload + Self::mass(i) } else { S::from(Self::mass(i)) };
            energy += mass * (height + dot(up, constant(Self::centre(i)))) * 9.81;
        }
        energy
    }
}

impl ListKineticEnergy for Arm {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        Arm::kinetic_energy(q, v, b[0])
    }
}

impl ListPotentialEnergy for Arm {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], _t: S) -> S {
        Arm::potential_energy(q, b[0])
    }
}

impl KineticEnergy<JOINTS, 1> for Arm {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, JOINTS>, v: &SVector<S, JOINTS>, b: &SVector<S, 1>) -> S {
        Arm::kinetic_energy(q.as_slice(), v.as_slice(), b[0])
    }
}

impl PotentialEnergy<JOINTS, 1> for Arm {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, JOINTS>, b: &SVector<S, 1>, _t: S) -> S {
        Arm::potential_energy(q.as_slice(), b[0])
    }
}

/// A robot arm of seven joints, driven by a torque at each, by lists or by fixed lengths.
pub fn arm(by_lists: bool) -> Scene {
    let mut scene = Scene::new();
    let q = coordinates(&mut scene, JOINTS);
    let payload: Param = scene.design("payload", 1.0).into();
    if by_lists {
        scene.list_kinetic_energy("T", Arm, &q, &[payload]);
        scene.list_potential_energy("V", Arm, &q, &[payload]);
    } else {
        let q: [_; JOINTS] = q.clone().try_into().expect("seven coordinates");
        scene.kinetic_energy("T", Arm, q, [payload]);
        scene.potential_energy("V", Arm, q, [payload]);
    }
    let torques: Vec<_> = (0..JOINTS).map(|i| scene.control(&format!("torque {i}"))).collect();
    for (i, (q, u)) in q.iter().zip(&torques).enumerate() {
        scene.list_force(&format!("motor {i}"), Motor, &[*q], &[*u], &[]);
    }
    scene.list_cost("h", Lean, Sum::Integral, &q, &[], &torques, &[0.01.into()]);
    scene
}

/// Q = u.
#[derive(Clone, Copy)]
struct Motor;

impl hamiltonian_adjoint::ListForce for Motor {
    fn force<S: Scalar>(&self, at: &hamiltonian_adjoint::ListForcePoint<S>, _b: &[S], force: &mut [S]) {
        force[0] = at.u[0];
    }
}
