//! [`Run`]: the iterations of the method.

use super::super::outcome::largest_change;
use super::super::{Iterate, Options, Reason, Watcher};
use super::filter::{Accepted, Filter};
use super::method::Method;
use super::newton::Newton;
use super::search::{Trial, search, trial};
use crate::Error;
use crate::number::largest;

/// The first μ, and how it decreases: to the smaller of `LESS` μ and μ^`POWER` once errors are below `SOLVED` μ, to `LAST_MU` of the tolerance.
pub(super) const FIRST_MU: f64 = 0.1;
const LESS: f64 = 0.2;
const POWER: f64 = 1.5;
const SOLVED: f64 = 10.0;
const LAST_MU: f64 = 1.0 / 11.0;
/// The largest first μ near a minimum of a similar problem.
pub(super) const NEAR_MU: f64 = 1e-6;
/// Multipliers are estimated again after steps shorter than this, shifts above this, or if they are large: they, the Hessian and its shift would
/// otherwise increase each other. Large ones of a step without a shift to a point that satisfies the constraints belong to constraints with small
/// derivatives.
const SHORT: f64 = 0.1;
const SHIFTED: f64 = 1.0;
/// Largest number of iterations in sequence without an acceptable step. In each, the filter is cleared, a fraction of the step is taken, and the
/// shift is increased by a factor from at least a smallest value.
const MOST_FAILED: usize = 3;
const FRACTION: f64 = 1.0 / 64.0;
const MORE: f64 = 100.0;
const LEAST_SHIFT: f64 = 1e-3;

/// A run diverges if a violation exceeds this multiple of the first one.
const FAR: f64 = 1e3;
/// Points with violations below this multiple of the first one are almost feasible. Steps along lines that have found none
/// end after this number of iterations, or after this number of short steps in sequence, which is smaller near a minimum.
const CLOSER: f64 = 1e-2;
const PATIENCE: usize = 80;
const MOST_SHORT: usize = 15;
const MOST_SHORT_NEAR: usize = 5;
/// From violations below this multiple of the first one, steps along lines are tried again.
const CLOSE: f64 = 0.1;
/// Number of iterations over which all violations exceed a fraction of the first if the violation has stopped decreasing; and this fraction.
const STUCK_FOR: usize = 40;
const STUCK: f64 = 0.9;

/// Constraints hold up to rounding if they are violated by less than this fraction of the largest variable.
const ROUNDING: f64 = 1e-13;

/// The last μ.
pub(super) fn least_mu(options: &Options) -> f64 {
    options.stationarity * LAST_MU
}

/// The state of a run apart from the point.
pub(super) struct Run<'o, 'w> {
    options: &'o Options,
    watch: &'o mut Watcher<'w>,
    pub history: Vec<Iterate>,
    pub failures: usize,
    pub first_failure: Option<Error>,
    /// Number of points with halved steps.
    pub halved: usize,
    /// Numbers of iterations in sequence without an acceptable step, and with short steps.
    failed: usize,
    short: usize,
    /// The largest variable of the first iterate, or 1 if it is smaller.
    first_size: Option<f64>,
}

impl<'o, 'w> Run<'o, 'w> {
    pub(super) fn new(options: &'o Options, watch: &'o mut Watcher<'w>) -> Self {
        Run {
            options,
            watch,
            history: Vec::new(),
            failures: 0,
            first_failure: None,
            halved: 0,
            failed: 0,
            short: 0,
            first_size: None,
        }
    }

    pub(super) fn fail(&mut self, error: Error) {
        self.failures += 1;
        // An interruption ends the run, so it replaces failures from which the method recovered.
        if self.first_failure.is_none() || matches!(error, Error::Interrupted { .. }) {
            self.first_failure = Some(error);
        }
    }

    pub(super) fn is_interrupted(&self) -> bool {
        matches!(self.first_failure, Some(Error::Interrupted { .. }))
    }

    /// True if the last iterate violates the constraints.
    pub(super) fn is_violated(&self) -> bool {
        self.history.last().is_some_and(|last| last.violation > self.options.violation)
    }

    /// The allowed violation.
    pub(super) fn allowed(&self) -> f64 {
        self.options.violation
    }

    /// True if violations have become large or have remained so since an iterate, or if steps have remained short.
    fn diverges(&self, since: usize, most_short: usize) -> bool {
        let (first, lately) = (self.first_violation(), &self.history[since..]);
        let is_slow = lately.len() > PATIENCE || self.short > most_short;
        is_slow && lately.iter().all(|of| of.violation > CLOSER * first)
            || lately.last().is_some_and(|last| last.violation > FAR * first)
    }

    /// The first violation, or 1 if it is smaller.
    fn first_violation(&self) -> f64 {
        self.history.first().map_or(1.0, |of| of.violation.max(1.0))
    }

    /// True if violations have hardly decreased for long since an iterate.
    pub(super) fn is_stuck(&self, since: usize) -> bool {
        let Some(lately) = self.history[since..].last_chunk::<STUCK_FOR>() else { return false };
        let (first, least) = (lately[0].violation, lately.iter().fold(f64::INFINITY, |least, of| least.min(of.violation)));
        self.is_violated() && least > STUCK * first
    }

    /// True if steps along lines that ended for this reason are followed by steps within a trust region.
    pub(super) fn falls_back(&self, reason: Reason) -> bool {
        matches!(reason, Reason::NoLowerValue | Reason::NoDerivative) && self.history.len() < self.options.iterations
    }

    /// True if the last iterate almost satisfies the constraints.
    pub(super) fn is_near(&self) -> bool {
        self.history.last().is_some_and(|last| last.violation <= CLOSER * self.first_violation())
    }

    /// True if violations have decreased since an iterate so far that steps along lines may lead on.
    pub(super) fn comes_close(&self, since: usize) -> bool {
        let is_close = |at: &Iterate| at.violation <= CLOSE * self.first_violation();
        self.history.last().is_some_and(is_close) && !is_close(&self.history[since])
    }

    /// Iterates along lines, from a start near a minimum or far from any, until there is a reason to stop.
    ///
    /// # Errors
    /// A problem without second derivatives.
    pub(super) fn along_lines(&mut self, method: &mut Method<'_>, begins_near: bool) -> Result<Reason, Error> {
        let mut filter = Filter::new(method.pair(&method.y, &method.values), begins_near);
        let (mut is_estimated, mut moved) = (true, 0.0);
        let (begin, most_short) = (self.history.len(), if begins_near { MOST_SHORT_NEAR } else { MOST_SHORT });
        (self.failed, self.short) = (0, 0);
        loop {
            if is_estimated {
                method.estimate_multipliers();
            }
            if let Some(reason) = self.record(method, moved) {
                return Ok(reason);
            }
            if self.diverges(begin, most_short) {
                return Ok(Reason::NoLowerValue);
            }
            if self.lower_barrier(method) {
                filter.clear();
            }
            let kkt = match method.kkt() {
                Ok(kkt) => kkt,
                Err(error) => return self.without_derivatives(error),
            };
            let Some(newton) = method.factorise(&kkt, self.is_near()) else { return Ok(Reason::NoLowerValue) };
            let Some(trial) = self.next(method, &newton, &mut filter) else {
                return Ok(if self.is_interrupted() { Reason::Interrupted } else { Reason::NoLowerValue });
            };
            moved = largest_change(&trial.y, &method.y);
            let shift = newton.shift;
            let alpha = trial.alpha;
            if let Err(error) = method.go(&trial.step, alpha, trial.y, trial.values) {
                return self.without_derivatives(error);
            }
            self.short = if alpha < SHORT { self.short + 1 } else { 0 };
            let is_sound = shift == 0.0 && method.violation() <= self.allowed();
            is_estimated = alpha < SHORT || shift > SHIFTED || !is_sound && method.are_large(&method.multipliers);
        }
    }

    /// Records the iterate; returns a reason to stop, if there is one.
    pub(super) fn record(&mut self, method: &Method<'_>, moved: f64) -> Option<Reason> {
        let errors = method.errors(0.0);
        let at = Iterate {
            value: method.values.cost,
            violation: errors.violation,
            stationarity: errors.stationarity,
            step: moved,
            evaluations: method.problem.counts().evaluations,
        };
        self.history.push(at);
        self.halved += usize::from(method.problem.is_halved());
        if (self.watch)(&at, &method.problem.x(&method.v(&method.y))).is_break() {
            return Some(Reason::Interrupted);
        }
        if self.falls_without_end(method) {
            return Some(Reason::Unbounded);
        }
        let Options { target, stationarity, violation, iterations, .. } = *self.options;
        match errors.violation <= violation {
            true if target.is_some_and(|target| at.value <= target) => Some(Reason::Target),
            true if errors.stationarity <= stationarity => Some(Reason::Stationary),
            _ => (self.history.len() > iterations).then_some(Reason::Iterations),
        }
    }

    /// True if the value falls at points at which the magnitude of the first one is below the rounding error, and the constraints hold up to it.
    fn falls_without_end(&mut self, method: &Method<'_>) -> bool {
        let size = largest(&method.y);
        let first = *self.first_size.get_or_insert(size.max(1.0));
        let Some([before, last]) = self.history.last_chunk() else { return false };
        let holds = last.violation <= self.options.violation.max(ROUNDING * size);
        f64::EPSILON * size > first && holds && last.value < before.value.min(self.history[0].value)
    }

    /// Reduces μ as far as errors allow; true if it changed.
    pub(super) fn lower_barrier(&self, method: &mut Method<'_>) -> bool {
        let (least, before) = (least_mu(self.options), method.barrier.mu);
        while method.barrier.mu > least {
            let mu = method.barrier.mu;
            let errors = method.errors(mu);
            if errors.stationarity.max(errors.violation) > SOLVED * mu {
                break;
            }
            method.barrier.mu = least.max((LESS * mu).min(mu.powf(POWER)));
        }
        method.barrier.mu != before
    }

    /// The next point; `None` if there is no acceptable one.
    fn next(&mut self, method: &mut Method<'_>, newton: &Newton<'_>, filter: &mut Filter) -> Option<Trial> {
        let residuals = method.residuals(&method.y, &method.values);
        let before = method.pair(&method.y, &method.values);
        let step = match search(self, method, newton, filter, (before, &residuals)) {
            Ok(found) => {
                self.failed = 0;
                if found.accepted == Accepted::Filtered {
                    filter.add(before);
                }
                return Some(found);
            }
            Err(step) => step,
        };
        self.failed += 1;
        if self.is_interrupted() || self.failed > MOST_FAILED {
            return None;
        }
        filter.clear();
        method.shift = MORE * method.shift.max(LEAST_SHIFT);
        trial(self, method, step, FRACTION).ok()
    }

    pub(super) fn without_derivatives(&mut self, error: Error) -> Result<Reason, Error> {
        if let Error::NoSecondDerivatives { .. } = error {
            return Err(error);
        }
        self.fail(error);
        Ok(if self.is_interrupted() { Reason::Interrupted } else { Reason::NoDerivative })
    }
}
