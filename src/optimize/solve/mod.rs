//! [`solve`]: a problem stated once, solved by what fits: segments from a guess of the states, joined to one motion.

mod accuracy;
mod apart;
mod attempt;
mod balanced;
mod corrected;
mod division;
mod guess;
mod halved;
mod pose;
mod reach;
mod saturated;
mod sensitivity;
mod solved;
mod starts;
mod turns;
mod ways;

use super::{Iterate, MotionProblem, Options, Outcome, Watcher, silent};
use crate::Error;
use crate::solver::each;
use accuracy::make_accurate;
pub use guess::{Guess, Search};
pub(super) use reach::start_of;
use reach::without_known;
pub use sensitivity::{Parameter, Sensitivity, sensitivities};
pub use solved::{Attempt, Solved};
use starts::Starts;
use turns::Turns;
use ways::{Start, from_start, is_hopeless, is_solved, settles_at};

/// Number of starts that are tried together, and of starts that must lead to the best value, not from near it, until no others are tried.
const TOGETHER: usize = 4;
const AGAIN: usize = 6;
/// Relative difference of values that are the same.
const ALIKE: f64 = 1e-4;

/// Minimises J of a motion subject to constraints on its outputs, from a guess of its states.
///
/// The motion is divided into segments that begin at the guess ([`Guess`]) and meet in the course of the optimisation
/// ([`stages`](super::stages())). Then their starts q and p\* become variables, so that the result is a single motion, which minimises J as the
/// problem states it. The error of a state grows along an unstable motion, so that one motion may violate constraints that the segments satisfied;
/// small violations are removed. If segments do not lead to a minimum, [`interior_point`](super::interior_point()) starts from the inputs of the problem
/// as one motion, and then segments of other lengths are tried. After three ways that end where the violation cannot be reduced, no others are tried.
/// If nothing leads to a minimum, the outcome is that with the smallest violation or, after such ways, one that is
/// [`Reason::Infeasible`](super::Reason::Infeasible).
///
/// If no state at the end has the values that are asked for, one motion is tried first, and `Reason::Infeasible` ends the search. Constraints on states at
/// the first or the last node that contradict each other or a fixed start end it after at most 100 iterations and as many of a feasibility phase, and those
/// at another node after the first way. [`Warning::NoState`](crate::Warning::NoState) names them.
///
/// Before segments are solved, a control that lies at its bound at all nodes is moved away from it, because steps end at bounds: by a tenth of the distance
/// between both bounds or, from a single bound, by about as much as moves the scene.
///
/// A value that decreases without bound ends the search, too ([`Reason::Unbounded`](super::Reason::Unbounded)).
///
/// If the duration is free, a feasible motion with about the duration of the start is sought first, without the bounds of the controls.
///
/// If a [`Search`] has several starts, the others have random controls, durations and guesses, and the lowest minimum is returned. Every second one
/// begins near the best minimum found before. Each of them is tried in one way, in segments or as one motion, and most of them in the way that led to
/// more minima for the same work. With the feature `rayon` they run on all cores; the outcome is the same. No further start is tried
/// once several of the others led to the lowest minimum.
///
/// [`Warning::Inaccurate`](crate::Warning::Inaccurate) in the outcome says that steps are too long for the minimum found. If an accuracy is wanted
/// ([`Search::accurate_to`]), the problem is solved again with smaller errors of the grid.
///
/// If constraints stay violated while controls are at their bounds, [`Warning::AtBounds`](crate::Warning::AtBounds) names the controls.
///
/// The problem is left with the motion of the solution, and [`Solved`] lists what was tried.
///
/// `watch` receives the iterates of the first start, and then the best point after each group of other starts. The progress callback of the
/// problem's solver ([`Solver::watch`](crate::Solver::watch)) is called in all motions of all starts, and stops all of them.
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
/// let solved = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent)?;
/// assert!(solved.outcome.reason.is_converged(), "{solved}");
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// Invalid sizes, bounds, options or guesses, or a problem without Hessian products.
pub fn solve(
    problem: &mut MotionProblem,
    search: impl Into<Search>,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Solved, Error> {
    let search = search.into();
    options.fit(problem, &problem.start())?;
    search.check(problem)?;
    without_known(problem, options.violation, |problem| {
        let mut found = from_all_starts(problem, &search, options, watch)?;
        make_accurate(problem, &mut found, (search.accuracy, options), watch)?;
        Ok(found)
    })
}

/// Solves from all starts of a search.
///
/// # Errors
/// As [`solve`].
fn from_all_starts(
    problem: &mut MotionProblem,
    search: &Search,
    options: &Options,
    watch: &mut Watcher,
) -> Result<Solved, Error> {
    let (guess, starts) = (&search.guess, search.starts);
    let mut best = from_start(problem, guess, (options, Start::First), watch)?;
    if starts < 2 || best.outcome.is_interrupted() || is_hopeless(&best.outcome) {
        return Ok(best);
    }
    let random = Starts::new(problem, &best.outcome);
    let value = |outcome: &Outcome| value(outcome, options);
    let mut values = vec![value(&best.outcome)];
    let mut turns = Turns::default();
    let others: Vec<usize> = (1..starts).collect();
    for some in others.chunks(TOGETHER) {
        let known = value(&best.outcome).is_finite().then_some(&best.outcome);
        let states = known.filter(|_| *guess != Guess::Inputs).and_then(|known| states(problem, known));
        let found = each(
            some,
            || (),
            |(), &which| {
                let is_near = known.is_some() && Starts::is_near(which);
                let guess = states.as_ref().filter(|_| is_near).unwrap_or(guess);
                let mut own = random.problem(which, known)?;
                let is_one_motion = turns.is_one_motion(which);
                let start = Start::Other { which, is_one_motion };
                let found = from_start(&mut own, guess, (options, start), &mut silent)?;
                Ok::<_, Error>((found, is_near, is_one_motion))
            },
        );
        let mut is_interrupted = false;
        for found in found {
            let (Solved { outcome, attempts }, is_near, is_one_motion) = found?;
            is_interrupted |= outcome.is_interrupted();
            turns.count(is_one_motion, is_solved(&outcome, options));
            best.attempts.extend(attempts);
            if !is_near {
                values.push(value(&outcome));
            }
            if value(&outcome) < value(&best.outcome) {
                best.outcome = outcome;
            }
        }
        let least = value(&best.outcome);
        let known = values.iter().filter(|value| **value <= least + ALIKE * least.abs()).count();
        let Outcome { violation, evaluations, ref x, .. } = best.outcome;
        let stationarity = best.outcome.history.last().map_or(f64::INFINITY, |last| last.stationarity);
        let at = Iterate { value: least, violation, stationarity, step: 0.0, evaluations };
        if is_interrupted || least.is_finite() && known >= AGAIN || watch(&at, x).is_break() {
            break;
        }
    }
    problem.settle_at(&best.outcome.x);
    Ok(best)
}

/// The states of a minimum, as a guess; `None` if they cannot be computed.
fn states(problem: &mut MotionProblem, of: &Outcome) -> Option<Guess> {
    settles_at(problem, &of.x).ok()?;
    let motion = problem.solver.trajectory();
    Some(Guess::States { q: motion.q.clone(), v: motion.v.clone() })
}

/// J of a minimum; infinite for other outcomes, also for segments that meet but violate the constraints as a single motion.
fn value(outcome: &Outcome, options: &Options) -> f64 {
    if is_solved(outcome, options) { outcome.value } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::super::{Free, Variables};
    use super::*;
    use crate::{Grid, Inputs, Settings, scenes::CartPendulum};

    #[test]
    fn segments_that_are_no_single_motion_are_no_minimum() {
        let scene = CartPendulum::with_links(1).scene();
        let force = scene.control_named("force on the cart").expect("its only control");
        let system = scene.compile().expect("a system");
        let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.02));
        let variables = Variables::new(&system, &inputs, vec![Free::control(force)]).expect("free");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
        let options = Options::default();
        let mut outcome = solve(&mut problem, Guess::Straight, &options, &mut silent).expect("fits").outcome;
        assert!(outcome.reason.is_converged() && value(&outcome, &options).is_finite(), "{outcome}");
        outcome.violation = 15.0;
        assert_eq!(value(&outcome, &options), f64::INFINITY);
    }
}
