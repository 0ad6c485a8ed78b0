//! Optimisation from many starts.

use super::{Outcome, Problem};
use crate::Error;
use crate::solver::each;

/// The outcomes of all starts, in their order and independent of the number of threads. With the feature `rayon` they run on all cores,
/// with one problem per thread.
///
/// ```
/// use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, interior_point, lowest, multi_start, silent};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
///
/// let scene = CartPendulum::with_links(1).scene();
/// let force = scene.control_named("force on the cart").expect("its only control");
/// let system = scene.compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
/// let variables = Variables::new(&system, &inputs, vec![Free::control(force)])?;
/// let problem = || MotionProblem::new(&system, Settings::default(), inputs.clone(), variables.clone());
/// let starts: Vec<Vec<f64>> = [-10.0, 5.0, 20.0].map(|force| vec![force; 41]).into();
/// let options = Options { target: Some(1e-10), ..Options::default() };
/// let outcomes = multi_start(&starts, problem, |problem, start| interior_point(problem, start, &options, &mut silent));
/// assert!(lowest(&outcomes, 1e-9).expect("one of them").value < 1e-10);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub fn multi_start<P: Problem>(
    starts: &[Vec<f64>],
    problem: impl Fn() -> Result<P, Error> + Sync,
    method: impl Fn(&mut P, &[f64]) -> Result<Outcome, Error> + Sync,
) -> Vec<Result<Outcome, Error>> {
    let one = |worker: &mut Option<P>, start: &Vec<f64>| {
        let mut own = match worker.take() {
            Some(own) => own,
            None => problem()?,
        };
        let outcome = method(&mut own, start);
        *worker = Some(own);
        outcome
    };
    each(starts, || None, one)
}

/// The outcome with the lowest value among those whose violation is at most `violation`; the first of equal ones. Starts without a value do
/// not count.
pub fn lowest(outcomes: &[Result<Outcome, Error>], violation: f64) -> Option<&Outcome> {
    let good = outcomes.iter().flatten().filter(|of| of.value.is_finite() && of.violation <= violation);
    good.min_by(|one, other| one.value.total_cmp(&other.value))
}
