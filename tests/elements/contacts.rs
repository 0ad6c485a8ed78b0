//! Contacts of circles and end stops against closed forms and balances.

use crate::common::{assert_gradient_is_exact, assert_says, largest};
use hamiltonian_adjoint::planar::{Body, CircleContact, EndStop};
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Force, ForcePoint, Gradient, Grid, Inputs, Mechanics, Param, Scene, Scheme, Settings, Solver, Start, Sum, System,
    Trajectory, gradient, simulate,
};
use nalgebra::SVector;
use num_dual::{Dual3_64, third_derivative};
use std::f64::consts::{FRAC_PI_2, PI};

const GRAVITY: f64 = 9.81;

fn list<const N: usize>(numbers: [f64; N]) -> [Param; N] {
    numbers.map(Into::into)
}

fn accurate() -> Settings {
    Settings { scheme: Scheme::ESDIRK5, ..Settings::default() }
}

fn accelerations(system: &System, v: &[f64]) -> Vec<f64> {
    let at = Mechanics::new(system, system.initial_coordinates().as_slice(), v).expect("a state");
    at.accelerations().expect("accelerations").0.as_slice().to_vec()
}

fn moved(system: &System, v: &[f64], steps: usize, duration: f64) -> Trajectory {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, duration / steps as f64));
    inputs.start.rate_mut().copy_from_slice(v);
    simulate(system, &inputs, accurate()).expect("a motion")
}

/// A ball of radius 0.1 whose depth in the floor at the start is given.
fn ball(depth: f64, law: [f64; 5]) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -GRAVITY);
    let ball = scene.body("ball", 0.2, 8e-4, [0.0, 0.1 - depth, 0.3]);
    scene.circle_contact("floor", Body::GROUND.at(0.3, 0.0), FRAC_PI_2, ball.at(0.0, 0.0), 0.1, list(law));
    scene.compile().expect("a scene")
}

#[test]
fn forces_with_a_width_have_continuous_second_derivatives_and_are_exact_beyond() {
    type Number = Dual3_64;
    let (zero, one) = (Number::from(0.0), Number::from(1.0));
    let at = |q: [Number; 3], v: Number| ForcePoint {
        q: [zero, zero, zero, q[0], q[1], q[2]].into(),
        v: [zero, zero, zero, zero, v, zero].into(),
        u: [].into(),
        t: zero,
    };
    let law = |first: f64, radius: f64| {
        SVector::from([0.0, 0.0, 0.0, 0.0, first, radius, 10.0, 0.3, 0.0, 1.0, 0.5].map(Number::from))
    };
    let contact = |is_pair: bool, y: Number, v: Number, b: SVector<Number, 11>| {
        CircleContact { is_pair, is_smooth: true }.force(&at([zero, y, zero], v), &b)[4]
    };
    // A point on a floor, a circle on another one, a pin in its bore, and a stop, as functions of the depth.
    let floor = |x: Number| contact(false, -x, zero, law(FRAC_PI_2, 0.0));
    let pair = |x: Number| contact(true, -x + 3.0, zero, law(2.0, 1.0));
    let bore = |x: Number| contact(true, -x - 1.0, zero, law(-2.0, 1.0));
    let limits = [-9.0, 0.0, 10.0, 0.3, 0.5].map(Number::from);
    let stop = |x: Number| -EndStop(true).force(&at([zero, zero, x], zero), &limits.into())[5];
    // The factor 1 + c dδ/dt at the depth 1, as a function of its value.
    let damping = |x: Number| contact(false, -one, (one - x) / 0.3, law(FRAC_PI_2, 0.0));
    let laws: [(&dyn Fn(Number) -> Number, f64); 5] =
        [(&floor, 1.5), (&pair, 1.5), (&bore, 1.5), (&stop, 1.0), (&damping, 1.0)];
    for (k, (law, n)) in laws.into_iter().enumerate() {
        let derivatives = |x: f64| {
            let (f, first, second, third) = third_derivative(law, x);
            [f, first, second, third]
        };
        for end in [0.0, 0.5] {
            let (before, after) = (derivatives(end - 1e-8), derivatives(end + 1e-8));
            assert!((0..3).all(|i| (before[i] - after[i]).abs() < 1e-4), "{k} at {end}: {before:?} {after:?}");
            assert!(end == 0.0 || (before[3] - after[3]).abs() > 10.0, "{k}: {before:?} {after:?}");
        }
        let exact = 10.0 * 1.2f64.powf(n);
        assert!((derivatives(1.2)[0] - exact).abs() < 1e-14 * exact.powi(2), "{k}");
        assert!(largest(&derivatives(-0.3)) == 0.0 && (1..150).all(|i| derivatives(0.01 * f64::from(i))[1] > 0.0), "{k}");
    }
    assert_eq!(third_derivative(floor, 0.0), (0.0, 0.0, 0.0, 0.0), "at the first touch");
}

#[test]
fn a_ball_is_pushed_by_the_law_beyond_the_width_and_by_friction_at_its_lowest_point() {
    let (k, c, mu, speed) = (1e5, 0.4, 0.3, 0.05);
    let v = [0.4, -0.2, -3.0];
    for width in [0.0, 1e-3, 2e-3] {
        let v_dot = accelerations(&ball(2e-3, [k, c, mu, speed, width]), &v);
        let normal: f64 = k * 2e-3f64.powf(1.5) * (1.0 + c * 0.2);
        let friction = -mu * normal * ((v[0] + 0.1 * v[2]) / speed).tanh();
        let expected = [friction / 0.2, normal / 0.2 - GRAVITY, 0.1 * friction / 8e-4];
        assert!((0..3).all(|i| (v_dot[i] - expected[i]).abs() < 1e-11 * expected[i].abs()), "{v_dot:?} {expected:?}");
    }
    let rolls = accelerations(&ball(2e-3, [k, c, mu, speed, 1e-3]), &[0.4, 0.0, -4.0]);
    assert!(rolls[0].abs() < 1e-12 && rolls[2].abs() < 1e-11, "no friction at rest: {rolls:?}");
    let softer = accelerations(&ball(2e-3, [k, c, mu, speed, 4e-3]), &v)[1];
    assert!(softer < accelerations(&ball(2e-3, [k, c, mu, speed, 0.0]), &v)[1] - 1.0, "within the width");
    assert_eq!(accelerations(&ball(-1e-9, [k, c, mu, speed, 1e-3]), &v), [0.0, -GRAVITY, 0.0]);
}

#[test]
fn a_ball_on_a_smooth_floor_returns_to_its_height() {
    let system = ball(-0.5, [1e5, 0.0, 0.0, 1.0, 1e-3]);
    let fall = (2.0 * 0.5 / GRAVITY).sqrt();
    let motion = moved(&system, &[0.0; 3], 20_000, 2.2 * fall);
    let after = motion.q.row(1).columns(12_000, 8_000).max();
    assert!((after - 0.6).abs() < 1e-5 && motion.q.row(1).min() < 0.098, "{after}");
}

#[test]
fn a_circle_without_radius_moves_as_a_point() {
    let scene = |is_circle: bool| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -GRAVITY);
        let rod = scene.body("rod", 0.2, 0.01, [0.0, 0.1, 0.3]);
        let (ground, point, law) = (Body::GROUND.at(0.1, 0.0), rod.at(-0.3, 0.0), list([1e4, 0.3, 0.2, 0.1]));
        match is_circle {
            false => scene.contact("floor", ground, FRAC_PI_2, point, law),
            true => {
                let [k, c, mu, speed] = law;
                scene.circle_contact("floor", ground, FRAC_PI_2, point, 0.0, [k, c, mu, speed, 0.0.into()]);
            }
        }
        scene.cost("turn", AngleError, Sum::Terminal, [rod.coordinates[2]], [], [], [0.0.into()]);
        let system = scene.compile().expect("a scene");
        let mut solver = Solver::new(&system, Settings::default());
        let phases = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(100, 0.002)), 8).expect("phases");
        assert!(!phases.events.is_empty());
        let end = solver.simulate(&phases).expect("a motion").q.column(phases.grid.steps.len()).into_owned();
        (end, solver.gradient().expect("a gradient").start.q().clone())
    };
    let (point, circle) = (scene(false), scene(true));
    assert!((point.0 - circle.0).amax() < 1e-12 && (&point.1 - &circle.1).amax() < 1e-11 * point.1.amax());
}

/// Momenta along x and y, angular momentum and kinetic energy of two free bodies with the given masses and moments of inertia.
fn balance(motion: &Trajectory, node: usize, inertia: [[f64; 2]; 2]) -> [f64; 4] {
    let (q, v) = (motion.q.column(node), motion.v.column(node));
    let mut sums = [0.0; 4];
    for (k, [mass, inertia]) in inertia.into_iter().enumerate() {
        let (q, v) = (&q.as_slice()[3 * k..], &v.as_slice()[3 * k..]);
        let of = [mass * v[0], mass * v[1], mass * (q[0] * v[1] - q[1] * v[0]) + inertia * v[2]];
        (0..3).for_each(|i| sums[i] += of[i]);
        sums[3] += 0.5 * (mass * (v[0] * v[0] + v[1] * v[1]) + inertia * v[2] * v[2]);
    }
    sums
}

#[test]
fn bodies_that_touch_keep_momentum_and_angular_momentum_and_without_losses_energy() {
    let inertia = [[1.0, 0.02], [2.0, 0.05]];
    for (is_pair, width, mu, c) in
        [true, false].into_iter().flat_map(|pair| [(pair, 0.0, 0.3, 0.2), (pair, 0.01, 0.3, 0.2), (pair, 0.01, 0.0, 0.0)])
    {
        let mut scene = Scene::new();
        let a = scene.body("a", inertia[0][0], inertia[0][1], [0.0, 0.0, 0.2]);
        let b = scene.body("b", inertia[1][0], inertia[1][1], [0.6, 0.15, 0.0]);
        let law = list([2e3, c, mu, 0.1, width]);
        match is_pair {
            true => scene.circle_pair_contact("bump", a.at(0.02, 0.0), 0.2, b.at(0.0, 0.03), 0.3, law),
            false => scene.circle_contact("bump", a.at(0.25, 0.0), 0.1, b.at(0.0, 0.03), 0.3, law),
        }
        let system = scene.compile().expect("a scene");
        let motion = moved(&system, &[1.0, 0.1, 2.0, -0.5, 0.0, -1.0], 4000, 0.5);
        let (before, after) = (balance(&motion, 0, inertia), balance(&motion, 4000, inertia));
        let changes: Vec<f64> = (0..4).map(|i| after[i] - before[i]).collect();
        let turned = (motion.v[(0, 4000)] - 1.0).abs();
        assert!(turned > 0.5 && largest(&changes[..3]) < 1e-12, "{is_pair} {width} {mu}: {changes:?}");
        assert!(if mu > 0.0 { changes[3] < -1e-2 } else { changes[3].abs() < 1e-8 }, "{is_pair} {width} {mu}: {changes:?}");
    }
}

#[test]
fn a_pin_rests_at_the_bottom_of_its_bore_and_starts_in_its_middle() {
    let (k, clearance, mass) = (1e5f64, 2e-3, 0.7);
    let depth = (mass * GRAVITY / k).powf(2.0 / 3.0);
    let pin = |below: f64| {
        let mut scene = Scene::new();
        scene.gravity(0.0, -GRAVITY);
        let (bore, stiffness) = (scene.design("bore", 0.02 + clearance), scene.design("stiffness", k));
        let pin = scene.body("pin", mass, 1e-3, [0.0, -below, 0.2]);
        let [width, c, mu, speed] = [0.5 * depth, 0.1, 0.2, 0.05].map(Param::from);
        let law = [stiffness.into(), c, mu, speed, width];
        scene.circle_pair_contact("hinge", Body::GROUND.at(0.0, 0.0), -Param::from(bore), pin.at(0.0, 0.0), 0.02, law);
        for (k, q) in pin.coordinates.into_iter().enumerate() {
            scene.cost(&format!("end {k}"), AngleError, Sum::Terminal, [q], [], [], [0.1.into()]);
        }
        scene.compile().expect("a scene")
    };
    assert!(largest(&accelerations(&pin(clearance + depth), &[0.0; 3])) < 1e-9);
    let system = pin(0.0);
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 5e-4));
    inputs.start.rate_mut().copy_from_slice(&[0.05, 0.0, 3.0]);
    assert!(simulate(&system, &inputs, Settings::default()).expect("a motion").q.row(1).min() < -clearance);
    assert_gradient_is_exact("pin in a bore", &system, &inputs);
}

/// A wheel between stops of its angle, or a slide between stops of its displacement, of inertia 0.5.
fn between_stops(is_angle: bool, law: [f64; 3]) -> System {
    let mut scene = Scene::new();
    let (limits, law) = (list([-0.3, 0.5]), list(law));
    let body = scene.body("body", 0.5, 0.5, [0.0; 3]);
    let (ground, centre) = (Body::GROUND.at(0.0, 0.0), body.at(0.0, 0.0));
    if is_angle {
        scene.revolute("axle", ground, centre);
        scene.end_stop("stop", Body::GROUND, body, limits, law);
    } else {
        scene.prismatic("rail", ground, 0.0, centre, 0.0);
        scene.sliding_end_stop("stop", ground, 0.0, centre, limits, law);
    }
    let coordinate = body.coordinates[if is_angle { 2 } else { 0 }];
    scene.cost("end", AngleError, Sum::Terminal, [coordinate], [], [], [0.0.into()]);
    scene.compile().expect("a scene")
}

/// The coordinates and inputs of a motion that begins with this rate.
fn rushing(system: &System, is_angle: bool, rate: f64, grid: Grid) -> (usize, Inputs) {
    let q = if is_angle { 2 } else { 0 };
    let mut v = vec![0.0; 3];
    v[q] = rate;
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.start = Start::Velocity { q: system.initial_coordinates().clone(), v: v.into() };
    (q, inputs)
}

#[test]
fn stops_return_what_hits_them_in_half_a_period_of_their_spring() {
    let k: f64 = 800.0;
    for (is_angle, rate) in [(true, 2.0), (true, -2.0), (false, 2.0), (false, -2.0)] {
        let system = between_stops(is_angle, [k, 0.0, 0.0]);
        assert_eq!(system.event_name(0), "stop");
        let way = if rate > 0.0 { 0.5 } else { 0.3 };
        // There, half a period, and back to the middle.
        let duration = 2.0 * way / 2.0 + PI * (0.5f64 / k).sqrt();
        let (q, inputs) = rushing(&system, is_angle, rate, Grid::uniform(200, duration / 200.0));
        let mut solver = Solver::new(&system, accurate());
        let phases = solver.find_phases(&inputs, 40).expect("phases");
        assert_eq!(phases.events.len(), 2);
        let motion = solver.simulate(&phases).expect("a motion");
        let last = motion.last();
        assert!(motion.q[(q, last)].abs() < 1e-6 && (motion.v[(q, last)] + rate).abs() < 1e-6, "{is_angle} {rate}");
    }
}

#[test]
fn a_damped_stop_returns_less_and_pulls_never() {
    for (is_angle, width, sign) in [true, false]
        .into_iter()
        .flat_map(|is_angle| [(0.0, 1.0), (0.01, 1.0), (0.01, -1.0)].map(|(w, sign)| (is_angle, w, sign)))
    {
        let system = between_stops(is_angle, [800.0, 2.0, width]);
        let (q, inputs) = rushing(&system, is_angle, 2.0 * sign, Grid::uniform(1000, 5e-4));
        let motion = simulate(&system, &inputs, accurate()).expect("a motion");
        let v = |i: usize| sign * motion.v[(q, i)];
        // Faster than 1/c, it would be pulled.
        assert!((0.1..0.5).contains(&-v(1000)), "{is_angle} {width} {sign}: {}", v(1000));
        assert!((1..=1000).all(|i| v(i) <= v(i - 1) + 1e-9), "{is_angle} {width} {sign}");
    }
}

#[test]
fn a_smooth_onset_has_no_event_and_no_kink_unless_steps_jump_over_it() {
    let smooth = |width: f64, steps: usize| -> (usize, Gradient) {
        let system = between_stops(true, [800.0, 0.1, width]);
        let (_, inputs) = rushing(&system, true, 2.0, Grid::uniform(steps, 0.6 / steps as f64));
        (system.events(), gradient(&system, &inputs, Settings::default()).expect("a gradient"))
    };
    let (events, resolved) = smooth(0.02, 900);
    assert!(events == 0 && resolved.frozen.is_none(), "15 steps cross the width");
    assert!(smooth(0.02, 300).1.frozen.is_some(), "five steps cross it");
    let (events, kinked) = smooth(0.0, 300);
    assert!(events == 1 && kinked.frozen.is_some());
}

#[test]
fn laws_out_of_range_are_named() {
    let refused = |add: fn(&mut Scene, Body)| {
        let mut scene = Scene::new();
        let body = scene.body("body", 1.0, 0.1, [0.0; 3]);
        add(&mut scene, body);
        scene.compile().expect_err("a scene that is wrong")
    };
    let ground = Body::GROUND.at(0.0, 0.0);
    let law = |speed: f64, width: f64| list([1.0, 0.0, 0.0, speed, width]);
    let error = refused(|scene, body| {
        scene.circle_contact(
            "floor",
            Body::GROUND.at(0.0, 0.0),
            0.0,
            body.at(0.0, 0.0),
            0.1,
            list([1.0, 0.0, 0.0, 1.0, -0.1]),
        )
    });
    assert_says(&error, &["the width of `floor`", "positive"]);
    let error = refused(|scene, body| {
        let width = scene.design("width", 0.0);
        let law = [1.0.into(), 0.0.into(), width.into()];
        scene.end_stop("stop", Body::GROUND, body, list([0.0, 1.0]), law);
    });
    assert_says(&error, &["the width of `stop`", "positive"]);
    let error = refused(|scene, body| {
        scene.sliding_end_stop(
            "stop",
            Body::GROUND.at(0.0, 0.0),
            0.0,
            body.at(0.0, 0.0),
            list([1.0, 0.5]),
            list([1.0, 0.0, 0.1]),
        );
    });
    assert_says(&error, &["the upper limit minus the lower limit of `stop`", "positive"]);
    for (radius, law, says) in
        [(-0.1, law(1.0, 0.1), "the radius of `ball`"), (0.1, law(0.0, 0.1), "the friction speed of `ball`")]
    {
        let mut scene = Scene::new();
        let body = scene.body("body", 1.0, 0.1, [0.0; 3]);
        scene.circle_pair_contact("ball", ground, 1.0, body.at(0.0, 0.0), radius, law);
        assert_says(&scene.compile().expect_err("a scene that is wrong"), &[says]);
    }
}
