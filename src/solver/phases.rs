//! Phases between the events of a motion, found along ordinary motions.

use nalgebra::DMatrix;

use super::Solver;
use crate::accelerations::EventFunctions;
use crate::forward::check_new_grid;
use crate::{Error, Grid, Inputs};

/// Times that differ by less than this fraction of the motion are the same.
const SAME: f64 = 1e-9;
/// Behind an event, values of functions below this fraction of their largest values are zero.
const ZERO: f64 = 1e-9;
/// Impacts accumulate if this number of intervals between them decrease, and the last one is below this fraction of the mean step.
const DECREASING: usize = 5;
const SHORT: f64 = 1e-2;

/// An event, and its time since the start.
#[derive(Clone, Copy)]
struct Found {
    event: usize,
    time: f64,
}

/// A time since the start at which a phase ends: an event, steps of length zero with the given nodes after them, or the end of the grid.
struct Stop {
    time: f64,
    event: Option<usize>,
    jumps: Vec<usize>,
}

impl Solver {
    /// The same inputs on a grid with a phase between every two events: all zeros of the functions of all events
    /// ([`Scene::event`](crate::Scene::event)) along the motion, in their order. The steps of a phase are equal; there are at least `least` of them, and
    /// they are not longer than the mean of the given ones. Controls remain the same functions of time ([`Inputs::controls_in_time`]), also when events move
    /// the nodes, except those that jump in steps of length zero, which belong to the nodes. Steps of length zero remain at their times, after an event at
    /// the same time.
    ///
    /// An event is found if its function changes its sign between two nodes. The given events are ignored. Where an event opens or closes constraint
    /// equations ([`Scene::impact_at`](crate::Scene::impact_at)), the motion is computed anew from there on, with steps of length zero behind the
    /// event. Where impacts accumulate, an event with the same function that closes the equation ends them.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, planar::Body};
    /// use nalgebra::SVector;
    ///
    /// struct Angle;
    /// impl Cost<1, 0, 0, 0> for Angle {
    ///     fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
    ///         at.q[0]
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let rod = scene.body("rod", 1.0, 0.1, [0.0, -0.5, 0.4]);
    /// scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(0.0, 0.5));
    /// scene.gravity(0.0, -9.81);
    /// scene.event("upright", Angle, [rod.coordinates[2]], [], [], []);
    /// let system = scene.compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    /// inputs.start = hamiltonian_adjoint::Start::assembled(&system).hold(&[rod.coordinates[2]]);
    /// let mut solver = Solver::new(&system, Settings::default());
    /// let phases = solver.find_phases(&inputs, 20)?;
    /// let motion = solver.simulate(&phases)?;
    /// assert_eq!(phases.events.len(), 2);
    /// assert!(phases.events.iter().all(|upright| motion.q[(2, upright.node)].abs() < 1e-12));
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate); a composed grid, a part of a grid, or steps of both signs; a cost at a single node
    /// ([`Sum::Node`](crate::Sum::Node)), which cannot be transferred to another grid; impacts that accumulate.
    pub fn find_phases(&mut self, inputs: &Inputs, least: usize) -> Result<Inputs, Error> {
        check_new_grid(&self.system, inputs)?;
        if inputs.grid.around != [0, 0] {
            return Err(Error::EventsInPart);
        }
        let (mut found, mut phases) = (Vec::new(), Inputs { events: Vec::new(), ..inputs.clone() });
        let (end, mut functions) = (inputs.grid.steps.iter().sum(), EventFunctions::default());
        loop {
            // Costs at events are not evaluated yet.
            self.forget();
            self.forward.run(&self.system, &phases, &self.settings)?;
            self.correct_times(&mut found);
            if !self.rebounds(&found, &mut functions)? {
                self.settle(&mut found)?;
                phases = self.phases(inputs, &found, least);
                continue;
            }
            let is_new = self.find_next(&mut found, end, &mut functions)?;
            if !is_new && !found.is_empty() {
                return Ok(phases);
            }
            phases = self.phases(inputs, &found, least);
            let is_last = found.last().is_none_or(|last| self.system.zero_steps_of(last.event) == 0);
            if is_last || (found[found.len() - 1].time - end).abs() <= SAME * end.abs() {
                return Ok(phases);
            }
            if self.accumulate(&found, end) {
                self.settle(&mut found)?;
                phases = self.phases(inputs, &found, least);
            }
        }
    }

    /// Adds the next events of the current motion, up to the first one at which equations open or close; false if there is none.
    fn find_next(&self, found: &mut Vec<Found>, end: f64, functions: &mut EventFunctions) -> Result<bool, Error> {
        let mut crossings = self.crossings(functions)?;
        crossings.sort_by(|a, b| a.time.abs().total_cmp(&b.time.abs()));
        let is_same = |a: &Found, b: &Found| (a.time - b.time).abs() <= SAME * end.abs();
        // An event that closes the equation of an impact waits until impacts accumulate.
        let impacts = crossings.clone();
        crossings
            .retain(|of| !impacts.iter().any(|impact| is_same(of, impact) && self.system.settles(of.event, impact.event)));
        let changes = |found: &Found| self.system.zero_steps_of(found.event) > 0;
        if let Some(pair) = crossings.windows(2).find(|pair| is_same(&pair[0], &pair[1]) && pair.iter().all(changes)) {
            let [first, second] = [0, 1].map(|k| self.system.event_name(pair[k].event).to_string());
            return Err(Error::EventsAtOnce { first, second, time: self.forward.motion.inputs.grid.start + pair[0].time });
        }
        // Events at the same time share a phase; that at which equations change counts.
        crossings.dedup_by(|b, a| {
            let same = is_same(a, b);
            if same && changes(b) {
                *a = *b;
            }
            same
        });
        let count = crossings.iter().position(changes).map_or(crossings.len(), |first| first + 1);
        found.extend(&crossings[..count]);
        Ok(count > 0)
    }

    /// Replaces the times of located events by those of the current motion.
    fn correct_times(&self, found: &mut [Found]) {
        let motion = &self.forward.motion;
        for (of, event) in found.iter_mut().zip(&motion.inputs.events) {
            of.time = motion.time(motion.trajectory.column_of(event.node)) - motion.inputs.grid.start;
        }
    }

    /// False if the last event is an impact behind which the function has another sign than before: without a rebound, or with one that ends within a
    /// step.
    fn rebounds(&self, found: &[Found], functions: &mut EventFunctions) -> Result<bool, Error> {
        let motion = &self.forward.motion;
        let (Some(last), Some(of)) = (found.last(), motion.inputs.events.last()) else { return Ok(true) };
        let zeros = self.system.zero_steps_of(last.event);
        if zeros < 2 || of.node + zeros + 1 >= motion.inputs.grid.nodes() {
            return Ok(true);
        }
        let mut value = |node: usize| self.value(functions, last.event, motion.trajectory.column_of(node));
        Ok(value(of.node - 1)? * value(of.node + zeros + 1)? > 0.0)
    }

    /// True if impacts follow each other ever faster, and the last two within a small part of a step.
    fn accumulate(&self, found: &[Found], end: f64) -> bool {
        let gaps = gaps(found);
        let mean = (end / self.forward.motion.inputs.grid.steps.len() as f64).abs();
        let is_decreasing = gaps.len() > DECREASING && gaps[..DECREASING].windows(2).all(|pair| pair[0] < pair[1]);
        is_decreasing && gaps[0] < SHORT * mean
    }

    /// Replaces the last impact by an event that closes its equation.
    ///
    /// # Errors
    /// There is none.
    fn settle(&self, found: &mut [Found]) -> Result<(), Error> {
        let last = found[found.len() - 1];
        let Some(event) = (0..self.system.events()).find(|&event| self.system.settles(event, last.event)) else {
            return Err(self.accumulation(found));
        };
        found[found.len() - 1].event = event;
        Ok(())
    }

    fn accumulation(&self, found: &[Found]) -> Error {
        let (last, gaps) = (found[found.len() - 1], gaps(found));
        // The intervals are a geometric sequence in the limit.
        let left = match gaps[..] {
            [gap, before, ..] if gap < before => gap * gap / (before - gap),
            _ => 0.0,
        };
        let event = self.system.event_name(last.event).to_string();
        let time = self.forward.motion.inputs.grid.start + last.time + left.copysign(last.time);
        Error::Accumulation { event, count: gaps.len() + 1, time }
    }

    /// The inputs on a grid with a phase between every two events.
    fn phases(&self, inputs: &Inputs, found: &[Found], least: usize) -> Inputs {
        let (steps, passed) = (&inputs.grid.steps, inputs.grid.passed());
        let mean = passed[steps.len()] / steps.iter().filter(|dt| **dt != 0.0).count() as f64;
        // The times of the nodes, and the nodes of the given grid from which controls are taken.
        let (mut lengths, mut nodes, mut events) = (Vec::new(), vec![(0.0, None)], Vec::new());
        let mut begin = 0.0;
        for Stop { time, event, jumps } in stops(inputs, &passed, found) {
            if time != begin {
                // Estimates of errors halve the number of steps twice.
                let count = (((time - begin) / mean).ceil() as usize).max(least).max(1).next_multiple_of(4);
                lengths.extend(std::iter::repeat_n((time - begin) / count as f64, count));
                nodes.extend((1..count).map(|k| (begin + (time - begin) * k as f64 / count as f64, None)));
                nodes.push((time, None));
            }
            events.extend(event.map(|event| self.system.event(event).at(lengths.len())));
            let zeros = event.map_or(0, |event| self.system.zero_steps_of(event)).max(jumps.len());
            lengths.extend(std::iter::repeat_n(0.0, zeros));
            nodes.extend((0..zeros).map(|k| (time, jumps.get(k).or(jumps.last()).copied())));
            begin = time;
        }
        let mut controls = DMatrix::zeros(inputs.controls.nrows(), nodes.len());
        let mut step = 1;
        for (node, &(time, jump)) in nodes.iter().enumerate() {
            if let Some(given) = jump {
                controls.set_column(node, &inputs.controls.column(given));
                continue;
            }
            while step < steps.len() && passed[step].abs() < time.abs() {
                step += 1;
            }
            let c = ((time - passed[step - 1]) / steps[step - 1]).clamp(0.0, 1.0);
            inputs.controls_within(step, c, controls.column_mut(node).as_mut_slice());
        }
        let jumps = |k: usize| (0..lengths.len()).any(|i| lengths[i] == 0.0 && controls[(k, i)] != controls[(k, i + 1)]);
        let smooth = (0..self.system.k()).filter(|&k| !jumps(k));
        let controls_in_time = smooth.map(|k| self.system.control(k)).collect();
        Inputs { grid: Grid::new(inputs.grid.start, lengths), controls, events, controls_in_time, ..inputs.clone() }
    }

    /// The changes of sign of the functions of all events behind the last located event, by linear interpolation between nodes.
    fn crossings(&self, functions: &mut EventFunctions) -> Result<Vec<Found>, Error> {
        let motion = &self.forward.motion;
        let start = motion.inputs.grid.start;
        let zeros = |event: usize| self.system.zero_steps_of(event);
        let located =
            motion.inputs.events.last().map(|last| motion.trajectory.column_of(last.node + zeros(last.event.index())));
        let begin = located.unwrap_or(0);
        let mut crossings = Vec::new();
        for event in 0..self.system.events() {
            let values = (0..motion.nodes()).map(|node| self.value(functions, event, node));
            let mut values = values.collect::<Result<Vec<f64>, Error>>()?;
            let most = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            // Behind an event its function may be zero but for rounding, at once or for good.
            let is_behind = |node: usize| located.is_some_and(|located| located <= node);
            let is_zero = |(node, value): &(usize, &mut f64)| is_behind(*node) && value.abs() <= ZERO * most;
            values.iter_mut().enumerate().filter(is_zero).for_each(|(_, value)| *value = 0.0);
            let side = self.system.side_of(event);
            for node in begin..motion.nodes() - 1 {
                let [before, after] = [values[node], values[node + 1]];
                // In a step of length zero a function may jump, but has no zero.
                let comes_from_side = side * before >= 0.0;
                let is_zero = before * after < 0.0 || before != 0.0 && after == 0.0;
                if motion.length(node + 1) != 0.0 && is_zero && comes_from_side {
                    let [from, to] = [node, node + 1].map(|node| motion.time(node));
                    let share = before / (before - after);
                    crossings.push(Found { event, time: from + share * (to - from) - start });
                }
            }
        }
        Ok(crossings)
    }

    fn value(&self, functions: &mut EventFunctions, event: usize, node: usize) -> Result<f64, Error> {
        let motion = &self.forward.motion;
        let place = (motion.node_of_whole(node), motion.trajectory.compliance_from(node));
        functions.value(&self.system, event, (&motion.at(node), place))
    }
}

/// The times at which phases end, in their order.
fn stops(inputs: &Inputs, passed: &[f64], found: &[Found]) -> Vec<Stop> {
    let steps = &inputs.grid.steps;
    let end = passed[steps.len()];
    let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * end.abs();
    let mut stops: Vec<Stop> = Vec::new();
    for node in (1..passed.len()).filter(|&node| steps[node - 1] == 0.0) {
        match stops.last_mut().filter(|last| last.time == passed[node]) {
            Some(last) => last.jumps.push(node),
            None => stops.push(Stop { time: passed[node], event: None, jumps: vec![node] }),
        }
    }
    if stops.last().is_none_or(|last| last.time != end) {
        stops.push(Stop { time: end, event: None, jumps: Vec::new() });
    }
    for of in found {
        let at = stops.partition_point(|stop| stop.time.abs() < of.time.abs() && !is_same(stop.time, of.time));
        match stops.get_mut(at).filter(|stop| is_same(stop.time, of.time)) {
            Some(stop) => stop.event = Some(of.event),
            None => stops.insert(at, Stop { time: of.time, event: Some(of.event), jumps: Vec::new() }),
        }
    }
    stops
}

/// The intervals between events of the kind of the last one, from the last to the first.
fn gaps(found: &[Found]) -> Vec<f64> {
    let last = found.last().map(|last| last.event);
    let times: Vec<f64> = found.iter().rev().filter(|of| Some(of.event) == last).map(|of| of.time).collect();
    times.windows(2).map(|pair| (pair[0] - pair[1]).abs()).collect()
}
