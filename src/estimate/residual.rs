//! [`Residual`]: the error of J by the residuals of the steps of the trapezoidal rule.
//!
//! Polynomials of third degree through four nodes are integrated over a step. They differ from what the rule adds by
//!
//! ```text
//!   τ_q = ∫ v dt − (q_n − q_{n−1}),    τ_p = ∫ ṗ* dt − (p*_n − p*_{n−1}),    τ_h = ∫ h dt − Δt (h_{n−1} + h_n)/2
//!   J of the continuous motion − J ≈ Σ −(a_nᵀ τ_q + b_nᵀ τ_p) + τ_h
//! ```
//!
//! because a_n and b_n are the derivatives of −J by perturbations of the step's equations E1 and E2.

use nalgebra::{DMatrix, Matrix4, Vector4};

use crate::accelerations::CostSum;
use crate::motion::column;
use crate::number::dot;
use crate::system::{CostFactors, Weights};
use crate::{Error, Solver, Trajectory};

/// The residuals of all steps, weighted with the adjoint variables.
pub(super) struct Residual {
    steps: Vec<f64>,
}

impl Residual {
    /// The residuals of the last motion and gradient; `None` if they are not those of plain steps of the trapezoidal rule.
    pub(super) fn new(solver: &Solver) -> Result<Option<Self>, Error> {
        let motion = solver.trajectory();
        let Some(adjoint) = solver.adjoint_variables() else { return Ok(None) };
        let is_plain = motion.scheme.is_trapezoidal() && motion.inserted.is_empty() && motion.restarted.is_empty();
        if !is_plain || motion.times.len() < 4 {
            return Ok(None);
        }
        let integrand = integrand(solver, motion)?;
        let of_step = |n: usize| {
            let (first, weights) = weights(&motion.times, n)?;
            let between = |list: &[f64]| weights.iter().zip(list).map(|(w, x)| w * x).sum::<f64>();
            let row = |matrix: &DMatrix<f64>, k: usize| std::array::from_fn(|i| matrix[(k, first + i)]);
            let residual = |rates: &DMatrix<f64>, states: &DMatrix<f64>| {
                let of = |k: usize| between(&row(rates, k) as &[f64; 4]) - (states[(k, n)] - states[(k, n - 1)]);
                (0..states.nrows()).map(of).collect::<Vec<f64>>()
            };
            let (of_q, of_p) = (residual(&motion.v, &motion.q), residual(&motion.p_star_dot, &motion.p_star));
            let half = 0.5 * (motion.times[n] - motion.times[n - 1]);
            let of_cost = between(&integrand[first..first + 4]) - half * (integrand[n - 1] + integrand[n]);
            Some(of_cost - dot(column(&adjoint.a, n), &of_q) - dot(column(&adjoint.b, n), &of_p))
        };
        Ok((1..motion.times.len()).map(of_step).collect::<Option<_>>().map(|steps| Residual { steps }))
    }

    pub(super) fn sum(&self) -> f64 {
        self.steps.iter().sum()
    }

    /// The shortest interval of time with more than half of all residuals, and its share; `None` if there are none.
    pub(super) fn largest(&self, times: &[f64]) -> Option<(f64, f64, f64)> {
        let total: f64 = self.steps.iter().map(|x| x.abs()).sum();
        let (mut from, mut sum, mut best) = (0, 0.0, None::<(usize, usize, f64)>);
        for (to, residual) in self.steps.iter().enumerate() {
            sum += residual.abs();
            while from <= to && sum - self.steps[from].abs() > 0.5 * total {
                sum -= self.steps[from].abs();
                from += 1;
            }
            let length = |from: usize, to: usize| times[to + 1] - times[from];
            if sum > 0.5 * total && best.is_none_or(|(first, last, _)| length(from, to) < length(first, last)) {
                best = Some((from, to, sum / total));
            }
        }
        best.map(|(from, to, share)| (times[from], times[to + 1], share))
    }
}

/// h at every node: the sum of the costs that are integrated.
fn integrand(solver: &Solver, motion: &Trajectory) -> Result<Vec<f64>, Error> {
    let (system, inputs) = (solver.system(), solver.inputs());
    let refinement = motion.refinement(inputs)?;
    let mut sums = CostSum::new(&refinement, CostFactors::of_cost(system.outputs()));
    let design = system.parameters().values(inputs.design.as_slice());
    let of_node = |node: usize| {
        let at = motion.columns(node).with_inputs((inputs.controls_at(node), &design));
        let mut h = 0.0;
        let place = (node, motion.compliance_from(node));
        sums.add(system, (&at, place), &Weights::of_integrands(), &mut |_, x| h += x).map(|()| h)
    };
    (0..motion.times.len()).map(of_node).collect()
}

/// The first of four nodes around the step that ends at a node, and the weights of their values in the integral over the step of the polynomial through
/// them; `None` if there are fewer than four between steps of length zero.
fn weights(times: &[f64], n: usize) -> Option<(usize, [f64; 4])> {
    let (start, length) = (times[n - 1], times[n] - times[n - 1]);
    if length == 0.0 {
        return Some((0, [0.0; 4]));
    }
    let is_smooth = |first: &usize| {
        let four = times.get(*first..first + 4);
        four.is_some_and(|four| four.windows(2).all(|pair| pair[0] != pair[1]))
    };
    let first = [2, 1, 3].into_iter().filter_map(|before| n.checked_sub(before)).find(is_smooth)?;
    let place = |i: usize| (times[first + i] - start) / length;
    let powers = Matrix4::from_fn(|power, i| place(i).powi(power as i32));
    let integrals = Vector4::from_fn(|power, _| length / (1.0 + power as f64));
    Some((first, powers.lu().solve(&integrals).map_or([0.0; 4], Into::into)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_third_degree_are_integrated_exactly() {
        let times = [0.0, 0.1, 0.25, 0.3, 0.5, 0.9];
        let (f, primitive) =
            (|t: f64| 1.0 - t + 3.0 * t * t - 4.0 * t.powi(3), |t: f64| t - t * t / 2.0 + t.powi(3) - t.powi(4));
        for n in 1..times.len() {
            let (first, weights) = weights(&times, n).expect("four nodes");
            let sum: f64 = weights.iter().enumerate().map(|(i, w)| w * f(times[first + i])).sum();
            assert!((sum - (primitive(times[n]) - primitive(times[n - 1]))).abs() < 1e-14, "{n}");
        }
    }

    #[test]
    fn the_largest_residuals_are_found() {
        let residual = Residual { steps: vec![0.1, -0.1, 2.0, -3.0, 0.1, 0.2] };
        let times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let (from, to, share) = residual.largest(&times).expect("residuals");
        assert_eq!((from, to), (3.0, 4.0));
        assert!((share - 3.0 / 5.5).abs() < 1e-15);
        assert_eq!(Residual { steps: vec![0.0; 6] }.largest(&times), None);
    }
}
