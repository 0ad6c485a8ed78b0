//! [`Pose`]: states at a node of a motion.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

use super::super::problem::Interval;
use super::super::segment::{Part, Segment};
use super::super::variables::Variables;
use super::reach::Reach;
use crate::assembly::Retraction;
use crate::number::Random;
use crate::redundancy::decomposition;
use crate::solver::Asked;
use crate::{Coordinate, Error, Inputs, Settings, System};

/// Newton's method for the end ends after this many iterations, each with at most so many halvings, or at residuals below `CLOSE`.
const ITERATIONS: usize = 50;
const HALVINGS: i32 = 10;
const CLOSE: f64 = 1e-10;
/// Singular values below this fraction of the largest one are zero.
const RANK: f64 = 1e-8;
/// The first damping relative to the largest diagonal entry of JᵀJ, its changes after steps that succeed and that fail, and the largest number of steps
/// that are tried: near a least sum that is not zero, JᵀJ may be much smaller than the second derivatives.
const DAMPING: f64 = 1.0;
const DAMPINGS: usize = 30;
const LESS: f64 = 0.3;
const MORE: f64 = 4.0;
/// Largest change of a coordinate in the first iteration, m or rad, and after an iteration whose change of the residuals differs from the linear one by more
/// than a fraction of it; after others, it is twice the last change.
const SHORT: f64 = 0.5;
const LINEAR: f64 = 0.25;
/// The gradient of half the sum of squares of residuals is zero below this fraction of the sum, or if its terms cancel up to this fraction, from which on
/// steps change the sum only by rounding error.
const LEAST: f64 = 1e-6;
const CANCEL: f64 = 3e-7;
/// Residuals of a state that was found, and the number of random poses from which it is sought.
pub(super) const FOUND: f64 = 1e-6;
const POSES: usize = 30;
/// At least so many of them must be poses that can be assembled, or the search is inconclusive.
const ASSEMBLED: usize = 10;

/// A state with the outputs that it determines: a node of the motion, other than the first, as a segment without steps.
pub(super) struct Pose {
    pub(super) segment: Segment,
    pub(super) inputs: Inputs,
    /// The independent coordinates.
    pub(super) states: Vec<Coordinate>,
    node: usize,
    /// For each independent coordinate, true if it is an angle.
    angles: Vec<bool>,
}

impl Pose {
    pub(super) fn new(
        (system, settings): (&System, Settings),
        inputs: &Inputs,
        states: &[Coordinate],
        node: usize,
    ) -> Result<Self, Error> {
        let mut own = inputs.clone();
        own.events.clear();
        let (nothing, part) = (Variables::new(system, &own, Vec::new())?, Part { nodes: node..node, knots: Vec::new() });
        let segment = Segment::new((system, settings), (&own, &nothing), states, part, &mut 0)?;
        let is_angle = |of: &Coordinate| system.sines().coordinates().any(|i| i == of.index());
        Ok(Pose { segment, inputs: own, states: states.to_vec(), node, angles: states.iter().map(is_angle).collect() })
    }

    /// A pose at this node with independent coordinates that are chosen at q; `None` if they are the same.
    fn with_coordinates_at(&self, q: &DVector<f64>) -> Option<Self> {
        let solver = &self.segment.motion.solver;
        let (system, settings, mut inputs) = (solver.system(), solver.settings(), self.inputs.clone());
        inputs.start.q_mut().copy_from(q);
        let states = Retraction::choose(system, &[], &inputs);
        (states != self.states).then(|| Pose::new((system, settings), &inputs, &states, self.node).ok()).flatten()
    }

    pub(super) fn guess(&mut self, q: &DVector<f64>, v: &DVector<f64>) -> Vec<f64> {
        self.segment.guess(q, v)
    }

    /// q and v for z, near those of the last call.
    pub(super) fn at(&mut self, z: &[f64], time: f64) -> Result<[DVector<f64>; 2], Error> {
        self.segment.try_at(z, time)?;
        self.segment.settle();
        let motion = self.segment.motion.solver.trajectory();
        Ok([&motion.q, &motion.v].map(|of| of.column(0).into_owned()))
    }

    /// The last coordinates, at rest; those of the guess if there are none.
    pub(super) fn last(&mut self, guess: &DVector<f64>) -> [DVector<f64>; 2] {
        [self.segment.near().unwrap_or_else(|| guess.clone()), DVector::zeros(guess.len())]
    }

    /// The state z near a given one in which outputs lie in given intervals, or where the sum of squares of the distances from them is least; and whether
    /// they do. Where the independent coordinates are singular, as at the extreme positions of a closed loop, others are chosen.
    pub(super) fn nearest(&mut self, start: [&DVector<f64>; 2], time: f64, asked: &[(usize, Interval)]) -> End {
        let end = self.nearest_here(start, time, asked);
        if end.reach != Reach::Unknown {
            return end;
        }
        self.nearest_elsewhere(start, time, asked).unwrap_or(end)
    }

    /// As [`nearest`](Self::nearest), at rest, with independent coordinates that are chosen at the given state; `None` if the search is inconclusive, too.
    fn nearest_elsewhere(&mut self, [q0, _]: [&DVector<f64>; 2], time: f64, asked: &[(usize, Interval)]) -> Option<End> {
        let mut other = self.with_coordinates_at(q0)?;
        // Near singular coordinates, the rates of others would be large.
        let found = other.nearest_here([q0, &DVector::zeros(q0.len())], time, asked);
        let [q, v] = other.at(&found.z, time).ok()?;
        (found.reach != Reach::Unknown).then(|| End { z: self.guess(&q, &v), ..found })
    }

    /// The state z near z₀ in which outputs lie in given intervals, or the last one that Newton's method found; and whether they do. If the
    /// method fails from z₀, as where derivatives vanish by symmetry, it starts from random poses, and the state nearest to z₀ is taken. If there is
    /// none, the state where the sum of squares of the distances is least.
    fn nearest_here(&mut self, [q0, v0]: [&DVector<f64>; 2], time: f64, asked: &[(usize, Interval)]) -> End {
        let z0 = self.guess(q0, v0);
        let from_start = self.newton(&z0, time, asked);
        if from_start.reach == Reach::Found {
            return from_start;
        }
        if let Some(end) = self.carried([q0, v0], time, asked) {
            return end;
        }
        let angles = self.angles.clone();
        let positions = || (0..z0.len()).step_by(2);
        let mut random = Random::new(0);
        let poses = (0..POSES).map(|_| {
            let mut z = z0.clone();
            for (i, is_angle) in positions().zip(&angles) {
                z[i] += if *is_angle { random.uniform(-PI, PI) } else { random.uniform(-0.5, 0.5) * (1.0 + z[i].abs()) };
            }
            z
        });
        let tried = poses.map(|z| {
            self.guess(q0, v0);
            self.newton(&z, time, asked)
        });
        let distance = |end: &End| positions().map(|i| (end.z[i] - z0[i]).powi(2)).sum::<f64>();
        let assembled = tried.filter(|end| end.left.amax().is_finite());
        let (found, others): (Vec<End>, Vec<End>) = assembled.partition(|end| end.reach == Reach::Found);
        let is_unknown = |end: &End| end.reach == Reach::Unknown;
        match found.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))) {
            Some(found) => found,
            None if others.len() < ASSEMBLED || others.iter().chain([&from_start]).any(is_unknown) => {
                End { reach: Reach::Unknown, ..from_start }
            }
            None => {
                let better = |least: End, end: End| if end.left.norm() < least.left.norm() { end } else { least };
                others.into_iter().fold(from_start, better)
            }
        }
    }

    /// z near another one in which outputs lie in given intervals, or where the sum of squares of the distances from them is least, if Newton's
    /// method finds it. Coordinates change a little in an iteration unless the residuals are linear, so that the method does not wind angles up.
    pub(super) fn newton(&mut self, from: &[f64], time: f64, asked: &[(usize, Interval)]) -> End {
        let mut z = DVector::from_column_slice(from);
        let Some(r) = self.residuals(&mut z, time, asked) else {
            return End { z: from.to_vec(), left: DVector::from_element(asked.len(), f64::INFINITY), reach: Reach::Unknown };
        };
        let mut at = At { z, r, is_least: false, most: SHORT };
        for _ in 0..ITERATIONS {
            let Some(jacobian) = self.derivatives(&mut at, asked) else { break };
            // There is none without a free coordinate.
            let Some(svd) = decomposition(jacobian.clone()) else { break };
            let Ok(step) = svd.solve(&at.r, RANK * svd.singular_values.max()) else { break };
            let step = at.shortened(step);
            let tried = (0..HALVINGS).find_map(|k| self.reduced(&at, (&jacobian, &(0.5f64.powi(k) * &step)), time, asked));
            let Some(next) = tried else { break };
            at = next;
        }
        if at.r.amax() >= FOUND && !at.is_least {
            self.descend(&mut at, time, asked);
        }
        let reach = match at.r.amax() < FOUND {
            true => Reach::Found,
            false if at.is_least => Reach::Impossible,
            false => Reach::Unknown,
        };
        End { z: at.z.as_slice().to_vec(), left: at.r, reach }
    }

    /// Reduces the sum of squares by damped steps (Levenberg and Marquardt), which lead to the least one where it is not zero.
    fn descend(&mut self, at: &mut At, time: f64, asked: &[(usize, Interval)]) {
        let mut first = None;
        if self.residuals(&mut at.z, time, asked).is_none() {
            return;
        }
        for _ in 0..ITERATIONS {
            let Some(jacobian) = self.derivatives(at, asked) else { return };
            if at.is_least {
                return;
            }
            let (squares, slopes) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&at.r));
            let damping = first.get_or_insert_with(|| DAMPING * squares.diagonal().amax());
            let tried = (0..DAMPINGS).find_map(|_| {
                let damped = DMatrix::from_diagonal_element(squares.nrows(), squares.ncols(), *damping) + &squares;
                let step = at.shortened(damped.cholesky()?.solve(&slopes));
                let next = self.reduced(at, (&jacobian, &step), time, asked);
                *damping *= if next.is_some() { LESS } else { MORE };
                next
            });
            let Some(next) = tried else { return };
            *at = next;
        }
    }

    /// The distances of outputs from their intervals in the state z or, where there is none, in one near it, which replaces z; `None` without a state.
    pub(super) fn residuals(
        &mut self,
        z: &mut DVector<f64>,
        time: f64,
        asked: &[(usize, Interval)],
    ) -> Option<DVector<f64>> {
        let tried = self.segment.try_at(z.as_slice(), time);
        let (_, found) = match tried {
            Err(_) if self.segment.approach(z.as_mut_slice()) => self.segment.try_at(z.as_slice(), time),
            tried => tried,
        }
        .ok()?;
        let excess = |(output, to): &(usize, Interval)| found[*output] - to.nearest(found[*output]);
        Some(DVector::from_iterator(asked.len(), asked.iter().map(excess)))
    }

    /// The derivatives of the distances by z at the last point; `None` if all are almost zero, or without derivatives.
    fn derivatives(&mut self, at: &mut At, asked: &[(usize, Interval)]) -> Option<DMatrix<f64>> {
        self.segment.settle();
        let outputs: Vec<Asked> = asked.iter().map(|(output, _)| Asked::Output(*output)).collect();
        let mut jacobian = DMatrix::zeros(asked.len(), at.z.len());
        if at.r.amax() < CLOSE || self.segment.jacobian(&outputs, &mut jacobian).is_err() {
            return None;
        }
        let is_inside = |i: &usize| at.r[*i] == 0.0 && !asked[*i].1.is_equality();
        (0..asked.len()).filter(is_inside).for_each(|i| jacobian.fill_row(i, 0.0));
        // Along the change of each variable by 1 m, 1 rad or their rates.
        let least = LEAST * at.r.norm_squared();
        at.is_least = jacobian.column_iter().all(|column| {
            let terms = column.component_mul(&at.r);
            terms.sum().abs() <= least.max(CANCEL * terms.lp_norm(1))
        });
        Some(jacobian)
    }

    /// The point after a step back, if its distances are smaller.
    fn reduced(
        &mut self,
        at: &At,
        (jacobian, step): (&DMatrix<f64>, &DVector<f64>),
        time: f64,
        asked: &[(usize, Interval)],
    ) -> Option<At> {
        let mut z = &at.z - step;
        let near = self.segment.near()?;
        let found = self.residuals(&mut z, time, asked);
        let Some(r) = found.filter(|r| r.norm() < at.r.norm()) else {
            self.segment.seek_near(&near);
            return None;
        };
        let linear = jacobian * step;
        let is_linear = (&at.r - &r - &linear).norm() <= LINEAR * linear.norm();
        let most = if is_linear { SHORT.max(2.0 * change_of_coordinates(step)) } else { SHORT };
        Some(At { z, r, is_least: false, most })
    }
}

/// A state z with the distances r of outputs from their intervals; true if the sum of squares of r is stationary there; the largest change of a coordinate
/// in the next iteration.
struct At {
    z: DVector<f64>,
    r: DVector<f64>,
    is_least: bool,
    most: f64,
}

impl At {
    /// A step no longer than the largest change of a coordinate.
    fn shortened(&self, step: DVector<f64>) -> DVector<f64> {
        self.most / change_of_coordinates(&step).max(self.most) * step
    }
}

/// The largest change of a coordinate in a change of z.
fn change_of_coordinates(step: &DVector<f64>) -> f64 {
    step.iter().step_by(2).fold(0.0, |most, change| most.max(change.abs()))
}

/// A state, and the distances of outputs from their intervals there.
pub(super) struct End {
    pub(super) z: Vec<f64>,
    pub(super) left: DVector<f64>,
    pub(super) reach: Reach,
}
