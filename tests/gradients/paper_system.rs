//! The condensed sweep against the paper's full 4n + m system.

use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, Solver, Start, scenes::CartPendulum};
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

#[test]
fn inputs_that_the_motion_does_not_belong_to_are_refused() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.02));
    inputs.controls.fill(1e3);
    inputs.grid.steps[2] = 1.0;
    let mut solver = Solver::new(&system, Settings { max_iterations: 4, ..Settings::default() });
    let motion = solver.simulate(&inputs).expect("motion").clone();
    assert!(!motion.inserted.is_empty());
    let error = PaperSystem::new(&system, &inputs, &motion).expect_err("halved steps");
    assert!(matches!(error, Error::Size { found: 5, .. }), "{error:?}");
    assert!(error.to_string().contains("`Solver::inputs`"), "{error}");
    assert!(PaperSystem::new(&system, solver.inputs(), &motion).is_ok());
    let mut other = solver.inputs().clone();
    other.controls = DMatrix::zeros(2, other.controls.ncols());
    assert!(matches!(PaperSystem::new(&system, &other, &motion).err(), Some(Error::Size { .. })));
}
