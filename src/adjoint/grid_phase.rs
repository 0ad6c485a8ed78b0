//! The gradient at frozen grid phase.
//!
//! Between two nodes, an element may have a kink: a gap opens or closes, or friction reverses. The discrete motion depends on the distance of the kink
//! from the nodes, the phase of the grid, and so does J: it zigzags. The derivative along a zigzag is exact but useless, however fine the grid.
//!
//! Let g_k be the function whose zero is the kink, and n_k the node after it. The derivative of the family of grids whose nodes n_k move such that
//! g_k keeps its value there is the derivative of J without the zigzag. The nodes between n_{k−1} and n_k move in proportion; the first and the
//! last node, and those at which a cost is read ([`Sum::Node`](crate::Sum::Node)), stay. With τ_k the time of n_k, and with controls as functions of
//! time,
//!
//! ```text
//!   J + Σ μ_k g_k     with    d(J + Σ_{j ≥ k} μ_j g_j)/dτ_k = 0
//! ```
//!
//! has this derivative. Since g_k depends on τ_1 … τ_k alone, the μ_k follow one by one in a backward sweep with two right-hand sides: that of the sum,
//! and that of the current g_k.

use std::ops::Range;

use super::AdjointSweep;
use super::grid_phase_warning::worst;
use crate::adjoint::Gradient;
use crate::motion::{Motion, Refinement, Report, Watch, column};
use crate::node::{Evaluation, Linearisation, SolvedMotion};
use crate::number::{add, dot};
use crate::system::{CostFactors, CostRows, Kinks, NodeView};
use crate::{Error, Settings, System, Warning};

/// A smooth kink is resolved if its function changes by less than this within a step.
const RESOLVED: f64 = 1.0;
/// Changes of a function below this fraction of its largest value are rounding.
const ROUNDING: f64 = 1e-9;
/// A kink is grazed if its function changes by less than this fraction of its change within the step when the step becomes longer.
const GRAZED: f64 = 0.05;

/// The kinks of a motion, and the progress of the sweeps that follow them: that of J, that at frozen grid phase, and that of a kink.
#[derive(Default)]
pub(crate) struct GridPhase {
    kinks: Kinks,
    /// The fingerprint of the elements and the parameters of `kinks`.
    of: Option<(u64, Vec<f64>)>,
    /// The functions of all kinks at two nodes, and their largest absolute values.
    values: [Vec<f64>; 2],
    largest: Vec<f64>,
    /// The nodes of the computed grid that are given nodes, and their times.
    nodes: Vec<usize>,
    times: Vec<f64>,
    /// Given nodes that follow a kink, then also those that do not move.
    stops: Vec<Stop>,
    /// The number of stops that lie before the sweep, of sweeps that are running, and the one whose kink is followed.
    ahead: usize,
    running: usize,
    followed: Option<usize>,
    /// The largest effect of a kink.
    worst: (f64, Option<Stop>),
}

/// A given node that follows a kink, or that does not move.
#[derive(Clone, Copy, Debug)]
struct Stop {
    given: usize,
    kink: Option<Crossing>,
}

/// A kink between a node and the previous one.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    kink: usize,
    /// The change of its function.
    change: f64,
}

impl GridPhase {
    /// The number of sweeps that are needed for a scene.
    pub(crate) fn sweeps(system: &System) -> usize {
        if system.has_kinks() { 3 } else { 1 }
    }

    /// The gradient of a weighted sum of J and the outputs in the first sweep, with the one at frozen grid phase if kinks lie between nodes.
    pub(crate) fn run(
        &mut self,
        sweeps: &mut Vec<AdjointSweep>,
        system: &System,
        solved: &mut SolvedMotion,
        settings: &Settings,
        choose: impl Fn(&mut CostFactors),
    ) -> Result<(), Error> {
        let SolvedMotion { motion, linearisation, report, watch } = solved;
        motion.trajectory.check_complete(&motion.inputs)?;
        self.examine_all(system, &linearisation.evaluation, motion);
        self.begin_back(sweeps, system, motion, settings, choose)?;
        self.back(sweeps, system, motion, linearisation, (0..motion.nodes(), watch))?;
        self.finish(sweeps, system, motion, report)
    }

    /// Examines all nodes of a motion.
    pub(crate) fn examine_all(&mut self, system: &System, evaluation: &Evaluation, motion: &Motion) {
        self.begin(system, evaluation, motion);
        if !self.kinks.all().is_empty() {
            let refinement = motion.refinement();
            (0..motion.nodes()).for_each(|node| self.examine(motion, &refinement, node));
        }
    }

    /// The first kink of an examined motion with located events that none of them locates.
    pub(crate) fn unlocated(&self, system: &System, motion: &Motion) -> Option<Warning> {
        // By rounding, a kink at the node of an event lies before it or behind it.
        let is_at = |given: usize| motion.inputs.events.iter().any(|event| self.times[event.node] == self.times[given]);
        let is_located = |given: usize| is_at(given) || is_at(given - motion.inputs.grid.stages);
        let is_real = |kink: &Crossing| kink.change.abs() > ROUNDING * self.largest[kink.kink];
        let mut kinks = self.stops.iter().filter_map(|stop| Some((stop.given, stop.kink.filter(is_real)?)));
        let (given, crossing) = kinks.find(|(given, _)| !is_located(*given))?;
        let element = self.kinks.element(system, crossing.kink).to_string();
        let (step, time) = (motion.refinement().step_of_whole(self.nodes[given]), self.times[given]);
        Some(Warning::KinkBetweenNodes { element, step, time })
    }

    /// Begins a motion.
    pub(crate) fn begin(&mut self, system: &System, evaluation: &Evaluation, motion: &Motion) {
        let (design, given) = (&motion.design, motion.nodes() - motion.trajectory.inserted.len());
        self.stops.clear();
        self.nodes.clear();
        self.times.clear();
        if !system.has_kinks() {
            return;
        }
        let fingerprint = evaluation.fingerprint();
        if self.of.as_ref().is_none_or(|(of, values)| Some(*of) != fingerprint || values != design) {
            self.kinks = Kinks::new(system, &evaluation.formulas(system).elements, design);
            self.of = fingerprint.map(|fingerprint| (fingerprint, design.clone()));
        }
        let count = self.kinks.all().len();
        self.values.iter_mut().chain([&mut self.largest]).for_each(|list| list.resize(count, 0.0));
        self.largest.fill(0.0);
        if count > 0 {
            self.nodes.reserve_exact(given);
            self.times.reserve_exact(given);
        }
    }

    /// Looks for kinks between a node and the one examined before it.
    #[inline]
    pub(crate) fn examine(&mut self, motion: &Motion, refinement: &Refinement, node: usize) {
        if !self.kinks.all().is_empty()
            && let Some(given) = refinement.given_node(node)
        {
            self.examine_given(motion, (node, given));
        }
    }

    fn examine_given(&mut self, motion: &Motion, (node, given): (usize, usize)) {
        let at = motion.at(node);
        self.nodes.push(node);
        self.times.push(at.t);
        // Inside a macro step, nodes lie in any order.
        if motion.inputs.grid.macro_steps(given).is_some() {
            let kink = self.crossing(&at, given > 0 && motion.length(node) != 0.0);
            self.stops.extend(kink.map(|kink| Stop { given, kink: Some(kink) }));
        }
    }

    /// The kink between a node and the previous one that was examined; kinks that are not rounded precede others.
    fn crossing(&mut self, at: &NodeView<f64>, has_previous: bool) -> Option<Crossing> {
        self.values.swap(0, 1);
        self.kinks.evaluate(at, &mut self.values[1]);
        let (mut found, [before, here]) = (None::<Crossing>, &self.values);
        for (kink, (&x, &y)) in before.iter().zip(here).enumerate() {
            self.largest[kink] = self.largest[kink].max(y.abs());
            let (is_smooth, change) = (self.kinks.all()[kink].is_smooth, y - x);
            let counts = has_previous && x * y < 0.0 && (!is_smooth || change.abs() > RESOLVED);
            if counts && found.is_none_or(|other| self.kinks.all()[other.kink].is_smooth && !is_smooth) {
                found = Some(Crossing { kink, change });
            }
        }
        found
    }

    /// Begins the sweeps backward through a motion whose nodes have all been examined.
    pub(crate) fn begin_back(
        &mut self,
        sweeps: &mut Vec<AdjointSweep>,
        system: &System,
        motion: &Motion,
        settings: &Settings,
        choose: impl Fn(&mut CostFactors),
    ) -> Result<(), Error> {
        // The memory of the previous gradient is used again.
        let old = sweeps[0].gradient.frozen.take();
        old.into_iter().zip(sweeps.get_mut(1)).for_each(|(old, frozen)| frozen.gradient = *old);
        sweeps[0].begin(system, motion, settings)?;
        choose(&mut sweeps[0].cost.factors);
        self.arrange(system, motion, &sweeps[0]);
        (self.ahead, self.running, self.followed, self.worst) = (self.stops.len(), 1, None, (0.0, None));
        if self.stops.is_empty() {
            return Ok(());
        }
        sweeps.resize_with(3, || AdjointSweep::new(system, settings.scheme));
        let settings = Settings { keep_adjoint: false, ..*settings };
        for sweep in &mut sweeps[1..] {
            sweep.begin(system, motion, &settings)?;
        }
        choose(&mut sweeps[1].cost.factors);
        sweeps[2].cost.factors.weigh(0.0, &vec![0.0; system.outputs()]);
        Ok(())
    }

    /// Leaves out kinks by rounding, and adds the nodes that stay unless there are no kinks.
    fn arrange(&mut self, system: &System, motion: &Motion, sweep: &AdjointSweep) {
        let Some(last) = self.nodes.len().checked_sub(1) else { return };
        let (factors, refinement, largest) = (&sweep.cost.factors, &sweep.refinement, &self.largest);
        let is_real = |kink: Crossing| kink.change.abs() > ROUNDING * largest[kink.kink];
        let is_read = |given: usize| system.has_reading(refinement.node_of_whole(self.nodes[given]), factors);
        // Where a control jumps, it is a function of time only if the node stays.
        let jumps = |node: usize| [node - 1, node].into_iter().any(|step| motion.inputs.grid.steps[step] == 0.0);
        let stays = |given: usize| given == 0 || given == last || is_read(given) || jumps(self.nodes[given]);
        let moves = |stop: &Stop| !stays(stop.given) && stop.kink.is_none_or(is_real);
        self.stops.retain(moves);
        if !self.stops.is_empty() {
            let staying = (0..=last).filter(|&given| stays(given));
            self.stops.extend(staying.map(|given| Stop { given, kink: None }));
            self.stops.sort_unstable_by_key(|stop| stop.given);
        }
    }

    /// Sweeps backward through these nodes.
    pub(crate) fn back(
        &mut self,
        sweeps: &mut [AdjointSweep],
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (nodes, watch): (Range<usize>, &mut Watch),
    ) -> Result<(), Error> {
        let mut to = nodes.end;
        while let Some(k) = self.ahead.checked_sub(1) {
            let node = self.nodes[self.stops[k].given];
            if node < nodes.start {
                break;
            }
            AdjointSweep::back(&mut sweeps[..self.running], system, motion, linearisation, (node + 1..to, watch))?;
            if let Some(followed) = self.followed.take() {
                self.end_phase(sweeps, system, motion, followed)?;
            }
            if self.stops[k].kink.is_some() {
                self.begin_phase(sweeps, system, motion, k);
            }
            (self.ahead, to) = (k, node + 1);
        }
        AdjointSweep::back(&mut sweeps[..self.running], system, motion, linearisation, (nodes.start..to, watch))
    }

    /// Begins to follow the kink of a stop, before its node is visited.
    fn begin_phase(&mut self, sweeps: &mut [AdjointSweep], system: &System, motion: &Motion, k: usize) {
        let ([plain, frozen, of_kink], Stop { given, kink: Some(Crossing { kink, .. }) }) = (sweeps, self.stops[k]) else {
            return;
        };
        if self.running == 1 {
            frozen.follow(plain);
        }
        let node = self.nodes[given];
        self.kinks.add_slopes(kink, &motion.at(node), of_kink.restart(system, node));
        (self.running, self.followed) = (3, Some(k));
    }

    /// Determines μ for the kink of a stop, before the node of the previous stop is visited.
    fn end_phase(&mut self, sweeps: &mut [AdjointSweep], system: &System, motion: &Motion, k: usize) -> Result<(), Error> {
        let ([_, frozen, of_kink], Stop { given, kink: Some(crossing) }) = (sweeps, self.stops[k]) else { return Ok(()) };
        let around = [k - 1, k, k + 1].map(|k| self.stops[k].given);
        // The weights of the costs of node n_{k−1} depend on the length of the step after it.
        frozen.cost_rows(system, motion, self.nodes[around[0]])?;
        frozen.costs_known = Some(self.nodes[around[0]]);
        let [of_sum, own] = [&*frozen, of_kink].map(|sweep| self.by_time(motion, sweep, around));
        // On a composed grid the node examined before is the end of the macro step before.
        let rate = crossing.change / (self.times[given] - self.times[given - motion.inputs.grid.stages]);
        if own.abs() > GRAZED * rate.abs() {
            let effect = frozen.add_multiple(-of_sum / own, of_kink);
            if effect > self.worst.0 {
                self.worst = (effect, Some(self.stops[k]));
            }
        }
        self.running = 2;
        Ok(())
    }

    /// Completes the gradient after all nodes have been visited.
    pub(crate) fn finish(
        &mut self,
        sweeps: &mut [AdjointSweep],
        system: &System,
        motion: &Motion,
        forward: &Report,
    ) -> Result<(), Error> {
        sweeps[0].is_recorded = sweeps[0].record.is_some();
        let is_plain = self.stops.is_empty();
        if let (false, [plain, frozen, ..]) = (is_plain, &mut *sweeps) {
            frozen.gradient.check_finite(system, frozen.refinement.node_of_whole(0))?;
            self.warn(system, motion, (plain, frozen));
            plain.gradient.frozen = Some(Box::new(std::mem::replace(&mut frozen.gradient, Gradient::empty(system))));
        }
        sweeps[0].finish(system, forward)
    }

    /// Warns if the gradients differ much; names the kink with the largest effect.
    fn warn(&self, system: &System, motion: &Motion, (plain, frozen): (&mut AdjointSweep, &AdjointSweep)) {
        let Some((of, value, frozen)) = worst(system, motion, &plain.gradient, &frozen.gradient) else { return };
        let Some(Stop { given, kink: Some(crossing) }) = self.worst.1 else { return };
        let element = self.kinks.element(system, crossing.kink).to_string();
        let (step, time) = (plain.refinement.step_of_whole(self.nodes[given]), self.times[given]);
        plain.report.warn(Warning::GridPhase { element, step, time, of, value, frozen });
    }

    /// The derivative by the time of a stop if the given nodes between its neighbours move in proportion.
    fn by_time(&self, motion: &Motion, sweep: &AdjointSweep, [before, stop, after]: [usize; 3]) -> f64 {
        self.of_phase(motion, sweep, before..stop, before) - self.of_phase(motion, sweep, stop..after, after)
    }

    /// The derivative by the length of a phase, whose given nodes move in proportion to their distance from the end that stays.
    fn of_phase(&self, motion: &Motion, sweep: &AdjointSweep, steps: Range<usize>, stays: usize) -> f64 {
        let (times, gradient) = (&self.times, &sweep.gradient);
        let length = times[steps.end] - times[steps.start];
        let share = |given: usize| (times[given] - times[stays]) / length;
        let of_steps: f64 = steps.clone().map(|k| gradient.steps[k] * (times[k + 1] - times[k]) / length).sum();
        // The node that both phases share belongs to the first one.
        let moved = if stays == steps.start { steps.start + 1..steps.end + 1 } else { steps.start + 1..steps.end };
        let of_controls =
            moved.map(|given| share(given) * self.by_moving_controls(motion, given, column(&gradient.controls, given)));
        of_steps + of_controls.sum::<f64>()
    }

    /// The derivative by the time of a given node of the controls there, as functions of time.
    fn by_moving_controls(&self, motion: &Motion, given: usize, slopes: &[f64]) -> f64 {
        let (first, last) = (given.saturating_sub(1), (given + 1).min(self.nodes.len() - 1));
        let [from, to] = [first, last].map(|given| motion.inputs.controls_at(self.nodes[given]));
        (dot(slopes, to) - dot(slopes, from)) / (self.times[last] - self.times[first])
    }
}

/// The right-hand sides.
impl AdjointSweep {
    /// Continues another sweep of the same motion from its last visited node.
    fn follow(&mut self, other: &AdjointSweep) {
        let (own, of) = (&mut self.gradient, &other.gradient);
        own.value = of.value;
        own.controls.copy_from(&of.controls);
        own.steps.copy_from_slice(&of.steps);
        self.design.copy_from_slice(&other.design);
        (self.time, self.is_idle, self.earlier.node) = (other.time, other.is_idle, other.earlier.node);
        self.earlier.rows.copy_from_slice(&other.earlier.rows);
        self.carried.copy_from(&other.carried);
    }

    /// Forgets all later nodes, and returns the derivatives, which are zero, of a function of the state at a node.
    fn restart(&mut self, system: &System, node: usize) -> &mut CostRows {
        self.gradient.controls.fill(0.0);
        self.gradient.steps.fill(0.0);
        self.design.fill(0.0);
        (self.time, self.is_idle, self.earlier.node) = (0.0, true, None);
        self.earlier.rows.fill(0.0);
        self.carried.clear();
        let sizes = (system.n(), system.m(), system.k());
        let rows = || (node, Box::new(CostRows::new(sizes, system.parameters().len(), system.outputs())));
        let (at, rows) = self.source.get_or_insert_with(rows);
        *at = node;
        rows.clear();
        rows
    }

    /// Adds the derivatives of a function of the state at a node, if this is the node.
    #[inline]
    pub(super) fn take_source(&mut self, node: usize) {
        if self.source.as_ref().is_some_and(|(at, _)| *at == node) {
            self.add_source_rows();
        }
    }

    #[cold]
    fn add_source_rows(&mut self) {
        let Some(source) = self.source.take() else { return };
        let (rows, sums) = (&source.1, &mut self.cost);
        let pairs = [(&mut sums.q, &rows.q), (&mut sums.v, &rows.v), (&mut sums.sigma, &rows.sigma)];
        pairs.into_iter().for_each(|(sum, rows)| add(sum, rows));
        self.add_inputs_of(rows);
        self.cost_is_zero = false;
        self.source = Some(source);
    }

    /// Adds a multiple of another sweep of the same motion; returns the size of what it adds.
    fn add_multiple(&mut self, factor: f64, other: &AdjointSweep) -> f64 {
        let mut size = 0.0;
        let mut add = |sum: &mut [f64], x: &[f64]| {
            sum.iter_mut().zip(x).for_each(|(sum, x)| {
                *sum += factor * x;
                size += (factor * x).powi(2);
            });
        };
        let (own, of) = (&mut self.gradient, &other.gradient);
        add(own.controls.as_mut_slice(), of.controls.as_slice());
        add(&mut self.design, &other.design);
        add(&mut own.steps, &of.steps);
        add(&mut self.earlier.rows, &other.earlier.rows);
        self.carried.add_multiple(factor, &other.carried);
        self.time += factor * other.time;
        self.is_idle &= other.is_idle;
        self.earlier.node = self.earlier.node.or(other.earlier.node);
        size.sqrt()
    }
}
