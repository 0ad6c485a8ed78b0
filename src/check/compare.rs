//! The comparison that all checks share: a hand-derived block against the references, at every point.

use super::agreement::{Agreement, Conflict, agreement};
use super::block::Block;
use super::diagnosis::{self, Evidence};
use super::matrix::fitting;
use super::place::{Place, set_scales};
use super::report::{BlockReport, Entry, Mistake, Verdict};
use super::search::Features;
use super::setting::Setting;
use crate::number::Random;

/// Maximum number of additional places for each point and, divided by the number of columns, for the block; and its lower bound.
const BENDS: (usize, usize, usize) = (3, 400, 6);
/// Number of the worst additional places that take part in the diagnosis.
const DIAGNOSED_BENDS: usize = 4;
/// Number of additional places that are differenced even if nothing is wrong there: derivatives are often lost in a branch.
const DIFFERENCED_BENDS: usize = 2;
/// Seed of the random changes that measure rounding.
pub(crate) const SEED: u64 = 0x5eed;
/// For functions with more arguments than this, a listed entry shows only the argument by which it is differentiated.
const NAMED: usize = 48;
/// The number of wrong entries that are listed.
const LISTED: usize = 4;

/// The points at which a block is compared, followed by additional ones for features that these do not show; and the features.
pub(crate) fn places<'a>(block: &'a Block, setting: &'a Setting, random: &mut Random) -> (Vec<Place>, Features<'a>) {
    let mut places = Place::of_points(&block.truth, setting, random);
    let most = (BENDS.0 * places.len()).min(BENDS.1 / block.columns.len().max(1)).max(BENDS.2);
    let features = Features::find(&block.truth, setting, most);
    let found = features.points[places.len()..].iter();
    let found = found.map(|known| Place::new(&block.truth, known.x.clone(), Some(known.base), random));
    places.extend(found.filter(Place::is_finite));
    (places, features)
}

/// Compares one block at all points.
pub(crate) fn check(block: &Block, setting: &Setting) -> BlockReport {
    let (rows, columns) = (block.rows.len(), block.columns.len());
    let (name, size, tolerance) = (block.name.clone(), (rows, columns), setting.tolerance);
    let mut report = BlockReport { name, size, tolerance, ..BlockReport::default() };
    if setting.drawn.points.is_empty() || rows == 0 || columns == 0 {
        report.notes.push("no points, or no rows or columns: nothing was compared".into());
        return report;
    }
    let mut random = Random::new(setting.seed ^ SEED);
    let (of, drawn, magnitudes) = (&block.truth, setting.drawn.points.len(), setting.magnitudes.as_slice());
    let (mut places, features) = places(block, setting, &mut random);
    set_scales(&mut places, &of.by, setting);
    places.iter_mut().for_each(|place| place.hand = fitting((block.hand)(&place.x), rows, columns));
    for (k, place) in places[drawn..].iter_mut().enumerate() {
        if k < DIFFERENCED_BENDS || !place.holds() {
            place.difference(of, magnitudes, &mut random);
        }
    }
    let mut agreements: Vec<Agreement> =
        places.iter().map(|place| agreement(of, place, magnitudes, [&block.rows, &block.columns])).collect();
    note_agreement(&agreements, drawn, &mut report);
    look_below(block, setting, &mut agreements, &mut report);
    let judged = places.iter().zip(&agreements).filter(|(_, agreement)| agreement.conflict.is_none());
    let judged: Vec<&Place> = judged.map(|(place, _)| place).collect();
    report.points = judged.iter().filter(|place| place.number < drawn).count();
    report.bends = judged.len() - report.points;
    report.set_aside = places.len() - judged.len();
    if places[..drawn].iter().all(|place| place.differences.iter().all(|x| !x.is_finite())) {
        report.notes.push("finite differences could not be computed near any point: two references instead of three".into());
    }
    if report.points == 0 || report.verdict == Verdict::ReferencesDisagree {
        report.verdict = Verdict::ReferencesDisagree;
    } else {
        let seen: Vec<&[f64]> = judged.iter().map(|place| place.x.as_slice()).collect();
        judge(block, setting, judged, &mut report);
        doubt((&features, &seen), &mut report);
    }
    report
}

/// Changes the verdict of a right block to undecided if the points do not show all features of its function.
fn doubt((features, points): (&Features, &[&[f64]]), report: &mut BlockReport) {
    if report.verdict != Verdict::Right {
        return;
    }
    let unseen = features.unseen(points);
    if !unseen.is_empty() {
        report.verdict = Verdict::Undecided;
        report.notes.push(format!(
            "no point was found that shows {}, so the block may be wrong there; add such a point with `.at(point)`, together with random ones by \
             `.random_points(12, 1)`, or exclude impossible points with `.admissible(…)`",
            unseen.join(", nor ")
        ));
    } else if features.is_blind() {
        let note = "the formula compares values (`re()`), but every comparison has the same outcome at all points; if another outcome is possible, add a point for it with `.at(point)`";
        report.notes.push(note.into());
    }
    if features.excludes {
        report.notes.push("branches and features that occur only at inadmissible points were not compared".into());
    }
}

/// Records disagreements of the references: points at a kink are set aside, anything else determines the verdict.
fn note_agreement(agreements: &[Agreement], chosen: usize, report: &mut BlockReport) {
    let largest = |of: fn(&Agreement) -> f64| agreements.iter().map(of).fold(0.0, f64::max);
    report.complex_step_error = largest(|a| a.complex_step);
    report.differences_error = largest(|a| a.differences);
    let conflicts: Vec<&Conflict> = agreements.iter().filter_map(|a| a.conflict.as_ref()).collect();
    let serious = conflicts.iter().find(|conflict| !conflict.is_kink);
    report.notes.extend(serious.or(conflicts.first()).map(|conflict| conflict.text.clone()));
    // If all chosen points have a conflict, additional points do not make up for them.
    if serious.is_some() || agreements[..chosen].iter().all(|agreement| agreement.conflict.is_some()) {
        report.verdict = Verdict::ReferencesDisagree;
    } else if !conflicts.is_empty() {
        report.notes.push(format!("{} of {} points were set aside because of this", conflicts.len(), agreements.len()));
    }
    if serious.is_none() {
        report.notes.extend(agreements.iter().find_map(|a| a.doubt.clone()));
    }
}

/// Compares the references for the function from which the block's function is formed: a derivative lost there is lost in all of them.
fn look_below(block: &Block, setting: &Setting, agreements: &mut [Agreement], report: &mut BlockReport) {
    let Some(of) = &block.foundation else { return };
    let mut places = Place::of_points(of, setting, &mut Random::new(setting.seed ^ 0xba5e));
    set_scales(&mut places, &of.by, setting);
    let row = |i: usize| format!("component {i} of the element's function");
    let rows: Vec<String> = (0..places[0].truth.nrows()).map(row).collect();
    let mut noted = false;
    for (place, above) in places.iter().zip(agreements) {
        let below = agreement(of, place, &setting.magnitudes, [&rows, &setting.arguments[of.by.clone()]]);
        let Some(conflict) = below.conflict.filter(|_| above.conflict.is_none()) else { continue };
        if !noted || !conflict.is_kink && report.verdict != Verdict::ReferencesDisagree {
            report.notes.push(conflict.text.clone());
            noted = true;
        }
        if !conflict.is_kink {
            report.verdict = Verdict::ReferencesDisagree;
        }
        above.conflict = Some(conflict);
    }
}

fn judge(block: &Block, setting: &Setting, judged: Vec<&Place>, report: &mut BlockReport) {
    let evidence = Evidence { block, setting, at: judged };
    if let Some(diagnosis) = diagnosis::shape(&evidence) {
        report.verdict = Verdict::Wrong;
        report.diagnoses.push(diagnosis);
        (report.absolute_error, report.relative_error) = (f64::NAN, f64::NAN);
        return;
    }
    measure(&evidence, report);
    report.verdict = if report.wrong_entries == 0 { Verdict::Right } else { Verdict::Wrong };
    if report.verdict == Verdict::Right && evidence.at.iter().all(|at| at.truth.iter().all(|x| *x == 0.0)) {
        doubt_zero(&evidence, report);
    }
    if report.verdict == Verdict::Wrong {
        let evidence = evidence.with_worst(report.points, DIAGNOSED_BENDS);
        report.diagnoses = diagnosis::diagnose(&evidence);
        // With a single point, an explanation may be a coincidence.
        if evidence.at.len() == 1 && report.diagnoses.iter().any(|found| found.mistake != Mistake::Unexplained) {
            report.notes.push("the diagnosis rests on a single point; more points make it certain".to_string());
        }
    }
}

/// Sets the verdict to undecided if a block is zero at every point but wrong with other arguments and constants.
fn doubt_zero(Evidence { block, setting, at }: &Evidence, report: &mut BlockReport) {
    let mut random = Random::new(setting.seed ^ 0x2e20);
    let groups = setting.groups.iter().flat_map(|(_, range)| range.clone());
    let all: Vec<usize> = groups.chain(setting.free.iter().copied()).collect();
    for place in at.iter().take(4) {
        let mut x = place.x.clone();
        for &k in &all {
            x[k] = (setting.magnitudes[k] * random.uniform(0.5, 1.5)).copysign(x[k]);
        }
        (setting.settle)(&mut x);
        let truth = block.truth.dual(&x);
        let largest = truth.amax();
        if largest > 0.0 && largest.is_finite() {
            let hand = fitting((block.hand)(&x), block.rows.len(), block.columns.len());
            let is_far = |error: &f64| error.is_nan() || error.abs() > 1e-6 * largest;
            if hand.shape() != truth.shape() || (hand - truth).iter().any(is_far) {
                report.verdict = Verdict::Undecided;
                let note = "the block is zero at every point with these constants but not with others: choose constants with which it is not zero \
                            (`.vary_constants(0.2)` varies those that are not 0), or add a point with `.at(point)`";
                report.notes.push(note.into());
            }
            return;
        }
    }
}

/// The arguments on which an entry depends at a place, with their names.
fn arguments(Evidence { block, setting, .. }: &Evidence, place: &Place, at: (usize, usize)) -> Vec<(String, f64)> {
    let names = &setting.arguments;
    let (own, count) = (block.truth.by.start + at.1, names.len() - 1);
    let entries = |x: &[f64]| {
        let hand = fitting((block.hand)(x), block.rows.len(), block.columns.len());
        (hand.get(at).copied(), block.truth.dual(x)[at])
    };
    let here = entries(&place.x);
    let depends = |k: usize| {
        let mut x = place.x.clone();
        x[k] += 1e-3 * x[k].abs().max(setting.magnitudes[k]);
        count <= NAMED && k != own && entries(&x) != here
    };
    (0..count).filter(|&k| k == own || depends(k)).map(|k| (names[k].clone(), place.x[k])).collect()
}

/// Computes the errors of a block and collects the worst entries.
fn measure(evidence: &Evidence, report: &mut BlockReport) {
    let (rows, columns) = (evidence.rows(), evidence.columns());
    // NaN counts as infinitely wrong.
    let at_least = |x: f64, y: f64| if y.is_nan() { f64::INFINITY } else { x.max(y) };
    let (mut wrong, mut closest) = (Vec::new(), -1.0);
    for at in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let errors = |place: &Place| {
            let error = (place.hand[at] - place.truth[at]).abs();
            [error, if error == 0.0 { 0.0 } else { error / place.scale[at] }]
        };
        for [absolute, relative] in evidence.at.iter().map(|place| errors(place)) {
            report.absolute_error = at_least(report.absolute_error, absolute);
            report.relative_error = at_least(report.relative_error, relative);
        }
        let worst = (0..evidence.at.len()).map(|p| (evidence.excess(p, at), p)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((excess, p)) = worst else { continue };
        let Place { tolerance, scale, .. } = evidence.at[p];
        if excess > closest {
            (closest, report.allowed) = (excess, if tolerance[at] == 0.0 { 0.0 } else { tolerance[at] / scale[at] });
        }
        if excess > 1.0 {
            wrong.push((at_least(0.0, errors(evidence.at[p])[1]), evidence.at[p], at));
        }
    }
    wrong.sort_by(|a, b| b.0.total_cmp(&a.0));
    report.wrong_entries = wrong.len();
    let entry = |(_, place, at): (f64, &Place, (usize, usize))| Entry {
        row: evidence.block.rows[at.0].clone(),
        column: evidence.block.columns[at.1].clone(),
        hand: place.hand[at],
        truth: place.truth[at],
        allowed: place.tolerance[at],
        point: place.number,
        at: arguments(evidence, place, at),
    };
    report.entries = wrong.into_iter().take(LISTED).map(entry).collect();
}
