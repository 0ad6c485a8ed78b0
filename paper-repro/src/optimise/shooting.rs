//! At rest after 2 s by multiple shooting: in ten segments from links that turn evenly, then as one motion.

use std::f64::consts::{FRAC_PI_2, PI};

use hamiltonian_adjoint::optimize::{MotionProblem, MultipleShooting, Options, Outcome, Variables, interior_point, silent};
use hamiltonian_adjoint::{Error, Inputs, Settings};

use super::Posed;

const SEGMENTS: usize = 10;

/// The solution as one motion, with what both together took, and its inputs.
pub fn solve(posed: &Posed, options: &Options) -> Result<(Outcome, Inputs), Error> {
    let Posed { system, inputs, free, constraints, states, .. } = posed;
    let settings = Settings::default();
    let mut problem = MultipleShooting::new(system, settings, inputs.clone(), free.clone(), states, SEGMENTS)?;
    constraints.iter().for_each(|(output, to)| problem.constrain(*output, *to));
    let (nodes, duration) = (inputs.grid.nodes() as f64 - 1.0, inputs.grid.steps.iter().sum::<f64>());
    problem.guess(|node, q, v| {
        // The first state is the cart's.
        for angle in states[1..].iter().map(|state| state.coordinate.index()) {
            (q[angle], v[angle]) = (PI * node as f64 / nodes - FRAC_PI_2, PI / duration);
        }
    })?;
    let start = problem.start();
    let parts = interior_point(&mut problem, &start, options, &mut silent)?;
    let inputs = problem.inputs_at(&parts.x);
    let variables = Variables::new(system, &inputs, free.clone())?;
    let mut one = MotionProblem::new(system, settings, inputs, variables)?;
    constraints.iter().for_each(|(output, to)| one.constrain(*output, *to));
    let start = one.start();
    let whole = interior_point(&mut one, &start, options, &mut silent)?;
    let inputs = one.inputs_at(&whole.x);
    let outcome = Outcome {
        evaluations: parts.evaluations + whole.evaluations,
        gradients: parts.gradients + whole.gradients,
        products: parts.products + whole.products,
        history: parts.history.into_iter().chain(whole.history).collect(),
        ..whole
    };
    Ok((outcome, inputs))
}
