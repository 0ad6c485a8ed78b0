//! Mechanisms of formulas that a user writes: long ones on many coordinates, and many short ones side by side.

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar, Scene, Sum,
};
use nalgebra::{SVector, vector};

use super::seven_bodies;

/// The scenes by name, each with a step length in s for which it is resolved.
pub fn all() -> Vec<(&'static str, Scene, f64)> {
    vec![
        ("seven bodies as one element", seven_bodies::whole(), 1e-4),
        ("seven bodies by parts", seven_bodies::by_parts(), 1e-4),
        ("30 masses, cables, soft contact", masses::<30>(true), 0.005),
        ("30 masses, cables, Hertzian contact", masses::<30>(false), 1e-4),
        ("10 boxes on ball joints", boxes(10), 0.001),
        ("cart with 6 links", cart(false), 0.01),
        ("cart with 6 links, quadratic cost of 20 coordinates", cart(true), 0.01),
    ]
}

/// ½ m |v|² and, for masses on cables, V = ½ c (l − l₀)² with b = [c, l₀].
struct Mass;

impl KineticEnergy<2, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        b[0] * v.dot(v) * 0.5
    }
}

struct Cable;

impl PotentialEnergy<4, 2> for Cable {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 4>, b: &SVector<S, 2>, _t: S) -> S {
        let strain = (q[2] - q[0]).hypot(q[3] - q[1]) - b[1];
        b[0] * strain * strain * 0.5
    }
}

/// A floor at y = 0 that pushes by k e^(−y/d), damps and slows by friction; and the weight. b = [m, 1/d].
struct SoftFloor;

impl Force<2, 0, 2> for SoftFloor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 2>) -> SVector<S, 2> {
        let push = (-(at.q[1] * b[1])).exp() * b[0];
        vector![-(push * at.v[0] * 0.1), push - at.v[1] * push * 0.1 - b[0] * 9.81]
    }
}

/// A floor that pushes by k max(0, −y)^(3/2), as spheres do after Hertz; and the weight. b = [m, k].
struct HertzianFloor;

impl Force<2, 0, 2> for HertzianFloor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 2>) -> SVector<S, 2> {
        let push = (-at.q[1]).max(S::from(0.0)).powf(1.5) * b[1];
        vector![-(push * at.v[0] * 0.1), push - b[0] * 9.81]
    }
}

/// ½ (y − b)².
struct Height;

impl Cost<1> for Height {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        let error = at.q[0] - 1.5;
        error * error * 0.5
    }
}

/// Masses above a floor, each tied to the next; a push on the first.
fn masses<const N: usize>(soft: bool) -> Scene {
    let mut scene = Scene::new();
    let mut last: Option<[Coordinate; 2]> = None;
    for k in 0..N {
        let q = scene.coordinates(&format!("mass {k}"), ["x", "y"]);
        let height = if soft { 0.3 } else { -0.001 };
        scene.place(q[0], 0.1 * k as f64);
        scene.place(q[1], height + 0.002 * (k * k) as f64);
        scene.kinetic_energy(&format!("mass {k}"), Mass, q, [0.1.into()]);
        let name = format!("floor under {k}");
        match soft {
            true => scene.force(&name, SoftFloor, q, [], [0.1.into(), 20.0.into()]),
            false => scene.force(&name, HertzianFloor, q, [], [0.1.into(), 1e6.into()]),
        };
        if let Some([x, y]) = last {
            scene.potential_energy(&format!("cable {k}"), Cable, [x, y, q[0], q[1]], [200.0.into(), 0.09.into()]);
        }
        scene.cost(&format!("height {k}"), Height, Sum::Terminal, [q[1]], [], [], []);
        last = Some(q);
    }
    push(&mut scene, last.expect("a mass")[0]);
    scene
}

/// A control that acts on a coordinate.
struct Push;

impl Force<1, 1> for Push {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        vector![at.u[0]]
    }
}

fn push(scene: &mut Scene, on: Coordinate) {
    let u = scene.control("push");
    scene.force("push", Push, [on], [u], []);
}

/// A box in natural coordinates, its centre r and three axes dᵢ fixed to it: T = ½ (m |ṙ|² + Σ eᵢ |ḋᵢ|²), V = m g z; b = [m, e₁, e₂, e₃].
struct Box12;

impl KineticEnergy<12, 4> for Box12 {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 12>, v: &SVector<S, 12>, b: &SVector<S, 4>) -> S {
        (0..12).map(|i| b[i / 3] * v[i] * v[i]).sum::<S>() * 0.5
    }
}

impl PotentialEnergy<12, 4> for Box12 {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 12>, b: &SVector<S, 4>, _t: S) -> S {
        b[0] * q[2] * 9.81
    }
}

/// dᵢ·dⱼ = δᵢⱼ, six equations.
struct Rigid;

impl Constraint<9, 6> for Rigid {
    fn phi<S: Scalar>(&self, q: &SVector<S, 9>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 6> {
        let dot = |i: usize, j: usize| q.fixed_rows::<3>(3 * i).dot(&q.fixed_rows::<3>(3 * j));
        vector![(dot(0, 0) - 1.0) * 0.5, (dot(1, 1) - 1.0) * 0.5, (dot(2, 2) - 1.0) * 0.5, dot(0, 1), dot(0, 2), dot(1, 2)]
    }
}

/// r + b₀ d₁ = r' + b₁ d₁', and r + b₀ d₁ = 0.
struct Ball;

impl Constraint<12, 3, 2> for Ball {
    fn phi<S: Scalar>(&self, q: &SVector<S, 12>, b: &SVector<S, 2>, _t: S) -> SVector<S, 3> {
        SVector::from_fn(|k, _| q[k] + b[0] * q[3 + k] - q[6 + k] - b[1] * q[9 + k])
    }
}

impl Constraint<6, 3, 1> for Ball {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 1>, _t: S) -> SVector<S, 3> {
        SVector::from_fn(|k, _| q[k] + b[0] * q[3 + k])
    }
}

/// Boxes of 1 m, end to end along x, that fall from rest.
fn boxes(count: usize) -> Scene {
    const AXES: [&str; 12] = ["x", "y", "z", "d1x", "d1y", "d1z", "d2x", "d2y", "d2z", "d3x", "d3y", "d3z"];
    let mut scene = Scene::new();
    let mut last: Option<[Coordinate; 12]> = None;
    for k in 0..count {
        let q = scene.coordinates(&format!("box {k}"), AXES);
        let values = [k as f64 + 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        q.iter().zip(values).for_each(|(q, value)| scene.place(*q, value));
        let b = [1.0.into(), 0.083.into(), 0.002.into(), 0.002.into()];
        scene.kinetic_energy(&format!("box {k}"), Box12, q, b);
        scene.potential_energy(&format!("weight {k}"), Box12, q, b);
        scene.constraint(&format!("axes {k}"), Rigid, std::array::from_fn(|i| q[3 + i]), []);
        let name = format!("ball joint {k}");
        let [rx, ry, rz, dx, dy, dz, ..] = q;
        match last {
            None => scene.constraint(&name, Ball, [rx, ry, rz, dx, dy, dz], [(-0.5).into()]),
            Some([x, y, z, ex, ey, ez, ..]) => {
                scene.constraint(&name, Ball, [x, y, z, ex, ey, ez, rx, ry, rz, dx, dy, dz], [0.5.into(), (-0.5).into()])
            }
        };
        scene.cost(&format!("height {k}"), Height, Sum::Terminal, [q[2]], [], [], []);
        last = Some(q);
    }
    push(&mut scene, last.expect("a box")[1]);
    scene
}

/// ½ qᵀ A q with a full matrix A.
struct QuadraticForm;

impl Cost<20> for QuadraticForm {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 20, 0, 0>, _b: &SVector<S, 0>) -> S {
        let entry = |i: usize, j: usize| at.q[i] * at.q[j] * (0.1 * ((7 * i + 3 * j) as f64).sin());
        (0..20).flat_map(|i| (0..20).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).sum::<S>() * 0.5
    }
}

/// The paper's cart, with or without a running cost of 20 of its 21 coordinates.
fn cart(quadratic: bool) -> Scene {
    let cart = CartPendulum::with_links(6).mechanism();
    let mut scene = cart.scene;
    let all: Vec<Coordinate> = [&cart.cart].into_iter().chain(&cart.links).flat_map(|body| body.coordinates).collect();
    for (j, link) in cart.links.iter().enumerate() {
        scene.cost(&format!("link {j}"), Height, Sum::Terminal, [link.coordinates[2]], [], [], []);
    }
    if quadratic {
        let coordinates: [Coordinate; 20] = std::array::from_fn(|i| all[i]);
        scene.cost("form", QuadraticForm, Sum::Trapezoidal, coordinates, [], [], []);
    }
    scene
}
