//! True values at other arguments: another node, one coordinate for another, sine for cosine, degrees, another constant.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;

use super::evidence::Evidence;
use super::mask::Mask;
use crate::check::block::Change;
use crate::check::report::{Diagnosis, Mistake};

/// Diagnosis if the values are true at one of the changed points that the check has named.
pub(super) fn elsewhere(mask: &Mask) -> Option<Diagnosis> {
    mask.of.block.elsewhere.iter().find_map(|(name, other)| {
        let found = is_truth_at(mask, other)?;
        Some(mask.says(Mistake::OtherArgument, format!("{found}evaluated {name},")))
    })
}

/// Sign, in words, with which the user's values are the true ones at changed points; `None` if they are not.
fn is_truth_at(mask: &Mask, change: &dyn Fn(&mut [f64])) -> Option<&'static str> {
    let values = mask.of.truth_at(change);
    let sign = mask.up_to_sign(|p, e| values[p][e])?;
    Some(if sign > 0.0 { "" } else { "with the sign flipped and " })
}

/// An argument that may be confused with another one, the text for it, and the change of a point that reproduces it.
pub(super) struct Confusion<'e> {
    pub(super) argument: usize,
    pub(super) text: String,
    pub(super) change: Change<'e>,
}

/// Diagnosis if one argument was taken for another or has the wrong sign, or if its sine was taken for its cosine.
pub(super) fn confused(mask: &Mask) -> Option<Diagnosis> {
    let any = pairs(0..mask.of.setting.arguments.len()).map(|pair| replaced(mask.of, pair));
    let any = any.take_while(|_| mask.of.is_small());
    confusions(mask.of).into_iter().chain(any).find_map(|Confusion { text, change, .. }| {
        let sign = is_truth_at(mask, &change)?;
        let mut found = mask.says(Mistake::OtherArgument, text);
        found.text += if sign.is_empty() { "" } else { ", and the sign is flipped" };
        Some(found)
    })
}

/// Confusions of a single argument, and of arguments of one kind, which are likelier than confusions of different kinds.
pub(super) fn confusions<'e>(evidence: &Evidence<'e>) -> Vec<Confusion<'e>> {
    if !evidence.is_small() {
        return Vec::new();
    }
    let ranges = || evidence.setting.groups.iter().map(|(_, range)| range.clone());
    let is_constant = |k: usize| evidence.setting.groups.iter().any(|(name, range)| name == "b" && range.contains(&k));
    let alone = |k: usize| {
        let name = name(evidence, k);
        let of = |text: String, change: Change<'e>| Confusion { argument: k, text, change };
        let sine =
            of(format!("sine and cosine of {name} are mistaken for one another"), Box::new(move |x| x[k] += FRAC_PI_2));
        let degrees = |factor: f64| {
            of(format!("looks like degrees instead of radians: {name}"), Box::new(move |x: &mut [f64]| x[k] *= factor))
        };
        let turned = of(format!("{name} has the wrong sign"), Box::new(move |x| x[k] = -x[k]));
        if is_constant(k) { Vec::new() } else { vec![turned, sine, degrees(180.0 / PI), degrees(PI / 180.0)] }
    };
    let alike = || ranges().flat_map(pairs);
    let exchanged = |(k, j): (usize, usize)| {
        let text = format!("{} and {} are exchanged", name(evidence, k), name(evidence, j));
        Confusion { argument: k, text, change: Box::new(move |x| x.swap(k, j)) }
    };
    let exchanged = alike().filter(|(k, j)| k < j).map(exchanged);
    ranges().flatten().flat_map(alone).chain(alike().map(|pair| replaced(evidence, pair))).chain(exchanged).collect()
}

fn replaced<'e>(evidence: &Evidence<'e>, (k, j): (usize, usize)) -> Confusion<'e> {
    let text = format!("{} is used instead of {}", name(evidence, j), name(evidence, k));
    Confusion { argument: k, text, change: Box::new(move |x| x[k] = x[j]) }
}

/// The name of an argument; the one without a name is the factor 1 by which values are multiplied.
fn name<'e>(evidence: &Evidence<'e>, k: usize) -> &'e str {
    Some(evidence.setting.arguments[k].as_str()).filter(|name| !name.is_empty()).unwrap_or("1")
}

/// Diagnosis if one constant has another value than in the formula.
pub(super) fn stale(mask: &Mask) -> Option<Diagnosis> {
    let Evidence { setting, block, at } = mask.of;
    let constants = setting.groups.iter().find(|(name, _)| name == "b").map(|(_, range)| range.clone())?;
    let entry = *mask.entries.first()?;
    let worst = (0..at.len()).max_by(|&a, &b| mask.of.excess(a, entry).total_cmp(&mask.of.excess(b, entry)))?;
    constants.filter(|_| mask.of.is_small() && mask.varies(|p, e| mask.truth(p, e))).find_map(|k| {
        let mut x = at[worst].x.clone();
        let mut error = |value: f64| {
            x[k] = value;
            block.truth.dual(&x)[entry] - at[worst].hand[entry]
        };
        // Secant method; the comparison at all points shows whether it has converged.
        let (mut last, mut value) = (at[worst].x[k], 1.01 * at[worst].x[k]);
        for _ in 0..20 {
            let errors = [error(last), error(value)];
            if errors[0] != errors[1] && value != last {
                (last, value) = (value, value - errors[1] * (value - last) / (errors[1] - errors[0]));
            }
        }
        let there = mask.of.truth_at(&|x| x[k] = value);
        let text = || format!("as if {} were {value:.9} instead of {:.9},", setting.arguments[k], at[worst].x[k]);
        mask.explains(|p, e| there[p][e]).then(|| mask.says(Mistake::OtherArgument, text()))
    })
}

fn pairs(range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    range.clone().flat_map(move |k| range.clone().filter(move |&j| j != k).map(move |j| (k, j)))
}
