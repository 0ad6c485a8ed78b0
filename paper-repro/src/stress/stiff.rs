//! Parts far stiffer than any step resolves: L-stable schemes damp their initial deviation, the trapezoidal rule never does.
//!
//! Two masses of 1 kg on a line; the first hangs on a spring k, both on each other by a spring K and a damper d. The intended motion is that of both masses as one,
//! x = cos(√(k/2) t).

use hamiltonian_adjoint::element::ForcePoint;
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Force, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Scheme, Settings, Start,
    Sum, System, simulate,
};
use nalgebra::{DVector, SVector};

use super::motion::gradient_error;
use super::row::{Measure, Trial};
use crate::statistics::largest;

const DT: f64 = 0.01;
const STEPS: usize = 100;
/// k, N/m: a period of 1.4 s.
const SOFT: f64 = 40.0;
/// The motion's largest velocity, m/s.
pub const FAST: f64 = 4.5;
/// Initial deviation between the masses, in m or m/s.
const APART: f64 = 1e-3;

pub fn trials() -> Vec<Trial> {
    let stiff = [("spring, ω = 1.4e4 rad/s", 1e8, 0.0), ("damper, rate 2e8 per s", 0.0, 1e8)];
    let pairs = stiff.into_iter().flat_map(|part| Scheme::ALL.into_iter().map(move |scheme| (part, scheme)));
    let trial = |((what, spring, damper), scheme): ((&str, f64, f64), Scheme)| {
        let name = format!("two masses on a {what}, {}, Δt = 10 ms, {STEPS} steps", scheme.name);
        Trial::new(name, move || judged(scheme, spring, damper))
    };
    pairs.map(trial).collect()
}

fn judged(scheme: Scheme, spring: f64, damper: f64) -> Result<Vec<Measure>, Error> {
    let settings = Settings { scheme, ..Settings::default() };
    let (system, inputs) = masses(spring, damper, STEPS, DT)?;
    let motion = simulate(&system, &inputs, settings)?;
    let apart = |node: usize| {
        let of = |x: &nalgebra::DMatrix<f64>| (x[(1, node)] - x[(0, node)]).abs();
        if spring > 0.0 { of(&motion.q) } else { of(&motion.v) }
    };
    let time = motion.times[STEPS];
    let mean = 0.5 * (motion.q[(0, STEPS)] + motion.q[(1, STEPS)]);
    let slow = mean - (1.0 + 0.5 * APART) * ((0.5 * SOFT).sqrt() * time).cos();
    let left = largest((STEPS - 9..=STEPS).map(apart)) / APART;
    // The damper moves the second mass, and its force requires a small relative velocity.
    let slip = if damper > 0.0 { 0.5 * SOFT / damper / APART } else { 0.0 };
    let kept = match scheme == Scheme::TRAPEZOIDAL {
        true => Measure::at_least("remaining part of the initial deviation", left, 0.9),
        false => Measure::at_most("remaining part of the initial deviation", left, 2.0 * slip + 1e-3),
    };
    // Forces of stiff parts are differences of nearly equal numbers and contain their rounding errors.
    let rounding = f64::EPSILON * (spring + FAST * damper) / SOFT;
    Ok(vec![
        kept,
        Measure::at_most("error of the slow motion [m]", slow.abs(), 2e-3),
        Measure::at_most("gradient error", gradient_error(&system, &inputs, settings, 10)?, 100.0 * rounding),
    ])
}

/// Both masses start 1 m from their rest position, with a small deviation between them.
pub fn masses(spring: f64, damper: f64, steps: usize, dt: f64) -> Result<(System, Inputs), Error> {
    let mut scene = Scene::new();
    let x = scene.coordinates("masses", ["first", "second"]);
    let force = scene.control("force");
    scene.kinetic_energy("inertia", Masses, x, []);
    scene.potential_energy("springs", Masses, x, [SOFT.into(), spring.into()]);
    scene.force("damper", Masses, x, [force], [damper.into()]);
    scene.cost("excursion", Masses, Sum::Integral, x, [], [], []);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, dt));
    let (q, v) = if spring > 0.0 { (APART, 0.0) } else { (0.0, APART) };
    inputs.start = Start::Velocity { q: DVector::from_vec(vec![1.0, 1.0 + q]), v: DVector::from_vec(vec![0.0, v]) };
    Ok((system, inputs))
}

struct Masses;

impl KineticEnergy<2> for Masses {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 2>, v: &SVector<S, 2>, _: &SVector<S, 0>) -> S {
        (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}

impl PotentialEnergy<2, 2> for Masses {
    fn potential_energy<S: Scalar>(&self, x: &SVector<S, 2>, b: &SVector<S, 2>, _: S) -> S {
        let apart = x[1] - x[0];
        (b[0] * x[0] * x[0] + b[1] * apart * apart) * 0.5
    }
}

impl Force<2, 1, 1> for Masses {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let pull = b[0] * (at.v[1] - at.v[0]);
        SVector::from([pull + at.u[0], -pull])
    }
}

impl Cost<2> for Masses {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0]
    }
}
