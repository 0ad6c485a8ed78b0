//! Trees of bodies.

use hamiltonian_adjoint::planar;
use hamiltonian_adjoint::spatial::{Body, Inertia, Quantity, Revolute};
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Grid, Inputs, Mechanics, Scalar, Scene, Settings, Solver, Sum, System, check,
};
use nalgebra::SVector;

use crate::common::assert_gradient_is_exact_with;

/// sin q₀ + ½ v₀².
struct Swing;

impl Cost<1, 0, 0, 0> for Swing {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.v[0] * at.v[0] * 0.5
    }
}

/// An arm of boxes whose hinges turn about y and x in turn.
fn arm(joints: usize) -> Result<System, Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let mut outer = Body::GROUND.origin();
    let mut hinges: Vec<Revolute> = Vec::new();
    for k in 0..joints {
        let axis = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.2, 0.9]][k % 3];
        let tensor = [0.02, 0.03, 0.015, 0.001, -0.002, 0.0015];
        let link =
            space.body(&format!("link {k}"), Inertia::new(1.0 + 0.1 * k as f64, tensor).centred_at([0.01, 0.02, -0.15]));
        hinges.push(space.revolute(&format!("hinge {k}"), outer.along(axis), link.origin().along(axis)));
        outer = link.at([0.0, 0.01, -0.3]);
    }
    hinges.iter().enumerate().for_each(|(k, hinge)| scene.place(hinge.angle, 0.3 - 0.1 * k as f64));
    let last = hinges[joints - 1].angle;
    scene.cost("swing", Swing, Sum::Terminal, [last], [], [], []);
    scene.compile()
}

#[test]
fn gravity_in_the_plane_keeps_that_along_z() -> Result<(), Error> {
    let mut scene = Scene::new();
    let ball = scene.spatial().body("ball", Inertia::sphere(2.0, 0.1));
    let mut space = scene.spatial();
    space.planar("table", Body::GROUND.origin().along([0.0, 1.0, 0.0]), ball.origin().along([0.0, 1.0, 0.0]));
    space.gravity([1.0, 0.0, -9.81]);
    scene.gravity(3.0, 0.5);
    let system = scene.compile()?;
    let here = Mechanics::new(&system, &[0.0; 3], &[0.0; 3])?;
    let found = SVector::from(here.marker(ball.origin())?.acceleration);
    assert!((found - SVector::from([3.0, 0.0, -9.81])).amax() < 1e-14, "{found}");
    Ok(())
}

#[test]
fn a_tree_of_parallel_hinges_moves_like_planar_bodies() -> Result<(), Error> {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity([0.0, -9.81, 0.0]);
    let [first, second] = ["first", "second"].map(|name| space.body(name, Inertia::principal(1.2, [0.3, 0.4, 0.1])));
    let a = space.revolute("a", Body::GROUND.origin(), first.at([-0.5, 0.0, 0.2]));
    let b = space.revolute("b", first.at([0.5, 0.0, 0.0]), second.at([-0.4, 0.1, 0.0]));
    scene.place(a.angle, 0.3);
    scene.place(b.angle, 0.5);
    let system = scene.compile()?;
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let bodies = ["first", "second"].map(|name| scene.body(name, 1.2, 0.1, [0.0; 3]));
    scene.revolute("a", planar::Body::GROUND.at(0.0, 0.0), bodies[0].at(-0.5, 0.0));
    scene.revolute("b", bodies[0].at(0.5, 0.0), bodies[1].at(-0.4, 0.1));
    let plane = scene.compile()?;
    let mut inputs = Inputs::at_rest(&plane, Grid::uniform(100, 0.005));
    let (p, r) = ((0.3f64).sin_cos(), (0.8f64).sin_cos());
    let centre = [0.5 * p.1, 0.5 * p.0];
    let outer = [p.1 + 0.4 * r.1 + 0.1 * r.0, p.0 + 0.4 * r.0 - 0.1 * r.1];
    inputs.start.q_mut().copy_from_slice(&[centre[0], centre[1], 0.3, outer[0], outer[1], 0.8]);
    let (here, there) = (Inputs::at_rest(&system, Grid::uniform(100, 0.005)), inputs);
    let own = Mechanics::at_start(&system, &here)?.accelerations()?.0;
    let other = Mechanics::at_start(&plane, &there)?.accelerations()?.0;
    assert!((own[0] - other[2]).abs() < 1e-12 && (own[0] + own[1] - other[5]).abs() < 1e-12, "{own} {other}");
    Ok(())
}

#[test]
fn gradients_are_exact() -> Result<(), Error> {
    for joints in [1, 3, 7] {
        let system = arm(joints)?;
        let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
        assert_gradient_is_exact_with(&format!("{joints} joints"), &system, &inputs, Settings::default());
        let mut solver = Solver::new(&system, Settings::default());
        let start = std::time::Instant::now();
        solver.simulate(&Inputs::at_rest(&system, Grid::uniform(2000, 1e-4)))?;
        solver.gradient()?;
        println!("{joints}: {:?} us a step", start.elapsed().as_secs_f64() / 2000.0 * 1e6);
        let start = std::time::Instant::now();
        arm(joints)?;
        println!("{joints}: compiled in {:?}", start.elapsed());
    }
    Ok(())
}

/// Where e = (1, 0, 0, 0), the inertia of e₀ is zero except for rounding, and says nothing of the size of its changes.
#[test]
fn the_check_accepts_gradients_of_bodies_that_fall_freely() -> Result<(), Error> {
    for offset in [0.0, 0.2] {
        let mut scene = Scene::new();
        let mut space = scene.spatial();
        space.gravity([0.0, 0.0, -9.81]);
        let inertia = Inertia::cuboid(1.2, [0.4, 0.2, 0.1]);
        let [base, arm] = ["base", "arm"].map(|name| space.body(name, inertia.centred_at([offset, 0.0, 0.0])));
        let free = space.free("free", Body::GROUND.origin(), base.origin());
        space.revolute("hinge", base.origin().along([0.0, 1.0, 0.0]), arm.origin().along([0.0, 1.0, 0.0]));
        let tip = space.outputs("tip", Quantity::Position, arm.at([0.2, 0.0, 0.0]), Sum::Terminal);
        scene.place(free.position[2], 1.0);
        let system = scene.compile()?;
        let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
        for output in tip {
            let report = check::gradient(&system, &inputs, Settings::default()).output(output).run()?;
            assert!(report.passed(), "{report}");
        }
    }
    Ok(())
}
