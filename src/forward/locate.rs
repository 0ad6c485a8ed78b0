//! Location of events: the steps of a phase are multiplied by a common factor until the function of the event that ends it is zero at its last node.
//!
//! With T the length of a phase and g the function at its end,
//!
//! ```text
//!   T ← T − g / (dg/dT)
//! ```
//!
//! The first guess is the zero of the cubic polynomial through g at the nodes around the first change of its sign; afterwards dg/dT is that of a secant
//! through two lengths at which g has the same sign, because an element may begin to act where g = 0, so that dg/dT jumps there.
//! The factor changes no node before the phase, so phases are located one by one, each from a checkpoint at its beginning.

use super::ForwardSweep;
use super::samples::Samples;
use crate::accelerations::EventFunctions;
use crate::error::quoted;
use crate::motion::{Occurrence, Scales, Trial, find_jump};
use crate::{Error, Inputs, Settings, System, Warning};

/// Largest number of passes through a phase.
const MOST_PASSES: usize = 40;
/// A correction below this fraction of the time is rounding.
const ROUNDING: f64 = 1e-14;
/// A phase is located if its correction, which does not decrease any more, is below this fraction.
const LOCATED: f64 = 1e-9;
/// The number of such corrections.
const STALLED: usize = 3;
/// The number of passes after which a length is halved between those that are too short and too long.
const SLOW: usize = 2;
/// A change of the function below this fraction of its value is not used for a secant.
const SMALL: f64 = 1e-6;
/// At the beginning of a phase, values of the function below this fraction of its largest value are zeros of the same event before it, or of the start.
const ZERO: f64 = 1e-7;
/// If another event was before it, both happen at the same time below this fraction.
const SAME_TIME: f64 = 1e-12;
/// The time of a node, on which the function may depend, is known up to this fraction, but a phase to more than this one.
const TIME: f64 = 100.0 * f64::EPSILON;
const MOST_ROUNDING: f64 = 1e-3;
/// At an event the function is below this fraction of its largest value in the first pass.
const POLE: f64 = 1e-3;
/// A zero that was not seen may lie before the end of the phase by less than one minus this fraction, because the steps have changed.
const EARLIER: f64 = 0.999;
/// A secant steeper than the function along the motion by this factor is that of a jump.
const STEEP: f64 = 1e4;
/// A single step after the same event is longer than this fraction of the given one.
const EMPTY: f64 = 1e-6;
/// An event is grazed if the rate of its function, times the length of the phase, is below this fraction of the largest value of the function.
const GRAZED: f64 = 0.05;
/// Largest factor of the length from one pass to the next.
const LONGER: f64 = 2.0;
/// Largest factor of the length of a phase that ends the motion.
const LONGEST: f64 = 100.0;
/// Factor of the length of a phase through which there is no motion.
const AFTER_FAILURE: f64 = 0.7;

/// The search for the length of a phase.
struct Search {
    phase: usize,
    of: Occurrence,
    /// The given length, the present one, and the longest.
    given: f64,
    length: f64,
    longest: f64,
    samples: Samples,
    functions: EventFunctions,
    /// At the beginning, values of the function below this fraction of its largest value count as zero.
    zero: f64,
    /// The lengths of the last passes and the functions at their ends, where the function was not negative and where it was.
    before: [Option<(f64, f64)>; 2],
    /// The largest value of the function in the first pass.
    largest: f64,
    /// The last correction, and the number of corrections that were not smaller than half of the one before.
    correction: f64,
    stalled: usize,
    /// A length, without its sign, up to which no zero was seen, and one up to which one was; the number of passes that hardly brought them closer.
    between: [f64; 2],
    slow: usize,
}

impl ForwardSweep {
    /// The motion with located events.
    pub(crate) fn run_located(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        self.begin(system, inputs, inputs.grid.nodes(), settings)?;
        self.locate(system, inputs, settings)?;
        self.advance(system, settings, usize::MAX)?;
        self.warn_of_events();
        Ok(())
    }

    /// Adds the warnings of located events, after those of the motion.
    pub(crate) fn warn_of_events(&mut self) {
        self.motion.scales.warnings.iter().for_each(|warning| self.monitor.report.warn(warning.clone()));
    }

    /// Locates all events of a motion that has begun, up to the last one, and returns the inputs with the steps found. The steps behind the last event
    /// are set, too.
    pub(crate) fn locate(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<Inputs, Error> {
        let (mut trial, mut scales) = (Trial::of(inputs), Scales::default());
        scales.warnings.extend(find_jump(inputs, system));
        let end = inputs.grid.steps.iter().sum::<f64>();
        let mut passed = 0.0;
        for phase in 0..trial.phases.located {
            let given = trial.phases.length(phase, &inputs.grid.steps);
            let is_last = phase + 1 == trial.phases.count();
            let longest = if is_last { LONGEST * given } else { end - passed };
            let (of, samples) = (inputs.events[phase], Samples::default());
            let length = if given / longest < 1.0 { given } else { longest };
            let mut search = Search {
                phase,
                of,
                given,
                length,
                longest,
                samples,
                functions: EventFunctions::default(),
                zero: ZERO,
                before: [None; 2],
                largest: 0.0,
                correction: f64::INFINITY,
                stalled: 0,
                between: [0.0, f64::INFINITY],
                slow: 0,
            };
            let before = phase.checked_sub(1).map(|before| inputs.events[before].event);
            search.zero = if before.is_none_or(|before| before == of.event) { ZERO } else { SAME_TIME };
            let slope = self.find(system, &mut trial, &mut search, settings)?;
            scales.push(search.length / given, slope);
            scales.warnings.extend(search.warn(system, self.motion.time(self.reached() - 1), slope));
            passed += search.length;
        }
        if trial.phases.has_rest() {
            let rest = trial.phases.located;
            let given = trial.phases.length(rest, &inputs.grid.steps);
            let scale = (end - passed) / given;
            if scale <= 0.0 || !scale.is_finite() || (end - passed).abs() <= ROUNDING * end.abs() {
                return Err(self.no_rest(system, inputs, end - passed));
            }
            trial.set_steps(rest, scale);
            self.motion.retake(self.reached() - 1, &trial.taken);
            scales.push(scale, 0.0);
        }
        scales.timed = trial.timed;
        self.motion.scales = scales;
        Ok(trial.taken)
    }

    /// Finds the length of a phase, and returns dg/dT.
    fn find(
        &mut self,
        system: &System,
        trial: &mut Trial<f64>,
        search: &mut Search,
        settings: &Settings,
    ) -> Result<f64, Error> {
        let (begin, found) = (self.save(), self.found());
        let start = self.motion.time(begin.node);
        let mut failure = None;
        for _ in 0..MOST_PASSES {
            trial.set_steps(search.phase, search.length / search.given);
            self.rewind(&begin, &trial.taken);
            self.restore_found(&found);
            if let Err(error) = self.pass_through(system, search, settings) {
                if matches!(error, Error::Interrupted { .. } | Error::Memory { .. }) {
                    return Err(error);
                }
                search.give_way();
                failure = Some(error);
                continue;
            }
            if let Some(slope) = search.correct(system, start, failure.as_ref())? {
                return Ok(slope);
            }
        }
        Err(failure.unwrap_or_else(|| search.not_located(system, start)))
    }

    /// Computes the nodes of a phase, and the function of its event at them.
    fn pass_through(&mut self, system: &System, search: &mut Search, settings: &Settings) -> Result<(), Error> {
        // Times since the beginning are not lost in the rounding of late start times.
        let (mut shown, mut passed) = (self.reached() - 1, None);
        search.samples.0.clear();
        loop {
            let (until, room) = (self.motion.trajectory.column_of(search.of.node), self.motion.trajectory.times.len());
            for node in shown..self.reached() {
                let time = passed.map_or(0.0, |passed| passed + self.motion.length(node));
                passed = Some(time);
                if !self.motion.ends_macro_step(node) {
                    continue;
                }
                let compliance = self.motion.trajectory.compliance_from(node);
                let place = (self.motion.node_of_whole(node), compliance);
                let g = search.functions.value(system, search.of.event.index(), (&self.motion.at(node), place))?;
                if !g.is_finite() {
                    let what = format!("event {} at node {node}", quoted(&search.name(system)));
                    return Err(Error::NotFinite { what, value: g });
                }
                // At the ends of a step of length zero, the function is that after it.
                search.samples.0.pop_if(|last| last.0 == time);
                search.samples.0.push((time, g));
            }
            shown = self.reached();
            if shown > until {
                return Ok(());
            }
            if self.motion.trajectory.computed == room {
                self.slide();
            }
            if !self.advance(system, settings, (self.motion.first + room).min(until + 1))? {
                return Err(Error::Memory { given: self.motion.nodes(), needed: self.motion.nodes() + 1 });
            }
        }
    }

    fn no_rest(&self, system: &System, inputs: &Inputs, left: f64) -> Error {
        let Occurrence { event, node } = inputs.events[inputs.events.len() - 1];
        Error::EventAtEnd {
            event: system.event_name(event.index()).into(),
            node,
            time: self.motion.time(self.reached() - 1),
            left,
        }
    }
}

impl Search {
    /// Corrects the length of the phase after a pass, and returns dg/dT if it is right.
    fn correct(&mut self, system: &System, start: f64, failure: Option<&Error>) -> Result<Option<f64>, Error> {
        let (end, g) = self.samples.end();
        if self.largest == 0.0 {
            self.largest = self.samples.largest();
        }
        let begins_with_zero = self.samples.0[0].1.abs() <= self.zero * self.samples.largest().min(self.largest);
        let side = usize::from(g < 0.0);
        let has_moved = |length: f64| (end - length).abs() > ROUNDING * end.abs();
        let (slope, is_known) = match self.before[side] {
            Some((length, before)) if has_moved(length) && (g - before).abs() > SMALL * before.abs() => {
                ((g - before) / (end - length), (end - length).abs() < 0.05 * end.abs())
            }
            _ => (self.samples.slope_at_end(), true),
        };
        let side_of_zero = system.side_of(self.of.event.index());
        let first = self.samples.first_zero(begins_with_zero, side_of_zero);
        let may_be_here = self.samples.has_been_on(side_of_zero);
        let root = first.map(|(root, _)| root);
        // Of several zeros the first one counts.
        let is_near = first.is_some_and(|(root, is_last)| is_last && (root - end).abs() < 0.05 * end.abs());
        let is_single = self.samples.0.len() == 2 && begins_with_zero;
        let earliest = if is_single { 0.0 } else { EARLIER };
        let target = match root {
            Some(root) if !is_near => root,
            // A zero that was not seen is not earlier, except in a single step after the same event.
            _ if slope != 0.0 && may_be_here && (is_near || (end - g / slope) / end > earliest) => end - g / slope,
            _ => LONGER * end,
        };
        let correction = target - end;
        let is_slow = correction.abs() >= 0.5 * self.correction.abs();
        let rounding = (TIME * (start + end).abs()).clamp(LOCATED * end.abs(), MOST_ROUNDING * end.abs());
        self.stalled += usize::from(is_slow && correction.abs() <= rounding);
        let is_stalled = self.stalled >= STALLED && correction.abs() <= rounding;
        let is_first = may_be_here && (root.is_none() || is_near);
        let is_small = is_known && correction.abs() <= ROUNDING * end.abs() || is_stalled;
        // Corrections are small near a pole, too, and a single step after the same event may shrink to nothing.
        // A function of halved steps may jump over its zero.
        let is_jump = is_small && slope.abs() > STEEP * self.samples.slope_at_end().abs();
        let is_zero = if is_single { end / self.given > EMPTY } else { g.abs() < POLE * self.largest };
        if is_first && is_zero && !is_jump && (g == 0.0 || is_small) {
            return Ok(Some(slope));
        }
        if root.is_none() && self.length == self.longest {
            return Err(failure.cloned().unwrap_or_else(|| self.not_reached(system, start)));
        }
        (self.before[side], self.correction) = (Some((end, g)), correction);
        let factor = (target / end).clamp(LONGER.recip(), LONGER);
        // A zero between nodes has been seen, so that the phase is known to be that short.
        let factor = if root.is_some() && !is_near { target / end } else { factor };
        let next = self.within(end, root.is_some(), (end * factor, is_slow));
        self.length = match next / self.longest < 1.0 {
            true => next,
            false if failure.is_some() => self.between_known(),
            false => self.longest,
        };
        Ok(None)
    }

    /// The next length after one through which there is no motion.
    fn give_way(&mut self) {
        (self.longest, self.before) = (self.length, [None; 2]);
        self.length = if self.between[0] > 0.0 { self.between_known() } else { AFTER_FAILURE * self.length };
    }

    /// The middle between the longest phase without a zero and one through which there is no motion.
    fn between_known(&self) -> f64 {
        (0.5 * (self.between[0] + self.longest.abs())).copysign(self.longest)
    }

    /// The next length, or the middle between the lengths known to be too short and too long, if it is not between them or does not approach.
    fn within(&mut self, end: f64, is_long: bool, (next, is_slow): (f64, bool)) -> f64 {
        let (size, [short, long]) = (end.abs(), self.between);
        self.between = match is_long {
            true => [if size > short { short } else { 0.0 }, long.min(size)],
            false if size < long => [short.max(size), long],
            false => [short, long],
        };
        let ([short, long], before) = (self.between, long - short);
        if long.is_infinite() {
            return next;
        }
        self.slow = if is_slow && long - short > 0.5 * before { self.slow + 1 } else { 0 };
        let is_between = short < next.abs() && next.abs() < long;
        if is_between && self.slow < SLOW { next } else { (0.5 * (short + long)).copysign(end) }
    }

    /// Warnings of a phase that has been located and ends at this time.
    fn warn(&self, system: &System, end: f64, slope: f64) -> Vec<Warning> {
        let start = end - self.length;
        let (event, node) = (self.name(system), self.of.node);
        // A secant through lengths that hardly differ is rounding.
        let slope = slope.abs().max(self.samples.slope_at_end().abs());
        let share = (slope * self.length).abs() / self.samples.largest();
        let is_crossed = share >= GRAZED;
        let grazed = (!is_crossed).then(|| Warning::Grazed { event: event.clone(), node, time: end, share });
        let missed = self.samples.missed().map(|at| Warning::MissedEvent { event: event.clone(), node, time: start + at });
        grazed.into_iter().chain(missed).collect()
    }

    /// The name of the event.
    fn name(&self, system: &System) -> String {
        system.event_name(self.of.event.index()).into()
    }

    fn not_reached(&self, system: &System, start: f64) -> Error {
        let (at, gap) = self.samples.closest();
        Error::EventNotReached {
            event: self.name(system),
            node: self.of.node,
            until: start + self.length,
            closest: start + at,
            gap,
        }
    }

    fn not_located(&self, system: &System, start: f64) -> Error {
        let (end, gap) = self.samples.end();
        Error::EventNotLocated { event: self.name(system), node: self.of.node, time: start + end, gap }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, planar::Body};

    /// The slope found at the end of a phase with g = 1 − 2 t up to there, after a pass through a phase of another length.
    fn slope(end: f64, before: (f64, f64)) -> Result<Option<f64>, Error> {
        let mut scene = Scene::new();
        let ball = scene.particle("ball", 1.0, [0.0, 1.0]);
        scene.rigid_contact("floor", Body::GROUND.at(0.0, 0.0), 1.5, ball.point());
        let system = scene.compile()?;
        let samples = Samples(vec![(0.0, 1.0), (0.25, 0.5), (0.5, end)]);
        let mut search = Search {
            phase: 0,
            of: system.event(0).at(2),
            given: 0.5,
            length: 0.5,
            longest: 1.0,
            samples,
            functions: EventFunctions::default(),
            zero: ZERO,
            before: [Some(before), None],
            largest: 1.0,
            correction: 1.0,
            stalled: 0,
            between: [0.0, f64::INFINITY],
            slow: 0,
        };
        search.correct(&system, 0.0, None)
    }

    #[test]
    fn two_passes_of_one_length_have_no_secant() -> Result<(), Error> {
        assert!(slope(6e-17, (0.5, 5e-17))?.is_some_and(|slope| (slope + 2.0).abs() < 1e-12));
        Ok(())
    }

    #[test]
    fn a_function_that_jumps_over_its_zero_has_none() -> Result<(), Error> {
        // Of the length that is shorter by 1e-13, the function is larger by 1e-5.
        assert_eq!(slope(1e-6, (0.5 - 1e-13, 1.1e-5))?, None);
        Ok(())
    }
}
