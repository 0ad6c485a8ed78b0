//! A pendulum on a rail with ends that turns up and comes to rest in the shortest time, as a scene of own formulas in minimal coordinates.

use hamiltonian_adjoint::optimize::{Free, Interval};
use hamiltonian_adjoint::{
    Cost, CostPoint, Error as MotionError, Force, ForcePoint, Grid, Inputs, KineticEnergy, Output, PotentialEnergy, Scalar,
    Scene, Scheme, Settings,
};
use nalgebra::{SVector, Vector2};

use super::problems::Posed;

const STEPS: usize = 35;
/// The angle at the end, rad.
#[expect(clippy::approx_constant, reason = "not π, but the value of the problem as it was stated")]
const ABOVE: f64 = 3.14;
/// The initial duration, s.
const DURATION: f64 = 2.0;
/// The centre of mass in the frame of the pendulum, m, and the moment of inertia about it, kg m²; its mass is 1 kg.
const CENTRE: [f64; 2] = [0.0688, -0.9542];
const INERTIA: f64 = 0.0391;

struct Pendulum;

impl KineticEnergy<2> for Pendulum {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector2<S>, v: &Vector2<S>, _b: &SVector<S, 0>) -> S {
        let (cos, sin) = (q[1].cos(), q[1].sin());
        let x = v[0] - (sin * CENTRE[0] + cos * CENTRE[1]) * v[1];
        let y = (cos * CENTRE[0] - sin * CENTRE[1]) * v[1];
        (x * x + y * y + v[1] * v[1] * INERTIA) * 0.5
    }
}

impl PotentialEnergy<2> for Pendulum {
    fn potential_energy<S: Scalar>(&self, q: &Vector2<S>, _b: &SVector<S, 0>, _t: S) -> S {
        (q[1].sin() * CENTRE[0] + q[1].cos() * CENTRE[1]) * 9.81
    }
}

struct Push;

impl Force<1, 1> for Push {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0]])
    }
}

#[derive(Clone)]
struct Place;

impl Cost<1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

/// The outline of the cart, m.
fn cart(q: &[f64]) -> Vec<[f64; 2]> {
    [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05], [-0.1, -0.05]].map(|[x, y]| [q[0] + x, y]).to_vec()
}

/// From the pivot to the centre of mass.
fn pendulum(q: &[f64]) -> Vec<[f64; 2]> {
    let (sin, cos) = q[1].sin_cos();
    vec![[q[0], 0.0], [q[0] + cos * CENTRE[0] - sin * CENTRE[1], sin * CENTRE[0] + cos * CENTRE[1]]]
}

pub fn pose() -> Result<Posed, MotionError> {
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["x", "angle"]);
    scene.kinetic_energy("T", Pendulum, q, []);
    scene.potential_energy("V", Pendulum, q, []);
    let force = scene.control("force");
    scene.force("motor", Push, [q[0]], [force], []);
    scene.time("time", 1.0);
    let ends = q.map(|coordinate| scene.end_state(coordinate));
    let at_rest = [(ends[0].position, 0.0), (ends[0].rate, 0.0), (ends[1].position, ABOVE), (ends[1].rate, 0.0)];
    let mut constraints: Vec<(Output, Interval)> = at_rest.map(|(output, x)| (output, Interval::equal(x))).to_vec();
    let places = scene.outputs_at("x", Place, 1..STEPS, [q[0]], [], [], []);
    constraints.extend(places.into_iter().map(|place| (place, Interval::new(-1.0, 5.0))));
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, DURATION / STEPS as f64));
    let free = vec![Free::control(force).within(-100.0, 100.0).scaled(50.0), Free::duration().within(0.05, 5.0)];
    let settings = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    Ok(Posed {
        system,
        settings,
        inputs,
        control: force,
        free,
        constraints,
        lines: &[("cart", cart), ("pendulum", pendulum)],
    })
}
