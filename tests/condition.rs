//! Where digits are lost, the report says so: pivots by the unknown's name, and the growth of the adjoint.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Solver, System, Warning, scenes::CartPendulum};

/// A chain of two rods, the second of another mass.
fn chain(mass: f64) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let upper = scene.body("upper", 1.0, 0.1, [0.5, 0.0, 0.0]);
    let lower = scene.body("lower", mass, 0.1 * mass, [1.5, 0.0, 0.0]);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(-0.5, 0.0));
    scene.revolute("elbow", upper.at(0.5, 0.0), lower.at(-0.5, 0.0));
    scene.compile().expect("scene")
}

fn warnings(system: &System, inputs: &Inputs) -> (f64, f64, Vec<Warning>) {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs).unwrap_or_else(|error| panic!("{error}"));
    solver.gradient().unwrap_or_else(|error| panic!("{error}"));
    let warnings = [solver.report().warnings.clone(), solver.adjoint_report().warnings.clone()].concat();
    warnings.iter().for_each(|warning| println!("{warning}"));
    (solver.report().worst_pivot, solver.adjoint_report().adjoint_growth, warnings)
}

#[test]
fn lost_digits_are_told_with_the_unknown_and_the_step() {
    for (mass, expected) in [(1.0, false), (1e4, false), (1e10, true)] {
        let system = chain(mass);
        let (pivot, _, warnings) = warnings(&system, &Inputs::at_rest(&system, Grid::uniform(20, 0.01)));
        println!("mass {mass:e}: worst pivot {pivot:.1e}");
        assert_eq!(pivot < Warning::LOST_DIGITS, expected);
        match (expected, warnings.as_slice()) {
            (false, []) => (),
            (true, [Warning::LostDigits { unknown, pivot: told, .. }]) => {
                assert!(unknown.contains("shoulder") || unknown.contains("elbow"), "{unknown}");
                assert!(*told < 1e-8 && *told >= pivot);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_chaotic_motion_warns_of_the_growth_of_its_gradient() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let growth = |steps: usize| {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.01));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if i < 40 { 60.0 } else { 0.0 });
        let (_, growth, warnings) = warnings(&system, &inputs);
        println!("{steps} steps: growth {growth:.1e}");
        (growth, warnings.iter().any(|warning| matches!(warning, Warning::AdjointGrowth { .. })))
    };
    let (short, long) = (growth(100), growth(3000));
    assert!(short.0 < Warning::GROWTH && !short.1, "{short:?}");
    assert!(long.0 > Warning::GROWTH && long.1, "{long:?}");
}

#[test]
fn a_motion_that_its_steps_do_not_resolve_is_told_by_its_fastest_angle() {
    let system = chain(1.0);
    let told = |speed: f64| {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.02));
        // Both rods turn about the shoulder.
        let v = inputs.start.rate_mut();
        (v[1], v[2], v[4], v[5]) = (0.5 * speed, speed, 1.5 * speed, speed);
        let (_, _, warnings) = warnings(&system, &inputs);
        warnings.into_iter().find(|warning| matches!(warning, Warning::Unresolved { .. }))
    };
    assert_eq!(told(10.0), None);
    let Some(Warning::Unresolved { coordinate, turn, .. }) = told(100.0) else { panic!("no warning") };
    assert!(coordinate.ends_with("φ") && turn > 1.9, "{coordinate}: {turn}");
}
