//! [`Pose`]: states at the end of a motion.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

use super::super::problem::Interval;
use super::super::segment::{Part, Segment};
use super::super::variables::Variables;
use super::reach::Reach;
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
/// Largest change of an angle in an iteration, rad.
const TURN: f64 = 0.5;
/// The gradient of half the sum of squares of residuals is zero below this fraction of the sum.
const LEAST: f64 = 1e-6;
/// Residuals of a state that was found, and the number of random poses from which it is sought.
const FOUND: f64 = 1e-6;
const POSES: usize = 30;

/// A state with the outputs that are terminal values: the end of the motion as a segment without steps.
pub(super) struct Pose {
    segment: Segment,
    /// For each independent coordinate, true if it is an angle.
    angles: Vec<bool>,
}

impl Pose {
    pub(super) fn new(system: &System, settings: Settings, inputs: &Inputs, states: &[Coordinate]) -> Result<Self, Error> {
        let (mut own, last) = (inputs.clone(), inputs.grid.steps.len());
        own.events.clear();
        let (nothing, end) = (Variables::new(system, &own, Vec::new())?, Part { nodes: last..last, knots: Vec::new() });
        let segment = Segment::new((system, settings), (&own, &nothing), states, end, &mut 0)?;
        let is_angle = |of: &Coordinate| system.sines().coordinates().any(|i| i == of.index());
        Ok(Pose { segment, angles: states.iter().map(is_angle).collect() })
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

    /// The state z near z₀ in which outputs lie in given intervals, or the last one that Newton's method found; and whether they do. If the
    /// method fails from z₀, as where derivatives vanish by symmetry, it starts from random poses, and the state nearest to z₀ is taken.
    pub(super) fn end(&mut self, [q0, v0]: [&DVector<f64>; 2], time: f64, asked: &[(usize, Interval)]) -> (Vec<f64>, Reach) {
        let z0 = self.guess(q0, v0);
        let from_start = self.newton(&z0, time, asked);
        if from_start.reach == Reach::Found {
            return (from_start.z, Reach::Found);
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
        let tried: Vec<End> = tried.collect();
        let distance = |end: &&End| positions().map(|i| (end.z[i] - z0[i]).powi(2)).sum::<f64>();
        let found = tried.iter().filter(|end| end.reach == Reach::Found);
        match found.min_by(|a, b| distance(a).total_cmp(&distance(b))) {
            Some(found) => (found.z.clone(), Reach::Found),
            None => {
                let reach = tried.iter().fold(from_start.reach, |least, end| least.min(end.reach));
                (from_start.z, reach)
            }
        }
    }

    /// z near another one in which outputs lie in given intervals, as nearly as Newton's method finds it. Angles change by at most [`TURN`] in an
    /// iteration, so that the method does not wind them up.
    fn newton(&mut self, from: &[f64], time: f64, asked: &[(usize, Interval)]) -> End {
        let outputs: Vec<Asked> = asked.iter().map(|(output, _)| Asked::Output(*output)).collect();
        let left = |segment: &mut Segment, z: &DVector<f64>| {
            let (_, found) = segment.try_at(z.as_slice(), time).ok()?;
            let excess = |(output, to): &(usize, Interval)| found[*output] - to.nearest(found[*output]);
            Some(DVector::from_iterator(asked.len(), asked.iter().map(excess)))
        };
        let Pose { segment, angles } = self;
        let mut z = DVector::from_column_slice(from);
        let Some(mut r) = left(segment, &z) else { return End { z: from.to_vec(), reach: Reach::Unknown } };
        let mut is_least = false;
        for _ in 0..ITERATIONS {
            segment.settle();
            let mut jacobian = DMatrix::zeros(asked.len(), z.len());
            if r.amax() < CLOSE || segment.jacobian(&outputs, &mut jacobian).is_err() {
                break;
            }
            let is_inside = |i: &usize| r[*i] == 0.0 && !asked[*i].1.is_equality();
            (0..asked.len()).filter(is_inside).for_each(|i| jacobian.fill_row(i, 0.0));
            // Along the change of each variable by 1 m, 1 rad or their rates.
            is_least = jacobian.tr_mul(&r).amax() <= LEAST * r.norm_squared();
            // There is none without a free coordinate.
            let Some(svd) = decomposition(jacobian) else { break };
            let Ok(step) = svd.solve(&r, RANK * svd.singular_values.max()) else { break };
            let turns = step.iter().step_by(2).zip(&*angles).filter(|(_, is_angle)| **is_angle);
            let longest = TURN / turns.fold(TURN, |most, (turn, _)| most.max(turn.abs()));
            let shares = (0..HALVINGS).map(|k| longest * 0.5f64.powi(k));
            let tried = shares.map(|share| &z - share * &step).find_map(|next| {
                let after = left(segment, &next)?;
                (after.norm() < r.norm()).then_some((next, after))
            });
            let Some((next, after)) = tried else { break };
            (z, r) = (next, after);
        }
        let reach = match r.amax() < FOUND {
            true => Reach::Found,
            false if is_least => Reach::Impossible,
            false => Reach::Unknown,
        };
        End { z: z.as_slice().to_vec(), reach }
    }
}

/// The end of Newton's method for the state at the end.
struct End {
    z: Vec<f64>,
    reach: Reach,
}
