//! [`Segment`]: a part of a motion, treated as a motion of its own.

mod independent;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

use super::free::{Free, Quantity};
use super::motion_problem::MotionProblem;
use super::problem::{Interval, Problem, set_row};
use super::variables::Variables;
use crate::solver::Asked;
use crate::{Coordinate, Error, Inputs, Settings, Start, System};
use independent::IndependentStart;

/// The problem of a part of a motion, and its place in the whole problem.
#[derive(Debug)]
pub(super) struct Segment {
    pub(super) motion: MotionProblem,
    /// The first and the last node.
    pub(super) first: usize,
    pub(super) last: usize,
    /// The index in the whole problem of each variable of the segment.
    pub(super) places: Vec<usize>,
    /// The knots that affect the segment, of each free quantity of the whole problem.
    pub(super) knots: Vec<Range<usize>>,
    begin: Begin,
    /// The variables of the motion at the last point.
    own: Vec<f64>,
}

/// A part of a motion: its first and last node, and the knots of each free quantity that affect it.
pub(super) struct Part {
    pub(super) nodes: Range<usize>,
    pub(super) knots: Vec<Range<usize>>,
}

/// The variables of a segment that determine its start; they follow the others.
#[derive(Debug)]
enum Begin {
    /// The start of the whole motion, which has free initial values among the other variables, if any.
    Given,
    /// Independent coordinates and their rates.
    Independent(Box<IndependentStart>),
    /// q and p*, the variables of the segment's motion.
    State,
}

impl Segment {
    /// The segment between two nodes. Unless it begins at the first node, the states of its start are the next variables.
    ///
    /// # Errors
    /// Invalid inputs and variables; states that constraints determine.
    pub(super) fn new(
        (system, settings): (&System, Settings),
        (whole, variables): (&Inputs, &Variables),
        states: &[Coordinate],
        Part { nodes: Range { start: first, end: last }, knots }: Part,
        next: &mut usize,
    ) -> Result<Self, Error> {
        let is_timed = variables.free().iter().any(|of| of.quantity == Quantity::Duration);
        if is_timed && share(whole, first..last) <= 0.0 {
            let why =
                "one of the segments runs backwards in time or has zero length; use other segments, or fix the duration";
            return Err(Error::NotInSegments { what: "a free duration".into(), why });
        }
        let (mut own, mut places) = own_variables(variables, whole, (first..last, &knots));
        let inputs = own_inputs(system, whole, (first, last));
        let mut begin = Begin::Given;
        if first > 0 {
            let start = IndependentStart::new(system, states, &inputs)?;
            places.extend(*next..*next + start.len());
            *next += start.len();
            let all = (0..system.n()).map(|i| system.coordinate(i));
            let state = all.clone().map(Quantity::Coordinate).chain(all.map(Quantity::Rate));
            own.extend(state.map(|of| (Free::new(of), 0..1)));
            begin = Begin::Independent(Box::new(start));
        }
        let between = [0..first, 0..last].map(|nodes| share(whole, nodes));
        let variables = Variables::with_knots(system, &inputs, own.into_iter().unzip(), between)?;
        let motion = MotionProblem::new(system, settings, inputs, variables)?;
        Ok(Segment { own: motion.start(), motion, first, last, places, knots, begin })
    }

    /// The number of variables that determine only the start.
    fn state(&self) -> usize {
        match &self.begin {
            Begin::Given => 0,
            Begin::Independent(start) => start.len(),
            Begin::State => 2 * self.motion.solver.system().n(),
        }
    }

    /// The variables of the whole problem that determine only the start.
    pub(super) fn start_places(&self) -> &[usize] {
        &self.places[self.places.len() - self.state()..]
    }

    /// The variables of the start for a guess of q and v.
    pub(super) fn guess(&mut self, q: &DVector<f64>, v: &DVector<f64>) -> Vec<f64> {
        self.seek_near(q);
        if let Begin::Independent(start) = &self.begin { start.of(q, v) } else { Vec::new() }
    }

    /// Sets the coordinates near which the start is sought.
    pub(super) fn seek_near(&mut self, q: &DVector<f64>) {
        if let Begin::Independent(start) = &mut self.begin {
            start.near().copy_from_slice(q.as_slice());
        }
    }

    /// The coordinates near which the start is sought; `None` for the first segment.
    pub(super) fn near(&mut self) -> Option<DVector<f64>> {
        let Begin::Independent(start) = &mut self.begin else { return None };
        Some(DVector::from_column_slice(start.near()))
    }

    /// Replaces the variables of the start, which are those of no state, by those of a state near it; false if there is none.
    pub(super) fn approach(&mut self, z: &mut [f64]) -> bool {
        match &mut self.begin {
            Begin::Independent(start) => start.approach(z),
            Begin::Given | Begin::State => false,
        }
    }

    /// J and the outputs at a point that does not become the current one.
    ///
    /// # Errors
    /// A point without a motion.
    pub(super) fn try_at(&mut self, x: &[f64], time: f64) -> Result<(f64, Vec<f64>), Error> {
        self.motion.start_at(time);
        let (others, n) = (x.len() - self.state(), self.motion.solver.system().n());
        match &mut self.begin {
            Begin::Independent(start) => {
                self.own[..others].copy_from_slice(&x[..others]);
                let [q, p] = start.place(&x[others..], &self.own, &mut self.motion)?;
                self.own[others..others + n].copy_from_slice(q.as_slice());
                self.own[others + n..].copy_from_slice(p.as_slice());
            }
            Begin::Given | Begin::State => self.own.copy_from_slice(x),
        }
        let mut found = vec![0.0; self.motion.outputs()];
        Ok((self.motion.try_at(&self.own, &mut found)?, found))
    }

    /// Continues the motion before, whose constraints have this drift and these multipliers at its end.
    pub(super) fn continue_from(&mut self, end: [Vec<f64>; 2]) {
        if let Begin::Independent(start) = &mut self.begin {
            start.continue_from(end);
        }
    }

    /// Makes q and p* the variables of the start, with indices from `next` on in the whole problem, and returns their values.
    pub(super) fn use_state(&mut self, next: usize) -> Vec<f64> {
        let (others, n) = (self.places.len() - self.state(), self.motion.solver.system().n());
        self.begin = Begin::State;
        self.places.truncate(others);
        self.places.extend(next..next + 2 * n);
        self.own[others..].to_vec()
    }

    /// Makes the last tried point the current one.
    pub(super) fn settle(&mut self) {
        self.motion.settle();
        if let Begin::Independent(start) = &mut self.begin {
            start.settle();
        }
    }

    /// The gradient of a weighted sum of J, the outputs, and (q, v, p*) at the end.
    ///
    /// # Errors
    /// A point without derivatives.
    pub(super) fn gradient(
        &mut self,
        f_weight: f64,
        (of_outputs, of_end): (&[f64], &[f64]),
        gradient: &mut [f64],
    ) -> Result<(), Error> {
        let mut own = vec![0.0; self.own.len()];
        self.motion.gradient_with_end(f_weight, (of_outputs, of_end), &mut own)?;
        match &mut self.begin {
            Begin::Independent(start) => start.pull_back_and_keep((self.motion.free(), &self.own), &own, gradient),
            Begin::Given | Begin::State => {
                gradient.copy_from_slice(&own);
                Ok(())
            }
        }
    }

    /// The derivatives of outputs and of entries of (q, v, p*) at the end.
    ///
    /// # Errors
    /// A point without derivatives.
    pub(super) fn jacobian(&mut self, asked: &[Asked], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        let mut own = DMatrix::zeros(asked.len(), self.own.len());
        self.motion.jacobian_of(asked, &mut own)?;
        let Begin::Independent(start) = &mut self.begin else {
            jacobian.copy_from(&own);
            return Ok(());
        };
        let mut row = vec![0.0; self.places.len()];
        for (k, own) in own.row_iter().enumerate() {
            let own: Vec<f64> = own.iter().copied().collect();
            start.pull_back((self.motion.free(), &self.own), &own, &mut row)?;
            set_row(jacobian, k, &row);
        }
        Ok(())
    }

    /// The changes of the outputs and of (q, v, p*) at the end along a direction.
    ///
    /// # Errors
    /// A point without derivatives.
    pub(super) fn push_forward(&mut self, direction: &[f64]) -> Result<[Vec<f64>; 2], Error> {
        let own = self.along(direction)?;
        let mut change = vec![0.0; self.motion.outputs()];
        self.motion.push_forward(&own, &mut change)?;
        let is_zero = own.iter().all(|x| *x == 0.0);
        let end = if is_zero { vec![0.0; 3 * self.motion.solver.system().n()] } else { self.motion.solver.change_of_end() };
        Ok([change, end])
    }

    /// The product of the Hessian of the function differentiated last with a direction.
    ///
    /// # Errors
    /// A point without second derivatives.
    pub(super) fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let along = self.along(direction)?;
        let mut own = vec![0.0; along.len()];
        self.motion.product(&along, &mut own)?;
        match &mut self.begin {
            Begin::Independent(start) => {
                start.pull_back((self.motion.free(), &self.own), &own, product)?;
                start.add_curvature(self.motion.free(), direction, product);
            }
            Begin::Given | Begin::State => product.copy_from_slice(&own),
        }
        Ok(())
    }

    /// The Hessian of the function differentiated last: by products along quantities of the whole motion, and by changes of the motion along the others.
    ///
    /// # Errors
    /// A point without second derivatives.
    pub(super) fn hessian(&mut self) -> Result<DMatrix<f64>, Error> {
        let size = self.places.len();
        let (mut direction, mut hessian) = (vec![0.0; size], DMatrix::zeros(size, size));
        let mut product = vec![0.0; size];
        let (local, whole): (Vec<usize>, Vec<usize>) = (0..size).partition(|&i| self.is_local(i));
        if !local.is_empty() && self.motion.begin_hessian(local.len())? {
            let first = self.motion.free().first_nodes();
            for (count, &i) in local.iter().enumerate() {
                direction[i] = 1.0;
                self.row((&direction, first[i]), &local[..=count], &mut product)?;
                direction[i] = 0.0;
                local[..=count].iter().for_each(|&j| (hessian[(i, j)], hessian[(j, i)]) = (product[j], product[j]));
            }
        }
        for i in whole {
            direction[i] = 1.0;
            self.product(&direction, &mut product)?;
            direction[i] = 0.0;
            (0..size).for_each(|j| (hessian[(i, j)], hessian[(j, i)]) = (product[j], product[j]));
        }
        Ok(hessian)
    }

    /// True for controls, and for the states of the start, in motions without events.
    fn is_local(&self, i: usize) -> bool {
        let is_state = i >= self.places.len() - self.state();
        !self.motion.solver.has_events() && (is_state || self.motion.free().quantity(i).control().is_some())
    }

    /// The entries of a row of the Hessian, along a direction which changes nothing before a node, for the variables up to this one.
    fn row(&mut self, (direction, node): (&[f64], usize), known: &[usize], row: &mut [f64]) -> Result<(), Error> {
        let (others, along) = (direction.len() - self.state(), self.along(direction)?);
        let mut own = vec![0.0; along.len()];
        let of_changes = self.motion.hessian_along(&along, node, &mut own)?;
        row.fill(0.0);
        row[..others].copy_from_slice(&own[..others]);
        known.iter().zip(of_changes).for_each(|(&j, x)| row[j] += x);
        if let Begin::Independent(start) = &mut self.begin
            && direction[others..].iter().any(|x| *x != 0.0)
        {
            start.add_curvature(self.motion.free(), direction, row);
        }
        Ok(())
    }

    /// The direction of the variables of the motion.
    fn along(&mut self, direction: &[f64]) -> Result<Vec<f64>, Error> {
        match &mut self.begin {
            Begin::Independent(start) => start.push_forward((self.motion.free(), &self.own), direction),
            Begin::Given | Begin::State => Ok(direction.to_vec()),
        }
    }
}

/// The fraction of a motion's duration between two nodes; 0 if it has no duration.
fn share(inputs: &Inputs, nodes: Range<usize>) -> f64 {
    let sum = |steps: &[f64]| steps.iter().sum::<f64>();
    let duration = sum(&inputs.grid.steps);
    if duration == 0.0 { 0.0 } else { sum(&inputs.grid.steps[nodes]) / duration }
}

/// The free quantities of a segment with their knots, and their variables in the whole problem; except for the first segment, without initial values.
fn own_variables(
    whole: &Variables,
    inputs: &Inputs,
    (nodes, all_knots): (Range<usize>, &[Range<usize>]),
) -> (Vec<(Free, Range<usize>)>, Vec<usize>) {
    let (mut own, mut places) = (Vec::new(), Vec::new());
    for ((of, range), knots) in whole.parts().zip(all_knots) {
        let of = match of.quantity {
            Quantity::Duration => {
                let (share, Interval { least, most }) = (share(inputs, nodes.clone()), of.bounds);
                Free { scale: of.scale * share, bounds: Interval::new(least * share, most * share), ..of.clone() }
            }
            _ if of.quantity.is_initial() && nodes.start > 0 => continue,
            _ => of.clone(),
        };
        own.push((of, knots.clone()));
        places.extend(knots.clone().map(|knot| range.start + knot));
    }
    (own, places)
}

/// The inputs between two nodes; except for the first segment, momenta are given.
fn own_inputs(system: &System, inputs: &Inputs, (first, last): (usize, usize)) -> Inputs {
    let mut own = inputs.clone();
    own.grid = inputs.grid.part(first, last);
    own.controls = inputs.controls.columns(first, last - first + 1).into_owned();
    if first > 0 {
        own.start = Start::Momentum { q: inputs.start.q().clone(), p_star: DVector::zeros(system.n()) };
    }
    own
}
