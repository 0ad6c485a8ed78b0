//! Multiples of the true value: −1, 0, a constant, an argument.

use std::f64::consts::{FRAC_PI_2, PI};

use super::Evidence;
use super::mask::Mask;
use crate::check::report::{Diagnosis, Mistake};

/// Two numbers are the same factor if they differ by less than this.
const SAME: f64 = 1e-7;
/// A factor nearer to 1 than this is a matter of digits.
const NEARLY_ONE: f64 = 1e-3;

/// Whether the true values are zero in these entries.
fn is_zero(evidence: &Evidence, mask: &Mask) -> bool {
    let zero = |p: usize, &(i, j): &(usize, usize)| evidence.at[p].truth[(i, j)].abs() <= evidence.at[p].tolerance[(i, j)];
    (0..evidence.at.len()).all(|p| mask.entries.iter().all(|entry| zero(p, entry)))
}

pub(super) fn sign(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    let flipped = !is_zero(evidence, mask) && evidence.explains(mask, |p, e| -evidence.at[p].truth[e]);
    flipped.then(|| mask.says(evidence, Mistake::SignFlipped, "sign flipped"))
}

pub(super) fn zero(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    let absent = !is_zero(evidence, mask) && evidence.at.iter().all(|at| mask.entries.iter().all(|&e| at.hand[e] == 0.0));
    absent.then(|| mask.says(evidence, Mistake::Zero, "zero where it should not be,"))
}

pub(super) fn not_zero(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    is_zero(evidence, mask).then(|| mask.says(evidence, Mistake::NotZero, "not zero where it should be,"))
}

/// The constant c with hand = c · true, if there is one.
fn constant_factor(evidence: &Evidence, mask: &Mask) -> Option<f64> {
    let truth = |p: usize, e: (usize, usize)| evidence.at[p].truth[e];
    let c = evidence.product(mask, |p, e| evidence.at[p].hand[e], truth) / evidence.product(mask, truth, truth);
    (c.is_finite() && evidence.explains(mask, |p, e| c * truth(p, e))).then_some(c)
}

/// A constant factor that people are likely to forget.
pub(super) fn likely(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    let c = constant_factor(evidence, mask)?;
    let name = name(evidence, c, &LIKELY)?;
    Some(mask.says(evidence, Mistake::Factor, format!("constant factor {name}")))
}

/// Any constant factor.
pub(super) fn constant(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    let c = constant_factor(evidence, mask)?;
    if (c - 1.0).abs() < NEARLY_ONE {
        let text = format!("right to {} digits only (constant factor 1 {:+.1e})", digits(c - 1.0), c - 1.0);
        return Some(mask.says(evidence, Mistake::FewDigits, text));
    }
    let name = name(evidence, c, &LIKELY).or_else(|| name(evidence, c, &POSSIBLE)).unwrap_or_else(|| format!("{c:.9}"));
    Some(mask.says(evidence, Mistake::Factor, format!("constant factor {name}")))
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

/// "2", "½", "γ (here 100)", "−1/`mass` (here −1.25)", or more than one of them.
fn name(evidence: &Evidence, c: f64, plain: &[(f64, &str)]) -> Option<String> {
    let same = |x: f64| (c.abs() / x.abs() - 1.0).abs() < SAME;
    let signed = |x: f64, name: String| if c * x < 0.0 { format!("−{name}") } else { name };
    let number = plain.iter().find(|(x, _)| same(*x)).map(|(x, name)| signed(*x, name.to_string()));
    let named = evidence.setting.factors.iter().filter(|(_, x)| *x != 0.0 && x.abs() != 1.0);
    let direct = named.clone().find(|(_, x)| same(*x)).map(|(name, x)| signed(*x, name.clone()));
    let inverse = || named.clone().find(|(_, x)| same(1.0 / x)).map(|(name, x)| signed(*x, format!("1/{name}")));
    match (number, direct.or_else(inverse)) {
        (Some(number), Some(name)) => Some(format!("{number} (or {name})")),
        (Some(number), None) => Some(number),
        (None, Some(name)) => Some(format!("{name} (here {c:.6})")),
        (None, None) => None,
    }
}

/// The factor c_p of every point with hand = c_p · true, if there is one.
fn factors(evidence: &Evidence, mask: &Mask) -> Option<Vec<f64>> {
    let factor = |p: usize| {
        let entries =
            mask.entries.iter().map(|&e| (evidence.at[p].hand[e], evidence.at[p].truth[e], evidence.at[p].scale[e]));
        let (top, bottom) = entries.fold((0.0, 0.0), |(a, b), (h, t, s)| (a + h / s * (t / s), b + t / s * (t / s)));
        top / bottom
    };
    let factors: Vec<f64> = (0..evidence.at.len()).map(factor).collect();
    let fits = || evidence.explains(mask, |p, e| factors[p] * evidence.at[p].truth[e]);
    (factors.len() > 1 && factors.iter().all(|c| c.is_finite()) && fits()).then_some(factors)
}

/// A factor that is the value of an argument, its square or its inverse.
pub(super) fn argument(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    // Nothing is multiplied by 1, which some arguments may be.
    let factors = factors(evidence, mask).filter(|all| all.iter().any(|c| (c.abs() - 1.0).abs() > NEARLY_ONE))?;
    let is = |k: usize, power: i32, sign: f64| {
        let expected = |p: usize| sign * evidence.at[p].x[k].powi(power);
        factors.iter().enumerate().all(|(p, c)| (c - expected(p)).abs() <= SAME * c.abs())
    };
    for (k, name) in evidence.setting.arguments.iter().enumerate() {
        for (power, word) in [(1, ""), (-1, "1/"), (2, "the square of ")] {
            if let Some(sign) = [1.0, -1.0].into_iter().find(|&sign| is(k, power, sign)) {
                let minus = if sign < 0.0 { "−" } else { "" };
                return Some(mask.says(evidence, Mistake::Factor, format!("factor {minus}{word}{name} too much")));
            }
        }
    }
    None
}

/// Proportional to the true values by a factor that differs from point to point.
pub(super) fn varying(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    let factors = factors(evidence, mask)?;
    // With one entry any values have some ratio.
    let proportional = mask.entries.iter().filter(|&&e| evidence.at.iter().any(|at| at.truth[e] != 0.0)).count() > 1;
    let range = factors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &c| (a.min(c), b.max(c)));
    let text = format!("a factor that is no constant ({:.4} to {:.4})", range.0, range.1);
    proportional.then(|| mask.says(evidence, Mistake::Factor, text))
}
