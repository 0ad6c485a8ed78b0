//! Numbers of segments into which a motion is divided.

use super::super::MotionProblem;

/// Numbers of steps of a segment, in the order in which they are tried from the first start, and from the others.
const STEPS: [usize; 4] = [5, 3, 10, 1];
const LATER: [usize; 4] = [3, 10, 1, 5];

/// The number of segments that is tried first.
pub(super) fn most_segments(problem: &MotionProblem) -> usize {
    counts(problem, 0).first().copied().unwrap_or(1)
}

/// The numbers of segments that are tried; from later starts, the first two take turns, near the best outcome and elsewhere.
pub(super) fn counts(problem: &MotionProblem, start: usize) -> Vec<usize> {
    let steps = problem.inputs_at(&problem.start()).grid.macro_ends().count();
    let order = if start == 0 { STEPS } else { LATER };
    let mut counts: Vec<usize> = Vec::new();
    for count in order.into_iter().map(|of| steps / of).filter(|count| *count > 1) {
        if !counts.contains(&count) {
            counts.push(count);
        }
    }
    if counts.len() > 1 && !(start / 2).is_multiple_of(2) {
        counts.swap(0, 1);
    }
    counts
}
