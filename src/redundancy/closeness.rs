//! 1/θ, the closeness of a node to a configuration at which branches of Φ = 0 cross.

use super::dependent::Dependent;
use crate::System;
use crate::node::{Linearisation, warn_of_lost_digits};
use crate::system::Pair;

/// Above this value of 1/θ there are no restarts: ε/θ² = 2e-4.
pub(crate) const UNDETERMINED: f64 = 1e6;

impl Dependent<'_> {
    /// Factors K(0) at the end of a step and returns 1/θ, which shows whether p* determines v there to sufficient digits.
    ///
    /// At a distance θ from a configuration at which branches of Φ = 0 cross, such as a flat parallelogram, rounding ε of Φ moves q by ε/θ, and turns
    /// the admissible directions of motion by ε/θ². 1/θ is computed as the velocities that violations of dΦ/dt by one unit each cause, in units in
    /// which they are about one at the start.
    pub(crate) fn closeness(&mut self, node: usize) -> f64 {
        let Dependent { system, motion, linearisation, report, point, .. } = self;
        let worst = report.worst_pivot;
        if let Err(breakdown) = linearisation.factor(system, 0.0, motion.node_blocks(node), report) {
            // Values that are not finite cause an error of the restart.
            return if breakdown.pivot.is_finite() { f64::INFINITY } else { 0.0 };
        }
        warn_of_lost_digits(system, motion, linearisation, report, (node, worst));
        closeness_here(linearisation, system, &mut point.left)
    }
}

/// Computes 1/θ with the current factors.
pub(super) fn closeness_here(linearisation: &mut Linearisation, system: &System, left: &mut Pair) -> f64 {
    left.v.fill(0.0);
    for (j, (violation, weight)) in left.sigma.iter_mut().zip(linearisation.weights.multipliers()).enumerate() {
        // An arbitrary combination of all equations.
        *violation = weight * (1.0 + 0.3 * (j as f64).sin());
    }
    linearisation.solve(system, left);
    linearisation.size_of(&left.v)
}
