//! The derivatives of the adjoint equations along a direction: a backward sweep with other sources.

use super::forward::along_start;
use super::kept::Place;
use super::{First, SecondOrderSweep};
use crate::adjoint::stage::StageMatrix;
use crate::adjoint::{AdjointSweep, Gradient};
use crate::motion::{Examiner, Motion, Report};
use crate::node::Linearisation;
use crate::number::{add, dot};
use crate::scheme::carried_part;
use crate::system::{Covector, NodeView, Order};
use crate::{Error, Inputs, Start, System};

impl SecondOrderSweep {
    /// Sweeps backward through all nodes.
    pub(super) fn backward(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        direction: &Inputs,
    ) -> Result<&Gradient, Error> {
        self.begin_sources(system, motion, first)?;
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(motion.nodes() - 1));
        for node in (0..motion.nodes()).rev() {
            self.visit(system, motion, (linearisation, first), node)?;
        }
        self.begin_rows(system, motion, (linearisation, first));
        self.back_through_assembly(system, motion, (linearisation, first), direction)?;
        self.parameter_rows(system, motion, first);
        let (mut report, mut examiner) = (Report::default(), Examiner::new(Order::Second));
        (0..motion.nodes()).for_each(|node| examiner.visit(system, motion, node, &mut report));
        self.sweep.gradient.warnings = report.warnings;
        match self.sweep.gradient.check_finite(system, motion.node_of_whole(0)) {
            // Some derivatives do not affect the product, such as that with respect to the start time.
            Err(error) => Err(self.suspect.take().unwrap_or(error)),
            Ok(()) => Ok(&self.sweep.gradient),
        }
    }

    /// Sweeps backward through one node and the step that ends there.
    fn visit(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        node: usize,
    ) -> Result<(), Error> {
        let (scheme, last, dt) = (motion.trajectory.scheme, motion.trajectory.last_stage(), motion.length(node));
        let (happened, h) = (motion.events.at(node), dt * scheme.a(last, last));
        self.unused_events.extend(self.ended.take());
        self.sources_of_node(system, motion, (linearisation, first), node)?;
        let sweep = &mut self.sweep;
        sweep.take_earlier_sigma(node);
        let begins = happened.is_some() || node == 0;
        let h_here = if begins { 0.0 } else { h };
        self.solve_stage(system, motion, (linearisation, first), (node, last), (h_here, None), || motion.at(node))?;
        if let Some(happened) = happened {
            let singular = |breakdown| system.singular_step(&breakdown, motion.step_of_whole(node), motion.time(node));
            self.pass_back(system, motion, (linearisation, first), happened).map_err(singular)?;
            let end = || happened.end.view(motion.at(node));
            self.solve_stage(system, motion, (linearisation, first), (node, last), (h, Some(happened.end.blocks)), end)?;
        }
        let sweep = &mut self.sweep;
        sweep.refinement.add_controls(node, 1.0, &sweep.u, &mut sweep.gradient.controls);
        if node == 0 {
            return Ok(());
        }
        for s in (1..last).rev() {
            self.inner_stage(system, motion, (linearisation, first), (node, s))?;
        }
        self.sweep.step_row(motion, happened.as_ref().map(|happened| &happened.end), node);
        self.step_row(motion, first, node);
        carried_part((&scheme, 0), dt, &mut self.sweep.step, &mut self.sweep.carried);
        self.carry(motion, first, (node, 0));
        Ok(())
    }

    /// Solves the adjoint equations of a stage with the factors of the forward sweep, and computes the derivatives with respect to its inputs.
    fn solve_stage<'a>(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        (node, s): (usize, usize),
        (h, blocks): (f64, Option<&[f64]>),
        at: impl Fn() -> NodeView<'a, f64>,
    ) -> Result<(), Error> {
        if first.record.has_nothing(motion.block_column(node, s)) {
            self.sweep.clear_stage(s);
            return Ok(());
        }
        let place = Place { column: motion.block_column(node, s), is_end: blocks.is_some() };
        let singular = |breakdown| system.singular_step(&breakdown, motion.step_of_whole(node), motion.at(node).t);
        let mut is_factored = self.kept.lend(system, linearisation, (place, h)).map_err(singular)?;
        let matrix = StageMatrix { h, blocks, is_factored: &mut is_factored };
        self.sweep.solve_stage(system, motion, linearisation, (node, s), matrix)?;
        self.kept.take_back(linearisation, place);
        self.sweep.input_rows(system, linearisation, at, node)
    }

    /// Sweeps backward through a stage between a node and the previous one.
    fn inner_stage(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        (node, s): (usize, usize),
    ) -> Result<(), Error> {
        let (scheme, dt) = (motion.trajectory.scheme, motion.length(node));
        let before = std::mem::take(&mut self.sweep.time);
        carried_part((&scheme, s), dt, &mut self.sweep.step, &mut self.sweep.carried);
        self.carry(motion, first, (node, s));
        self.sources_of_stage(system, motion, (linearisation, first), (node, s))?;
        let at = || motion.at_stage(node, s);
        self.solve_stage(system, motion, (linearisation, first), (node, s), (dt * scheme.a(s, s), None), at)?;
        self.sweep.add_inner_inputs(node, scheme.c(s));
        self.sweep.time += before;
        Ok(())
    }

    /// Adds Δt˙ Σ_{r>s} a_rs (a_r, b_r), the change of the carried part with the length of the step.
    fn carry(&mut self, motion: &Motion, first: &First, (node, s): (usize, usize)) {
        let (scheme, dt_dot) = (motion.trajectory.scheme, self.change.length(node));
        let carried = &mut self.sweep.carried;
        if scheme.stages() == 1 {
            carried.alpha.fill(0.0);
            carried.beta.fill(0.0);
        }
        if dt_dot == 0.0 {
            return;
        }
        for r in s + 1..=scheme.stages() {
            let ([a, b], factor) = (first.record.of_step(motion.block_column(node, r)), dt_dot * scheme.a(r, s));
            carried.alpha.iter_mut().zip(a).for_each(|(sum, a)| *sum += factor * a);
            carried.beta.iter_mut().zip(b).for_each(|(sum, b)| *sum += factor * b);
        }
    }

    /// The change of dJ/dΔt = −Σ_s Σ_j a_sj (a_sᵀ v_j + b_sᵀ g_j) with v_j and g_j.
    fn step_row(&mut self, motion: &Motion, first: &First, node: usize) {
        let (scheme, mut own) = (motion.trajectory.scheme, 0.0);
        for (s, row) in scheme.rows.iter().enumerate() {
            let stage = motion.block_column(node, s + 1);
            if first.record.has_nothing(stage) {
                continue;
            }
            let [a, b] = first.record.of_step(stage);
            for (j, weight) in row.iter().enumerate() {
                let ended =
                    self.ended.as_ref().filter(|_| j == scheme.stages()).map(|end| (&end.v[..], &end.p_star_dot[..]));
                let (v, rate) = ended.unwrap_or_else(|| self.change.trajectory.rates(node, j));
                own += weight * (dot(a, v) + dot(b, rate));
            }
        }
        self.sweep.refinement.add_step(node, -own, &mut self.sweep.gradient.steps);
    }

    /// Computes the rows of q₀ and v₀ or p*₀, including the change of p*₀ = T_v(q₀, v₀; b) itself.
    fn begin_rows(&mut self, system: &System, motion: &Motion, (linearisation, first): (&mut Linearisation, &First)) {
        let SecondOrderSweep { sweep, change, programs, zeros, no_controls, right, .. } = self;
        sweep.start_rows(system, motion, linearisation);
        let [_, b] = first.record.of_step(motion.block_column(0, motion.trajectory.last_stage()));
        let Start::Velocity { q, v } = &mut sweep.gradient.start else { return };
        right.v.iter_mut().zip(b).for_each(|(c, b)| *c = -b);
        let (with, rows) = (Covector { c: &right.v, d: &zeros.v, e: &zeros.sigma }, &mut sweep.cost);
        let ((at, blocks), along) = (motion.given_start(), along_start(change, (&zeros.sigma, no_controls)));
        programs.rows_along((system, &linearisation.evaluation), (&at, blocks), &along, &with, rows);
        add(q.as_mut_slice(), &rows.q);
        add(v.as_mut_slice(), &rows.v);
        add(&mut sweep.design, &rows.design);
    }

    /// From the values z(b) of the parameters to b: the change of (∂z/∂b)ᵀ w.
    fn parameter_rows(&mut self, system: &System, motion: &Motion, first: &First) {
        let [of, along] = [&motion.inputs.design, &self.change.inputs.design].map(|design| design.as_slice());
        let AdjointSweep { design, gradient, .. } = &mut self.sweep;
        system.parameters().pull_back_along([of, first.design], [along, design], gradient.design.as_mut_slice());
    }
}
