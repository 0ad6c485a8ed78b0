//! Through a restart, forwards and backwards: the equations of `forward/restart.rs` along a direction, and `adjoint/restart.rs` differentiated.
//!
//! ```text
//!   (𝓛_vv + 𝓛_vq) ẇ + Φ_qᵀ ν̇ = −D 𝓛_v,   Φ_q ẇ = −D Φ     D along q̇⁻ and the inputs, at (q, w, ν);     q̇ = q̇⁻ + ẇ
//!   ṗ* = D 𝓛_v(q, v⁻, s)                                   D along q̇, v̇⁻, ṡ = α σ̇⁻ + β σ̇₋ and the inputs
//! ```

use num_dual::Dual64;

use super::forward::stage_end;
use super::sources::OfStage;
use super::{SecondOrderSweep, dual};
use crate::adjoint::AdjointSweep;
use crate::adjoint::record::{Crossed, Record};
use crate::adjoint::restart::is_rounding;
use crate::forward::Motion;
use crate::forward::projection::MOST_CORRECTIONS_OF_PROJECTION;
use crate::forward::restart::Restart;
use crate::motion::column;
use crate::node::Newton;
use crate::number::{Hyper, Real, largest};
use crate::system::{CostRows, Covector, Given, NodeView, Pair};
use crate::{Error, System};

/// The directions of what a step ended with, of (w, ν) and of s.
pub(super) struct RestartChange {
    q: Vec<f64>,
    pub(super) v: Vec<f64>,
    sigma: Vec<f64>,
    pub(super) p_star_dot: Vec<f64>,
    projection: Pair,
    begin: Vec<f64>,
}

/// A restart, what the gradient and the direction know of it.
struct Crossing<'a> {
    node: usize,
    restart: &'a Restart<'a>,
    crossed: &'a Crossed,
    change: &'a RestartChange,
}

impl Crossing<'_> {
    /// q̇ = q̇⁻ + ẇ.
    fn direction_of_q(&self) -> Vec<f64> {
        self.change.q.iter().zip(&self.change.projection.v).map(|(q, w)| q + w).collect()
    }
}

impl SecondOrderSweep {
    /// From the direction at the end of a step to that of the motion that was started anew.
    pub(super) fn cross(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, restart): (usize, &Restart),
    ) -> Result<(), Error> {
        let end = self.change.at(node);
        let own = |list: &[f64]| list.to_vec();
        let (q_end, v, sigma, p_star_dot) = (own(end.q), own(end.v), own(end.sigma), own(end.p_star_dot));
        let mut q = q_end.clone();
        let mut projection = Pair { v: vec![0.0; q.len()], sigma: vec![0.0; sigma.len()] };
        if let Some(of_projection) = restart.projection {
            projection = self.project(system, motion, newton, (node, restart.q, of_projection), &q)?;
            q.iter_mut().zip(&projection.v).for_each(|(q, w)| *q += w);
        }
        let [now, before] = restart.weights;
        let sigma_before = column(&self.change.trajectory.sigma, restart.before);
        let begin: Vec<f64> = sigma.iter().zip(sigma_before).map(|(end, start)| now * end + before * start).collect();
        let at = NodeView { v: restart.v, sigma: restart.begin, ..motion.at(node) };
        let SecondOrderSweep { change, programs, sums, .. } = self;
        let along = NodeView { q: &q, v: &v, sigma: &begin, ..change.at(node) };
        newton.evaluation.push_forward(system, restart.momentum_blocks, &along, sums);
        if let Some(programs) = programs {
            programs.equations.add_changes(system.batches(), (&at, &along), sums);
        }
        self.known_p.copy_from_slice(self.sums.l_v());
        self.known_q.copy_from_slice(&q);
        self.sigma_before.copy_from_slice(&begin);
        self.restarts.push(RestartChange { q: q_end, v, sigma, p_star_dot, projection, begin });
        Ok(())
    }

    /// ẇ and ν̇.
    fn project(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        (node, q_before, (nu, blocks)): (usize, &[f64], (&[f64], &[f64])),
        q_dot: &[f64],
    ) -> Result<Pair, Error> {
        let w = displacement(motion, node, q_before);
        let at = NodeView { v: &w, sigma: nu, ..motion.at(node) };
        let SecondOrderSweep { change, programs, zeros, no_controls, sums, report, .. } = self;
        let here = change.at(node);
        let along = NodeView { q: q_dot, v: &zeros.v, sigma: &zeros.sigma, ..here };
        newton.evaluation.push_forward(system, blocks, &along, sums);
        if let Some(programs) = programs {
            programs.equations.add_changes(system.batches(), (&at, &along), sums);
        }
        let mut right = Pair::new(w.len(), nu.len());
        right.v.iter_mut().zip(sums.l_v()).for_each(|(right, l_v)| *right = -l_v);
        let [q, u] = [dual(at.q, q_dot), dual(at.u, here.u)];
        let design = dual(at.design, here.design);
        let given = Given { u: &u, t: Dual64::new(at.t, here.t), design: &design };
        let (v, none) = (dual(&zeros.v, &zeros.v), dual(&zeros.sigma, &zeros.sigma));
        let mut phi = none.clone();
        system.phi(&given.at(&q, &v, &none), &mut phi);
        right.sigma.iter_mut().zip(&phi).for_each(|(right, phi)| *right = -phi.eps);

        let singular = |breakdown| system.singular_step(&breakdown, motion.given_step(node), at.t);
        newton.factor(system, 0.0, blocks, report).map_err(singular)?;
        let (mut x, mut left, mut last) = (Pair::new(w.len(), nu.len()), right.clone(), f64::INFINITY);
        for _ in 0..MOST_CORRECTIONS_OF_PROJECTION {
            newton.solve(system, &mut left);
            x.add(&left);
            let correction = largest(&left.v);
            if is_rounding(correction, last, largest(&x.v)) {
                break;
            }
            last = correction;
            let of_x = NodeView::of_equations([&x.v, &x.v, &x.sigma], (no_controls, 0.0, &[]));
            newton.evaluation.push_forward(system, blocks, &of_x, sums);
            left.v.copy_from_slice(sums.l_v());
            // Φ_q w is what dΦ/dt changes by with v.
            let of_w = NodeView::of_equations([&zeros.v, &x.v, &zeros.sigma], (no_controls, 0.0, &[]));
            newton.evaluation.push_forward(system, blocks, &of_w, sums);
            left.sigma.copy_from_slice(sums.phi_dot());
            motion.trajectory.compliance.iter().for_each(|&(j, mu)| left.sigma[j] -= mu * x.sigma[j]);
            left.subtract_from(&right);
        }
        Ok(x)
    }

    /// Back through the restart, to the end of the step before it, whose sources stand in the sweep then.
    pub(super) fn cross_back(
        &mut self,
        system: &System,
        motion: &Motion,
        (newton, first): (&mut Newton, &AdjointSweep),
        (node, restart): (usize, &Restart),
    ) -> Result<(), Error> {
        let Some(change) = self.restarts.pop() else { return Ok(()) };
        let Some((record, crossed)) = first.record.as_ref().and_then(|record| Some((record, record.crossed(node)?))) else {
            return Ok(());
        };
        let of = Crossing { node, restart, crossed, change: &change };
        self.sweep.begin_crossing();
        self.momentum_back(system, motion, newton, &of);
        self.projection_back(system, motion, newton, &of)?;
        self.sweep.carried.clear();
        self.add_end(system, motion, (newton, record), &of);
        self.ended = Some(change);
        Ok(())
    }

    /// p* = 𝓛_v(q, v⁻, s).
    fn momentum_back(&mut self, system: &System, motion: &Motion, newton: &mut Newton, of: &Crossing) {
        let Crossing { node, restart, crossed, change } = of;
        self.sweep.cross_momentum(system, motion, newton, restart, *node);
        let pi: Vec<f64> = crossed.anew.b.iter().map(|b| -b).collect();
        let (q, zeros) = (of.direction_of_q(), self.zeros.clone());
        let at = NodeView { v: restart.v, sigma: restart.begin, ..motion.at(*node) };
        let with = Covector { c: &pi, d: &zeros.v, e: &zeros.sigma };
        let states = [&q[..], &change.v, &change.begin];
        self.rows_along(system, newton, (*node, &at, restart.momentum_blocks), states, &with);
        let SecondOrderSweep { sweep, first_rows: rows, .. } = self;
        add(&mut sweep.cost.q, &rows.q, 1.0);
        add(&mut sweep.cost.v, &rows.v, 1.0);
        let [now, before] = restart.weights;
        add(&mut sweep.cost.sigma, &rows.sigma, now);
        add(&mut sweep.sigma_before, &rows.sigma, before);
        sweep.add_inputs_of(rows);
    }

    /// 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0, if there was a projection.
    fn projection_back(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        of: &Crossing,
    ) -> Result<(), Error> {
        let Crossing { node, restart, crossed, change } = of;
        let Some((nu, blocks)) = restart.projection else { return Ok(()) };
        let (q, w) = (of.direction_of_q(), displacement(motion, *node, restart.q));
        let (here, zeros) = (motion.at(*node), self.zeros.clone());
        let at = NodeView { v: &w, sigma: nu, ..here };
        let states = [&q[..], &change.projection.v, &change.projection.sigma];
        let Pair { v: c, sigma: e } = &crossed.projection;
        let of_e = Covector { c: &zeros.v, d: &zeros.v, e };
        self.rows_along(system, newton, (*node, &at, blocks), states, &of_e);
        let mut less = Pair { v: self.first_rows.v.clone(), sigma: zeros.sigma.clone() };
        let of_c = Covector { c, d: &zeros.v, e: &zeros.sigma };
        self.rows_along(system, newton, (*node, &at, blocks), states, &of_c);
        let rows = &self.first_rows;
        add(&mut less.v, &rows.v, 1.0);
        add(&mut less.v, &rows.q, 1.0);
        add(&mut less.sigma, &rows.sigma, 1.0);
        let singular = |breakdown| system.singular_step(&breakdown, motion.given_step(*node), here.t);
        let crossed = self.sweep.cross_projection(system, motion, newton, (restart, Some(&less)), *node);
        crossed.map_err(singular)?;
        add(&mut self.sweep.cost.q, &self.first_rows.v, -1.0);
        self.sweep.add_inputs_of(&self.first_rows);
        self.add_change_of_phi(system, (&here, *node), (e, 1.0), &q);
        Ok(())
    }

    /// The sources of the end of the step.
    fn add_end(&mut self, system: &System, motion: &Motion, (newton, record): (&Newton, &Record), of: &Crossing) {
        let Crossing { node, restart, change, .. } = *of;
        let last = motion.trajectory.last_stage();
        let stage = motion.block_column(node, last);
        let (_, at, blocks) = stage_end(motion, (node, last), Some(*restart));
        let SecondOrderSweep { sweep, change: of_motion, programs, first_rows: rows, .. } = self;
        let Some(programs) = programs else { return };
        let along = NodeView { q: &change.q, v: &change.v, sigma: &change.sigma, ..of_motion.at(node) };
        let h_dot = of_motion.length(node) * motion.trajectory.scheme.a(last, last);
        let (with, step) = (record.covector(stage), record.of_step(stage));
        rows.clear();
        OfStage { at, along, blocks, with, step, h_dot }.add_sources(system, newton, programs, rows);
        let CostRows { q, v, sigma, p_star_dot, .. } = &mut sweep.cost;
        for (sum, own) in [(q, &rows.q), (v, &rows.v), (sigma, &rows.sigma), (p_star_dot, &rows.p_star_dot)] {
            add(sum, own, 1.0);
        }
        sweep.add_inputs_of(rows);
    }

    /// What (Φ_b, Φ_t)ᵀ e, times a sign, changes by along a direction, by hyper-dual numbers.
    pub(super) fn add_change_of_phi(
        &mut self,
        system: &System,
        (here, node): (&NodeView<f64>, usize),
        (e, sign): (&[f64], f64),
        q_dot: &[f64],
    ) {
        let along = self.change.at(node);
        let number = |(x, dot): (&f64, &f64)| {
            let mut number = Hyper::from(*x);
            number.add_to_part(2, *dot);
            number
        };
        let moving = |x: &[f64], dot: &[f64]| x.iter().zip(dot).map(number).collect::<Vec<Hyper>>();
        let (q, u) = (moving(here.q, q_dot), moving(here.u, along.u));
        let zeros = [vec![Hyper::from(0.0); q.len()], vec![Hyper::from(0.0); e.len()]];
        let mut phi = zeros[1].clone();
        for p in 0..=self.sweep.design.len() {
            let (mut design, mut t) = (moving(here.design, along.design), number((&here.t, &along.t)));
            design.get_mut(p).unwrap_or(&mut t).add_to_part(1, 1.0);
            let given = Given { u: &u, t, design: &design };
            system.phi(&given.at(&q, &zeros[0], &zeros[1]), &mut phi);
            let own = sign * phi.iter().zip(e).map(|(phi, e)| phi.part(3) * e).sum::<f64>();
            *self.sweep.design.get_mut(p).unwrap_or(&mut self.sweep.time) += own;
        }
    }
}

/// w, by which a projection moved a node.
fn displacement(motion: &Motion, node: usize, q_before: &[f64]) -> Vec<f64> {
    motion.at(node).q.iter().zip(q_before).map(|(q, before)| q - before).collect()
}

fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}
