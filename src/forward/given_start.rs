//! Design variables b that a given start does not follow: ∂Φ/∂b ≠ 0 at q₀, so that q₀ violates constraints for another value of b.

use crate::system::{InputRows, NodeView};
use crate::{System, Warning};

/// The warning that dJ/db holds for the same q₀; `None` if constraints do not depend on b there.
pub(super) fn find(system: &System, at: &NodeView<f64>) -> Option<Warning> {
    if !system.placed().any(|item| item.is_set_by_design()) {
        return None;
    }
    let (mut elements, mut designs) = (Vec::new(), Vec::new());
    for item in system.placed().filter(|item| item.is_set_by_design()) {
        let (mut by_parameters, mut by_designs) = (vec![0.0; system.parameters().len()], vec![0.0; system.designs()]);
        // The weights differ, so that the equations of one element do not cancel.
        let weights = Vec::from_iter((0..system.m()).map(|j| 1.0 + 0.3 * (j as f64).sin()));
        let (mut u, mut time, mut evaluations) = (Vec::new(), 0.0, 0);
        let rows = &mut InputRows { u: &mut u, design: &mut by_parameters, time: &mut time, evaluations: &mut evaluations };
        item.pull_back_phi(at, &weights, rows);
        system.parameters().pull_back(&at.design[..system.designs()], &by_parameters, &mut by_designs);
        let moving = (0..by_designs.len()).filter(|&b| by_designs[b] != 0.0);
        let before = designs.len();
        designs.extend(moving.map(|b| system.design_name(b).to_string()));
        if designs.len() > before {
            elements.push(item.name.clone());
        }
    }
    designs.sort_unstable();
    designs.dedup();
    (!designs.is_empty()).then_some(Warning::GivenStart { designs, elements })
}
