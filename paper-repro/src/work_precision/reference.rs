//! Values computed independently of the library (`tests/data/README.md`): a cart with three links under a constant force.

use serde::Deserialize;

use crate::statistics::relative_difference;

/// The end of the motion, s.
pub const END: f64 = 2.0;
/// The constant force, N.
pub const FORCE: f64 = 10.0;

/// J and a gradient.
#[derive(Deserialize)]
pub struct Reference {
    #[serde(rename = "J")]
    pub cost: f64,
    #[serde(rename = "grad")]
    pub gradient: Vec<f64>,
}

impl Reference {
    /// The problem in continuous time, DOP853 with tolerances of 1e-12: dJ/dx for u piecewise linear on 101 knots with values x.
    pub fn continuous() -> Self {
        Self::read(include_str!("../../../tests/data/continuous_grad_cr0_const10.json"))
    }

    /// The trapezoidal rule with 100 steps in 128-bit floats: dJ/du at its 101 nodes.
    pub fn discrete() -> Self {
        Self::read(include_str!("../../../tests/data/truth_k3_cr0_const10.json"))
    }

    /// Reads one of the files that are part of the program.
    fn read(file: &str) -> Self {
        serde_json::from_str(file).expect("J and a gradient")
    }

    /// |ours − J|/|J|.
    pub fn cost_error(&self, ours: f64) -> f64 {
        ((ours - self.cost) / self.cost).abs()
    }

    /// ‖ours − dJ/dx‖∞/‖dJ/dx‖∞.
    pub fn gradient_error(&self, ours: &[f64]) -> f64 {
        relative_difference(ours, &self.gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_references_have_a_derivative_for_each_knot_and_differ_as_the_scheme_does() {
        let (continuous, discrete) = (Reference::continuous(), Reference::discrete());
        assert_eq!((continuous.gradient.len(), discrete.gradient.len()), (101, 101));
        // The trapezoidal rule with 100 steps.
        assert!((1e-5..1e-3).contains(&continuous.cost_error(discrete.cost)));
        assert!((1e-5..1e-2).contains(&continuous.gradient_error(&discrete.gradient)));
    }
}
