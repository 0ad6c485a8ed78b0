//! The adjoint of a restart: from dJ/dq and dJ/dp* of the restarted motion to dJ/dq⁻ and dJ/dv⁻ of the step before.

use super::AdjointSweep;
use crate::System;
use crate::linear::Breakdown;
use crate::motion::{MOST_CORRECTIONS_OF_PROJECTION, Motion, Restart};
use crate::node::Linearisation;
use crate::number::add;
use crate::scheme::StageAdjoint;
use crate::system::{Covector, InputRows, NodeView, Pair};

/// True if the corrections with 𝓛_vqᵀ (which decrease in proportion to the drift) consist of rounding errors and do not merely converge slowly.
pub(super) fn is_rounding(correction: f64, last: f64, size: f64) -> bool {
    correction <= 1e-16 * size || correction >= 0.5 * last && correction <= 1e-13 * size
}

impl AdjointSweep {
    /// Converts (a, b) = −(dJ/dq, dJ/dp*) of the node to a cost at the end of the step, J_q = dJ/dq⁻ and J_v = dJ/dv⁻. Afterwards the compliances are
    /// those of the projection.
    pub(crate) fn cross(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        restart: &Restart,
        node: usize,
    ) -> Result<(), Breakdown> {
        self.begin_crossing();
        self.cross_momentum(system, motion, linearisation, restart, node);
        linearisation.evaluation.set_compliance(&motion.shared);
        self.cross_projection(system, motion, linearisation, (restart, None), node)?;
        if let Some(record) = &mut self.record {
            record.end_crossing(&self.step[self.stage]);
        }
        self.carried.clear();
        Ok(())
    }

    /// Stores dJ/dq in place of J_q, and π = dJ/dp* in place of b.
    pub(super) fn begin_crossing(&mut self) {
        self.cost.clear();
        self.cost_is_zero = false;
        let StageAdjoint { a, b, .. } = &mut self.step[self.stage];
        self.cost.q.iter_mut().zip(a).for_each(|(q, a)| *q = -*a);
        b.iter_mut().for_each(|b| *b = -*b);
    }

    /// Adjoint of p* = 𝓛_v(q, v⁻, s) with the initial s = α σ⁻ + β σ₋.
    pub(super) fn cross_momentum(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        restart: &Restart,
        node: usize,
    ) {
        let StageAdjoint { b, e, .. } = &self.step[self.stage];
        let with = Covector { c: b, d: &self.zeros.v, e: &self.zeros.sigma };
        linearisation.evaluation.pull_back(system, restart.momentum_blocks, &with, &mut self.rows);
        self.cost.v.copy_from_slice(&self.rows.v);
        add(&mut self.cost.q, &self.rows.q);
        let here = motion.at(node);
        // dJ/ds, from which the contribution to σ₋ follows below.
        self.sigma_before.copy_from_slice(&self.rows.sigma);
        self.sigma_before_at = Some(restart.before);
        for &(j, mu) in motion.trajectory.compliance_from(node) {
            self.sigma_before[j] += mu * e[j];
        }
        let [now, before] = restart.weights;
        for (j_sigma, carried) in self.cost.sigma.iter_mut().zip(&mut self.sigma_before) {
            *j_sigma = now * *carried;
            *carried *= before;
        }
        let at = NodeView { v: restart.v, sigma: restart.begin, ..here };
        let evaluations = &mut self.report.input_evaluations;
        let mut rows = InputRows { u: &mut self.u, design: &mut self.design, time: &mut self.time, evaluations };
        linearisation.evaluation.pull_back_inputs(system, &at, &with, &mut rows);
    }

    /// Adjoint of 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0 with q = q⁻ + w, if there was a projection; `less` is subtracted from the right-hand side.
    pub(super) fn cross_projection(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (restart, less): (&Restart, Option<&Pair>),
        node: usize,
    ) -> Result<(), Breakdown> {
        let Some((nu, blocks)) = restart.projection else { return Ok(()) };
        let StageAdjoint { c, d, e, .. } = &mut self.step[self.stage];
        self.rows.q.fill(0.0);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS_OF_PROJECTION {
            // c of the previous iterate, for the size of the change.
            d.copy_from_slice(c);
            let (positions, right) = (system.positions(), &mut self.right);
            let terms = self.cost.q.iter().zip(&self.rows.q);
            positions.v.iter().zip(terms).for_each(|(&position, (j_q, row))| right[position] = -(j_q + row));
            positions.sigma.iter().for_each(|&position| right[position] = 0.0);
            if let Some(less) = less {
                positions.v.iter().zip(&less.v).for_each(|(&position, less)| right[position] -= less);
                positions.sigma.iter().zip(&less.sigma).for_each(|(&position, less)| right[position] -= less);
            }
            linearisation.factor_and_solve_transposed(system, 0.0, blocks, right, &mut self.report)?;
            c.iter_mut().zip(&positions.v).for_each(|(c, &position)| *c = right[position]);
            e.iter_mut().zip(&positions.sigma).for_each(|(e, &position)| *e = right[position]);
            let with = Covector { c, d: &self.zeros.v, e: &self.zeros.sigma };
            linearisation.evaluation.pull_back(system, blocks, &with, &mut self.rows);
            d.iter_mut().zip(&*c).for_each(|(d, c)| *d -= c);
            let change = linearisation.size_of(d);
            if is_rounding(change, last, linearisation.size_of(c)) {
                break;
            }
            last = change;
        }
        self.cost.q.iter_mut().zip(&self.rows.v).for_each(|(q, row)| *q = -row);

        let here = motion.at(node);
        // w is stored in place of d, which is no longer needed.
        d.iter_mut().zip(here.q.iter().zip(restart.q)).for_each(|(w, (q, before))| *w = q - before);
        let at = NodeView { v: d, sigma: nu, ..here };
        let with = Covector { c, d: &self.zeros.v, e: &self.zeros.sigma };
        let evaluations = &mut self.report.input_evaluations;
        let mut rows = InputRows { u: &mut self.u, design: &mut self.design, time: &mut self.time, evaluations };
        linearisation.evaluation.pull_back_inputs(system, &at, &with, &mut rows);
        system.placed().for_each(|item| item.pull_back_phi(&at, e, &mut rows));
        Ok(())
    }
}
