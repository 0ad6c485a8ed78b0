//! Multiples of the true value: −1, 0, a constant, an argument.

use std::f64::consts::{FRAC_PI_2, PI};

use super::evidence::Evidence;
use super::mask::Mask;
use crate::check::report::{Diagnosis, Mistake};

/// Two numbers are the same factor if they differ by less than this.
const SAME: f64 = 1e-7;
/// A factor nearer to 1 than this counts as a lack of digits.
const NEARLY_ONE: f64 = 1e-3;

/// True if the true values of these entries are zero.
fn is_zero(mask: &Mask) -> bool {
    mask.of.at.iter().all(|at| mask.entries.iter().all(|&e| at.truth[e].abs() <= at.tolerance[e]))
}

pub(super) fn sign(mask: &Mask) -> Option<Diagnosis> {
    let flipped = !is_zero(mask) && mask.explains(|p, e| -mask.truth(p, e));
    flipped.then(|| mask.says(Mistake::SignFlipped, "sign flipped"))
}

pub(super) fn zero(mask: &Mask) -> Option<Diagnosis> {
    let absent = !is_zero(mask) && mask.of.at.iter().all(|at| mask.entries.iter().all(|&e| at.hand[e] == 0.0));
    absent.then(|| mask.says(Mistake::Zero, "zero where it should not be,"))
}

pub(super) fn not_zero(mask: &Mask) -> Option<Diagnosis> {
    is_zero(mask).then(|| mask.says(Mistake::NotZero, "not zero where it should be,"))
}

/// The constant c with hand = c · true, if there is one.
fn constant_factor(mask: &Mask) -> Option<f64> {
    mask.multiple(|_, _| 0.0, |p, e| mask.truth(p, e))
}

/// Diagnosis of a constant factor that is often forgotten.
pub(super) fn likely(mask: &Mask) -> Option<Diagnosis> {
    let c = constant_factor(mask)?;
    let name = likely_name(mask.of, c)?;
    Some(mask.says(Mistake::Factor, format!("constant factor {name}")))
}

/// Diagnosis of any constant factor. Constant entries are always multiples of their true values, which is no evidence.
pub(super) fn constant(mask: &Mask) -> Option<Diagnosis> {
    let c = constant_factor(mask)?;
    let is_all = || mask.entries == Mask::wrong(mask.of).entries;
    if !is_all() && !mask.varies(|p, e| mask.truth(p, e)) {
        return None;
    }
    if (c - 1.0).abs() < NEARLY_ONE {
        let text = format!("right to {} digits only (constant factor 1 {:+.1e})", digits(c - 1.0), c - 1.0);
        return Some(mask.says(Mistake::FewDigits, text));
    }
    Some(mask.says(Mistake::Factor, format!("constant factor {}", any_name(mask.of, c))))
}

pub(super) fn likely_name(evidence: &Evidence, c: f64) -> Option<String> {
    name(evidence, c, &LIKELY)
}

pub(super) fn any_name(evidence: &Evidence, c: f64) -> String {
    likely_name(evidence, c).or_else(|| name(evidence, c, &POSSIBLE)).unwrap_or_else(|| format!("{c:.9}"))
}

pub(super) fn digits(relative: f64) -> usize {
    (-relative.abs().log10()).floor().max(0.0) as usize
}

const LIKELY: [(f64, &str); 7] = [
    (2.0, "2"),
    (0.5, "½"),
    (2.0 * PI, "2π"),
    (180.0 / PI, "180/π (degrees for radians)"),
    (PI / 180.0, "π/180 (degrees for radians)"),
    (1000.0, "1000 (a unit)"),
    (0.001, "1/1000 (a unit)"),
];

const POSSIBLE: [(f64, &str); 9] = [
    (3.0, "3"),
    (1.0 / 3.0, "⅓"),
    (4.0, "4"),
    (0.25, "¼"),
    (1.5, "3/2"),
    (2.0 / 3.0, "⅔"),
    (PI, "π"),
    (1.0 / PI, "1/π"),
    (FRAC_PI_2, "π/2"),
];

/// Name of a factor: "2", "½", "γ (here 100)", "−1/`mass` (here −1.25)", or two of them.
fn name(evidence: &Evidence, c: f64, plain: &[(f64, &str)]) -> Option<String> {
    let same = |x: f64| (c.abs() / x.abs() - 1.0).abs() < SAME;
    let signed = |x: f64, name: String| if c * x < 0.0 { format!("−{name}") } else { name };
    let number = plain.iter().find(|(x, _)| same(*x)).map(|(x, name)| signed(*x, name.to_string()));
    let named = evidence.setting.factors.iter().filter(|(_, x)| *x != 0.0 && x.abs() != 1.0);
    let direct = named.clone().find(|(_, x)| same(*x)).map(|(name, x)| signed(*x, name.clone()));
    let inverse = || named.clone().find(|(_, x)| same(1.0 / x)).map(|(name, x)| signed(*x, format!("1/{name}")));
    let ratio = || {
        let pairs = named.clone().flat_map(|over| named.clone().map(move |under| (over, under)));
        let found = pairs.into_iter().find(|((_, x), (_, y))| same(x / y) && (x / y - 1.0).abs() > NEARLY_ONE)?;
        Some(signed(found.0.1 / found.1.1, format!("{}/{}", found.0.0, found.1.0)))
    };
    match (number, direct.or_else(inverse)) {
        (Some(number), Some(name)) => Some(format!("{number} (or {name})")),
        (Some(number), None) => Some(number),
        (None, Some(name)) => Some(format!("{name} (here {c:.6})")),
        (None, None) => ratio().map(|name| format!("{name} (here {c:.6})")),
    }
}

/// The factors c_p with hand = c_p · true at every point p, if there are any.
fn factors(mask: &Mask) -> Option<Vec<f64>> {
    let factor = |p: usize| {
        let at = mask.of.at[p];
        let entries = mask.entries.iter().map(|&e| (at.hand[e], at.truth[e], at.scale[e]));
        let (top, bottom) = entries.fold((0.0, 0.0), |(a, b), (h, t, s)| (a + h / s * (t / s), b + t / s * (t / s)));
        top / bottom
    };
    let factors: Vec<f64> = (0..mask.of.at.len()).map(factor).collect();
    let fits = || mask.explains(|p, e| factors[p] * mask.truth(p, e));
    (factors.len() > 1 && factors.iter().all(|c| c.is_finite()) && fits()).then_some(factors)
}

/// Diagnosis of a factor that is an argument, its square or its inverse.
pub(super) fn argument(mask: &Mask) -> Option<Diagnosis> {
    // A factor 1 is no mistake, and some arguments may be 1.
    let factors = factors(mask).filter(|all| all.iter().any(|c| (c.abs() - 1.0).abs() > NEARLY_ONE))?;
    let constant = |k: usize, power: i32| {
        let c = |p: usize| factors[p] / mask.of.at[p].x[k].powi(power);
        let varies = factors.iter().any(|x| (x / factors[0] - 1.0).abs() > SAME);
        let same = (1..factors.len()).all(|p| (c(p) / c(0) - 1.0).abs() <= SAME);
        Some(c(0)).filter(|c| same && c.is_finite() && (varies || (c.abs() - 1.0).abs() <= SAME))
    };
    for (k, name) in mask.of.setting.arguments.iter().enumerate() {
        for (power, word) in [(1, ""), (-1, "1/"), (2, "the square of ")] {
            let Some(c) = constant(k, power) else { continue };
            let is_one = (c.abs() - 1.0).abs() <= SAME;
            let number = if is_one { Some(String::new()) } else { likely_name(mask.of, c.abs()).map(|c| c + " ") };
            if let Some(number) = number {
                let minus = if c < 0.0 { "−" } else { "" };
                return Some(mask.says(Mistake::Factor, format!("superfluous factor {minus}{number}{word}{name}")));
            }
        }
    }
    None
}

/// Diagnosis of a factor that differs from point to point.
pub(super) fn varying(mask: &Mask) -> Option<Diagnosis> {
    let factors = factors(mask)?;
    // Any values of a single entry have some ratio.
    let proportional = mask.entries.iter().filter(|&&e| mask.of.at.iter().any(|at| at.truth[e] != 0.0)).count() > 1;
    let range = factors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &c| (a.min(c), b.max(c)));
    let text = format!("a factor that is not constant ({:.4} to {:.4})", range.0, range.1);
    proportional.then(|| mask.says(Mistake::Factor, text))
}
