//! [`Layout`]: places of the variables and outputs of multiple shooting in a problem in stages.
//!
//! ```text
//!   s = (state at the start of the segment, knots of controls shared with the segments before, duration and design variables, sums of outputs so far)
//!   w = (the other knots of controls that affect the segment; in the first segment also free initial values)
//! ```
//!
//! Knot i of a control is entry i mod m of its m entries of s, where m is the largest number of knots that a segment shares with those before it:
//! 1 if the control is free at all nodes.

use nalgebra::DVector;
use std::ops::Range;

use super::super::multiple_shooting::MultipleShooting;
use super::super::problem::Interval;
use super::problem::Shape;
use crate::Sum;

/// An output of the motion of a segment that is constrained.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub output: usize,
    /// The entry of s that sums the output over segments; `None` if only this segment contributes.
    pub sum: Option<usize>,
}

/// A knot of a control that affects a segment and the next one.
#[derive(Clone, Copy)]
pub(super) struct Shared {
    /// The knot's entry of v in the segment.
    pub from: usize,
    /// The knot's entry of s in the next segment.
    pub to: usize,
}

pub(super) struct Layout {
    pub shape: Shape,
    /// For each segment, the entry of v for each variable of its motion.
    pub places: Vec<Vec<usize>>,
    /// For each segment, the knots that it shares with the next one.
    pub shared: Vec<Vec<Shared>>,
    /// For each segment, its constrained outputs.
    pub rows: Vec<Vec<Row>>,
    /// Entries of s that sum outputs, with these outputs: they are constrained at the end.
    pub ends: Vec<(usize, usize)>,
}

impl Layout {
    pub(super) fn new(of: &MultipleShooting) -> Self {
        let (state, slots) = (of.entries.len(), slots(of));
        let others =
            of.whole.free().iter().filter(|free| free.quantity.control().is_none() && !free.quantity.is_initial()).count();
        let first_other = state + slots.iter().flatten().map(|of| of.count).sum::<usize>();
        let first_sum = first_other + others;
        let (owners, bounds_of) = (owners(of), of.whole.bounds());
        let asked: Vec<usize> = (0..owners.len()).filter(|&output| of.constraints[output] != Interval::FREE).collect();
        let sums = asked.iter().copied().filter(|&output| owners[output].is_none());
        let ends: Vec<(usize, usize)> = sums.enumerate().map(|(k, output)| (first_sum + k, output)).collect();
        let states = first_sum + ends.len();
        let mut shape = Shape {
            states,
            of_whole: (first_other..first_sum).collect(),
            bounds: Vec::new(),
            rows: Vec::new(),
            shifted: Vec::new(),
        };
        let (mut all_places, mut all_shared, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for (k, segment) in of.segments.iter().enumerate() {
            let OfSegment { places, shared, size } = OfSegment::new(of, k, &slots, (first_other, states));
            let (mut bounds, mut shifted) = (vec![Interval::FREE; size], DVector::zeros(size));
            let is_copy = |at: usize| k > 0 && (state..states).contains(&at);
            for (&at, &variable) in places.iter().zip(&segment.places).filter(|(at, _)| !is_copy(**at)) {
                shifted[at] = 1.0;
                bounds[at] = bounds_of.get(variable).copied().unwrap_or(Interval::FREE);
            }
            let summed = ends.iter().map(|&(sum, output)| Row { output, sum: Some(sum) });
            let own = asked.iter().filter(|&&output| owners[output] == Some(k)).map(|&output| Row { output, sum: None });
            let of_segment: Vec<Row> = summed.chain(own).collect();
            let intervals = of_segment.iter().filter(|row| row.sum.is_none()).map(|row| of.constraints[row.output]);
            shape.rows.push(intervals.collect());
            shape.bounds.push(bounds);
            shape.shifted.push(shifted);
            rows.push(of_segment);
            all_shared.push(shared);
            all_places.push(places);
        }
        shape.rows.push(ends.iter().map(|&(_, output)| of.constraints[output]).collect());
        shape.bounds.push(vec![Interval::FREE; states]);
        shape.shifted.push(DVector::zeros(states));
        Layout { shape, places: all_places, shared: all_shared, rows, ends }
    }
}

impl Layout {
    /// The stage and the row of a constrained output.
    pub(super) fn row(&self, output: usize) -> Option<(usize, usize)> {
        let local = |(stage, rows): (usize, &Vec<Row>)| {
            let row = rows.iter().filter(|row| row.sum.is_none()).position(|row| row.output == output)?;
            Some((stage, row))
        };
        let end = || Some((self.places.len(), self.ends.iter().position(|&(_, of)| of == output)?));
        self.rows.iter().enumerate().find_map(local).or_else(end)
    }
}

/// The entries of s for the knots of a control.
struct Slots {
    first: usize,
    count: usize,
}

impl Slots {
    fn entry(&self, knot: usize) -> usize {
        self.first + knot % self.count
    }
}

/// For each free quantity, its entries of s if it is a control.
fn slots(of: &MultipleShooting) -> Vec<Option<Slots>> {
    let mut next = of.entries.len();
    let all = of.whole.free().iter().enumerate().map(|(i, free)| {
        free.quantity.control()?;
        let count = (1..=of.segments.len()).map(|k| shared_knots(of, i, k).len()).max().unwrap_or(0);
        next += count;
        Some(Slots { first: next - count, count })
    });
    all.collect()
}

/// The knots of free quantity i that affect segment k and the segments before it. The end after the last segment has a copy of the last knot.
fn shared_knots(of: &MultipleShooting, i: usize, k: usize) -> Range<usize> {
    let Some(before) = k.checked_sub(1).map(|before| &of.segments[before].knots[i]) else { return 0..0 };
    of.segments.get(k).map_or(before.end - 1, |here| here.knots[i].start)..before.end
}

/// The places of one segment.
struct OfSegment {
    /// For each variable of the segment's motion, its entry of v.
    places: Vec<usize>,
    shared: Vec<Shared>,
    /// The number of entries of v.
    size: usize,
}

impl OfSegment {
    fn new(of: &MultipleShooting, k: usize, slots: &[Option<Slots>], (mut other, states): (usize, usize)) -> Self {
        let mut own = OfSegment { places: Vec::new(), shared: Vec::new(), size: states };
        for (i, free) in of.whole.free().iter().enumerate() {
            match &slots[i] {
                Some(slots) => {
                    let shared = [k, k + 1].map(|k| shared_knots(of, i, k));
                    own.add_knots(&of.segments[k].knots[i], slots, shared);
                }
                None if free.quantity.is_initial() && k > 0 => {}
                None if free.quantity.is_initial() => own.add(),
                None => {
                    own.places.push(other);
                    other += 1;
                }
            }
        }
        if k > 0 {
            own.places.extend(0..of.entries.len());
        }
        own
    }

    /// Adds an entry of w.
    fn add(&mut self) {
        self.places.push(self.size);
        self.size += 1;
    }

    /// Adds the knots of a control, of which some are shared with the segments before and with the next one.
    fn add_knots(&mut self, knots: &Range<usize>, slots: &Slots, [before, next]: [Range<usize>; 2]) {
        for knot in knots.clone() {
            if before.contains(&knot) {
                self.places.push(slots.entry(knot));
            } else {
                self.add();
            }
            if next.contains(&knot) {
                self.shared.push(Shared { from: self.places[self.places.len() - 1], to: slots.entry(knot) });
            }
        }
    }
}

/// For each output, the only segment that contributes to it; `None` if several ones do.
pub(in super::super) fn owners(of: &MultipleShooting) -> Vec<Option<usize>> {
    let last = of.segments.len() - 1;
    let system = of.segments[0].motion.solver.system();
    let segment_of = |node: usize| of.segments.iter().position(|segment| node <= segment.last).unwrap_or(last);
    let owner = |output: usize| {
        let mut segments = system.sums(1 + output).map(|(sum, _)| match sum {
            Sum::Terminal => Some(last),
            Sum::Node(node) => Some(segment_of(node)),
            _ => None,
        });
        let first = segments.next().unwrap_or(Some(last));
        first.filter(|_| segments.all(|other| other == first))
    };
    (0..of.running.len()).map(owner).collect()
}
