//! The true value of other arguments: another node, one coordinate for another, sine for cosine.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use super::Evidence;
use super::mask::Mask;
use crate::check::matrix::fitting;
use crate::check::report::{Diagnosis, Mistake};

/// Whether the values are true at another point that the front end has named.
pub(super) fn elsewhere(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    evidence.block.elsewhere.iter().find_map(|(name, other)| {
        let found = is_truth_at(evidence, mask, other)?;
        Some(mask.says(evidence, Mistake::OtherArgument, format!("{found}evaluated {name},")))
    })
}

/// Whether the user's values are the true ones at other points, up to the sign, which is returned.
fn is_truth_at(evidence: &Evidence, mask: &Mask, other: impl Fn(&[f64]) -> Vec<f64>) -> Option<&'static str> {
    let values = evidence.truth_at(other);
    let sign = evidence.up_to_sign(mask, |p, e| values[p][e])?;
    Some(if sign > 0.0 { "" } else { "with the sign flipped and " })
}

/// Whether one argument was taken for another, or with the wrong sign, or its sine for its cosine.
pub(super) fn confused(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    if !evidence.is_small() {
        return None;
    }
    let setting = evidence.setting;
    // What has no name is the 1 that values are multiplied by.
    let name = |k: usize| Some(setting.arguments[k].as_str()).filter(|name| !name.is_empty()).unwrap_or("1");
    let found = |sign: &str, text: String| {
        let mut found = mask.says(evidence, Mistake::OtherArgument, text);
        found.text += if sign.is_empty() { "" } else { ", and the sign is flipped" };
        Some(found)
    };
    let ranges = || setting.groups.iter().map(|(_, range)| range.clone());
    for k in ranges().flatten() {
        if let Some(sign) = is_truth_at(evidence, mask, |x| changed(x, |x| x[k] = -x[k])) {
            return found(sign, format!("{} has the wrong sign", name(k)));
        }
        if let Some(sign) = is_truth_at(evidence, mask, |x| changed(x, |x| x[k] += FRAC_PI_2)) {
            return found(sign, format!("sine and cosine of {} are mistaken for one another", name(k)));
        }
    }
    // Arguments of one kind are confused more often than those of different kinds.
    let alike = ranges().flat_map(|range| pairs(&range).collect::<Vec<_>>());
    let count = setting.arguments.len();
    for (k, j) in alike.chain(pairs(&(0..count))) {
        if let Some(sign) = is_truth_at(evidence, mask, |x| changed(x, |x| x[k] = x[j])) {
            return found(sign, format!("{} stands where {} belongs", name(j), name(k)));
        }
    }
    for (k, j) in ranges().flat_map(|range| pairs(&range).collect::<Vec<_>>()).filter(|(k, j)| k < j) {
        if let Some(sign) = is_truth_at(evidence, mask, |x| changed(x, |x| x.swap(k, j))) {
            return found(sign, format!("{} and {} are exchanged", name(k), name(j)));
        }
    }
    None
}

/// The point with a change.
pub(super) fn changed(x: &[f64], change: impl Fn(&mut Vec<f64>)) -> Vec<f64> {
    let mut x = x.to_vec();
    change(&mut x);
    x
}

fn pairs(range: &Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    let (first, last) = (range.clone(), range.clone());
    first.flat_map(move |k| last.clone().filter(move |&j| j != k).map(move |j| (k, j)))
}

/// Arguments without which the error is gone: a hint where nothing else fits.
pub(super) fn where_it_vanishes(evidence: &Evidence) -> Vec<String> {
    if !evidence.is_small() {
        return Vec::new();
    }
    let groups = evidence.setting.groups.iter();
    let single = evidence.setting.arguments.iter().enumerate().map(|(k, name)| (name, k..k + 1));
    let candidates = groups.map(|(name, range)| (name, range.clone())).chain(single);
    let gone = |range: &Range<usize>| {
        evidence.at.iter().all(|at| {
            let x = changed(&at.x, |x| x[range.clone()].fill(0.0));
            let truth = evidence.block.truth.dual(&x);
            // Where nobody has to have an answer, none is asked for.
            if !(evidence.setting.admissible)(&x) || truth.iter().any(|x| !x.is_finite()) {
                return false;
            }
            let hand = fitting((evidence.block.hand)(&x), evidence.rows(), evidence.columns());
            let holds = |(i, t): (usize, &f64)| (hand[i] - truth[i]).abs() <= *t;
            hand.shape() == truth.shape() && at.tolerance.iter().enumerate().all(holds)
        })
    };
    let names: Vec<&str> = candidates.filter(|(_, range)| gone(range)).map(|(name, _)| name.as_str()).take(4).collect();
    if names.is_empty() { Vec::new() } else { vec![format!("the error vanishes where {} is zero", names.join(" or "))] }
}
