//! Jacobian blocks derived by hand, compared with those of the library: a pendulum in the coordinates (x, y, φ).
//!
//! `PaperSystem` contains the paper's equations f1 … f5 in y = (q̇, ṗ*, q, p*, σ) and their tangent matrices (Eq. 10), computed with dual
//! numbers. This example compares three of its blocks with hand-derived formulas; a wrong sign would be reported with its row and column.
//!
//! `cargo run --release --example hand_derived`

use std::error::Error;
use std::f64::consts::FRAC_PI_6;

use hamiltonian_adjoint::paper_system::{Equation, PaperSystem, Variable};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, simulate};
use nalgebra::{DMatrix, DMatrixView, Matrix2x3, Matrix3, Vector3};

const MASS: f64 = 1.2;
const INERTIA: f64 = 0.1;
const HALF: f64 = 0.5;

/// Φ = (x − a cos φ, y − a sin φ), a = half the length.
fn phi_q(angle: f64) -> Matrix2x3<f64> {
    Matrix2x3::new(1.0, 0.0, HALF * angle.sin(), 0.0, 1.0, -HALF * angle.cos())
}

/// [f3]_q = γ M + (Φ_qᵀ σ)_q
fn f3_q(gamma: f64, angle: f64, sigma: [f64; 2]) -> Matrix3<f64> {
    let mut f3_q = Matrix3::from_diagonal(&Vector3::new(MASS, MASS, INERTIA)) * gamma;
    f3_q[(2, 2)] += HALF * (sigma[0] * angle.cos() + sigma[1] * angle.sin());
    f3_q
}

/// [f5]_q = γ Φ_q + (Φ_q q̇)_q
fn f5_q(gamma: f64, angle: f64, omega: f64) -> Matrix2x3<f64> {
    let turning = Matrix2x3::new(0.0, 0.0, HALF * angle.cos() * omega, 0.0, 0.0, HALF * angle.sin() * omega);
    phi_q(angle) * gamma + turning
}

/// The largest error of an entry, relative to the largest entry of the block.
fn compare(name: &str, by_hand: DMatrix<f64>, library: DMatrixView<f64>) -> f64 {
    let difference = (&by_hand - library).abs();
    let (row, column) = difference.iamax_full();
    let error = difference[(row, column)] / library.amax();
    println!(
        "{name:8} worst entry ({row}, {column}): by hand {:+.15e}, library {:+.15e}, relative error {error:.1e}",
        by_hand[(row, column)],
        library[(row, column)]
    );
    error
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let start = [HALF * FRAC_PI_6.cos(), HALF * FRAC_PI_6.sin(), FRAC_PI_6];
    let rod = scene.body("rod", MASS, INERTIA, start);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-HALF, 0.0));
    let system = scene.compile()?;
    let dt = 0.01;
    let inputs = Inputs::at_rest(&system, Grid::uniform(60, dt));
    let motion = simulate(&system, &inputs, Settings::default())?;

    let node = 50;
    let (gamma, angle, omega) = (2.0 / dt, motion.q[(2, node)], motion.v[(2, node)]);
    let sigma = [motion.sigma[(0, node)], motion.sigma[(1, node)]];
    println!("node {node}: φ = {angle:.4} rad, φ̇ = {omega:.4} rad/s, σ = ({:.4}, {:.4}) N s", sigma[0], sigma[1]);

    let paper = PaperSystem::new(&system, &inputs, &motion)?;
    let tangent = paper.f_y(node);
    let dense = |rows: usize, entries: &[f64]| DMatrix::from_column_slice(rows, 3, entries);
    let errors = [
        compare(
            "Φ_q",
            dense(2, phi_q(angle).as_slice()),
            tangent.block(Equation::F3, Variable::Sigma).transpose().as_view(),
        ),
        compare("[f3]_q", dense(3, f3_q(gamma, angle, sigma).as_slice()), tangent.block(Equation::F3, Variable::Q)),
        compare("[f5]_q", dense(2, f5_q(gamma, angle, omega).as_slice()), tangent.block(Equation::F5, Variable::Q)),
    ];
    assert!(errors.iter().all(|error| *error <= 1e-13), "a block derived by hand is wrong");
    Ok(())
}
