//! The linearised motion against closed forms, and against differences of accelerations.

use crate::cases::{all, apart, differences, inputs};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Held, Inputs, LinearModel, Mechanics, Scene, Settings, Solver, Start, System};
use nalgebra::{DMatrix, DVector};

/// A pendulum on a cart: (M + m) ẍ + m l φ̈ cos φ − m l φ̇² sin φ = u, (J + m l²) φ̈ + m l ẍ cos φ = m g l sin φ, φ from the upper vertical.
#[test]
fn a_cart_with_a_pendulum_has_the_textbook_matrices_hanging_and_upright() {
    let CartPendulum { cart_mass, link_mass: m, link_inertia, link_length, rail_friction, gravity: g, .. } =
        CartPendulum::default();
    let (l, inertia) = (0.5 * link_length, link_inertia + link_mass_moment(m, link_length));
    for (start_angle, sign) in [(-std::f64::consts::FRAC_PI_2, -1.0), (std::f64::consts::FRAC_PI_2, 1.0)] {
        let parts = CartPendulum { start_angle, hinge_friction: 0.0, ..CartPendulum::with_links(1) }.mechanism();
        let chosen = [parts.cart.coordinates[0], parts.links[0].coordinates[2]];
        let system = parts.scene.compile().expect("a scene");
        let at = Mechanics::new(&system, system.initial_coordinates().as_slice(), &vec![0.0; system.n()]).expect("a state");
        let linear = at.linear_model(&chosen).expect("a linear model");
        assert_eq!(linear.names, ["cart.x", "link 1.φ"]);
        // The angle from the vertical is −(φ − start_angle) upright; the coordinate turns the other way.
        let mass = DMatrix::from_row_slice(2, 2, &[cart_mass + m, -sign * m * l, -sign * m * l, inertia]);
        let inverse = mass.try_inverse().expect("regular");
        let stiffness = DMatrix::from_diagonal(&DVector::from_row_slice(&[0.0, sign * m * g * l]));
        let damping = DMatrix::from_diagonal(&DVector::from_row_slice(&[-rail_friction, 0.0]));
        let mut a = DMatrix::zeros(4, 4);
        a.view_mut((0, 2), (2, 2)).fill_with_identity();
        a.view_mut((2, 0), (2, 2)).copy_from(&(&inverse * stiffness));
        a.view_mut((2, 2), (2, 2)).copy_from(&(&inverse * damping));
        let b = DMatrix::from_column_slice(4, 1, &[0.0, 0.0, inverse[(0, 0)], inverse[(1, 0)]]);
        assert!(apart(&linear.a, &a) < 1e-14, "{}{a}", linear.a);
        assert!(apart(&linear.b, &b) < 1e-14, "{}{b}", linear.b);
        let grows = linear.eigenvalues[0].re > 1e-6;
        assert_eq!(grows, sign > 0.0, "{:?}", linear.eigenvalues);
    }
}

fn link_mass_moment(mass: f64, length: f64) -> f64 {
    mass * (0.5 * length).powi(2)
}

/// ż for values of z, controls and design variables, by a new start and its accelerations.
fn rates(
    system: &System,
    at: &Mechanics,
    linear: &LinearModel,
    z: &DVector<f64>,
    u: &[f64],
    design: &DVector<f64>,
) -> DVector<f64> {
    let d = linear.coordinates.len();
    let [mut q, mut v] = [at.q(), at.v()].map(DVector::from_column_slice);
    // The other values are guesses.
    for (k, coordinate) in linear.coordinates.iter().enumerate() {
        (q[coordinate.index()], v[coordinate.index()]) = (z[k], z[d + k]);
    }
    let held = Held { coordinates: linear.coordinates.clone(), velocities: linear.coordinates.clone() };
    let inputs = Inputs { start: Start::Assembled { q, v, held }, ..inputs(system, at, u, design) };
    let there = Mechanics::at_start(system, &inputs).expect("a state");
    let (v_dot, _) = there.accelerations().expect("accelerations");
    let of = |x: &[f64]| linear.coordinates.iter().map(|i| x[i.index()]).collect::<Vec<f64>>();
    DVector::from_vec([of(there.v()), of(v_dot.as_slice())].concat())
}

#[test]
fn matrices_are_the_derivatives_of_the_motion_for_mechanisms_of_every_kind() {
    for (name, system, at) in all() {
        let linear = at.linear_model(&[]).expect(name);
        let d = linear.coordinates.len();
        assert_eq!(d, at.degrees_of_freedom() + at.open().len(), "{name}");
        let z = DVector::from_iterator(
            2 * d,
            [at.q(), at.v()].into_iter().flat_map(|x| linear.coordinates.iter().map(|i| x[i.index()])),
        );
        let (u, design) = (at.controls().to_vec(), system.design_values());
        let column = |len: usize, j: usize, by: f64| DVector::from_fn(len, |i, _| if i == j { by } else { 0.0 });
        let columns = |count: usize, of: &dyn Fn(usize, f64) -> DVector<f64>| {
            let columns: Vec<_> = (0..count).map(|j| differences(|by| of(j, by))).collect();
            if columns.is_empty() { DMatrix::zeros(2 * d, 0) } else { DMatrix::from_columns(&columns) }
        };
        let a = columns(2 * d, &|j, by| rates(&system, &at, &linear, &(&z + column(2 * d, j, by)), &u, &design));
        let b = columns(u.len(), &|j, by| {
            let u: Vec<f64> = (0..u.len()).map(|i| u[i] + if i == j { by } else { 0.0 }).collect();
            rates(&system, &at, &linear, &z, &u, &design)
        });
        let by_design =
            columns(design.len(), &|j, by| rates(&system, &at, &linear, &z, &u, &(&design + column(design.len(), j, by))));
        for (what, ours, reference) in [("A", &linear.a, a), ("B", &linear.b, b), ("C", &linear.by_design, by_design)] {
            assert!(apart(ours, &reference) < 2e-9, "{name}: {what} {}{ours}{reference}", apart(ours, &reference));
        }
        assert!(linear.a.view((d, 0), (d, 2 * d)).amax() > 1e-2, "{name}: the test is empty");
        let still = DMatrix::from_fn(d, 2 * d, |i, j| linear.q_z[(linear.coordinates[i].index(), j)]);
        assert!(apart(&still, &DMatrix::from_fn(d, 2 * d, |i, j| if i == j { 1.0 } else { 0.0 })) < 1e-15, "{name}");
    }
}

/// A pendulum whose rod has become longer by its drift swings as one with a longer rod.
#[test]
fn a_node_of_a_motion_is_linearised_with_its_drift() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let length = scene.design("length", 1.0);
    let bob = scene.particle("bob", 1.0, [0.6, -0.8]);
    scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.point(), length);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("a motion").clone();
    let node = Mechanics::at_node(&system, &inputs, &motion, 40).expect("a node");
    let drift = node.phi()[0];
    assert!(drift.abs() > 1e-6, "{drift}: there is no drift");
    let linear = node.linear_model(&[]).expect("a linear model");
    let same = Mechanics::new(&system, node.q(), node.v()).expect("a state");
    assert!(same.linear_model(&[]).is_err());
    inputs.design[0] = node.q()[0].hypot(node.q()[1]);
    let longer = same.with_design(inputs.design.as_slice()).expect("a length").linear_model(&[]).expect("a linear model");
    assert!(apart(&linear.a, &longer.a) < 1e-12, "{}{}", linear.a, longer.a);
    assert!(apart(&linear.q_z, &longer.q_z) < 1e-14 && apart(&linear.v_z, &longer.v_z) < 1e-14);
}

/// The transition matrix of a motion about an equilibrium is e^{A t}.
#[test]
fn a_small_motion_about_rest_is_that_of_the_matrices() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rods = [0, 1]
        .map(|k| scene.body(&format!("rod {k}"), 1.0 + k as f64, 0.1, [0.0, -0.5 - k as f64, -std::f64::consts::FRAC_PI_2]));
    scene.revolute("upper", Body::GROUND.at(0.0, 0.0), rods[0].at(-0.5, 0.0));
    scene.revolute("lower", rods[0].at(0.5, 0.0), rods[1].at(-0.5, 0.0));
    let angles = rods.map(|rod| rod.coordinates[2]);
    let system = scene.compile().expect("a scene");
    let q = system.initial_coordinates();
    let linear = Mechanics::new(&system, q.as_slice(), &[0.0; 6]).expect("a state").linear_model(&angles).expect("a model");
    let small = 1e-6;
    let z = DVector::from_row_slice(&[0.3, -0.2, 0.5, 0.4]) * small;
    let (q, v) = (&q + &linear.q_z * &z, &linear.v_z * &z);
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(400, 0.0025));
    inputs.start = Start::Assembled { q, v, held: Held { coordinates: angles.to_vec(), velocities: angles.to_vec() } };
    let settings = Settings { scheme: hamiltonian_adjoint::Scheme::ESDIRK5, ..Settings::default() };
    let mut solver = Solver::new(&system, settings);
    let motion = solver.simulate(&inputs).expect("a motion");
    let expected = (&linear.a * 1.0).exp() * z;
    let last = motion.last();
    for (k, angle) in angles.iter().enumerate() {
        let moved = motion.q[(angle.index(), last)] - system.initial_coordinates()[angle.index()];
        assert!((moved - expected[k]).abs() < 1e-8 * small, "{moved} {}", expected[k]);
    }
}
