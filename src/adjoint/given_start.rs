//! Design variables b that a start which is given does not follow: ∂Φ/∂b ≠ 0 at q₀, so that with another value of b it would violate constraints.

use super::AdjointSweep;
use crate::forward::Motion;
use crate::system::InputRows;
use crate::{System, Warning};

impl AdjointSweep {
    /// Passes on what was found of formulas when the scene was compiled.
    pub(super) fn warn_of_lost_derivatives(&mut self, system: &System) {
        system.lost_derivatives().iter().for_each(|warning| self.report.warn(warning.clone()));
    }

    /// Says that dJ/db is that for the same q₀, where an assembled start would move.
    pub(super) fn warn_of_given_start(&mut self, system: &System, motion: &Motion) {
        if motion.assembly.is_some() || !system.placed().any(|item| item.is_set_by_design()) {
            return;
        }
        let (at, design) = (motion.at(0), motion.inputs.design.as_slice());
        // Different, so that the equations of one element do not cancel.
        let weights = Vec::from_iter((0..system.m()).map(|j| 1.0 + 0.3 * (j as f64).sin()));
        let (mut u, mut time, evaluations) = (vec![0.0; system.k()], 0.0, &mut self.report.input_evaluations);
        let (mut elements, mut designs) = (Vec::new(), Vec::new());
        for item in system.placed().filter(|item| item.is_set_by_design()) {
            let (mut by_parameters, mut by_designs) = (vec![0.0; system.parameters().len()], vec![0.0; design.len()]);
            let design_rows = by_parameters.as_mut_slice();
            item.pull_back_phi(
                &at,
                &weights,
                &mut InputRows { u: &mut u, design: design_rows, time: &mut time, evaluations },
            );
            system.parameters().pull_back(design, &by_parameters, &mut by_designs);
            let moving = (0..design.len()).filter(|&b| by_designs[b] != 0.0);
            let before = designs.len();
            designs.extend(moving.map(|b| system.design_name(b).to_string()));
            if designs.len() > before {
                elements.push(item.name.clone());
            }
        }
        if !designs.is_empty() {
            designs.sort_unstable();
            designs.dedup();
            self.report.warn(Warning::GivenStart { designs, elements });
        }
    }
}
