//! Lengths and pivots of a crank and rocker for which a point of the coupler follows a closed path: a user-defined problem, differentiated with
//! hyper-dual numbers.

use std::f64::consts::{PI, TAU};

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{
    Interval, Options as MethodOptions, Outcome, Problem, interior_point, lowest, multi_start, silent,
};
use hamiltonian_adjoint::{Error as MotionError, Hyper, Real, Scalar};

/// Points of the path, an ellipse with half axes of 0.3 m and 0.15 m, turned by 20°.
const POINTS: usize = 10;
/// a, b, c, d; x, y and γ of the ground link; the coordinates of the point in the coupler; then the angles θ of the crank and ψ of the coupler.
const LENGTHS: usize = 9;
/// Minimum differences between the sums of Grashof's condition, m, and between angles of the crank, rad.
const ROOM: f64 = 0.01;
const LEAST_TURN: f64 = 0.1;

fn target(k: usize) -> [f64; 2] {
    let (sin, cos) = (TAU * k as f64 / POINTS as f64).sin_cos();
    let (tilt_sin, tilt_cos) = (PI / 9.0).sin_cos();
    let (along, across) = (0.3 * cos, 0.15 * sin);
    [0.5 + along * tilt_cos - across * tilt_sin, 0.6 + along * tilt_sin + across * tilt_cos]
}

/// The mean square of the distances from the path, followed by the constraints.
fn formulas<S: Scalar>(x: &[S]) -> Vec<S> {
    let [a, b, c, d, left, low, gamma, u, v] = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| x[i]);
    let foot = [left + d * gamma.cos(), low + d * gamma.sin()];
    let (mut sum, mut closure, mut transmission, mut turns) = (S::zero(), Vec::new(), Vec::new(), Vec::new());
    for k in 0..POINTS {
        let (theta, psi) = (x[LENGTHS + k], x[LENGTHS + POINTS + k]);
        let (cos, sin) = (psi.cos(), psi.sin());
        let joint = [left + a * theta.cos(), low + a * theta.sin()];
        let rocker = [joint[0] + b * cos - foot[0], joint[1] + b * sin - foot[1]];
        closure.push(rocker[0] * rocker[0] + rocker[1] * rocker[1] - c * c);
        // sin μ of the angle between coupler and rocker.
        transmission.push((cos * rocker[1] - sin * rocker[0]) / c);
        let [px, py] = target(k);
        let (ex, ey) = (joint[0] + u * cos - v * sin - px, joint[1] + u * sin + v * cos - py);
        sum += (ex * ex + ey * ey) * (1.0 / POINTS as f64);
        let next = if k + 1 < POINTS { x[LENGTHS + k + 1] } else { x[LENGTHS] + TAU };
        turns.push(next - theta);
    }
    let grashof = vec![b + c - a - d, c + d - a - b, b + d - a - c];
    [vec![sum], closure, transmission, turns, grashof].concat()
}

/// The problem and the point of its last evaluation.
struct FourBar {
    x: Vec<f64>,
    weights: Vec<f64>,
}

impl FourBar {
    /// The formulas with ε₁ along variable i and ε₂ along a direction.
    fn along(&self, i: usize, direction: Option<&[f64]>) -> Vec<Hyper> {
        let number = |(j, x): (usize, &f64)| {
            let mut number = Hyper::from(*x);
            number.add_to_part(1, if i == j { 1.0 } else { 0.0 });
            number.add_to_part(2, direction.map_or(0.0, |direction| direction[j]));
            number
        };
        formulas(&self.x.iter().enumerate().map(number).collect::<Vec<Hyper>>())
    }

    fn sum(&self, part: usize, values: &[Hyper]) -> f64 {
        self.weights.iter().zip(values).map(|(w, x)| w * x.part(part)).sum()
    }
}

impl Problem for FourBar {
    fn variables(&self) -> usize {
        LENGTHS + 2 * POINTS
    }

    fn bounds(&self) -> Vec<Interval> {
        let mut bounds = vec![Interval::FREE; self.variables()];
        bounds[..4].fill(Interval::new(0.05, 2.0));
        bounds[4..6].fill(Interval::new(-1.0, 2.0));
        bounds[7..9].fill(Interval::new(-2.0, 2.0));
        bounds
    }

    fn constraints(&self) -> Vec<Interval> {
        let closure = vec![Interval::ZERO; POINTS];
        // The angle lies between 30° and 150°, always on the same side.
        let transmission = vec![Interval::at_least(0.5); POINTS];
        let turns = vec![Interval::at_least(LEAST_TURN); POINTS];
        [closure, transmission, turns, vec![Interval::at_least(ROOM); 3]].concat()
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, MotionError> {
        self.x = x.to_vec();
        let values = formulas(x);
        c.copy_from_slice(&values[1..]);
        Ok(values[0])
    }

    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), MotionError> {
        self.weights = [&[f], c].concat();
        gradient.iter_mut().enumerate().for_each(|(i, g)| *g = self.sum(1, &self.along(i, None)));
        Ok(())
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), MotionError> {
        let values = self.along(usize::MAX, Some(direction));
        change.iter_mut().zip(&values[1..]).for_each(|(change, value)| *change = value.part(2));
        Ok(())
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), MotionError> {
        product.iter_mut().enumerate().for_each(|(i, x)| *x = self.sum(3, &self.along(i, Some(direction))));
        Ok(())
    }
}

/// Result of random starts: the lowest outcome, the number of starts within 1 % of it, and the number that converged.
pub struct Synthesis {
    pub best: Outcome,
    pub alike: usize,
    pub converged: usize,
}

pub fn synthesise(starts: usize) -> Option<Synthesis> {
    let mut random = Random::new(3);
    let mut start = || {
        let [a, b, c, d] = [[0.1, 0.4], [0.4, 1.0], [0.4, 1.0], [0.4, 1.0]].map(|[low, high]| random.uniform(low, high));
        let mut x = vec![a, b, c, d, random.uniform(-0.5, 1.0), random.uniform(-0.5, 1.0)];
        x.extend([random.uniform(-PI, PI), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)]);
        let begin = random.uniform(-PI, PI);
        x.extend((0..POINTS).map(|k| begin + TAU * k as f64 / POINTS as f64));
        x.extend((0..POINTS).map(|_| random.uniform(-PI, PI)));
        x
    };
    let starts: Vec<Vec<f64>> = (0..starts).map(|_| start()).collect();
    let options = MethodOptions { stationarity: 1e-6, iterations: 500, ..MethodOptions::default() };
    let problem = || Ok(FourBar { x: Vec::new(), weights: Vec::new() });
    let all = multi_start(&starts, problem, |problem, start| interior_point(problem, start, &options, &mut silent));
    let best = lowest(&all, 1e-8)?.clone();
    let good = || all.iter().flatten().filter(|outcome| outcome.violation <= 1e-8);
    let alike = good().filter(|outcome| outcome.value <= 1.01 * best.value).count();
    Some(Synthesis { alike, converged: good().filter(|outcome| outcome.reason.is_converged()).count(), best })
}
