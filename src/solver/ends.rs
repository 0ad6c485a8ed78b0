//! The state at the end of a motion, and its derivatives.

use super::Solver;
use crate::Error;
use crate::adjoint::{AdjointSweep, Gradient};
use crate::motion::Report;
use crate::{Settings, Trajectory};

/// A function of a motion: an output, or an entry of the state (q, v, p\*) at the last node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    Output(usize),
    End(usize),
}

impl Solver {
    /// q, v and p* at the last node.
    pub(crate) fn end(&self) -> Vec<f64> {
        end_of(self.trajectory(), self.trajectory().last())
    }

    /// Φ, m or rad, and σ, N s or N m s, at the last node.
    pub(crate) fn end_of_constraints(&self) -> [Vec<f64>; 2] {
        let mut phi = vec![0.0; self.system.m()];
        let at = self.forward.motion.at(self.trajectory().last());
        self.system.phi(&at, &mut phi);
        [phi, at.sigma.to_vec()]
    }

    /// The changes of q, v and p* at the last node along the last direction of [`push_forward`](Self::push_forward).
    pub(crate) fn change_of_end(&self) -> Vec<f64> {
        let change = self.products.as_ref().map(|products| products.change());
        change.map_or_else(Vec::new, |change| end_of(change, self.trajectory().last()))
    }

    /// The gradients of outputs and of entries of the state at the last node.
    pub(crate) fn gradients_of_all<'s>(
        &'s mut self,
        asked: &[Asked],
    ) -> Result<impl Iterator<Item = &'s Gradient> + use<'s>, Error> {
        if self.has_events() && !asked.is_empty() {
            self.located()?;
        }
        let Solver { system, settings, forward, sweeps, rows, located, .. } = self;
        if rows.len() < asked.len() {
            rows.resize_with(asked.len(), || AdjointSweep::new(system, settings.scheme));
        }
        let (rows, entries) = (&mut rows[..asked.len()], 3 * system.n());
        if !asked.is_empty() {
            let settings = Settings { keep_adjoint: false, ..*settings };
            AdjointSweep::run(rows, system, &mut forward.solved(), &settings, |k, factors| match asked[k] {
                Asked::Output(which) => factors.choose(1 + which),
                Asked::End(which) => factors.choose_end(which, entries),
            })?;
            located.iter().for_each(|located| rows.iter_mut().for_each(|row| located.complete(&mut row.gradient)));
            sweeps[0].report = Report::of_all(rows.iter_mut().map(|row| std::mem::take(&mut row.report)));
        }
        Ok(rows.iter().map(|row| &row.gradient))
    }
}

fn end_of(trajectory: &Trajectory, node: usize) -> Vec<f64> {
    let all = [&trajectory.q, &trajectory.v, &trajectory.p_star];
    all.into_iter().flat_map(|of| of.column(node).iter().copied().collect::<Vec<f64>>()).collect()
}
