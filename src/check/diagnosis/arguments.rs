//! The true value of other arguments: another node, one coordinate for another, sine for cosine.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use super::Evidence;
use super::mask::Mask;
use crate::check::matrix::fitting;
use crate::check::report::{Diagnosis, Mistake};

/// Whether the values are true at another point that the front end has named.
pub(super) fn elsewhere(mask: &Mask) -> Option<Diagnosis> {
    mask.of.block.elsewhere.iter().find_map(|(name, other)| {
        let found = is_truth_at(mask, other)?;
        Some(mask.says(Mistake::OtherArgument, format!("{found}evaluated {name},")))
    })
}

/// Whether the user's values are the true ones at points with a change, up to the sign, which is returned.
fn is_truth_at(mask: &Mask, change: &dyn Fn(&mut [f64])) -> Option<&'static str> {
    let values = mask.of.truth_at(change);
    let sign = mask.up_to_sign(|p, e| values[p][e])?;
    Some(if sign > 0.0 { "" } else { "with the sign flipped and " })
}

/// Whether one argument was taken for another, or with the wrong sign, or its sine for its cosine.
pub(super) fn confused(mask: &Mask) -> Option<Diagnosis> {
    if !mask.of.is_small() {
        return None;
    }
    let setting = mask.of.setting;
    // What has no name is the 1 that values are multiplied by.
    let name = |k: usize| Some(setting.arguments[k].as_str()).filter(|name| !name.is_empty()).unwrap_or("1");
    let explained = |change: &dyn Fn(&mut [f64]), text: &dyn Fn() -> String| {
        let sign = is_truth_at(mask, change)?;
        let mut found = mask.says(Mistake::OtherArgument, text());
        found.text += if sign.is_empty() { "" } else { ", and the sign is flipped" };
        Some(found)
    };
    let alone = |k: usize| {
        let turned = explained(&|x| x[k] = -x[k], &|| format!("{} has the wrong sign", name(k)));
        let text = || format!("sine and cosine of {} are mistaken for one another", name(k));
        turned.or_else(|| explained(&|x| x[k] += FRAC_PI_2, &text))
    };
    let replaced = |(k, j)| explained(&|x| x[k] = x[j], &|| format!("{} stands where {} belongs", name(j), name(k)));
    let exchanged = |(k, j)| explained(&|x| x.swap(k, j), &|| format!("{} and {} are exchanged", name(k), name(j)));
    let ranges = || setting.groups.iter().map(|(_, range)| range.clone());
    // Arguments of one kind are confused more often than those of different kinds.
    let alike = || ranges().flat_map(pairs);
    let any = pairs(0..setting.arguments.len());
    let found = ranges().flatten().find_map(alone).or_else(|| alike().chain(any).find_map(replaced));
    found.or_else(|| alike().filter(|(k, j)| k < j).find_map(exchanged))
}

fn pairs(range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    range.clone().flat_map(move |k| range.clone().filter(move |&j| j != k).map(move |j| (k, j)))
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
            let mut x = at.x.clone();
            x[range.clone()].fill(0.0);
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
