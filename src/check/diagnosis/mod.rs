//! Diagnosis of a difference: tries common mistakes, from the simplest to the least specific.
//!
//! Every guess must reproduce the user's values to the tolerance of the comparison at all points, so a coincidence
//! is unlikely. Guesses are tried on the whole block, then on its wrong entries, then on the wrong entries
//! of each row, each column, and one by one.

mod arguments;
mod chain;
mod evidence;
mod exchange;
mod factor;
mod mask;
mod sides;
mod terms;

use super::place::Place;
use super::report::{Diagnosis, Mistake};
use chain::Chain;
use evidence::At;
pub(crate) use evidence::Evidence;
use mask::{Lines, Mask};

/// Blocks with more wrong entries than this are not diagnosed entry by entry.
const MOST_SINGLE: usize = 6;
/// Blocks with more wrong rows than this are only split if all of them have an explanation.
const MOST_SPLIT: usize = 3;

/// Diagnosis of wrong numbers of rows and columns.
pub(crate) fn shape(evidence: &Evidence) -> Option<Diagnosis> {
    let Place { hand, truth, .. } = evidence.at.iter().find(|at| at.hand.shape() != at.truth.shape())?;
    let ((rows, columns), (r, c)) = (hand.shape(), truth.shape());
    if rows == 1 && columns == 1 && hand[0].is_nan() {
        return Some(Diagnosis::new(Mistake::NotFinite, "the given value is NaN instead of a matrix".into()));
    }
    let sizes = format!("{rows}×{columns} instead of {r}×{c}");
    let is_turned = (rows, columns) == (c, r);
    Some(if is_turned && (hand.transpose() - truth).amax() <= 1e-9 * truth.amax() {
        Diagnosis::new(Mistake::Transposed, format!("transposed: {sizes}, with the right values"))
    } else if is_turned {
        Diagnosis::new(Mistake::Shape, format!("{sizes}: transposed, and with wrong values"))
    } else {
        Diagnosis::new(Mistake::Shape, sizes)
    })
}

/// Diagnoses of all differences of a block.
pub(crate) fn diagnose(evidence: &Evidence) -> Vec<Diagnosis> {
    let (wrong, chain) = (&Mask::wrong(evidence), &Chain::record(evidence));
    if let Some(found) = known(wrong, chain).or_else(|| vague(wrong)) {
        return vec![found];
    }
    let rest = |mask: &Mask| mask.says(Mistake::Unexplained, "no simple explanation");
    let split = |masks: Vec<Mask>| -> Option<Vec<Diagnosis>> {
        let found: Vec<_> = masks.iter().map(|mask| (mask, part(mask, chain).or_else(|| vague(mask)))).collect();
        let explained = found.iter().filter(|(_, found)| found.is_some()).count();
        let helps = masks.len() > 1 && explained > 0 && (explained == masks.len() || masks.len() <= MOST_SPLIT);
        helps.then(|| found.into_iter().map(|(mask, f)| f.unwrap_or_else(|| rest(mask))).collect())
    };
    let singles = if wrong.entries.len() <= MOST_SINGLE { wrong.singles() } else { Vec::new() };
    let best = [split(wrong.by(Lines::Rows)), split(wrong.by(Lines::Columns)), split(singles)]
        .into_iter()
        .flatten()
        .min_by_key(|found| badness(found));
    best.unwrap_or_else(|| vec![rest(wrong)])
}

/// A mistake that explains all differences.
fn known(wrong: &Mask, chain: &Option<Chain>) -> Option<Diagnosis> {
    not_finite(wrong).or_else(|| whole(wrong)).or_else(|| sides::one_sided(wrong, chain)).or_else(|| part(wrong, chain))
}

/// Rank of a set of diagnoses: few unexplained mistakes come first, then few mistakes.
fn badness(found: &[Diagnosis]) -> (usize, usize) {
    (found.iter().filter(|d| d.mistake == Mistake::Unexplained).count(), found.len())
}

/// Mistakes that concern the block as a whole.
fn whole(wrong: &Mask) -> Option<Diagnosis> {
    let all = &Mask::all(wrong.of);
    factor::sign(all)
        .or_else(|| factor::zero(all))
        .or_else(|| exchange::transposed(all))
        .or_else(|| factor::likely(all))
        .or_else(|| terms::named(all))
        .or_else(|| terms::other_block(all))
        .or_else(|| arguments::elsewhere(all))
        .or_else(|| exchange::rows_or_columns(wrong))
        .or_else(|| factor::argument(all))
}

/// Mistakes in some of the entries.
fn part(mask: &Mask, chain: &Option<Chain>) -> Option<Diagnosis> {
    factor::not_zero(mask)
        .or_else(|| factor::sign(mask))
        .or_else(|| factor::zero(mask))
        .or_else(|| factor::likely(mask))
        .or_else(|| terms::named(mask))
        .or_else(|| exchange::transposed(mask))
        .or_else(|| exchange::entries(mask))
        .or_else(|| terms::of_arguments(mask))
        .or_else(|| arguments::confused(mask))
        .or_else(|| arguments::elsewhere(mask))
        .or_else(|| terms::displaced(mask))
        .or_else(|| chain.as_ref()?.wrong_step(mask))
        .or_else(|| chain.as_ref()?.confused_step(mask))
        .or_else(|| factor::constant(mask))
        .or_else(|| factor::argument(mask))
        .or_else(|| arguments::stale(mask))
        .or_else(|| chain.as_ref()?.unlikely_step(mask))
        .or_else(|| terms::of_other_blocks(mask))
}

/// Common property of differences that no mistake explains.
fn vague(mask: &Mask) -> Option<Diagnosis> {
    factor::varying(mask).or_else(|| terms::few_digits(mask))
}

fn not_finite(wrong: &Mask) -> Option<Diagnosis> {
    let bad = |entry: &At| wrong.of.at.iter().any(|at| !at.hand[*entry].is_finite());
    let mask = wrong.only(bad);
    (!mask.entries.is_empty()).then(|| mask.says(Mistake::NotFinite, "infinite or not a number"))
}
