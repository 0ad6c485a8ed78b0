//! [`Pose`]: states at the end of a motion.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

use super::super::segment::Segment;
use crate::number::Random;
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
/// Residuals of a state that was found, and the number of random poses from which it is sought.
const FOUND: f64 = 1e-6;
const POSES: usize = 10;

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
        let segment = Segment::new((system, settings), &own, &[], states, (last, last), &mut 0)?;
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

    /// The state z near z₀ in which outputs have given values, or the last one that Newton's method found; and whether they have them. If the
    /// method fails from z₀, as where derivatives vanish by symmetry, it starts from random poses, and the state nearest to z₀ is taken.
    pub(super) fn end(&mut self, [q0, v0]: [&DVector<f64>; 2], time: f64, ends: &[(usize, f64)]) -> (Vec<f64>, bool) {
        let z0 = self.guess(q0, v0);
        let from_start = self.newton(&z0, time, ends);
        if from_start.is_found {
            return (from_start.z, true);
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
            self.newton(&z, time, ends)
        });
        let distance = |end: &End| positions().map(|i| (end.z[i] - z0[i]).powi(2)).sum::<f64>();
        let found = tried.filter(|end| end.is_found).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let is_found = found.is_some();
        (found.unwrap_or(from_start).z, is_found)
    }

    /// z near another one in which outputs have given values, as nearly as Newton's method finds it. Angles change by at most [`TURN`] in an
    /// iteration, so that the method does not wind them up.
    fn newton(&mut self, from: &[f64], time: f64, ends: &[(usize, f64)]) -> End {
        let asked: Vec<Asked> = ends.iter().map(|(output, _)| Asked::Output(*output)).collect();
        let left = |segment: &mut Segment, z: &DVector<f64>| {
            let (_, found) = segment.try_at(z.as_slice(), time).ok()?;
            Some(DVector::from_iterator(ends.len(), ends.iter().map(|(output, value)| found[*output] - value)))
        };
        let Pose { segment, angles } = self;
        let mut z = DVector::from_column_slice(from);
        let Some(mut r) = left(segment, &z) else { return End { z: from.to_vec(), is_found: false } };
        for _ in 0..ITERATIONS {
            segment.settle();
            let mut jacobian = DMatrix::zeros(ends.len(), z.len());
            if r.amax() < CLOSE || segment.jacobian(&asked, &mut jacobian).is_err() {
                break;
            }
            let svd = jacobian.svd(true, true);
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
        End { z: z.as_slice().to_vec(), is_found: r.amax() < FOUND }
    }
}

/// The end of Newton's method for the state at the end.
struct End {
    z: Vec<f64>,
    /// True if the outputs have their values there.
    is_found: bool,
}
