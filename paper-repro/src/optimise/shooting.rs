//! Rest after 2 s by multiple shooting: ten segments from a guess with uniformly turning links and no force, then fewer and fewer segments.

use std::f64::consts::{FRAC_PI_2, PI};

use hamiltonian_adjoint::optimize::{Iterate, MultipleShooting, Options, Outcome, interior_point, silent};
use hamiltonian_adjoint::{Error, Inputs, Settings, Trajectory};
use nalgebra::DVector;

use super::problems::Posed;

const SEGMENTS: usize = 10;

/// A solution with the given number of segments, and the work done.
struct Solution {
    problem: MultipleShooting,
    outcome: Outcome,
}

/// Solves with ten segments; if they are to be merged, finally as one motion.
pub fn solve(posed: &Posed, options: &Options, is_merged: bool) -> Result<(Outcome, Inputs), Error> {
    let (nodes, duration) = (posed.inputs.grid.nodes() as f64 - 1.0, posed.inputs.grid.steps.iter().sum::<f64>());
    let even = |node: usize, q: &mut DVector<f64>, v: &mut DVector<f64>| {
        // The first state is the cart's.
        for angle in posed.states[1..].iter().map(|state| state.coordinate.index()) {
            (q[angle], v[angle]) = (PI * node as f64 / nodes - FRAC_PI_2, PI / duration);
        }
    };
    let mut unforced = posed.inputs.clone();
    unforced.controls.fill(0.0);
    let mut found = minimise(posed, options, (&unforced, SEGMENTS), even)?;
    for segments in (1..SEGMENTS).rev().filter(|_| is_merged) {
        let inputs = found.problem.inputs_at(&found.outcome.x);
        let states = states(&found.problem);
        let before = found.outcome;
        found = minimise(posed, options, (&inputs, segments), |node, q, v| {
            q.copy_from(&states[node].0);
            v.copy_from(&states[node].1);
        })?;
        let last = found.outcome;
        let after = |it: Iterate| Iterate { evaluations: before.evaluations + it.evaluations, ..it };
        found.outcome = Outcome {
            iterations: before.iterations + last.iterations,
            evaluations: before.evaluations + last.evaluations,
            gradients: before.gradients + last.gradients,
            products: before.products + last.products,
            history: before.history.into_iter().chain(last.history.into_iter().map(after)).collect(),
            ..last
        };
    }
    let inputs = found.problem.inputs_at(&found.outcome.x);
    Ok((found.outcome, inputs))
}

fn minimise(
    Posed { system, free, constraints, states, .. }: &Posed,
    options: &Options,
    (inputs, segments): (&Inputs, usize),
    guess: impl FnMut(usize, &mut DVector<f64>, &mut DVector<f64>),
) -> Result<Solution, Error> {
    let mut problem = MultipleShooting::new(system, Settings::default(), inputs.clone(), free.clone(), states, segments)?;
    constraints.iter().for_each(|(output, to)| problem.constrain(*output, *to));
    problem.guess(guess)?;
    let start = problem.start();
    let outcome = interior_point(&mut problem, &start, options, &mut silent)?;
    Ok(Solution { problem, outcome })
}

/// q and v at all nodes except the last.
fn states(problem: &MultipleShooting) -> Vec<(DVector<f64>, DVector<f64>)> {
    let of_segment = |motion: &Trajectory| {
        let columns = (0..motion.q.ncols() - 1).map(|i| (motion.q.column(i).into_owned(), motion.v.column(i).into_owned()));
        columns.collect::<Vec<_>>()
    };
    problem.segments().flat_map(|segment| of_segment(segment.solver.trajectory())).collect()
}
