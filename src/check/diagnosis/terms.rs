//! Sums with a term that is missing, superfluous or wrong.

use nalgebra::DMatrix;

use super::evidence::Evidence;
use super::factor::{any_name, digits};
use super::mask::Mask;
use crate::check::block::MatrixAt;
use crate::check::place::Place;
use crate::check::report::{Diagnosis, Mistake};

/// Errors below this fraction may be a lack of digits.
const FEW: f64 = 1e-3;
/// Two numbers are the same coefficient if they differ by less than this.
const SAME: f64 = 1e-6;

fn values(mask: &Mask, matrix: &MatrixAt) -> Vec<DMatrix<f64>> {
    mask.of.at.iter().map(|at| matrix(&at.x)).collect()
}

/// Diagnosis if the difference is a multiple of a term of the true value.
pub(super) fn named(mask: &Mask) -> Option<Diagnosis> {
    let terms = mask.of.block.terms.iter().map(|(name, matrix)| (name, values(mask, matrix)));
    let fitting: Vec<_> = terms.filter_map(|(name, term)| Some((name, coefficient(mask, &term)?))).collect();
    let simple = fitting.iter().find(|(_, c)| [-1.0, 1.0, -2.0].iter().any(|s| (c - s).abs() < SAME));
    // A small multiple of a term may be a lack of digits.
    let any = || fitting.first().filter(|_| few_digits(mask).is_none());
    if let Some((name, c)) = simple.or_else(any) {
        return Some(describe(mask, name, *c));
    }
    turned(mask)
}

/// Diagnosis if the difference is a multiple of a matrix that does not belong to the block.
pub(super) fn of_other_blocks(mask: &Mask) -> Option<Diagnosis> {
    if few_digits(mask).is_some() {
        return None;
    }
    mask.of.block.others.iter().find_map(|(name, matrix)| {
        let c = coefficient(mask, &values(mask, matrix))?;
        let text = format!("the difference is {c:.6} times {name}, which does not belong here,");
        Some(mask.says(Mistake::TermWrong, text))
    })
}

/// Diagnosis if one named term was evaluated at another point than the others.
pub(super) fn displaced(mask: &Mask) -> Option<Diagnosis> {
    mask.of.block.terms.iter().find_map(|(name, matrix)| {
        let here = values(mask, matrix);
        mask.of.block.elsewhere.iter().find_map(|(place, change)| {
            let there = |at: &&Place| {
                let mut x = at.x.clone();
                change(&mut x);
                matrix(&x)
            };
            let there: Vec<DMatrix<f64>> = mask.of.at.iter().map(there).collect();
            let says = || mask.says(Mistake::OtherArgument, format!("the term {name} is evaluated {place},"));
            mask.explains(|p, e| mask.truth(p, e) + there[p][e] - here[p][e]).then(says)
        })
    })
}

/// Diagnosis if a named term was transposed.
fn turned(mask: &Mask) -> Option<Diagnosis> {
    if mask.of.rows() != mask.of.columns() {
        return None;
    }
    let changed = |(name, matrix): &(String, MatrixAt)| {
        let term = values(mask, matrix);
        if term.iter().any(|term| !term.is_square()) {
            return None;
        }
        let term: Vec<DMatrix<f64>> = term.into_iter().map(|term| term.transpose() - term).collect();
        let c = coefficient(mask, &term)?;
        let says = || mask.says(Mistake::Transposed, format!("the term {name} is transposed"));
        ((c - 1.0).abs() < SAME).then(says)
    };
    mask.of.block.terms.iter().find_map(changed)
}

/// The c with hand − true = c · term, if there is one.
fn coefficient(mask: &Mask, term: &[DMatrix<f64>]) -> Option<f64> {
    if term.iter().zip(&mask.of.at).any(|(term, at)| term.shape() != at.truth.shape()) {
        return None;
    }
    mask.multiple(|p, e| mask.truth(p, e), |p, e| term[p][e]).filter(|c| c.abs() > SAME)
}

pub(super) fn describe(mask: &Mask, name: &str, c: f64) -> Diagnosis {
    let is = |x: f64| (c - x).abs() < SAME;
    let (mistake, words) = if is(-1.0) {
        (Mistake::TermMissing, "term missing".into())
    } else if is(1.0) {
        (Mistake::TermWrong, "term counted twice".into())
    } else if is(-2.0) {
        (Mistake::TermWrong, "sign of a term flipped".into())
    } else {
        (Mistake::TermWrong, format!("a term has the factor {} instead of 1", any_name(mask.of, 1.0 + c)))
    };
    mask.says(mistake, format!("{words}: {name},"))
}

/// Diagnosis if the matrix is the true value of another block.
pub(super) fn other_block(mask: &Mask) -> Option<Diagnosis> {
    let is = |(name, matrix): &(String, MatrixAt)| {
        let values = values(mask, matrix);
        if values.iter().any(|v| v.shape() != (mask.of.rows(), mask.of.columns())) {
            return None;
        }
        let sign = mask.up_to_sign(|p, e| values[p][e])?;
        let minus = if sign > 0.0 { "" } else { "−" };
        Some(mask.says(Mistake::OtherBlock, format!("these are the values of {minus}{name} instead,")))
    };
    mask.of.block.others.iter().find_map(is)
}

/// Diagnosis if the difference is a multiple of the part due to one argument: true(x) − true(x with this argument 0).
pub(super) fn of_arguments(mask: &Mask) -> Option<Diagnosis> {
    let Evidence { setting, at, .. } = mask.of;
    if !mask.of.is_small() {
        return None;
    }
    let groups = &setting.groups;
    let single = groups.iter().flat_map(|(_, range)| range.clone().map(|k| (setting.arguments[k].clone(), k..k + 1)));
    let several = groups.iter().filter(|(_, range)| range.len() > 1).map(|(name, range)| (name.clone(), range.clone()));
    // Coordinates come last: they enter nonlinearly and seldom form a term.
    let mut candidates: Vec<_> = single.chain(several).collect();
    let coordinates = groups.iter().find(|(name, _)| name == "q").map_or(0..0, |(_, range)| range.clone());
    candidates.sort_by_key(|(_, range)| coordinates.contains(&range.start));
    let fitting: Vec<(String, f64)> = candidates
        .into_iter()
        .filter_map(|(name, range)| {
            let without = mask.of.truth_at(&|x| x[range.clone()].fill(0.0));
            let term: Vec<DMatrix<f64>> = at.iter().zip(&without).map(|(at, without)| &at.truth - without).collect();
            Some((name, coefficient(mask, &term)?))
        })
        .collect();
    // A missing term is likelier than one with another factor, even if both fit.
    let with = |wanted: f64| fitting.iter().find(move |(_, c)| (c - wanted).abs() < SAME);
    let (name, c) = with(-1.0).or_else(|| with(-2.0)).or_else(|| with(1.0))?;
    Some(describe(mask, &format!("the part that comes from {name}"), *c))
}

/// Diagnosis of values that are right in the leading digits only.
pub(super) fn few_digits(mask: &Mask) -> Option<Diagnosis> {
    let errors =
        |at: &Place| mask.entries.iter().map(|&e| (at.hand[e] - at.truth[e]).abs() / at.scale[e]).fold(0.0, f64::max);
    let worst = mask.of.at.iter().map(|at| errors(at)).fold(0.0, f64::max);
    let digits = digits(worst);
    // The place is in the middle of the text.
    let few = mask.says(Mistake::FewDigits, format!("right to {digits} digits only"));
    let text = few.text + ": a constant with too few digits, a difference quotient, or a small term missing";
    (worst < FEW).then_some(Diagnosis { text, ..few })
}
