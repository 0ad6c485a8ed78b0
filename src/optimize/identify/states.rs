//! States at the starts of segments from the readings in them, one segment after the other.

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

use super::super::multiple_shooting::MultipleShooting;
use super::super::problem::{Interval, Problem};
use super::super::segment::Segment;
use super::super::stages::owners;
use super::super::{Options, levenberg_marquardt, silent};
use crate::Error;
use crate::solver::Asked;

/// The fit of a state ends after this many iterations, or at derivatives below this fraction of the first ones.
const ITERATIONS: usize = 20;
const STATIONARITY: f64 = 1e-3;

/// Fits the states at the starts of the segments to the residuals in them. Each fit begins at the end of the segment before, so that the residuals
/// determine what they depend on, and the motion before all else. Returns the variables, and the number of evaluations of one segment.
///
/// # Errors
/// Problems that do not fit; none for segments without a motion, which keep their guess.
pub(super) fn fit_states(shooting: &mut MultipleShooting) -> Result<(Vec<f64>, usize), Error> {
    let (owners, mut x) = (owners(shooting), shooting.start());
    let (times, bounds) = (shooting.inputs_at(&x).grid.times(), shooting.bounds());
    let starts: Vec<usize> = shooting.whole.parts().filter(|(free, _)| free.quantity.is_initial()).flat_map(range).collect();
    let (mut end, mut evaluations): (Option<[DVector<f64>; 2]>, usize) = (None, 0);
    for (k, segment) in shooting.segments.iter_mut().enumerate() {
        if let Some([q, v]) = end.take().filter(|_| k > 0) {
            let z = segment.guess(&q, &v);
            segment.start_places().iter().zip(z).for_each(|(&at, z)| x[at] = z);
        }
        let places: &[usize] = if k > 0 { segment.start_places() } else { &starts };
        let free: Vec<usize> = (0..segment.places.len()).filter(|&i| places.contains(&segment.places[i])).collect();
        let is_asked = |j: &usize| owners[*j] == Some(k) && shooting.constraints[*j] != Interval::FREE;
        let outputs: Vec<usize> = (0..owners.len()).filter(is_asked).collect();
        let own: Vec<f64> = segment.places.iter().map(|&at| x[at]).collect();
        let intervals = outputs.iter().map(|&j| shooting.constraints[j]).collect();
        let bounds = free.iter().map(|&i| bounds[segment.places[i]]).collect();
        let mut one = One { time: times[segment.first], segment, own, free, outputs, intervals, bounds };
        let (count, has_motion) = one.fit()?;
        evaluations += count;
        let One { segment, own, .. } = one;
        segment.places.iter().zip(own).for_each(|(&at, value)| x[at] = value);
        let n = segment.motion.solver.system().n();
        let state = has_motion.then(|| segment.motion.solver.end());
        end = state.map(|of| [&of[..n], &of[n..2 * n]].map(DVector::from_column_slice));
    }
    Ok((x, evaluations))
}

fn range<T>((_, range): (T, Range<usize>)) -> Range<usize> {
    range
}

/// The residuals of one segment as functions of its start.
struct One<'s> {
    segment: &'s mut Segment,
    time: f64,
    /// The variables of the segment, of which these are free.
    own: Vec<f64>,
    free: Vec<usize>,
    /// The outputs that only this segment contributes to.
    outputs: Vec<usize>,
    intervals: Vec<Interval>,
    bounds: Vec<Interval>,
}

impl One<'_> {
    /// Fits the start, if there is anything to fit, and leaves the segment with its motion. Returns the number of evaluations, and true if there is a
    /// motion.
    fn fit(&mut self) -> Result<(usize, bool), Error> {
        let start: Vec<f64> = self.free.iter().map(|&i| self.own[i]).collect();
        if self.free.is_empty() || self.outputs.is_empty() {
            let mut c = vec![0.0; self.outputs.len()];
            return Ok((1, self.evaluate(&start, &mut c).is_ok()));
        }
        let options = Options { iterations: ITERATIONS, stationarity: STATIONARITY, ..Options::default() };
        let fit = levenberg_marquardt(self, &start, &options, &mut silent)?;
        self.set(&fit.outcome.x);
        Ok((fit.outcome.evaluations, fit.outcome.value.is_finite()))
    }

    fn set(&mut self, x: &[f64]) {
        self.free.iter().zip(x).for_each(|(&i, x)| self.own[i] = *x);
    }
}

impl Problem for One<'_> {
    fn variables(&self) -> usize {
        self.free.len()
    }

    fn bounds(&self) -> Vec<Interval> {
        self.bounds.clone()
    }

    fn constraints(&self) -> Vec<Interval> {
        self.intervals.clone()
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.set(x);
        let (_, found) = self.segment.try_at(&self.own, self.time)?;
        self.segment.settle();
        c.iter_mut().zip(&self.outputs).for_each(|(c, &output)| *c = found[output]);
        Ok(0.0)
    }

    fn gradient(&mut self, _: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let mut weights = vec![0.0; self.segment.motion.outputs()];
        self.outputs.iter().zip(c_weights).for_each(|(&output, w)| weights[output] = *w);
        let mut own = vec![0.0; self.own.len()];
        self.segment.gradient(0.0, (&weights, &[]), &mut own)?;
        gradient.iter_mut().zip(&self.free).for_each(|(g, &i)| *g = own[i]);
        Ok(())
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        let asked: Vec<Asked> = rows.iter().map(|&row| Asked::Output(self.outputs[row])).collect();
        let mut own = DMatrix::zeros(rows.len(), self.own.len());
        self.segment.jacobian(&asked, &mut own)?;
        jacobian.copy_from(&own.select_columns(&self.free));
        Ok(())
    }
}
