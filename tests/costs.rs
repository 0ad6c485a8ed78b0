//! J is the sum that each way of summing promises, whoever computes it.

mod common;

use common::bench::number;
use hamiltonian_adjoint::scenes::{CartPendulum, CartScene};
use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Settings, Solver, Sum};
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
    for sum in [Sum::Plain, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral, Sum::Terminal, Sum::Node(17)] {
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
            Sum::Rectangle => (0..last).map(|i| dt[i] * h(i)).sum(),
            Sum::Trapezoidal | Sum::Integral => (1..=last).map(|i| dt[i - 1] * 0.5 * (h(i - 1) + h(i))).sum(),
            Sum::Terminal => h(last),
            Sum::Node(node) => h(node),
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
