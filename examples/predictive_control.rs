//! Model predictive control: a pushed pendulum is balanced by a cart whose bounded force is optimised anew 50 times a second, each time over the next
//! second. The model's link is a tenth lighter than that of the plant.
//!
//! `cargo run --release --example predictive_control`

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::time::Instant;

use hamiltonian_adjoint::optimize::{Free, Guess, MotionProblem, Options, Variables, silent, solve};
use hamiltonian_adjoint::scenes::{CartPendulum, CartScene};
use hamiltonian_adjoint::{Cost, CostPoint, Grid, Held, Inputs, Scalar, Settings, Solver, Start, Sum};
use nalgebra::{DVector, SVector};

/// Time between two optimisations, s; length of the horizon in such steps; number of optimisations.
const STEP: f64 = 0.02;
const HORIZON: usize = 50;
const SOLVES: usize = 50;
/// The largest force, N, and the rate of the link after the push, rad/s.
const MOST: f64 = 9.0;
const PUSH: f64 = 1.8;

/// h = ½ [100 (φ − π/2)² + 10 x² + φ̇² + ẋ² + 0.01 u²].
struct Deviation;

impl Cost<2, 0, 1> for Deviation {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 1>, _b: &SVector<S, 0>) -> S {
        let (angle, place) = (at.q[0] - FRAC_PI_2, at.q[1]);
        let of_state = angle * angle * 100.0 + place * place * 10.0 + at.v[0] * at.v[0] + at.v[1] * at.v[1];
        (of_state + at.u[0] * at.u[0] * 0.01) * 0.5
    }
}

fn pendulum(link_mass: f64) -> CartScene {
    let upright = CartPendulum { start_angle: FRAC_PI_2, link_mass, ..CartPendulum::with_links(1) };
    upright.mechanism()
}

fn main() -> Result<(), Box<dyn Error>> {
    let CartScene { mut scene, force, cart, links, .. } = pendulum(0.36);
    let (angle, place) = (links[0].coordinates[2], cart.coordinates[0]);
    scene.cost("deviation", Deviation, Sum::Trapezoidal, [angle, place], [], [force], []);
    let model = scene.compile()?;
    let plant = pendulum(0.4).scene.compile()?;

    // The link turns about its hinge, 0.5 m below its centre.
    let mut state = Inputs::at_rest(&plant, Grid::uniform(4, STEP / 4.0));
    let mut v = DVector::zeros(plant.n());
    (v[links[0].coordinates[0].index()], v[angle.index()]) = (-0.5 * PUSH, PUSH);
    state.start = Start::Assembled { q: state.start.q().clone(), v, held: Held::default() };
    let mut inputs = Inputs::at_rest(&model, Grid::uniform(HORIZON, STEP));
    inputs.start = state.start.clone();
    let variables = Variables::new(&model, &inputs, vec![Free::control(force).within(-MOST, MOST)])?;
    let mut problem = MotionProblem::new(&model, Settings::default(), inputs, variables)?;
    let mut simulation = Solver::new(&plant, Settings::default());

    let options = Options { stationarity: 1e-6, ..Options::default() };
    let mut best = solve(&mut problem, Guess::Straight, &options, &mut silent)?.outcome;
    println!("{:>6} {:>10} {:>9} {:>9} {:>11} {:>9}", "t, s", "angle, °", "cart, m", "force, N", "iterations", "ms");
    let (mut most, mut saturated) = (0, 0);
    for k in 1..=SOLVES {
        // The plant moves for one step under the force of the last optimum.
        let forces = [best.x[0], best.x[1]];
        state.set_control(force, |t| forces[0] + (forces[1] - forces[0]) * t / STEP);
        let motion = simulation.simulate(&state)?;
        let [q, v]: [DVector<f64>; 2] = [&motion.q, &motion.v].map(|of| of.column(of.ncols() - 1).into_owned());
        // The joints of the plant have drifted apart a little.
        state.start = Start::Assembled { q: q.clone(), v, held: Held::default() };
        // The horizon moves on: the controls by one node, and the start to the state of the plant.
        best.x.rotate_left(1);
        best.x[HORIZON] = best.x[HORIZON - 1];
        problem.change(|inputs| inputs.start = state.start.clone())?;
        let begun = Instant::now();
        let found = solve(&mut problem, Guess::from(&best), &options, &mut silent)?;
        if !found.outcome.reason.is_converged() {
            return Err(format!("the optimisation {k} failed:\n{found}\n{}", found.outcome).into());
        }
        best = found.outcome;
        most = most.max(best.iterations);
        saturated += usize::from(best.x[0].abs() > MOST - 1e-3);
        if k % 5 == 0 {
            let (t, degrees) = (k as f64 * STEP, (q[angle.index()] - FRAC_PI_2).to_degrees());
            let milliseconds = 1e3 * begun.elapsed().as_secs_f64();
            let place = q[place.index()];
            println!("{t:>6.2} {degrees:>10.3} {place:>9.4} {:>9.3} {:>11} {milliseconds:>9.1}", best.x[0], best.iterations);
        }
    }
    println!("{SOLVES} optimisations, at most {most} iterations each; {saturated} begin with the largest force");
    Ok(())
}
