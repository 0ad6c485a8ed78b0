//! Phases between the events of a motion, found along an ordinary motion.

use nalgebra::DMatrix;

use super::Solver;
use crate::forward::check_new_grid;
use crate::{Error, Grid, Inputs};

/// Times that differ by less than this fraction of the motion are the same.
const SAME: f64 = 1e-9;

/// A time at which a phase ends: a change of the sign of the function of an event, a step of length zero, or the end of the grid.
struct Stop {
    event: Option<usize>,
    /// The given node after a step of length zero.
    jump: Option<usize>,
    /// Time since the start.
    time: f64,
}

impl Solver<'_> {
    /// The same inputs on a grid with a phase between every two events: all zeros of the functions of all events
    /// ([`Scene::event`](crate::Scene::event)) along the motion on the given grid, in their order. The steps of a phase are equal; there are at
    /// least `least` of them, and they are not longer than the mean of the given ones. Controls remain the same functions of time, and steps of length
    /// zero remain at their times, after an event at the same time.
    ///
    /// An event is found if its function changes its sign between two nodes of the given grid. The given events are ignored.
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
    /// inputs.start = hamiltonian_adjoint::Start::assembled(&system).hold(&rod.coordinates[2..]);
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
    /// ([`Sum::Node`](crate::Sum::Node)), which cannot be transferred to another grid.
    pub fn find_phases(&mut self, inputs: &Inputs, least: usize) -> Result<Inputs, Error> {
        let steps = &inputs.grid.steps;
        check_new_grid(self.system, inputs)?;
        if inputs.grid.around != [0, 0] {
            return Err(Error::EventsInPart);
        }
        // Costs at events are not evaluated yet.
        self.forget();
        self.forward.run(self.system, &Inputs { events: Vec::new(), ..inputs.clone() }, &self.settings)?;
        let (mut crossings, passed) = (self.crossings(), inputs.grid.passed());
        let end = passed[steps.len()];
        crossings.sort_by(|a, b| a.time.abs().total_cmp(&b.time.abs()));
        let mean = end / steps.iter().filter(|dt| **dt != 0.0).count() as f64;
        // Events at the same time share a phase, and one at the end of the grid ends the motion.
        let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * end.abs();
        crossings.dedup_by(|b, a| is_same(a.time, b.time));
        let jumps = (1..passed.len()).filter(|&node| steps[node - 1] == 0.0);
        let mut stops: Vec<Stop> = jumps.map(|node| Stop { event: None, jump: Some(node), time: passed[node] }).collect();
        stops.push(Stop { event: None, jump: None, time: end });
        for mut crossing in crossings {
            let at =
                stops.partition_point(|stop| stop.time.abs() < crossing.time.abs() && !is_same(stop.time, crossing.time));
            let same = stops.get(at).filter(|stop| is_same(stop.time, crossing.time));
            crossing.time = same.map_or(crossing.time, |stop| stop.time);
            stops.insert(at, crossing);
        }
        let (mut found, mut nodes, mut begin) = (Vec::new(), vec![(0.0, None)], 0.0);
        let mut events = Vec::new();
        for Stop { event, jump, time: until } in stops {
            if until != begin {
                let length = until - begin;
                // Estimates of errors halve the number of steps twice.
                let count = ((length / mean).ceil() as usize).max(least).max(1).next_multiple_of(4);
                found.extend(std::iter::repeat_n(length / count as f64, count));
                nodes.extend((1..count).map(|k| (begin + length * k as f64 / count as f64, None)));
                nodes.push((until, None));
            }
            events.extend(event.map(|event| self.system.event(event).at(found.len())));
            if jump.is_some() {
                found.push(0.0);
                nodes.push((until, jump));
            }
            begin = until;
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
        Ok(Inputs { grid: Grid::new(inputs.grid.start, found), controls, events, ..inputs.clone() })
    }

    /// The changes of sign of the functions of all events along the motion, by linear interpolation between nodes.
    fn crossings(&self) -> Vec<Stop> {
        let motion = &self.forward.motion;
        let start = motion.inputs.grid.start;
        let mut crossings = Vec::new();
        for event in 0..self.system.events() {
            let mut before = self.system.event_value(event, &motion.at(0));
            for node in 1..motion.nodes() {
                let after: f64 = self.system.event_value(event, &motion.at(node));
                // In a step of length zero a function may jump, but has no zero.
                if motion.length(node) != 0.0 && (before * after < 0.0 || before != 0.0 && after == 0.0) {
                    let [from, to] = [node - 1, node].map(|node| motion.time(node));
                    let share = before / (before - after);
                    let time = from + share * (to - from) - start;
                    crossings.push(Stop { event: Some(event), jump: None, time });
                }
                before = after;
            }
        }
        crossings
    }
}
