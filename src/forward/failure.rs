//! Explains why a step has no solution, with the name of the cause.

use super::ForwardSweep;
use crate::motion::column;
use crate::node::StepFailure;
use crate::redundancy::near_singular;
use crate::system::{NodeView, Sums};
use crate::{Error, Start, System};

/// Values of an iterate above this are not arguments of a mechanism: their cubes overflow.
const RAN_AWAY: f64 = 1e100;

impl ForwardSweep {
    /// True if a formula is the cause, which a shorter step would not change.
    pub(super) fn model_fault(&self, system: &System, node: usize, failure: &StepFailure) -> bool {
        let overflows = match failure {
            StepFailure::NotFinite => true,
            StepFailure::Singular(breakdown) => !breakdown.pivot.is_finite(),
            _ => false,
        };
        overflows && self.find_not_finite(system, node, 0.0).is_some()
    }

    pub(crate) fn explain(&self, system: &System, node: usize, failure: StepFailure) -> Error {
        let (step, time, length) = (self.motion.step_of_whole(node), self.motion.time(node), self.motion.length(node));
        match failure {
            StepFailure::Singular(breakdown) if !breakdown.pivot.is_finite() => self.not_finite(system, node),
            StepFailure::NotFinite => self.not_finite(system, node),
            StepFailure::Singular(breakdown) => {
                self.near_singular(system, node).unwrap_or_else(|| system.singular_step(&breakdown, step, time))
            }
            StepFailure::Diverged { iterations, residual, unknown, jump } => {
                self.near_singular(system, node).unwrap_or_else(|| {
                    let (equation, driven) = (system.residual_name(unknown), self.driven(system, node));
                    Error::Newton { step, time, iterations, length, residual, equation, driven, jump }
                })
            }
            StepFailure::LinearEnergy { coordinate, momentum } => {
                Error::LinearEnergy { coordinate: system.coordinate_name(coordinate).into(), momentum, step, time }
            }
            StepFailure::Projection { iterations, correction } => {
                self.near_singular(system, node).unwrap_or(Error::Projection { step, time, iterations, correction })
            }
        }
    }

    /// Error if the constraints nearly lose rank at the last computed node.
    fn near_singular(&self, system: &System, node: usize) -> Option<Error> {
        let at = self.motion.at(node.checked_sub(1)?);
        near_singular(system, &at, self.motion.step_of_whole(node), self.driven(system, node))
    }

    /// The constraint equations that depend on time at the end of the step, Φ_t ≠ 0, at the coordinates of the last computed node.
    fn driven(&self, system: &System, node: usize) -> Vec<String> {
        let (last, mut sums) = (self.motion.at(node.saturating_sub(1)), Sums::new(system.n(), system.m()));
        let still = vec![0.0; system.n()];
        system.plain_sums(&NodeView { v: &still, t: self.motion.time(node), ..last }, &mut sums);
        let depends = |j: &usize| sums.phi_dot()[*j].abs() > 0.0;
        (0..system.m()).filter(depends).map(|j| system.equation_name(j).to_string()).collect()
    }

    /// v₀ as given, or zero.
    fn given_velocity(&self) -> Vec<f64> {
        match &self.motion.inputs.start {
            Start::Velocity { v, .. } | Start::Assembled { v, .. } => v.as_slice().to_vec(),
            Start::Momentum { p_star, .. } => vec![0.0; p_star.len()],
        }
    }

    /// The element that is not finite at the last computed node, or `ahead` seconds later at constant velocities.
    fn find_not_finite(&self, system: &System, node: usize, ahead: f64) -> Option<Error> {
        let last = self.motion.at(node.saturating_sub(1));
        let u = column(&self.motion.inputs.controls, node);
        if node == 0 {
            // The v₀ and σ₀ of the failed iteration may be NaN.
            let (v, sigma) = (self.given_velocity(), vec![0.0; last.sigma.len()]);
            return system.find_not_finite(&NodeView { q: &self.stepper.start_q, v: &v, sigma: &sigma, u, ..last }, 0);
        }
        let q: Vec<f64> = last.q.iter().zip(last.v).map(|(q, v)| q + ahead * v).collect();
        let at = NodeView { q: &q, u, t: self.motion.time(node), ..last };
        system.find_not_finite(&at, self.motion.node_of_whole(node))
    }

    /// The element that is not finite where the iteration failed.
    fn find_not_finite_iterate(&self, system: &System, node: usize) -> Option<Error> {
        let x = self.stepper.newton.linearisation.iterate(system);
        let h = self.stepper.half_step(&self.motion.trajectory.scheme, self.motion.length(node));
        let q: Vec<f64> = self.stepper.start_q.iter().zip(&x.v).map(|(q, v)| q + h * v).collect();
        // A diverged iterate does not show that a formula fails.
        let is_point = [&q, &x.v, &x.sigma].into_iter().flatten().all(|x| x.abs() < RAN_AWAY);
        let stage = self.motion.at_stage(node, self.stepper.stage);
        let at = NodeView { q: &q, v: &x.v, sigma: &x.sigma, ..stage };
        is_point.then(|| system.find_not_finite(&at, self.motion.node_of_whole(node))).flatten()
    }

    /// The error for a value that is not finite, with the element that causes it.
    fn not_finite(&self, system: &System, node: usize) -> Error {
        let (step, time, length) = (self.motion.step_of_whole(node), self.motion.time(node), self.motion.length(node));
        // At node 0 there is no step, and `ahead` is zero.
        let ahead = [0.0, self.motion.given_length(node)];
        let found = ahead.into_iter().find_map(|ahead| self.find_not_finite(system, node, ahead));
        found.or_else(|| self.find_not_finite_iterate(system, node)).unwrap_or_else(|| Error::Newton {
            step,
            time,
            iterations: self.monitor.report.most_iterations,
            length,
            residual: f64::INFINITY,
            equation: "all equations (the iteration overflowed)".into(),
            driven: self.driven(system, node),
            jump: None,
        })
    }
}
