//! Rods in natural coordinates, the two ends (x₁, y₁, x₂, y₂) of each: their lengths are internal constraints, which every rod has and which join
//! it to nothing. They are eliminated with their rod, and the multipliers of the hinges make a chain of small nodes.

use crate::common::{assert_gradient_is_exact, largest_difference};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Force, ForcePoint, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Sum,
    System, simulate,
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

/// (r₂ − r₁) × (r₂' − r₁') = 0 for two rods: linear in the coordinates of each.
struct Parallel;

impl Constraint<8, 1> for Parallel {
    fn phi<S: Scalar>(&self, q: &SVector<S, 8>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        vector![(q[2] - q[0]) * (q[7] - q[5]) - (q[3] - q[1]) * (q[6] - q[4])]
    }
}

/// Rods in a line, which hinges join; they also stay parallel if `is_rigid`.
fn chain(rods: usize, is_rigid: bool) -> System {
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
        if let (true, Some([a, b, c, d])) = (is_rigid, last) {
            scene.constraint(&format!("angle {i}"), Parallel, [a, b, c, d, q[0], q[1], q[2], q[3]], []);
        }
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
    let nodes = |rods: usize| chain(rods, false).elimination();
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
        let (rods, bodies) = (chain(3, false), bodies(3));
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
    for is_rigid in [false, true] {
        let system = chain(4, is_rigid);
        let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.01));
        assert_gradient_is_exact("rods in natural coordinates", &system, &inputs);
    }
}

/// σᵀΦ_qq contains both rods of such a constraint, but K does not contain σᵀΦ_qq.
#[test]
fn only_multipliers_couple_bodies_that_a_bilinear_constraint_joins() {
    let nodes = chain(40, true).elimination();
    // A rod and its length couple to the three multipliers at either end, and these, one by one, to each other and to the next three.
    assert!(nodes.iter().all(|node| matches!(node, [5 | 7, ..=6] | [2, ..=4] | [1, ..=3])), "{nodes:?}");
}

/// T = ½ v².
struct Unit;

impl KineticEnergy<1> for Unit {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// A follower on a cam, x = φ², and one that is held where it is, x = 0.
struct Follows;
struct Held;

impl Constraint<2, 1> for Follows {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        vector![q[0] - q[1] * q[1]]
    }
}

impl Constraint<2, 1> for Held {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        vector![q[0]]
    }
}

/// Q_φ = √(1 + ẋ²) and Q_x = −sin ẋ: neither coordinate has constant derivatives.
struct Pull;

impl Force<2> for Pull {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, _b: &SVector<S, 0>) -> SVector<S, 2> {
        vector![-at.v[0].sin(), (at.v[0] * at.v[0] + 1.0).sqrt()]
    }
}

/// φ at the end of a motion from φ = 0, with coordinates of groups of their own in one order or the other, placed at φ₀.
fn turned(joint: impl Constraint<2, 1>, is_turned: bool, placed: f64, with_programs: bool) -> f64 {
    let mut scene = Scene::new();
    let names = if is_turned { ["phi", "x"] } else { ["x", "phi"] };
    let mut q = names.map(|name| scene.coordinates(name, ["value"])[0]);
    q.iter().zip(["first", "second"]).for_each(|(q, name)| scene.kinetic_energy(name, Unit, [*q], []));
    if is_turned {
        q.reverse();
    }
    scene.place(q[1], placed);
    scene.constraint("joint", joint, q, []);
    scene.force("pull", Pull, q, [], []);
    scene.cost("end", AngleError, Sum::Terminal, [q[1]], [], [], [0.3.into()]);
    let system = if with_programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    inputs.start.q_mut().fill(0.0);
    inputs.start.set_rate(q[1], 1.0);
    let motion = simulate(&system, &inputs, Settings::default()).expect("a motion");
    assert!(motion.inserted.is_empty());
    motion.q[(q[1].index(), 10)]
}

#[test]
fn a_slope_that_vanishes_where_a_motion_begins_or_everywhere_makes_no_step_singular() {
    for (is_turned, placed, with_programs) in
        [(false, 0.0, true), (false, 1.0, true), (false, 1.0, false), (true, 0.0, false), (true, 1.0, true)]
    {
        let cam = turned(Follows, is_turned, placed, with_programs);
        assert!((cam - turned(Follows, true, 0.0, true)).abs() < 1e-13, "{cam}");
        // Uniformly accelerated.
        let free = turned(Held, is_turned, placed, with_programs);
        assert!((free - 0.22).abs() < 1e-13, "{free}");
    }
}
