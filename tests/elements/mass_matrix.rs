//! Mass matrices that depend on the coordinates: T_q, the term that the paper's Eq. (1b) lacks, decides everything here.
//!
//! With `force` of the kinetic energy left out in `src/system/formula/energy.rs`, every test of this file fails.

use crate::common::{assert_gradient_is_exact, assert_order, bench::number, largest_difference};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Start, Sum, System, Trajectory,
    scenes::AngleError, simulate,
};
use nalgebra::{DVector, SVector, dvector};

const GRAVITY: f64 = 9.81;
/// Mass, moment of inertia about the centre, hinge to centre and length of each link of the double pendulum.
const LINKS: [[f64; 4]; 2] = [[1.1, 0.08, 0.4, 0.9], [0.7, 0.05, 0.3, 0.6]];

/// A double pendulum in its two angles from the x axis; b = [m₁, J₁, a₁, l₁, m₂, J₂, a₂].
struct DoublePendulum;

impl KineticEnergy<2, 7> for DoublePendulum {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 7>) -> S {
        let [m1, j1, a1, l1, m2, j2, a2] = [b[0], b[1], b[2], b[3], b[4], b[5], b[6]];
        let first = (j1 + m1 * a1 * a1 + m2 * l1 * l1) * v[0] * v[0];
        let second = (j2 + m2 * a2 * a2) * v[1] * v[1];
        (first + second) * 0.5 + m2 * l1 * a2 * (q[0] - q[1]).cos() * v[0] * v[1]
    }
}

impl PotentialEnergy<2, 7> for DoublePendulum {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 7>, _t: S) -> S {
        let [m1, _, a1, l1, m2, _, a2] = [b[0], b[1], b[2], b[3], b[4], b[5], b[6]];
        ((m1 * a1 + m2 * l1) * q[0].sin() + m2 * a2 * q[1].sin()) * GRAVITY
    }
}

const CONSTANTS: [f64; 7] = [LINKS[0][0], LINKS[0][1], LINKS[0][2], LINKS[0][3], LINKS[1][0], LINKS[1][1], LINKS[1][2]];

fn minimal() -> System {
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["φ1", "φ2"]);
    let names = ["m1", "J1", "a1", "l1", "m2", "J2", "a2"];
    let b = std::array::from_fn(|i| scene.design(names[i], CONSTANTS[i]).into());
    scene.kinetic_energy("T", DoublePendulum, q, b);
    scene.potential_energy("V", DoublePendulum, q, b);
    scene.cost("angle", AngleError, Sum::Rectangle, [q[1]], [], [], [0.3.into()]);
    scene.compile().expect("scene")
}

fn absolute(angles: [f64; 2]) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let [[m1, j1, a1, l1], [m2, j2, a2, _]] = LINKS;
    let [(s1, c1), (s2, c2)] = angles.map(f64::sin_cos);
    let one = scene.body("one", m1, j1, [a1 * c1, a1 * s1, angles[0]]);
    let two = scene.body("two", m2, j2, [l1 * c1 + a2 * c2, l1 * s1 + a2 * s2, angles[1]]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), one.at(-a1, 0.0));
    scene.revolute("elbow", one.at(l1 - a1, 0.0), two.at(-a2, 0.0));
    scene.compile().expect("scene")
}

fn run(system: &System, q: DVector<f64>, v: DVector<f64>, grid: Grid) -> Trajectory {
    let inputs = Inputs { start: Start::Velocity { q, v }, ..Inputs::at_rest(system, grid) };
    simulate(system, &inputs, Settings::default()).expect("motion")
}

fn last(motion: &Trajectory, coordinates: [usize; 2]) -> [f64; 2] {
    coordinates.map(|i| motion.q[(i, motion.q.ncols() - 1)])
}

#[test]
fn minimal_and_absolute_coordinates_give_the_same_double_pendulum() {
    let start = [0.3, -0.8];
    let (small, large) = (minimal(), absolute(start));
    let errors = [200, 400, 800, 1600].map(|steps| {
        let grid = Grid::uniform(steps, 2.0 / steps as f64);
        let angles = run(&small, dvector![start[0], start[1]], dvector![0.0, 0.0], grid.clone());
        let bodies = run(&large, large.initial_coordinates(), DVector::zeros(6), grid);
        largest_difference(&last(&angles, [0, 1]), &last(&bodies, [2, 5]))
    });
    assert_order("difference of the angles", &errors, 2.0, 0.05);
}

#[test]
fn the_gradient_of_a_double_pendulum_in_minimal_coordinates_is_exact() {
    let system = minimal();
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(60, 0.02));
    inputs.start = Start::Velocity { q: dvector![0.3, -0.8], v: dvector![1.0, -2.0] };
    inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= 1.0 + 0.3 * number(i));
    assert_gradient_is_exact("started with v", &system, &inputs);
    inputs.start = Start::Momentum { q: dvector![0.3, -0.8], p_star: dvector![0.5, -0.2] };
    assert_gradient_is_exact("started with p*", &system, &inputs);
}

/// The largest deviation of the energy from its value at the start, in the first and in the last tenth of a motion.
fn deviations(motion: &Trajectory, energy: impl Fn(&[f64], &[f64]) -> f64) -> [f64; 2] {
    let at = |i: usize| energy(motion.q.column(i).as_slice(), motion.v.column(i).as_slice());
    let (start, nodes) = (at(0), motion.q.ncols());
    let worst = |nodes: std::ops::Range<usize>| nodes.fold(0.0f64, |worst, i| worst.max((at(i) - start).abs()));
    [worst(0..nodes / 10), worst(nodes - nodes / 10..nodes)]
}

fn assert_energy_stays(what: &str, [first, last]: [f64; 2], [fine_first, fine_last]: [f64; 2]) {
    println!("{what}: first tenth {first:.2e} J, last {last:.2e} J; at half the step {fine_first:.2e} J, {fine_last:.2e} J");
    assert!(last < 1.2 * first, "{what}: the error grows from {first:.2e} J to {last:.2e} J");
    let order = (first.max(last) / fine_first.max(fine_last)).log2();
    assert!((order - 2.0).abs() < 0.05, "{what}: order {order:.3}");
}

#[test]
fn the_energy_of_a_double_pendulum_stays_near_its_start_for_ten_thousand_steps() {
    let system = minimal();
    let energy = |q: &[f64], v: &[f64]| {
        let (q, v, b) = (SVector::from([q[0], q[1]]), SVector::from([v[0], v[1]]), SVector::from(CONSTANTS));
        DoublePendulum.kinetic_energy(&q, &v, &b) + DoublePendulum.potential_energy(&q, &b, 0.0)
    };
    let deviations = |steps: usize| {
        let motion = run(&system, dvector![-1.3, -1.9], dvector![0.0, 0.0], Grid::uniform(steps, 100.0 / steps as f64));
        deviations(&motion, energy)
    };
    assert_energy_stays("double pendulum", deviations(10_000), deviations(20_000));
}

/// T = ½ J(φ) φ̇² of a slider-crank with a massless rod: crank J, slider m at x = r cos φ + √(l² − r² sin² φ); b = [J, m, r, l].
struct SliderCrank;

impl SliderCrank {
    /// J(φ) = J + m (dx/dφ)².
    fn inertia<S: Scalar>(q: S, b: &SVector<S, 4>) -> S {
        let (sin, cos) = q.sin_cos();
        let rod = (b[3] * b[3] - b[2] * b[2] * sin * sin).sqrt();
        let slope = -(b[2] * sin) - b[2] * b[2] * sin * cos / rod;
        b[0] + b[1] * slope * slope
    }
}

impl KineticEnergy<1, 4> for SliderCrank {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 4>) -> S {
        SliderCrank::inertia(q[0], b) * v[0] * v[0] * 0.5
    }
}

const CRANK: [f64; 4] = [0.05, 0.9, 0.3, 0.8];

fn slider_crank() -> System {
    let mut scene = Scene::new();
    let q = scene.coordinates("crank", ["φ"]);
    let b = std::array::from_fn(|i| scene.design(["J", "m", "r", "l"][i], CRANK[i]).into());
    scene.kinetic_energy("T", SliderCrank, q, b);
    scene.cost("angle", AngleError, Sum::Trapezoidal, q, [], [], [1.0.into()]);
    scene.compile().expect("scene")
}

#[test]
fn a_free_slider_crank_keeps_half_j_v_squared() {
    let system = slider_crank();
    let inertia = |q: f64| SliderCrank::inertia(q, &SVector::from(CRANK));
    let errors = [200, 400, 800, 1600].map(|steps| {
        let motion = run(&system, dvector![0.4], dvector![3.0], Grid::uniform(steps, 2.0 / steps as f64));
        let exact = |i: usize| 3.0 * (inertia(0.4) / inertia(motion.q[i])).sqrt();
        let closed: Vec<f64> = (0..=steps).map(exact).collect();
        largest_difference(motion.v.as_slice(), &closed)
    });
    assert_order("v of the crank", &errors, 2.0, 0.05);
}

#[test]
fn the_energy_of_a_free_slider_crank_stays_near_its_start_for_ten_thousand_steps() {
    let system = slider_crank();
    let energy = |q: &[f64], v: &[f64]| 0.5 * SliderCrank::inertia(q[0], &SVector::from(CRANK)) * v[0] * v[0];
    let deviations = |steps: usize| {
        let motion = run(&system, dvector![0.4], dvector![3.0], Grid::uniform(steps, 100.0 / steps as f64));
        deviations(&motion, energy)
    };
    assert_energy_stays("slider-crank", deviations(10_000), deviations(20_000));
}

#[test]
fn the_gradient_of_a_slider_crank_is_exact() {
    let system = slider_crank();
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(60, 0.02));
    inputs.start = Start::Velocity { q: dvector![0.4], v: dvector![3.0] };
    assert_gradient_is_exact("slider-crank", &system, &inputs);
}
