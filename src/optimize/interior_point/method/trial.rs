//! [`Trial`]: the point to which a step leads, judged by φ = f + barrier + ν ‖C‖.
//!
//! Slacks do not enter the simulation: they are set to the minimum of φ for the computed constraints. Further least changes correct for the curvature
//! of the constraints, as long as each of them halves the violation; otherwise steps along a curved manifold would have to be short.

use nalgebra::DVector;

use super::super::super::barrier::TO_BOUND;
use super::super::super::counted::Counted;
use super::super::super::projection::Projection;
use super::super::super::trust_region::{CORRECTIONS, Linearised, Region, Step, TAKEN_BACK};
use super::Method;

/// Largest number of times that slacks are moved; they are not moved again if ‖C‖ changed by at most the fraction `SETTLED`.
const MOVES: usize = 10;
const SETTLED: f64 = 0.1;

/// The point to which a step led.
pub(super) struct Trial {
    pub(super) y: DVector<f64>,
    pub(super) value: f64,
    pub(super) c: DVector<f64>,
}

impl Method {
    pub(super) fn merit(&self, value: f64, y: &DVector<f64>, c: &DVector<f64>) -> f64 {
        value + self.barrier.value(y.as_slice()) + self.region.penalty * c.norm()
    }

    /// The trial of a step or, if it is better, of the step corrected for the curvature of the constraints; and the decrease of φ relative to the
    /// prediction.
    pub(super) fn better_trial(
        &self,
        problem: &mut Counted,
        step: &Step,
        projection: &Projection,
        scales: &DVector<f64>,
        (here, foreseen): (f64, f64),
    ) -> (Trial, f64) {
        let mut best = self.try_step(problem, &step.p, scales);
        let mut ratio = self.ratio(&best, here, foreseen);
        let (mut p, mut c, n) = (step.p.clone(), best.c.clone(), problem.bounds.len());
        for _ in 0..CORRECTIONS {
            if Region::accepts(ratio) || !best.value.is_finite() || self.rows.is_empty() {
                break;
            }
            p += projection.least_change(&c);
            // Slacks are set to their values afterwards.
            let mut d = p.component_mul(scales);
            d.rows_mut(n, p.len() - n).fill(0.0);
            if self.barrier.most(TO_BOUND, self.y.as_slice(), &vec![0.0; d.len()], d.as_slice()) < 1.0 {
                break;
            }
            let other = self.try_step(problem, &p, scales);
            let (of_other, left) = (self.ratio(&other, here, foreseen), other.c.norm() / c.norm());
            c.copy_from(&other.c);
            if of_other > ratio {
                (best, ratio) = (other, of_other);
            }
            if left.is_nan() || left > TAKEN_BACK {
                break;
            }
        }
        (best, ratio)
    }

    fn try_step(&self, problem: &mut Counted, p: &DVector<f64>, scales: &DVector<f64>) -> Trial {
        let mut y = &self.y + p.component_mul(scales);
        self.barrier.keep_inside(self.y.as_slice(), y.as_mut_slice());
        let value = problem.evaluate(&y.as_slice()[..problem.bounds.len()]);
        let c = if value.is_finite() { self.settle(problem, &mut y) } else { self.constraints(problem, &y) };
        Trial { c, y, value }
    }

    /// Moves each slack to the minimum of −μ ln(its distances) + ν (c − s)²/2N with the previous N = ‖C‖, which decreases φ for any N, until N no
    /// longer changes. Returns C.
    fn settle(&self, problem: &Counted, y: &mut DVector<f64>) -> DVector<f64> {
        let mut c = self.constraints(problem, y);
        for _ in 0..MOVES {
            let before = c.norm();
            let weight = self.barrier.mu * before / self.region.penalty;
            if weight == 0.0 {
                break;
            }
            for (i, &j) in (problem.bounds.len()..).zip(&self.inequalities) {
                if self.scales[i] > 0.0 {
                    y[i] = self.barrier.settled(i, problem.c[j], weight).unwrap_or(y[i]);
                }
            }
            c = self.constraints(problem, y);
            if (c.norm() - before).abs() <= SETTLED * before {
                break;
            }
        }
        c
    }

    /// The decrease of φ relative to the prediction.
    fn ratio(&self, to: &Trial, here: f64, foreseen: f64) -> f64 {
        Region::ratio(here, self.merit(to.value, &to.y, &to.c), foreseen)
    }
}
