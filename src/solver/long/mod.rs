//! [`LongSolver`]: motions of any length within a given amount of memory.
//!
//! A window of L nodes is stored in full, as in a [`Solver`](crate::Solver). Of a longer motion only checkpoints are stored. When the adjoint sweep
//! reaches a part of the motion, this part is recomputed from its checkpoint, with bitwise identical results:
//!
//! ```text
//!   forward  ├──────●──────●──────●──────┤   c checkpoints
//!   back                          ├●──●──┤   c more in the last part, …
//!                                     ├──┤   until a part fits into the window
//! ```
//!
//! With r levels, N ≤ L cʳ nodes can be reached, and every step is computed r + 1 times. The number of nodes that halved steps insert is not known
//! in advance. Memory is reserved for some; if there are more, the motion is continued without checkpoints, and then computed once more with a
//! new plan for the grid that is known by then.

mod plan;
mod state;
mod values;

use std::ops::ControlFlow;

use plan::{Plan, SHORTEST};
pub use state::State;
use values::{Sums, Values};

use super::check_weights;
use crate::adjoint::{AdjointSweep, Gradient, GridPhase, Located};
use crate::forward::{Checkpoint, ForwardSweep, HISTORY};
use crate::motion::Events;
use crate::motion::{Progress, Refinement, Report, Timed, Watch};
use crate::system::CostFactors;
use crate::{Error, Inputs, Settings, System};

/// The plan includes one additional node for this many nodes of the given grid.
const SPARE: usize = 8;

/// A solver for motions that do not fit into memory: value and gradient within a given number of bytes.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, LongSolver, Settings, gradient, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(2000, 0.002));
/// inputs.controls.fill(1.0);
/// let mut solver = LongSolver::new(&system, Settings::default(), 300_000);
/// let long = solver.gradient(&inputs)?;
/// assert_eq!(long.controls, gradient(&system, &inputs, Settings::default())?.controls);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct LongSolver {
    system: System,
    settings: Settings,
    bytes: usize,
    /// The nodes of the given grid, and whether it has events.
    given: usize,
    has_events: bool,
    /// The memory of the knots of controls that are functions of time.
    timed_bytes: usize,
    forward: ForwardSweep,
    /// One sweep for each right-hand side; empty if only the motion is computed.
    sweeps: Vec<AdjointSweep>,
    phase: GridPhase,
    /// Whether sweeps follow the kinks of the motion.
    follows: bool,
    /// The work of all sweeps.
    adjoint_report: Report,
    plan: Plan,
    /// True if the plan has room for restarts that the settings do not request, because dependent constraints are left out.
    leaves_out: bool,
    checkpoints: Vec<Checkpoint>,
    /// The number of computed nodes of the last motion.
    computed: usize,
    /// J and the outputs of the last motion; `None` if nodes were inserted during the motion.
    values: Option<Values>,
}

impl std::fmt::Debug for LongSolver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LongSolver").field("system", &self.system).field("bytes", &self.bytes).finish_non_exhaustive()
    }
}

impl LongSolver {
    /// A solver that stores at most `bytes` of a motion, including its copies of the inputs and the gradient.
    ///
    /// The workspace of one step is additional: about 4 kB per body of a chain, and 1 kB for each output of [`jacobian`](Self::jacobian).
    pub fn new(system: &System, settings: Settings, bytes: usize) -> Self {
        LongSolver {
            system: system.clone(),
            settings: Settings { keep_adjoint: false, ..settings },
            bytes,
            given: 0,
            has_events: false,
            timed_bytes: 0,
            forward: ForwardSweep::new(system, settings.scheme),
            sweeps: Vec::new(),
            phase: GridPhase::default(),
            follows: false,
            adjoint_report: Report::default(),
            plan: Plan::NONE,
            leaves_out: false,
            checkpoints: Vec::new(),
            computed: 0,
            values: None,
        }
    }

    /// Computes the motion and passes every node to `visit`; only the last nodes are stored.
    ///
    /// # Errors
    /// As [`Solver::simulate`](crate::Solver::simulate), or too little memory. The nodes before a failed step have been visited.
    pub fn simulate(&mut self, inputs: &Inputs, mut visit: impl FnMut(&State)) -> Result<(), Error> {
        self.sweeps.clear();
        self.follows = false;
        self.begin(inputs)?;
        self.forward_to_end(usize::MAX, &mut visit).map(|_| ())
    }

    /// J and its derivatives with respect to all inputs, equal to those of a [`Solver`](crate::Solver).
    ///
    /// # Errors
    /// As [`Solver::simulate`](crate::Solver::simulate) and [`Solver::gradient`](crate::Solver::gradient), or too little memory. If steps
    /// are halved, the lack of memory may be detected only during the motion.
    pub fn gradient(&mut self, inputs: &Inputs) -> Result<&Gradient, Error> {
        self.follow_kinks(inputs, |_| ())?;
        Ok(&self.sweeps[0].gradient)
    }

    /// The gradient of w₀ J + Σ w_k r_k over the outputs r, as in [`Solver::weighted_gradient`](crate::Solver::weighted_gradient).
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient), or a number of weights that differs from that of the outputs, or a weight that is not finite.
    pub fn weighted_gradient(&mut self, inputs: &Inputs, of_cost: f64, of_outputs: &[f64]) -> Result<&Gradient, Error> {
        check_weights(&self.system, of_cost, of_outputs)?;
        self.follow_kinks(inputs, |factors| factors.weigh(of_cost, of_outputs))?;
        Ok(&self.sweeps[0].gradient)
    }

    /// Values and gradients of all outputs, by one common backward sweep.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    pub fn jacobian(&mut self, inputs: &Inputs) -> Result<Vec<Gradient>, Error> {
        let outputs = self.system.outputs();
        if outputs == 0 {
            self.adjoint_report = Report::default();
            return self.simulate(inputs, |_| ()).map(|()| Vec::new());
        }
        self.differentiate(inputs, outputs, |k, factors| factors.choose(1 + k))?;
        self.adjoint_report = Report::of_all(self.sweeps.iter_mut().map(|sweep| std::mem::take(&mut sweep.report)));
        Ok(self.sweeps.drain(..).map(|sweep| sweep.gradient).collect())
    }

    /// Computes the motion and one backward sweep with several right-hand sides, and those of the events.
    fn differentiate(
        &mut self,
        inputs: &Inputs,
        count: usize,
        choose: impl Fn(usize, &mut CostFactors),
    ) -> Result<(), Error> {
        self.compute(inputs, (count + inputs.events.len(), false))?;
        for (k, sweep) in self.sweeps.iter_mut().enumerate() {
            sweep.begin(&self.system, &self.forward.motion, &self.settings)?;
            let factors = &mut sweep.cost.factors;
            if k < count { choose(k, factors) } else { factors.choose_event(k - count) }
        }
        self.back_to_start()?;
        self.sweeps.iter_mut().try_for_each(|sweep| sweep.finish(&self.system, &self.forward.monitor.report))?;
        if inputs.events.is_empty() {
            return Ok(());
        }
        let rows = self.sweeps.drain(count..).map(|sweep| sweep.gradient).collect();
        let unlocated = self.phase.unlocated(&self.system, &self.forward.motion);
        let located = Located::new(&self.system, &self.forward.motion, (rows, unlocated))?;
        self.sweeps.iter_mut().for_each(|sweep| located.complete(&mut sweep.gradient));
        Ok(())
    }

    /// Computes the motion and the backward sweeps of one gradient.
    fn follow_kinks(&mut self, inputs: &Inputs, choose: impl Fn(&mut CostFactors)) -> Result<(), Error> {
        if !inputs.events.is_empty() {
            self.differentiate(inputs, 1, |_, factors| choose(factors))?;
            self.adjoint_report = std::mem::take(&mut self.sweeps[0].report);
            return Ok(());
        }
        self.compute(inputs, (GridPhase::sweeps(&self.system), true))?;
        self.phase.begin_back(&mut self.sweeps, &self.system, &self.forward.motion, &self.settings, choose)?;
        self.back_to_start()?;
        self.phase.finish(&mut self.sweeps, &self.system, &self.forward.motion, &self.forward.monitor.report)?;
        self.adjoint_report = std::mem::take(&mut self.sweeps[0].report);
        Ok(())
    }

    /// Computes the motion with checkpoints for these sweeps, and examines its kinks if sweeps `follow` them. A plan for the motion alone has no
    /// checkpoints, so there is at least one sweep.
    fn compute(&mut self, inputs: &Inputs, (sweeps, follow): (usize, bool)) -> Result<(), Error> {
        self.sweeps.resize_with(sweeps, || AdjointSweep::new(&self.system, self.settings.scheme));
        self.follows = follow;
        self.begin(inputs)?;
        if !self.forward_to_end(self.plan.part(), &mut |_| ())? {
            let taken = self.forward.motion.nodes();
            self.plan = self.plan_within(self.bytes, taken).ok_or_else(|| self.too_little(taken, 0))?;
            self.forward.motion.make_room(self.plan.window + HISTORY);
            self.checkpoints.reserve_exact(self.plan.checkpoints * self.plan.levels);
            self.forward.begin_again(&self.system, &self.settings)?;
            self.forward_to_end(self.plan.part(), &mut |_| ())?;
        }
        Ok(())
    }

    /// Sweeps backward from the last node.
    fn back_to_start(&mut self) -> Result<(), Error> {
        self.forward.watch.turn();
        let starts: Vec<usize> = self.checkpoints.iter().map(|checkpoint| checkpoint.node).collect();
        let mut to = self.forward.motion.nodes() - 1;
        for from in starts.into_iter().rev().chain([0]) {
            self.back(from, to)?;
            self.checkpoints.pop();
            to = from;
        }
        Ok(())
    }

    /// Sets a progress callback for all motions and gradients, as [`Solver::watch`](crate::Solver::watch) does. Parts of a motion that are
    /// recomputed during the backward sweep are not reported.
    pub fn watch(&mut self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) {
        self.forward.watch = Watch::new(callback);
    }

    /// The inputs of the last motion, on the grid that was used.
    pub fn inputs(&self) -> &Inputs {
        &self.forward.motion.inputs
    }

    /// The work of the last motion, including recomputed steps.
    pub fn report(&self) -> &Report {
        &self.forward.monitor.report
    }

    /// The work of the last adjoint sweep.
    pub fn adjoint_report(&self) -> &Report {
        &self.adjoint_report
    }

    fn begin(&mut self, inputs: &Inputs) -> Result<(), Error> {
        self.leaves_out = false;
        self.system.check_events(inputs.events.len())?;
        self.begin_planned(inputs)?;
        if self.forward.motion.leaves_out() {
            self.leaves_out = true;
            self.begin_planned(inputs)?;
        }
        if inputs.events.is_empty() {
            return Ok(());
        }
        let taken = self.forward.locate(&self.system, inputs, &self.settings).map_err(|error| match error {
            Error::Memory { needed, .. } => self.too_little(2 * needed, 0),
            error => error,
        })?;
        let scales = self.forward.motion.scales.clone();
        self.begin_planned(&taken)?;
        self.forward.motion.scales = scales;
        Ok(())
    }

    fn begin_planned(&mut self, inputs: &Inputs) -> Result<(), Error> {
        self.checkpoints = Vec::new();
        (self.computed, self.values) = (0, None);
        self.settings.check()?;
        inputs.check(&self.system)?;
        (self.given, self.has_events) = (inputs.grid.nodes(), !inputs.events.is_empty());
        self.timed_bytes = Timed::bytes(inputs);
        let tight = self.plan_within(self.bytes, self.given).ok_or_else(|| self.too_little(self.given, 0))?;
        // Room for additional nodes, in case steps are halved, unless it makes the work much larger.
        let roomy = self.plan_within(self.bytes, self.given + (self.given / SPARE).max(SHORTEST));
        self.plan = roomy.filter(|roomy| roomy.levels == tight.levels).unwrap_or(tight);
        self.checkpoints.reserve_exact(self.plan.checkpoints * self.plan.levels);
        self.forward.motion.ahead.most_nodes = self.plan.nodes;
        self.forward.begin(&self.system, inputs, self.plan.window + HISTORY, &self.settings)
    }

    /// Computes the motion from node 0 on, with a checkpoint after every `every` nodes. Returns false if there were more nodes than planned,
    /// so that the checkpoints were discarded.
    fn forward_to_end(&mut self, mut every: usize, visit: &mut impl FnMut(&State)) -> Result<bool, Error> {
        // The refinements of the sweeps are set up again before the backward sweep.
        self.sweeps.iter_mut().for_each(|sweep| sweep.refinement = Refinement::default());
        let (refinement, inserted) = (self.forward.motion.refinement(), self.forward.motion.trajectory.inserted.len());
        let mut sums = Sums::new(&self.system, &refinement);
        let examines = !self.sweeps.is_empty() && (self.follows || self.has_events);
        if examines {
            let ForwardSweep { motion, stepper, .. } = &self.forward;
            self.phase.begin(&self.system, &stepper.newton.linearisation.evaluation, motion);
        }
        let (mut shown, mut as_planned) = (0, true);
        loop {
            let until = self.checkpoints.last().map_or(0, |checkpoint| checkpoint.node).saturating_add(every);
            let result = self.advance(until.saturating_add(1));
            let reached = self.forward.reached();
            // If steps are being halved, the weights of the sums are not known yet.
            let is_known = self.forward.motion.trajectory.inserted.len() == inserted;
            let motion = &self.forward.motion;
            let known = (examines && self.sweeps.len() > 1).then(|| motion.refinement());
            for node in shown..reached {
                visit(&self.forward.state(node));
                known.iter().for_each(|refinement| self.phase.examine(motion, refinement, node));
                if is_known {
                    sums.add(&self.system, &self.forward.motion, node);
                }
            }
            (shown, self.computed) = (reached, reached);
            let is_complete = reached == self.forward.motion.nodes();
            self.values = (is_known && is_complete).then(|| sums.values(&self.system));
            let has_room = result?;
            if is_complete {
                self.forward.warn_of_events();
                return Ok(as_planned);
            }
            if !has_room {
                (every, as_planned) = (usize::MAX, false);
                self.give_up_checkpoints()?;
            } else if reached > until {
                self.checkpoints.push(self.forward.save());
            }
            self.slide_if_full();
        }
    }

    /// Makes room for more nodes of the grid by storing only the shortest window of the motion.
    fn give_up_checkpoints(&mut self) -> Result<(), Error> {
        self.checkpoints = Vec::new();
        self.forward.slide();
        self.forward.motion.events = Events::default();
        self.plan.window = SHORTEST;
        self.forward.motion.make_room(SHORTEST + HISTORY);
        let nodes = self.forward.motion.nodes();
        let window = (SHORTEST + HISTORY) * self.bytes_per_node();
        let of_one_more = self.bytes_of_grid(nodes + 1) - self.bytes_of_grid(nodes);
        let free = self.bytes.saturating_sub(window + self.bytes_of_grid(nodes));
        if free < of_one_more {
            // At least twice as many nodes are expected; they need room beside the shortest window, too.
            return Err(self.too_little(2 * nodes, window + self.bytes_of_grid(2 * nodes)));
        }
        self.plan.nodes = nodes + free / of_one_more;
        self.forward.motion.ahead.most_nodes = self.plan.nodes;
        Ok(())
    }

    /// Computes the nodes before `end`, as far as the window has room.
    fn advance(&mut self, end: usize) -> Result<bool, Error> {
        let room = self.forward.motion.first + self.plan.window + HISTORY;
        self.forward.advance(&self.system, &self.settings, room.min(end))
    }

    fn slide_if_full(&mut self) {
        if self.forward.motion.trajectory.computed == self.plan.window + HISTORY {
            self.forward.slide();
        }
    }

    /// The adjoint sweep through the nodes from `to` down to `from` + 1 (to 0, if `from` is 0), recomputed from the last checkpoint.
    fn back(&mut self, from: usize, to: usize) -> Result<(), Error> {
        if self.plan.levels > 0 {
            self.load(from)?;
        }
        if to - from > self.plan.window {
            return self.split(from, to);
        }
        self.forward.advance(&self.system, &self.settings, to + 1)?;
        debug_assert!(self.forward.reached() > to, "the steps computed before succeed again");
        let last = if from == 0 { 0 } else { from + 1 };
        let ForwardSweep { motion, stepper, watch, .. } = &mut self.forward;
        let (sweeps, linearisation, nodes) = (&mut self.sweeps[..], &mut stepper.newton.linearisation, last..to + 1);
        match self.follows {
            true => self.phase.back(sweeps, &self.system, motion, linearisation, (nodes, watch)),
            false => AdjointSweep::back(sweeps, &self.system, motion, linearisation, (nodes, watch)),
        }
    }

    /// Adds one more level of checkpoints between two nodes.
    fn split(&mut self, from: usize, to: usize) -> Result<(), Error> {
        let part = (to - from).div_ceil(self.plan.checkpoints.max(2)).max(self.plan.window);
        let base = self.checkpoints.len();
        for node in (from + part..to).step_by(part) {
            while self.forward.reached() <= node {
                self.advance(node + 1)?;
                self.slide_if_full();
            }
            let checkpoint = self.forward.save();
            self.checkpoints.push(checkpoint);
        }
        let mut end = to;
        while self.checkpoints.len() > base {
            let start = self.checkpoints[self.checkpoints.len() - 1].node;
            self.back(start, end)?;
            self.checkpoints.pop();
            end = start;
        }
        self.back(from, end)
    }

    /// Restores the last checkpoint if it is at this node; otherwise returns to the start.
    fn load(&mut self, node: usize) -> Result<(), Error> {
        match self.checkpoints.last().filter(|checkpoint| checkpoint.node == node) {
            Some(checkpoint) => {
                self.forward.load(checkpoint);
                Ok(())
            }
            None => self.forward.begin_again(&self.system, &self.settings),
        }
    }
}
