//! [`Guess`]: states of a motion from which [`solve`](super::solve()) starts.

use nalgebra::DMatrix;

use super::super::problem::Problem;
use super::super::{MotionProblem, Outcome};
use super::pose::Pose;
use super::reach::{Reach, end_of, is_outside_at_start, start_of, values_at_end};
use super::starts;
use crate::assembly::Retraction;
use crate::motion::{check_size, indices};
use crate::{Coordinate, Error};

/// A guess of the states of a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Guess {
    /// A straight line in independent coordinates, from the start to a state near it in which the outputs that are terminal values have the values
    /// that equalities ask for and, if there is such a state, all outputs of q and v at the last node lie in their intervals. What they leave free is in
    /// equilibrium there, if there is an equilibrium near: a load hangs below its trolley.
    #[default]
    Straight,
    /// Coordinates and velocities at all nodes, n × (N + 1) each; independent ones are used, the others follow from the constraints.
    States {
        /// q, m or rad.
        q: DMatrix<f64>,
        /// v, m/s or rad/s.
        v: DMatrix<f64>,
    },
    /// The motion of the inputs of the problem, without segments.
    Inputs,
    /// The minimum of a problem that differs a little from this one, in its targets, bounds, start or parameters: a few Newton steps lead to the new
    /// minimum. An [`Outcome`] can be converted to this guess.
    Optimum {
        /// The variables, [`Outcome::x`].
        x: Vec<f64>,
        /// The multipliers of the outputs, [`Outcome::multipliers`].
        multipliers: Vec<f64>,
    },
}

impl From<&Outcome> for Guess {
    fn from(outcome: &Outcome) -> Self {
        Guess::Optimum { x: outcome.x.clone(), multipliers: outcome.multipliers.clone() }
    }
}

/// A guess, and a number of starts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Search {
    /// The guess of the states.
    pub guess: Guess,
    /// The number of starts, at least 1: the first with the inputs of the problem, the others with random durations, with random sines added to the
    /// controls to which the first start led and to the guess; every second one begins near the best minimum found before.
    pub starts: usize,
    /// The wanted accuracy of the continuous motion, if any; see [`accurate_to`](Self::accurate_to).
    pub accuracy: Option<f64>,
}

impl Search {
    /// Validates the guess and the accuracy.
    ///
    /// # Errors
    /// Wrong sizes, or values that are not finite.
    pub(super) fn check(&self, problem: &MotionProblem) -> Result<(), Error> {
        self.guess.check(problem)?;
        match self.accuracy {
            Some(value) if !(value > 0.0 && value.is_finite()) => {
                Err(Error::Parameter { what: "`Search::accuracy`".into(), value, must_be: "finite and positive" })
            }
            _ => Ok(()),
        }
    }

    /// Solves again by a scheme of order 4, and then with the steps halved that have the largest errors, until the estimated errors of J and of all
    /// constrained outputs are at most this fraction: of the size of J, and of that of an output or 1 m or rad, whichever is larger. What remains is a
    /// [`Warning::Inaccurate`](crate::Warning::Inaccurate).
    ///
    /// The problem then has this scheme and these steps, with a variable for each node of a control that is free at all nodes, and the same knots of
    /// other controls. If a cost or an output is evaluated at a node or an event, or if a control is piecewise constant, so that it changes within a
    /// step between pieces, steps are not halved; ESDIRK5 is used instead.
    pub fn accurate_to(self, accuracy: f64) -> Search {
        Search { accuracy: Some(accuracy), ..self }
    }
}

impl From<Guess> for Search {
    fn from(guess: Guess) -> Self {
        Search { guess, starts: 1, accuracy: None }
    }
}

impl Guess {
    /// Validates sizes and values for a problem.
    ///
    /// # Errors
    /// Wrong sizes, or values that are not finite.
    pub(super) fn check(&self, problem: &MotionProblem) -> Result<(), Error> {
        let is_finite = |what: &str, mut all: std::slice::Iter<'_, f64>| match all.find(|x| !x.is_finite()) {
            Some(&value) => Err(Error::NotFinite { what: format!("an entry of {what}"), value }),
            None => Ok(()),
        };
        match self {
            Guess::Straight | Guess::Inputs => Ok(()),
            Guess::States { q, v } => {
                let (n, nodes) = (problem.solver.system().n(), problem.inputs_at(&problem.start()).grid.nodes());
                [("the coordinates of a guess", q), ("the velocities of a guess", v)].into_iter().try_for_each(
                    |(what, of)| {
                        check_size(what, n, of.nrows())?;
                        check_size(what, nodes, of.ncols())?;
                        is_finite(what, of.as_slice().iter())
                    },
                )
            }
            Guess::Optimum { x, multipliers } => {
                let (variables, outputs) = (problem.variables(), problem.constraints().len());
                let all = [("the variables of a guess", x, variables), ("the multipliers of a guess", multipliers, outputs)];
                all.into_iter().try_for_each(|(what, of, expected)| {
                    check_size(what, expected, of.len())?;
                    is_finite(what, of.iter())
                })
            }
        }
    }

    /// A search from this guess with a number of starts.
    pub fn starts(self, starts: usize) -> Search {
        Search { guess: self, starts, accuracy: None }
    }

    /// A search from this guess for a minimum with an accuracy; see [`Search::accurate_to`].
    pub fn accurate_to(self, accuracy: f64) -> Search {
        Search::from(self).accurate_to(accuracy)
    }
}

/// Independent coordinates, and states at all nodes.
pub(super) struct Line {
    pub(super) coordinates: Vec<Coordinate>,
    pub(super) q: DMatrix<f64>,
    pub(super) v: DMatrix<f64>,
    /// The result of the search for states at the first and the last node that satisfy the constraints.
    pub(super) reach: Reach,
}

impl Line {
    /// The states of the last evaluated motion of a problem.
    pub(super) fn of_motion(problem: &MotionProblem) -> Self {
        let (system, inputs) = (problem.solver.system(), problem.inputs_at(&problem.start()));
        let coordinates = Retraction::choose(system, &[], &inputs);
        let motion = problem.solver.trajectory();
        Line { coordinates, q: motion.q.clone(), v: motion.v.clone(), reach: Reach::Found }
    }

    /// The states of a guess for a start of a search, bent at random unless it is the first one; `None` if there is no consistent start.
    pub(super) fn new(problem: &MotionProblem, guess: &Guess, start: usize) -> Option<Self> {
        let (system, settings) = (problem.solver.system(), problem.solver.settings());
        let inputs = problem.inputs_at(&problem.start());
        let nodes = inputs.grid.nodes();
        let [q0, v0] = start_of(system, settings, &inputs)?;
        let preferred: Vec<usize> =
            values_at_end(problem).iter().flat_map(|(output, _)| system.coordinates_of(1 + output)).collect();
        let mut at = inputs.clone();
        at.start.q_mut().copy_from(&q0);
        let coordinates = Retraction::choose(system, &preferred, &at);
        let chosen = indices(&coordinates);
        let mut pose = Pose::new((system, settings), &at, &coordinates, nodes - 1).ok()?;
        let times = inputs.grid.times();
        let z0 = pose.guess(&q0, &v0);
        let (end, at_end) = end_of(problem, &mut pose, [&q0, &v0]);
        let reach = match (at_end, guess) {
            _ if is_outside_at_start(problem) => Reach::Impossible,
            // Given states may end where Newton's method does not.
            (Reach::Unknown, Guess::States { .. }) => Reach::Found,
            _ => at_end,
        };
        let mut z = match guess {
            Guess::States { q, v } => {
                let of = |i: usize, node: usize| {
                    if i.is_multiple_of(2) { q[(chosen[i / 2], node)] } else { v[(chosen[i / 2], node)] }
                };
                DMatrix::from_fn(z0.len(), nodes, of)
            }
            _ => straight(&z0, &end, &times),
        };
        if start > 0 {
            starts::bend(&mut z, &times, start);
        }
        pose.guess(&q0, &v0);
        let (mut q, mut v) = (DMatrix::zeros(system.n(), nodes), DMatrix::zeros(system.n(), nodes));
        for (node, z) in z.column_iter().enumerate() {
            let z: Vec<f64> = z.iter().copied().collect();
            // Poses that cannot be assembled are like the last one that could.
            let [mut here, mut rates] = pose.at(&z, times[node]).unwrap_or_else(|_| pose.last(&q0));
            for (&i, z) in chosen.iter().zip(z.chunks(2)) {
                (here[i], rates[i]) = (z[0], z[1]);
            }
            q.set_column(node, &here);
            v.set_column(node, &rates);
        }
        Some(Line { coordinates, q, v, reach })
    }
}

/// A straight line between two states, with its own rates, at these times.
fn straight(start: &[f64], end: &[f64], times: &[f64]) -> DMatrix<f64> {
    let (first, duration) = (times[0], times[times.len() - 1] - times[0]);
    DMatrix::from_fn(start.len(), times.len(), |i, node| {
        let change = end[i - i % 2] - start[i - i % 2];
        let passed = if duration == 0.0 { 0.0 } else { (times[node] - first) / duration };
        match i % 2 {
            0 => start[i] + passed * change,
            _ if duration == 0.0 => 0.0,
            _ => change / duration,
        }
    })
}
