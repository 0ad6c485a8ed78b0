//! Results of a gradient check.

use super::super::report::{BlockReport, Verdict, outcome};
use super::taylor::ENOUGH;
use super::{Identity, Taylor};

/// Allowed error of the differences, in addition to their own error estimate.
pub(super) const DIFFERENCED: f64 = 1e-6;
/// Safety factor on the error estimate of the differences, which may be too small.
pub(super) const CAUTION: f64 = 30.0;

/// The derivative along one direction, computed in four ways.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DirectionReport {
    /// The inputs that change.
    pub name: String,
    /// g·d with the gradient g of the discrete adjoint.
    pub adjoint: f64,
    /// The derivative by the tangent system.
    pub direct: f64,
    /// The derivative by complex step through the whole simulation.
    pub complex_step: f64,
    /// The derivative by differences with Ridders' extrapolation.
    pub differences: f64,
    /// Estimated error of the differences.
    pub differences_error: f64,
    /// Scale of the errors: √Σ (g_j d_j)².
    pub size: f64,
    /// Smallest scale of the errors, from three contributions. The first is 1e-6 |J| + 1e-4 |d²J|: dJ is known at best to the rounding
    /// error of J and, at an optimum, to the effect of the rounding errors of the motion. The second is 1e-4 of the terms of dJ/dΔt, which
    /// cancel for a mechanism at rest, and of dJ/db, which cancel if a mass scales inertia and weight alike. The third is 1e-6 of the largest row, or 1e-3 of the largest single input.
    pub floor: f64,
    /// True if dJ, at these inputs or at inputs nearby, is larger than the tolerated error; otherwise every value would pass.
    pub is_seen: bool,
    /// The verdict; "nothing compared" if the rounding of J hides dJ.
    pub verdict: Verdict,
}

/// Report of a check of a gradient.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct GradientReport {
    /// The checked function: J or an output.
    pub of: String,
    /// Value of the checked function.
    pub value: f64,
    /// The random directions.
    pub directions: Vec<DirectionReport>,
    /// Number of single inputs compared.
    pub singles: usize,
    /// The single inputs with the largest errors.
    pub worst_singles: Vec<DirectionReport>,
    /// The Taylor remainder test, in all inputs together.
    pub taylor: Taylor,
    /// The dot-product identity, in controls and initial values; `None` for motions with located events.
    pub identity: Option<Identity>,
    /// Rounding of direct differentiation and complex step along the random directions, relative to the unknowns of a step (see
    /// [`LiftedSolver::rounding`](crate::LiftedSolver::rounding)): about 1e-14, more if tangent matrices are nearly singular or springs are
    /// stiff.
    pub rounding: f64,
    /// Warnings of the motion and its gradient ([`Report::warnings`](crate::Report::warnings)), as text.
    pub warnings: Vec<String>,
    /// Whether the gradient has [`Warning::GridPhase`](crate::Warning::GridPhase): it belongs to this grid, and not to the continuous motion.
    pub has_kinks: bool,
    /// The estimated error that the grid causes, in words ([`estimate`](crate::estimate())); empty for an output, or if it cannot be estimated.
    pub grid: String,
    /// The user's gradients.
    pub own: Vec<BlockReport>,
}

impl DirectionReport {
    /// Creates the report; `sizes` are size, floor and the size of dJ nearby.
    pub(super) fn new(name: String, values: [f64; 4], differences_error: f64, sizes: [f64; 3], tolerance: f64) -> Self {
        let ([adjoint, direct, complex_step, differences], [size, floor, nearby]) = (values, sizes);
        let (size, verdict) = (size.max(direct.abs()), Verdict::NothingCompared);
        let is_seen = size.max(nearby) > tolerance * size.max(floor);
        let mut report = DirectionReport {
            name,
            adjoint,
            direct,
            complex_step,
            differences,
            differences_error,
            size,
            floor,
            is_seen,
            verdict,
        };
        report.judge(0.0, tolerance);
        report
    }

    /// Judges again, with errors relative to at least `floor`.
    pub(super) fn judge(&mut self, floor: f64, tolerance: f64) {
        self.floor = self.floor.max(floor);
        let exact = tolerance * self.scale();
        let agree = near(self.direct, self.complex_step, exact);
        self.verdict = if !agree || self.differences_differ() {
            Verdict::ReferencesDisagree
        } else if !near(self.adjoint, self.direct, exact) {
            Verdict::Wrong
        } else if self.is_seen || self.agrees(tolerance) {
            Verdict::Right
        } else {
            Verdict::NothingCompared
        };
    }

    /// True if differences could be computed but disagree with dJ.
    fn differences_differ(&self) -> bool {
        let seen = DIFFERENCED * self.scale() + CAUTION * self.differences_error;
        self.differences.is_finite() && !near(self.direct, self.differences, seen)
    }

    /// True if the references disagree by the differences alone.
    pub(super) fn only_differences_differ(&self) -> bool {
        self.differences_differ() && near(self.direct, self.complex_step, DIFFERENCED * self.scale())
    }

    /// True if the exact ways disagree.
    pub(super) fn is_inexact(&self) -> bool {
        matches!(self.verdict, Verdict::Wrong | Verdict::ReferencesDisagree) && !self.only_differences_differ()
    }

    /// True if all ways except differences agree relative to dJ itself, however large J is: then dJ is not just rounding.
    fn agrees(&self, tolerance: f64) -> bool {
        let exact = tolerance * self.size;
        near(self.direct, self.complex_step, exact) && near(self.adjoint, self.direct, exact)
    }

    /// Scale of the errors relative to the terms of dJ if dJ is only rounding; d²J is up to four times larger along a longer direction.
    pub(super) fn raised(&self, tolerance: f64) -> f64 {
        let times = 4.0 * self.floor / self.size;
        if times.is_finite() && times > 4.0 && !self.agrees(tolerance) { times } else { 1.0 }
    }

    /// Relative difference of adjoint and direct differentiation.
    pub fn error(&self) -> f64 {
        relative(self.adjoint - self.direct, self.scale())
    }

    /// Scale of the errors.
    pub(super) fn scale(&self) -> f64 {
        self.size.max(self.floor)
    }
}

/// Remainders above this multiple of the error that differences allow do not come from a wrong gradient.
const BENDS: f64 = 4.0;

fn near(a: f64, b: f64, within: f64) -> bool {
    (a - b).abs() <= within
}

pub(super) fn relative(difference: f64, size: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference.abs() / size }
}

outcome!(GradientReport);

impl GradientReport {
    /// The overall verdict, including the user's gradients.
    pub fn verdict(&self) -> Verdict {
        self.library().with(&self.own)
    }

    /// The outcome for the library's gradient.
    pub(super) fn library(&self) -> Verdict {
        let rows = || self.directions.iter().chain(&self.worst_singles);
        let any = |verdict| rows().any(|row| row.verdict == verdict);
        let identity = self.identity.is_none_or(|identity| identity.first_wrong.is_none());
        if any(Verdict::ReferencesDisagree) {
            Verdict::ReferencesDisagree
        } else if any(Verdict::Wrong) || !identity || !self.taylor_holds() {
            Verdict::Wrong
        } else if self.directions.iter().all(|row| row.size == 0.0 || row.verdict == Verdict::NothingCompared) {
            Verdict::NothingCompared
        } else {
            Verdict::Right
        }
    }

    pub(super) fn taylor_holds(&self) -> bool {
        self.taylor.slope.is_none_or(|slope| slope > ENOUGH) || self.bends()
    }

    /// True if low orders do not come from a wrong gradient, because differences along the same direction (the last one) contradict an
    /// error of this size: then J itself is not smooth.
    pub(super) fn bends(&self) -> bool {
        let (by, allowed) =
            (self.taylor.wrong_by, |row: &DirectionReport| (row.differences - row.adjoint).abs() + row.differences_error);
        by.is_infinite() || self.directions.last().is_some_and(|row| by > BENDS * allowed(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// dJ = 1 in all ways, with these errors of adjoint, direct differentiation, complex step and differences.
    fn row(errors: [f64; 4]) -> DirectionReport {
        DirectionReport::new("all".into(), errors.map(|error| 1.0 + error), 1e-9, [1.0, 0.0, 0.0], 1e-9)
    }

    fn report(rows: Vec<DirectionReport>, slope: f64, first_wrong: Option<usize>) -> GradientReport {
        GradientReport {
            of: "J".into(),
            value: 1.0,
            directions: vec![row([0.0; 4])],
            singles: rows.len(),
            worst_singles: rows,
            taylor: Taylor { remainders: Vec::new(), slope: Some(slope), wrong_by: 5e-7 },
            identity: Some(Identity { worst: 0.0, node: 0, first_wrong }),
            rounding: 0.0,
            warnings: Vec::new(),
            has_kinks: false,
            grid: String::new(),
            own: Vec::new(),
        }
    }

    #[test]
    fn a_difference_of_any_two_ways_is_seen() {
        assert_eq!(row([0.5e-9, 0.0, 0.0, 0.5e-6]).verdict, Verdict::Right);
        for wrong in [2e-9, -2e-9, f64::NAN] {
            assert_eq!(row([wrong, 0.0, 0.0, 0.0]).verdict, Verdict::Wrong);
            assert_eq!(row([0.0, 0.0, wrong, 0.0]).verdict, Verdict::ReferencesDisagree);
        }
        assert_eq!(row([0.0, 0.0, 0.0, 2e-6]).verdict, Verdict::ReferencesDisagree);
        assert!(report(vec![row([0.0, 0.0, 0.0, 0.5])], 2.0, None).to_string().contains("a kink at these inputs"));
        assert!(!report(vec![row([0.0, 0.0, 0.5, 0.5])], 2.0, None).to_string().contains("a kink at these inputs"));
        // No motion exists at any step of the differences.
        assert_eq!(row([0.0, 0.0, 0.0, f64::NAN]).verdict, Verdict::Right);
    }

    /// dJ = 1 compared with J = 1e17.
    #[test]
    fn what_the_rounding_of_a_value_hides_is_not_right() {
        let hidden = |errors: [f64; 4]| {
            DirectionReport::new("all".into(), errors.map(|error| 1.0 + error), 1e3, [1.0, 1e11, 0.0], 1e-9)
        };
        let wrong = hidden([1e-3, 0.0, 0.0, 0.0]);
        assert_eq!(wrong.verdict, Verdict::NothingCompared);
        assert_eq!(hidden([1e-10, 0.0, 0.0, 0.0]).verdict, Verdict::Right);
        let mut all = report(Vec::new(), 2.0, None);
        all.directions = vec![wrong];
        assert_eq!(all.verdict(), Verdict::NothingCompared);
        // At an optimum dJ is zero, but not nearby.
        let row = DirectionReport::new("all".into(), [1e-17, 0.0, 0.0, 0.0], 0.0, [1e-17, 1e-4, 1.0], 1e-9);
        assert_eq!(row.verdict, Verdict::Right);
    }

    #[test]
    fn every_part_of_a_check_counts() {
        let right = || vec![row([0.0; 4])];
        assert_eq!(report(right(), 2.0, None).verdict(), Verdict::Right);
        assert_eq!(report(vec![row([2e-9, 0.0, 0.0, 0.0])], 2.0, None).verdict(), Verdict::Wrong);
        assert_eq!(report(vec![row([0.0, 0.0, 2e-9, 0.0])], 2.0, None).verdict(), Verdict::ReferencesDisagree);
        let broken = report(right(), 2.0, Some(3));
        assert!(broken.verdict() == Verdict::Wrong && broken.to_string().contains("BROKEN from node 3"));
        // Differences that are as far from the gradient allow a first-order remainder; others show that J is not smooth, whatever the rounding.
        let mut low = GradientReport { rounding: 1e-11, ..report(right(), 1.0, None) };
        assert!(low.verdict() == Verdict::Right && low.to_string().contains("J has a kink within its steps"));
        low.directions = vec![row([0.0, 0.0, 0.0, 5e-7])];
        assert!(low.verdict() == Verdict::Wrong && low.to_string().contains("TOO LOW"));
    }

    #[test]
    fn a_report_names_no_cause_that_is_none() {
        // Complex step differs, and differences do not.
        let rough = GradientReport { rounding: 1e-10, ..report(vec![row([0.0, 0.0, 1e-8, 0.0])], 2.0, None) }.to_string();
        assert!(!rough.contains("a kink at these inputs") && rough.contains("rounding error of 1.0e-10"), "{rough}");
        // Only the differences differ, and rounding is not the reason.
        let bent = GradientReport { rounding: 1e-10, ..report(vec![row([0.0, 0.0, 0.0, 1e-3])], 2.0, None) }.to_string();
        assert!(bent.contains("a kink at these inputs") && !bent.contains("rounding error"), "{bent}");
        let mut none = report(vec![row([0.0, 0.0, 0.0, f64::NAN])], 2.0, None);
        none.taylor.slope = None;
        let none = none.to_string();
        assert!(
            none.contains("the differences could not be computed") && !none.contains("NaN") && !none.contains("is linear"),
            "{none}"
        );
    }
}
