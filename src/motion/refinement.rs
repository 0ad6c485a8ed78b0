//! The computed grid: the given grid, with steps halved where Newton's method found no solution.
//!
//! Between given nodes A and B the controls are linear, u = (1 − θ) u_A + θ u_B, and every part is a fixed fraction of the given step, Δt_k = s_k Δt.
//! A motion on the computed grid is therefore a function of the given inputs, with the derivatives
//!
//! ```text
//!   dJ/du_A = Σ (1 − θ_k) dJ/du_k,     dJ/du_B = Σ θ_k dJ/du_k,     dJ/dΔt = Σ s_k dJ/dΔt_k
//! ```
//!
//! Costs are summed over the given nodes only, with the weights of the given steps.

use nalgebra::DMatrix;

use super::trajectory::column_of;
use super::{Occurrence, column_mut};
use crate::number::Real;
use crate::system::{Beside, GivenWeights, Occurring, Weights};
use crate::{Error, Grid, Inputs, Scheme, Trajectory};

/// One step of the computed grid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    /// The given step that contains it, counted from 0.
    step: usize,
    /// Its length s as a fraction of the given step.
    share: f64,
    /// The position θ of its end in the given step, from 0 to 1.
    end: f64,
}

impl Part {
    #[inline]
    fn whole(step: usize) -> Self {
        Part { step, share: 1.0, end: 1.0 }
    }
}

/// A given step that was halved.
#[derive(Clone, Copy, Debug)]
struct Halved {
    /// The node of the computed grid at which it begins.
    node: usize,
    /// Its number in the given grid, counted from 0.
    step: usize,
}

/// The relation between the computed grid and the given grid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refinement {
    /// Halved steps, in ascending order; all other steps are unchanged.
    halved: Vec<Halved>,
    /// (s, θ) of all parts of halved steps.
    parts: Vec<(f64, f64)>,
    /// The number of the first given node in the longer motion of which this one is a part, and whether this part is its end.
    first: usize,
    is_end: bool,
    events: Vec<Occurrence>,
    /// The given nodes behind the steps of length zero that follow the events.
    after_events: Vec<usize>,
}

impl Refinement {
    /// From the computed steps, the numbers of nodes of a longer motion before and after them, and the inserted nodes in ascending order.
    pub(crate) fn new((steps, events): (&[f64], &[Occurrence]), around: [usize; 2], inserted: &[usize]) -> Self {
        let most = inserted.len().min(steps.len());
        let (halved, parts) = (Vec::with_capacity(most), Vec::with_capacity(most + inserted.len()));
        let after_events = events.iter().map(|event| after(event.node, steps, inserted)).collect();
        let [first, behind] = around;
        let mut refinement = Refinement { halved, parts, first, is_end: behind == 0, events: events.to_vec(), after_events };
        let mut before = 0;
        while let Some(&cut) = inserted.get(before) {
            // Consecutive inserted nodes lie within one given step, which ends after the last of them.
            let run = inserted[before..].iter().zip(cut..).take_while(|&(&node, next)| node == next).count();
            let parts = &steps[cut - 1..(cut + run).min(steps.len())];
            let length: f64 = parts.iter().sum();
            let mut done = 0.0;
            refinement.halved.push(Halved { node: cut - 1, step: cut - 1 - before });
            refinement.parts.extend(parts.iter().map(|part| {
                done += part;
                (part / length, done / length)
            }));
            before += run;
        }
        refinement
    }

    /// Upper bound of the memory, in bytes, for given numbers of given steps and inserted nodes.
    pub(crate) fn bytes(steps: usize, inserted: usize) -> usize {
        let most = inserted.min(steps);
        most * size_of::<Halved>() + (most + inserted) * size_of::<(f64, f64)>()
    }

    /// The parts of halved step `k`.
    fn parts_of(&self, k: usize) -> &[(f64, f64)] {
        // Each halved step has one part more than it has inserted nodes.
        let first = |k: usize| self.halved.get(k).map_or(self.parts.len(), |halved| halved.node - halved.step + k);
        &self.parts[first(k)..first(k + 1)]
    }

    /// The computed step that ends at node ≥ 1.
    #[inline]
    fn part(&self, node: usize) -> Part {
        if self.halved.is_empty() { Part::whole(node - 1) } else { self.part_of_refined(node) }
    }

    #[cold]
    fn part_of_refined(&self, node: usize) -> Part {
        let before = self.halved.partition_point(|halved| halved.node < node);
        let Some(k) = before.checked_sub(1) else { return Part::whole(node - 1) };
        let (Halved { node: begin, step }, parts) = (self.halved[k], self.parts_of(k));
        let behind = node - begin - 1;
        match parts.get(behind) {
            Some(&(share, end)) => Part { step, share, end },
            None => Part::whole(step + 1 + behind - parts.len()),
        }
    }

    /// The number of the given step that ends at a node of the computed grid or contains it, counted from 1; 0 for node 0.
    pub(crate) fn given_step(&self, node: usize) -> usize {
        if node == 0 { 0 } else { self.part(node).step + 1 }
    }

    /// The number of the given step that ends at a node or contains it, in the longer motion of which this one is a part; 0 for node 0.
    pub(crate) fn step_of_whole(&self, node: usize) -> usize {
        if node == 0 { 0 } else { self.node_of_whole(node) }
    }

    /// The number of the given node at or after a node of the computed grid, in the longer motion of which this one is a part.
    pub(crate) fn node_of_whole(&self, node: usize) -> usize {
        self.first + self.given_step(node)
    }

    /// The number of the given node at a node of the computed grid; `None` if the node was inserted.
    pub(crate) fn given_node(&self, node: usize) -> Option<usize> {
        (node == 0 || self.part(node).end == 1.0).then(|| self.given_step(node))
    }

    /// The weights for each way to sum a cost at a node of the computed grid, from the adjacent steps that are counted.
    pub(crate) fn weights<R: Real>(&self, scheme: &Scheme, taken: &[R], node: usize, side: Beside) -> Weights<R> {
        let before = node.checked_sub(1).map(|before| taken[before]);
        let after = taken.get(node).copied();
        let part = |step: Option<R>, weight: f64| step.map_or(R::zero(), |dt| dt * weight);
        let [counted_before, counted_after] = [before.filter(|_| side.has_before()), after.filter(|_| side.has_after())];
        let integral = part(counted_before, scheme.weight(scheme.stages())) + part(counted_after, scheme.weight(0));
        let given = self.given_node(node).map(|given| {
            let ends = if self.parts.is_empty() { (before, after) } else { self.given_lengths(taken, node, given) };
            // The first node of a part is the last node of the previous part, which counts it, unless the part has no other node.
            let number = (given > 0 || self.first == 0 || taken.is_empty()).then_some(self.first + given);
            let after_event = self.after_events.binary_search(&given).ok();
            let weights = GivenWeights::new(number, ends.0, ends.1, side);
            let terminal = if self.is_end { weights.terminal } else { R::zero() };
            GivenWeights { event: self.event_at(given), after_event, terminal, ..weights }
        });
        Weights { given, integral, side }
    }

    /// The event at a given node.
    #[inline]
    fn event_at(&self, given: usize) -> Option<Occurring> {
        if self.events.is_empty() {
            return None;
        }
        let number = self.events.binary_search_by_key(&given, |event| event.node).ok()?;
        Some(Occurring { number, function: self.events[number].event.index() })
    }

    /// The lengths of the given steps before and after a given node.
    fn given_lengths<R: Real>(&self, taken: &[R], node: usize, given: usize) -> (Option<R>, Option<R>) {
        let length = |step: usize| {
            let next = self.halved.partition_point(|halved| halved.step <= step);
            let Some(k) = next.checked_sub(1) else { return taken[step] };
            let (halved, parts) = (self.halved[k], self.parts_of(k).len());
            match step - halved.step {
                0 => taken[halved.node..halved.node + parts].iter().fold(R::zero(), |sum, &dt| sum + dt),
                behind => taken[halved.node + parts + behind - 1],
            }
        };
        (given.checked_sub(1).map(length), (node < taken.len()).then(|| length(given)))
    }

    /// Inputs on the computed grid from those on the given grid.
    pub(crate) fn refine<R: Real>(&self, given: &Inputs<R>) -> Inputs<R> {
        if self.parts.is_empty() {
            return given.clone();
        }
        let count = given.grid.steps.len() + self.parts.len() - self.halved.len();
        let steps = (1..=count).map(|node| self.part(node)).map(|part| given.grid.steps[part.step] * part.share).collect();
        let controls = DMatrix::from_fn(given.controls.nrows(), count + 1, |channel, node| {
            if node == 0 {
                return given.controls[(channel, 0)];
            }
            let part = self.part(node);
            let (before, after) = (given.controls[(channel, part.step)], given.controls[(channel, part.step + 1)]);
            before * (1.0 - part.end) + after * part.end
        });
        let grid = Grid { steps, ..given.grid };
        Inputs { grid, controls, ..given.clone() }
    }

    /// Adds dJ/du at a computed node, times a factor, to dJ/du at the given nodes.
    pub(crate) fn add_controls(&self, node: usize, factor: f64, taken: &[f64], given: &mut DMatrix<f64>) {
        let (step, end) = if node == 0 { (0, 0.0) } else { (self.part(node).step, self.part(node).end) };
        let mut add = |step: usize, factor: f64| {
            column_mut(given, step).iter_mut().zip(taken).for_each(|(sum, derivative)| *sum += factor * derivative);
        };
        if end < 1.0 {
            add(step, factor * (1.0 - end));
        }
        if end > 0.0 {
            add(step + 1, factor * end);
        }
    }

    /// Adds dJ/dΔt of the computed step that ends at a node to dJ/dΔt of the given step.
    pub(crate) fn add_step(&self, node: usize, taken: f64, given: &mut [f64]) {
        let part = self.part(node);
        given[part.step] += part.share * taken;
    }
}

impl<R: Real> Trajectory<R> {
    /// The relation between the grid of this motion, which may have been computed elsewhere, and the given grid.
    pub(crate) fn refinement(&self, inputs: &Inputs<R>) -> Result<Refinement, Error> {
        let Inputs { grid, events, .. } = inputs;
        let mut before = 0;
        for &node in &self.inserted {
            // If a motion stopped within a given step, the end of that step is missing after its last node.
            if node <= before || node >= grid.steps.len() {
                let what = "a node of the trajectory's `inserted`".into();
                let must_be = "larger than the one before it, and between the first and the last node of the motion";
                return Err(Error::Parameter { what, value: node as f64, must_be });
            }
            before = node;
        }
        let lengths: Vec<f64> = grid.steps.iter().map(|dt| dt.part(0)).collect();
        Ok(Refinement::new((&lengths, events), grid.around, &self.inserted))
    }
}

/// The given node behind the steps of length zero that follow a given node.
fn after(node: usize, steps: &[f64], inserted: &[usize]) -> usize {
    node + steps.iter().skip(column_of(node, inserted)).take_while(|length| **length == 0.0).count()
}

#[cfg(test)]
mod tests {
    use super::Refinement;
    use crate::system::Beside;
    use crate::{Grid, Inputs, Scheme, Start};
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn controls_are_linear_between_given_nodes_and_shares_add_up() {
        // Given steps 1, 2, 1; the second was halved, and then its first half.
        let refinement = Refinement::new((&[1.0, 0.5, 0.5, 1.0, 1.0], &[]), [0, 0], &[2, 3]);
        let start = Start::Velocity { q: DVector::zeros(0), v: DVector::zeros(0) };
        let grid = Grid::new(0.0, vec![1.0, 2.0, 1.0]);
        let controls = DMatrix::from_row_slice(1, 4, &[1.0, 3.0, 7.0, 8.0]);
        let given = Inputs {
            grid,
            start,
            controls,
            design: DVector::zeros(0),
            events: Vec::new(),
            controls_in_time: Vec::new(),
            open: Vec::new(),
        };
        let taken = refinement.refine(&given);
        assert_eq!(taken.grid.steps, [1.0, 0.5, 0.5, 1.0, 1.0]);
        assert_eq!(taken.controls.as_slice(), [1.0, 3.0, 4.0, 5.0, 7.0, 8.0]);
        assert_eq!(
            (0..6).map(|i| refinement.given_node(i)).collect::<Vec<_>>(),
            [Some(0), Some(1), None, None, Some(2), Some(3)]
        );
        let weights = refinement.weights(&Scheme::TRAPEZOIDAL, &taken.grid.steps, 4, Beside::Both);
        let given = weights.given.expect("a given node");
        assert_eq!((given.rectangle, given.trapezoidal, weights.integral), (1.0, 1.5, 1.0));
        assert!(refinement.weights(&Scheme::TRAPEZOIDAL, &taken.grid.steps, 3, Beside::Both).given.is_none());
        let (mut controls, mut steps) = (DMatrix::zeros(1, 4), vec![0.0; 3]);
        (0..6).for_each(|node| refinement.add_controls(node, 1.0, &[1.0], &mut controls));
        (1..6).for_each(|node| refinement.add_step(node, 1.0, &mut steps));
        assert_eq!(controls.as_slice(), [1.0, 2.25, 1.75, 1.0]);
        assert_eq!(steps, [1.0, 1.0, 1.0]);
    }
}
