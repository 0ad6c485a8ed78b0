//! The condensed sweep against the paper's full 4n + m system.

use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, Start, scenes::CartPendulum};
use nalgebra::DMatrix;

fn difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    (a - b).amax() / b.amax()
}

#[test]
fn the_condensed_sweep_gives_the_papers_adjoint_variables_and_gradient() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    let at_rest = nalgebra::DVector::zeros(system.n());
    inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star: at_rest };
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, Settings { keep_adjoint: true, ..Settings::default() });
    let trajectory = solver.simulate(&inputs).expect("motion").clone();
    let gradient = solver.gradient().expect("gradient").clone();
    let variables = solver.adjoint_variables().expect("kept");

    let paper = PaperSystem::new(&system, &inputs, &trajectory).expect("complete");
    for i in 0..=100 {
        assert!(paper.f(i).amax() < 1e-11, "f_{i} = {:.1e}", paper.f(i).amax());
    }
    let reference = paper.gradient().expect("regular");
    let errors = [
        ("dJ/du", difference(&gradient.controls, &reference.controls)),
        ("dJ/dq0", (gradient.start.q() - &reference.q0).amax() / reference.q0.amax()),
        ("dJ/dp*0", (gradient.start.rate() - &reference.p_star0).amax() / reference.p_star0.amax()),
        ("w", difference(&variables.w, &reference.w)),
    ];
    for (what, error) in errors {
        println!("{what}: relative difference {error:.1e}");
        assert!(error <= 1e-12, "{what}: {error:.1e}");
    }
}
