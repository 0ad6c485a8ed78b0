//! Phases between the events of a motion, found along an ordinary motion.

use nalgebra::DMatrix;

use super::Solver;
use crate::forward::check_new_grid;
use crate::{Error, Grid, Inputs};

/// Times that differ by less than this fraction of the motion are the same.
const SAME: f64 = 1e-9;

/// A change of the sign of the function of an event.
struct Crossing {
    event: usize,
    /// Time since the start.
    time: f64,
}

impl Solver<'_> {
    /// The same inputs on a grid with a phase between every two events: all zeros of the functions of all events
    /// ([`Scene::event`](crate::Scene::event)) along the motion on the given grid, in their order. The steps of a phase are equal; there are at
    /// least `least` of them, and they are not longer than the mean of the given ones. Controls remain the same functions of time.
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
        let end = passed[passed.len() - 1];
        crossings.sort_by(|a, b| a.time.abs().total_cmp(&b.time.abs()));
        let mean = end / steps.len() as f64;
        // Events at the same time share a phase, and one at the end of the grid ends the motion.
        let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * end.abs();
        crossings.dedup_by(|b, a| is_same(a.time, b.time));
        let rest = crossings.last().is_none_or(|last| !is_same(last.time, end)).then_some((end, None));
        let (mut found, mut times, mut begin) = (Vec::new(), vec![0.0], 0.0);
        let mut events = Vec::new();
        for (until, event) in crossings.iter().map(|c| (c.time, Some(c.event))).chain(rest) {
            let length = until - begin;
            // Estimates of errors halve the number of steps twice.
            let count = ((length / mean).ceil() as usize).max(least).max(1).next_multiple_of(4);
            found.extend(std::iter::repeat_n(length / count as f64, count));
            times.extend((1..=count).map(|k| begin + length * k as f64 / count as f64));
            events.extend(event.map(|event| self.system.event(event).at(found.len())));
            begin = until;
        }
        let mut controls = DMatrix::zeros(inputs.controls.nrows(), times.len());
        let mut step = 1;
        for (node, &time) in times.iter().enumerate() {
            while step < steps.len() && passed[step].abs() < time.abs() {
                step += 1;
            }
            let c = ((time - passed[step - 1]) / steps[step - 1]).clamp(0.0, 1.0);
            inputs.controls_within(step, c, controls.column_mut(node).as_mut_slice());
        }
        Ok(Inputs { grid: Grid::new(inputs.grid.start, found), controls, events, ..inputs.clone() })
    }

    /// The changes of sign of the functions of all events along the motion, by linear interpolation between nodes.
    fn crossings(&self) -> Vec<Crossing> {
        let motion = &self.forward.motion;
        let start = motion.inputs.grid.start;
        let mut crossings = Vec::new();
        for event in 0..self.system.events() {
            let mut before = self.system.event_value(event, &motion.at(0));
            for node in 1..motion.nodes() {
                let after: f64 = self.system.event_value(event, &motion.at(node));
                if before * after < 0.0 || before != 0.0 && after == 0.0 {
                    let [from, to] = [node - 1, node].map(|node| motion.time(node));
                    let share = before / (before - after);
                    crossings.push(Crossing { event, time: from + share * (to - from) - start });
                }
                before = after;
            }
        }
        crossings
    }
}
