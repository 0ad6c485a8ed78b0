//! Second derivatives of a restart: the equations of `forward/restart.rs` along a direction, and the derivatives of `adjoint/restart.rs`.
//!
//! ```text
//!   (𝓛_vv + 𝓛_vq) ẇ + Φ_qᵀ ν̇ = −D 𝓛_v,   Φ_q ẇ = −D Φ     D along q̇⁻ and the inputs, at (q, w, ν);     q̇ = q̇⁻ + ẇ
//!   ṗ* = D 𝓛_v(q, v⁻, s)                                   D along q̇, v̇⁻, ṡ = α σ̇⁻ + β σ̇₋ and the inputs
//! ```

use super::changes::RestartChange;
use super::forward::stage_end;
use super::sources::{OfStage, direction};
use super::{First, SecondOrderSweep};
use crate::adjoint::record::{Crossed, Record};
use crate::adjoint::restart::is_rounding;
use crate::motion::{MOST_CORRECTIONS_OF_PROJECTION, Motion, Restart, column};
use crate::node::{ALONG, Linearisation};
use crate::number::{Real, add};
use crate::system::{CostRows, Covector, NodeView, Pair};
use crate::{Error, System};

/// A restart, with its data from the gradient and from the direction.
struct Crossing<'a> {
    node: usize,
    restart: &'a Restart<'a>,
    crossed: &'a Crossed,
    change: &'a RestartChange,
}

impl SecondOrderSweep {
    /// From the direction at the end of a step to that of the restarted motion.
    pub(super) fn cross(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (node, restart): (usize, &Restart),
    ) -> Result<(), Error> {
        let unused = self.unused_restarts.pop();
        let mut of = unused.unwrap_or_else(|| RestartChange::new(system.n(), system.m())).at_end(&self.change.at(node));
        if let Some(of_projection) = restart.projection {
            self.project(system, motion, linearisation, (node, restart.q, of_projection), &mut of)?;
        }
        let [now, before] = restart.weights;
        let sigma_before = column(&self.change.trajectory.sigma, restart.before);
        let both = of.sigma.iter().zip(sigma_before);
        of.begin.iter_mut().zip(both).for_each(|(begin, (end, start))| *begin = now * end + before * start);
        let at = NodeView { v: restart.v, sigma: restart.begin, ..motion.at(node) };
        let SecondOrderSweep { change, programs, sums, .. } = self;
        let along = NodeView { q: &of.q_behind, v: &of.v, sigma: &of.begin, ..change.at(node) };
        programs.changes((system, &linearisation.evaluation), (&at, restart.momentum_blocks), &along, sums);
        self.known_p.copy_from_slice(self.sums.l_v());
        self.known_q.copy_from_slice(&of.q_behind);
        self.sigma_before.copy_from_slice(&of.begin);
        self.restarts.push(of);
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(node));
        Ok(())
    }

    /// Computes ẇ, ν̇ and q̇ = q̇⁻ + ẇ.
    fn project(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (node, q_before, (nu, blocks)): (usize, &[f64], (&[f64], &[f64])),
        of: &mut RestartChange,
    ) -> Result<(), Error> {
        let SecondOrderSweep { change, programs, zeros, no_controls, sums, report, right, left, x_q: w, phi, .. } = self;
        let (here, q_dot) = (change.at(node), &of.q[..]);
        set_displacement(motion, node, q_before, w);
        let at = NodeView { v: w, sigma: nu, ..motion.at(node) };
        let along = NodeView { q: q_dot, v: &zeros.v, sigma: &zeros.sigma, ..here };
        programs.changes((system, &linearisation.evaluation), (&at, blocks), &along, sums);
        right.v.iter_mut().zip(sums.l_v()).for_each(|(right, l_v)| *right = -l_v);
        phi.set(&at, &along);
        right.sigma.iter_mut().zip(phi.evaluate(system)).for_each(|(right, phi)| *right = -phi.part(ALONG));

        let singular = |breakdown| system.singular_step(&breakdown, motion.step_of_whole(node), at.t);
        linearisation.evaluation.set_compliance(&motion.shared);
        linearisation.factor(system, 0.0, blocks, report).map_err(singular)?;
        let (x, mut last) = (&mut of.projection, f64::INFINITY);
        left.v.copy_from_slice(&right.v);
        left.sigma.copy_from_slice(&right.sigma);
        for _ in 0..MOST_CORRECTIONS_OF_PROJECTION {
            linearisation.solve(system, left);
            x.add(left);
            let correction = linearisation.size_of(&left.v);
            if is_rounding(correction, last, linearisation.size_of(&x.v)) {
                break;
            }
            last = correction;
            let of_x = NodeView::of_equations([&x.v, &x.v, &x.sigma], (no_controls, 0.0, &[]));
            linearisation.evaluation.push_forward(system, blocks, &of_x, sums);
            left.v.copy_from_slice(sums.l_v());
            // Φ_q w is the change of dΦ/dt with v along w.
            let of_w = NodeView::of_equations([&zeros.v, &x.v, &zeros.sigma], (no_controls, 0.0, &[]));
            linearisation.evaluation.push_forward(system, blocks, &of_w, sums);
            left.sigma.copy_from_slice(sums.phi_dot());
            linearisation.evaluation.compliance().iter().for_each(|&(j, mu)| left.sigma[j] -= mu * x.sigma[j]);
            left.subtract_from(right);
        }
        add(&mut of.q_behind, &of.projection.v);
        Ok(())
    }

    /// Adjoint equations of a restart, back to the end of the step before it, whose sources are then in the sweep.
    pub(super) fn cross_back(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        (node, restart): (usize, &Restart),
    ) -> Result<(), Error> {
        let (Some(change), Some(crossed)) = (self.restarts.pop(), first.record.crossed(node)) else { return Ok(()) };
        let of = Crossing { node, restart, crossed, change: &change };
        self.sweep.begin_crossing();
        self.momentum_back(system, motion, linearisation, &of);
        linearisation.evaluation.set_compliance(&motion.shared);
        self.projection_back(system, motion, linearisation, &of)?;
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_into(node));
        self.sweep.carried.clear();
        self.add_end(system, motion, (linearisation, first.record), &of);
        self.ended = Some(change);
        Ok(())
    }

    /// Adjoint of p* = 𝓛_v(q, v⁻, s).
    fn momentum_back(&mut self, system: &System, motion: &Motion, linearisation: &mut Linearisation, of: &Crossing) {
        let Crossing { node, restart, crossed, change } = of;
        self.sweep.cross_momentum(system, motion, linearisation, restart, *node);
        let SecondOrderSweep { sweep, change: of_motion, programs, first_rows: rows, right, zeros, .. } = self;
        right.v.iter_mut().zip(&crossed.anew.b).for_each(|(pi, b)| *pi = -b);
        let at = NodeView { v: restart.v, sigma: restart.begin, ..motion.at(*node) };
        let with = Covector { c: &right.v, d: &zeros.v, e: &zeros.sigma };
        let along = direction(of_motion, *node, [&change.q_behind, &change.v, &change.begin]);
        programs.rows_along((system, &linearisation.evaluation), (&at, restart.momentum_blocks), &along, &with, rows);
        add(&mut sweep.cost.q, &rows.q);
        add(&mut sweep.cost.v, &rows.v);
        let [now, before] = restart.weights;
        add_multiple(&mut sweep.cost.sigma, now, &rows.sigma);
        add_multiple(&mut sweep.sigma_before, before, &rows.sigma);
        sweep.add_inputs_of(rows);
    }

    /// Adjoint of 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0, if there was a projection.
    fn projection_back(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        of: &Crossing,
    ) -> Result<(), Error> {
        let Crossing { node, restart, crossed, change } = of;
        let Some((nu, blocks)) = restart.projection else { return Ok(()) };
        let here = motion.at(*node);
        let SecondOrderSweep { change: of_motion, programs, first_rows: rows, left: less, zeros, x_q: w, .. } = self;
        set_displacement(motion, *node, restart.q, w);
        let at = NodeView { v: w, sigma: nu, ..here };
        let along = direction(of_motion, *node, [&change.q_behind, &change.projection.v, &change.projection.sigma]);
        let Pair { v: c, sigma: e } = &crossed.projection;
        let of_e = Covector { c: &zeros.v, d: &zeros.v, e };
        programs.rows_along((system, &linearisation.evaluation), (&at, blocks), &along, &of_e, rows);
        less.v.copy_from_slice(&rows.v);
        let of_c = Covector { c, d: &zeros.v, e: &zeros.sigma };
        programs.rows_along((system, &linearisation.evaluation), (&at, blocks), &along, &of_c, rows);
        add(&mut less.v, &rows.v);
        add(&mut less.v, &rows.q);
        less.sigma.copy_from_slice(&rows.sigma);
        let singular = |breakdown| system.singular_step(&breakdown, motion.step_of_whole(*node), here.t);
        let crossed = self.sweep.cross_projection(system, motion, linearisation, (restart, Some(&self.left)), *node);
        crossed.map_err(singular)?;
        add_multiple(&mut self.sweep.cost.q, -1.0, &self.first_rows.v);
        self.sweep.add_inputs_of(&self.first_rows);
        self.add_change_of_phi(system, (&here, *node), (e, 1.0), &change.q_behind);
        Ok(())
    }

    /// Adds the sources at the end of the step.
    fn add_end(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, record): (&Linearisation, &Record),
        of: &Crossing,
    ) {
        let Crossing { node, restart, change, .. } = *of;
        let last = motion.trajectory.last_stage();
        let stage = motion.block_column(node, last);
        let (_, at, blocks) = stage_end(motion, (node, last), Some(*restart));
        let SecondOrderSweep { sweep, change: of_motion, programs, first_rows: rows, .. } = self;
        let along = NodeView { q: &change.q, v: &change.v, sigma: &change.sigma, ..of_motion.at(node) };
        let h_dot = of_motion.length(node) * motion.trajectory.scheme.a(last, last);
        let (with, step) = (record.covector(stage), record.of_step(stage));
        rows.clear();
        OfStage { at, along, blocks, with, step, h_dot }.add_sources(system, linearisation, programs, rows);
        let CostRows { q, v, sigma, p_star_dot, .. } = &mut sweep.cost;
        for (sum, own) in [(q, &rows.q), (v, &rows.v), (sigma, &rows.sigma), (p_star_dot, &rows.p_star_dot)] {
            add(sum, own);
        }
        sweep.add_inputs_of(rows);
    }

    /// Adds the change of (Φ_b, Φ_t)ᵀ e, times a sign, along a direction, by hyper-dual numbers.
    pub(super) fn add_change_of_phi(
        &mut self,
        system: &System,
        (here, node): (&NodeView<f64>, usize),
        (e, sign): (&[f64], f64),
        q_dot: &[f64],
    ) {
        let SecondOrderSweep { change, sweep, phi, .. } = self;
        phi.set(here, &NodeView { q: q_dot, ..change.at(node) });
        phi.add_change(system, (e, sign), (&mut sweep.design, &mut sweep.time));
    }
}

/// w, the displacement of a node by a projection.
fn set_displacement(motion: &Motion, node: usize, q_before: &[f64], w: &mut [f64]) {
    let moved = motion.at(node).q.iter().zip(q_before);
    w.iter_mut().zip(moved).for_each(|(w, (q, before))| *w = q - before);
}

fn add_multiple(sum: &mut [f64], factor: f64, x: &[f64]) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}
