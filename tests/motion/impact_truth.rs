//! Impacts, and constraints that open and close, beside references that were made without this library (`tests/data/events.json`).

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Error, Grid, Inputs, Multiplier, Param, PotentialEnergy, Scalar, Scene, Scheme, Settings,
    Solver, Start, Sum, Warning,
};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

use crate::common::{assert_says, numbers};
use crate::event_truth::{Case, TRUTH, Value, ends, rods};

/// b₀ σ + b₁ λ.
struct Reaction;

impl Cost<0, 1, 0, 2> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, b: &SVector<S, 2>) -> S {
        b[0] * at.sigma[0] + b[1] * at.lambda[0]
    }
}

/// Rows of a reference, value and derivatives, with the derivatives in another order.
fn rows(name: &str, order: &[usize]) -> Vec<f64> {
    numbers(TRUTH, name)
        .chunks(1 + order.len())
        .flat_map(|row| [row[0]].into_iter().chain(order.iter().map(|k| row[1 + k])))
        .collect()
}

/// An output −σ at the end, less that after the impact.
fn impulse_since(scene: &mut Scene, name: &str, equation: Multiplier) {
    let output = scene.output(name);
    let mut term = |name: &str, sum, factor: f64| {
        scene.term(output, name, Reaction, sum, [], [equation], [], [factor.into(), 0.0.into()])
    };
    term(name, Sum::Terminal, -1.0);
    term(&format!("{name}, before"), Sum::AfterEvent(0), 1.0);
}

/// A ball of 1 kg falls from 1 m on a rigid floor, which it hits, or on which it stays.
fn ball(name: &str, restitution: Option<f64>) -> Case {
    let mut scene = Scene::new();
    let gravity = scene.design("gravity", 9.81);
    scene.gravity(0.0, -Param::from(gravity));
    let mass = scene.design("mass", 1.0);
    let ball = scene.particle("ball", mass, [0.0, 1.0]);
    let z = [ball.coordinates[1]];
    let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, 0.0), FRAC_PI_2, ball.point());
    match restitution {
        Some(restitution) => {
            let restitution = scene.design("restitution", restitution);
            scene.impact_at(floor.event, floor.equation, restitution);
        }
        None => scene.close_at(floor.event, &[floor.equation]),
    }
    let impacts = if restitution.is_some() { 2 } else { 1 };
    for k in 0..impacts {
        scene.event_time(&format!("event {k}"), k);
        scene.event_impulse(&format!("impulse {k}"), floor.equation, k);
    }
    for (name, is_rate) in [("z", false), ("v", true)] {
        let output = scene.output(name);
        scene.term(output, name, Value { is_rate }, Sum::Terminal, z, [], [], []);
    }
    let integral = scene.output("integral");
    scene.term(integral, "integral", Value { is_rate: false }, Sum::Integral, z, [], [], []);
    if restitution.is_none() {
        impulse_since(&mut scene, "support", floor.equation);
    }
    let system = scene.compile().expect("a scene");
    let order: &[usize] = if restitution.is_some() { &[3, 2, 1, 0] } else { &[2, 1, 0] };
    let truth = rows(name, order);
    let times: Vec<f64> = (0..impacts).map(|k| truth[2 * k * (1 + order.len())]).collect();
    let ends = [times.clone(), vec![1.2]].concat();
    let starts = [vec![0.0], times].concat();
    let phases = starts.iter().zip(ends).map(|(start, end)| (end - start, false)).collect();
    let start = Inputs::at_rest(&system, Grid::uniform(1, 1.0)).start;
    let zeros = if restitution.is_some() { 2 } else { 1 };
    let designs = (0..order.len() - 1).collect();
    Case { system, start, designs, coordinates: vec![1], truth, phases, events: vec![(0, zeros); impacts] }
}

#[test]
fn a_ball_on_a_rigid_floor() -> Result<(), Error> {
    let bouncing: [&[usize]; 3] = [&[10, 20, 6], &[20, 40, 12], &[40, 80, 24]];
    let resting: [&[usize]; 3] = [&[10, 20], &[20, 40], &[40, 80]];
    for (name, restitution, steps) in [("B1", Some(0.7), bouncing), ("B2", None, resting)] {
        let case = ball(name, restitution);
        // Only the integral has errors, and the fourth-order scheme has none.
        case.assert_orders(name, Scheme::TRAPEZOIDAL, 2.0, &steps)?;
        let errors = case.errors(Scheme::ESDIRK4, steps[0])?;
        println!("{name}, ESDIRK4: {errors:?}");
        // Derivatives that vanish count relative to 1e-5.
        assert!(errors[0] < 1e-13 && errors[1] < 1e-8, "{name}: {errors:?}");
    }
    Ok(())
}

/// Two rods in absolute coordinates, with angles from the lower vertical; the tip hits a rigid wall, or stays on it.
fn double_pendulum(name: &str, restitution: Option<f64>) -> Case {
    let mut scene = Scene::new();
    let mass = scene.design("mass", 0.7);
    let wall = scene.design("wall", -0.85);
    let gravity = scene.design("gravity", 9.81);
    scene.gravity(0.0, -Param::from(gravity));
    let [inner, outer] = rods(&mut scene, mass);
    let contact = scene.rigid_contact("wall", Body::GROUND.at(wall, 0.0), 0.0, outer.at(0.0, -0.4));
    scene.event_time("time", 0);
    scene.event_impulse("impulse", contact.equation, 0);
    ends(&mut scene, [inner, outer]);
    let angle = outer.coordinates[2];
    let mut designs = vec![0, 1, 2];
    match restitution {
        Some(restitution) => {
            let restitution = scene.design("restitution", restitution);
            scene.impact_at(contact.event, contact.equation, restitution);
            designs.push(3);
        }
        None => {
            scene.close_at(contact.event, &[contact.equation]);
            let force = scene.output("force");
            scene.term(force, "force", Reaction, Sum::Terminal, [], [contact.equation], [], [0.0.into(), (-1.0).into()]);
            impulse_since(&mut scene, "sliding", contact.equation);
        }
    }
    let system = scene.compile().expect("a scene");
    let start = Start::assembled(&system).hold(&[inner.coordinates[2], angle]);
    // The reference has the derivatives by the mass, the wall, gravity, both angles and the restitution.
    let order: &[usize] = if restitution.is_some() { &[0, 1, 2, 5, 3, 4] } else { &[0, 1, 2, 3, 4] };
    let truth = rows(name, order);
    let phases = vec![(truth[0], false), (1.08 - truth[0], false)];
    let coordinates = vec![inner.coordinates[2].index(), angle.index()];
    let zeros = if restitution.is_some() { 2 } else { 1 };
    Case { system, start, designs, coordinates, truth, phases, events: vec![(0, zeros)] }
}

#[test]
fn a_double_pendulum_whose_tip_hits_a_rigid_wall() -> Result<(), Error> {
    let coarse: [&[usize]; 3] = [&[400, 200], &[800, 400], &[1600, 800]];
    let fine: [&[usize]; 3] = [&[50, 25], &[100, 50], &[200, 100]];
    for (name, restitution) in [("C1", Some(0.7)), ("C3", None)] {
        let case = double_pendulum(name, restitution);
        case.assert_orders(name, Scheme::TRAPEZOIDAL, 2.0, &coarse)?;
        case.assert_orders(name, Scheme::ESDIRK4, 4.0, &fine)?;
    }
    Ok(())
}

/// t − b₀.
struct Past;

impl Cost<0, 0, 0, 1> for Past {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, b: &SVector<S, 1>) -> S {
        at.t - b[0]
    }
}

/// The force of a spring to a moving end, less that which opens a latch; b = [stiffness, force].
struct Pull;

impl Cost<1, 0, 0, 2> for Pull {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 2>) -> S {
        b[0] * (at.t * 0.5 + 0.3 - at.q[0]) - b[1]
    }
}

/// ½ b (0.3 + 0.5 t − x)².
struct Moving;

impl PotentialEnergy<1, 1> for Moving {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, t: S) -> S {
        let stretch = t * 0.5 + 0.3 - q[0];
        b[0] * stretch * stretch * 0.5
    }
}

/// ½ b x².
struct Spring;

impl PotentialEnergy<1, 1> for Spring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, _t: S) -> S {
        b[0] * q[0] * q[0] * 0.5
    }
}

/// x = 0.3.
struct Latch;

impl Constraint<1, 1, 0> for Latch {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0] - 0.3])
    }
}

/// A mass on a spring that a latch holds until a given time, or until a second spring pulls it open.
fn latch(name: &str) -> Case {
    let mut scene = Scene::new();
    let [mass, stiffness] = [scene.design("mass", 2.0), scene.design("stiffness", 50.0)];
    let slider = scene.particle("slider", mass, [0.3, 0.0]);
    let x = slider.coordinates[0];
    scene.potential_energy("spring", Spring, [x], [stiffness.into()]);
    let [latch] = scene.constraint("latch", Latch, [x], []);
    let release = if name == "D1" {
        let time = scene.design("time", 0.2);
        scene.event("release", Past, [], [], [], [time.into()])
    } else {
        let [second, force] = [scene.design("second stiffness", 40.0), scene.design("force", 10.0)];
        scene.potential_energy("second spring", Moving, [x], [second.into()]);
        scene.event("release", Pull, [x], [], [], [second.into(), force.into()])
    };
    scene.open_at(release, &[latch]);
    scene.event_time("time of release", 0);
    for (name, is_rate) in [("x", false), ("v", true)] {
        let output = scene.output(name);
        scene.term(output, name, Value { is_rate }, Sum::Terminal, [x], [], [], []);
    }
    let system = scene.compile().expect("a scene");
    let order: Vec<usize> = (0..system.designs()).collect();
    let truth = rows(name, &order);
    let phases = vec![(truth[0] * 0.9, false), (1.0 - truth[0] * 0.9, false)];
    let start = Inputs::at_rest(&system, Grid::uniform(1, 1.0)).start;
    Case { system, start, designs: order, coordinates: Vec::new(), truth, phases, events: vec![(0, 1)] }
}

#[test]
fn a_mass_that_is_released() -> Result<(), Error> {
    let steps: [&[usize]; 4] = [&[4, 20], &[8, 40], &[16, 80], &[32, 160]];
    for name in ["D1", "D2"] {
        let case = latch(name);
        case.assert_orders(name, Scheme::TRAPEZOIDAL, 2.0, &steps)?;
        case.assert_orders(name, Scheme::ESDIRK4, 4.0, &steps[..3])?;
    }
    Ok(())
}

#[test]
fn impacts_end_where_an_event_closes_their_equation() -> Result<(), Error> {
    let mut scene = Scene::new();
    let ball = scene.particle("ball", 1.0, [0.0, 1.0]);
    scene.gravity(0.0, -9.81);
    let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, 0.0), FRAC_PI_2, ball.point());
    scene.impact_at(floor.event, floor.equation, 0.5);
    let rests = scene.event("rests", Value { is_rate: false }, [ball.coordinates[1]], [], [], []);
    scene.close_at(rests, &[floor.equation]);
    let system = scene.compile()?;
    let mut solver = Solver::new(&system, Settings::default());
    let phases = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(100, 0.02)), 8)?;
    let motion = solver.simulate(&phases)?;
    let last = phases.events[phases.events.len() - 1];
    // All impacts happen before 0.4515 s (1 + 0.5)/(1 − 0.5); those within two steps are left out.
    println!("{} impacts, the last at {}", phases.events.len(), motion.times[last.node]);
    assert!(last.event == rests && (motion.times[last.node] - 3.0 * (2.0 / 9.81f64).sqrt()).abs() < 0.04);
    assert!(motion.q.row(1).iter().skip(last.node).all(|y| y.abs() < 1e-12));
    assert!(solver.report().warnings.is_empty(), "{:?}", solver.report().warnings);
    Ok(())
}

/// A mass on a spring that lands and leaves again when the spring pulls it up: its contact opens where it would pull.
#[test]
fn a_contact_opens_where_it_would_pull_and_no_rounding_closes_it() -> Result<(), Error> {
    let mut opened = 0;
    for k in 0..40 {
        let mut scene = Scene::new();
        let foot = scene.particle("foot", 0.3, [0.0, 0.2]);
        let body = scene.particle("body", 2.0, [0.0, 0.8]);
        scene.gravity(0.0, -9.81);
        scene.spring_damper("leg", foot.point(), body.point(), 400.0 + 40.0 * f64::from(k), 1.0, 0.6);
        let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, 0.0), FRAC_PI_2, foot.point());
        scene.close_at(floor.event, &[floor.equation]);
        let leaves = scene.reaction_event("leaves", floor.equation);
        scene.open_at(leaves, &[floor.equation]);
        let system = scene.compile()?;
        let mut solver = Solver::new(&system, Settings::default());
        let phases = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(200, 0.005)), 8)?;
        let motion = solver.simulate(&phases)?;
        let times: Vec<f64> = phases.events.iter().map(|event| motion.times[event.node]).collect();
        // Every landing is followed by a take-off, and in between time passes.
        assert!(
            phases.events.iter().enumerate().all(|(i, event)| (event.event == leaves) == (i % 2 == 1)),
            "{k}: {times:?}"
        );
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] > 1e-3), "{k}: {times:?}");
        let warnings = &solver.report().warnings;
        assert!(
            warnings.iter().all(|warning| matches!(warning, Warning::Pulls { .. } | Warning::CoarseSteps { .. })),
            "{k}: {warnings:?}"
        );
        opened += phases.events.len() / 2;
    }
    println!("{opened} take-offs");
    assert!(opened >= 20);
    Ok(())
}

#[test]
fn phases_between_impacts_are_found() -> Result<(), Error> {
    let case = ball("B1", Some(0.7));
    let mut solver = Solver::new(&case.system, Settings::default());
    let given = Inputs { start: case.start.clone(), ..Inputs::at_rest(&case.system, Grid::uniform(60, 0.02)) };
    let phases = solver.find_phases(&given, 8)?;
    assert_eq!(phases.events.len(), 2);
    solver.simulate(&phases)?;
    let values = solver.outputs()?;
    for (value, truth) in values.iter().zip(case.truth.chunks(5)).take(4) {
        assert!((value - truth[0]).abs() < 1e-12, "{value} for {}", truth[0]);
    }
    // Impacts end at 0.4515 s (1 + 0.7)/(1 − 0.7).
    let long = Inputs { start: case.start.clone(), ..Inputs::at_rest(&case.system, Grid::uniform(150, 0.02)) };
    let error = solver.find_phases(&long, 8).map(|_| ()).expect_err("impacts that accumulate");
    assert_says(&error, &["impacts accumulate", "`floor`", "close"]);
    let Error::Accumulation { count, time, .. } = error else { panic!("{error}") };
    assert!(count > 10 && (time - case.truth[0] * 1.7 / 0.3).abs() < 1e-6, "{count}, {time}");
    let plastic = ball("B1", Some(0.0));
    let mut solver = Solver::new(&plastic.system, Settings::default());
    let given = Inputs { start: plastic.start.clone(), ..Inputs::at_rest(&plastic.system, Grid::uniform(60, 0.02)) };
    let error = solver.find_phases(&given, 8).map(|_| ()).expect_err("no rebound");
    assert_says(&error, &["after 1 impacts", "t = 0.4515"]);
    Ok(())
}

/// z − 0.1.
struct Above;

impl Cost<1, 0, 0, 0> for Above {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] - 0.1
    }
}

#[test]
fn what_contacts_cannot_do_is_said() -> Result<(), Error> {
    let case = ball("B1", Some(0.7));
    let mut solver = Solver::new(&case.system, Settings::default());
    let through = Inputs { start: case.start.clone(), ..Inputs::at_rest(&case.system, Grid::uniform(10, 0.05)) };
    let empty = Inputs { events: Vec::new(), ..through.clone() };
    let scene_of = |restitution: f64| {
        let mut scene = Scene::new();
        let ball = scene.particle("ball", 1.0, [0.3, 1.0]);
        scene.gravity(0.0, -9.81);
        let pull = scene.control("pull");
        scene.actuator("rope", Body::GROUND.at(0.0, 0.0), FRAC_PI_2, ball.point(), pull);
        let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, 0.0), FRAC_PI_2, ball.point());
        let other = scene.event("other", Above, [ball.coordinates[1]], [], [], []);
        let [_] = scene.constraint("joint", Latch, [ball.coordinates[0]], []);
        if restitution.is_nan() {
            scene.close_at(floor.event, &[floor.equation]);
        } else {
            scene.impact_at(floor.event, floor.equation, restitution);
        }
        scene.close_at(other, &[floor.equation]);
        scene.compile()
    };
    assert!(solver.simulate(&empty).is_err(), "outputs at events");
    assert_says(
        &scene_of(-0.1).expect_err("a negative restitution"),
        &["restitution at event `floor`", "-0.1", "not negative"],
    );
    let mut scene = Scene::new();
    let ball = scene.particle("ball", 1.0, [1.0, 1.0]);
    let [floor, wall] = [("floor", FRAC_PI_2), ("wall", 0.0)]
        .map(|(name, normal)| scene.rigid_contact(name, Body::GROUND.at(0.0, 0.0), normal, ball.point()));
    [floor, wall].iter().for_each(|contact| scene.impact_at(floor.event, contact.equation, 0.5));
    assert_says(&scene.compile().expect_err("two impacts"), &["equations with an impact at event `floor`", "it must be 1"]);
    let system = scene_of(0.5)?;
    let mut solver = Solver::new(&system, Settings::default());
    let free = Inputs::at_rest(&system, Grid::uniform(10, 0.05));
    solver.simulate(&free)?;
    let told: Vec<String> = solver.report().warnings.iter().map(ToString::to_string).collect();
    println!("{told:?}");
    assert!(told.len() == 1 && told[0].contains("the gap of `floor` is negative at t = 0.5 s"), "{told:?}");
    // Each fault, and what is said of it.
    let at = |event: usize, node: usize, steps: &[f64]| {
        let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, steps.to_vec()));
        inputs.events = vec![system.event(event).at(node)];
        inputs
    };
    let faults: [(Inputs, &[&str]); 5] = [
        (at(0, 2, &[0.2; 4]), &["length of step 3", "`floor`", "open or close", "0"]),
        (at(0, 2, &[0.2, 0.2, 0.0, 0.1]), &["length of step 4", "`floor`"]),
        (at(1, 2, &[0.2, 0.2, 0.0, 0.1]), &["`other` closes `floor`", "t = 0.428", "violated by 1.000e-1"]),
        (Inputs { open: vec![scene_of(0.5)?.multiplier(0)], ..free.clone() }, &["Inputs::open", "multiplier"]),
        (Inputs { open: vec![system.multiplier(1)], ..free.clone() }, &["`joint`", "`Inputs::open`"]),
    ];
    for (inputs, words) in faults {
        assert_says(&solver.simulate(&inputs).map(|_| ()).expect_err("a fault"), words);
    }
    // On the floor, the rope lifts the ball.
    let system = scene_of(f64::NAN)?;
    let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, [vec![0.05; 9], vec![0.0], vec![0.05; 10]].concat()));
    inputs.events = vec![system.event(0).at(9)];
    inputs.controls.columns_mut(14, 7).fill(12.0);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let told: Vec<String> = solver.report().warnings.iter().map(ToString::to_string).collect();
    assert!(told.len() == 1 && told[0].contains("`floor` pulls before t = 0.7"), "{told:?}");
    Ok(())
}
