//! Agreement of the references at a point, and the reason if they disagree.

use super::place::{NOISE, Place};
use super::reference::Jacobian;

/// Allowed relative difference between dual numbers and complex step, which are both exact up to rounding.
const EXACT: f64 = 1e-9;
/// Allowed error of the differences, relative to the size of an entry; the other two references are compared to all digits.
const DIFFERENCED: f64 = 1e-7;
/// Safety factor on the error estimate of the differences, which may be too small.
const CAUTION: f64 = 30.0;

/// Agreement of the references at one point.
#[derive(Default)]
pub(crate) struct Agreement {
    /// Largest difference between the complex step and the dual numbers, relative to the sizes of the entries.
    pub complex_step: f64,
    pub differences: f64,
    pub conflict: Option<Conflict>,
    /// A note if finite differences contradict the other references and smaller steps do not settle the question.
    pub doubt: Option<String>,
}

/// An entry on which the references disagree at a point.
pub(crate) struct Conflict {
    /// True if the one-sided derivatives differ: no derivative exists, so none of the references is wrong.
    pub is_kink: bool,
    /// Text for the report.
    pub text: String,
}

/// Compares the references at a place, with errors relative to the scales of the entries; `rows` and `columns` are names.
pub(crate) fn agreement(of: &Jacobian, place: &Place, magnitudes: &[f64], [rows, columns]: [&[String]; 2]) -> Agreement {
    let mut found = Agreement::default();
    for at in (0..columns.len()).flat_map(|column| (0..rows.len()).map(move |row| (row, column))) {
        let (dual, complex, size) = (place.truth[at], place.complex_step[at], place.scale[at]);
        let (differences, noise) = (place.differences[at], NOISE * place.noise[at]);
        let relative = |error: f64| if error == 0.0 { 0.0 } else { error / size };
        let entry = || format!("d({})/d({})", rows[at.0], columns[at.1]);
        let apart = (dual - complex).abs();
        found.complex_step = found.complex_step.max(relative(apart));
        let mut why = None;
        if let Some(reference) = not_finite(dual, complex) {
            why = Some(format!(
                "{reference} infinity or NaN for {}: a root, logarithm or quotient at the edge of its domain",
                entry()
            ));
        } else if apart > EXACT * size + noise {
            why = Some(format!(
                "dual numbers give {} = {dual:.9e}, complex step {complex:.9e}: the formula is not analytic \
                 (a conjugate, a hand-written absolute value, a branch on a derivative part)",
                entry()
            ));
        } else if differences.is_finite() {
            let allowed = |error: f64| DIFFERENCED * size + noise + CAUTION * error;
            let apart = (dual - differences).abs();
            if apart <= allowed(place.differences_error[at]) {
                found.differences = found.differences.max(relative(apart));
            } else if found.conflict.is_none() {
                match contradiction(of, place, at, magnitudes, allowed) {
                    Some(true) => why = Some(lost(&entry(), dual, differences)),
                    Some(false) => _ = found.doubt.get_or_insert_with(|| unsure(&entry(), dual, differences)),
                    None => {}
                }
            }
        }
        // If rounding of the arguments changes a derivative by about its size and differences give another value, a kink may be near.
        let is_other = (dual - differences).abs() > DIFFERENCED * size + CAUTION * place.differences_error[at];
        let may_be_kink = why.is_some() || (noise > 0.5 * size && is_other);
        if found.conflict.is_none() && may_be_kink {
            let sides = one_sided(of, &place.x, (of.by.start + at.1, magnitudes), at.0, size);
            let kink = sides.map(|sides| kink(&rows[at.0], &columns[at.1], sides));
            let is_kink = kink.is_some();
            found.conflict = kink.or(why).map(|text| Conflict { is_kink, text });
        }
    }
    found
}

/// `Some(true)` if shorter differences contradict the other references too, `Some(false)` if rounding leaves the question open.
fn contradiction(
    of: &Jacobian,
    place: &Place,
    (row, column): (usize, usize),
    magnitudes: &[f64],
    allowed: impl Fn(f64) -> f64,
) -> Option<bool> {
    let (dual, apart) = (place.truth[(row, column)], (place.truth[(row, column)] - place.differences[(row, column)]).abs());
    // Differences across a narrow feature are no evidence; shorter ones must clearly show the same contradiction. Even if rounding leaves only half a
    // digit of a difference with a short step, it still shows which value is nearer.
    let finer = |level: i32| {
        let (shorter, error) = of.differences(&place.x, column, magnitudes, level);
        ((dual - shorter[row]).abs(), error[row])
    };
    let agrees = |(shorter, error): (f64, f64)| {
        let within = (CAUTION * error).min(0.1 * apart).max(0.5 * error);
        error <= apart && shorter <= allowed(0.0) + within
    };
    let (shorter, error) = finer(1);
    let agree = agrees((shorter, error)) || [finer(2), finer(3)].into_iter().any(agrees);
    (!agree).then_some(shorter > allowed(error))
}

fn not_finite(dual: f64, complex: f64) -> Option<&'static str> {
    match (dual.is_finite(), complex.is_finite()) {
        (true, true) => None,
        (true, false) => Some("complex step gives"),
        (false, true) => Some("dual numbers give"),
        (false, false) => Some("dual numbers and complex step give"),
    }
}

/// The derivatives on the left and on the right, if their difference persists as the step shrinks: a kink at the point or very close.
fn one_sided(of: &Jacobian, x: &[f64], (at, magnitudes): (usize, &[f64]), row: usize, size: f64) -> Option<(f64, f64)> {
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
        persists.then_some((left, right))
    })
}

fn kink(row: &str, column: &str, (left, right): (f64, f64)) -> String {
    format!(
        "{row} has a kink in {column}: its derivative is {left:.3e} on the left and {right:.3e} on the right, so no derivative exists here; \
         choose points away from it"
    )
}

fn lost(entry: &str, dual: f64, differences: f64) -> String {
    format!(
        "the formula loses a derivative: {entry} is {dual:.6e} by dual numbers and complex step, \
         but {differences:.6e} by differences of its values; it uses a bare real value somewhere (`re()`, a table, \
         an iteration that stops early)"
    )
}

fn unsure(entry: &str, dual: f64, differences: f64) -> String {
    format!(
        "{entry} is {dual:.6e} by dual numbers and complex step, but {differences:.6e} by differences, and with shorter steps the differences are lost in rounding. Either there is a narrow feature near the point, or the formula loses a derivative; to decide, remove constant terms from the formula"
    )
}
