//! Verification of hand-derived derivatives: a slider-crank in three user-defined coordinates, with one wrong sign.
//!
//! `cargo run --release --example check_slider_crank`
//!
//! The crank turns by θ, the rod by φ, the slider moves along x. The formulas in `impl` blocks are those that a scene needs; the module
//! `by_hand` contains derivatives derived on paper, as for a code without automatic differentiation, which are to be verified.

use hamiltonian_adjoint::element::{CostPoint, ForcePoint, Sum};
use hamiltonian_adjoint::{
    Constraint, Cost, Error, Force, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Start, check,
};
use nalgebra::{DVector, Matrix2x3, Matrix3, SVector, Vector2, Vector3};

/// b = [r, l] for the closure, [J₁, m₂, J₂, m₃, r, l] for the energy, with the rod's centre in its middle.
struct SliderCrank;

impl Constraint<3, 2, 2> for SliderCrank {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, _t: S) -> SVector<S, 2> {
        let along = b[0] * q[0].cos() + b[1] * q[1].cos() - q[2];
        let across = b[0] * q[0].sin() + b[1] * q[1].sin();
        SVector::from([along, across])
    }
}

impl KineticEnergy<3, 6> for SliderCrank {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 3>, v: &SVector<S, 3>, b: &SVector<S, 6>) -> S {
        let (crank, rod) = (b[4] * v[0], b[5] * v[1] * 0.5);
        let speed = crank * crank + rod * rod + crank * rod * (q[0] - q[1]).cos() * 2.0;
        (b[0] * v[0] * v[0] + b[1] * speed + b[2] * v[1] * v[1] + b[3] * v[2] * v[2]) * 0.5
    }
}

/// A torque on the crank.
struct Motor;

impl Force<1, 1> for Motor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0]])
    }
}

/// ½ (x − x̄)² at the end, b = [x̄].
struct Place;

impl Cost<1, 0, 0, 1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        (at.q[0] - b[0]).powi(2) * 0.5
    }
}

mod by_hand {
    use super::*;

    pub fn phi_q(q: &Vector3<f64>, b: &Vector2<f64>) -> Matrix2x3<f64> {
        let ([r, l], [theta, phi]) = ([b[0], b[1]], [q[0], q[1]]);
        Matrix2x3::new(-r * theta.sin(), -l * phi.sin(), -1.0, r * theta.cos(), l * phi.cos(), 0.0)
    }

    /// (Φ_q v)_q
    pub fn phi_q_v_q(q: &Vector3<f64>, v: &Vector3<f64>, b: &Vector2<f64>) -> Matrix2x3<f64> {
        let ([r, l], [theta, phi]) = ([b[0], b[1]], [q[0], q[1]]);
        let (crank, rod) = (r * v[0], l * v[1]);
        Matrix2x3::new(-crank * theta.cos(), -rod * phi.cos(), 0.0, -crank * theta.sin(), -rod * phi.sin(), 0.0)
    }

    /// (Φ_qᵀσ)_q, with a mistake: the second term of the rod must also have a minus sign.
    pub fn phi_q_t_sigma_q(q: &Vector3<f64>, sigma: &Vector2<f64>, b: &Vector2<f64>) -> Matrix3<f64> {
        let ([r, l], [theta, phi]) = ([b[0], b[1]], [q[0], q[1]]);
        let crank = -r * (theta.cos() * sigma[0] + theta.sin() * sigma[1]);
        let rod = -l * phi.cos() * sigma[0] + l * phi.sin() * sigma[1];
        Matrix3::from_diagonal(&Vector3::new(crank, rod, 0.0))
    }

    pub fn mass(q: &Vector3<f64>, b: &SVector<f64, 6>) -> Matrix3<f64> {
        let [j1, m2, j2, m3, r, l] = (*b).into();
        let coupling = 0.5 * m2 * r * l * (q[0] - q[1]).cos();
        Matrix3::new(j1 + m2 * r * r, coupling, 0.0, coupling, j2 + 0.25 * m2 * l * l, 0.0, 0.0, 0.0, m3)
    }

    /// (M v)_q
    pub fn mass_v_q(q: &Vector3<f64>, v: &Vector3<f64>, b: &SVector<f64, 6>) -> Matrix3<f64> {
        let c = 0.5 * b[1] * b[4] * b[5] * (q[0] - q[1]).sin();
        Matrix3::new(-c * v[1], c * v[1], 0.0, -c * v[0], c * v[0], 0.0, 0.0, 0.0, 0.0)
    }

    /// T_q
    pub fn t_q(q: &Vector3<f64>, v: &Vector3<f64>, b: &SVector<f64, 6>) -> Vector3<f64> {
        let c = 0.5 * b[1] * b[4] * b[5] * (q[0] - q[1]).sin() * v[0] * v[1];
        Vector3::new(-c, c, 0.0)
    }
}

fn main() -> Result<(), Error> {
    let names = ["θ", "φ", "x"];
    let (lengths, constants) = ([0.1, 0.3], [0.002, 0.5, 0.004, 0.8, 0.1, 0.3]);

    // The energy first: all three derivatives are right.
    let energy = check::kinetic_energy(&SliderCrank, constants)
        .coordinates(names)
        .mass(|at| by_hand::mass(&at.q, &at.b))
        .mass_v_q(|at| by_hand::mass_v_q(&at.q, &at.v, &at.b))
        .t_q(|at| by_hand::t_q(&at.q, &at.v, &at.b))
        .run();
    println!("{energy}");

    // The closure: one of three derivatives is wrong; the report states which one, where, and the kind of the mistake.
    let closure = check::constraint(&SliderCrank, lengths)
        .coordinates(names)
        .equations(["along", "across"])
        .constants(["r", "l"])
        .phi_q(|at| by_hand::phi_q(&at.q, &at.b))
        .phi_q_v_q(|at| by_hand::phi_q_v_q(&at.q, &at.v, &at.b))
        .phi_q_t_sigma_q(|at| by_hand::phi_q_t_sigma_q(&at.q, &at.sigma, &at.b))
        .run();
    println!("{closure}");

    // The gradient of a scene with these elements, computed in four ways.
    let mut scene = Scene::new();
    let q = scene.coordinates("slider-crank", names);
    let torque = scene.control("torque");
    let [r, l] = [scene.design("crank length", lengths[0]), scene.design("rod length", lengths[1])];
    let [j1, m2, j2, m3, ..] = constants.map(Into::into);
    scene.kinetic_energy("bodies", SliderCrank, q, [j1, m2, j2, m3, r.into(), l.into()]);
    scene.constraint("closure", SliderCrank, q, [r.into(), l.into()]);
    scene.force("motor", Motor, [q[0]], [torque], []);
    scene.cost("place", Place, Sum::Terminal, [q[2]], [], [], [0.35.into()]);
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.005));
    let (theta, r, l) = (1.0f64, lengths[0], lengths[1]);
    let phi = (-r * theta.sin() / l).asin();
    let start = DVector::from_row_slice(&[theta, phi, r * theta.cos() + l * phi.cos()]);
    inputs.start = Start::Velocity { q: start, v: DVector::zeros(3) };
    inputs.controls.fill(0.05);
    println!("{}", check::gradient(&system, &inputs, Settings::default()).run()?);
    Ok(())
}
