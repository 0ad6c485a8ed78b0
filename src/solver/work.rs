//! Work of computing the Jacobian of outputs by rows and by columns, counted so that the choice between them is the same in every run.

use super::{Asked, Solver};
use crate::model::element::Sum;
use crate::system::Depends;

/// Work of evaluating one cost; solving a stage is one unit of work per unknown.
const COST: usize = 10;
/// Work of computing the accelerations at one node, relative to that of solving a stage.
const ACCELERATIONS: usize = 6;

impl Solver {
    /// The work, in the unit of `COST`, by rows (a backward sweep for each of the given functions of the last motion) and by columns (a
    /// push-forward for each of `variables` variables).
    pub(crate) fn jacobian_work(&self, asked: &[Asked], variables: usize) -> [usize; 2] {
        let (system, motion) = (&self.system, &self.forward.motion);
        let (last, stages) = (motion.nodes() - 1, motion.trajectory.last_stage());
        let (all, unknowns) = (1 + stages * last, system.n() + system.m());
        // Number of stages that the sweep of each output passes; `None` without a sweep.
        let mut ways = vec![None; 1 + system.outputs()];
        let mut ends = 0;
        asked.iter().for_each(|asked| match asked {
            Asked::Output(output) => ways[1 + output] = Some(0),
            Asked::End(_) => ends += all,
        });
        let (mut by_rows, mut costs, mut accelerations) = (0, 0, 0);
        for term in system.costs().terms().filter(|term| term.output > 0) {
            let (places, way) = match term.sum {
                Sum::Node(node) => (1, 1 + stages * node),
                Sum::Terminal => (1, all),
                Sum::Integral => (all, all),
                _ => (1 + last, all),
            };
            let felt = if term.uses.accelerations() == Depends::Never { 0 } else { places };
            (costs, accelerations) = (costs + places, accelerations + felt);
            if let Some(Some(longest)) = ways.get_mut(term.output) {
                *longest = way.max(*longest);
                by_rows += COST * places + ACCELERATIONS * unknowns * felt;
            }
        }
        by_rows += unknowns * (ends + ways.into_iter().flatten().sum::<usize>());
        [by_rows, variables * (COST * costs + unknowns * (all + ACCELERATIONS * accelerations.min(all)))]
    }
}
