//! A run of the forward sweep: the consistent start, then one step after another, with checks.

use nalgebra::DMatrix;

use super::{ForwardSweep, restart, start};
use crate::assembly::Assembler;
use crate::motion::{Clock, Examiner, Report, Scales, Task, column, with_open};
use crate::node::StepFailure;
use crate::system::{Given, NodeView, Order};
use crate::{Error, Inputs, Multiplier, Settings, Start, System, Trajectory, Warning, memory};

impl ForwardSweep {
    pub(crate) fn run(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        if !inputs.events.is_empty() {
            return self.run_located(system, inputs, settings);
        }
        self.begin(system, inputs, inputs.grid.nodes(), settings)?;
        self.advance(system, settings, usize::MAX).map(|_| ())
    }

    /// Copies the inputs, makes room for a number of nodes and solves node 0; allocates only if the room differs from that of the previous call.
    pub(crate) fn begin(&mut self, system: &System, inputs: &Inputs, room: usize, settings: &Settings) -> Result<(), Error> {
        self.motion.trajectory.computed = 0;
        (self.monitor.report, self.monitor.examiner) = (Report::default(), Examiner::new(Order::First));
        let elements: Vec<String> = system.too_long().map(String::from).collect();
        self.monitor.report.warnings.extend((!elements.is_empty()).then_some(Warning::NoProgram { elements }));
        self.watch.begin();
        settings.check()?;
        inputs.check(system)?;
        if self.motion.trajectory.times.len() != room {
            // Inputs and gradient need additional memory.
            let node = system.bytes_per_node(settings) + 2 * (1 + system.k()) * size_of::<f64>();
            memory::check("the motion", room, node)?;
            self.motion.trajectory = Trajectory::zeros(system, room, settings.scheme);
            self.motion.blocks = DMatrix::zeros(system.block_len(), room * settings.scheme.stages());
        }
        self.take(system, inputs, settings)?;
        self.motion.trajectory.inserted.clear();
        self.motion.ahead.forget();
        self.motion.is_growing = false;
        self.motion.scales = Scales::default();
        self.monitor.most_turn = Warning::TURN;
        self.monitor.oscillation.begin(system.n());
        self.dependence.forget_brakes();
        self.stepper.continuation.counted = 0;
        self.begin_again(system, settings)
    }

    /// Sets the inputs, the current formulas, and a start that satisfies the constraints.
    pub(crate) fn take(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        self.motion.inputs.copy_from(inputs);
        self.motion.design.clear();
        self.motion.design.extend_from_slice(&system.parameters().values(inputs.design.as_slice()));
        self.stepper.start_p.fill(0.0);
        self.stepper.start_sigma.fill(0.0);
        let state = [inputs.start.q().as_slice(), &self.stepper.start_p, &self.stepper.start_sigma];
        let start = NodeView::of_equations(state, (inputs.controls_at(0), inputs.grid.start, &self.motion.design));
        system.check_panics(&start)?;
        self.stepper.newton.linearisation.evaluation.set_start(system, &start)?;
        self.monitor.lengths.begin(system, &self.stepper.newton.linearisation);
        self.assemble(system, inputs, settings)
    }

    /// Assembles a start that satisfies the constraints, if the start is a guess.
    fn assemble(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        self.motion.assembly = None;
        let Start::Assembled { q, v, held } = &inputs.start else { return Ok(()) };
        let given = Given { u: inputs.controls_at(0), t: inputs.grid.start, design: &self.motion.design };
        let open = inputs.open.iter().map(Multiplier::index).collect();
        let (linearisation, report) = (&mut self.stepper.newton.linearisation, &mut self.monitor.report);
        // Larger tolerances are meant for given starts.
        let tolerance = settings.position_tolerance.min(Settings::default().position_tolerance);
        let mut assembler = Assembler { system, linearisation, report, tolerance, open };
        let assembled = assembler.assemble(q.as_slice(), v.as_slice(), held, given);
        let (start, assembly) = assembled.map_err(|error| error.started_at(inputs.grid.around[0]))?;
        self.motion.inputs.start = start;
        self.motion.assembly = Some(assembly);
        Ok(())
    }

    /// Solves node 0 of the current inputs.
    pub(crate) fn begin_again(&mut self, system: &System, settings: &Settings) -> Result<(), Error> {
        (self.motion.first, self.stepper.smooth_from, self.restarting.most_range) = (0, 0, 0.0);
        self.motion.events.clear();
        self.dependence.forget_circuits();
        self.motion.ahead.again();
        self.motion.trajectory.computed = 0;
        self.motion.trajectory.restarted.clear();
        self.motion.forget_compliance();
        if !self.motion.inputs.open.is_empty() {
            let open: Vec<usize> = self.motion.inputs.open.iter().map(Multiplier::index).collect();
            self.motion.set_compliance(0, with_open(&[], &open));
        }
        self.motion.trajectory.times[0] = self.motion.inputs.grid.start;
        self.stepper.newton.linearisation.evaluation.set_compliance(self.motion.trajectory.compliance_from(0));
        self.stepper.set_clock(0, Clock::new(self.motion.inputs.grid.start));
        let first = self.motion.inputs.grid.around[0];
        start::solve(self, system, settings).map_err(|error| error.started_at(first))?;
        self.check_energies(system, 0)?;
        self.monitor.examiner.visit(system, &self.motion, 0, &mut self.monitor.report);
        restart::keep_end(self, 0);
        self.monitor.lengths.reach.fill(0.0);
        self.monitor.lengths.watch_reach(&self.motion, 0);
        Ok(())
    }

    /// Computes the nodes before `end`, as far as the grid goes, and halves steps without a solution. Returns false if there is no memory for a node
    /// that had to be inserted.
    pub(crate) fn advance(&mut self, system: &System, settings: &Settings, end: usize) -> Result<bool, Error> {
        let was_known = self.motion.ahead.is_known(self.motion.nodes());
        let done = self.take_steps(system, settings, end);
        let next = self.motion.first + self.motion.trajectory.computed;
        self.motion.know(next);
        if done.is_err() || next == self.motion.nodes() {
            // A failed step is known with its halvings; a step before which the motion was stopped is still ahead.
            let has_failed = done.as_ref().is_err_and(|error| !matches!(error, Error::Interrupted { .. }));
            self.motion.close_gap(next - usize::from(!has_failed));
            if done.is_ok() && !was_known {
                self.warn_of_halved_steps();
            }
        }
        done
    }

    fn take_steps(&mut self, system: &System, settings: &Settings, end: usize) -> Result<bool, Error> {
        let mut node = self.motion.first + self.motion.trajectory.computed;
        while node < self.motion.nodes().min(end) {
            self.motion.take(node);
            let smooth_from = self.stepper.smooth_from;
            while let Err(failure) = self.step(system, node, settings) {
                // Information from the long step must not be used when its halves are recomputed.
                self.stepper.smooth_from = smooth_from;
                if !self.shorten(system, node, failure, settings)? {
                    return Ok(false);
                }
            }
            self.motion.keep(node);
            self.check_energies(system, node)?;
            self.check_compliant(system, node, settings)?;
            self.watch_dependent(system, node);
            self.watch_turns(system, node);
            self.monitor.lengths.watch_reach(&self.motion, node);
            self.pass_events(system, node, settings)?;
            if !system.gaps().is_empty() {
                self.watch_contacts(system, node, settings);
            }
            self.monitor.watch_drift(system, &self.motion, &self.stepper.newton.linearisation, node, settings);
            self.monitor.examiner.visit(system, &self.motion, node, &mut self.monitor.report);
            self.monitor.watch_oscillation(system, &self.motion, &self.stepper.newton.linearisation.weights, node);
            node += 1;
            self.motion.trajectory.computed = node - self.motion.first;
            self.watch.tell(Task::Simulation, node, self.motion.nodes())?;
        }
        if node == self.motion.nodes() {
            self.dependent(system).look_at_end(settings)?;
        }
        Ok(true)
    }

    /// Halves a failed step if that may help; false if there is no memory for another node.
    #[cold]
    fn shorten(&mut self, system: &System, node: usize, failure: StepFailure, settings: &Settings) -> Result<bool, Error> {
        if self.model_fault(system, node, &failure) || !self.motion.may_halve(node, settings) {
            return Err(self.explain(system, node, failure));
        }
        let has_room = self.motion.nodes() < self.motion.ahead.most_nodes;
        if has_room {
            self.motion.halve(node)
        } else {
            self.motion.put_back(node)
        }
        Ok(has_room)
    }

    /// Keeps the warning of the angle with the largest rotation in one step, if it is too large.
    fn watch_turns(&mut self, system: &System, node: usize) {
        let k = node - self.motion.first;
        let (before, now) = (column(&self.motion.trajectory.q, k - 1), column(&self.motion.trajectory.q, k));
        let turn = |i: usize| (now[i] - before[i]).abs();
        let Some(i) = system.sines().coordinates().find(|&i| turn(i) > self.monitor.most_turn) else { return };
        let worst = system.sines().coordinates().fold(i, |worst, i| if turn(i) > turn(worst) { i } else { worst });
        self.monitor.most_turn = turn(worst);
        let coordinate = system.coordinate_name(worst).to_string();
        let (step, time) = (self.motion.step_of_whole(node), self.motion.trajectory.times[k]);
        self.monitor.report.replace(Warning::Unresolved { coordinate, step, time, turn: self.monitor.most_turn });
    }

    /// Returns an error if an energy is not defined at a node, even though its derivatives are.
    fn check_energies(&self, system: &System, node: usize) -> Result<(), Error> {
        if !system.has_partly_defined_energies() {
            return Ok(());
        }
        system.find_undefined_energy(&self.motion.at(node), self.motion.node_of_whole(node)).map_or(Ok(()), Err)
    }

    /// Warns of the steps that were halved.
    #[cold]
    fn warn_of_halved_steps(&mut self) {
        let (inserted, grid) = (&self.motion.trajectory.inserted, &self.motion.inputs.grid);
        let Some(&first) = inserted.first() else { return };
        // Every part of a step begins or ends at an inserted node.
        let lengths = inserted.iter().map(|&node| grid.steps[node - 1].abs().min(grid.steps[node].abs()));
        let shortest = lengths.fold(f64::INFINITY, f64::min);
        let time = grid.time(first - 1);
        let step = self.motion.step_of_whole(first);
        self.monitor.report.warn(Warning::HalvedSteps { step, time, inserted: inserted.len(), shortest });
    }
}
