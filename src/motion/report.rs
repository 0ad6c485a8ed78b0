//! [`Report`]: the work and the warnings of a simulation or an adjoint sweep.

use std::fmt;

use crate::Warning;

/// The work and the accuracy of a simulation or an adjoint sweep.
///
/// It prints as a table without the rows that are zero:
///
/// ```
/// let report = hamiltonian_adjoint::Report { newton_iterations: 231, most_iterations: 3, restarts: 2, ..Default::default() };
/// let lines = ["       231  Newton iterations, at most 3 in one step", "         2  restarts"];
/// assert_eq!(report.to_string().lines().take(2).collect::<Vec<_>>(), lines);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of Newton iterations of all steps.
    pub newton_iterations: usize,
    /// Largest number of Newton iterations of one step.
    pub most_iterations: usize,
    /// Number of factorisations of tangent matrices.
    pub factorisations: usize,
    /// Number of Newton corrections with the factors of the previous iteration, used when they already suffice for convergence.
    pub reused_factors: usize,
    /// Number of adjoint solves with iterative refinement: one in 128, and all if these show lost digits (adjoint sweep only).
    pub refined_solutions: usize,
    /// Number of element evaluations, each element counted separately; elements that are constant or sums of sines are not counted.
    pub element_evaluations: usize,
    /// Number of evaluations of second derivatives of the elements counted in `element_evaluations`: whenever the tangent matrix K is assembled, and
    /// at each solution.
    pub second_derivatives: usize,
    /// Number of evaluations of sine and cosine of a coordinate for sinusoidal constraints.
    pub sine_evaluations: usize,
    /// Number of derivative evaluations with respect to one control, one design variable or time, each element counted separately.
    pub input_evaluations: usize,
    /// Number of element evaluations in the check that the steps resolve the elements (adjoint sweep only).
    pub chord_evaluations: usize,
    /// Number of evaluations of single costs with their derivatives.
    pub cost_evaluations: usize,
    /// Smallest ratio of a pivot to the terms of which it is the difference; about 1e-16 means that all digits are lost.
    pub worst_pivot: f64,
    /// Largest growth of (dJ/dq, dJ/dp*) in the backward sweep relative to the contributions of the costs, sampled at some nodes (adjoint
    /// sweep only).
    pub adjoint_growth: f64,
    /// Number of restarts.
    pub restarts: usize,
    /// Warnings of the run.
    pub warnings: Vec<Warning>,
}

impl Default for Report {
    fn default() -> Self {
        Report {
            newton_iterations: 0,
            most_iterations: 0,
            factorisations: 0,
            reused_factors: 0,
            refined_solutions: 0,
            element_evaluations: 0,
            second_derivatives: 0,
            sine_evaluations: 0,
            input_evaluations: 0,
            chord_evaluations: 0,
            cost_evaluations: 0,
            worst_pivot: 1.0,
            adjoint_growth: 1.0,
            restarts: 0,
            warnings: Vec::new(),
        }
    }
}

impl Report {
    /// The total work of several sweeps.
    pub(crate) fn of_all(mut reports: impl Iterator<Item = Report>) -> Report {
        let mut sum = reports.next().unwrap_or_default();
        reports.for_each(|report| sum.add(report));
        sum
    }

    fn add(&mut self, other: Report) {
        self.newton_iterations += other.newton_iterations;
        self.most_iterations = self.most_iterations.max(other.most_iterations);
        self.factorisations += other.factorisations;
        self.reused_factors += other.reused_factors;
        self.refined_solutions += other.refined_solutions;
        self.element_evaluations += other.element_evaluations;
        self.second_derivatives += other.second_derivatives;
        self.sine_evaluations += other.sine_evaluations;
        self.input_evaluations += other.input_evaluations;
        self.chord_evaluations += other.chord_evaluations;
        self.cost_evaluations += other.cost_evaluations;
        self.worst_pivot = self.worst_pivot.min(other.worst_pivot);
        self.adjoint_growth = self.adjoint_growth.max(other.adjoint_growth);
        self.restarts += other.restarts;
        other.warnings.into_iter().for_each(|warning| self.warn(warning));
    }

    /// Adds a warning and removes earlier ones of this kind.
    pub(crate) fn replace(&mut self, warning: Warning) {
        let kind = std::mem::discriminant(&warning);
        self.warnings.retain(|other| std::mem::discriminant(other) != kind);
        self.warnings.push(warning);
    }

    /// Adds a warning unless the report already contains it.
    pub(crate) fn warn(&mut self, warning: Warning) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let counts = [
            (self.factorisations, "factorisations of tangent matrices"),
            (self.reused_factors, "corrections with factors of the previous iteration"),
            (self.refined_solutions, "refined solutions of adjoint equations"),
            (self.element_evaluations, "evaluations of elements"),
            (self.second_derivatives, "evaluations of second derivatives of elements"),
            (self.sine_evaluations, "sines and cosines of coordinates"),
            (self.input_evaluations, "derivatives of elements with respect to inputs"),
            (self.chord_evaluations, "evaluations of elements along steps"),
            (self.cost_evaluations, "evaluations of costs"),
            (self.restarts, "restarts"),
        ];
        if self.newton_iterations > 0 {
            writeln!(f, "{:>10}  Newton iterations, at most {} in one step", self.newton_iterations, self.most_iterations)?;
        }
        let mut done = counts.iter().filter(|(count, _)| *count > 0);
        done.try_for_each(|(count, what)| writeln!(f, "{count:>10}  {what}"))?;
        write!(f, "{:>10.1e}  smallest pivot relative to its terms", self.worst_pivot)?;
        if self.adjoint_growth > 1.0 {
            write!(
                f,
                "\n{:>10.1e}  largest growth of adjoint variables relative to the contributions of costs",
                self.adjoint_growth
            )?;
        }
        self.warnings.iter().try_for_each(|warning| write!(f, "\nwarning: {warning}"))
    }
}
