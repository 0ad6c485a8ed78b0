//! The order of convergence of motion, cost and gradient, on equal, graded and composed grids.

use crate::common::{assert_order, largest_difference, numbers};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Gradient, Grid, Inputs, Scene, Settings, Sum, System, Trajectory, gradient, scenes::AngleError, scenes::CartPendulum,
    simulate,
};
use std::f64::consts::FRAC_PI_2;

const END: f64 = 2.0;

/// The paper's motion on a grid: a constant force of 10 N.
fn pushed(system: &System, grid: Grid) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.controls.fill(10.0);
    inputs
}

fn motion(system: &System, grid: Grid) -> Trajectory {
    simulate(system, &pushed(system, grid), Settings::default()).expect("motion")
}

fn derivatives(system: &System, grid: Grid) -> Gradient {
    gradient(system, &pushed(system, grid), Settings::default()).expect("gradient")
}

fn equal(steps: usize) -> Grid {
    Grid::uniform(steps, END / steps as f64)
}

/// Nodes at t(s) = T (s + 0.6 sin(2π s)/(2π)): steps between 0.4 and 1.6 times the mean.
fn graded(steps: usize) -> Grid {
    let time = |i: usize| {
        let s = i as f64 / steps as f64;
        END * (s + 0.6 * (std::f64::consts::TAU * s).sin() / std::f64::consts::TAU)
    };
    Grid::new(0.0, (0..steps).map(|i| time(i + 1) - time(i)).collect())
}

/// Suzuki's composition of fourth order: five steps for one, of which the third goes back in time.
fn suzuki(steps: usize) -> Grid {
    let p = 1.0 / (4.0 - 4.0f64.cbrt());
    let one = [p, p, 1.0 - 4.0 * p, p, p].map(|part| part * END / steps as f64);
    Grid::new(0.0, (0..steps).flat_map(|_| one).collect())
}

/// x of the cart and the angles of three links at the end.
fn end(motion: &Trajectory) -> [f64; 4] {
    [0, 5, 8, 11].map(|i| motion.q[(i, motion.q.ncols() - 1)])
}

/// The reference for one of the three joints with friction: x, φ₁, φ₂, φ₃ and J.
fn reference(friction_joint: usize) -> (Vec<f64>, f64) {
    let file = include_str!("../data/converged_t2_const10.json");
    let part = file.split("\"cr_joint\"").nth(friction_joint + 1).expect("joint");
    let q = [numbers(part, "x"), numbers(part, "phi")].concat();
    (q, numbers(part, "J")[0])
}

fn cart(friction_joint: usize) -> System {
    CartPendulum { friction_joint, ..CartPendulum::default() }.scene().compile().expect("scene")
}

#[test]
fn coordinates_and_cost_converge_with_order_two_for_each_place_of_the_friction() {
    for joint in 0..3 {
        let (system, (q, j)) = (cart(joint), reference(joint));
        let errors = [100, 200, 400, 800, 1600].map(|steps| {
            let motion = motion(&system, equal(steps));
            let cost = motion.cost(&system, &pushed(&system, equal(steps))).expect("cost");
            (largest_difference(&end(&motion), &q), (cost - j).abs())
        });
        assert_order(&format!("q, friction in joint {joint}"), &errors.map(|e| e.0), 2.0, 0.05);
        assert_order(&format!("J, friction in joint {joint}"), &errors.map(|e| e.1), 2.0, 0.05);
    }
}

#[test]
fn momenta_and_multipliers_converge_with_order_two() {
    let system = cart(0);
    let last = |motion: &Trajectory| {
        let i = motion.q.ncols() - 1;
        (motion.p_star.column(i).as_slice().to_vec(), motion.sigma.column(i).as_slice().to_vec())
    };
    let (p_star, sigma) = last(&motion(&system, suzuki(800)));
    let errors = [100, 200, 400, 800, 1600].map(|steps| {
        let (p, s) = last(&motion(&system, equal(steps)));
        (largest_difference(&p, &p_star), largest_difference(&s, &sigma))
    });
    assert_order("p*", &errors.map(|e| e.0), 2.0, 0.05);
    assert_order("σ", &errors.map(|e| e.1), 2.0, 0.05);
}

#[test]
fn a_graded_grid_keeps_order_two() {
    let (system, (q, _)) = (cart(0), reference(0));
    let errors = [100, 200, 400, 800].map(|steps| largest_difference(&end(&motion(&system, graded(steps))), &q));
    assert_order("q on a graded grid", &errors, 2.0, 0.05);
}

#[test]
fn suzukis_composition_has_order_four() {
    let (system, (q, _)) = (cart(0), reference(0));
    let errors = [25, 50, 100, 200].map(|steps| largest_difference(&end(&motion(&system, suzuki(steps))), &q));
    assert_order("q by Suzuki's composition", &errors, 4.0, 0.1);
}

/// dJ/d(knot) for controls that are piecewise linear between 101 knots: the chain rule through the interpolation.
fn with_respect_to_knots(gradient: &Gradient, refinement: usize) -> Vec<f64> {
    let hat = |knot: usize, node: usize| 1.0 - (node as f64 / refinement as f64 - knot as f64).abs();
    let at_node = |knot| gradient.controls.iter().enumerate().map(move |(node, d)| hat(knot, node).max(0.0) * d);
    (0..=100).map(|knot| at_node(knot).sum()).collect()
}

#[test]
fn the_gradient_with_respect_to_the_controls_converges_with_order_two() {
    let reference = numbers(include_str!("../data/continuous_grad_cr0_const10.json"), "grad");
    let system = cart(0);
    let errors = [1, 2, 4, 8, 16].map(|refinement| {
        let gradient = derivatives(&system, equal(100 * refinement));
        largest_difference(&with_respect_to_knots(&gradient, refinement), &reference)
    });
    assert_order("dJ/du", &errors, 2.0, 0.05);
}

/// A cart with two links; the design variables are a mass, a length from hinge to centre and gravity.
fn designed() -> System {
    let mut scene = Scene::new();
    let (mass, arm, gravity) = (scene.design("mass", 0.4), scene.design("arm", 0.5), scene.design("gravity", -9.81));
    let force = scene.control("force");
    scene.gravity(0.0, gravity);
    let cart = scene.body("cart", 0.8, 0.034, [0.0; 3]);
    let one = scene.body("one", mass, 0.083, [0.0, -0.5, -FRAC_PI_2]);
    let two = scene.body("two", mass, 0.083, [0.0, -1.5, -FRAC_PI_2]);
    let (origin, centre) = (Body::GROUND.at(0.0, 0.0), cart.at(0.0, 0.0));
    scene.prismatic("rail", origin, 0.0, centre, 0.0);
    scene.actuator("drive", origin, 0.0, centre, force);
    scene.revolute("first hinge", centre, one.at(-0.5, 0.0));
    scene.revolute("second hinge", one.at(arm, 0.0), two.at(-0.5, 0.0));
    scene.joint_friction("friction", cart, one, 0.2);
    let [_, _, angle] = two.coordinates;
    scene.cost("angle", AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
    scene.compile().expect("scene")
}

/// dJ/dα for turning both links at the start, and dJ/db.
fn of_start_and_design(gradient: &Gradient) -> (f64, [f64; 3]) {
    let q = gradient.start.q();
    // The centres hang 0.5 m and 1.5 m below the cart: dx/dα = −y = 0.5 m, 1.5 m.
    let turned = 0.5 * q[3] + q[5] + 1.5 * q[6] + q[8];
    (turned, [0, 1, 2].map(|b| gradient.design[b]))
}

#[test]
fn derivatives_with_respect_to_the_initial_angle_and_to_constants_converge_with_order_two() {
    let system = designed();
    let (angle, design) = of_start_and_design(&derivatives(&system, suzuki(800)));
    let errors = [100, 200, 400, 800, 1600].map(|steps| {
        let (a, d) = of_start_and_design(&derivatives(&system, equal(steps)));
        (a - angle, [0, 1, 2].map(|b| d[b] - design[b]))
    });
    assert_order("dJ/d(initial angle)", &errors.map(|e| e.0.abs()), 2.0, 0.05);
    for (b, name) in ["mass", "arm", "gravity"].iter().enumerate() {
        assert_order(&format!("dJ/d({name})"), &errors.map(|e| e.1[b].abs()), 2.0, 0.05);
    }
}
