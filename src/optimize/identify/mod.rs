//! [`identify`]: parameters from readings of one or several records, also from guesses from which a single motion does not follow the readings.

mod in_segments;
mod states;
mod weighted;

use std::fmt;

use super::outcome::significant;
use super::solve::Attempt;
use super::{Fit, Interval, Options, Problem, Reason, Trials, Watcher, levenberg_marquardt};
use crate::{Error, Warning};
use in_segments::in_segments;

/// Numbers of nodes with readings in a segment, in the order in which they are tried.
const READINGS: [usize; 3] = [3, 8, 20];
/// The largest number of iterations of the first fit, after which segments are tried.
const FEW: usize = 50;
/// Relative difference of values that are the same.
const ALIKE: f64 = 1e-3;

/// The result of [`identify`].
#[derive(Clone, Debug)]
pub struct Identified {
    /// The fit with the lowest sum of squares. The counts of its outcome are those of all attempts.
    pub fit: Fit,
    /// The attempts in the order in which they were made. The value of an attempt is ½‖r‖², its violation the largest |r|.
    pub attempts: Vec<Attempt>,
}

/// The fit, and a line for each attempt.
impl fmt::Display for Identified {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}\n{}", self.fit, self.table())
    }
}

/// Finds the free quantities of records that minimise the sum of squares of all residuals, ½‖r‖², from a guess that may be far from the solution.
///
/// First [`levenberg_marquardt`] fits the motions as they are. If the residuals are larger than the errors of the readings explain
/// ([`Warning::Misfit`]), or if the standard deviations of the readings are not known, each motion is divided into segments: the states at their starts
/// are fitted to the readings in the segment, one segment after the other, and become variables. Fits in which the distances between the segments
/// have growing weights lead to motions that are nearly continuous, and from there the motions are fitted again as they are. This converges where
/// the motions of the guess get out of phase with the readings, or are unstable. Segments of several lengths are tried until the residuals are
/// explained, or two attempts lead to the same sum of squares; the fit with the lowest sum is returned.
///
/// Motions with events, and with free quantities that segments do not support, such as single step lengths, are fitted only as they are.
///
/// The problem is left with the motions of the fit. `options` apply to each fit, and `watch` receives the iterates of all fits, whose values in segments include the distances.
///
/// ```
/// use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Trials, Variables, identify, silent};
/// use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, planar::Body};
///
/// // A mass of 1 kg on a spring of 40 N/m: x = 1 m + c cos(√40 t/s), read every 0.05 s for 5 s.
/// let (mut scene, grid) = (Scene::new(), Grid::uniform(500, 0.01));
/// let stiffness = scene.design("stiffness", 10.0); // a guess with half the frequency, N/m
/// let cart = scene.body("cart", 1.0, 0.1, [1.2, 0.0, 0.0]);
/// scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.0), cart.at(0.0, 0.0), stiffness, 2.0, 0.0);
/// let value = |t: f64| 1.0 + 0.2 * (40f64.sqrt() * t).cos();
/// let readings: Vec<_> = grid.times().into_iter().enumerate().skip(5).step_by(5).map(|(node, t)| (node, value(t))).collect();
/// scene.axis_readings("position", cart.coordinates[0], &readings, 1e-2);
/// let system = scene.compile()?;
/// let inputs = Inputs::at_rest(&system, grid);
/// let variables = Variables::new(&system, &inputs, vec![Free::design(stiffness)])?;
/// let motion = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
/// let found = identify(&mut Trials::sharing_designs(vec![motion])?, &Options::default(), &mut silent)?;
/// assert!((found.fit.outcome.x[0] - 40.0).abs() < 0.1, "{found}");
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// Invalid sizes, bounds or options, or a problem without residuals.
pub fn identify(trials: &mut Trials, options: &Options, watch: &mut Watcher) -> Result<Identified, Error> {
    let start = trials.start();
    let few = Options { iterations: options.iterations.min(FEW), ..*options };
    let first = levenberg_marquardt(trials, &start, &few, watch)?;
    let mut found = Identified::first("one motion", first);
    for readings in READINGS {
        if found.is_ended(trials) {
            break;
        }
        let Some(next) = in_segments(trials, (&start, readings), options, watch)? else { continue };
        found.add(format!("segments with {readings} readings"), next);
    }
    if found.fit.outcome.reason == Reason::Iterations && options.iterations > FEW {
        let x = found.fit.outcome.x.clone();
        found.add("continued".into(), levenberg_marquardt(trials, &x, options, watch)?);
    }
    let mut c = vec![0.0; found.fit.outcome.constraints.len()];
    // Every fit has counted this motion.
    trials.evaluate(&found.fit.outcome.x, &mut c).ok();
    Ok(found)
}

impl Identified {
    /// A table of what was tried, with a header.
    pub fn table(&self) -> String {
        let head = format!("{:<26} {:>10} {:>10}  end", "tried", "iterations", "χ²");
        self.attempts.iter().fold(head, |table, Attempt { what, reason, value, iterations, .. }| {
            table + &format!("\n{what:<26} {iterations:>10} {:>10}  {reason}", significant(2.0 * value, 4))
        })
    }

    fn first(what: &str, fit: Fit) -> Self {
        Identified { attempts: vec![attempt(what.into(), &fit)], fit }
    }

    /// Adds a fit, which replaces the one before if it has a lower value.
    fn add(&mut self, what: String, next: Fit) {
        self.attempts.push(attempt(what, &next));
        let is_better = rank(&next) < rank(&self.fit) || next.outcome.is_interrupted();
        let mut all = self.fit.outcome.clone();
        all.add(&next.outcome);
        if is_better {
            self.fit = next;
        }
        self.fit.outcome = self.fit.outcome.clone().with_counts_of(all);
    }

    /// True if no further attempt is needed: readings with known errors are explained, or two attempts agree.
    fn is_ended(&self, trials: &Trials) -> bool {
        let Fit { outcome, .. } = &self.fit;
        let is_explained = are_readings(trials) && self.fit.degrees_of_freedom() > 0 && !is_too_large(&self.fit);
        let is_same = |of: &&Attempt| of.reason.is_converged() && of.value <= outcome.value * (1.0 + ALIKE);
        outcome.is_interrupted()
            || outcome.reason == Reason::Target
            || outcome.reason.is_converged() && is_explained
            || outcome.reason.is_converged() && outcome.value == 0.0
            || self.attempts.iter().filter(is_same).count() > 1
    }
}

fn attempt(what: String, fit: &Fit) -> Attempt {
    let Attempt { reason, value, violation, iterations, .. } = Attempt::of(String::new(), &fit.outcome, &Options::default());
    Attempt { what, reason, value, violation, iterations, is_unstable: false }
}

/// ½‖r‖², infinite if it is not known.
fn rank(fit: &Fit) -> f64 {
    if fit.outcome.value.is_nan() { f64::INFINITY } else { fit.outcome.value }
}

/// True if all residuals are deviations from readings with known standard deviations.
fn are_readings(trials: &Trials) -> bool {
    let intervals = trials.constraints();
    (0..intervals.len()).all(|j| intervals[j] == Interval::FREE || trials.is_reading(j))
}

fn is_too_large(fit: &Fit) -> bool {
    let is_large = |warning: &Warning| match warning {
        Warning::Misfit { chi_squared, degrees_of_freedom, .. } => *chi_squared > *degrees_of_freedom as f64,
        _ => false,
    };
    fit.outcome.warnings.iter().any(is_large)
}
