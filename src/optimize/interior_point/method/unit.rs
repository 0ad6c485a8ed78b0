//! The unit of variables: the distance to the minimum of f along its gradient, as far as bounds and constraints permit.

use nalgebra::DVector;

use super::super::super::counted::Counted;
use super::super::super::projection::Projection;
use super::super::super::trust_region::Linearised;
use super::Method;
use crate::Error;
use crate::number::{dot, largest};

/// A smaller relative change of the gradient, when variables change by their size, may be rounding error, for example of finite differences.
const STRAIGHT: f64 = 1e-10;
/// Largest number of continuations of the path along the bounds and constraints that it met.
const TURNS: usize = 5;
/// The path continues only if more than this fraction of the gradient is left.
const LEFT: f64 = 1e-10;

impl Method {
    /// Sets the unit of variables to the distance to the minimum of f along the last gradient; if f is straight, to their first size, or 1.
    pub(super) fn take_unit(&mut self, problem: &mut Counted) -> Result<(), Error> {
        let gradient = self.moving(self.gradient.as_slice());
        let (step, square) = self.parabola(problem, &gradient)?;
        let (slope, known) = (largest(&gradient), largest(&self.moving(&self.start)));
        let unit = if step > 0.0 { step * slope } else { self.size() };
        (self.barrier.unit, self.first_slope, self.first_fall) = (unit, slope, 0.5 * step * slope * slope * square);
        // The path is at least as long as the largest variable at the start.
        if slope > 0.0 && unit > known {
            let way = self.way(problem, gradient)?.max(known);
            if way > 0.0 && way < unit {
                (self.barrier.unit, self.first_fall) = (way, self.first_fall.min(slope * way));
            }
        }
        self.fall = self.first_fall;
        Ok(())
    }

    /// The multiple of a direction at which f is least, 0 if f is straight; and the square of the direction in units of its largest entry.
    fn parabola(&self, problem: &mut Counted, direction: &[f64]) -> Result<(f64, f64), Error> {
        // The largest entry may be of any magnitude.
        let largest = largest(direction);
        let unit: Vec<f64> = direction.iter().map(|d| if largest > 0.0 { d / largest } else { 0.0 }).collect();
        let mut product = vec![0.0; unit.len()];
        problem.product(&unit, &mut product)?;
        let square = dot(&unit, &unit);
        let step = square / dot(&unit, &product).abs();
        let is_straight = !(step * largest).is_finite() || STRAIGHT * step * largest > self.size();
        Ok((if is_straight { 0.0 } else { step }, square))
    }

    /// The largest variable at the start, or 1.
    fn size(&self) -> f64 {
        let size = largest(&self.moving(&self.start));
        if size > 0.0 { size } else { 1.0 }
    }

    /// The largest change of a variable on a path of descent from bound to bound on which equalities hold.
    fn way(&self, problem: &mut Counted, mut d: Vec<f64>) -> Result<f64, Error> {
        let (n, mut way) = (d.len(), 0.0f64);
        let slacks = self.slacks(n);
        let mut held: Vec<usize> = (0..self.rows.len()).filter(|k| slacks.iter().all(|(_, row)| row != k)).collect();
        let mut moves: Vec<f64> =
            self.barrier.bounds[..n].iter().map(|of| if of.is_equality() { 0.0 } else { 1.0 }).collect();
        for turn in 0..TURNS {
            let is_projected = turn > 0 || !held.is_empty();
            if is_projected {
                let jacobian = self.jacobian.columns(0, n).select_rows(&held);
                let free = DVector::from_iterator(n, self.gradient.iter().zip(&moves).map(|(g, moves)| g * moves));
                d = Projection::new(&jacobian, &moves).project(&free).data.into();
            }
            let slope = largest(&d);
            if slope <= LEFT * self.first_slope {
                break;
            }
            let step = if is_projected { self.parabola(problem, &d)?.0 } else { self.barrier.unit / slope };
            d.iter_mut().for_each(|d| *d *= -if step > 0.0 { step } else { self.size() / slope });
            let (met, before) = (self.meet(&d, &mut moves, &mut held), way);
            way = before.max(if met > 0.0 { met } else { largest(&d) });
            if met == 0.0 {
                break;
            }
        }
        Ok(way)
    }

    /// Fixes variables and slacks that meet a bound on a step d of the variables. Returns the largest change up to there; 0 if none meets a bound.
    fn meet(&self, d: &[f64], moves: &mut [f64], held: &mut Vec<usize>) -> f64 {
        let (n, mut most) = (d.len(), 0.0f64);
        for (i, d) in d.iter().enumerate() {
            let share = self.barrier.share(i, self.y[i], *d, self.size());
            if share < 1.0 {
                (moves[i], most) = (0.0, most.max(share * d.abs()));
            }
        }
        for (slack, k) in self.slacks(n) {
            let row = self.jacobian.row(k);
            let change = (0..n).map(|i| row[i] * d[i]).sum();
            let share = self.barrier.share(slack, self.y[slack], change, 0.0);
            if share < 1.0 && !held.contains(&k) {
                held.push(k);
                most = (0..n).filter(|&i| row[i] != 0.0).fold(most, |most, i| most.max(share * d[i].abs()));
            }
        }
        most
    }
}
