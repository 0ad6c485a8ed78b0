//! [`Segments`]: multiple shooting as a problem in stages, one stage for each segment.

use nalgebra::{DMatrix, DVector};

use super::super::multiple_shooting::MultipleShooting;
use super::super::problem::Problem;
use super::super::segment::Segment;
use super::layout::{Layout, Row, Shared};
use super::method::Slopes;
use super::problem::{Counts, Linear, Multipliers, Shape, Staged, Values};
use crate::Error;
use crate::solver::{Asked, each_mut};

/// The problem of multiple shooting, with its variables arranged in stages.
pub(super) struct Segments<'p> {
    pub(super) of: &'p mut MultipleShooting,
    pub(super) at: Layout,
    work: Counts,
}

impl<'p> Segments<'p> {
    pub(super) fn new(of: &'p mut MultipleShooting) -> Self {
        Segments { at: Layout::new(of), of, work: Counts::default() }
    }

    /// The point of the stages for variables of the whole problem; the sums are those of the last evaluation, or 0.
    pub(super) fn point(&self, x: &[f64]) -> Vec<DVector<f64>> {
        let mut v: Vec<DVector<f64>> = self.at.shape.bounds.iter().map(|of| DVector::zeros(of.len())).collect();
        for ((v, places), segment) in v.iter_mut().zip(&self.at.places).zip(&self.of.segments) {
            places.iter().zip(&segment.places).for_each(|(&at, &variable)| v[at] = x[variable]);
        }
        // The end has copies of the last knots and of the quantities of the whole motion.
        let last = self.at.places.len() - 1;
        self.at.shape.of_whole.iter().for_each(|&i| v[last + 1][i] = v[last][i]);
        self.at.shared[last].iter().for_each(|&Shared { from, to }| v[last + 1][to] = v[last][from]);
        v
    }

    /// For each continuous state of a segment, the entry of (q, v, p*) at its end.
    fn ends(&self, k: usize) -> Vec<usize> {
        self.of.joints(k).map(|joint| joint.end).collect()
    }

    /// Sets the sums of outputs in the states of a point.
    ///
    /// # Errors
    /// A point without values.
    pub(super) fn with_sums(&mut self, v: &mut [DVector<f64>]) -> Result<(), Error> {
        if self.at.ends.is_empty() {
            return Ok(());
        }
        let values = self.evaluate(v)?;
        for &(at, _) in &self.at.ends {
            let mut sum = 0.0;
            for (v, next) in v.iter_mut().zip(&values.next) {
                let share = next[at] - v[at];
                v[at] = sum;
                sum += share;
            }
            v[self.at.places.len()][at] = sum;
        }
        Ok(())
    }

    /// Derivatives of the Lagrangian by the variables of the stages and by the slacks of their rows, from those by the variables of the whole problem,
    /// and from the multipliers of the outputs.
    pub(super) fn slopes(&self, by_x: &[f64], multipliers: &[f64]) -> Slopes {
        let of_rows = |of: &Vec<Row>| {
            let own = of.iter().filter(|row| row.sum.is_none());
            DVector::from_iterator(own.clone().count(), own.map(|row| -multipliers[row.output]))
        };
        let mut rows: Vec<DVector<f64>> = self.at.rows.iter().map(of_rows).collect();
        let of_ends = self.at.ends.iter().map(|&(_, output)| -multipliers[output]);
        rows.push(DVector::from_iterator(self.at.ends.len(), of_ends));
        Slopes { variables: self.point(by_x), rows }
    }

    /// The multipliers of the outputs and of the continuity conditions, in the order of the constraints of the whole problem.
    pub(super) fn multipliers(&self, Multipliers { costates, rows }: &Multipliers) -> Vec<f64> {
        let mut all = vec![0.0; self.of.constraints.len()];
        for (k, of) in self.at.rows.iter().enumerate() {
            let local = of.iter().filter(|row| row.sum.is_none());
            local.zip(rows[k].iter()).for_each(|(row, w)| all[row.output] = *w);
            self.of.joints(k).enumerate().for_each(|(i, joint)| all[joint.row] = costates[k][i]);
        }
        self.at.ends.iter().zip(rows[self.at.places.len()].iter()).for_each(|(&(_, output), w)| all[output] = *w);
        all
    }
}

impl Staged for Segments<'_> {
    fn shape(&self) -> &Shape {
        &self.at.shape
    }

    fn counts(&self) -> Counts {
        self.work
    }

    fn is_halved(&self) -> bool {
        self.of.is_halved()
    }

    fn x(&self, v: &[DVector<f64>]) -> Vec<f64> {
        let mut x = vec![0.0; self.of.variables()];
        for ((v, places), segment) in v.iter().zip(&self.at.places).zip(&self.of.segments) {
            places.iter().zip(&segment.places).for_each(|(&at, &variable)| x[variable] = v[at]);
        }
        x
    }

    fn evaluate(&mut self, v: &[DVector<f64>]) -> Result<Values, Error> {
        self.work.evaluations += 1;
        let x = self.x(v);
        let mut values = Values { cost: 0.0, next: Vec::new(), rows: Vec::new() };
        let outputs = self.of.running.len();
        let found = self.of.evaluate_segments(&x)?;
        for (k, (cost, c)) in found.into_iter().enumerate() {
            let minimised = (0..outputs).filter(|&output| self.of.minimised[output] && self.of.contributes(k, output));
            values.cost += cost + minimised.map(|output| c[output]).sum::<f64>();
            let mut next = DVector::zeros(self.at.shape.states);
            let end = self.of.segments[k].motion.solver.end();
            self.ends(k).into_iter().enumerate().for_each(|(i, entry)| next[i] = end[entry]);
            self.at.shared[k].iter().for_each(|&Shared { from, to }| next[to] = v[k][from]);
            self.at.shape.of_whole.iter().for_each(|&i| next[i] = v[k][i]);
            let mut rows = Vec::new();
            for row in &self.at.rows[k] {
                match row.sum {
                    Some(at) => next[at] = v[k][at] + c[row.output],
                    None => rows.push(c[row.output]),
                }
            }
            values.next.push(next);
            values.rows.push(DVector::from_vec(rows));
        }
        let end = &v[self.at.places.len()];
        values.rows.push(DVector::from_iterator(self.at.ends.len(), self.at.ends.iter().map(|&(at, _)| end[at])));
        Ok(values)
    }

    fn linearise(&mut self) -> Result<Vec<Linear>, Error> {
        let of_all: Vec<Wanted> = (0..self.at.places.len()).map(|k| self.wanted(k)).collect();
        let at = &self.at;
        let mut all = each_mut(&mut self.of.segments, |k, segment| linearised((k, at), segment, &of_all[k]))?;
        let mut rows = DMatrix::zeros(self.at.ends.len(), self.at.shape.states);
        self.at.ends.iter().enumerate().for_each(|(i, &(at, _))| rows[(i, at)] = 1.0);
        all.push(Linear { gradient: DVector::zeros(rows.ncols()), dynamics: DMatrix::zeros(0, rows.ncols()), rows });
        self.work.gradients += 1 + of_all[0].asked.len();
        Ok(all)
    }

    fn hessians(&mut self, cost: f64, multipliers: &Multipliers) -> Result<Vec<DMatrix<f64>>, Error> {
        let of_all: Vec<Weights> = (0..self.at.places.len()).map(|k| self.weights(k, cost, multipliers)).collect();
        let at = &self.at;
        let mut all = each_mut(&mut self.of.segments, |k, segment| hessian((k, at), segment, &of_all[k]))?;
        all.push(DMatrix::zeros(self.at.shape.states, self.at.shape.states));
        self.work.products += self.at.places[0].len();
        Ok(all)
    }
}

/// The functions of a segment that are differentiated once.
struct Wanted {
    /// The continuous states at the end of the segment, then its constrained outputs.
    asked: Vec<Asked>,
    /// Number of continuous states.
    continuous: usize,
    /// Weights of the outputs that are terms of the cost.
    minimised: Vec<f64>,
}

/// The function of a segment whose Hessian is wanted.
struct Weights {
    cost: f64,
    of_outputs: Vec<f64>,
    of_end: Vec<f64>,
}

impl Segments<'_> {
    /// Weights of the outputs of a segment that are terms of the cost.
    fn minimised(&self, k: usize, weight: f64) -> Vec<f64> {
        let is_term = |output: usize| self.of.minimised[output] && self.of.contributes(k, output);
        (0..self.of.running.len()).map(|output| if is_term(output) { weight } else { 0.0 }).collect()
    }

    fn wanted(&self, k: usize) -> Wanted {
        let (ends, rows) = (self.ends(k), self.at.rows[k].iter().map(|row| Asked::Output(row.output)));
        let (continuous, minimised) = (ends.len(), self.minimised(k, 1.0));
        Wanted { asked: ends.into_iter().map(Asked::End).chain(rows).collect(), continuous, minimised }
    }

    fn weights(&self, k: usize, cost: f64, multipliers: &Multipliers) -> Weights {
        let (costates, mut of_outputs) = (multipliers.costates[k].as_slice(), self.minimised(k, cost));
        let mut of_end = vec![0.0; 3 * self.of.system().n()];
        self.ends(k).into_iter().zip(costates).for_each(|(entry, costate)| of_end[entry] += costate);
        let mut of_rows = multipliers.rows[k].iter();
        for row in &self.at.rows[k] {
            let of_row = row.sum.map_or_else(|| of_rows.next(), |at| costates.get(at));
            of_outputs[row.output] += of_row.unwrap_or(&0.0);
        }
        Weights { cost, of_outputs, of_end }
    }
}

fn linearised((k, at): (usize, &Layout), segment: &mut Segment, wanted: &Wanted) -> Result<Linear, Error> {
    let size = at.shape.bounds[k].len();
    let mut of = Linear {
        gradient: DVector::zeros(size),
        dynamics: DMatrix::zeros(at.shape.states, size),
        rows: DMatrix::zeros(at.shape.rows[k].len(), size),
    };
    let places = &at.places[k];
    let mut gradient = vec![0.0; places.len()];
    segment.gradient(1.0, (&wanted.minimised, &[]), &mut gradient)?;
    places.iter().zip(&gradient).for_each(|(&at, g)| of.gradient[at] = *g);
    let mut jacobian = DMatrix::zeros(wanted.asked.len(), places.len());
    segment.jacobian(&wanted.asked, &mut jacobian)?;
    let mut local = 0;
    for (i, row) in jacobian.row_iter().enumerate() {
        let sum = if i < wanted.continuous { Some(i) } else { at.rows[k][i - wanted.continuous].sum };
        let mut into = match sum {
            Some(at) => of.dynamics.row_mut(at),
            None => {
                local += 1;
                of.rows.row_mut(local - 1)
            }
        };
        places.iter().zip(row.iter()).for_each(|(&at, x)| into[at] = *x);
    }
    at.shared[k].iter().for_each(|&Shared { from, to }| of.dynamics[(to, from)] = 1.0);
    let kept = at.shape.of_whole.iter().copied().chain(at.ends.iter().map(|&(at, _)| at));
    kept.for_each(|i| of.dynamics[(i, i)] = 1.0);
    Ok(of)
}

fn hessian((k, at): (usize, &Layout), segment: &mut Segment, of: &Weights) -> Result<DMatrix<f64>, Error> {
    let (size, places) = (at.shape.bounds[k].len(), &at.places[k]);
    let mut gradient = vec![0.0; places.len()];
    segment.gradient(of.cost, (&of.of_outputs, &of.of_end), &mut gradient)?;
    let (own, mut hessian) = (segment.hessian()?, DMatrix::zeros(size, size));
    for (column, &j) in own.column_iter().zip(places) {
        column.iter().zip(places).for_each(|(x, &i)| hessian[(i, j)] = *x);
    }
    Ok(hessian)
}
