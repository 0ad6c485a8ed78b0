//! Motions that need steps of very different lengths.

use hamiltonian_adjoint::element::ForcePoint;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Error, Force, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Scheme,
    Settings, Solver, Start, Sum, System, Trajectory, simulate,
};
use nalgebra::{DMatrix, DVector, SVector};

/// The crank's angle q, the slider's place x, the rod's angle p: an example of SUNDIALS (idasSlCrank_FSA_dns), written anew.
///
/// M = diag(1, 1, 2); b = \[k, c\] of a spring and damper between the centres of crank and rod; a = ½.
pub struct SliderCrank;

const A: f64 = 0.5;

/// The length of the spring squared, and l ∂l/∂(q, x, p).
fn spring<S: Scalar>(y: &SVector<S, 3>) -> (S, SVector<S, 3>) {
    let (q, x, p) = (y[0], y[1], y[2]);
    let squared = x * x - x * (p.cos() + q.cos() * A) + (p - q).cos() * (0.5 * A) + 0.25 * (1.0 + A * A);
    let turned = (p - q).sin();
    let gradient = [
        (turned * 0.5 + x * q.sin()) * (0.5 * A),
        x - (p.cos() + q.cos() * A) * 0.5,
        (x * p.sin() - turned * (0.5 * A)) * 0.5,
    ];
    (squared, SVector::from(gradient))
}

impl KineticEnergy<3> for SliderCrank {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 3>, v: &SVector<S, 3>, _: &SVector<S, 0>) -> S {
        (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] * 2.0) * 0.5
    }
}

impl PotentialEnergy<3, 1> for SliderCrank {
    fn potential_energy<S: Scalar>(&self, y: &SVector<S, 3>, b: &SVector<S, 1>, _: S) -> S {
        let stretch = spring(y).0.sqrt() - 1.0;
        // And a constant force 1 on the rod.
        b[0] * stretch * stretch * 0.5 - (y[1] + y[2].cos())
    }
}

impl Force<3, 0, 1> for SliderCrank {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 0>, b: &SVector<S, 1>) -> SVector<S, 3> {
        let (squared, gradient) = spring(&at.q);
        let rate = gradient[0] * at.v[0] + gradient[1] * at.v[1] + gradient[2] * at.v[2];
        gradient.map(|l| -(b[0] * rate * l / squared))
    }
}

impl Constraint<3, 2> for SliderCrank {
    fn phi<S: Scalar>(&self, y: &SVector<S, 3>, _: &SVector<S, 0>, _: S) -> SVector<S, 2> {
        let (q, x, p) = (y[0], y[1], y[2]);
        SVector::from([x - p.cos() - q.cos() * A, -p.sin() - q.sin() * A])
    }
}

impl Cost<3> for SliderCrank {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _: &SVector<S, 0>) -> S {
        self.kinetic_energy(&at.q, &at.v, &SVector::zeros())
    }
}

/// The slider-crank over 10 s from rest, on a grid of one step.
pub fn slider_crank() -> Result<(System, Inputs), Error> {
    let mut scene = Scene::new();
    let y = scene.coordinates("mechanism", ["q", "x", "p"]);
    let (k, c) = (scene.design("k", 1.0), scene.design("c", 1.0));
    scene.kinetic_energy("masses", SliderCrank, y, []);
    scene.potential_energy("spring", SliderCrank, y, [k.into()]);
    scene.force("damper", SliderCrank, y, [], [c.into()]);
    scene.constraint("closure", SliderCrank, y, []);
    scene.cost("work", SliderCrank, Sum::Integral, y, [], [], []);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 10.0));
    let p = (-A).asin();
    let q = DVector::from_vec(vec![std::f64::consts::FRAC_PI_2, p.cos(), p]);
    inputs.start = Start::Velocity { q, v: DVector::zeros(3) };
    Ok((system, inputs))
}

/// A block on a belt: ½ m v², ½ k x², and friction that is weaker for a sliding block, smoothed over v_s.
pub struct Block;

impl KineticEnergy<1> for Block {
    fn kinetic_energy<S: Scalar>(&self, _: &SVector<S, 1>, v: &SVector<S, 1>, _: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

impl PotentialEnergy<1> for Block {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _: &SVector<S, 0>, _: S) -> S {
        q[0] * q[0] * 5.0
    }
}

impl Force<1> for Block {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _: &SVector<S, 0>) -> SVector<S, 1> {
        let sliding = at.v[0] - 0.5;
        let weakened = (sliding * sliding * 25.0 + 1.0).recip() + 1.0;
        SVector::from([-((sliding * 100.0).tanh() * weakened)])
    }
}

impl Cost<1> for Block {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0]
    }
}

/// Three periods of sticking and slipping.
pub fn stick_slip() -> Result<(System, Inputs), Error> {
    let mut scene = Scene::new();
    let x = scene.coordinates("block", ["x"]);
    scene.kinetic_energy("mass", Block, x, []);
    scene.potential_energy("spring", Block, x, []);
    scene.force("friction", Block, x, [], []);
    scene.cost("excursion", Block, Sum::Integral, x, [], [], []);
    let system = scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(1, 6.0));
    Ok((system, inputs))
}

/// The same motion on a uniform grid, with the controls of the start.
pub fn uniform(inputs: &Inputs, steps: usize) -> Inputs {
    let end: f64 = inputs.grid.steps.iter().sum();
    let controls = DMatrix::from_fn(inputs.controls.nrows(), steps + 1, |channel, _| inputs.controls[(channel, 0)]);
    Inputs { grid: Grid::uniform(steps, end / steps as f64), controls, ..inputs.clone() }
}

/// A motion that is as good as exact, for every time.
pub struct Exact(Trajectory);

impl Exact {
    pub fn new(system: &System, inputs: &Inputs) -> Result<Self, Error> {
        let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
        Ok(Exact(simulate(system, &uniform(inputs, 15_000), settings)?))
    }

    /// The largest error of the coordinates at all nodes, absolute or relative, against cubic interpolation.
    pub fn error(&self, motion: &Trajectory) -> f64 {
        let (times, dt) = (&self.0.times, self.0.times[1] - self.0.times[0]);
        let of_node = |k: usize| {
            let node = (((motion.times[k] - times[0]) / dt) as usize).min(times.len() - 2);
            let s = (motion.times[k] - times[node]) / dt;
            let exact = |i: usize| {
                let [q, v] = [&self.0.q, &self.0.v].map(|x| [x[(i, node)], x[(i, node + 1)]]);
                let rise = q[1] - q[0];
                let (begin, end) = (dt * v[0] - rise, rise - dt * v[1]);
                q[0] + s * rise + s * (1.0 - s) * ((1.0 - s) * begin + s * end)
            };
            (0..motion.q.nrows()).map(|i| (motion.q[(i, k)] - exact(i)).abs() / exact(i).abs().max(1.0)).fold(0.0, f64::max)
        };
        (0..motion.computed).map(of_node).fold(0.0, f64::max)
    }

    /// The fewest steps of a uniform grid that are as good, to a tenth.
    pub fn steps_of_uniform(&self, solver: &mut Solver, inputs: &Inputs, wanted: f64) -> usize {
        let mut steps = 8.0f64;
        // From here on all finer grids are as good.
        let mut good = None;
        while steps < 1.2e4 && good.is_none_or(|first| steps < 2.0 * first as f64) {
            let is_good = solver.simulate(&uniform(inputs, steps as usize)).is_ok_and(|motion| self.error(motion) <= wanted);
            good = if is_good { good.or(Some(steps as usize)) } else { None };
            steps *= 1.1;
        }
        good.unwrap_or(steps as usize)
    }
}
