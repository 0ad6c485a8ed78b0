//! Results of a method.

use hamiltonian_adjoint::Inputs;
use hamiltonian_adjoint::optimize::Outcome;
use serde_json::{Value, json};

use super::problems::{Name, Posed};
use crate::plot::Point;

/// Result of a run.
pub struct Run {
    pub name: Name,
    pub method: &'static str,
    pub outcome: Outcome,
    pub milliseconds: f64,
    /// The motion found, if the problem has one.
    pub found: Option<Found>,
}

/// The best motion of a run, with the inputs at each iteration.
pub struct Found {
    pub posed: Posed,
    pub inputs: Inputs,
    pub iterates: Vec<Inputs>,
}

impl Found {
    /// The control over time.
    pub fn control(&self, inputs: &Inputs) -> Vec<Point> {
        inputs.grid.times().into_iter().zip(inputs.controls.row(self.posed.control.index()).iter().copied()).collect()
    }
}

/// A value with significant digits even if it is small.
fn digits(value: f64) -> String {
    if value.abs() < 1e-3 { format!("{value:.3e}") } else { format!("{value:.6}") }
}

impl Run {
    pub fn cells(&self, gradient: f64) -> Vec<String> {
        let outcome = &self.outcome;
        vec![
            self.name.text(),
            self.method.to_owned(),
            outcome.iterations.to_string(),
            outcome.evaluations.to_string(),
            outcome.gradients.to_string(),
            outcome.products.to_string(),
            format!("{:.2}", self.milliseconds),
            format!("{:.0}", 1e-3 * self.milliseconds / gradient),
            digits(outcome.value),
            // The residuals of a fit are not violations.
            if self.name == Name::Identify { "–".to_owned() } else { format!("{:.0e}", outcome.violation) },
            format!("{:?}", outcome.reason),
        ]
    }

    pub fn record(&self) -> Value {
        let outcome = &self.outcome;
        json!({
            "problem": self.name.text(),
            "method": self.method,
            "iterations": outcome.iterations,
            "simulations": outcome.evaluations,
            "gradients": outcome.gradients,
            "products": outcome.products,
            "milliseconds": self.milliseconds,
            "value": outcome.value,
            "violation": outcome.violation,
            "converged": outcome.reason.is_converged(),
            "reason": format!("{:?}", outcome.reason),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_values_keep_their_digits() {
        assert_eq!([0.0, 9.4321e-8, 15.18].map(digits), ["0.000e0", "9.432e-8", "15.180000"]);
    }
}
