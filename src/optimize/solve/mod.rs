//! [`solve`]: a problem stated once, solved by what fits: segments from a guess of the states, joined to one motion.

mod attempt;
mod guess;
mod solved;

use super::{MotionProblem, Options, Reason, Watcher, interior_point};
use crate::Error;
use attempt::in_segments;
pub use guess::Guess;
use guess::Line;
pub use solved::{Attempt, Solved};

/// Numbers of steps of a segment, in the order in which they are tried.
const STEPS: [usize; 4] = [5, 10, 1, 3];

/// Minimises J of a motion subject to constraints on its outputs, from a guess of its states.
///
/// The motion is divided into segments that begin at the guess ([`Guess`]) and meet in the course of the optimisation
/// ([`stages`](super::stages())). Then their starts q and p\* become variables, so that the result is a single motion, which minimises J as the
/// problem states it. Segments of different lengths are tried until one of them leads to a minimum; if none does,
/// [`interior_point`](super::interior_point()) continues from the best result as one motion. The problem is left with the motion of the
/// solution, and [`Solved`] lists what was tried.
///
/// ```
/// use hamiltonian_adjoint::optimize::{Free, Guess, Interval, MotionProblem, Options, Variables, silent, solve};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
/// use std::f64::consts::FRAC_PI_2;
///
/// let mut cart = CartPendulum::with_links(2).mechanism();
/// cart.scene.effort("effort", cart.force, 1e-4);
/// let rail = cart.scene.end_state(cart.cart.coordinates[0]);
/// let links: Vec<_> = cart.links.iter().map(|link| cart.scene.end_state(link.coordinates[2])).collect();
/// let system = cart.scene.compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(80, 0.02));
/// let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)])?;
/// let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
/// // Upright and at rest, wherever the cart is.
/// problem.constrain(rail.rate, Interval::ZERO);
/// for link in links {
///     problem.constrain(link.position, Interval::equal(FRAC_PI_2));
///     problem.constrain(link.rate, Interval::ZERO);
/// }
/// let solved = solve(&mut problem, &Guess::Straight, &Options::default(), &mut silent)?;
/// assert!(solved.outcome.reason.is_converged(), "{solved}");
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// Invalid sizes, bounds, options or guesses, or a problem without Hessian products.
pub fn solve(problem: &mut MotionProblem, guess: &Guess, options: &Options, watch: &mut Watcher) -> Result<Solved, Error> {
    let start = problem.start();
    options.fit(problem, &start)?;
    let mut attempts = Vec::new();
    let line = match guess {
        Guess::Inputs => None,
        _ => Line::new(problem, guess)?,
    };
    let ways = line.iter().flat_map(|line| counts(problem).into_iter().map(move |segments| (line, segments)));
    for (line, segments) in ways.collect::<Vec<_>>() {
        let Some(outcome) = in_segments(problem, (line, segments), options, watch)? else { continue };
        attempts.push(Attempt::of(format!("{segments} segments"), &outcome));
        if outcome.reason.is_converged() || outcome.reason == Reason::Interrupted {
            return Ok(Solved { outcome, attempts });
        }
    }
    let outcome = interior_point(problem, &start, options, watch)?;
    attempts.push(Attempt::of("one motion".into(), &outcome));
    Ok(Solved { outcome, attempts })
}

/// The numbers of segments that are tried.
fn counts(problem: &MotionProblem) -> Vec<usize> {
    let steps = problem.inputs_at(&problem.start()).grid.macro_ends().count();
    let mut counts: Vec<usize> = Vec::new();
    for count in STEPS.into_iter().map(|of| steps / of).filter(|count| *count > 1) {
        if !counts.contains(&count) {
            counts.push(count);
        }
    }
    counts
}
