//! [`MultipleShooting`] as a [`Problem`]: values and derivatives assembled from all segments.

use nalgebra::DMatrix;
use std::collections::HashMap;

use super::super::problem::{Interval, Problem};
use super::super::segment::Segment;
use super::MultipleShooting;
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

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.sizes().values(x, c)?;
        c.fill(0.0);
        let mut sum = 0.0;
        for (k, (cost, found)) in self.evaluate_segments(x)?.into_iter().enumerate() {
            sum += cost;
            self.rows(k).for_each(|output| c[output] += found[output]);
            self.joints(k).for_each(|(row, output, start)| c[row] = found[output] - x[start]);
        }
        Ok(sum + (0..self.running.len()).filter(|&k| self.minimised[k]).map(|k| c[k]).sum::<f64>())
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.sizes().gradient(c_weights, gradient)?;
        gradient.fill(0.0);
        for k in 0..self.segments.len() {
            let mut weights = vec![0.0; self.segments[k].motion.outputs()];
            let of_f = |output: usize| if self.minimised[output] { f_weight } else { 0.0 };
            self.rows(k).for_each(|output| weights[output] = c_weights[output] + of_f(output));
            for (row, output, start) in self.joints(k) {
                weights[output] = c_weights[row];
                gradient[start] -= c_weights[row];
            }
            let segment = &mut self.segments[k];
            let mut own = vec![0.0; segment.places.len()];
            segment.motion.gradient(f_weight, &weights, &mut own)?;
            segment.places.iter().zip(own).for_each(|(&at, g)| gradient[at] += g);
        }
        Ok(())
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        self.sizes().jacobian(rows, jacobian)?;
        jacobian.fill(0.0);
        let places = places(rows);
        for k in 0..self.segments.len() {
            let own = self.outputs_in(k, &places);
            for (row, _, start) in self.joints(k) {
                if let Some(&at) = places.get(&row) {
                    jacobian[(at, start)] -= 1.0;
                }
            }
            let Segment { motion, places, .. } = &mut self.segments[k];
            let outputs: Vec<usize> = own.iter().map(|(output, _)| *output).collect();
            let mut part = DMatrix::zeros(own.len(), places.len());
            motion.jacobian(&outputs, &mut part)?;
            for (&(_, at), row) in own.iter().zip(part.row_iter()) {
                places.iter().zip(row.iter()).for_each(|(&variable, x)| jacobian[(at, variable)] += x);
            }
        }
        Ok(())
    }

    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        let places = places(rows);
        self.segments.iter().enumerate().fold([0; 2], |[by_rows, by_columns], (k, segment)| {
            let outputs: Vec<usize> = self.outputs_in(k, &places).into_iter().map(|(output, _)| output).collect();
            let work = segment.motion.jacobian_work(&outputs);
            [by_rows + work[0], by_columns + work[1]]
        })
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.sizes().push_forward(direction, change)?;
        let mut found = vec![0.0; self.segments[0].motion.outputs()];
        change.fill(0.0);
        for k in 0..self.segments.len() {
            let segment = &mut self.segments[k];
            let own: Vec<f64> = segment.places.iter().map(|&at| direction[at]).collect();
            segment.motion.push_forward(&own, &mut found)?;
            self.rows(k).for_each(|output| change[output] += found[output]);
            self.joints(k).for_each(|(row, output, start)| change[row] = found[output] - direction[start]);
        }
        Ok(())
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.sizes().product(direction, product)?;
        product.fill(0.0);
        for segment in &mut self.segments {
            let own: Vec<f64> = segment.places.iter().map(|&at| direction[at]).collect();
            let mut found = vec![0.0; own.len()];
            segment.motion.product(&own, &mut found)?;
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
    /// The cost and the outputs of every segment.
    ///
    /// # Errors
    /// A segment without a motion.
    pub(in super::super) fn evaluate_segments(&mut self, x: &[f64]) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let whole = self.inputs_at(x);
        let times = whole.grid.times();
        let of = |segment: &mut Segment| {
            segment.motion.start_at(times[segment.first]);
            let own: Vec<f64> = segment.places.iter().map(|&at| x[at]).collect();
            let mut found = vec![0.0; segment.motion.outputs()];
            Ok((segment.motion.try_at(&own, &mut found)?, found))
        };
        let found = self.segments.iter_mut().map(of).collect::<Result<Vec<_>, Error>>()?;
        // After all segments succeeded, so that none keeps a point at which another one has no value.
        self.segments.iter_mut().for_each(|segment| segment.motion.settle());
        (self.inputs, self.x) = (whole, x.to_vec());
        Ok(found)
    }

    /// The outputs of a segment that contribute to rows with these positions, each with its position.
    fn outputs_in(&self, segment: usize, places: &HashMap<usize, usize>) -> Vec<(usize, usize)> {
        let joints = self.joints(segment).map(|(row, output, _)| (row, output));
        let all = self.rows(segment).map(|output| (output, output)).chain(joints);
        all.filter_map(|(row, output)| Some((output, *places.get(&row)?))).collect()
    }
}
