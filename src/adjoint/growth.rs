//! Growth of the adjoint variables in the backward sweep, by which rounding errors grow too.
//!
//! (a, b) = −(dJ/dq, dJ/dp*) are compared with the contributions of the costs so far, which are their partial derivatives. With masses m for the
//! pivots of K(0), and T for the duration of the motion, all sizes have the same unit, J/√J:
//!
//! ```text
//!   |b| √m,   |a| T/√m        J_q T/√m,   J_v/√m,   J_p* √m,   J_ṗ* √m/Δt,   J_σ/√(1/m)
//! ```
//!
//! In free flight the sizes are constant; if a cost is small because its aim is reached, both sizes are small.

use crate::Warning;
use crate::motion::{Motion, Report};
use crate::node::UnitWeights;
use crate::system::CostRows;

#[derive(Default)]
pub(crate) struct Growth {
    /// T, s.
    duration: f64,
    /// Sum of the contributions of the costs.
    source: f64,
    most: f64,
}

impl Growth {
    /// Nodes whose numbers are multiples of this are checked.
    pub(crate) const LOOK_EVERY: usize = 64;

    pub(crate) fn begin(&mut self, motion: &Motion) {
        let last = motion.trajectory.times[motion.trajectory.last()];
        *self = Growth { duration: (last - motion.inputs.grid.start).abs(), source: 0.0, most: 1.0 };
    }

    /// Adds the contributions of the costs of a node, at the last node and at checked nodes, which represent the nodes between them.
    pub(crate) fn add_source(&mut self, motion: &Motion, weights: &UnitWeights, cost: &CostRows, node: usize) {
        let steps = &motion.inputs.grid.steps;
        let is_last = node == steps.len();
        if !is_last && !node.is_multiple_of(Self::LOOK_EVERY) {
            return;
        }
        let step = steps[..node.max(1).min(steps.len())].iter().rev().find(|dt| **dt != 0.0).map_or(1.0, |dt| dt.abs());
        let of_rates = |rates: &[f64]| weights.of_velocities(rates.iter().copied());
        let sizes = [
            self.duration * weights.of_momenta(&cost.q),
            weights.of_momenta(&cost.v),
            of_rates(&cost.p_star),
            of_rates(&cost.p_star_dot) / step,
            weights.of_equations(&cost.sigma),
        ];
        let size = sizes.into_iter().fold(0.0, f64::max);
        self.source += if is_last { size } else { Self::LOOK_EVERY as f64 * size };
    }

    /// Compares a and b with the contributions of the costs.
    pub(crate) fn watch(&mut self, weights: &UnitWeights, (a, b): (&[f64], &[f64])) {
        let size = weights.of_velocities(b.iter().copied()).max(self.duration * weights.of_momenta(a));
        if self.source > 0.0 {
            self.most = self.most.max(size / self.source);
        }
    }

    pub(crate) fn tell(&self, report: &mut Report) {
        report.adjoint_growth = self.most;
        if self.most > Warning::GROWTH {
            report.warn(Warning::AdjointGrowth { factor: self.most });
        }
    }
}
