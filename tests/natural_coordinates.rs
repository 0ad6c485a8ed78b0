//! Rods in natural coordinates, the two ends (x₁, y₁, x₂, y₂) of each: their lengths are internal constraints, which every rod has and which join
//! it to nothing. They are eliminated with their rod, and the multipliers of the hinges make a chain of small nodes.

mod common;

use common::{assert_gradient_is_exact, largest_difference};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Sum, System, simulate,
};
use nalgebra::{SVector, vector};

const MASS: f64 = 0.7;
const GRAVITY: f64 = 9.81;
/// From the x axis, of every rod at the start.
const ANGLE: f64 = -0.4;

/// T = m/6 (ṙ₁² + ṙ₁·ṙ₂ + ṙ₂²) and V = ½ m g (y₁ + y₂) of a uniform rod.
struct Rod;

impl KineticEnergy<4> for Rod {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 4>, v: &SVector<S, 4>, _b: &SVector<S, 0>) -> S {
        (v.dot(v) + v[0] * v[2] + v[1] * v[3]) * (MASS / 6.0)
    }
}

impl PotentialEnergy<4> for Rod {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 4>, _b: &SVector<S, 0>, _t: S) -> S {
        (q[1] + q[3]) * (0.5 * MASS * GRAVITY)
    }
}

/// |r₂ − r₁|² = l².
struct Length;

impl Constraint<4, 1, 1> for Length {
    fn phi<S: Scalar>(&self, q: &SVector<S, 4>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        let (x, y) = (q[2] - q[0], q[3] - q[1]);
        vector![x * x + y * y - b[0] * b[0]]
    }
}

/// r = 0, and r = r'.
struct Fixed;

impl Constraint<2, 2> for Fixed {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 2> {
        *q
    }
}

struct Shared;

impl Constraint<4, 2> for Shared {
    fn phi<S: Scalar>(&self, q: &SVector<S, 4>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 2> {
        vector![q[0] - q[2], q[1] - q[3]]
    }
}

fn chain(rods: usize) -> System {
    let mut scene = Scene::new();
    let (sin, cos) = ANGLE.sin_cos();
    let length = scene.design("length", 1.0);
    let mut last: Option<[Coordinate; 4]> = None;
    for i in 0..rods {
        let q = scene.coordinates(&format!("rod {i}"), ["x1", "y1", "x2", "y2"]);
        let place = |k: usize| [k as f64 * cos, k as f64 * sin];
        for (coordinate, value) in q.into_iter().zip([place(i), place(i + 1)].concat()) {
            scene.place(coordinate, value);
        }
        scene.kinetic_energy(&format!("energy of rod {i}"), Rod, q, []);
        scene.potential_energy(&format!("weight of rod {i}"), Rod, q, []);
        scene.constraint(&format!("length of rod {i}"), Length, q, [length.into()]);
        match last {
            None => scene.constraint("hook", Fixed, [q[0], q[1]], []),
            Some(before) => scene.constraint(&format!("hinge {i}"), Shared, [before[2], before[3], q[0], q[1]], []),
        };
        last = Some(q);
    }
    if let Some([.., y]) = last {
        scene.cost("height of the end", AngleError, Sum::Trapezoidal, [y], [], [], [0.3.into()]);
    }
    scene.compile().expect("a scene")
}

/// The same chain with bodies.
fn bodies(rods: usize) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let (sin, cos) = ANGLE.sin_cos();
    let mut hook = Body::GROUND.at(0.0, 0.0);
    for i in 0..rods {
        let middle = i as f64 + 0.5;
        let body = scene.body(&format!("rod {i}"), MASS, MASS / 12.0, [middle * cos, middle * sin, ANGLE]);
        scene.revolute(&format!("hinge {i}"), hook, body.at(-0.5, 0.0));
        hook = body.at(0.5, 0.0);
    }
    scene.compile().expect("a scene")
}

#[test]
fn internal_constraints_are_eliminated_with_their_body() {
    let nodes = |rods: usize| chain(rods).elimination();
    let work = |rods: usize| nodes(rods).iter().map(|[size, width]| size * (size + width).pow(2)).sum::<usize>();
    // A rod and its length; the first hinge is that of a root. A hinge couples to the next ones on both sides.
    assert!(nodes(40).iter().all(|node| matches!(node, [5 | 7, ..=4] | [2, ..=4])), "{:?}", nodes(40));
    println!("{} multiplications", work(40));
    assert_eq!(work(40) - work(30), work(20) - work(10));
    assert!(work(40) < 20_000);
}

#[test]
fn rods_in_natural_coordinates_move_like_bodies() {
    let middles = |steps: usize| {
        let (rods, bodies) = (chain(3), bodies(3));
        let [rods, bodies] = [&rods, &bodies].map(|system| {
            let inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.5 / steps as f64));
            simulate(system, &inputs, Settings::default()).expect("a motion").q.column(steps).into_owned()
        });
        let of_rods: Vec<f64> = (0..3).flat_map(|i| [0, 1].map(|k| 0.5 * (rods[4 * i + k] + rods[4 * i + k + 2]))).collect();
        let of_bodies: Vec<f64> = (0..3).flat_map(|i| [0, 1].map(|k| bodies[3 * i + k])).collect();
        largest_difference(&of_rods, &of_bodies)
    };
    let errors = [100, 200, 400].map(middles);
    println!("{errors:?}");
    assert!(errors[2] < 1e-4 && errors[0] / errors[1] > 3.8 && errors[1] / errors[2] > 3.8, "{errors:?}");
}

#[test]
fn their_gradient_is_exact() {
    let system = chain(4);
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.01));
    inputs.design[0] = 1.0;
    assert_gradient_is_exact("rods in natural coordinates", &system, &inputs);
}
