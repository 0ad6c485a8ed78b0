//! The dot-product identity of adjoint and tangent, at every node.
//!
//! a_i and b_i are the changes of J per unit of q_{i−1} and p*_{i−1}, and α_i and β_i per unit of v_{i−1} and ṗ*_{i−1}, through the step
//! into node i and with the sign of the Lagrangian; for the trapezoidal rule, α = h a and β = h b. The change of the cost from node i on
//! is therefore, by the tangent system on the left and by the adjoint on the right,
//!
//! ```text
//!   Σ_{j ≥ i} δℓ_j  =  −(a_i·δq + α_i·δv + b_i·δp* + β_i·δṗ*)_{i−1} + Σ_{j ≥ i} (dJ/du_j)·δu_j
//! ```
//!
//! for changes of controls and initial values. If the motion is restarted at the end of the macro step of node i, s_i·δσ₋ of the node
//! where this macro step began is added; if constraints have a compliance μ, μ e_i·δσ_{i−1} is added. The first node, counted from the
//! end, at which the identity fails is where the error is.

use num_dual::Dual64;

use super::subject::Subject;
use crate::accelerations::CostSum;
use crate::check::direct::moved;
use crate::motion::Refinement;
use crate::system::CostFactors;
use crate::{AdjointVariables, Error, Gradient, Inputs};

/// Error of the adjoint–tangent identity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Identity {
    /// Largest difference between the two sides of the identity, relative to the largest of their terms or to their rounding error
    /// ([`DirectionReport::floor`](super::DirectionReport)).
    pub worst: f64,
    /// The node of the largest difference.
    pub node: usize,
    /// The last node at which the two sides differ, if any: the error is in the contribution of this node to the backward sweep.
    pub first_wrong: Option<usize>,
}

/// Compares both sides at the nodes N … 1.
pub(super) fn identity(
    subject: &Subject,
    direction: &Inputs,
    (gradient, adjoint): (&Gradient, &AdjointVariables),
    (floor, tolerance): (f64, f64),
) -> Result<Identity, Error> {
    let &Subject { system, inputs, settings, which, .. } = subject;
    let mut solver = subject.lifted::<Dual64>()?;
    let inserted = solver.real().trajectory().inserted.clone();
    let taken = solver.real().inputs().clone();
    let refinement = Refinement::new((&taken.grid.steps, &taken.events), taken.grid.around, &inserted);
    // With inserted nodes or stages, the gradient is that of the given controls, not a sum over later nodes: controls are then fixed.
    let are_held = !inserted.is_empty() || settings.scheme.inner() > 0 || system.has_control_rates();
    let mut direction = direction.clone();
    if are_held {
        direction.controls.fill(0.0);
    }
    let moved = moved(inputs, &direction, Dual64::new)?;
    let motion = solver.simulate(&moved)?.clone();
    let moved = solver.inputs();
    let design = system.parameters().values(moved.design.as_slice());
    let dot = |x: nalgebra::DVectorView<f64>, y: nalgebra::DVectorView<Dual64>| {
        x.iter().zip(y.iter()).map(|(x, y)| x * y.eps).sum::<f64>()
    };
    let (mut by_tangent, mut of_controls) = (0.0, 0.0);
    let mut sides: Vec<(usize, f64, f64, f64)> = Vec::new();
    let mut costs = CostSum::new(&refinement, CostFactors::of_one(which, system.outputs()));
    for i in (1..taken.grid.nodes()).rev() {
        // All other costs have the factor 0.
        motion.costs_of_step(system, (moved, &design), &mut costs, (i, i), &mut |_, term: Dual64| by_tangent += term.eps)?;
        if !are_held {
            of_controls += gradient.controls.column(i).dot(&direction.controls.column(i));
        }
        let of_state = [
            (&adjoint.a, &motion.q),
            (&adjoint.alpha, &motion.v),
            (&adjoint.b, &motion.p_star),
            (&adjoint.beta, &motion.p_star_dot),
        ];
        let of_state = of_state.map(|(adjoint, motion)| dot(adjoint.column(i), motion.column(i - 1)));
        let is_end =
            |&node: &usize| refinement.given_node(node).is_some_and(|given| taken.grid.macro_steps(given).is_some());
        let end = (0..i).rev().find(is_end).unwrap_or(0);
        let sigma = motion.sigma.column(i - 1);
        let compliant = motion.compliance_into(i).iter().map(|&(j, mu)| mu * adjoint.e[(j, i)] * sigma[j].eps).sum::<f64>();
        let of_sigma = dot(adjoint.s.column(i), motion.sigma.column(end)) + compliant;
        let by_adjoint = of_controls + of_sigma - of_state.iter().sum::<f64>();
        let size = of_state.iter().chain([&of_controls, &of_sigma]).fold(by_tangent.abs(), |m, x| m.max(x.abs()));
        sides.push((i, by_tangent, by_adjoint, size));
    }
    let largest = sides.iter().fold(floor, |m, side| m.max(side.3));
    let errors: Vec<(usize, f64)> =
        sides.iter().map(|(i, a, b, _)| (*i, if a == b { 0.0 } else { (a - b).abs() / largest })).collect();
    let (node, worst) = errors.iter().copied().fold((0, 0.0), |m, x| if x.1 > m.1 { x } else { m });
    let first_wrong = errors.iter().find(|(_, error)| error.is_nan() || *error > tolerance).map(|(i, _)| *i);
    Ok(Identity { worst, node, first_wrong })
}

#[cfg(test)]
mod tests {
    use super::super::directions::{Part, random};
    use super::super::watch::Watch;
    use super::*;
    use crate::number::Random;
    use crate::{Grid, Settings, Solver, scenes::CartPendulum};

    #[test]
    fn the_wrong_node_nearest_to_the_end_is_found() {
        let system = CartPendulum::with_links(1).scene().compile().unwrap();
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
        inputs.controls.fill(10.0);
        let free = f64::INFINITY;
        let settings =
            Settings { keep_adjoint: true, position_tolerance: free, velocity_tolerance: free, ..Settings::default() };
        let mut solver = Solver::new(&system, settings);
        solver.simulate(&inputs).unwrap();
        let gradient = solver.gradient().unwrap().clone();
        let direction = random(&inputs, &[Part::Controls, Part::Coordinates, Part::Rates], &mut Random::new(1));
        let adjoint = solver.adjoint_variables().unwrap();
        let found = |adjoint: &AdjointVariables| {
            let subject = Subject { system: &system, inputs: &inputs, settings, which: 0, watch: Watch::default() };
            identity(&subject, &direction, (&gradient, adjoint), (0.0, 1e-9)).unwrap().first_wrong
        };
        assert_eq!(found(adjoint), None);
        let size = adjoint.a.amax();
        for error in [1e-6 * size, f64::NAN] {
            let mut wrong = adjoint.clone();
            wrong.a[(0, 5)] += error;
            wrong.a[(0, 12)] += error;
            assert_eq!(found(&wrong), Some(12));
        }
    }
}
