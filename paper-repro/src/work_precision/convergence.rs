//! Errors of J and of its gradient with respect to the continuous problem, and run times, over the number of macro steps.

use std::hint::black_box;

use hamiltonian_adjoint::{Error, Inputs, Settings, Solver, System, gradient};
use serde::Serialize;

use super::knots::{Interpolation, Reading};
use super::reference::Reference;
use super::{Method, order};
use crate::plot::Colour;
use crate::stopwatch::{Job, Repeats};

/// Intervals between the knots of the control.
const INTERVALS: usize = 100;
/// Relative errors above these are errors of the scheme, not of rounding or the reference, for J and for its gradient.
const FLOORS: (f64, f64) = (3e-12, 3e-11);

/// A method with several numbers of macro steps.
#[derive(Clone, Debug, Serialize)]
pub struct Convergence {
    pub scheme: &'static str,
    /// Implicit stages per macro step.
    pub stages: usize,
    /// The theoretical order of J and its gradient.
    pub order: usize,
    #[serde(skip)]
    pub colour: Colour,
    /// Interpolation of the control at inner nodes; J of a constant control does not depend on it.
    pub reading: Reading,
    pub order_of_cost: Option<f64>,
    pub order_of_gradient: Option<f64>,
    /// The runs, from coarse to fine.
    pub runs: Vec<Run>,
}

/// One grid.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Run {
    pub macro_steps: usize,
    pub cost_error: f64,
    /// Time of a simulation and its J, s.
    pub cost_time_s: f64,
    /// Relative error of dJ/dx for the knots, if macro steps fit between them.
    pub gradient_error: Option<f64>,
    /// Time of a simulation and the gradient with respect to the knots, s.
    pub gradient_time_s: Option<f64>,
}

impl Convergence {
    /// Name in figures and tables.
    pub fn label(&self) -> String {
        match self.reading {
            Reading::Piece => self.scheme.to_owned(),
            Reading::Time => format!("{}, u at node times", self.scheme),
        }
    }

    /// Computes the observed orders.
    pub fn new(method: &Method, reading: Reading, runs: Vec<Run>) -> Self {
        let mut convergence = Convergence {
            scheme: method.name,
            stages: method.stages(),
            order: method.order(),
            colour: method.colour,
            reading,
            order_of_cost: None,
            order_of_gradient: None,
            runs,
        };
        convergence.order_of_cost = order::observed(&convergence.cost_over_steps(), FLOORS.0);
        convergence.order_of_gradient = order::observed(&convergence.gradient_over_steps(), FLOORS.1);
        convergence
    }

    /// (stages, error of J).
    pub fn cost_over_steps(&self) -> Vec<(f64, f64)> {
        self.runs.iter().map(|run| (run.steps(self.stages), run.cost_error)).collect()
    }

    /// (time, error of J).
    pub fn cost_over_time(&self) -> Vec<(f64, f64)> {
        self.runs.iter().map(|run| (run.cost_time_s, run.cost_error)).collect()
    }

    /// (stages, error of the gradient).
    pub fn gradient_over_steps(&self) -> Vec<(f64, f64)> {
        self.runs.iter().filter_map(|run| Some((run.steps(self.stages), run.gradient_error?))).collect()
    }

    /// (time, error of the gradient).
    pub fn gradient_over_time(&self) -> Vec<(f64, f64)> {
        self.runs.iter().filter_map(|run| Some((run.gradient_time_s?, run.gradient_error?))).collect()
    }
}

impl Run {
    /// Total number of implicit stages.
    fn steps(&self, stages: usize) -> f64 {
        (self.macro_steps * stages) as f64
    }
}

/// The numbers of macro steps: 25, 50, … up to the onset of rounding errors.
fn macro_steps(method: &Method, short: bool) -> Vec<usize> {
    let most = if short { method.finest_short } else { method.finest };
    std::iter::successors(Some(25), |steps| Some(2 * steps)).take_while(|steps| *steps <= most).collect()
}

/// Runs methods on all their grids.
pub fn measure(
    system: &System,
    cases: &[(Method, Reading)],
    short: bool,
    repeats: Repeats,
) -> Result<Vec<Convergence>, Error> {
    let reference = Reference::continuous();
    let grids = |(method, reading): &(Method, Reading)| -> Vec<GridOfCase> {
        let of = |macro_steps| GridOfCase::new(system, method, *reading, macro_steps);
        macro_steps(method, short).into_iter().map(of).collect()
    };
    let grids: Vec<Vec<GridOfCase>> = cases.iter().map(grids).collect();
    let mut jobs: Vec<Job> = grids.iter().flatten().flat_map(|grid| grid.jobs(system)).collect();
    let mut times = repeats.times(&mut jobs)?.into_iter();
    let converge = |((method, reading), grids): (&(Method, Reading), &Vec<GridOfCase>)| {
        let runs = grids.iter().map(|grid| grid.run(system, &reference, &mut times)).collect::<Result<_, _>>()?;
        Ok(Convergence::new(method, *reading, runs))
    };
    cases.iter().zip(&grids).map(converge).collect()
}

/// A grid and the knots of the control on it.
struct GridOfCase {
    macro_steps: usize,
    inputs: Inputs,
    settings: Settings,
    /// The interpolation between knots, if macro steps fit between them.
    knots: Option<Interpolation>,
}

impl GridOfCase {
    fn new(system: &System, method: &Method, reading: Reading, macro_steps: usize) -> Self {
        GridOfCase {
            macro_steps,
            inputs: method.constant_force(system, macro_steps),
            settings: method.settings(),
            knots: macro_steps
                .is_multiple_of(INTERVALS)
                .then(|| Interpolation::new(reading, INTERVALS, macro_steps / INTERVALS, method.composition)),
        }
    }

    /// The timed jobs: J and, if there is one, the gradient; each has its own solver.
    fn jobs(&self, system: &System) -> Vec<Job<'_>> {
        let mut solver = Solver::new(system, self.settings);
        let cost: Job = Box::new(move || {
            solver.simulate(&self.inputs)?;
            let _ = black_box(solver.cost());
            Ok(())
        });
        let gradient = self.knots.as_ref().map(|knots| -> Job {
            let mut solver = Solver::new(system, self.settings);
            Box::new(move || {
                solver.simulate(&self.inputs)?;
                black_box(knots.pull_back(&solver.gradient()?.controls));
                Ok(())
            })
        });
        std::iter::once(cost).chain(gradient).collect()
    }

    /// The errors, combined with the times of the jobs.
    fn run(&self, system: &System, reference: &Reference, times: &mut impl Iterator<Item = f64>) -> Result<Run, Error> {
        let gradient = gradient(system, &self.inputs, self.settings)?;
        let knots = self.knots.as_ref().map(|knots| knots.pull_back(&gradient.controls));
        Ok(Run {
            macro_steps: self.macro_steps,
            cost_error: reference.cost_error(gradient.value),
            cost_time_s: times.next().unwrap_or(f64::NAN),
            gradient_error: knots.as_ref().map(|knots| reference.gradient_error(knots)),
            gradient_time_s: if knots.is_some() { times.next() } else { None },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hamiltonian_adjoint::scenes::CartPendulum;
    use std::time::Duration;

    #[test]
    fn kinks_lower_the_order_only_where_they_lie_inside_macro_steps() {
        let system = CartPendulum::default().scene().compile().unwrap();
        let repeats = Repeats { turns: 1, turn: Duration::ZERO };
        let cases = [Reading::Piece, Reading::Time].map(|reading| (crate::work_precision::YOSHIDA, reading));
        let [piece, time] = &measure(&system, &cases, true, repeats).unwrap()[..] else { panic!("two cases") };
        assert!((piece.order_of_cost.unwrap() - 6.0).abs() < 0.2, "{:?}", piece.order_of_cost);
        assert!((piece.order_of_gradient.unwrap() - 6.0).abs() < 0.2, "{:?}", piece.order_of_gradient);
        assert!((time.order_of_gradient.unwrap() - 2.0).abs() < 0.2, "{:?}", time.order_of_gradient);
        // 25 and 50 macro steps do not meet all knots.
        let without: Vec<usize> =
            piece.runs.iter().filter(|run| run.gradient_error.is_none()).map(|run| run.macro_steps).collect();
        assert_eq!(without, [25, 50]);
        assert!(piece.gradient_over_time().iter().all(|(time, _)| *time > 0.0));
    }
}
