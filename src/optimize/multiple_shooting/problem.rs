//! [`MultipleShooting`] as a [`Problem`]: values and derivatives assembled from all segments.

use nalgebra::DMatrix;
use std::collections::HashMap;

use super::super::problem::{Interval, Problem};
use super::super::segment::Segment;
use super::MultipleShooting;
use crate::solver::{Asked, each_mut};
use crate::{Error, Report, Warning};

impl Problem for MultipleShooting {
    fn variables(&self) -> usize {
        self.names.len()
    }

    fn bounds(&self) -> Vec<Interval> {
        let mut bounds = self.whole.bounds();
        bounds.resize(self.names.len(), Interval::FREE);
        bounds
    }

    fn constraints(&self) -> Vec<Interval> {
        self.constraints.clone()
    }

    fn variable_name(&self, i: usize) -> String {
        self.names[i].clone()
    }

    fn constraint_name(&self, j: usize) -> String {
        match j.checked_sub(self.running.len()) {
            None => self.segments[0].motion.constraint_name(j),
            Some(joint) => format!("the continuity of `{}`", self.names[self.whole.len() + joint]),
        }
    }

    fn warnings(&self) -> Vec<Warning> {
        Report::of_all(self.segments.iter().map(|segment| segment.motion.solver.report().clone())).warnings
    }

    fn is_reading(&self, j: usize) -> bool {
        j < self.running.len() && self.segments[0].motion.is_reading(j)
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        let f = self.try_at(x, c)?;
        self.settle();
        Ok(f)
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.sizes().gradient(c_weights, gradient)?;
        gradient.fill(0.0);
        for k in 0..self.segments.len() {
            let mut weights = vec![0.0; self.segments[k].motion.outputs()];
            let mut of_end = vec![0.0; 3 * self.system().n()];
            let of_f = |output: usize| if self.minimised[output] { f_weight } else { 0.0 };
            self.rows(k).for_each(|output| weights[output] = c_weights[output] + of_f(output));
            for joint in self.joints(k) {
                of_end[joint.end] = c_weights[joint.row];
                gradient[joint.start] -= c_weights[joint.row];
            }
            let segment = &mut self.segments[k];
            let mut own = vec![0.0; segment.places.len()];
            segment.gradient(f_weight, (&weights, &of_end), &mut own)?;
            segment.places.iter().zip(own).for_each(|(&at, g)| gradient[at] += g);
        }
        Ok(())
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        self.sizes().jacobian(rows, jacobian)?;
        jacobian.fill(0.0);
        let places = places(rows);
        for k in 0..self.segments.len() {
            let own = self.asked_in(k, &places);
            for joint in self.joints(k) {
                if let Some(&at) = places.get(&joint.row) {
                    jacobian[(at, joint.start)] -= 1.0;
                }
            }
            let segment = &mut self.segments[k];
            let asked: Vec<Asked> = own.iter().map(|(asked, _)| *asked).collect();
            let mut part = DMatrix::zeros(own.len(), segment.places.len());
            segment.jacobian(&asked, &mut part)?;
            for (&(_, at), row) in own.iter().zip(part.row_iter()) {
                segment.places.iter().zip(row.iter()).for_each(|(&variable, x)| jacobian[(at, variable)] += x);
            }
        }
        Ok(())
    }

    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        let places = places(rows);
        self.segments.iter().enumerate().fold([0; 2], |[by_rows, by_columns], (k, segment)| {
            let asked: Vec<Asked> = self.asked_in(k, &places).into_iter().map(|(asked, _)| asked).collect();
            let work = segment.motion.solver.jacobian_work(&asked, segment.motion.free().len());
            [by_rows + work[0], by_columns + work[1]]
        })
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.sizes().push_forward(direction, change)?;
        change.fill(0.0);
        for k in 0..self.segments.len() {
            let segment = &mut self.segments[k];
            let own: Vec<f64> = segment.places.iter().map(|&at| direction[at]).collect();
            let [found, end] = segment.push_forward(&own)?;
            self.rows(k).for_each(|output| change[output] += found[output]);
            self.joints(k).for_each(|joint| change[joint.row] = end[joint.end] - direction[joint.start]);
        }
        Ok(())
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.sizes().product(direction, product)?;
        product.fill(0.0);
        for segment in &mut self.segments {
            let own: Vec<f64> = segment.places.iter().map(|&at| direction[at]).collect();
            let mut found = vec![0.0; own.len()];
            segment.product(&own, &mut found)?;
            segment.places.iter().zip(found).for_each(|(&at, x)| product[at] += x);
        }
        Ok(())
    }
}

/// The position of each row in a Jacobian.
fn places(rows: &[usize]) -> HashMap<usize, usize> {
    rows.iter().enumerate().map(|(k, &row)| (row, k)).collect()
}

impl MultipleShooting {
    /// The cost and the outputs of every segment, with the feature `rayon` on all cores.
    ///
    /// # Errors
    /// A segment without a motion.
    pub(in super::super) fn evaluate_segments(&mut self, x: &[f64]) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let found = self.try_segments(x, true)?;
        self.settle();
        Ok(found)
    }

    /// As [`evaluate`](Problem::evaluate), but the point does not become the current one.
    ///
    /// # Errors
    /// A segment without a motion.
    pub(in super::super) fn try_at(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.sizes().values(x, c)?;
        c.fill(0.0);
        let mut sum = 0.0;
        for (k, (cost, found)) in self.try_segments(x, false)?.into_iter().enumerate() {
            sum += cost;
            self.rows(k).for_each(|output| c[output] += found[output]);
            let end = self.segments[k].motion.solver.end();
            self.joints(k).for_each(|joint| c[joint.row] = end[joint.end] - x[joint.start]);
        }
        Ok(sum + (0..self.running.len()).filter(|&k| self.minimised[k]).map(|k| c[k]).sum::<f64>())
    }

    /// Makes the point that was tried last, which has a value, the current one.
    pub(in super::super) fn settle(&mut self) {
        // After all segments succeeded, so that none keeps a point at which another one has no value.
        self.segments.iter_mut().for_each(Segment::settle);
        self.x.clone_from(&self.tried);
        self.inputs = self.inputs_at(&self.tried);
    }

    /// Computes all segments, one after the other or several at once.
    fn try_segments(&mut self, x: &[f64], is_parallel: bool) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let times = self.inputs_at(x).grid.times();
        let of = |segment: &mut Segment| {
            let own: Vec<f64> = segment.places.iter().map(|&at| x[at]).collect();
            segment.try_at(&own, times[segment.first])
        };
        let found = match is_parallel {
            true => each_mut(&mut self.segments, |_, segment| of(segment))?,
            // Reports of progress come in order.
            false => self.segments.iter_mut().map(of).collect::<Result<Vec<_>, Error>>()?,
        };
        self.tried = x.to_vec();
        Ok(found)
    }

    /// What determines rows with these positions in a segment, each with its position.
    fn asked_in(&self, segment: usize, places: &HashMap<usize, usize>) -> Vec<(Asked, usize)> {
        let joints = self.joints(segment).map(|joint| (joint.row, Asked::End(joint.end)));
        let all = self.rows(segment).map(|output| (output, Asked::Output(output))).chain(joints);
        all.filter_map(|(row, asked)| Some((asked, *places.get(&row)?))).collect()
    }
}
