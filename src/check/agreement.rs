//! Whether the oracles agree among each other at a point, and if not, why.

use super::oracle::Jacobian;
use super::place::{NOISE, Place};

/// Dual numbers and complex step are both exact up to rounding.
const EXACT: f64 = 1e-9;
/// Differences see this much, relative to the size of an entry; what they miss, the other two compare to all digits.
const DIFFERENCED: f64 = 1e-7;
/// The error estimate of the differences may itself be too small by this factor.
const CAUTION: f64 = 30.0;

/// How well the oracles agree at one point.
pub(crate) struct Agreement {
    /// The largest differences from the dual numbers, relative to the sizes of the entries.
    pub complex_step: f64,
    pub differences: f64,
    pub conflict: Option<Conflict>,
    /// Where differences contradict the others, and shorter ones cannot tell.
    pub doubt: Option<Conflict>,
}

/// An entry in which the oracles disagree at a point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Conflict {
    row: usize,
    column: usize,
    why: Why,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Why {
    /// One-sided derivatives, left and right, differ: no derivative exists, and nobody is to blame.
    Kink(f64, f64),
    /// This oracle gives infinity or NaN.
    NotFinite(&'static str),
    /// Dual numbers and complex step differ.
    NotAnalytic(f64, f64),
    /// Differences of the function itself contradict what both others give.
    Lost(f64, f64),
    /// They do so with long steps, and rounding leaves nothing of short ones.
    Unsure(f64, f64),
}

/// Compares the oracles at a place, with errors relative to the scales of the entries.
pub(crate) fn agreement(of: &Jacobian, place: &Place, magnitudes: &[f64]) -> Agreement {
    let mut found = Agreement { complex_step: 0.0, differences: 0.0, conflict: None, doubt: None };
    for column in 0..place.scale.ncols() {
        for row in 0..place.scale.nrows() {
            let at = (row, column);
            let (dual, complex, size) = (place.truth[at], place.complex_step[at], place.scale[at]);
            let noise = NOISE * place.noise[at];
            let relative = |error: f64| if error == 0.0 { 0.0 } else { error / size };
            let by_differences = place.differences[at];
            let apart = (dual - complex).abs();
            found.complex_step = found.complex_step.max(relative(apart));
            let mut why = None;
            if let Some(oracle) = not_finite(dual, complex) {
                why = Some(Why::NotFinite(oracle));
            } else if apart > EXACT * size + noise {
                why = Some(Why::NotAnalytic(dual, complex));
            } else if by_differences.is_finite() {
                let allowed = |error: f64| DIFFERENCED * size + noise + CAUTION * error;
                let apart = (dual - by_differences).abs();
                if apart <= allowed(place.differences_error[at]) {
                    found.differences = found.differences.max(relative(apart));
                } else if found.conflict.is_none() {
                    // Steps across something narrow say nothing; shorter ones must say the same, clearly. Short ones that rounding leaves
                    // half a digit still tell on whose side they are.
                    let finer = |level: i32| {
                        let (shorter, error) = of.differences(&place.x, column, magnitudes, level);
                        ((dual - shorter[row]).abs(), error[row])
                    };
                    let agrees = |(shorter, error): (f64, f64)| {
                        let within = (CAUTION * error).min(0.1 * apart).max(0.5 * error);
                        error <= apart && shorter <= allowed(0.0) + within
                    };
                    let (shorter, error) = finer(1);
                    let persists = shorter > allowed(error);
                    if !agrees((shorter, error)) && ![finer(2), finer(3)].into_iter().any(agrees) {
                        if persists {
                            why = Some(Why::Lost(dual, by_differences));
                        } else {
                            found.doubt.get_or_insert(Conflict { row, column, why: Why::Unsure(dual, by_differences) });
                        }
                    }
                }
            }
            if let Some(why) = why.filter(|_| found.conflict.is_none()) {
                let kink = kink(of, &place.x, (of.by.start + column, magnitudes), row, size);
                found.conflict = Some(Conflict { row, column, why: kink.unwrap_or(why) });
            }
        }
    }
    found
}

fn not_finite(dual: f64, complex: f64) -> Option<&'static str> {
    match (dual.is_finite(), complex.is_finite()) {
        (true, true) => None,
        (true, false) => Some("complex step"),
        (false, true) => Some("dual numbers"),
        (false, false) => Some("dual numbers and complex step"),
    }
}

/// One-sided difference quotients that do not approach each other as the step shrinks: at the point, or too near to see past it.
fn kink(of: &Jacobian, x: &[f64], (at, magnitudes): (usize, &[f64]), row: usize, size: f64) -> Option<Why> {
    let value = |s: f64| {
        let mut x = x.to_vec();
        x[at] += s;
        of.function.real(&x)[row]
    };
    let sides = |h: f64| ((value(0.0) - value(-h)) / h, (value(h) - value(0.0)) / h);
    let own = if x[at] == 0.0 { 1.0 } else { x[at].abs() };
    [own, magnitudes[at]].into_iter().find_map(|scale| {
        let (coarse, (left, right)) = (sides(1e-5 * scale), sides(1e-6 * scale));
        let gap = (right - left).abs();
        let persists = gap > 0.5 * (coarse.1 - coarse.0).abs() && gap > 1e-3 * size;
        persists.then_some(Why::Kink(left, right))
    })
}

impl Conflict {
    pub(crate) fn is_kink(&self) -> bool {
        matches!(self.why, Why::Kink(..))
    }

    /// The sentence for a report.
    pub(crate) fn describe(&self, rows: &[String], columns: &[String]) -> String {
        let (row, column) = (&rows[self.row], &columns[self.column]);
        match self.why {
            Why::Kink(left, right) => format!(
                "{row} has a kink in {column}: its derivative is {left:.3e} on the left and {right:.3e} on the right, so there is none here; \
                 choose points away from it"
            ),
            Why::NotFinite(oracle) => format!(
                "{oracle} give infinity or NaN for d({row})/d({column}): a root, logarithm or quotient at the edge of its domain"
            ),
            Why::NotAnalytic(dual, complex) => format!(
                "dual numbers give d({row})/d({column}) = {dual:.9e}, complex step {complex:.9e}: the formula is not analytic \
                 (a conjugate, an absolute value by hand, a branch on a derivative part)"
            ),
            Why::Lost(dual, differences) => format!(
                "the formula itself is wrong for derivatives: d({row})/d({column}) is {dual:.6e} by dual numbers and complex step, \
                 but its values change by {differences:.6e}; it continues somewhere with a bare real value (`re()`, a table, \
                 an iteration that stops early) and so loses a derivative"
            ),
            Why::Unsure(dual, differences) => format!(
                "d({row})/d({column}) is {dual:.6e} by dual numbers and complex step, and {differences:.6e} by differences, of which rounding leaves \
                 nothing where their steps are short: something narrow beside the point, or a derivative that the formula loses; to see which, \
                 leave out of the formula what does not change"
            ),
        }
    }
}
