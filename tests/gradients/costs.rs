//! J is the sum that each way of summing promises, whoever computes it.

use crate::common::bench::number;
use hamiltonian_adjoint::scenes::{CartPendulum, CartScene};
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver, Sum, gradient,
};
use nalgebra::SVector;

/// x² + t v + b u.
struct Mixed;
impl Cost<1, 0, 1, 1> for Mixed {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 1>, b: &SVector<S, 1>) -> S {
        at.q[0] * at.q[0] + at.t * at.v[0] + b[0] * at.u[0]
    }
}

const WEIGHT: f64 = 0.3;

#[test]
fn every_way_of_summing_gives_the_sum_written_by_hand() {
    for sum in [Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral, Sum::Terminal, Sum::Node(17)] {
        let cart = CartPendulum::with_links(2);
        let CartScene { mut scene, links, .. } = cart.mechanism();
        let [_, _, angle] = links[1].coordinates;

        let control = scene.control("unused");
        scene.cost("mixed", Mixed, sum, [angle], [], [control], [WEIGHT.into()]);
        let system = scene.compile().expect("scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
        inputs.grid.start = 0.4;
        inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= 1.0 + 0.5 * number(i));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 3.0 * number(i + 5));

        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs).expect("motion").clone();
        let i = angle.index();
        let h = |node: usize| {
            let (q, v, u) = (motion.q[(i, node)], motion.v[(i, node)], inputs.controls[(control.index(), node)]);
            q * q + motion.times[node] * v + WEIGHT * u
        };
        let (dt, last) = (&inputs.grid.steps, inputs.grid.steps.len());
        let by_hand: f64 = match sum {
            Sum::Plain => (0..last).map(h).sum(),
            Sum::AllNodes => (0..=last).map(h).sum(),
            Sum::Rectangle => (0..last).map(|i| dt[i] * h(i)).sum(),
            Sum::Trapezoidal | Sum::Integral => (1..=last).map(|i| dt[i - 1] * 0.5 * (h(i - 1) + h(i))).sum(),
            Sum::Terminal => h(last),
            Sum::Node(node) => h(node),
            Sum::Event(_) | Sum::AfterEvent(_) => 0.0,
        };
        let found = [
            solver.cost().expect("cost"),
            motion.cost(&system, &inputs).expect("cost"),
            solver.gradient().expect("gradient").value,
        ];
        for j in found {
            assert!((j - by_hand).abs() <= 1e-14 * by_hand.abs(), "{sum:?}: {found:?} instead of {by_hand}");
        }
    }
}

/// Σ (q_i − b_i)².
struct Tracking;
impl<const N: usize> Cost<N, 0, 0, N> for Tracking {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, 0, 0>, b: &SVector<S, N>) -> S {
        (0..N).map(|i| (at.q[i] - b[i]).powi(2)).sum()
    }
}

/// J and dJ/dΔt of a cost whose squares are far smaller than the numbers in them; with programs or without.
fn tracking<const N: usize>(programs: bool) -> [f64; 2] {
    let mut scene = Scene::new();
    let far = |i: usize| 1e4 * (1.0 + 0.1 * i as f64);
    let free: [Coordinate; N] = std::array::from_fn(|i| scene.coordinates(&format!("free {i}"), ["x"])[0]);
    for (i, x) in free.into_iter().enumerate() {
        scene.place(x, far(i) + 1e-5);
        scene.kinetic_energy(&format!("mass {i}"), Mass, [x], []);
    }
    scene.cost("tracking", Tracking, Sum::Trapezoidal, free, [], [], std::array::from_fn(|i| far(i).into()));
    let system = if programs { scene.compile() } else { scene.compile_without_programs() }.expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
    let gradient = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    [gradient.value, gradient.steps[2]]
}

struct Mass;
impl KineticEnergy<1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// Slopes of squares of small differences of large numbers, too.
#[test]
fn slopes_of_many_arguments_keep_their_digits() {
    for far in [0.0, 1e3, 5e6, 1e8] {
        let mut scene = Scene::new();
        let free: [Coordinate; 6] = std::array::from_fn(|i| scene.coordinates(&format!("free {i}"), ["x"])[0]);
        for (i, x) in free.into_iter().enumerate() {
            scene.place(x, far + 1.0 + 0.125 * i as f64);
            scene.kinetic_energy(&format!("mass {i}"), Mass, [x], []);
        }
        scene.cost("tracking", Tracking, Sum::Terminal, free, [], [], [far.into(); 6]);
        let system = scene.compile().expect("scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.125));
        let gradient = gradient(&system, &inputs, Settings::default()).expect("a gradient");
        for (i, slope) in gradient.start.q().iter().enumerate() {
            assert_eq!(*slope, 2.0 * (1.0 + 0.125 * i as f64), "{far:e}");
        }
    }
}

#[test]
fn small_sums_of_squares_of_many_arguments_keep_their_digits() {
    for [with, without] in [[true, false].map(tracking::<3>), [true, false].map(tracking::<8>)] {
        let differences = [0, 1].map(|k| (with[k] - without[k]).abs() / without[k].abs());
        assert!(without[0] > 0.0 && differences.iter().all(|x| *x <= 1e-13), "{with:?} {without:?}");
    }
}
