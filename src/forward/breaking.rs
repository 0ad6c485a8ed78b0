//! Design variables b that break a dependence of constraints.
//!
//! ```text
//!   zᵀ Φ_q = 0:     Φ(q + δq, b + δb) = 0 for some δq only if zᵀ ∂Φ/∂b δb = 0
//! ```

use crate::System;
use crate::system::{InputRows, NodeView};

/// What is left of zᵀ ∂Φ/∂b below this part of its terms is rounding, and that of z.
const ROUNDING: f64 = 1e-4;

/// The design variables of which zᵀ ∂Φ/∂b does not vanish, for a z with zᵀ Φ_q = 0.
pub(super) fn designs(system: &System, at: &NodeView<f64>, z: &[f64]) -> Vec<usize> {
    // The same terms with other weights, so that they do not cancel.
    let weighted: Vec<f64> = z.iter().enumerate().map(|(j, z)| z * (1.0 + 0.9 * (j as f64 + 0.5).sin())).collect();
    let [sums, terms] = [z, &weighted].map(|z| by_designs(system, at, z));
    (0..system.designs()).filter(|&b| sums[b].abs() > ROUNDING * terms[b].abs()).collect()
}

/// zᵀ ∂Φ/∂b.
fn by_designs(system: &System, at: &NodeView<f64>, z: &[f64]) -> Vec<f64> {
    let (mut u, mut design, mut time, mut evaluations) = (vec![0.0; system.k()], vec![0.0; system.designs()], 0.0, 0);
    let mut rows = InputRows { u: &mut u, design: &mut design, time: &mut time, evaluations: &mut evaluations };
    system.placed().for_each(|item| item.pull_back_phi(at, z, &mut rows));
    design
}
