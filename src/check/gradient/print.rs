//! The report of a gradient check as a table, and in words.

use std::fmt;

use super::super::report::{BlockReport, Verdict};
use super::report::relative;
use super::taylor::ENOUGH;
use super::ways::OF_VALUE;
use super::{DirectionReport, GradientReport};

/// Range of rounding that is explained: an ordinary motion has less, and one at rest may have more.
const ROUGH: [f64; 2] = [1e-12, 1e-3];

impl fmt::Display for GradientReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let library = self.library();
        let summary = match library {
            Verdict::NothingCompared => {
                "FAILED, because nothing was compared: the function depends on the inputs by no more than its rounding error"
                    .to_string()
            }
            Verdict::Right if self.has_kinks => {
                "right for this grid, but not near the gradient of the continuous motion (see `Gradient::frozen`)"
                    .to_string()
            }
            other => other.to_string(),
        };
        let own = if library == self.verdict() { "" } else { "; but see your own gradient" };
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
                "  Taylor remainder: observed order {slope:.3}; J has a kink within its steps, or is rough: a wrong gradient would have smaller remainders"
            )?,
            Some(slope) => {
                let word = if self.taylor_holds() { "enough" } else { "TOO LOW" };
                writeln!(
                    f,
                    "  Taylor remainder J(x + s d) − J(x) − s g·d: observed order {slope:.3}, {word}: more than {ENOUGH} is required; a right \
                     gradient has 2, a wrong one 1"
                )?;
            }
            None if self.taylor.remainders.is_empty() => {
                writeln!(f, "  Taylor remainder: none, because no neighbouring motion could be computed")?
            }
            None => {
                writeln!(f, "  Taylor remainder: only rounding at all steps; the function is linear along this direction")?
            }
        }
        let most = self.directions.iter().fold(0.0f64, |most, row| most.max(row.size));
        if most > 0.0 && most < OF_VALUE * self.value.abs() {
            let (of, share) = (&self.of, OF_VALUE * self.value.abs() / most);
            writeln!(
                f,
                "  {of} is so large compared with dJ that its rounding hides dJ: errors are relative to {OF_VALUE:.0e} of {of}, which is {share:.0e} times \
                 dJ, and differences and Taylor remainder are less sensitive; for a stricter check, remove constant terms from {of}"
            )?;
        }
        if let Some(identity) = self.identity {
            write!(f, "  adjoint–tangent identity: holds to {:.1e} at all nodes", identity.worst)?;
            match identity.first_wrong {
                Some(node) => writeln!(f, "; BROKEN from node {node} backwards")?,
                None => writeln!(f)?,
            }
        }
        if !self.grid.is_empty() {
            writeln!(
                f,
                "  all this is about the motion on this grid; its difference from the continuous motion: {}",
                self.grid
            )?;
        }
        self.explain(f)?;
        self.own.iter().filter(|own| own.verdict != Verdict::Right).try_for_each(|own| write!(f, "{own}"))
    }
}

impl GradientReport {
    /// Explains why the ways differ, if the numbers show a reason.
    fn explain(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let rows = || self.directions.iter().chain(&self.worst_singles);
        if let Some(DirectionReport { name, .. }) = rows().find(|row| row.only_differences_differ()) {
            writeln!(
                f,
                "  along `{name}` only the differences disagree. {} may have a kink at these inputs, for example from abs, max or min at zero, so that only one-sided derivatives exist; it may be rough; or a formula may lose a derivative, for example by `re()`. Move the inputs slightly and repeat the check",
                self.of
            )?;
        }
        if let Some(DirectionReport { name, .. }) = rows().find(|row| !row.differences.is_finite()) {
            writeln!(
                f,
                "  along `{name}` the differences could not be computed: at neighbouring inputs the motion fails, or other steps are halved or restarts occur at other nodes, so that {} is a different function there; along this direction, formulas that lose a derivative are not detected",
                self.of
            )?;
        }
        let is_broken = self.identity.is_some_and(|identity| identity.first_wrong.is_some());
        if is_broken || rows().any(DirectionReport::is_inexact) {
            explain_difference(f, self.rounding)?;
        }
        print_warnings(f, &self.warnings)
    }
}

/// Explains why the exact ways may differ: by a rounding error larger than usual.
pub(super) fn explain_difference(f: &mut fmt::Formatter, rounding: f64) -> fmt::Result {
    if rounding > ROUGH[0] && rounding < ROUGH[1] {
        writeln!(
            f,
            "  direct differentiation and complex step have a rounding error of {rounding:.1e}, because tangent matrices are nearly singular or \
             springs are stiff: derivatives of this motion agree to about ten to a thousand times this error; set the check's `tolerance` \
             accordingly, or use shorter steps or another start"
        )?;
    }
    Ok(())
}

/// Prints the warnings of the motion and its gradient.
pub(super) fn print_warnings(f: &mut fmt::Formatter, warnings: &[String]) -> fmt::Result {
    warnings.iter().try_for_each(|warning| writeln!(f, "  warning of this motion: {warning}"))
}

/// The user's gradient as a row of the table; it is compared number by number with the adjoint's.
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
        let verdict = if self.size == 0.0 { Verdict::NothingCompared } else { self.verdict };
        let differences =
            if differences.is_finite() { format!("{differences:.1e} ({estimate:.0e})") } else { "none        ".into() };
        writeln!(
            f,
            "  {name:width$}  {:>+19.12e}  {adjoint:>9.1e}  {complex:>9.1e}  {differences:>17}  {verdict}",
            self.direct
        )
    }
}
