//! Constant second derivatives of elements, and the coefficients of their sines.

use std::f64::consts::FRAC_PI_2;

use super::constants::Constants;
use super::sinusoidal_constraints::SinusoidalTerm;
use crate::system::formula::{Block, Element, ElementKind, Entry, Place, Slot};

impl Element {
    /// Adds the constant second derivatives and the coefficients of the sinusoidal terms.
    pub fn add_constants(&self, parameters: &[f64], into: &mut Constants) {
        let Some(kernels) = &self.formula.kernels else { return };
        let none = |_| 0.0;
        for (entry, value) in self.formula.fixed.iter().zip(kernels.fixed.evaluate(parameters, none)) {
            into.add(entry, self.row_and_col(entry), value);
        }
        if self.formula.constant && self.kind() != ElementKind::Holonomic {
            let values = kernels.at_zero.evaluate(parameters, none);
            let n = self.to.q.len();
            into.add_first(&self.to.q, &values[..n], &values[n..2 * n]);
            for (k, value) in values[2 * n..].iter().enumerate() {
                into.add_control(self.to.q[k / self.to.u.len()], self.to.u[k % self.to.u.len()], *value);
            }
        }
        if self.formula.sinusoidal {
            self.add_waves(parameters, into);
        }
    }

    /// Computes a, α, β of a q + α sin q + β cos q from its slopes a + α cos q − β sin q at q = 0, π/2 and π.
    fn add_waves(&self, parameters: &[f64], into: &mut Constants) {
        let Some(kernels) = &self.formula.kernels else { return };
        let slopes = [0.0, FRAC_PI_2, 2.0 * FRAC_PI_2].map(|angle| {
            let is_angle = |which| matches!(self.formula.shape.place(which), Place::Of(Slot::Q(_)));
            kernels.at_state(parameters, |which| if is_angle(which) { angle } else { 0.0 }).1
        });
        // Each of these slopes depends on one coordinate, so none is relative to another.
        let varying = self.formula.varying.iter().map(|relative| &relative.entry);
        for (k, entry) in varying.enumerate().filter(|(_, entry)| entry.block == Block::PhiQ) {
            let [at_0, at_90, at_180] = slopes.each_ref().map(|slopes| slopes[k]);
            // π is not exact in binary, so a coefficient that should be zero is left with a rounding error.
            let rounding = 4.0 * f64::EPSILON * at_0.abs().max(at_90.abs()).max(at_180.abs());
            let clean = |x: f64| if x.abs() <= rounding { 0.0 } else { x };
            let linear = clean(0.5 * (at_0 + at_180));
            let (sine, cosine) = (clean(0.5 * (at_0 - at_180)), clean(linear - at_90));
            let [equation, coordinate] = self.row_and_col(entry);
            into.waves.push(SinusoidalTerm { coordinate, equation, sine, cosine });
            into.add_phi_q(Entry { row: equation, col: coordinate, value: linear });
        }
    }
}
