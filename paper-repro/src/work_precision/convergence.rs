//! Errors of J and of its gradient in the continuous problem, and the time they take, over the number of macro steps.

use std::hint::black_box;

use hamiltonian_adjoint::{Composition, Error, Grid, Inputs, Settings, Solver, System, gradient};
use serde::Serialize;

use super::knots::Interpolation;
use super::order;
use super::reference::{END, FORCE, Reference};
use super::stopwatch::{Job, Repeats};

/// Intervals between the knots of the control.
const INTERVALS: usize = 100;
/// Relative errors above this belong to the scheme and not to rounding or the reference, for J and for its gradient.
const FLOORS: (f64, f64) = (3e-12, 3e-11);

/// How the control is had at the nodes between the ends of macro steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// From the linear piece of the macro step, continued.
    Piece,
    /// From the time of the node.
    Time,
}

/// A composition over numbers of macro steps.
#[derive(Clone, Debug, Serialize)]
pub struct Convergence {
    /// Its name.
    pub scheme: &'static str,
    /// Steps of the rule to a macro step.
    pub stages: usize,
    /// The order that theory promises for J and its gradient.
    pub order: usize,
    /// How the control is read at inner nodes, which J of a constant control does not depend on.
    pub reading: Reading,
    /// The order that J shows.
    pub order_of_cost: Option<f64>,
    /// The order that the gradient shows.
    pub order_of_gradient: Option<f64>,
    /// The runs, coarse to fine.
    pub runs: Vec<Run>,
}

/// One grid.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Run {
    /// Macro steps.
    pub macro_steps: usize,
    /// Relative error of J.
    pub cost_error: f64,
    /// Time of a simulation and its J, s.
    pub cost_time_s: f64,
    /// Relative error of dJ/dx for the knots, if macro steps fit between them.
    pub gradient_error: Option<f64>,
    /// Time of a simulation and the gradient with respect to the knots, s.
    pub gradient_time_s: Option<f64>,
}

impl Convergence {
    /// What it is called in figures and tables.
    pub fn label(&self) -> String {
        match self.reading {
            Reading::Piece => self.scheme.to_owned(),
            Reading::Time => format!("{}, u at node times", self.scheme),
        }
    }

    /// Finds the orders that the runs show.
    pub fn new(composition: Composition, reading: Reading, runs: Vec<Run>) -> Self {
        let mut convergence = Convergence {
            scheme: super::name(composition),
            stages: composition.stages(),
            order: composition.order(),
            reading,
            order_of_cost: None,
            order_of_gradient: None,
            runs,
        };
        convergence.order_of_cost = order::observed(&convergence.cost_over_steps(), FLOORS.0);
        convergence.order_of_gradient = order::observed(&convergence.gradient_over_steps(), FLOORS.1);
        convergence
    }

    /// (steps of the rule, error of J).
    pub fn cost_over_steps(&self) -> Vec<(f64, f64)> {
        self.runs.iter().map(|run| (run.steps(self.stages), run.cost_error)).collect()
    }

    /// (time, error of J).
    pub fn cost_over_time(&self) -> Vec<(f64, f64)> {
        self.runs.iter().map(|run| (run.cost_time_s, run.cost_error)).collect()
    }

    /// (steps of the rule, error of the gradient).
    pub fn gradient_over_steps(&self) -> Vec<(f64, f64)> {
        self.runs.iter().filter_map(|run| Some((run.steps(self.stages), run.gradient_error?))).collect()
    }

    /// (time, error of the gradient).
    pub fn gradient_over_time(&self) -> Vec<(f64, f64)> {
        self.runs.iter().filter_map(|run| Some((run.gradient_time_s?, run.gradient_error?))).collect()
    }
}

impl Run {
    /// Steps of the trapezoidal rule.
    fn steps(&self, stages: usize) -> f64 {
        (self.macro_steps * stages) as f64
    }
}

/// The macro steps to be tried: 25, 50, … up to where rounding begins.
fn macro_steps(composition: Composition, short: bool) -> Vec<usize> {
    let (full, few) = match composition {
        Composition::Trapezoidal => (3200, 800),
        Composition::Suzuki4 => (1600, 400),
        Composition::Yoshida6 | Composition::KahanLi6 => (800, 400),
    };
    let most = if short { few } else { full };
    std::iter::successors(Some(25), |steps| Some(2 * steps)).take_while(|steps| *steps <= most).collect()
}

/// Runs compositions on all their grids.
pub fn measure(
    system: &System,
    cases: &[(Composition, Reading)],
    short: bool,
    repeats: Repeats,
) -> Result<Vec<Convergence>, Error> {
    let reference = Reference::continuous();
    let grids = |&(composition, reading): &(Composition, Reading)| -> Vec<GridOfCase> {
        let of = |macro_steps| GridOfCase::new(system, composition, reading, macro_steps);
        macro_steps(composition, short).into_iter().map(of).collect()
    };
    let grids: Vec<Vec<GridOfCase>> = cases.iter().map(grids).collect();
    let mut jobs: Vec<Job> = grids.iter().flatten().flat_map(|grid| grid.jobs(system)).collect();
    let mut times = repeats.times(&mut jobs)?.into_iter();
    let mut all = Vec::new();
    for (&(composition, reading), grids) in cases.iter().zip(&grids) {
        let runs = grids.iter().map(|grid| grid.run(system, &reference, &mut times)).collect::<Result<_, _>>()?;
        all.push(Convergence::new(composition, reading, runs));
    }
    Ok(all)
}

/// A grid and what the control on it is made of.
struct GridOfCase {
    macro_steps: usize,
    inputs: Inputs,
    /// Where macro steps fit between knots.
    knots: Option<Interpolation>,
}

impl GridOfCase {
    fn new(system: &System, composition: Composition, reading: Reading, macro_steps: usize) -> Self {
        let interpolate = match reading {
            Reading::Piece => Interpolation::by_pieces,
            Reading::Time => Interpolation::by_time,
        };
        GridOfCase {
            macro_steps,
            inputs: constant_force(system, macro_steps, composition),
            knots: macro_steps
                .is_multiple_of(INTERVALS)
                .then(|| interpolate(INTERVALS, macro_steps / INTERVALS, composition)),
        }
    }

    /// What is timed: J and, where there is one, the gradient; each with a solver of its own.
    fn jobs<'a>(&'a self, system: &'a System) -> Vec<Job<'a>> {
        let mut solver = Solver::new(system, Settings::default());
        let cost: Job = Box::new(move || {
            solver.simulate(&self.inputs)?;
            let _ = black_box(solver.cost());
            Ok(())
        });
        let gradient = self.knots.as_ref().map(|knots| -> Job {
            let mut solver = Solver::new(system, Settings::default());
            Box::new(move || {
                solver.simulate(&self.inputs)?;
                black_box(knots.pull_back(&solver.gradient()?.controls));
                Ok(())
            })
        });
        std::iter::once(cost).chain(gradient).collect()
    }

    /// The errors, with the times of the jobs.
    fn run(&self, system: &System, reference: &Reference, times: &mut impl Iterator<Item = f64>) -> Result<Run, Error> {
        let gradient = gradient(system, &self.inputs, Settings::default())?;
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

/// The motion of the references on a composed grid.
pub fn constant_force(system: &System, macro_steps: usize, composition: Composition) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::composed(macro_steps, END / macro_steps as f64, composition));
    inputs.controls.fill(FORCE);
    inputs
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
        let cases = [Reading::Piece, Reading::Time].map(|reading| (Composition::Yoshida6, reading));
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
