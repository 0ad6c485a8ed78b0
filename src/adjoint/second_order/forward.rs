//! The derivatives of the motion along a direction: one linear system with K(h) for each stage.

use super::SecondOrderSweep;
use super::kept::Place;
use crate::motion::{Motion, StepEnd, column};
use crate::node::Linearisation;
use crate::number::largest;
use crate::scheme::known_part;
use crate::system::{NodeView, Pair};
use crate::{Error, Start, System};

/// The state at the end of stage s of the step into a node, with the second derivatives there.
pub(super) struct StageEnd<'a> {
    node: usize,
    s: usize,
    pub(super) at: NodeView<'a, f64>,
    pub(super) blocks: &'a [f64],
    is_before_event: bool,
}

impl SecondOrderSweep {
    /// Computes the derivatives from a node on, before which nothing changes.
    pub(super) fn forward(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        from: usize,
    ) -> Result<(), Error> {
        let (scheme, last) = (motion.trajectory.scheme, motion.trajectory.last_stage());
        self.unused_events.append(&mut self.events);
        self.unused_events.extend(self.ended.take());
        self.change.inputs.grid.write_times(&mut self.change.trajectory.times);
        self.sigma_before.fill(0.0);
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(0));
        if let Some(before) = from.checked_sub(1) {
            self.change.trajectory.stage_mut(before, last).clear();
        } else {
            self.begin_motion(system, motion, linearisation);
            self.solve(system, motion, linearisation, &stage_end(motion, (0, last), None), 0.0)?;
        }
        for node in from.max(1)..motion.nodes() {
            let happened = motion.events.at(node);
            let ended = happened.map(|happened| happened.end);
            for s in 1..=last {
                self.known_part(motion, (node, s), ended);
                let end = stage_end(motion, (node, s), ended);
                self.solve(system, motion, linearisation, &end, motion.length(node) * scheme.a(s, s))?;
            }
            if let Some(happened) = happened {
                let singular = |breakdown| system.singular_step(&breakdown, motion.step_of_whole(node), motion.time(node));
                self.pass(system, motion, linearisation, happened).map_err(singular)?;
                self.solve(system, motion, linearisation, &stage_end(motion, (node, last), None), 0.0)?;
            }
        }
        Ok(())
    }

    /// Computes q̇₀ and ṗ*₀, which may follow from v̇₀: p*₀ = T_v(q₀, v₀; b).
    fn begin_motion(&mut self, system: &System, motion: &Motion, linearisation: &Linearisation) {
        self.known_q.copy_from_slice(self.change.inputs.start.q().as_slice());
        if let Start::Momentum { p_star, .. } = &self.change.inputs.start {
            self.known_p.copy_from_slice(p_star.as_slice());
            return;
        }
        let ((at, blocks), along) =
            (motion.given_start(), along_start(&self.change, (&self.zeros.sigma, &self.no_controls)));
        self.programs.changes((system, &linearisation.evaluation), (&at, blocks), &along, &mut self.sums);
        self.known_p.copy_from_slice(self.sums.l_v());
    }

    /// Computes q̄˙ + ḣ v and p̄˙ + ḣ g of a stage, and the change of its time.
    fn known_part(&mut self, motion: &Motion, (node, s): (usize, usize), ended: Option<StepEnd>) {
        let (trajectory, inputs) = (&mut self.change.trajectory, &self.change.inputs);
        let (scheme, dt, dt_dot) = (motion.trajectory.scheme, motion.length(node), inputs.grid.steps[node - 1]);
        if s < scheme.stages() {
            trajectory.place_stage(node, s, dt_dot, inputs.at_ends(node));
        }
        self.sigma_before.copy_from_slice(column(&trajectory.sigma, node - 1));
        let before = trajectory.columns(node - 1);
        known_part((&scheme, s), dt, (before.q, before.v), |j| trajectory.rates(node, j).0, &mut self.known_q);
        let p_star = (before.p_star, before.p_star_dot);
        known_part((&scheme, s), dt, p_star, |j| trajectory.rates(node, j).1, &mut self.known_p);
        if dt_dot == 0.0 {
            return;
        }
        for j in 0..=s {
            let rates = ended.filter(|_| j == scheme.stages()).map(|end| (end.v, end.p_star_dot));
            let (factor, (v, g)) = (dt_dot * scheme.a(s, j), rates.unwrap_or_else(|| motion.trajectory.rates(node, j)));
            self.known_q.iter_mut().zip(v).for_each(|(sum, v)| *sum += factor * v);
            self.known_p.iter_mut().zip(g).for_each(|(sum, g)| *sum += factor * g);
        }
    }

    /// Computes v̇ and σ̇ of a stage, and the derivatives that follow from them.
    fn solve(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        &StageEnd { node, s, at, blocks, is_before_event }: &StageEnd,
        h: f64,
    ) -> Result<(), Error> {
        let NodeView { u, t, design, .. } = self.change.at_stage(node, s);
        let along = NodeView::of_equations([&self.known_q, &self.zeros.v, &self.zeros.sigma], (u, t, design));
        self.programs.changes((system, &linearisation.evaluation), (&at, blocks), &along, &mut self.sums);
        let (l_v, force) = (self.sums.l_v(), self.sums.force());
        for (i, right) in self.right.v.iter_mut().enumerate() {
            *right = self.known_p[i] - l_v[i] + h * force[i];
        }
        self.right.sigma.iter_mut().zip(self.sums.phi_dot()).for_each(|(right, phi_dot)| *right = -phi_dot);
        let compliance = linearisation.evaluation.compliance().iter();
        compliance.for_each(|&(j, mu)| self.right.sigma[j] -= mu * self.sigma_before[j]);
        let place = Place { column: motion.block_column(node, s), is_end: is_before_event };
        let factored = match self.kept.lend(system, linearisation, (place, h)) {
            Ok(false) => linearisation.factor(system, h, blocks, &mut self.report),
            known => known.map(|_| linearisation.worst_pivot()),
        };
        let singular = |breakdown| system.singular_step(&breakdown, motion.step_of_whole(node), at.t);
        let pivot = factored.map_err(singular)?;
        self.x.v.copy_from_slice(&self.right.v);
        self.x.sigma.copy_from_slice(&self.right.sigma);
        linearisation.solve(system, &mut self.x);
        if self.accuracy.is_in_doubt(pivot) {
            self.refine(system, linearisation, (h, blocks), pivot);
        }
        self.kept.take_back(linearisation, place);
        let SecondOrderSweep { x, x_q, no_controls, of_state, .. } = self;
        let along = along_solution((x, h), x_q, no_controls);
        linearisation.evaluation.push_forward_to_force(system, blocks, &along, of_state);
        self.store((node, s), h);
        Ok(())
    }

    /// One step of iterative refinement.
    #[cold]
    fn refine(&mut self, system: &System, linearisation: &mut Linearisation, (h, blocks): (f64, &[f64]), pivot: f64) {
        let SecondOrderSweep { x, x_q, no_controls, of_state, .. } = self;
        linearisation.evaluation.push_forward(system, blocks, &along_solution((x, h), x_q, no_controls), of_state);
        let (l_v, force) = (of_state.l_v(), of_state.force());
        self.left.v.iter_mut().enumerate().for_each(|(i, left)| *left = l_v[i] - h * force[i]);
        self.left.sigma.copy_from_slice(self.of_state.phi_dot());
        let compliance = linearisation.evaluation.compliance().iter();
        compliance.for_each(|&(j, mu)| self.left.sigma[j] -= mu * self.x.sigma[j]);
        self.left.subtract_from(&self.right);
        linearisation.solve(system, &mut self.left);
        self.x.add(&self.left);
        self.accuracy.note(largest(&self.left.v) / largest(&self.x.v), pivot);
    }

    fn store(&mut self, (node, s): (usize, usize), h: f64) {
        let now = self.change.trajectory.stage_mut(node, s);
        now.v.copy_from_slice(&self.x.v);
        now.sigma.copy_from_slice(&self.x.sigma);
        for i in 0..now.q.len() {
            let g = self.sums.force()[i] + self.of_state.force()[i];
            now.q[i] = self.known_q[i] + h * self.x.v[i];
            now.p_star_dot[i] = g;
            now.p_star[i] = self.known_p[i] + h * g;
        }
    }
}

/// A stage of the step that ends at a node; if an event follows, the state before it.
pub(super) fn stage_end<'a>(motion: &'a Motion, (node, s): (usize, usize), ended: Option<StepEnd<'a>>) -> StageEnd<'a> {
    let ended = ended.filter(|_| s == motion.trajectory.last_stage());
    let (at, blocks) = match ended {
        None => (motion.at_stage(node, s), motion.stage_blocks(node, s)),
        Some(end) => (end.view(motion.at(node)), end.blocks),
    };
    StageEnd { node, s, at, blocks, is_before_event: ended.is_some() }
}

/// The direction of v̇ and σ̇, and of q̇ = h v̇.
fn along_solution<'a>((x, h): (&'a Pair, f64), x_q: &'a mut [f64], no_controls: &'a [f64]) -> NodeView<'a, f64> {
    x_q.iter_mut().zip(&x.v).for_each(|(q, v)| *q = h * v);
    NodeView::of_equations([x_q, &x.v, &x.sigma], (no_controls, 0.0, &[]))
}

/// The direction of (q₀, v₀) and the design variables, if velocities are given.
pub(super) fn along_start<'a>(change: &'a Motion, (sigma, u): (&'a [f64], &'a [f64])) -> NodeView<'a, f64> {
    let start = &change.inputs.start;
    NodeView::of_equations([start.q().as_slice(), start.rate().as_slice(), sigma], (u, 0.0, &change.design))
}
