//! The adjoint equations of one stage: Kᵀ (c, e) = r, and the variables that follow from c by substitution.
//!
//! Substituting b = c + B − J_p* into d gives d = D − h c with D = J_ṗ* + h J_p* − (h B + β). Then ∂v + h ∂q and ∂σ (see [`sweep`](super::sweep)) are
//! n + m equations for (c, e) with the matrix K(h)ᵀ; at node 0, h = 0:
//!
//! ```text
//!   Kᵀ (c, e) = ( h A + α − J_v − h J_q − (𝓛_qv + Q_v)ᵀ D − h (𝓛_qq + Q_q)ᵀ D,   −J_σ − (dΦ/dt)_q D )
//! ```
//!
//! With a compliance μ (`redundancy/compliances.rs`), the last part is −J_σ − (dΦ/dt)_q D − μ Σ e of the stages that follow.

use super::sweep::AdjointSweep;
use crate::motion::{Motion, column};
use crate::node::Linearisation;
use crate::system::Covector;
use crate::{Error, System};

/// The matrix K(h) of a stage.
pub(super) struct StageMatrix<'a> {
    pub(super) h: f64,
    /// Second derivatives, unless they are those of the motion.
    pub(super) blocks: Option<&'a [f64]>,
    pub(super) is_factored: &'a mut bool,
}

impl AdjointSweep {
    /// Solves the adjoint equations of stage s of the step that ends at node `i`.
    pub(super) fn solve_stage(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        (i, s): (usize, usize),
        StageMatrix { h, blocks, is_factored }: StageMatrix,
    ) -> Result<(), Error> {
        self.stage = s - 1;
        let at = motion.block_column(i - motion.first, s);
        let blocks = blocks.unwrap_or_else(|| column(&motion.blocks, at));
        self.right_side(system, linearisation, h, blocks);
        let solved = match std::mem::replace(is_factored, true) {
            true => Ok(linearisation.solve_transposed(system, &mut self.right, &mut self.report)),
            false => linearisation.factor_and_solve_transposed(system, h, blocks, &mut self.right, &mut self.report),
        };
        match solved {
            Ok(pivot) if self.accuracy.is_in_doubt(pivot) => self.refine(system, linearisation, (h, blocks), pivot),
            Ok(_) => {}
            Err(breakdown) => return Err(self.singular(system, motion, i, &breakdown)),
        }
        self.insert(system, linearisation, h, blocks);
        if let Some(record) = &mut self.record {
            record.store(at, &self.step[self.stage]);
        }
        Ok(())
    }

    /// Computes D, and the right-hand side r.
    #[inline(always)]
    fn right_side(&mut self, system: &System, linearisation: &mut Linearisation, h: f64, blocks: &[f64]) {
        let n = system.n();
        let (node, carried) = (&mut self.step[self.stage], &self.carried);
        let positions = system.positions();
        let right = &mut self.right[..];
        // Slices of equal length, so that the loops below need no bounds checks.
        let (a_sum, b_sum, position) = (&carried.a[..n], &carried.b[..n], &positions.v[..n]);
        let (alpha, beta, h_sum) = (&carried.alpha[..n], &carried.beta[..n], h + carried.factor);
        let d = &mut node.d[..n];
        right.fill(0.0);
        for k in 0..n {
            d[k] = -(h_sum * b_sum[k] + beta[k]);
            right[position[k]] = h_sum * a_sum[k] + alpha[k];
        }
        if !self.cost_is_zero {
            let cost = &self.cost;
            for k in 0..n {
                d[k] += cost.p_star_dot[k] + h * cost.p_star[k];
                right[position[k]] -= cost.v[k] + h * cost.q[k];
            }
            positions.sigma.iter().zip(&cost.sigma).for_each(|(&position, j_sigma)| right[position] -= j_sigma);
        }
        for &(j, mu) in linearisation.evaluation.compliance() {
            right[positions.sigma[j]] -= mu * carried.e[j];
        }
        linearisation.evaluation.subtract_force_rows(system, h, blocks, d, right);
    }

    /// One step of iterative refinement of (c, e).
    #[cold]
    fn refine(&mut self, system: &System, linearisation: &mut Linearisation, (h, blocks): (f64, &[f64]), pivot: f64) {
        self.solution.copy_from_slice(&self.right);
        self.right_side(system, linearisation, h, blocks);
        let correction = linearisation.refine_transposed(system, h, blocks, &self.solution, &mut self.right);
        self.accuracy.note(correction, pivot);
        self.report.refined_solutions += 1;
    }

    /// Computes the adjoint variables from (c, e), which are stored in place of r.
    #[inline(always)]
    fn insert(&mut self, system: &System, linearisation: &mut Linearisation, h: f64, blocks: &[f64]) {
        let n = system.n();
        let (node, carried, positions) = (&mut self.step[self.stage], &self.carried, system.positions());
        let (a_sum, b_sum, position) = (&carried.a[..n], &carried.b[..n], &positions.v[..n]);
        let (a, b, c, d) = (&mut node.a[..n], &mut node.b[..n], &mut node.c[..n], &mut node.d[..n]);
        for k in 0..n {
            let of_v = self.right[position[k]];
            c[k] = of_v;
            d[k] -= h * of_v;
            b[k] = of_v + b_sum[k];
        }
        node.e.iter_mut().zip(&positions.sigma).for_each(|(e, &position)| *e = self.right[position]);
        a.copy_from_slice(a_sum);
        if !self.cost_is_zero {
            a.iter_mut().zip(&self.cost.q).for_each(|(a, j_q)| *a -= j_q);
            b.iter_mut().zip(&self.cost.p_star).for_each(|(b, j_p)| *b -= j_p);
        }
        linearisation.evaluation.subtract_row_q(system, blocks, &Covector { c, d, e: &node.e }, a);
    }
}
