//! [`Layout`]: places of the variables and outputs of multiple shooting in a problem in stages.
//!
//! ```text
//!   s = (state at the start of the segment, controls there, duration and design variables, sums of outputs so far)
//!   w = (controls at the other nodes; in the first segment also free initial values)
//! ```

use nalgebra::DVector;

use super::super::free::Quantity;
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

pub(super) struct Layout {
    pub shape: Shape,
    /// Numbers of entries of the state, of controls, and of other quantities in s.
    pub counts: [usize; 3],
    /// For each segment, the entry of v for each variable of its motion.
    pub places: Vec<Vec<usize>>,
    /// For each segment, the first entry of v of the controls at its end.
    pub last_controls: Vec<usize>,
    /// For each segment, its constrained outputs.
    pub rows: Vec<Vec<Row>>,
    /// Entries of s that sum outputs, with these outputs: they are constrained at the end.
    pub ends: Vec<(usize, usize)>,
}

impl Layout {
    pub(super) fn new(of: &MultipleShooting) -> Self {
        let count = |kind: Kind| of.whole.free().iter().filter(|of| Kind::of(&of.quantity) == kind).count();
        let counts = [of.entries.len(), count(Kind::Control), count(Kind::Other)];
        let first_sum = counts.iter().sum::<usize>();
        let (owners, bounds_of) = (owners(of), of.whole.bounds());
        let asked: Vec<usize> = (0..owners.len()).filter(|&output| of.constraints[output] != Interval::FREE).collect();
        let sums = asked.iter().copied().filter(|&output| owners[output].is_none());
        let ends: Vec<(usize, usize)> = sums.enumerate().map(|(k, output)| (first_sum + k, output)).collect();
        let states = first_sum + ends.len();
        let mut shape = Shape {
            states,
            free: (counts[0]..first_sum).collect(),
            of_whole: (counts[0] + counts[1]..first_sum).collect(),
            bounds: Vec::new(),
            rows: Vec::new(),
            shifted: Vec::new(),
        };
        let (mut all_places, mut last_controls, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for (k, segment) in of.segments.iter().enumerate() {
            let steps = segment.last - segment.first;
            let size = states + steps * counts[1] + if k == 0 { count(Kind::Start) } else { 0 };
            let places = places(of, k, steps, (counts, states));
            let (mut bounds, mut shifted) = (vec![Interval::FREE; size], DVector::zeros(size));
            let is_copy = |at: usize| k > 0 && (counts[0]..states).contains(&at);
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
            last_controls.push(states + (steps - 1) * counts[1]);
            all_places.push(places);
        }
        shape.rows.push(ends.iter().map(|&(_, output)| of.constraints[output]).collect());
        shape.bounds.push(vec![Interval::FREE; states]);
        shape.shifted.push(DVector::zeros(states));
        Layout { shape, counts, places: all_places, last_controls, rows, ends }
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

/// Kind of a free quantity.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Control,
    Start,
    Other,
}

impl Kind {
    fn of(quantity: &Quantity) -> Self {
        match quantity {
            Quantity::Control(_) => Kind::Control,
            Quantity::Coordinate(_) | Quantity::Rate(_) => Kind::Start,
            _ => Kind::Other,
        }
    }
}

/// For each variable of a segment's motion, its entry of v.
fn places(of: &MultipleShooting, k: usize, steps: usize, (counts, states): ([usize; 3], usize)) -> Vec<usize> {
    let [state, controls, _] = counts;
    let mut places = Vec::new();
    let (mut control, mut other, mut start) = (0, 0, 0);
    for of in of.whole.free() {
        match Kind::of(&of.quantity) {
            Kind::Control => {
                places.push(state + control);
                places.extend((0..steps).map(|step| states + step * controls + control));
                control += 1;
            }
            Kind::Start if k > 0 => {}
            Kind::Start => {
                places.push(states + steps * controls + start);
                start += 1;
            }
            Kind::Other => {
                places.push(state + controls + other);
                other += 1;
            }
        }
    }
    if k > 0 {
        places.extend(0..state);
    }
    places
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
