//! What methods are told, and what they answer.

use std::fmt;
use std::ops::ControlFlow;

use super::Problem;
use crate::{Error, Warning};

/// When a method stops, and how it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The most iterations.
    pub iterations: usize,
    /// A value of f, or of ½‖r‖², at which it is good enough, if there is one.
    pub target: Option<f64>,
    /// How much smaller than at the start the gradient must become, by variables that no bound holds: its largest component. Where units of variables differ by
    /// powers of ten, give them scales ([`Free::scaled`](super::Free::scaled)): small derivatives of some are nothing beside large ones of others.
    pub stationarity: f64,
    /// How far constraints may be from what they must be.
    pub violation: f64,
    /// The pairs of steps and changes of the gradient that are remembered.
    pub memory: usize,
    /// The length of the first step in the variable that moves most; found from f and its gradient if none is given, or where it leads to
    /// nothing lower (1 where f and all variables are zero, which tell no length).
    pub first_step: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Options { iterations: 1000, target: None, stationarity: 1e-7, violation: 1e-9, memory: 30, first_step: None }
    }
}

impl Options {
    /// What every method asks first, for optimisers of your own.
    ///
    /// # Errors
    /// Sizes or options that do not fit, a start that is not finite, bounds that no value is between.
    pub fn fit(&self, problem: &dyn Problem, start: &[f64]) -> Result<(), Error> {
        self.check()?;
        let (bounds, n) = (problem.bounds(), problem.variables());
        for (what, found) in [("the variables of the start", start.len()), ("the bounds of the variables", bounds.len())] {
            if found != n {
                return Err(Error::Size { what, expected: n, found });
            }
        }
        if let Some(i) = start.iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite { what: format!("the start of `{}`", problem.variable_name(i)), value: start[i] });
        }
        bounds.iter().enumerate().try_for_each(|(i, of)| of.check(|| format!("`{}`", problem.variable_name(i))))?;
        problem.constraints().iter().enumerate().try_for_each(|(j, of)| of.check(|| problem.constraint_name(j)))
    }

    /// Refuses what no comparison would ever meet or exceed.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refused =
            |name: &str, value, must_be| Err(Error::Parameter { what: format!("`Options::{name}`"), value, must_be });
        match *self {
            Options { stationarity, .. } if !(stationarity >= 0.0 && stationarity.is_finite()) => {
                refused("stationarity", stationarity, "finite and not negative")
            }
            Options { violation, .. } if violation.is_nan() || violation < 0.0 => {
                refused("violation", violation, "a number that is not negative")
            }
            Options { target: Some(target), .. } if target.is_nan() => refused("target", target, "a number"),
            Options { first_step: Some(length), .. } if !(length > 0.0 && length.is_finite()) => {
                refused("first_step", length, "finite and positive")
            }
            _ => Ok(()),
        }
    }
}

/// Why a method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The value is at or below the target, and constraints hold.
    Target,
    /// The gradient is as small as was asked for, or as rounding lets it be seen, and constraints hold, at least to rounding; where rounding is a matter of
    /// slopes, differences confirm them.
    Stationary,
    /// There is no lower value within rounding in the direction of search; where f jumps, as [`Outcome::halved`] tells, or folds, there may be one beyond.
    NoLowerValue,
    /// Constraints do not hold at any point nearby: at this one the sum of squares of their violations, in the units that they have, is least. There may
    /// be no point at all where they hold, or one far away, to which another start or a [`homotopy`](super::homotopy()) may lead.
    Infeasible,
    /// The value falls without end: it still fell so far from the start that what was a unit of the variables there is rounding.
    Unbounded,
    /// The last problem of a homotopy was not reached; how far it came, its last call of `set` tells.
    NoWay,
    /// All iterations were made.
    Iterations,
    /// The watcher said so, or the watcher of a simulation ([`Error::Interrupted`]).
    Asked,
    /// The start has no value or no derivatives, as of a motion that cannot be computed: [`Outcome::first_failure`] says why. The value and the violation
    /// are infinite.
    NoStart,
    /// A derivative at the point could not be computed: `Outcome::first_failure` says why.
    NoDerivative,
}

impl Reason {
    /// Whether what was asked for is reached.
    pub fn is_converged(self) -> bool {
        matches!(self, Reason::Target | Reason::Stationary)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Reason::Target => "the target was reached",
            Reason::Stationary => "the gradient is as small as was asked for, or as rounding lets it be seen",
            Reason::NoLowerValue => "there is no lower value within rounding in the direction of search",
            Reason::Infeasible => "constraints get no closer to what they must be",
            Reason::Unbounded => "the value falls without end",
            Reason::NoWay => "the last problem of the homotopy was not reached",
            Reason::Iterations => "all iterations were made",
            Reason::Asked => "it was told to stop",
            Reason::NoStart => "the start has no value or no derivatives",
            Reason::NoDerivative => "a derivative could not be computed",
        })
    }
}

/// A point on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iterate {
    /// f, or ½‖r‖².
    pub value: f64,
    /// The largest violation of a constraint.
    pub violation: f64,
    /// The largest component of the gradient of the Lagrangian, reduced to what bounds leave.
    pub stationarity: f64,
    /// The largest change of a variable that led here.
    pub step: f64,
    /// Evaluations so far.
    pub evaluations: usize,
}

/// Where a method ended: not to converge is an answer too.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best point found; where constraints are far from what they must be, the one at which the method ended.
    pub x: Vec<f64>,
    /// f there, or ½‖r‖².
    pub value: f64,
    /// c there.
    pub constraints: Vec<f64>,
    /// The largest violation of a constraint.
    pub violation: f64,
    /// w of the Lagrangian f + wᵀc.
    pub multipliers: Vec<f64>,
    /// Why it stopped.
    pub reason: Reason,
    /// Iterations, also those towards constraints alone, which the history does not list.
    pub iterations: usize,
    /// Values that were asked for: simulations.
    pub evaluations: usize,
    /// Gradients that were asked for, and columns of Jacobians: one sweep each.
    pub gradients: usize,
    /// Products of the Hessian that were asked for.
    pub products: usize,
    /// The start and all iterates.
    pub history: Vec<Iterate>,
    /// What the evaluation at `x` has to say ([`Problem::warnings`]).
    pub warnings: Vec<Warning>,
    /// Points at which steps were halved ([`Warning::HalvedSteps`]): f jumps between these and others, and a method may find no lower value there.
    pub halved: usize,
    /// Points that had no value, or no derivatives.
    pub failures: usize,
    /// Why the first had none; what ended the method, if that was [`Reason::NoDerivative`] or [`Reason::NoStart`].
    pub first_failure: Option<Error>,
}

impl Outcome {
    /// The history as a table: one line for each iterate, with a header.
    pub fn history_csv(&self) -> String {
        let head = "iteration,simulations,value,violation,stationarity,step\n".to_string();
        self.history.iter().enumerate().fold(head, |table, (k, it)| {
            let Iterate { value, violation, stationarity, step, evaluations } = it;
            table + &format!("{k},{evaluations},{value:e},{violation:e},{stationarity:e},{step:e}\n")
        })
    }
}

/// Why the method stopped, after how many iterations, with which value and violation; one line.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Outcome { reason, iterations, evaluations, gradients, products, value, violation, .. } = self;
        write!(
            f,
            "{reason}, after {iterations} iterations ({evaluations} values, {gradients} gradients, {products} products): "
        )?;
        write!(f, "value {value:e}, largest violation {violation:e}")?;
        match &self.first_failure {
            Some(error) if matches!(reason, Reason::NoStart | Reason::NoDerivative) => write!(f, "; {error}"),
            _ => Ok(()),
        }
    }
}

/// What sees every iterate with its point x, and may stop the method.
pub type Watcher<'w> = dyn FnMut(&Iterate, &[f64]) -> ControlFlow<()> + 'w;

/// Goes on without a word: the [`Watcher`] unless something else watches.
pub fn silent(_: &Iterate, _: &[f64]) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The largest change of a variable.
pub(super) fn largest_change(new: &[f64], old: &[f64]) -> f64 {
    new.iter().zip(old).fold(0.0, |most: f64, (new, old)| most.max((new - old).abs()))
}
