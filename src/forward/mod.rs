//! The forward sweep: consistent start, then one step after the other.

mod adapt;
mod continuation;
mod drift;
mod halving;
mod projection;
pub(crate) mod rank;
mod redundancy;
pub(crate) mod restart;
mod start;
mod surprise;
mod window;

pub(crate) use window::HISTORY;

use nalgebra::{DMatrix, DVector};

use crate::forward::continuation::Continuation;
use crate::forward::halving::Ahead;
use crate::forward::redundancy::Relaxed;
use crate::linear::Breakdown;
use crate::motion::{Report, column, column_mut};
use crate::node::Newton;
use crate::node::Predictor;
use crate::node::{StepFailure, Unknowns};
use crate::number::largest;
use crate::scheme::known_part;
use crate::system::NodeView;
use crate::system::{Given, KnownPart};
use crate::{Error, Grid, Inputs, Scheme, Settings, Start, System, Trajectory, Warning, memory};
use restart::{LastEnd, Point, Restarts};

/// What a compliance may take of the largest velocity; more says that constraints contradict each other.
const CONTRADICTION: f64 = 1e-6;

/// Numbers of an iterate from here on are no arguments of a mechanism: their cubes overflow.
const RAN_AWAY: f64 = 1e100;

/// A motion, with what the adjoint sweep needs of it.
pub(crate) struct Forward {
    /// On the grid that is taken; what is ahead stands behind a gap, while there is one.
    pub(crate) inputs: Inputs,
    pub(crate) ahead: Ahead,
    /// The node that column 0 of the trajectory holds.
    pub(crate) first: usize,
    pub(crate) trajectory: Trajectory,
    /// The second derivatives of all varying elements, one column a stage.
    pub(crate) blocks: DMatrix<f64>,
    pub(crate) restarts: Restarts,
    pub(crate) newton: Newton,
    pub(crate) report: Report,
    predictor: Predictor,
    /// The most that an angle turned in a step, if it is worth a warning.
    most_turn: f64,
    /// The first node that may be extrapolated from.
    pub(crate) smooth_from: usize,
    pub(crate) continuation: Continuation,
    /// Whether the step into a column is worth a look, if elements may bend within it.
    pub(crate) surprising: Vec<bool>,
    /// The stage at hand of a step, and the controls there if it lies between nodes.
    stage: usize,
    stage_u: Vec<f64>,
    /// q̄, p̄ and σ₋.
    start_q: Vec<f64>,
    start_p: Vec<f64>,
    start_sigma: Vec<f64>,
    /// Φ of a node, and what its entries are compared with.
    pub(crate) phi: Vec<f64>,
    pub(crate) lengths: Vec<f64>,
    /// The largest range of σ between two restarts, as estimated so far.
    pub(crate) most_range: f64,
    pub(crate) last_end: LastEnd,
    /// A point of a restart.
    pub(crate) restarting: Point,
    /// The dependent constraints of the last start that had any.
    pub(crate) relaxed: Option<Relaxed>,
}

/// The controls of a node, or those of the stage at hand if it is none, and the design variables.
fn stage_inputs<'a>(inputs: &'a Inputs, (node, is_node): (usize, bool), stage_u: &'a [f64]) -> (&'a [f64], &'a [f64]) {
    let (u, design) = inputs.at(node);
    (if is_node { u } else { stage_u }, design)
}

impl Forward {
    pub(crate) fn new(system: &System, scheme: Scheme) -> Self {
        let (n, m) = (system.n(), system.m());
        let empty = Inputs {
            grid: Grid::new(0.0, Vec::new()),
            start: Start::Velocity { q: DVector::zeros(0), v: DVector::zeros(0) },
            controls: DMatrix::zeros(0, 0),
            design: DVector::zeros(0),
        };
        Forward {
            inputs: empty,
            ahead: Ahead::new(),
            first: 0,
            trajectory: Trajectory::zeros(system, 0, scheme),
            blocks: DMatrix::zeros(0, 0),
            restarts: Restarts::default(),
            newton: Newton::new(system),
            report: Report::default(),
            predictor: Predictor::new(n, m),
            most_turn: Warning::TURN,
            smooth_from: 0,
            continuation: Continuation::new(n, m),
            surprising: Vec::new(),
            stage: scheme.stages(),
            stage_u: vec![0.0; system.k()],
            start_q: vec![0.0; n],
            start_p: vec![0.0; n],
            start_sigma: vec![0.0; m],
            phi: vec![0.0; m],
            lengths: vec![0.0; m],
            most_range: 0.0,
            last_end: LastEnd { node: 0, sigma: vec![0.0; m] },
            restarting: Point::new(n, m),
            relaxed: None,
        }
    }

    pub(crate) fn run(&mut self, system: &System, inputs: &Inputs, settings: &Settings) -> Result<(), Error> {
        self.begin(system, inputs, inputs.grid.nodes(), settings)?;
        self.advance(system, settings, usize::MAX).map(|_| ())
    }

    /// Copies the inputs, makes room for so many nodes and solves node 0; allocates only when the room is not that of the call before.
    pub(crate) fn begin(&mut self, system: &System, inputs: &Inputs, room: usize, settings: &Settings) -> Result<(), Error> {
        self.trajectory.computed = 0;
        settings.check()?;
        inputs.check(system)?;
        if self.trajectory.times.len() != room {
            // Inputs and gradient besides.
            let node = system.bytes_per_node(settings) + 2 * (1 + system.k()) * size_of::<f64>();
            memory::check("the motion", room, node)?;
            self.trajectory = Trajectory::zeros(system, room, settings.scheme);
            self.blocks = DMatrix::zeros(system.block_len(), room * settings.scheme.stages());
        }
        self.inputs.copy_from(inputs);
        self.report = Report::default();
        self.trajectory.inserted.clear();
        self.ahead.forget();
        self.most_turn = Warning::TURN;
        self.continuation.counted = 0;
        self.start_p.fill(0.0);
        self.start_sigma.fill(0.0);
        let (q, (u, design)) = (inputs.start.q().as_slice(), inputs.at(0));
        let start = NodeView::of_equations([q, &self.start_p, &self.start_sigma], (u, inputs.grid.start, design));
        self.newton.evaluation.set_start(system, &start)?;
        self.begin_again(system, settings)
    }

    /// Solves node 0 of the inputs at hand.
    pub(crate) fn begin_again(&mut self, system: &System, settings: &Settings) -> Result<(), Error> {
        (self.first, self.smooth_from, self.most_range) = (0, 0, 0.0);
        self.restarts.clear();
        self.ahead.again();
        self.trajectory.computed = 0;
        self.trajectory.restarted.clear();
        self.trajectory.compliance.clear();
        self.trajectory.times[0] = self.inputs.grid.start;
        self.newton.evaluation.set_compliance(&[]);
        start::solve(self, system, settings)?;
        restart::keep_end(self, 0);
        Ok(())
    }

    /// Computes the nodes before this one, as far as the grid goes; a step without a solution is halved. False if there is no memory for
    /// a node that had to be inserted.
    pub(crate) fn advance(&mut self, system: &System, settings: &Settings, end: usize) -> Result<bool, Error> {
        let was_known = self.ahead.is_known(self.nodes());
        let done = self.take_steps(system, settings, end);
        let next = self.first + self.trajectory.computed;
        self.know(next);
        if done.is_err() || next == self.nodes() {
            // Of a step that failed it is known how it was halved.
            self.close_gap(next - usize::from(done.is_ok()));
            if done.is_ok() && !was_known {
                self.warn_of_halved_steps();
            }
        }
        done
    }

    fn take_steps(&mut self, system: &System, settings: &Settings, end: usize) -> Result<bool, Error> {
        let mut node = self.first + self.trajectory.computed;
        while node < self.nodes().min(end) {
            self.take(node);
            while let Err(failure) = self.step(system, node, settings) {
                if !self.shorten(system, node, failure, settings)? {
                    return Ok(false);
                }
            }
            self.keep(node);
            self.check_compliant(system, node, settings)?;
            self.watch_turns(system, node);
            restart::apply(self, system, node, settings)?;
            self.watch_drift(system, node, settings);
            node += 1;
            self.trajectory.computed = node - self.first;
        }
        Ok(true)
    }

    /// Halves a step that failed, if that may help; false if there is no memory for another node.
    #[cold]
    fn shorten(&mut self, system: &System, node: usize, failure: StepFailure, settings: &Settings) -> Result<bool, Error> {
        if self.model_fault(system, node, &failure) || !self.may_halve(node, settings) {
            return Err(self.explain(system, node, failure));
        }
        let has_room = self.nodes() < self.ahead.most_nodes;
        if has_room {
            self.halve(node)
        } else {
            self.put_back(node)
        }
        Ok(has_room)
    }

    /// Solves all stages of the step into a node.
    pub(super) fn step(&mut self, system: &System, node: usize, settings: &Settings) -> Result<(), StepFailure> {
        for s in 0..self.trajectory.last_stage() {
            self.solve_stage(system, node, s + 1, settings)?;
        }
        Ok(())
    }

    fn solve_stage(&mut self, system: &System, node: usize, s: usize, settings: &Settings) -> Result<(), StepFailure> {
        let (dt, k) = (self.inputs.grid.steps[node - 1], node - self.first);
        self.begin_stage(k, s, dt);
        if !self.trajectory.compliance.is_empty() {
            self.start_sigma.copy_from_slice(column(&self.trajectory.sigma, k - 1));
        }
        // Of a step that is followed from zero, later stages know its beginning.
        let history = Predictor::MOST.min(k).min(node - self.smooth_from).max(1);
        if history == 1 && s == 1 && self.is_rough(system, k) {
            self.continue_from_zero(system, node, settings)?;
        } else {
            self.predictor.predict(&self.inputs.grid.steps[node - history..node], &mut self.trajectory, k, s);
            match self.solve_at_hand(system, node, dt, settings) {
                Ok(()) if !self.has_missed(system, k) => {}
                Err(failure) if self.model_fault(system, node, &failure) => return Err(failure),
                _ => self.continue_from_zero(system, node, settings)?,
            }
        }
        if system.may_bend() && self.trajectory.scheme.is_trapezoidal() {
            self.note_surprise(system, k, history);
        }
        Ok(())
    }

    /// h = Δt a_ss of the stage at hand.
    fn half_step(&self, dt: f64) -> f64 {
        dt * self.trajectory.scheme.a(self.stage, self.stage)
    }

    /// Makes stage s of a step of this length into column k the one at hand: its time, its controls and its known part.
    #[inline]
    pub(crate) fn begin_stage(&mut self, k: usize, s: usize, dt: f64) {
        let Forward { trajectory, inputs, .. } = self;
        let begin = trajectory.times[k - 1];
        trajectory.times[k] = begin + dt;
        self.stage = s;
        if s < trajectory.last_stage() {
            let c = trajectory.scheme.c(s);
            *trajectory.stage_mut(k, s).time = begin + c * dt;
            inputs.controls_within(self.first + k, c, &mut self.stage_u);
        }
        let scheme = &trajectory.scheme;
        let before = trajectory.columns(k - 1);
        known_part((scheme, s), dt, (before.q, before.v), |j| trajectory.rates(k, j).0, &mut self.start_q);
        known_part((scheme, s), dt, (before.p_star, before.p_star_dot), |j| trajectory.rates(k, j).1, &mut self.start_p);
    }

    /// Solves the stage at hand of a step of this length.
    pub(crate) fn solve_at_hand(
        &mut self,
        system: &System,
        node: usize,
        dt: f64,
        settings: &Settings,
    ) -> Result<(), StepFailure> {
        let h = self.half_step(dt);
        self.solve(system, node, h, settings)
    }

    /// Solves for (v, σ) of a node, with q = start_q + h v.
    pub(crate) fn solve_node(
        &mut self,
        system: &System,
        node: usize,
        h: f64,
        settings: &Settings,
    ) -> Result<(), StepFailure> {
        self.stage = self.trajectory.last_stage();
        self.solve(system, node, h, settings)
    }

    /// Solves the node problem of the stage at hand from the values in its columns.
    fn solve(&mut self, system: &System, node: usize, h: f64, settings: &Settings) -> Result<(), StepFailure> {
        let (k, s) = (node - self.first, self.stage);
        let from = KnownPart { h, q: &self.start_q, p_star: &self.start_p, sigma: &self.start_sigma };
        let (u, design) = stage_inputs(&self.inputs, (node, s == self.trajectory.last_stage()), &self.stage_u);
        let columns = self.trajectory.stage_mut(k, s);
        let given = Given { u, t: *columns.time, design };
        let mut unknowns = Unknowns { q: columns.q, v: columns.v, sigma: columns.sigma, p_star_dot: columns.p_star_dot };
        let worst = self.report.worst_pivot;
        self.newton.solve_step(system, &from, given, &mut unknowns, settings, &mut self.report)?;
        for ((p_star, start), rate) in columns.p_star.iter_mut().zip(&self.start_p).zip(unknowns.p_star_dot.iter()) {
            *p_star = start + h * rate;
        }
        self.warn_of_lost_digits(system, node, worst);
        let at = self.block_column(k, s);
        column_mut(&mut self.blocks, at).copy_from_slice(&self.newton.evaluation.blocks);
        Ok(())
    }

    /// The column of the second derivatives of a stage.
    #[inline]
    pub(crate) fn block_column(&self, k: usize, s: usize) -> usize {
        k * self.trajectory.last_stage() + s - 1
    }

    /// The second derivatives of a stage of the step into a node.
    #[inline]
    pub(crate) fn stage_blocks(&self, node: usize, s: usize) -> &[f64] {
        column(&self.blocks, self.block_column(node - self.first, s))
    }

    /// The second derivatives of a node.
    pub(crate) fn node_blocks(&self, node: usize) -> &[f64] {
        self.stage_blocks(node, self.trajectory.last_stage())
    }

    /// Keeps the worst of all warnings of this kind; compliances lose digits on purpose, of what moves nothing.
    pub(crate) fn warn_of_lost_digits(&mut self, system: &System, node: usize, worst_before: f64) {
        let is_new = self.report.worst_pivot < worst_before.min(Warning::LOST_DIGITS);
        if !is_new || !self.trajectory.compliance.is_empty() {
            return;
        }
        let unknown = system.unknown_name(self.newton.worst_unknown(system));
        let (step, time) = (self.given_step(node), self.trajectory.times[node - self.first]);
        self.report.replace(Warning::LostDigits { step, time, unknown, pivot: self.report.worst_pivot });
    }

    /// Keeps the warning of the angle that turns most in one step, if it turns too far.
    fn watch_turns(&mut self, system: &System, node: usize) {
        let k = node - self.first;
        let (before, now) = (column(&self.trajectory.q, k - 1), column(&self.trajectory.q, k));
        let turn = |i: usize| (now[i] - before[i]).abs();
        let Some(i) = system.sines().coordinates().find(|&i| turn(i) > self.most_turn) else { return };
        let worst = system.sines().coordinates().fold(i, |worst, i| if turn(i) > turn(worst) { i } else { worst });
        self.most_turn = turn(worst);
        let coordinate = system.coordinate_name(worst).to_string();
        let (step, time) = (self.given_step(node), self.trajectory.times[k]);
        self.report.replace(Warning::Unresolved { coordinate, step, time, turn: self.most_turn });
    }

    /// What equations and costs of a node depend on.
    pub(crate) fn at(&self, node: usize) -> NodeView<'_, f64> {
        self.trajectory.columns(node - self.first).with_inputs(self.inputs.at(node))
    }

    pub(crate) fn set_start(&mut self, q: &[f64], p_star: &[f64], sigma: &[f64]) {
        self.start_q.copy_from_slice(q);
        self.start_p.copy_from_slice(p_star);
        self.start_sigma.copy_from_slice(sigma);
    }

    /// Factors K(0) at the given state, before anything is solved with it.
    pub(crate) fn factor_start(&mut self, system: &System) -> Result<(), Breakdown> {
        let from = KnownPart { h: 0.0, q: &self.start_q, p_star: &self.start_p, sigma: &self.start_sigma };
        let (u, design) = self.inputs.at(0);
        let given = Given { u, t: self.trajectory.times[0], design };
        let (v, sigma) = (column(&self.trajectory.v, 0), column(&self.trajectory.sigma, 0));
        self.newton.factor_at(system, &from, given, (v, sigma), &mut self.report)
    }

    /// Dependent constraints that cannot be satisfied together pull their compliances apart.
    pub(crate) fn check_compliant(&self, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
        if self.trajectory.compliance.is_empty() {
            return Ok(());
        }
        let at = self.at(node);
        let tolerance = settings.velocity_tolerance + CONTRADICTION * largest(at.v);
        let gap = |&(j, mu): &(usize, f64)| (j, (mu * (at.sigma[j] - self.start_sigma[j])).abs());
        let gaps = || self.trajectory.compliance.iter().map(gap).filter(|(_, gap)| *gap > tolerance);
        if gaps().next().is_none() {
            return Ok(());
        }
        let violation = gaps().fold(0.0f64, |largest, (_, gap)| largest.max(gap));
        let equations = rank::dependent(system, &at)
            .unwrap_or_else(|| gaps().map(|(j, _)| system.equation_name(j).to_string()).collect());
        Err(Error::ContradictoryConstraints { equations, violation, time: at.t })
    }

    /// Whether a formula is to blame, which a shorter step would not change.
    fn model_fault(&self, system: &System, node: usize, failure: &StepFailure) -> bool {
        let overflows = match failure {
            StepFailure::NotFinite => true,
            StepFailure::Singular(breakdown) => !breakdown.pivot.is_finite(),
            _ => false,
        };
        overflows && self.find_not_finite(system, node, 0.0).is_some()
    }

    pub(crate) fn explain(&self, system: &System, node: usize, failure: StepFailure) -> Error {
        let time = self.trajectory.times[node - self.first];
        let step = self.given_step(node);
        let length = node.checked_sub(1).map_or(0.0, |before| self.inputs.grid.steps[before]);
        match failure {
            StepFailure::Singular(breakdown) if !breakdown.pivot.is_finite() => self.not_finite(system, node),
            StepFailure::NotFinite => self.not_finite(system, node),
            StepFailure::Singular(breakdown) => {
                self.near_singular(system, node).unwrap_or_else(|| system.singular_step(&breakdown, step, time))
            }
            StepFailure::Diverged { iterations, residual, unknown } => {
                self.near_singular(system, node).unwrap_or_else(|| {
                    let equation = system.residual_name(unknown);
                    Error::Newton { step, time, iterations, length, residual, equation }
                })
            }
            StepFailure::LinearEnergy { coordinate, momentum } => {
                Error::LinearEnergy { coordinate: system.coordinate_name(coordinate).into(), momentum, step, time }
            }
            StepFailure::Projection { iterations, correction } => {
                self.near_singular(system, node).unwrap_or(Error::Projection { step, time, iterations, correction })
            }
        }
    }

    /// Whether the constraints lose rank where the last good node stood.
    fn near_singular(&self, system: &System, node: usize) -> Option<Error> {
        let at = self.at(node.checked_sub(1)?);
        rank::near_singular(system, &at, self.given_step(node), at.t)
    }

    /// v₀ as given, or zero.
    fn given_velocity(&self) -> Vec<f64> {
        match &self.inputs.start {
            Start::Velocity { v, .. } => v.as_slice().to_vec(),
            Start::Momentum { p_star, .. } => vec![0.0; p_star.len()],
        }
    }

    /// The element that gives no number where the last good node stood, or where its velocities lead within so many seconds.
    fn find_not_finite(&self, system: &System, node: usize, ahead: f64) -> Option<Error> {
        let last = self.at(node.saturating_sub(1));
        let u = column(&self.inputs.controls, node);
        if node == 0 {
            // What the iteration left of v₀ and σ₀ may be no numbers.
            let (v, sigma) = (self.given_velocity(), vec![0.0; last.sigma.len()]);
            return system.find_not_finite(&NodeView { q: &self.start_q, v: &v, sigma: &sigma, u, ..last }, 0);
        }
        let q: Vec<f64> = last.q.iter().zip(last.v).map(|(q, v)| q + ahead * v).collect();
        let at = NodeView { q: &q, u, t: self.trajectory.times[node - self.first], ..last };
        system.find_not_finite(&at, self.given_step(node))
    }

    /// The same where the iteration broke off.
    fn find_not_finite_iterate(&self, system: &System, node: usize) -> Option<Error> {
        let x = self.newton.iterate(system);
        let h = node.checked_sub(1).map_or(0.0, |before| self.half_step(self.inputs.grid.steps[before]));
        let q: Vec<f64> = self.start_q.iter().zip(&x.v).map(|(q, v)| q + h * v).collect();
        // An iteration that ran away says nothing of a formula.
        let is_point = [&q, &x.v, &x.sigma].into_iter().flatten().all(|x| x.abs() < RAN_AWAY);
        let (u, design) = stage_inputs(&self.inputs, (node, self.stage == self.trajectory.last_stage()), &self.stage_u);
        let at = NodeView::of_equations(
            [&q, &x.v, &x.sigma],
            (u, self.trajectory.stage(node - self.first, self.stage).t, design),
        );
        is_point.then(|| system.find_not_finite(&at, self.given_step(node))).flatten()
    }

    /// Which element is to blame for a value that is not finite.
    fn not_finite(&self, system: &System, node: usize) -> Error {
        let time = self.trajectory.times[node - self.first];
        let step = self.given_step(node);
        let length = node.checked_sub(1).map_or(0.0, |before| self.inputs.grid.steps[before]);
        // Node 0 has no step, and nothing ahead.
        let ahead = [0.0, self.given_length(node)];
        let found = ahead.into_iter().find_map(|ahead| self.find_not_finite(system, node, ahead));
        found.or_else(|| self.find_not_finite_iterate(system, node)).unwrap_or_else(|| Error::Newton {
            step,
            time,
            iterations: self.report.most_iterations,
            length,
            residual: f64::INFINITY,
            equation: "all equations (the iteration overflowed)".into(),
        })
    }
}
