//! The one comparison that all checks share: a hand-derived block against the oracles, at every point.

use nalgebra::DMatrix;
use std::ops::Range;

use super::agreement::{Agreement, Conflict, agreement};
use super::diagnosis::{self, Evidence};
use super::formula::Differentiable;
use super::matrix::fitting;
use super::place::{Place, set_scales};
use super::random::Random;
use super::report::{BlockReport, Diagnosis, Entry, Mistake, Verdict};
use super::scan::bends;

/// Places found by searching: the most for each point, and for all columns together; but not fewer than the last.
const BENDS: (usize, usize, usize) = (3, 400, 6);
/// So many of the worst of them take part in the diagnosis.
const DIAGNOSED_BENDS: usize = 4;
/// So many of them are differenced even if nothing is wrong there: where derivatives get lost, it is often in a branch.
const DIFFERENCED_BENDS: usize = 2;
/// What noise is drawn with.
pub(crate) const SEED: u64 = 0x5eed;
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

/// A change of a point, and a question about one.
type Settle<'a> = Box<dyn Fn(&mut [f64]) + 'a>;
type Admissible<'a> = Box<dyn Fn(&[f64]) -> bool + 'a>;

/// Where blocks are compared, and how strictly.
pub(crate) struct Setting<'a> {
    pub points: Vec<Vec<f64>>,
    /// Of each point: the one that it is with some arguments made small.
    pub parents: Vec<Option<usize>>,
    /// Whether the user has given the points.
    pub given: bool,
    /// Arguments along which one may search for places where the formula bends, and those that may become small together.
    pub free: Vec<usize>,
    pub kinds: Vec<Vec<usize>>,
    /// Makes a point's other arguments fit those that were moved.
    pub settle: Settle<'a>,
    pub admissible: Admissible<'a>,
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

/// The points at which a block is compared, and behind them the places where the formula bends near them.
pub(crate) fn places(block: &Block, setting: &Setting, random: &mut Random) -> Vec<Place> {
    let f = block.function.as_ref();
    let mut places = Place::of_points(f, &block.by, setting, random);
    let most = (BENDS.0 * places.len()).min(BENDS.1 / block.columns.len().max(1)).max(BENDS.2);
    let found = bends(f, &block.by, setting, most);
    let found = found.into_iter().map(|bend| Place::new(f, bend.x, &block.by, Some(bend.base), random));
    places.extend(found.filter(Place::is_finite));
    places
}

/// Compares one block at all points, and where the formula bends near them.
pub(crate) fn check(block: &Block, setting: &Setting) -> BlockReport {
    let (rows, columns) = (block.rows.len(), block.columns.len());
    let mut report = BlockReport::empty(block.name.clone(), (rows, columns), setting.tolerance);
    if setting.points.is_empty() || rows == 0 || columns == 0 {
        report.notes.push("no points, or no rows or columns: nothing was compared".into());
        return report;
    }
    let mut random = Random::new(setting.seed ^ SEED);
    let (f, drawn) = (block.function.as_ref(), setting.points.len());
    let mut places = places(block, setting, &mut random);
    set_scales(&mut places, drawn, &block.by, &setting.magnitudes);
    let hand = |place: &Place| fitting((block.hand)(&place.x), rows, columns);
    let hands: Vec<DMatrix<f64>> = places.iter().map(hand).collect();
    for (k, (place, hand)) in places.iter_mut().zip(&hands).enumerate().skip(drawn) {
        if k < drawn + DIFFERENCED_BENDS || !place.holds(hand, setting.tolerance) {
            place.truth.difference(f, &place.x, &block.by, &setting.magnitudes, &mut random);
        }
    }
    let of = (&block.by, setting.magnitudes.as_slice());
    let look = |place: &Place| agreement(f, &place.x, of, &place.truth, &place.scale);
    let mut agreements: Vec<Agreement> = places.iter().map(look).collect();
    note_agreement(&agreements, block, &mut report);
    look_below(block, setting, &mut agreements, &mut report);
    let judged: Vec<usize> = (0..places.len()).filter(|&p| agreements[p].conflict.is_none()).collect();
    report.points = judged.iter().filter(|&&p| p < drawn).count();
    report.bends = judged.len() - report.points;
    report.set_aside = places.len() - judged.len();
    if places[..drawn].iter().all(|place| place.truth.differences.iter().all(|x| !x.is_finite())) {
        report.notes.push("no differences could be formed near any point: two oracles instead of three".into());
    }
    if judged.is_empty() {
        report.verdict = Verdict::OraclesDisagree;
    }
    if report.verdict != Verdict::OraclesDisagree {
        judge(block, setting, &judged, &places, &hands, &mut report);
    }
    report
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
    let mut places = Place::of_points(f.as_ref(), by, setting, &mut Random::new(setting.seed ^ 0xba5e));
    set_scales(&mut places, setting.points.len(), by, &setting.magnitudes);
    let mut noted = false;
    for (place, above) in places.iter().zip(agreements) {
        let below = agreement(f.as_ref(), &place.x, (by, &setting.magnitudes), &place.truth, &place.scale);
        let Some(conflict) = below.conflict.filter(|_| above.conflict.is_none()) else { continue };
        let row = |i: usize| format!("component {i} of the element's function");
        let rows: Vec<String> = (0..place.size.nrows()).map(row).collect();
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
    places: &[Place],
    hands: &[DMatrix<f64>],
    report: &mut BlockReport,
) {
    let of = |value: fn(&Place) -> &DMatrix<f64>| judged.iter().map(|&p| value(&places[p]).clone()).collect::<Vec<_>>();
    let (truth, sizes) = (of(|place| &place.truth.value), of(|place| &place.scale));
    let hand: Vec<DMatrix<f64>> = judged.iter().map(|&p| hands[p].clone()).collect();
    if let Some(diagnosis) = diagnosis::shape(&hand, &truth) {
        report.verdict = Verdict::Wrong;
        report.diagnoses.push(diagnosis);
        (report.absolute_error, report.relative_error) = (f64::NAN, f64::NAN);
        return;
    }
    let points = judged.iter().map(|&p| places[p].x.as_slice()).collect();
    let tolerance = judged.iter().map(|&p| places[p].tolerance(setting.tolerance)).collect();
    let evidence = Evidence { block, setting, points, hand, truth, tolerance, sizes };
    measure(&evidence, judged, report);
    report.verdict = if report.wrong_entries == 0 { Verdict::Right } else { Verdict::Wrong };
    if report.verdict == Verdict::Right && evidence.truth.iter().all(|truth| truth.iter().all(|x| *x == 0.0)) {
        report.notes.push("zero at every point: if it is not zero by nature, choose points where it is not".into());
    }
    if report.verdict == Verdict::Wrong {
        let evidence = evidence.with_worst(report.points, DIAGNOSED_BENDS);
        let (diagnoses, notes) = diagnosis::diagnose(&evidence);
        report.diagnoses = diagnoses;
        report.notes.extend(notes);
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
    let (rows, columns) = (evidence.rows(), evidence.columns());
    let mut wrong: Vec<(f64, Entry)> = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let worst = (0..evidence.points.len()).map(|p| (evidence.excess(p, i, j), p)).max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((excess, p)) = worst else { continue };
            let (hand, truth) = (evidence.hand[p][(i, j)], evidence.truth[p][(i, j)]);
            let error = (hand - truth).abs();
            let relative = if error == 0.0 { 0.0 } else { error / evidence.sizes[p][(i, j)] };
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
