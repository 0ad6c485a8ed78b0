//! Options and results of optimisation methods.

mod progress;

use std::fmt;
use std::io::Write;
use std::ops::ControlFlow;

use super::{Problem, Violation};
use crate::{Error, Warning};

/// Number of violated constraints that a message names.
const NAMED: usize = 3;
/// Number of lines of a log after which the header is repeated.
const LINES: usize = 25;

/// Options of an optimisation method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Largest number of iterations. Feasibility phases of [`interior_point`](super::interior_point()), and each phase of an attempt of
    /// [`solve`](super::solve()), have as many of their own.
    pub iterations: usize,
    /// Value of f, or of ½‖r‖², at which the method stops, if any.
    pub target: Option<f64>,
    /// Tolerance of the largest component g of the gradient of the Lagrangian, over variables that are not at a bound, in the unit that a method
    /// chooses:
    ///
    /// - [`interior_point`](super::interior_point()), [`homotopy`](super::homotopy()): the largest component of ∇f or of its terms ∇²f x at the
    ///   point itself, but not more than the largest gradient at the start. The tolerance does not grow with the slope at a start that is far away.
    /// - [`stages`](super::stages()), and segments of [`solve`](super::solve()): absolute, for f multiplied by a factor with which the largest
    ///   component of its gradient at the start is between 0.01 and 1.
    /// - [`lbfgs`](super::lbfgs()), [`augmented_lagrangian`](super::augmented_lagrangian()): the largest gradient at the start, because gradients
    ///   alone determine no other unit. A steep start loosens the tolerance; start again from the result, or reduce the tolerance.
    /// - [`levenberg_marquardt`](super::levenberg_marquardt()): as for `lbfgs`, with variables in units of the columns of the Jacobian.
    ///
    /// The unit of f does not matter. If units of variables differ by powers of ten, set scales ([`Free::scaled`](super::Free::scaled)); otherwise
    /// the largest derivatives dominate.
    pub stationarity: f64,
    /// Tolerance of the violation of constraints.
    pub violation: f64,
    /// Number of stored pairs of steps and gradient changes (limited memory).
    pub memory: usize,
    /// Length of the first step in the variable that changes most. By default, or if it does not decrease f, it is computed from f and its
    /// gradient (1 if f and all variables are zero).
    pub first_step: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Options { iterations: 1000, target: None, stationarity: 1e-7, violation: 1e-9, memory: 30, first_step: None }
    }
}

impl Options {
    /// Validates a problem, a start and these options as every method does; for optimisers of your own.
    ///
    /// # Errors
    /// Invalid sizes or options, a start that is not finite, or an empty interval of bounds.
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

    /// Rejects values with which no comparison would succeed.
    pub(super) fn check(&self) -> Result<(), Error> {
        let Options { stationarity, violation, target, first_step, .. } = *self;
        let (least, length) = (target.unwrap_or(0.0), first_step.unwrap_or(1.0));
        let is_finite = |x: f64, is_in: bool| is_in && x.is_finite();
        let all = [
            ("stationarity", stationarity, is_finite(stationarity, stationarity >= 0.0), "finite and not negative"),
            ("violation", violation, violation >= 0.0, "a number that is not negative"),
            ("target", least, !least.is_nan(), "a number"),
            ("first_step", length, is_finite(length, length > 0.0), "finite and positive"),
        ];
        match all.into_iter().find(|(_, _, fits, _)| !fits) {
            Some((name, value, _, must_be)) => Err(Error::Parameter { what: format!("`Options::{name}`"), value, must_be }),
            None => Ok(()),
        }
    }
}

/// Reason why a method stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The value reached the target, and the constraints hold.
    Target,
    /// The gradient is below the tolerance or rounding, and the constraints hold within the tolerance or rounding. If steep slopes
    /// determine the rounding error of the gradient, these slopes are confirmed by finite differences.
    Stationary,
    /// No lower value was found along the search direction. If f jumps ([`Outcome::halved`]) or has a fold, lower values may exist beyond the
    /// jump or fold.
    NoLowerValue,
    /// The sum of squares of the violations has a local minimum, in the units of the constraints: no feasible point is nearby. Where only its gradient
    /// vanishes, as by symmetry, [`interior_point`](super::interior_point()) follows negative curvature instead. Another start or a [`homotopy`](super::homotopy()) may find a feasible point if one exists.
    /// [`solve`](super::solve()) returns this reason, too, if constraints on states at one node contradict each other or a fixed start
    /// ([`Warning::NoState`]).
    Infeasible,
    /// The constraints hold within the tolerance, but have no multipliers: the gradient of a constraint vanishes where the constraint holds, as that
    /// of (φ − π/2)² = 0 does, or gradients become linearly dependent. No point can be confirmed as a minimum. State such constraints in another
    /// form, here φ − π/2 = 0.
    Degenerate,
    /// The value decreases without bound: it still decreases at variables so large that a change by the magnitude of their initial values
    /// is below their rounding error.
    Unbounded,
    /// The last problem of a homotopy was not reached; the argument s of the last call of `set` is the one that was reached.
    NoWay,
    /// The limit of iterations was reached. [`Outcome::is_improving`] is true if more iterations are likely to help.
    Iterations,
    /// Stopped by a callback of the method or of a simulation ([`Error::Interrupted`]).
    Interrupted,
    /// The value or a derivative at the start could not be computed, for example because its motion fails; [`Outcome::first_failure`] contains the
    /// error. Value and violation are infinite.
    NoStart,
    /// A derivative at the point could not be computed; `Outcome::first_failure` contains the error.
    NoDerivative,
}

impl Reason {
    /// The violations that an outcome names: those above the tolerance or, where constraints have no multipliers, all.
    pub(super) fn named_above(self, tolerance: f64) -> f64 {
        if self == Reason::Degenerate { 0.0 } else { tolerance }
    }

    /// True for [`Target`](Self::Target) and [`Stationary`](Self::Stationary).
    pub fn is_converged(self) -> bool {
        matches!(self, Reason::Target | Reason::Stationary)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Reason::Target => "the target was reached",
            Reason::Stationary => "the gradient is below the tolerance or below its rounding error",
            Reason::NoLowerValue => "no step lowers the value or the violation further; try another guess or several starts",
            Reason::Infeasible => "the constraints contradict each other, or their violation cannot be reduced further",
            Reason::Degenerate => {
                "a constraint has no multiplier, because its gradient vanishes or depends on those of others"
            }
            Reason::Unbounded => "the value decreases without bound",
            Reason::NoWay => "the last problem of the homotopy was not reached",
            Reason::Iterations => "the iteration limit was reached",
            Reason::Interrupted => "stopped by a callback",
            Reason::NoStart => "the value or a derivative at the start could not be computed",
            Reason::NoDerivative => "a derivative could not be computed",
        })
    }
}

/// An iterate of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iterate {
    /// f, or ½‖r‖².
    pub value: f64,
    /// The largest violation of a constraint.
    pub violation: f64,
    /// The largest component of the gradient of the Lagrangian, projected onto the bounds.
    pub stationarity: f64,
    /// The largest change of a variable in the last step.
    pub step: f64,
    /// Number of evaluations so far.
    pub evaluations: usize,
}

/// Result of a method, converged or not.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The best point found; if constraints are violated, the last point.
    pub x: Vec<f64>,
    /// The value f, or ½‖r‖², at this point.
    pub value: f64,
    /// The constraints c at this point.
    pub constraints: Vec<f64>,
    /// The largest violation of a constraint.
    pub violation: f64,
    /// The constraints that are violated by more than the tolerance, the largest violation first; for [`Reason::Degenerate`], all that do not hold
    /// exactly.
    pub violated: Vec<Violation>,
    /// The multipliers w of the Lagrangian f + wᵀc.
    pub multipliers: Vec<f64>,
    /// Reason why the method stopped.
    pub reason: Reason,
    /// Number of iterations, including those of a feasibility phase, which are not in the history.
    pub iterations: usize,
    /// Number of evaluations (simulations).
    pub evaluations: usize,
    /// Number of gradients and columns of Jacobians: one right-hand side each.
    pub gradients: usize,
    /// Number of Hessian products.
    pub products: usize,
    /// The start and all iterates.
    pub history: Vec<Iterate>,
    /// Warnings of the evaluation at `x` ([`Problem::warnings`]).
    pub warnings: Vec<Warning>,
    /// Number of points with halved steps ([`Warning::HalvedSteps`]); f jumps between these points and other points, so lower values may
    /// not be found.
    pub halved: usize,
    /// Number of points without a value or derivatives.
    pub failures: usize,
    /// Error of the first such point, or the error that caused [`Reason::NoDerivative`] or [`Reason::NoStart`].
    pub first_failure: Option<Error>,
}

impl Outcome {
    /// The history as CSV with a header and one line for each iterate.
    pub fn history_csv(&self) -> String {
        let head = "iteration,simulations,value,violation,stationarity,step\n".to_string();
        self.history.iter().enumerate().fold(head, |table, (k, it)| {
            let Iterate { value, violation, stationarity, step, evaluations } = it;
            table + &format!("{k},{evaluations},{value:e},{violation:e},{stationarity:e},{step:e}\n")
        })
    }
}

/// One line with the reason, the counts, the value and the largest violation.
impl Outcome {
    /// True if a callback stopped the method.
    pub(super) fn is_interrupted(&self) -> bool {
        self.reason == Reason::Interrupted
    }

    /// Adds the counts and the history of another run to those of all runs before it.
    pub(super) fn add(&mut self, next: &Outcome) {
        let before = self.evaluations;
        self.history.extend(next.history.iter().map(|it| Iterate { evaluations: before + it.evaluations, ..*it }));
        self.iterations += next.iterations;
        self.evaluations += next.evaluations;
        self.gradients += next.gradients;
        self.products += next.products;
        self.halved += next.halved;
        self.failures += next.failures;
        self.first_failure = self.first_failure.take().or_else(|| next.first_failure.clone());
    }

    /// The same result with the counts and the history of all runs.
    pub(super) fn with_counts_of(self, all: Outcome) -> Self {
        let Outcome { iterations, evaluations, gradients, products, halved, failures, first_failure, history, .. } = all;
        Outcome { iterations, evaluations, gradients, products, halved, failures, first_failure, history, ..self }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (value, violation) = (significant(self.value, 6), significant(self.violation, 2));
        self.describe(f, &format!("value {value}, largest violation {violation}"))
    }
}

impl Outcome {
    /// Writes the reason, the counts, the result, and the error that stopped the method, if any.
    pub(super) fn describe(&self, f: &mut fmt::Formatter, result: &str) -> fmt::Result {
        let Outcome { reason, iterations, evaluations, gradients, products, .. } = self;
        let counted = |number: &usize, noun| format!("{number} {noun}{}", if *number == 1 { "" } else { "s" });
        let counts =
            [(evaluations, "value"), (gradients, "gradient"), (products, "Hessian product")].map(|(n, of)| counted(n, of));
        write!(f, "{reason}, after {} ({}): {result}", counted(iterations, "iteration"), counts.join(", "))?;
        if let Some(named) = self.named_violations().filter(|_| !reason.is_converged()) {
            write!(f, "; {named}")?;
        }
        self.describe_progress(f)?;
        match &self.first_failure {
            Some(error) if matches!(reason, Reason::NoStart | Reason::NoDerivative) => write!(f, "; {error}"),
            _ => Ok(()),
        }
    }
}

impl Outcome {
    /// The constraints with the largest violations, and the number of others; `None` if all hold within the tolerance.
    pub(super) fn named_violations(&self) -> Option<String> {
        let named: Vec<String> = self.violated.iter().take(NAMED).map(Violation::to_string).collect();
        let more = self.violated.len().saturating_sub(NAMED);
        let others = if more > 0 { format!("; and {more} more") } else { String::new() };
        (!named.is_empty()).then(|| format!("{}{others}", named.join("; ")))
    }
}

/// A number with a given number of significant digits, with an exponent only if it is very small or large.
pub(super) fn significant(x: f64, digits: usize) -> String {
    let rounded: f64 = format!("{x:.*e}", digits - 1).parse().unwrap_or(x);
    let is_plain = rounded == 0.0 || !rounded.is_finite() || (1e-4..1e6).contains(&rounded.abs());
    if is_plain { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Callback that receives every iterate with its point x and may stop the method.
pub type Watcher<'w> = dyn FnMut(&Iterate, &[f64]) -> ControlFlow<()> + 'w;

/// A [`Watcher`] that does nothing.
pub fn silent(_: &Iterate, _: &[f64]) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A [`Watcher`] that writes a line for each iterate: its number, value, largest violation, stationarity and step.
///
/// Errors of the writer are ignored.
///
/// ```no_run
/// use hamiltonian_adjoint::optimize::{Options, Problem, interior_point, log_to};
/// # fn f(problem: &mut dyn Problem, start: &[f64]) -> Result<(), hamiltonian_adjoint::Error> {
/// interior_point(problem, start, &Options::default(), &mut log_to(std::io::stdout()))?;
/// # Ok(()) }
/// ```
pub fn log_to(mut writer: impl Write) -> impl FnMut(&Iterate, &[f64]) -> ControlFlow<()> {
    let mut count = 0;
    move |Iterate { value, violation, stationarity, step, .. }, _| {
        if count % LINES == 0 {
            let _ = writeln!(
                writer,
                "{:>9} {:>14} {:>10} {:>12} {:>10}",
                "iteration", "value", "violation", "stationarity", "step"
            );
        }
        let _ = writeln!(writer, "{count:>9} {value:>14.6e} {violation:>10.1e} {stationarity:>12.1e} {step:>10.1e}");
        count += 1;
        ControlFlow::Continue(())
    }
}

/// The largest change of a variable.
pub(super) fn largest_change(new: &[f64], old: &[f64]) -> f64 {
    new.iter().zip(old).fold(0.0, |most: f64, (new, old)| most.max((new - old).abs()))
}
