//! The paper's example: numbers against reference values in 128-bit floats (`tests/data/README.md`), and what its Fig. 4 shows.

use crate::common::{assert_same_derivatives, largest, numbers, relative_error};
use hamiltonian_adjoint::check::{Input, complex_step, tangent};
use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, System, gradient, scenes::CartPendulum};

fn pushed_by_10_newton(links: usize, dt: f64) -> (System, Inputs) {
    let system = CartPendulum::with_links(links).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, dt));
    inputs.controls.fill(10.0);
    (system, inputs)
}

fn assert_reference_is_met(file: &str, links: usize, dt: f64) {
    let (system, inputs) = pushed_by_10_newton(links, dt);
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("motion").clone();
    let gradient = solver.gradient().expect("gradient");
    let last = |matrix: &nalgebra::DMatrix<f64>| matrix.column(100).as_slice().to_vec();
    let errors = [
        ("J", relative_error(&[gradient.value], &numbers(file, "J"))),
        ("dJ/du", relative_error(gradient.controls.as_slice(), &numbers(file, "grad"))),
        ("q", relative_error(&last(&motion.q), &numbers(file, "q_final"))),
        ("p*", relative_error(&last(&motion.p_star), &numbers(file, "p_final"))),
        ("σ", relative_error(&last(&motion.sigma), &numbers(file, "sigma_final"))),
    ];
    for (what, error) in errors {
        println!("{links} links: relative error of {what} {error:.1e}");
        assert!(error <= 1e-12, "{what}: {error:.1e}");
    }
}

#[test]
fn three_links_agree_with_the_128_bit_reference() {
    assert_reference_is_met(include_str!("../data/truth_k3_cr0_const10.json"), 3, 0.02);
}

#[test]
fn ten_links_agree_with_the_128_bit_reference() {
    assert_reference_is_met(include_str!("../data/truth_k10_cr0_const10.json"), 10, 0.01);
}

#[test]
fn velocity_constraints_hold_to_rounding_and_position_constraints_drift_as_in_figure_4() {
    let (system, inputs) = pushed_by_10_newton(3, 0.02);
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("motion");
    let rate = largest(motion.phi_dot(&system, &inputs).expect("motion").as_slice());
    assert!(rate <= 1e-12, "{rate:.1e} m/s");

    // The largest violation of each node; the paper: "generally between 1e-5 and 1e-4".
    let phi = motion.phi(&system, &inputs).expect("motion");
    let mut drift: Vec<f64> = phi.column_iter().map(|phi| largest(phi.as_slice())).collect();
    drift.sort_by(f64::total_cmp);
    let (median, most) = (drift[drift.len() / 2], drift[drift.len() - 1]);
    println!("dΦ/dt {rate:.1e} m/s, Φ at most {most:.3e} m, median {median:.3e} m");
    assert!((2e-4..4e-4).contains(&most), "{most:.2e} m");
    assert!((0.7e-4..1.5e-4).contains(&median), "{median:.2e} m");
}

#[test]
fn every_derivative_agrees_with_complex_step_and_with_tangents() {
    let (system, inputs) = pushed_by_10_newton(3, 0.02);
    let settings = Settings::default();
    let gradient = gradient(&system, &inputs, settings).expect("gradient");
    let all = Input::all(&inputs);
    let adjoint: Vec<f64> = all.iter().map(|input| input.in_gradient(&gradient)).collect();
    let complex = complex_step(&system, &inputs, settings, &all).expect("complex step");
    let dual = tangent(&system, &inputs, settings, &all).expect("tangents");
    assert_same_derivatives("adjoint and complex step", &all, &adjoint, &complex);
    assert_same_derivatives("adjoint and tangents", &all, &adjoint, &dual);
}
