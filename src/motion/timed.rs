//! [`Timed`]: controls that are functions of time, u(t), in a motion whose nodes move with located events.
//!
//! The given nodes are knots with times τ_k and values U_k. From knot k on, the control at the time t of a node is
//!
//! ```text
//!   u = U_k + r (t − τ_k),     r = (U_{k+1} − U_k)/(τ_{k+1} − τ_k)
//! ```
//!
//! The control is constant after the last knot. A control does not jump: knots at both ends of a step of length zero have the mean of their values, so that the
//! derivatives with respect to them are equal. Where a node is at a knot up to rounding, as in a motion whose given steps are right, r is the mean of both
//! sides: the derivative with respect to t does not depend on rounding, and is right to second order if the knots are those of a smooth function.

use std::ops::Range;

use nalgebra::DMatrix;
use num_dual::Dual64;

use crate::number::Real;
use crate::{Error, Inputs, System, Warning};

/// The knots of controls that are functions of time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Timed<R = f64> {
    /// The numbers of these controls.
    channels: Vec<usize>,
    /// The number of steps between knots: that of a macro step.
    every: usize,
    /// The times of the given nodes since the start.
    times: Vec<R>,
    /// The values of all controls at the given nodes.
    values: DMatrix<R>,
    /// Knots at the same time, the first and the last of them.
    twins: Vec<[usize; 2]>,
}

/// Nodes at a knot up to this fraction of the motion are at this knot.
const SAME: f64 = 1e-9;

/// A jump is told if it is larger than this fraction of the control.
const JUMP: f64 = 1e-6;

/// A time t near knot k.
struct Place<R> {
    /// k.
    knot: usize,
    /// t − τ_k.
    since: R,
    /// The steps between knots of whose slopes r is the mean: none after the last knot, one, or two.
    slopes: [Option<[usize; 2]>; 2],
}

impl<R> Place<R> {
    /// The steps, and the share of each in r.
    fn slopes(&self) -> impl Iterator<Item = ([usize; 2], f64)> {
        let count = self.slopes.iter().flatten().count();
        self.slopes.into_iter().flatten().map(move |step| (step, (count as f64).recip()))
    }
}

/// The derivatives of a function by the knots.
pub(crate) struct ByKnots<R> {
    /// dJ/dU for all controls, with those of other controls unchanged.
    pub(crate) values: DMatrix<R>,
    /// dJ/dτ.
    pub(crate) times: Vec<R>,
}

impl Timed {
    /// The knots with their changes along a direction of the given inputs.
    pub(crate) fn along(&self, direction: &Inputs) -> Timed<Dual64> {
        let times =
            self.times.iter().zip(direction.grid.passed()).map(|(time, change)| Dual64::new(*time, change)).collect();
        let mut changes = direction.controls.clone();
        self.average(&mut changes);
        let values = self.values.zip_map(&changes, Dual64::new);
        Timed { channels: self.channels.clone(), every: self.every, times, values, twins: self.twins.clone() }
    }
}

impl<R: Real> Timed<R> {
    /// `None` if no control is a function of time, or no event moves nodes.
    pub(crate) fn of(given: &Inputs<R>) -> Option<Self> {
        if !given.has_knots() {
            return None;
        }
        let mut channels: Vec<usize> = given.controls_in_time.iter().map(|control| control.index()).collect();
        channels.sort_unstable();
        channels.dedup();
        let (every, times) = (given.grid.stages, given.grid.passed());
        let mut twins: Vec<[usize; 2]> = Vec::new();
        for knot in (every..times.len()).step_by(every) {
            if times[knot].part(0) != times[knot - every].part(0) {
                continue;
            }
            match twins.last_mut().filter(|[_, last]| *last == knot - every) {
                Some([_, last]) => *last = knot,
                None => twins.push([knot - every, knot]),
            }
        }
        let mut values = given.controls.clone();
        let timed = Timed { channels, every, times, values: DMatrix::zeros(0, 0), twins };
        timed.average(&mut values);
        Some(Timed { values, ..timed })
    }

    /// Replaces the values of these controls, or derivatives with respect to them, at knots at the same time by their means.
    fn average<T: Real>(&self, values: &mut DMatrix<T>) {
        for &[first, last] in &self.twins {
            let knots = || (first..=last).step_by(self.every);
            let share = 1.0 / knots().count() as f64;
            for &channel in &self.channels {
                let mean = knots().fold(T::zero(), |sum, knot| sum + values[(channel, knot)]) * share;
                knots().for_each(|knot| values[(channel, knot)] = mean);
            }
        }
    }

    /// The memory of the knots, in bytes, and of the times of nodes while controls are written.
    pub(crate) fn bytes(given: &Inputs<R>) -> usize {
        if given.has_knots() { given.grid.nodes() * (2 + given.controls.nrows()) * size_of::<R>() } else { 0 }
    }

    /// Writes these controls at nodes, with the times of all nodes since the start.
    pub(crate) fn write(&self, times: &[R], nodes: Range<usize>, controls: &mut DMatrix<R>) {
        for node in nodes {
            let place = self.place(node, times[node]);
            for &channel in &self.channels {
                controls[(channel, node)] = self.values[(channel, place.knot)] + self.rate(&place, channel) * place.since;
            }
        }
    }

    /// dJ/dt of all nodes, from dJ/du at all nodes.
    pub(crate) fn by_times(&self, times: &[R], by_controls: &DMatrix<R>) -> Vec<R> {
        let by_time = |(node, &t): (usize, &R)| {
            let place = self.place(node, t);
            let terms = self.channels.iter().map(|&channel| self.rate(&place, channel) * by_controls[(channel, node)]);
            terms.fold(R::zero(), |sum, term| sum + term)
        };
        times.iter().enumerate().map(by_time).collect()
    }

    /// The derivatives with respect to the knots, from those with respect to the controls at all nodes.
    pub(crate) fn by_knots(&self, times: &[R], by_controls: &DMatrix<R>) -> ByKnots<R> {
        let mut by = ByKnots { values: by_controls.clone(), times: vec![R::zero(); self.times.len()] };
        self.channels.iter().for_each(|&channel| by.values.row_mut(channel).fill(R::zero()));
        for (node, &t) in times.iter().enumerate() {
            let place = self.place(node, t);
            for &channel in &self.channels {
                let by_control = by_controls[(channel, node)];
                by.values[(channel, place.knot)] += by_control;
                by.times[place.knot] -= by_control * self.rate(&place, channel);
                for (step, share) in place.slopes() {
                    let [length, slope] = self.step(step, channel);
                    let by_end = by_control * place.since * share / length;
                    for (knot, sign) in step.into_iter().zip([-1.0, 1.0]) {
                        by.values[(channel, knot)] += by_end * sign;
                        by.times[knot] -= by_end * slope * sign;
                    }
                }
            }
        }
        self.average(&mut by.values);
        by
    }

    /// r of a control.
    fn rate(&self, place: &Place<R>, channel: usize) -> R {
        place.slopes().fold(R::zero(), |sum, (step, share)| sum + self.step(step, channel)[1] * share)
    }

    /// The length of a step between knots, and the slope of a control.
    fn step(&self, [from, to]: [usize; 2], channel: usize) -> [R; 2] {
        let length = self.times[to] - self.times[from];
        [length, (self.values[(channel, to)] - self.values[(channel, from)]) / length]
    }

    fn place(&self, node: usize, t: R) -> Place<R> {
        let (time, now) = (|knot: usize| self.times[knot].part(0), t.part(0));
        let end = time(self.last());
        let is_at = |knot: &usize| (time(*knot) - now).abs() <= SAME * end.abs();
        let is_over = |knot: usize| if end < 0.0 { time(knot) >= now } else { time(knot) <= now };
        // The number of knots that are not after t. In a step of a composed grid that goes back, t may be before the first one.
        let (mut low, mut high) = (1, self.last() / self.every + 1);
        while low < high {
            let middle = low.midpoint(high);
            (low, high) = if is_over(middle * self.every) { (middle + 1, high) } else { (low, middle) };
        }
        let behind = low * self.every;
        let before = behind - self.every;
        let own = Some(node).filter(|node| node.is_multiple_of(self.every));
        let near = own.into_iter().chain([before, behind.min(self.last())]).find(is_at);
        let knot = near.unwrap_or(before);
        let slopes = match near {
            Some(knot) => {
                let is_other = |other: &usize| time(*other) != time(knot);
                let left = (0..knot / self.every).rev().map(|k| k * self.every).find(is_other);
                let right = (knot..=self.last()).step_by(self.every).find(is_other);
                [left.map(|left| [left, left + self.every]), right.map(|right| [right - self.every, right])]
            }
            None => [(behind <= self.last()).then_some([before, behind]), None],
        };
        Place { knot, since: t - self.times[knot], slopes }
    }

    /// The last knot.
    fn last(&self) -> usize {
        self.times.len() - 1
    }
}

/// Returns an error unless the controls that are functions of time are those of the system.
pub(crate) fn check_timed(inputs: &Inputs, system: &System) -> Result<(), Error> {
    let mut timed = inputs.controls_in_time.iter();
    let is_foreign = timed.any(|control| control.index() >= system.k() || !system.owns(control.0));
    match is_foreign {
        true => Err(Error::Foreign { element: "Inputs::controls_in_time".into(), kind: "control" }),
        false => Ok(()),
    }
}

/// A warning if a control that is a function of time jumps in a step of length zero.
pub(crate) fn find_jump(given: &Inputs, system: &System) -> Option<Warning> {
    let Inputs { grid, controls, controls_in_time: timed, .. } = given;
    let jump = |k: usize, step: usize| controls[(k, step + 1)] - controls[(k, step)];
    let jumps = |k: usize, step: usize| jump(k, step).abs() > JUMP * controls.row(k).amax();
    let mut zeros = (0..grid.steps.len()).filter(|&step| grid.steps[step] == 0.0);
    zeros.find_map(|step| {
        let k = timed.iter().map(|control| control.index()).find(|&k| jumps(k, step))?;
        Some(Warning::MeanOfJump { control: system.control_name(k).into(), step: step + 1, jump: jump(k, step) })
    })
}
