//! Motions that need steps of very different lengths.

use hamiltonian_adjoint::element::ForcePoint;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Force, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Start, Sum, System,
};
use nalgebra::{DVector, SVector};

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

/// ∫₀¹⁰ T dt, its derivatives by k and c, and q(10): DOP853 at 1e-13 and complex step.
pub const SLIDER_CRANK: [f64; 4] = [3.3366067994827757, 0.33344810612844017, -0.3637540339709487, 1.2756758486502386];

/// The slider-crank over 10 s from rest, on a grid of one step.
pub fn slider_crank() -> (System, Inputs) {
    let mut scene = Scene::new();
    let y = scene.coordinates("mechanism", ["q", "x", "p"]);
    let (k, c) = (scene.design("k", 1.0), scene.design("c", 1.0));
    scene.kinetic_energy("masses", SliderCrank, y, []);
    scene.potential_energy("spring", SliderCrank, y, [k.into()]);
    scene.force("damper", SliderCrank, y, [], [c.into()]);
    scene.constraint("closure", SliderCrank, y, []);
    scene.cost("work", SliderCrank, Sum::Integral, y, [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 10.0));
    let p = (-A).asin();
    let q = DVector::from_vec(vec![std::f64::consts::FRAC_PI_2, p.cos(), p]);
    inputs.start = Start::Velocity { q, v: DVector::zeros(3) };
    (system, inputs)
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
pub fn stick_slip() -> (System, Inputs) {
    let mut scene = Scene::new();
    let x = scene.coordinates("block", ["x"]);
    scene.kinetic_energy("mass", Block, x, []);
    scene.potential_energy("spring", Block, x, []);
    scene.force("friction", Block, x, [], []);
    scene.cost("excursion", Block, Sum::Integral, x, [], [], []);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(1, 6.0));
    (system, inputs)
}
