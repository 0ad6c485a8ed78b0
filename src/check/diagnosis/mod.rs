//! What a difference looks like: tries the mistakes that people make, from the simplest to the least specific.
//!
//! Every guess must reproduce the user's values to the tolerance of the comparison at all points, so a guess that
//! holds is hardly a coincidence. Guesses are tried on the whole block, then on its wrong entries, then on the wrong entries
//! of each row, each column, and one by one.

mod arguments;
mod exchange;
mod factor;
mod mask;
mod terms;

use nalgebra::DMatrix;

use super::place::Place;
use super::plan::{Block, Setting};
use super::report::{Diagnosis, Mistake};
use mask::{Lines, Mask};

/// Slack on the tolerance when a guess is compared with the user's values.
const SLACK: f64 = 8.0;
/// What a guess may be off by, relative to itself, whatever the size of the entry is.
const ROUNDING: f64 = 1e-13;
/// More wrong entries than this are not looked at one by one.
const MOST_SINGLE: usize = 6;
/// A block with more wrong rows than this is only split if all of them have an explanation.
const MOST_SPLIT: usize = 3;

/// A block at the points where it is judged.
pub(crate) struct Evidence<'a> {
    pub block: &'a Block<'a>,
    pub setting: &'a Setting<'a>,
    pub at: Vec<&'a Place>,
}

impl Evidence<'_> {
    /// The first points, and the worst of the others.
    pub(crate) fn with_worst(mut self, first: usize, most: usize) -> Self {
        let all = Mask::all(&self).entries;
        let worst = |p: usize| all.iter().map(|&entry| self.excess(p, entry)).fold(0.0, f64::max);
        let excesses: Vec<f64> = (0..self.at.len()).map(worst).collect();
        let mut others: Vec<_> = self.at.drain(first..).zip(excesses.into_iter().skip(first)).collect();
        others.sort_by(|a, b| b.1.total_cmp(&a.1));
        self.at.extend(others.into_iter().take(most).map(|(at, _)| at));
        self
    }

    /// |hand − true| relative to its tolerance; more than 1 is wrong.
    pub(crate) fn excess(&self, p: usize, entry: (usize, usize)) -> f64 {
        match self.difference(p, entry).abs() {
            0.0 => 0.0,
            error if error.is_nan() => f64::INFINITY,
            error => error / self.at[p].tolerance[entry],
        }
    }

    /// Whether the user's values are the expected ones in these entries, at all points, and these are not just the true ones: what
    /// hardly differs from the truth is no reason for an error that is hardly one.
    fn explains(&self, mask: &Mask, expected: impl Fn(usize, (usize, usize)) -> f64) -> bool {
        let differs = |p: usize, &e: &(usize, usize)| {
            let error = (expected(p, e) - self.at[p].truth[e]).abs();
            error.is_nan() || error > self.at[p].tolerance[e]
        };
        let is_another = || (0..self.at.len()).any(|p| mask.entries.iter().any(|entry| differs(p, entry)));
        self.holds(mask, &expected) && is_another()
    }

    /// The sign with which the expected values explain the user's, if one does.
    fn up_to_sign(&self, mask: &Mask, expected: impl Fn(usize, (usize, usize)) -> f64) -> Option<f64> {
        [1.0, -1.0].into_iter().find(|sign| self.explains(mask, |p, e| sign * expected(p, e)))
    }

    /// Whether the user's values are the expected ones in these entries, at all points.
    fn holds(&self, mask: &Mask, expected: impl Fn(usize, (usize, usize)) -> f64) -> bool {
        let within = |p: usize, &e: &(usize, usize)| {
            let x = expected(p, e);
            // A multiple of the true value has a multiple of its rounding, and another entry's value the rounding of that.
            let grown = (x / self.at[p].truth[e]).abs().max(1.0);
            let grown = if grown.is_finite() { grown } else { 1.0 };
            let within = (grown * self.at[p].tolerance[e]).max(ROUNDING * x.abs());
            x.is_finite() && (self.at[p].hand[e] - x).abs() <= SLACK * within
        };
        (0..self.at.len()).all(|p| mask.entries.iter().all(|entry| within(p, entry)))
    }

    /// Σ a b over entries and points, in units of the entries' sizes.
    fn product(
        &self,
        mask: &Mask,
        a: impl Fn(usize, (usize, usize)) -> f64,
        b: impl Fn(usize, (usize, usize)) -> f64,
    ) -> f64 {
        let term = |p: usize, &e: &(usize, usize)| {
            let size = self.at[p].scale[e].max(f64::MIN_POSITIVE);
            a(p, e) / size * (b(p, e) / size)
        };
        (0..self.at.len()).map(|p| mask.entries.iter().map(|entry| term(p, entry)).sum::<f64>()).sum()
    }

    fn difference(&self, p: usize, entry: (usize, usize)) -> f64 {
        self.at[p].hand[entry] - self.at[p].truth[entry]
    }

    pub(crate) fn rows(&self) -> usize {
        self.block.rows.len()
    }

    pub(crate) fn columns(&self) -> usize {
        self.block.columns.len()
    }

    /// The true block at other points.
    fn truth_at(&self, other: impl Fn(&[f64]) -> Vec<f64>) -> Vec<DMatrix<f64>> {
        self.at.iter().map(|at| self.block.truth.dual(&other(&at.x))).collect()
    }

    /// Whether there are groups of arguments, and few enough to try all of them one by one.
    fn is_small(&self) -> bool {
        !self.setting.groups.is_empty() && self.setting.arguments.len() <= 48
    }
}

/// Wrong numbers of rows and columns.
pub(crate) fn shape(evidence: &Evidence) -> Option<Diagnosis> {
    let Place { hand, truth, .. } = evidence.at.iter().find(|at| at.hand.shape() != at.truth.shape())?;
    let ((rows, columns), (r, c)) = (hand.shape(), truth.shape());
    if rows == 1 && columns == 1 && hand[0].is_nan() {
        return Some(diagnosis(Mistake::NotFinite, "no matrix was given, but NaN alone".into()));
    }
    let turned = (rows, columns) == (c, r);
    let same = turned && (hand.transpose() - truth).amax() <= 1e-9 * truth.amax();
    Some(match (turned, same) {
        (_, true) => {
            diagnosis(Mistake::Transposed, format!("transposed: {rows}×{columns} instead of {r}×{c}, with the right values"))
        }
        (true, _) => diagnosis(
            Mistake::Shape,
            format!("{rows}×{columns} instead of {r}×{c}: transposed, and wrong in its values too"),
        ),
        _ => diagnosis(Mistake::Shape, format!("{rows}×{columns} instead of {r}×{c}")),
    })
}

fn diagnosis(mistake: Mistake, text: String) -> Diagnosis {
    Diagnosis { mistake, text }
}

/// What the differences look like, and further observations.
pub(crate) fn diagnose(evidence: &Evidence) -> (Vec<Diagnosis>, Vec<String>) {
    let wrong = Mask::wrong(evidence);
    let known = not_finite(evidence, &wrong).or_else(|| whole(evidence, &wrong)).or_else(|| part(evidence, &wrong));
    if let Some(found) = known {
        return (vec![found], Vec::new());
    }
    let rest = |mask: &Mask| mask.says(evidence, Mistake::Unexplained, "no simple explanation");
    let split = |masks: Vec<Mask>| -> Option<Vec<Diagnosis>> {
        let found: Vec<_> = masks.iter().map(|mask| (mask, part(evidence, mask))).collect();
        let explained = found.iter().filter(|(_, found)| found.is_some()).count();
        let helps = masks.len() > 1 && explained > 0 && (explained == masks.len() || masks.len() <= MOST_SPLIT);
        helps.then(|| found.into_iter().map(|(mask, f)| f.unwrap_or_else(|| rest(mask))).collect())
    };
    let singles = if wrong.entries.len() <= MOST_SINGLE { wrong.singles() } else { Vec::new() };
    let best = [split(wrong.by(Lines::Rows)), split(wrong.by(Lines::Columns)), split(singles)]
        .into_iter()
        .flatten()
        .min_by_key(|found| badness(found));
    let found = best.unwrap_or_else(|| vec![terms::few_digits(evidence, &wrong).unwrap_or_else(|| rest(&wrong))]);
    let open = found.iter().any(|d| d.mistake == Mistake::Unexplained);
    (found, if open { arguments::where_it_vanishes(evidence) } else { Vec::new() })
}

/// Few open questions first, then few mistakes.
fn badness(found: &[Diagnosis]) -> (usize, usize) {
    (found.iter().filter(|d| d.mistake == Mistake::Unexplained).count(), found.len())
}

/// Mistakes that concern the block as a whole.
fn whole(evidence: &Evidence, wrong: &Mask) -> Option<Diagnosis> {
    let all = Mask::all(evidence);
    factor::sign(evidence, &all)
        .or_else(|| factor::zero(evidence, &all))
        .or_else(|| exchange::transposed(evidence, &all))
        .or_else(|| factor::likely(evidence, &all))
        .or_else(|| terms::named(evidence, &all))
        .or_else(|| terms::other_block(evidence, &all))
        .or_else(|| arguments::elsewhere(evidence, &all))
        .or_else(|| exchange::rows_or_columns(evidence, wrong))
        .or_else(|| factor::argument(evidence, &all))
}

/// Mistakes in some of the entries.
fn part(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    factor::not_zero(evidence, mask)
        .or_else(|| factor::sign(evidence, mask))
        .or_else(|| factor::zero(evidence, mask))
        .or_else(|| factor::likely(evidence, mask))
        .or_else(|| terms::named(evidence, mask))
        .or_else(|| exchange::transposed(evidence, mask))
        .or_else(|| exchange::entries(evidence, mask))
        .or_else(|| terms::of_arguments(evidence, mask))
        .or_else(|| arguments::confused(evidence, mask))
        .or_else(|| arguments::elsewhere(evidence, mask))
        .or_else(|| factor::constant(evidence, mask))
        .or_else(|| factor::argument(evidence, mask))
        .or_else(|| factor::varying(evidence, mask))
        .or_else(|| terms::of_other_blocks(evidence, mask))
        .or_else(|| terms::few_digits(evidence, mask))
}

fn not_finite(evidence: &Evidence, wrong: &Mask) -> Option<Diagnosis> {
    let bad = |entry: &(usize, usize)| evidence.at.iter().any(|at| !at.hand[*entry].is_finite());
    let entries: Vec<_> = wrong.entries.iter().copied().filter(bad).collect();
    let says = |mask: Mask| mask.says(evidence, Mistake::NotFinite, "infinite or not a number");
    (!entries.is_empty()).then(|| says(Mask { entries }))
}
