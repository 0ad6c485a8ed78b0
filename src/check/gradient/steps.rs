//! What derivatives by step lengths are the sums of: where a mechanism rests under its weight they cancel, and leave rounding.
//!
//! ```text
//!   dJ/dΔt_i = −½ (a·(v₋ + v) + b·(ṗ*₋ + ṗ*)) + …      |b·ṗ*| ≤ ‖b‖ ‖ṗ*‖ with Σ m b² and Σ ṗ*²/m, where units do not matter; |a·v| alike
//! ```

use crate::forward::redundancy::masses;
use crate::{Solver, System};

/// For each given step, how large the terms of its derivative may be: what a, b, v and ṗ* are rounded to changes dJ by 1e-16 of that.
pub(super) fn sizes_of_terms(system: &System, solver: &mut Solver) -> Vec<f64> {
    let masses = masses(&solver.forward_mut().stepper.newton, system);
    let (motion, refinement) = (solver.trajectory(), solver.refinement());
    let taken = solver.inputs().grid.steps.len();
    let mut sizes = vec![0.0; taken - motion.inserted.len()];
    let Some(adjoint) = solver.adjoint_variables() else { return sizes };
    let norm = |x: nalgebra::DVectorView<f64>, power: i32| {
        let terms = x.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0).map(|(x, mass)| x * x * mass.powi(power));
        terms.sum::<f64>().sqrt()
    };
    for node in 1..=taken {
        let both = |x: &nalgebra::DMatrix<f64>, power| 0.5 * (norm(x.column(node - 1), power) + norm(x.column(node), power));
        let of_a = norm(adjoint.a.column(node), -1) * both(&motion.v, 1);
        let of_b = norm(adjoint.b.column(node), 1) * both(&motion.p_star_dot, -1);
        sizes[refinement.given_step(node) - 1] += of_a + of_b;
    }
    sizes
}
