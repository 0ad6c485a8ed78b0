//! What a gradient check found.

use std::fmt;

use super::super::report::{BlockReport, Verdict};
use super::{CAUTION, DIFFERENCED, Identity, Taylor};

/// What is left to rounding by an ordinary motion is less; where it is more than the second number, nothing moves.
const ROUGH: [f64; 2] = [1e-12, 1e-3];

/// One direction, four ways.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DirectionReport {
    /// Which inputs move.
    pub name: String,
    /// g·d with the gradient g of the discrete adjoint.
    pub adjoint: f64,
    /// By the tangent system.
    pub direct: f64,
    /// By complex step through the whole simulation.
    pub complex_step: f64,
    /// By differences with Ridders' extrapolation.
    pub differences: f64,
    /// Their error by their own estimate.
    pub differences_error: f64,
    /// √Σ (g_j d_j)²: what the errors are relative to …
    pub size: f64,
    /// … unless dJ is rounding: 1e-6 |J| + 1e-4 |d²J|, since no dJ is known better than to the rounding of J, nor at an optimum than to what the
    /// rounding of the motion changes it by; 1e-4 of the terms of dJ/dΔt, which cancel where a mechanism rests; and 1e-6 of the largest row, or 1e-3 of the largest single input.
    pub floor: f64,
    /// Whether dJ, or what it is nearby, is more than errors may be: if not, any number would do.
    pub is_seen: bool,
    /// The outcome: "nothing compared" where all that can be said is that dJ is hidden by the rounding of J.
    pub verdict: Verdict,
}

/// The gradient of a system's cost, checked.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct GradientReport {
    /// Of what: J, or an output.
    pub of: String,
    /// Its value.
    pub value: f64,
    /// Random directions.
    pub directions: Vec<DirectionReport>,
    /// How many single inputs were compared.
    pub singles: usize,
    /// The worst of them.
    pub worst_singles: Vec<DirectionReport>,
    /// The Taylor remainder test, in all inputs together.
    pub taylor: Taylor,
    /// The dot-product identity, in controls and initial values.
    pub identity: Option<Identity>,
    /// What direct differentiation and complex step left to rounding along the random directions, relative to the unknowns of a step (see [`LiftedSolver::rounding`](crate::LiftedSolver::rounding)):
    /// about 1e-14, and more where tangent matrices are close to singular or springs are stiff.
    pub rounding: f64,
    /// Gradients of the user's own.
    pub own: Vec<BlockReport>,
}

impl DirectionReport {
    /// With size, floor, and what dJ is nearby.
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
        let seen = DIFFERENCED * self.scale() + CAUTION * self.differences_error;
        let oracles = near(self.direct, self.complex_step, exact);
        let differences = !self.differences.is_finite() || near(self.direct, self.differences, seen);
        self.verdict = if !oracles || !differences {
            Verdict::OraclesDisagree
        } else if !near(self.adjoint, self.direct, exact) {
            Verdict::Wrong
        } else if self.is_seen || self.agrees(tolerance) {
            Verdict::Right
        } else {
            Verdict::NothingCompared
        };
    }

    /// Whether the oracles disagree by the differences alone.
    fn only_differences_differ(&self) -> bool {
        self.verdict == Verdict::OraclesDisagree && near(self.direct, self.complex_step, DIFFERENCED * self.scale())
    }

    /// Whether all but the differences agree to what dJ is itself, however large J is: then dJ is no rounding.
    fn agrees(&self, tolerance: f64) -> bool {
        let exact = tolerance * self.size;
        near(self.direct, self.complex_step, exact) && near(self.adjoint, self.direct, exact)
    }

    /// How many times more than its terms errors are relative to where dJ is rounding; d²J is up to four times more along a longer direction.
    pub(super) fn raised(&self, tolerance: f64) -> f64 {
        let times = 4.0 * self.floor / self.size;
        if times.is_finite() && times > 4.0 && !self.agrees(tolerance) { times } else { 1.0 }
    }

    /// |adjoint − direct|, relative.
    pub fn error(&self) -> f64 {
        relative(self.adjoint - self.direct, self.scale())
    }

    /// What errors are relative to.
    pub(super) fn scale(&self) -> f64 {
        self.size.max(self.floor)
    }
}

/// Where dJ is smaller than this part of J, errors are relative to that.
const HIDDEN: f64 = super::ways::OF_VALUE;
/// Differences as near to the adjoint as this leave nothing for a Taylor remainder of the first order but kinks.
const BENDS: f64 = 1e-9;
/// The least observed order that a right gradient has: half-way between 1 and 2.
const ENOUGH: f64 = 1.5;

fn near(a: f64, b: f64, within: f64) -> bool {
    (a - b).abs() <= within
}

fn relative(difference: f64, size: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference.abs() / size }
}

impl GradientReport {
    /// The outcome of everything, gradients of the user's own included.
    pub fn verdict(&self) -> Verdict {
        self.library().with(&self.own)
    }

    /// The outcome for the library's gradient.
    fn library(&self) -> Verdict {
        let rows = || self.directions.iter().chain(&self.worst_singles);
        let any = |verdict| rows().any(|row| row.verdict == verdict);
        let identity = self.identity.is_none_or(|identity| identity.first_wrong.is_none());
        if any(Verdict::OraclesDisagree) {
            Verdict::OraclesDisagree
        } else if any(Verdict::Wrong) || !identity || !self.taylor_holds() {
            Verdict::Wrong
        } else if self.directions.iter().all(|row| row.size == 0.0 || row.verdict == Verdict::NothingCompared) {
            Verdict::NothingCompared
        } else {
            Verdict::Right
        }
    }

    fn taylor_holds(&self) -> bool {
        self.taylor.slope.is_none_or(|slope| slope > ENOUGH) || self.bends()
    }

    /// Whether differences along the direction of the Taylor remainder, the last, have all digits that a remainder can tell of, and the motion is no rounding:
    /// then it is J that bends.
    fn bends(&self) -> bool {
        let along = self.directions.last().filter(|_| self.rounding <= ROUGH[0]);
        along.is_some_and(|row| {
            let exact = BENDS * row.scale();
            near(row.differences, row.adjoint, exact) && row.differences_error <= exact
        })
    }

    /// Whether all is right.
    pub fn passed(&self) -> bool {
        self.verdict() == Verdict::Right
    }

    /// For tests.
    ///
    /// # Panics
    /// With the whole report, unless all is right.
    #[track_caller]
    pub fn assert_passed(&self) {
        assert!(self.passed(), "\n{self}");
    }
}

impl fmt::Display for GradientReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let summary = match self.verdict() {
            Verdict::Right => "right".to_string(),
            Verdict::NothingCompared => {
                "FAILED, because nothing was compared: it does not depend on the inputs by more than its rounding"
                    .to_string()
            }
            other => other.to_string(),
        };
        let own = if self.library() == self.verdict() { "" } else { "; but see the gradient of your own" };
        let summary = if own.is_empty() { summary } else { self.library().to_string() };
        writeln!(f, "gradient of {} = {:.12e}: {summary}{own}", self.of, self.value)?;
        let names = self.directions.iter().map(|row| &row.name).chain(self.own.iter().map(|own| &own.name));
        let width = names.map(|name| name.chars().count()).max().unwrap_or(0);
        writeln!(
            f,
            "  {:width$}  {:>19}  {:>9}  {:>9}  {:>9} (est.)   verdict",
            "direction", "dJ by direct diff.", "adjoint", "complex", "differ."
        )?;
        self.directions.iter().try_for_each(|row| row.line(f, width))?;
        if self.singles > 0 {
            writeln!(f, "  each of {} inputs alone; the worst:", self.singles)?;
            self.worst_singles.iter().take(5).try_for_each(|row| row.line(f, width))?;
        }
        self.own.iter().try_for_each(|own| own_line(own, f, width))?;
        match self.taylor.slope {
            Some(slope) if slope <= ENOUGH && self.bends() => writeln!(
                f,
                "  Taylor remainder: observed order {slope:.3}; J bends within its steps, for differences agree with the gradient"
            )?,
            Some(slope) => {
                let word = if self.taylor_holds() { "enough" } else { "TOO LOW" };
                writeln!(
                    f,
                    "  Taylor remainder J(x + s d) − J(x) − s g·d: observed order {slope:.3}, {word}: more than {ENOUGH} is asked for; a right \
                     gradient has 2, a wrong one 1"
                )?;
            }
            None => writeln!(f, "  Taylor remainder: rounding at all steps, it is linear along this direction")?,
        }
        let most = self.directions.iter().fold(0.0f64, |most, row| most.max(row.size));
        if most > 0.0 && most < HIDDEN * self.value.abs() {
            let (of, share) = (&self.of, HIDDEN * self.value.abs() / most);
            writeln!(
                f,
                "  {of} is so large beside dJ that its rounding hides dJ: errors are relative to {HIDDEN:.0e} of {of}, which is {share:.0e} times \
                 dJ, and differences and Taylor remainder tell less; to see more, leave out of {of} what does not change"
            )?;
        }
        if let Some(identity) = self.identity {
            write!(f, "  adjoint–tangent identity: holds to {:.1e} at all nodes", identity.worst)?;
            match identity.first_wrong {
                Some(node) => writeln!(f, "; BROKEN from node {node} backwards")?,
                None => writeln!(f)?,
            }
        }
        let bent = self.directions.iter().chain(&self.worst_singles).find(|row| row.only_differences_differ());
        if let Some(DirectionReport { name, .. }) = bent {
            writeln!(
                f,
                "  along `{name}` differences alone differ from all others: {} bends at these inputs, as by abs, max or min at zero, and has no \
                 derivative there but that of one side; or it is rough; move the inputs a little and see",
                self.of
            )?;
        }
        let is_rough = self.rounding > ROUGH[0] && self.rounding < ROUGH[1];
        if is_rough && matches!(self.verdict(), Verdict::Wrong | Verdict::OraclesDisagree) {
            writeln!(
                f,
                "  direct differentiation and complex step left corrections of {:.1e} to rounding, because tangent matrices are nearly \
                 singular or springs are stiff: derivatives of this motion agree to some ten to a thousand times that, which is what the \
                 check's `tolerance` should be; or take shorter steps, or another start",
                self.rounding
            )?;
        }
        self.own.iter().filter(|own| own.verdict != Verdict::Right).try_for_each(|own| write!(f, "{own}"))
    }
}

/// A gradient of the user's own as a row of the table: it is compared number by number, with the adjoint's.
fn own_line(own: &BlockReport, f: &mut fmt::Formatter, width: usize) -> fmt::Result {
    let (name, error, count) = (&own.name, own.relative_error, own.size.1);
    let numbers = format!("{} of {count} wrong", own.wrong_entries);
    writeln!(f, "  {name:width$}  {numbers:>19}  {error:>9.1e}  {:9}  {:9}         {}", "", "", own.verdict)
}

impl DirectionReport {
    fn line(&self, f: &mut fmt::Formatter, width: usize) -> fmt::Result {
        let off = |x: f64| relative(x - self.direct, self.scale());
        let (adjoint, complex, differences) = (off(self.adjoint), off(self.complex_step), off(self.differences));
        let (name, estimate) = (&self.name, relative(self.differences_error, self.scale()));
        writeln!(
            f,
            "  {name:width$}  {:>+19.12e}  {adjoint:>9.1e}  {complex:>9.1e}  {differences:>9.1e} ({estimate:.0e})  {}",
            self.direct, self.verdict
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// dJ = 1 by all ways, but for these errors of adjoint, direct differentiation, complex step and differences.
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
            taylor: Taylor { remainders: Vec::new(), slope: Some(slope) },
            identity: Some(Identity { worst: 0.0, node: 0, first_wrong }),
            rounding: 0.0,
            own: Vec::new(),
        }
    }

    #[test]
    fn a_difference_of_any_two_ways_is_seen() {
        assert_eq!(row([0.5e-9, 0.0, 0.0, 0.5e-6]).verdict, Verdict::Right);
        for wrong in [2e-9, -2e-9, f64::NAN] {
            assert_eq!(row([wrong, 0.0, 0.0, 0.0]).verdict, Verdict::Wrong);
            assert_eq!(row([0.0, 0.0, wrong, 0.0]).verdict, Verdict::OraclesDisagree);
        }
        assert_eq!(row([0.0, 0.0, 0.0, 2e-6]).verdict, Verdict::OraclesDisagree);
        assert!(report(vec![row([0.0, 0.0, 0.0, 0.5])], 2.0, None).to_string().contains("bends at these inputs"));
        assert!(!report(vec![row([0.0, 0.0, 0.5, 0.5])], 2.0, None).to_string().contains("bends at these inputs"));
        // No step of the differences had a motion.
        assert_eq!(row([0.0, 0.0, 0.0, f64::NAN]).verdict, Verdict::Right);
    }

    /// dJ = 1 beside J = 1e17.
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
        // At an optimum dJ is nothing, but not what it is nearby.
        let row = DirectionReport::new("all".into(), [1e-17, 0.0, 0.0, 0.0], 0.0, [1e-17, 1e-4, 1.0], 1e-9);
        assert_eq!(row.verdict, Verdict::Right);
    }

    #[test]
    fn every_part_of_a_check_counts() {
        let right = || vec![row([0.0; 4])];
        assert_eq!(report(right(), 2.0, None).verdict(), Verdict::Right);
        assert_eq!(report(vec![row([2e-9, 0.0, 0.0, 0.0])], 2.0, None).verdict(), Verdict::Wrong);
        assert_eq!(report(vec![row([0.0, 0.0, 2e-9, 0.0])], 2.0, None).verdict(), Verdict::OraclesDisagree);
        let broken = report(right(), 2.0, Some(3));
        assert!(broken.verdict() == Verdict::Wrong && broken.to_string().contains("BROKEN from node 3"));
        // Differences that are no nearer to the gradient leave room for a remainder of the first order; others say that J bends.
        let mut low = report(right(), 1.0, None);
        assert!(low.verdict() == Verdict::Right && low.to_string().contains("J bends within its steps"));
        low.directions = vec![row([0.0, 0.0, 0.0, 5e-7])];
        assert!(low.verdict() == Verdict::Wrong && low.to_string().contains("TOO LOW"));
    }
}
