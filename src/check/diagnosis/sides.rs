//! Blocks that are wrong on one side of a threshold only, for example where an argument is negative, or beyond an end stop.

use super::chain::Chain;
use super::evidence::Evidence;
use super::known;
use super::mask::Mask;
use crate::check::matrix::fitting;
use crate::check::report::{Diagnosis, Mistake};
use crate::number::Random;

/// Number of additional points, each with arguments of two others.
const MIXED: usize = 64;
/// Required odds against a coincidence, for every quantity and side that is tried.
const ODDS: f64 = 1e3;
/// An error above this multiple of its tolerance is certain, one below 1 is none, and points between are left out.
const CLEAR: f64 = 100.0;

/// Diagnosis of a block that is wrong on one side of a threshold only, with the mistake there.
pub(super) fn one_sided(mask: &Mask, chain: &Option<Chain>) -> Option<Diagnosis> {
    let evidence = mask.of;
    let is_wrong = |p: usize| mask.entries.iter().any(|&entry| evidence.excess(p, entry) > 1.0);
    let wrong: Vec<bool> = (0..evidence.at.len()).map(is_wrong).collect();
    if wrong.iter().all(|wrong| *wrong) {
        return None;
    }
    if let Some(found) = chain.as_ref().and_then(|chain| chain.wrong_step(mask)) {
        return Some(found);
    }
    let mut points: Vec<(Vec<f64>, bool)> = evidence.at.iter().map(|at| at.x.clone()).zip(wrong.iter().copied()).collect();
    points.extend(mixed(evidence));
    let side = threshold(evidence, chain, &points)?;
    let at: Vec<_> = evidence.at.iter().zip(&wrong).filter(|(_, wrong)| **wrong).map(|(at, _)| *at).collect();
    let there = Evidence { at, ..*evidence };
    let found = known(&Mask::wrong(&there), &Chain::record(&there));
    let text = found.map_or_else(|| Mask::wrong(&there).place(), |found| found.text);
    Some(Diagnosis::new(Mistake::OneSided, format!("wrong only where {side}: {text}")))
}

/// Points with arguments of two others, each with `true` if the block is wrong there.
fn mixed(evidence: &Evidence) -> Vec<(Vec<f64>, bool)> {
    let Evidence { block, setting, at } = evidence;
    let random = &mut Random::new(setting.seed ^ 0x51de);
    let mut tolerance = at[0].tolerance.clone();
    at.iter().for_each(|at| tolerance.zip_apply(&at.tolerance, |a, b| *a = a.max(b)));
    let mix = |_| {
        let [a, b] = [(); 2].map(|()| &at[random.below(at.len())].x);
        let mut x: Vec<f64> = a.iter().zip(b).map(|(a, b)| if random.below(2) == 0 { *a } else { *b }).collect();
        (setting.settle)(&mut x);
        if !(setting.admissible)(&x) {
            return None;
        }
        let truth = block.truth.dual(&x);
        let hand = fitting((block.hand)(&x), evidence.rows(), evidence.columns());
        let error = (hand.shape() == truth.shape()).then(|| (hand - truth).zip_map(&tolerance, |e, t| e.abs() / t).max())?;
        (error <= 1.0 || error > CLEAR).then_some((x, error > CLEAR))
    };
    (0..MIXED).filter_map(mix).collect()
}

/// "`v` < 0": the quantity that separates the wrong points from the right ones, if a coincidence is unlikely.
fn threshold(evidence: &Evidence, chain: &Option<Chain>, points: &[(Vec<f64>, bool)]) -> Option<String> {
    let (all, wrong) = (points.len(), points.iter().filter(|(_, wrong)| *wrong).count());
    // Number of ways to choose the wrong points among all.
    let ways: f64 = (0..wrong.min(all - wrong)).map(|k| (all - k) as f64 / (k + 1) as f64).product();
    let names = evidence.setting.arguments.iter().enumerate().filter(|(_, name)| !name.is_empty());
    let arguments = names.flat_map(|(k, name)| {
        let values: Vec<f64> = points.iter().map(|(x, _)| x[k]).collect();
        let sizes = values.iter().map(|x| x.abs()).collect();
        [(name.clone(), values), (format!("|{name}|"), sizes)]
    });
    let nodes = chain.iter().flat_map(|chain| chain.quantities(points));
    let quantities: Vec<(String, Vec<f64>)> = arguments.chain(nodes).collect();
    if ways < ODDS * 2.0 * quantities.len() as f64 {
        return None;
    }
    quantities.iter().find_map(|(name, values)| {
        let range = |wanted: bool| {
            let of = values.iter().zip(points).filter(|(_, (_, wrong))| *wrong == wanted).map(|(s, _)| *s);
            of.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)))
        };
        let (wrong, right) = (range(true), range(false));
        let (sign, low, high) = match (wrong, right) {
            ((_, end), (begin, _)) if end < begin => ("<", end, begin),
            ((begin, _), (_, end)) if end < begin => (">", end, begin),
            _ => return None,
        };
        let zero = low <= 0.0 && high >= 0.0;
        let near = if zero { "0".to_string() } else { format!("a value between {low:.3} and {high:.3}") };
        Some(format!("{name} {sign} {near}"))
    })
}
