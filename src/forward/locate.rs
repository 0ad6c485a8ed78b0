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
use crate::error::quoted;
use crate::motion::{Occurrence, Phases, Scales};
use crate::{Error, Inputs, Settings, System, Warning};

/// Largest number of passes through a phase.
const MOST_PASSES: usize = 40;
/// A correction below this fraction of the time is rounding.
const ROUNDING: f64 = 1e-14;
/// A phase is located if its correction, which does not decrease any more, is below this fraction.
const LOCATED: f64 = 1e-9;
/// The number of such corrections, and the largest factor of the least one.
const STALLED: usize = 2;
const ABOVE_LEAST: f64 = 4.0;
/// A change of the function below this fraction of its value is not used for a secant.
const SMALL: f64 = 1e-6;
/// At the beginning of a phase, values of the function below this fraction of its largest value are zeros of the event before.
const ZERO: f64 = 1e-7;
/// An event is grazed if the rate of its function, times the length of the phase, is below this fraction of the largest value of the function.
const GRAZED: f64 = 0.05;
/// Largest factor of the length from one pass to the next.
const LONGER: f64 = 2.0;
/// Largest factor of the length of a phase that ends the motion.
const LONGEST: f64 = 100.0;
/// Factor of the length of a phase through which there is no motion.
const AFTER_FAILURE: f64 = 0.7;

/// The function of an event at the nodes of a phase, by the time since its beginning.
#[derive(Default)]
struct Samples(Vec<(f64, f64)>);

/// The search for the length of a phase.
struct Search {
    phase: usize,
    of: Occurrence,
    /// The given length, the present one, and the longest.
    given: f64,
    length: f64,
    longest: f64,
    samples: Samples,
    /// The lengths of the last passes and the functions at their ends, where the function was not negative and where it was.
    before: [Option<(f64, f64)>; 2],
    /// The least correction, and the number of corrections since then that were not half as large.
    least: f64,
    stalled: usize,
}

impl ForwardSweep {
    /// The motion with located events.
    pub(crate) fn run_located(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        self.begin(system, inputs, inputs.grid.nodes(), settings)?;
        self.locate(system, inputs, settings)?;
        self.advance(system, settings, usize::MAX).map(|_| ())
    }

    /// Locates all events of a motion that has begun, up to the last one, and returns the inputs with the steps found. The steps behind the last event
    /// are set, too.
    pub(crate) fn locate(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<Inputs, Error> {
        let (phases, mut taken) = (Phases::new(inputs), inputs.clone());
        let mut scales = Scales::default();
        let end = inputs.grid.steps.iter().sum::<f64>();
        let mut passed = 0.0;
        for phase in 0..phases.located {
            let given = phases.length(phase, &inputs.grid.steps);
            let is_last = phase + 1 == phases.count();
            let longest = if is_last { LONGEST * given } else { end - passed };
            let (of, samples) = (inputs.events[phase], Samples::default());
            let length = if given / longest < 1.0 { given } else { longest };
            let mut search =
                Search { phase, of, given, length, longest, samples, before: [None; 2], least: f64::INFINITY, stalled: 0 };
            let slope = self.find(system, (inputs, &mut taken, &phases), &mut search, settings)?;
            scales.push(search.length / given, slope);
            passed += search.length;
        }
        if phases.has_rest() {
            let given = phases.length(phases.located, &inputs.grid.steps);
            let scale = (end - passed) / given;
            if scale <= 0.0 || !scale.is_finite() {
                return Err(self.no_rest(system, inputs, end - passed));
            }
            self.set_steps((inputs, &mut taken), phases.steps(phases.located), scale);
            self.motion.retake(self.reached() - 1, &taken);
            scales.push(scale, 0.0);
        }
        self.motion.scales = scales;
        Ok(taken)
    }

    /// Finds the length of a phase, and returns dg/dT.
    fn find(
        &mut self,
        system: &System,
        (inputs, taken, phases): (&Inputs, &mut Inputs, &Phases),
        search: &mut Search,
        settings: &Settings,
    ) -> Result<f64, Error> {
        let (begin, warnings) = (self.save(), self.monitor.report.warnings.clone());
        let start = self.motion.time(begin.node);
        let mut failure = None;
        for _ in 0..MOST_PASSES {
            self.set_steps((inputs, taken), phases.steps(search.phase), search.length / search.given);
            self.rewind(&begin, taken);
            self.monitor.report.warnings.clone_from(&warnings);
            if let Err(error) = self.pass_through(system, search, settings) {
                if matches!(error, Error::Interrupted { .. }) {
                    return Err(error);
                }
                (search.longest, search.before) = (search.length, [None; 2]);
                search.length *= AFTER_FAILURE;
                failure = Some(error);
                continue;
            }
            if let Some(slope) = search.correct(system, start, failure.as_ref())? {
                search.warn(system, start, slope).into_iter().for_each(|warning| self.monitor.report.warn(warning));
                return Ok(slope);
            }
        }
        Err(failure.unwrap_or_else(|| search.not_located(system, start)))
    }

    fn set_steps(&mut self, (given, taken): (&Inputs, &mut Inputs), steps: std::ops::Range<usize>, scale: f64) {
        taken.grid.steps[steps.clone()].iter_mut().zip(&given.grid.steps[steps]).for_each(|(dt, given)| *dt = given * scale);
    }

    /// Computes the nodes of a phase, and the function of its event at them.
    fn pass_through(&mut self, system: &System, search: &mut Search, settings: &Settings) -> Result<(), Error> {
        let first = self.reached() - 1;
        let start = self.motion.time(first);
        search.samples.0.clear();
        let mut shown = first;
        loop {
            let (until, room) = (self.motion.trajectory.column_of(search.of.node), self.motion.trajectory.times.len());
            for node in shown..self.reached() {
                let g = system.event_value(search.of.event.index(), &self.motion.at(node));
                if !g.is_finite() {
                    let what = format!("event {} at node {}", quoted(system.event_name(search.of.event.index())), node);
                    return Err(Error::NotFinite { what, value: g });
                }
                search.samples.0.push((self.motion.time(node) - start, g));
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
        let side = usize::from(g < 0.0);
        let slope = match self.before[side] {
            Some((length, before)) if (g - before).abs() > SMALL * before.abs() => (g - before) / (end - length),
            _ => self.samples.slope_at_end(),
        };
        let root = self.samples.first_zero();
        let is_near = root.is_some_and(|root| (root - end).abs() < 0.05 * end.abs());
        let target = match root {
            Some(root) if !is_near => root,
            _ if slope != 0.0 && (is_near || (end - g / slope) / end > 0.0) => end - g / slope,
            _ => LONGER * end,
        };
        let correction = target - end;
        let size = (start + end).abs().max(end.abs());
        self.stalled = if correction.abs() < 0.5 * self.least { 0 } else { self.stalled + 1 };
        self.least = self.least.min(correction.abs());
        let is_stalled = self.stalled >= STALLED && correction.abs() <= (LOCATED * size).min(ABOVE_LEAST * self.least);
        if g == 0.0 || correction.abs() <= ROUNDING * size || is_stalled {
            return Ok(Some(slope));
        }
        if root.is_none() && self.length == self.longest {
            return Err(failure.cloned().unwrap_or_else(|| self.not_reached(system, start)));
        }
        self.before[side] = Some((end, g));
        let factor = (target / end).clamp(LONGER.recip(), LONGER);
        // A zero between nodes has been seen, so that the phase is known to be that short.
        let factor = if root.is_some() && !is_near { target / end } else { factor };
        self.length = if (end * factor / self.longest) < 1.0 { end * factor } else { self.longest };
        Ok(None)
    }

    /// Warnings of a phase that has been located.
    fn warn(&self, system: &System, start: f64, slope: f64) -> Vec<Warning> {
        let (event, node) = (system.event_name(self.of.event.index()), self.of.node);
        let share = (slope * self.length).abs() / self.samples.largest();
        let grazed = (share < GRAZED).then(|| {
            let time = start + self.length;
            Warning::Grazed { event: event.into(), node, time, share }
        });
        let missed = self.samples.missed().map(|at| Warning::MissedEvent { event: event.into(), node, time: start + at });
        grazed.into_iter().chain(missed).collect()
    }

    fn not_reached(&self, system: &System, start: f64) -> Error {
        let (at, gap) = self.samples.closest();
        Error::EventNotReached {
            event: system.event_name(self.of.event.index()).into(),
            node: self.of.node,
            until: start + self.length,
            closest: start + at,
            gap,
        }
    }

    fn not_located(&self, system: &System, start: f64) -> Error {
        let (end, gap) = self.samples.end();
        let event = system.event_name(self.of.event.index()).into();
        Error::EventNotLocated { event, node: self.of.node, time: start + end, gap }
    }
}

impl Samples {
    fn end(&self) -> (f64, f64) {
        self.0[self.0.len() - 1]
    }

    /// The first zero after the beginning, by a cubic polynomial; `None` if the sign does not change.
    fn first_zero(&self) -> Option<f64> {
        let samples = &self.0;
        let first = usize::from(samples[0].1.abs() <= ZERO * self.largest());
        let at = (first + 1..samples.len()).find(|&i| samples[i - 1].1 * samples[i].1 <= 0.0)?;
        let from = at.saturating_sub(2).min(samples.len().saturating_sub(4));
        Some(zero_between(&samples[from..samples.len().min(from + 4)], samples[at - 1], samples[at]))
    }

    /// The largest |g|.
    fn largest(&self) -> f64 {
        self.0.iter().fold(0.0f64, |largest, (_, g)| largest.max(g.abs()))
    }

    /// The time of a minimum of |g| between nodes at which the parabola through three of them has the other sign.
    fn missed(&self) -> Option<f64> {
        let vertex = |three: &[(f64, f64)]| {
            let [(a, f), (b, g), (c, h)] = [three[0], three[1], three[2]];
            let (left, right) = ((g - f) / (b - a), (h - g) / (c - b));
            let bend = (right - left) / (c - a);
            let at = 0.5 * (a + b) - 0.5 * left / bend;
            let value = f + (at - a) * (left + bend * (at - b));
            (g.abs() <= f.abs() && g.abs() <= h.abs() && f * g > 0.0 && g * h > 0.0 && value * g < 0.0).then_some(at)
        };
        let inner = &self.0[1.min(self.0.len())..];
        inner.windows(3).find_map(vertex)
    }

    /// dg/dt at the last node, by a cubic polynomial.
    fn slope_at_end(&self) -> f64 {
        let last = &self.0[self.0.len().saturating_sub(4)..];
        let (end, _) = self.end();
        (0..last.len()).map(|i| last[i].1 * slope_of_basis(last, i, end)).sum()
    }

    /// The smallest |g| after the first node, and its time.
    fn closest(&self) -> (f64, f64) {
        let later = self.0.iter().skip(1);
        later.fold((0.0, f64::INFINITY), |least, &(t, g)| if g.abs() < least.1.abs() { (t, g) } else { least })
    }
}

/// The zero of the polynomial through some samples between two of them, by bisection.
fn zero_between(samples: &[(f64, f64)], (mut low, before): (f64, f64), (mut high, _): (f64, f64)) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let value: f64 = (0..samples.len()).map(|i| samples[i].1 * basis(samples, i, middle)).sum();
        *(if value * before > 0.0 { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// The Lagrange polynomial of sample i.
fn basis(samples: &[(f64, f64)], i: usize, t: f64) -> f64 {
    let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
    others.map(|(_, other)| (t - other.0) / (samples[i].0 - other.0)).product()
}

/// The derivative of the Lagrange polynomial of sample i at a sample.
fn slope_of_basis(samples: &[(f64, f64)], i: usize, t: f64) -> f64 {
    let others = |without: usize| samples.iter().enumerate().filter(move |(j, _)| *j != i && *j != without);
    let terms = others(i).map(|(j, other)| {
        let rest: f64 = others(j).map(|(_, other)| (t - other.0) / (samples[i].0 - other.0)).product();
        rest / (samples[i].0 - other.0)
    });
    terms.sum()
}
