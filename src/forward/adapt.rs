//! Adaptive grids, on which the estimated error of every step is below a tolerance.
//!
//! ```text
//!   error = max_i ( |δq_i| / max(1, |q_i|),  Δt |δv_i| / max(1, |v_i|) ),     K(h) (δv, δσ) = (δp*, 0),     Δt ← 0.9 Δt (tolerance/error)^(1/k)
//! ```
//!
//! Errors of velocities are weighted by the coordinate change that they cause in a step, as for index-2 variables in RADAU5 (Hairer & Wanner,
//! *Solving Ordinary Differential Equations II*, VII.4). Unweighted, they alone would determine the grid, and steps would be shortest where a
//! mechanism reverses sharply, although much of the error in v is undone after the reversal: the four-bar of `tests/motion/adapt.rs` would take a
//! fifth more steps by the trapezoidal rule for the same error.
//!
//! The error of a scheme of even order p is an odd derivative of the motion, Δt^(p+1) d^(p+1)x/dt^(p+1), whose sign alternates from swing to swing.
//! Such errors cancel over equal steps, but less over steps adapted to them. Steps of these schemes lie between the two,
//!
//! ```text
//!   Δt ≤ √(Δt_e Δt̄) / 1.5,     Δt_e the steps by errors alone, Δt̄ their mean
//! ```
//!
//! Without this bound the trapezoidal rule takes 9 % more steps than a uniform grid on the slider-crank of `tests/motion/adapt.rs`, and 14 % more on
//! the four-bar; with it, 8 % and 5 % fewer. The test determines the uniform grids to within a tenth.
//!
//! δq and δp* are the estimates of the scheme (`scheme/estimate.rs`), of order k. Solving with K(h) converts the errors of momenta to errors of
//! velocities; it removes components in the directions of the reactions and damps components that are too stiff to contribute to the motion.
//!
//! These estimates do not show a tolerance below rounding: with embedded weights the rounding error of δq is about Δt ε |v|, which short steps
//! reduce. But the sum q + Δq has the rounding error ½ ε |q|, unless q hardly moves: if it exceeds the tolerance, shorter steps make the motion
//! worse.

use nalgebra::DMatrix;

use super::{ForwardSweep, HISTORY};
use crate::motion::{Clock, Task, column, column_mut};
use crate::node::StepFailure;
use crate::scheme::local_error;
use crate::system::Pair;
use crate::{Error, Grid, Inputs, Occurrence, Settings, System};

/// Safety factor of the step length, and range of the ratio of successive step lengths.
const SAFETY: f64 = 0.9;
const RANGE: (f64, f64) = (0.2, 5.0);
/// The first trial step, as a fraction of the motion.
const FIRST: f64 = 1e-3;
/// Factor of the step length after a step without a solution.
const AFTER_FAILURE: f64 = 0.25;
/// Number of nodes in memory in addition to the history.
const WINDOW: usize = 64;
/// Steps determined by errors alone are not changed if they are shorter than 1/1.5² of their mean.
const BETWEEN: f64 = 1.0 / 1.5;
/// Steps shorter than this fraction of the motion are lost in rounding.
const SHORTEST: f64 = 1e-14;
/// Slopes of controls are equal if they differ by less than this fraction, or if the controls differ by less than `SAME` of the largest.
const STRAIGHT: f64 = 1e-9;
const SAME: f64 = 8.0 * f64::EPSILON;

/// The given nodes at which controls bend or jump, that have an event, or at which the motion ends. An adaptive grid contains them, because a method has its order
/// only between them.
fn kinks(inputs: &Inputs) -> Vec<usize> {
    let (steps, u) = (&inputs.grid.steps, &inputs.controls);
    let largest: Vec<f64> = u.row_iter().map(|channel| channel.amax()).collect();
    let bends_in = |channel: usize, node: usize| {
        let [u0, u1, u2] = [node - 1, node, node + 1].map(|node| u[(channel, node)]);
        let (before, after) = ((u1 - u0) / steps[node - 1], (u2 - u1) / steps[node]);
        let rounding = SAME * largest[channel] / steps[node - 1].abs().min(steps[node].abs());
        // A jump is a short step with a large slope; the slopes next to it are small in comparison.
        (after - before).abs() > STRAIGHT * before.abs().max(after.abs()) + rounding
    };
    let jumps = |node: usize| steps[node - 1] == 0.0 || steps[node] == 0.0;
    let bends = |node: &usize| jumps(*node) || (0..u.nrows()).any(|channel| bends_in(channel, *node));
    let has_event = |node: usize| inputs.events.binary_search_by_key(&node, |event| event.node).is_ok();
    (1..steps.len()).filter(|node| bends(node) || has_event(*node)).chain([steps.len()]).collect()
}

/// A grid under construction: the computed steps, and the straight piece of the given inputs in which the next step lies.
///
/// Times are counted from the start, because steps would be lost in the rounding of late start times, such as dates.
struct Growing<'a> {
    given: &'a Inputs,
    times: Vec<f64>,
    now: Clock,
    kinks: std::iter::Peekable<std::vec::IntoIter<usize>>,
    /// The given step that contains the current time.
    at: usize,
    /// The events passed, at their nodes on the new grid.
    events: Vec<Occurrence>,
}

impl Growing<'_> {
    /// Passes a kink, which is a node of the new grid.
    fn pass_kink(&mut self, node: usize) {
        let given = self.kinks.next();
        let event = self.given.events.iter().find(|event| Some(event.node) == given);
        self.events.extend(event.map(|event| Occurrence { node, ..*event }));
    }

    /// The next kink, and the time until then: exactly zero for a step of length zero.
    fn piece(&mut self) -> Option<(usize, f64)> {
        let node = *self.kinks.peek()?;
        let is_jump = self.given.grid.steps[node - 1] == 0.0;
        Some((node, if is_jump { 0.0 } else { self.times[node] - self.now.time() }))
    }

    /// The given controls at a time.
    fn controls(&mut self, t: f64, u: &mut [f64]) {
        let forth = self.times[self.times.len() - 1] >= 0.0;
        let is_over = |end: f64| if forth { end <= t } else { end >= t };
        while self.at + 2 < self.times.len() && is_over(self.times[self.at + 1]) {
            self.at += 1;
        }
        // A repeated trial step ends earlier.
        while self.at > 0 && !is_over(self.times[self.at]) {
            self.at -= 1;
        }
        let c = (t - self.times[self.at]) / self.given.grid.steps[self.at];
        self.given.controls_within(self.at + 1, c.clamp(0.0, 1.0), u);
    }
}

/// The longest step from time `t` on: between those of `grid` and equal ones.
fn between(grid: &Grid, times: &[f64], t: f64) -> f64 {
    let mean = times[times.len() - 1] / grid.steps.len() as f64;
    let step = times[1..grid.steps.len()].partition_point(|time| time.abs() <= t.abs());
    BETWEEN * (grid.steps[step] * mean).sqrt()
}

impl ForwardSweep {
    /// The inputs on a grid on which the estimated error of every step is below the tolerance.
    pub(crate) fn adapt(
        &mut self,
        system: &System,
        inputs: &Inputs,
        settings: &Settings,
        tolerance: f64,
    ) -> Result<Inputs, Error> {
        check(system, inputs, tolerance)?;
        let located = match inputs.events.is_empty() {
            true => None,
            false => {
                self.begin(system, inputs, inputs.grid.nodes(), settings)?;
                Some(self.locate(system, inputs, settings)?)
            }
        };
        let inputs = located.as_ref().unwrap_or(inputs);
        let by_errors = self.grow(system, inputs, settings, tolerance, &|_| f64::INFINITY)?;
        if settings.scheme.order % 2 == 1 {
            return Ok(by_errors);
        }
        let times = by_errors.grid.passed();
        self.grow(system, inputs, settings, tolerance, &|t| between(&by_errors.grid, &times, t))
    }

    /// The inputs on a grid determined by errors alone, with an upper bound on each step as a function of the time at which it begins.
    fn grow(
        &mut self,
        system: &System,
        inputs: &Inputs,
        settings: &Settings,
        tolerance: f64,
        longest: &dyn Fn(f64) -> f64,
    ) -> Result<Inputs, Error> {
        let done = self.grow_steps(system, inputs, settings, (tolerance, longest));
        // The nodes in memory are not a complete motion and must not be returned as one.
        self.motion.trajectory.computed = 0;
        let taken = &mut self.motion.inputs;
        taken.controls = taken.controls.columns(0, taken.grid.nodes()).into_owned();
        done.map(|()| {
            taken.start = inputs.start.clone();
            taken.clone()
        })
    }

    fn grow_steps(
        &mut self,
        system: &System,
        inputs: &Inputs,
        settings: &Settings,
        (tolerance, longest): (f64, &dyn Fn(f64) -> f64),
    ) -> Result<(), Error> {
        let (times, now, kinks) = (inputs.grid.passed(), Clock::new(0.0), kinks(inputs).into_iter().peekable());
        let mut growing = Growing { given: inputs, times, now, kinks, at: 0, events: Vec::new() };
        let duration = growing.times[growing.times.len() - 1];
        let mut dt = FIRST * duration;
        self.begin(system, &first_step(inputs, dt), WINDOW + HISTORY, settings)?;
        self.motion.is_growing = true;
        let mut delta = Pair::new(system.n(), system.m());
        let mut delta_q = vec![0.0; system.n()];
        let mut node = 1;
        let mut may_lengthen = true;
        while let Some((kink, left)) = growing.piece() {
            if self.motion.trajectory.computed == WINDOW + HISTORY {
                self.slide();
            }
            let begin = growing.now.time();
            let bounded = dt.abs().min(longest(begin)).copysign(dt);
            let is_last = bounded.abs() >= 0.999 * left.abs();
            // Use two steps of equal length rather than a tiny last one.
            let length = if is_last {
                left
            } else if 2.0 * bounded.abs() > left.abs() {
                0.5 * left
            } else {
                bounded
            };
            self.append(&mut growing, node, (length, is_last.then_some(kink)));
            let factor = match self.step(system, node, settings) {
                Ok(()) => {
                    let error = self.error_of_step(system, node, (&mut delta_q, &mut delta)) / tolerance;
                    let order = settings.scheme.estimate_order() as f64;
                    let factor = (SAFETY * error.powf(-order.recip())).clamp(RANGE.0, RANGE.1);
                    if error > 1.0 && is_too_short(length, duration) {
                        return Err(Error::Tolerance { time: self.motion.time(node - 1), length, error });
                    }
                    // The first step is repeated while a step of five times its length would satisfy the tolerance.
                    may_lengthen = may_lengthen && error <= 1.0 && factor == RANGE.1 && length == dt;
                    if error <= 1.0 && !may_lengthen {
                        self.refuse_rounding(system, node, tolerance)?;
                        self.check_compliant(system, node, settings)?;
                        self.watch_dependent(system, node);
                        self.monitor.lengths.watch_reach(&self.motion, node);
                        self.pass_events(system, node, settings)?;
                        node += 1;
                        growing.now = growing.now.after(length);
                        self.motion.trajectory.computed = node - self.motion.first;
                        if is_last {
                            growing.pass_kink(node - 1);
                        }
                        // Estimate of the number of nodes if steps continue like this.
                        let share = (begin + length) / duration;
                        let nodes = 1 + ((node - 1) as f64 / share).round() as usize;
                        self.watch.tell_of_guess(Task::Simulation, node, nodes)?;
                    }
                    factor
                }
                Err(failure) => {
                    self.give_up_if_hopeless(system, node, failure, is_too_short(length, duration))?;
                    may_lengthen = false;
                    AFTER_FAILURE
                }
            };
            // A step that was shortened for the grid says little about longer steps.
            dt = if factor > 1.0 && length.abs() < dt.abs() { dt } else { length * factor };
        }
        self.motion.inputs.events = growing.events;
        Ok(())
    }

    fn give_up_if_hopeless(
        &self,
        system: &System,
        node: usize,
        failure: StepFailure,
        is_too_short: bool,
    ) -> Result<(), Error> {
        let is_hopeless = is_too_short || self.model_fault(system, node, &failure);
        if is_hopeless { Err(self.explain(system, node, failure)) } else { Ok(()) }
    }

    /// Returns an error if the tolerance is below the rounding error of a coordinate in the step that ends at a node.
    fn refuse_rounding(&self, system: &System, node: usize, tolerance: f64) -> Result<(), Error> {
        let (k, dt) = (node - self.motion.first, self.motion.inputs.grid.steps[node - 1]);
        let [q, v] = [&self.motion.trajectory.q, &self.motion.trajectory.v].map(|x| column(x, k));
        let rounding = |i: usize| (0.5 * f64::EPSILON * q[i].abs()).min((dt * v[i]).abs()) / q[i].abs().max(1.0);
        match (0..q.len()).find(|&i| rounding(i) > tolerance) {
            Some(i) => {
                let (coordinate, rounding) = (system.coordinate_name(i).to_string(), rounding(i));
                Err(Error::Rounding { time: self.motion.time(node), coordinate, rounding, tolerance })
            }
            None => Ok(()),
        }
    }

    /// Makes this step the last one of the grid and discards the steps after it.
    fn append(&mut self, growing: &mut Growing, node: usize, (length, kink): (f64, Option<usize>)) {
        self.motion.inputs.grid.steps.truncate(node - 1);
        self.motion.inputs.grid.steps.push(length);
        let (channels, room) = self.motion.inputs.controls.shape();
        if room <= node {
            // Double the memory, so that all copies together cost as much as the last.
            let controls = std::mem::replace(&mut self.motion.inputs.controls, DMatrix::zeros(0, 0));
            self.motion.inputs.controls = controls.resize_horizontally(2 * node + WINDOW, 0.0);
        }
        debug_assert_eq!(channels, growing.given.controls.nrows());
        let u = column_mut(&mut self.motion.inputs.controls, node);
        match kink {
            Some(given) => u.copy_from_slice(growing.given.controls_at(given)),
            None => growing.controls(growing.now.time() + length, u),
        }
    }

    /// The estimated error of the step that ends at a node.
    fn error_of_step(&mut self, system: &System, node: usize, (delta_q, delta): (&mut [f64], &mut Pair)) -> f64 {
        let (k, steps, trajectory) = (node - self.motion.first, &self.motion.inputs.grid.steps, &self.motion.trajectory);
        let (scheme, dt) = (&trajectory.scheme, steps[node - 1]);
        let is_known = k >= 2 && node >= 2 && steps[node - 2] != 0.0;
        let before = is_known.then(|| (steps[node - 2], trajectory.columns(k - 2)));
        let of = |which: usize| before.as_ref().map(|(dt, y)| (*dt, [y.v, y.p_star_dot][which]));
        local_error(scheme, dt, |s| trajectory.rates(k, s).0, of(0), delta_q);
        local_error(scheme, dt, |s| trajectory.rates(k, s).1, of(1), &mut delta.v);
        delta.sigma.fill(0.0);
        self.stepper.newton.linearisation.solve(system, delta);
        let largest = |errors: &[f64], sizes: &[f64]| {
            let relative = errors.iter().zip(sizes).map(|(error, x)| error.abs() / x.abs().max(1.0));
            relative.fold(0.0, |most: f64, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
        };
        let of_q = largest(delta_q, column(&self.motion.trajectory.q, k));
        let of_v = largest(&delta.v, column(&self.motion.trajectory.v, k));
        of_q.max(dt.abs() * of_v)
    }
}

/// True if a step cannot be shortened.
fn is_too_short(length: f64, duration: f64) -> bool {
    length.abs() <= SHORTEST * duration.abs()
}

/// The start of the given inputs, with a single step.
fn first_step(inputs: &Inputs, dt: f64) -> Inputs {
    let controls = DMatrix::from_fn(inputs.controls.nrows(), 2, |channel, _| inputs.controls[(channel, 0)]);
    Inputs { grid: Grid { steps: vec![dt], ..inputs.grid }, controls, events: Vec::new(), ..inputs.clone() }
}

/// Checks that an adaptive grid can be computed for these inputs.
fn check(system: &System, inputs: &Inputs, tolerance: f64) -> Result<(), Error> {
    inputs.check(system)?;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::Parameter { what: "the tolerance".into(), value: tolerance, must_be: "a positive number" });
    }
    check_new_grid(system, inputs)
}

/// Checks that these inputs can be transferred to another grid.
pub(crate) fn check_new_grid(system: &System, inputs: &Inputs) -> Result<(), Error> {
    if let Some((node, cost)) = system.last_cost_node().filter(|(node, _)| *node > 0) {
        let what = format!("the node at which `{cost}` is evaluated (`Sum::Node`)");
        return Err(Error::Parameter {
            what,
            value: node as f64,
            must_be: "0 on an adaptive grid or one with phases, whose nodes are not known beforehand; use `Sum::Terminal`, or a given grid",
        });
    }
    if inputs.grid.stages > 1 {
        let value = inputs.grid.stages as f64;
        return Err(Error::Parameter {
            what: "`Grid::stages`".into(),
            value,
            must_be: "1 for an adaptive grid or one with phases",
        });
    }
    let steps = &inputs.grid.steps;
    let first = steps.first().copied().unwrap_or_default();
    match steps.iter().position(|dt| *dt != 0.0 && dt.signum() != first.signum()) {
        Some(step) => {
            let what = format!("the length of step {} in s (step 1: {first} s)", step + 1);
            Err(Error::Parameter {
                what,
                value: steps[step],
                must_be: "of the same sign for an adaptive grid or one with phases",
            })
        }
        None if steps.is_empty() => {
            Err(Error::Parameter { what: "the number of steps".into(), value: 0.0, must_be: "1 or more" })
        }
        None => Ok(()),
    }
}
