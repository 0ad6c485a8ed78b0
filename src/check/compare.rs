//! The one comparison that all checks share: a hand-derived block against the oracles, at every point.

use nalgebra::DMatrix;
use std::ops::Range;

use super::agreement::{Agreement, Conflict, agreement};
use super::diagnosis::{self, Evidence};
use super::formula::Differentiable;
use super::matrix::fitting;
use super::oracle::{Truth, truth};
use super::random::Random;
use super::report::{BlockReport, Diagnosis, Entry, Mistake, Verdict};
use super::scale::sizes;

/// An entry may be off by this many times the noise of the true value.
const NOISE: f64 = 64.0;
/// The number of wrong entries that are listed.
const LISTED: usize = 4;

/// A matrix that depends on the point.
pub(crate) type MatrixAt<'a> = Box<dyn Fn(&[f64]) -> DMatrix<f64> + 'a>;

/// A block of derivatives: what is differentiated by what, and the user's version of it.
pub(crate) struct Block<'a> {
    pub name: String,
    pub function: Box<dyn Differentiable + 'a>,
    /// The arguments it is differentiated by.
    pub by: Range<usize>,
    /// What the function is itself made of by differentiation: there, too, the oracles must agree.
    pub foundation: Option<(Box<dyn Differentiable + 'a>, Range<usize>)>,
    pub rows: Vec<String>,
    pub columns: Vec<String>,
    pub hand: MatrixAt<'a>,
    /// Named terms that may have been left out of it.
    pub terms: Vec<(String, MatrixAt<'a>)>,
    /// Named matrices that it may have been mistaken for.
    pub others: Vec<(String, MatrixAt<'a>)>,
    /// Points whose true value may have been taken instead ("node i − 1").
    pub elsewhere: Vec<(String, Elsewhere<'a>)>,
}

/// Another point made of a point.
pub(crate) type Elsewhere<'a> = Box<dyn Fn(&[f64]) -> Vec<f64> + 'a>;

/// Where blocks are compared, and how strictly.
#[derive(Clone)]
pub(crate) struct Setting {
    pub points: Vec<Vec<f64>>,
    pub seed: u64,
    /// The size that each argument has.
    pub magnitudes: Vec<f64>,
    /// The name of each argument.
    pub arguments: Vec<String>,
    /// Arguments that belong together (q, v, σ, …) and may be mistaken for one another; none if they cannot be changed freely.
    pub groups: Vec<(String, Range<usize>)>,
    /// Numbers by which one may multiply in error.
    pub factors: Vec<(String, f64)>,
    /// Relative to the size of an entry's row and column.
    pub tolerance: f64,
}

/// Compares one block at all points.
pub(crate) fn check(block: &Block, setting: &Setting) -> BlockReport {
    let mut report = BlockReport::empty(block.name.clone(), (block.rows.len(), block.columns.len()), setting.tolerance);
    if setting.points.is_empty() || block.rows.is_empty() || block.columns.is_empty() {
        report.notes.push("no points, or no rows or columns: nothing was compared".into());
        return report;
    }
    let mut random = Random::new(setting.seed ^ 0x5eed);
    let f = block.function.as_ref();
    let mut look = |x: &Vec<f64>| truth(f, x, &block.by, &setting.magnitudes, &mut random);
    let truths: Vec<Truth> = setting.points.iter().map(&mut look).collect();
    let sizes = common_sizes(&truths, setting, &block.by);
    let look = |(x, truth): (&Vec<f64>, &Truth)| agreement(f, x, &block.by, truth, &sizes);
    let mut agreements: Vec<Agreement> = setting.points.iter().zip(&truths).map(look).collect();
    note_agreement(&agreements, block, &mut report);
    look_below(block, setting, &mut agreements, &mut report);
    let judged: Vec<usize> = (0..truths.len()).filter(|&p| agreements[p].conflict.is_none()).collect();
    report.points = judged.len();
    report.set_aside = truths.len() - judged.len();
    if truths.iter().all(|truth| truth.differences.iter().all(|x| !x.is_finite())) {
        report.notes.push("no differences could be formed near any point: two oracles instead of three".into());
    }
    if judged.is_empty() {
        report.verdict = Verdict::OraclesDisagree;
    }
    if report.verdict == Verdict::OraclesDisagree {
        return report;
    }
    let hand = |&p: &usize| fitting((block.hand)(&setting.points[p]), block.rows.len(), block.columns.len());
    let hands: Vec<DMatrix<f64>> = judged.iter().map(hand).collect();
    judge(block, setting, &judged, &truths, hands, sizes, &mut report);
    report
}

/// The sizes of the entries over all points.
fn common_sizes(truths: &[Truth], setting: &Setting, by: &Range<usize>) -> DMatrix<f64> {
    let finite = |x: f64| if x.is_finite() { x.abs() } else { 0.0 };
    let mut largest = truths[0].value.map(finite);
    let mut function = vec![0.0f64; largest.nrows()];
    for truth in truths {
        largest.zip_apply(&truth.value, |a, b| *a = a.max(finite(b)));
        function.iter_mut().zip(&truth.function).for_each(|(a, &b)| *a = a.max(finite(b)));
    }
    let magnitude = |j: usize| setting.magnitudes[by.start + j];
    // An empty column has the size that would change the row's function by as much as the others do.
    let row = |i: usize| (0..largest.ncols()).fold(function[i], |m, j| m.max(largest[(i, j)] * magnitude(j)));
    sizes(&largest, |i, j| row(i) / magnitude(j))
}

/// Where the oracles disagree: a kink is set aside, anything else is a verdict.
fn note_agreement(agreements: &[Agreement], block: &Block, report: &mut BlockReport) {
    let largest = |of: fn(&Agreement) -> f64| agreements.iter().map(of).fold(0.0, f64::max);
    report.complex_step_error = largest(|a| a.complex_step);
    report.differences_error = largest(|a| a.differences);
    let conflicts: Vec<&Conflict> = agreements.iter().filter_map(|a| a.conflict.as_ref()).collect();
    let serious = conflicts.iter().find(|conflict| !matches!(conflict, Conflict::Kink { .. }));
    if let Some(conflict) = serious.or(conflicts.first()) {
        report.notes.push(conflict.describe(&block.rows, &block.columns));
    }
    if serious.is_some() || conflicts.len() == agreements.len() {
        report.verdict = Verdict::OraclesDisagree;
    } else if !conflicts.is_empty() {
        report.notes.push(format!("{} of {} points were set aside for it", conflicts.len(), agreements.len()));
    }
}

/// The same for the function that the block's function is made of, whose lost derivatives all oracles would lose together.
fn look_below(block: &Block, setting: &Setting, agreements: &mut [Agreement], report: &mut BlockReport) {
    let Some((f, by)) = &block.foundation else { return };
    let mut random = Random::new(setting.seed ^ 0xba5e);
    let mut look = |x: &Vec<f64>| truth(f.as_ref(), x, by, &setting.magnitudes, &mut random);
    let truths: Vec<Truth> = setting.points.iter().map(&mut look).collect();
    let sizes = common_sizes(&truths, setting, by);
    let mut noted = false;
    for ((x, truth), above) in setting.points.iter().zip(&truths).zip(agreements) {
        let below = agreement(f.as_ref(), x, by, truth, &sizes);
        let Some(conflict) = below.conflict.filter(|_| above.conflict.is_none()) else { continue };
        let row = |i: usize| format!("component {i} of the element's function");
        let rows: Vec<String> = (0..sizes.nrows()).map(row).collect();
        let serious = !matches!(conflict, Conflict::Kink { .. });
        if !noted || serious && report.verdict != Verdict::OraclesDisagree {
            report.notes.push(conflict.describe(&rows, &setting.arguments[by.clone()]));
            noted = true;
        }
        if serious {
            report.verdict = Verdict::OraclesDisagree;
        }
        above.conflict = Some(conflict);
    }
}

fn judge(
    block: &Block,
    setting: &Setting,
    judged: &[usize],
    truths: &[Truth],
    hands: Vec<DMatrix<f64>>,
    sizes: DMatrix<f64>,
    report: &mut BlockReport,
) {
    let points: Vec<&[f64]> = judged.iter().map(|&p| setting.points[p].as_slice()).collect();
    let values: Vec<DMatrix<f64>> = judged.iter().map(|&p| truths[p].value.clone()).collect();
    let tolerance = |p: usize| sizes.zip_map(&truths[p].noise, |size, noise| setting.tolerance * size + NOISE * noise);
    let tolerances: Vec<DMatrix<f64>> = judged.iter().map(|&p| tolerance(p)).collect();
    if let Some(diagnosis) = diagnosis::shape(&hands, &values) {
        report.verdict = Verdict::Wrong;
        report.diagnoses.push(diagnosis);
        (report.absolute_error, report.relative_error) = (f64::NAN, f64::NAN);
        return;
    }
    let evidence = Evidence { block, setting, points, hand: hands, truth: values, tolerance: tolerances, sizes };
    measure(&evidence, judged, report);
    report.verdict = if report.wrong_entries == 0 { Verdict::Right } else { Verdict::Wrong };
    if report.verdict == Verdict::Right && evidence.truth.iter().all(|truth| truth.iter().all(|x| *x == 0.0)) {
        report.notes.push("zero at every point: if it is not zero by nature, choose points where it is not".into());
    }
    if report.verdict == Verdict::Wrong {
        (report.diagnoses, report.notes) = {
            let (diagnoses, mut notes) = diagnosis::diagnose(&evidence);
            notes.splice(0..0, std::mem::take(&mut report.notes));
            (diagnoses, notes)
        };
        report.notes.extend(without_first(&evidence, &report.diagnoses));
    }
}

/// A warning where only one point was compared: a coincidence is possible.
fn without_first(evidence: &Evidence, diagnoses: &[Diagnosis]) -> Option<String> {
    let sure = evidence.points.len() > 1 || diagnoses.iter().all(|d| d.mistake == Mistake::Unexplained);
    (!sure).then(|| "the diagnosis rests on a single point; more points make it certain".to_string())
}

/// Errors and the worst entries.
fn measure(evidence: &Evidence, judged: &[usize], report: &mut BlockReport) {
    let (rows, columns) = evidence.sizes.shape();
    let mut wrong: Vec<(f64, Entry)> = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let worst = (0..evidence.points.len()).map(|p| (evidence.excess(p, i, j), p)).max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((excess, p)) = worst else { continue };
            let (hand, truth) = (evidence.hand[p][(i, j)], evidence.truth[p][(i, j)]);
            let error = (hand - truth).abs();
            let relative = if error == 0.0 { 0.0 } else { error / evidence.sizes[(i, j)] };
            // NaN counts as infinitely wrong.
            let at_least = |x: f64, y: f64| if y.is_nan() { f64::INFINITY } else { x.max(y) };
            report.absolute_error = at_least(report.absolute_error, error);
            report.relative_error = at_least(report.relative_error, relative);
            if excess > 1.0 {
                let (row, column) = (evidence.block.rows[i].clone(), evidence.block.columns[j].clone());
                wrong.push((at_least(0.0, relative), Entry { row, column, hand, truth, point: judged[p] }));
            }
        }
    }
    wrong.sort_by(|a, b| b.0.total_cmp(&a.0));
    report.wrong_entries = wrong.len();
    report.entries = wrong.into_iter().take(LISTED).map(|(_, entry)| entry).collect();
}
