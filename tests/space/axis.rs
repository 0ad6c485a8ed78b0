//! Parts along an axis: each against its equation, against the planar part of the same kind, and with derivatives of all kinds on an arm.

use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::axis::Axis;
use hamiltonian_adjoint::planar::{self, Constant, ConstantSpeed, Harmonic};
use hamiltonian_adjoint::spatial::{self, Inertia};
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Error, Grid, Inputs, Mechanics, Multiplier, Param, Scalar, Scene, Scheme, Settings, Solver,
    Start, Sum, System, Warning, gradient,
};
use nalgebra::SVector;

use crate::common::products::assert_products_are_exact;
use crate::common::{assert_gradient_is_exact_with, assert_says, largest_difference};

const MASSES: [f64; 2] = [2.0, 0.5];

/// Two masses at coordinates of one's own, joined by parts.
fn pair(add: impl FnOnce(&mut Scene, [Coordinate; 2])) -> System {
    let mut scene = Scene::new();
    let q = scene.coordinates("pair", ["x", "y"]);
    for (k, n) in [(0, 0.1), (1, 4.0)] {
        scene.rotor(&format!("rotor {k}"), q[k], MASSES[k] / (n * n), n);
    }
    add(&mut scene, q);
    scene.compile().expect("a pair")
}

/// N along the axis beyond a limit: k δ (1 + c dδ/dt), not negative, multiplied by t² (1 + 2 r + 3 r²) for a width.
fn normal(depth: f64, rate: f64, [k, c, w]: [f64; 3]) -> f64 {
    let t = if w > 0.0 { (depth / w).clamp(0.0, 1.0) } else { 1.0 };
    let r = 1.0 - t;
    k * depth.max(0.0) * (1.0 + c * rate).max(0.0) * t * t * (1.0 + 2.0 * r + 3.0 * r * r)
}

#[test]
fn each_part_pushes_as_its_equation_says() -> Result<(), Error> {
    type Part = (fn(&mut Scene, Axis), fn(f64, f64) -> f64);
    const LAW: [f64; 3] = [50.0, 0.2, 0.0];
    const SMOOTH: [f64; 3] = [50.0, 0.2, 0.1];
    const TIME: f64 = 0.3;
    let parts: [Part; 6] = [
        (
            |scene, axis| {
                let u = scene.control("u");
                scene.motor("motor", axis, u);
            },
            |_, _| 0.7,
        ),
        (
            |scene, axis| scene.axis_force("gust", axis, Harmonic, [0.1, 0.4, 5.0, 0.2].map(Into::into)),
            |_, _| 0.1 + 0.4 * (5.0 * TIME + 0.2).sin(),
        ),
        (|scene, axis| scene.axis_spring_damper("spring", axis, 4.0, 0.1, 0.3), |s, rate| -4.0 * (s - 0.1) - 0.3 * rate),
        (|scene, axis| scene.axis_coulomb_friction("friction", axis, 0.8, 0.2), |_, rate| -0.8 * (rate / 0.2).tanh()),
        (
            |scene, axis| scene.axis_end_stop("stop", axis, [-0.3, 0.4].map(Into::into), LAW.map(Into::into)),
            |s, rate| normal(-0.3 - s, -rate, LAW) - normal(s - 0.4, rate, LAW),
        ),
        (
            |scene, axis| scene.axis_end_stop("stop", axis, [-0.3, 0.4].map(Into::into), SMOOTH.map(Into::into)),
            |s, rate| normal(-0.3 - s, -rate, SMOOTH) - normal(s - 0.4, rate, SMOOTH),
        ),
    ];
    // The rates are so small that the factor of damping is not rounded.
    let states = [(0.45, 0.6), (0.62, -1.1), (0.1, 0.3), (-0.36, 0.2), (-0.7, -1.0)];
    for (part, (add, force)) in parts.into_iter().enumerate() {
        for ([x, y], [v_x, v_y]) in states.map(|(s, rate)| ([s, 0.2], [rate, -0.1])) {
            let single = pair(|scene, q| add(scene, q[0].into()));
            let both = pair(|scene, q| add(scene, Axis::difference(q[0], 1.5, q[1])));
            let [s, rate] = [[x, y], [v_x, v_y]].map(|[x, y]| y - 1.5 * x);
            let of_both = force(s, rate);
            for (system, expected) in [(single, [force(x, v_x), 0.0]), (both, [-1.5 * of_both, of_both])] {
                let at = Mechanics::new(&system, &[x, y], &[v_x, v_y])?.at_time(TIME)?;
                let at = at.with_controls(&[0.7][..system.k()])?;
                assert!((at.mass() - nalgebra::dmatrix![MASSES[0], 0.0; 0.0, MASSES[1]]).amax() < 1e-15);
                let acceleration = at.accelerations()?.0;
                let pushed = [0, 1].map(|k| MASSES[k] * acceleration[k]);
                assert!(largest_difference(&pushed, &expected) < 1e-13, "{part} at {s}: {pushed:?} for {expected:?}");
            }
        }
    }
    Ok(())
}

#[test]
fn drives_and_relations_hold_with_their_reactions() -> Result<(), Error> {
    let [m, n] = MASSES;
    // s = y − 1.5 x = 0.1 + 0.2 sin(3 t + 0.4).
    let parameters = [0.1, 0.2, 3.0, 0.4];
    let driven = pair(|scene, q| {
        _ = scene.driven_axis("drive", Axis::difference(q[0], 1.5, q[1]), Harmonic, parameters.map(Into::into));
    });
    let (s, rate, change) = (0.1 + 0.2 * 0.4f64.sin(), 0.6 * 0.4f64.cos(), -1.8 * 0.4f64.sin() / (1.0 / n + 1.5 * 1.5 / m));
    let at = Mechanics::new(&driven, &[0.0, s], &[0.0, rate])?;
    assert!(at.phi()[0].abs() < 1e-15 && at.phi_dot()[0].abs() < 1e-15);
    let (acceleration, lambda) = at.accelerations()?;
    assert!((-lambda[0] - change).abs() < 1e-13, "{lambda}");
    assert!(largest_difference(acceleration.as_slice(), &[-1.5 * change / m, change / n]) < 1e-13);
    // 0.3 x + 0.2 y = 0.05 under a force of 0.7 on x.
    let geared = pair(|scene, q| {
        let u = scene.control("u");
        scene.motor("motor", q[0], u);
        scene.linear_relation("gear", [(q[0], 0.3), (q[1], 0.2)], 0.05);
    });
    let at = Mechanics::new(&geared, &[0.1, 0.1], &[0.2, -0.3])?.with_controls(&[0.7])?;
    assert!(at.phi()[0].abs() < 1e-15 && at.phi_dot()[0].abs() < 1e-15);
    let (acceleration, lambda) = at.accelerations()?;
    let x = 0.7 / (m + n * 1.5 * 1.5);
    assert!(largest_difference(acceleration.as_slice(), &[x, -1.5 * x]) < 1e-13, "{acceleration}");
    assert!((-0.2 * lambda[0] + n * 1.5 * x).abs() < 1e-13);
    Ok(())
}

/// The angle and the rate of a joint, the multiplier of a relation, and the reaction (or the multiplier) of a drive.
struct Effort {
    is_of_reaction: bool,
}

impl Cost<2, 2, 0, 0> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 2, 0>, _b: &SVector<S, 0>) -> S {
        let swing = at.q[0].sin() + at.v[1] * at.v[1] * 0.5;
        let drive = if self.is_of_reaction { at.lambda[0] } else { at.sigma[0] };
        swing + drive * drive * 0.02 + at.sigma[1] * 0.3
    }
}

/// An arm with three hinges, a slide at its end, and all parts.
struct Arm {
    system: System,
    hinges: [Coordinate; 3],
    drive: [Multiplier; 1],
}

/// Three links, with a slide at the last one: the angles of its hinges, and the displacement of the slide.
fn links(scene: &mut Scene) -> ([Coordinate; 3], Coordinate) {
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let mut outer = spatial::Body::GROUND.origin();
    let hinges = [0, 1, 2].map(|k| {
        let axis = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.2, 0.9]][k];
        let tensor = [0.02, 0.03, 0.015, 0.001, -0.002, 0.0015];
        let link =
            space.body(&format!("link {k}"), Inertia::new(1.0 + 0.1 * k as f64, tensor).centred_at([0.01, 0.02, -0.15]));
        let hinge = space.revolute(&format!("hinge {k}"), outer.along(axis), link.origin().along(axis));
        outer = link.at([0.0, 0.01, -0.3]);
        hinge.angle
    });
    let slide = space.body("slide", Inertia::principal(0.3, [1e-3, 2e-3, 1e-3]));
    let offset = space.prismatic("rail", outer, slide.origin()).offset;
    hinges.iter().zip([0.3, 0.2, 0.1]).for_each(|(hinge, angle)| scene.place(*hinge, angle));
    (hinges, offset)
}

/// `is_kinked` adds a stop without a width, `is_of_reaction` a cost of λ: neither has derivatives of second order in hyper-dual numbers.
fn arm([is_kinked, is_of_reaction]: [bool; 2]) -> Arm {
    let mut scene = Scene::new();
    let (hinges, offset) = links(&mut scene);
    let [a, b, c] = hinges;
    let torque = scene.control("torque");
    let mut design = |name: &str, value: f64| Param::from(scene.design(name, value));
    let [inertia, ratio] = [design("inertia", 2.0) * 1e-4, design("ratio", 30.0)];
    let [stiffness, free, damping] = [design("stiffness", 3.0), design("free angle", 0.1), design("damping", 0.2)];
    let [dry, speed] = [design("dry", 0.4), design("speed", 0.3)];
    let limits = [design("lower", -0.5), design("upper", 0.15)];
    let law = [design("k", 40.0), design("c", 0.3), design("w", 0.1)];
    let [amplitude, pitch] = [design("amplitude", 0.1), design("pitch", 0.2)];
    scene.motor("motor", a, torque);
    scene.rotor("rotor", a, inertia, ratio);
    scene.rotor("second rotor", Axis::difference(a, ratio * 0.1, b), inertia, 5.0);
    scene.axis_spring_damper("spring", b, stiffness, free, damping);
    scene.axis_spring_damper("belt", Axis::difference(a, pitch, b), stiffness, free, damping);
    scene.axis_coulomb_friction("friction", a, dry, speed);
    scene.axis_coulomb_friction("rubbing", Axis::difference(a, ratio * 0.02, b), dry * 0.5, speed);
    scene.axis_end_stop("stop", b, limits, law);
    scene.axis_end_stop("second stop", Axis::difference(b, 0.5, a), [limits[0] + 0.75, limits[1] + 0.5], law);
    if is_kinked {
        scene.axis_end_stop("hard stop", a, [limits[0], limits[1] + 0.1], [law[0], law[1], 0.0.into()]);
    }
    scene.axis_force("gust", b, Harmonic, [free, amplitude, 5.0.into(), 0.3.into()]);
    scene.axis_force("load", offset, Constant, [dry]);
    let drive = scene.driven_axis("drive", c, Harmonic, [0.0.into(), amplitude, 6.0.into(), FRAC_PI_2.into()]);
    let relation = scene.linear_relation("screw", [(offset, 1.0.into()), (a, -pitch)], pitch * -0.25);
    scene.cost("end", Effort { is_of_reaction }, Sum::Terminal, [a, b], [drive[0], relation[0]], [], []);
    scene.cost("run", Effort { is_of_reaction }, Sum::Integral, [b, a], [drive[0], relation[0]], [], []);
    let output = scene.output("middle");
    scene.term(output, "middle", Effort { is_of_reaction }, Sum::Node(7), [b, a], [drive[0], relation[0]], [], []);
    Arm { system: scene.compile().expect("an arm"), hinges, drive }
}

fn inputs(arm: &Arm, steps: usize) -> Inputs {
    let mut inputs = Inputs::at_rest(&arm.system, Grid::uniform(steps, 0.01));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 2.0 * (0.4 * i as f64).sin());
    inputs.start = Start::assembled(&arm.system).hold(&arm.hinges[..2]);
    inputs
}

#[test]
fn gradients_are_exact_with_all_parts() {
    let arm = arm([true; 2]);
    assert_eq!((arm.system.n(), arm.system.m(), arm.system.event_name(0)), (4, 2, "hard stop"));
    for scheme in Scheme::ALL {
        let settings = Settings { scheme, ..Settings::default() };
        assert_gradient_is_exact_with(scheme.name, &arm.system, &inputs(&arm, 20), settings);
    }
    let gradient = gradient(&arm.system, &inputs(&arm, 20), Settings::default()).expect("a gradient");
    println!("{}", gradient.design);
    assert!(gradient.design.len() == 14 && gradient.design.iter().all(|of| of.abs() > 1e-6));
    let restarted = Settings { rebase_every: 3, drift_bound: 0.0, ..Settings::default() };
    assert_gradient_is_exact_with("restarts", &arm.system, &inputs(&arm, 20), restarted);
}

#[test]
fn products_are_exact_with_all_parts() -> Result<(), Error> {
    for scheme in [Settings::default().scheme, Scheme::ESDIRK4] {
        let arm = arm([false; 2]);
        assert_products_are_exact(&arm.system, &inputs(&arm, 20), Settings { scheme, ..Settings::default() })?;
    }
    Ok(())
}

#[test]
fn a_drive_gives_the_torque_that_a_motor_needs() -> Result<(), Error> {
    let arm = arm([true; 2]);
    let given = inputs(&arm, 20);
    let mut solver = Solver::new(&arm.system, Settings::default());
    let motion = solver.simulate(&given)?.clone();
    let mut scene = Scene::new();
    let (hinges, offset) = links(&mut scene);
    let torques = hinges.map(|hinge| scene.control(&format!("torque {}", hinge.index())));
    hinges.iter().zip(torques).for_each(|(hinge, u)| scene.motor(&format!("motor {}", hinge.index()), *hinge, u));
    scene.driven_axis("rail", offset, Constant, [0.0.into()]);
    let free = scene.compile()?;
    let mut scene = Scene::new();
    let (hinges, offset) = links(&mut scene);
    let harmonic = [0.0, 0.1, 6.0, FRAC_PI_2].map(Into::into);
    let drives = hinges.map(|hinge| scene.driven_axis(&format!("drive {}", hinge.index()), hinge, Harmonic, harmonic));
    scene.driven_axis("rail", offset, Constant, [0.0.into()]);
    let held = scene.compile()?;
    for t in [0.0, 0.1, 0.7] {
        let phase: f64 = 6.0 * t + FRAC_PI_2;
        let (angle, rate, change) = (0.1 * phase.sin(), 0.6 * phase.cos(), -3.6 * phase.sin());
        let (q, v) = ([angle, angle, angle, 0.0], [rate, rate, rate, 0.0]);
        let (driven, lambda) = Mechanics::new(&held, &q, &v)?.at_time(t)?.accelerations()?;
        assert!(driven.iter().take(3).all(|own| (own - change).abs() < 1e-11), "{driven}");
        let torques = drives.map(|drive| -lambda[drive[0].index()]);
        assert!(torques.iter().all(|torque| torque.abs() > 1e-3));
        let own = Mechanics::new(&free, &q, &v)?.with_controls(&torques)?.accelerations()?.0;
        assert!((own - driven).amax() < 1e-11, "{t}");
    }
    // The drive of the arm turns its hinge as told.
    let (c, last) = (arm.hinges[2].index(), motion.last());
    assert!((motion.q[(c, last)] - 0.1 * (6.0 * motion.times[last] + FRAC_PI_2).sin()).abs() < 1e-3);
    assert!(motion.sigma[(arm.drive[0].index(), last)].abs() > 1e-3);
    Ok(())
}

/// The parts of a chain of two bodies, which turn about parallel axes.
#[derive(Clone, Copy, Debug)]
enum By {
    PlanarParts,
    PlanarAxes,
    Space,
}

const NUMBERS: [f64; 3] = [4.0, 0.1, 0.2];
const LIMITS: [f64; 2] = [-0.2, 0.25];
const LAWS: [[f64; 3]; 2] = [[40.0, 0.3, 0.05], [30.0, 0.2, 0.0]];

/// Parts along the angle of the first body and the angle between both.
fn along(scene: &mut Scene, [first, between]: [Axis; 2], speeds: Option<f64>) {
    let [c, free, d] = NUMBERS;
    let torque = scene.control("torque");
    scene.motor("motor", between.clone(), torque);
    scene.axis_spring_damper("spring", between.clone(), c, free, d);
    scene.axis_spring_damper("viscous", first.clone(), 0.0, 0.0, 0.3);
    scene.axis_coulomb_friction("dry", between.clone(), 0.7, 0.2);
    scene.axis_end_stop("stop", between.clone(), LIMITS.map(Into::into), LAWS[0].map(Into::into));
    scene.axis_end_stop("hard", first.clone(), LIMITS.map(Into::into), LAWS[1].map(Into::into));
    scene.axis_force("moment", first, Constant, [0.4.into()]);
    if let Some(speed) = speeds {
        scene.driven_axis("drive", between, ConstantSpeed, [0.5.into(), speed.into()]);
    }
}

fn chain(by: By, speed: Option<f64>) -> System {
    let mut scene = Scene::new();
    if let By::Space = by {
        let mut space = scene.spatial();
        space.gravity([0.0, -9.81, 0.0]);
        let [first, second] = ["first", "second"].map(|name| space.body(name, Inertia::principal(1.2, [0.3, 0.4, 0.1])));
        let a = space.revolute("a", spatial::Body::GROUND.origin(), first.at([-0.5, 0.0, 0.2])).angle;
        let b = space.revolute("b", first.at([0.5, 0.0, 0.0]), second.at([-0.4, 0.1, 0.0])).angle;
        along(&mut scene, [a.into(), b.into()], speed);
        return scene.compile().expect("a chain");
    }
    scene.gravity(0.0, -9.81);
    let ground = planar::Body::GROUND;
    let [first, second] = ["first", "second"].map(|name| scene.body(name, 1.2, 0.1, [0.0; 3]));
    scene.revolute("a", ground.at(0.0, 0.0), first.at(-0.5, 0.0));
    scene.revolute("b", first.at(0.5, 0.0), second.at(-0.4, 0.1));
    if let By::PlanarAxes = by {
        let [p, q] = [first, second].map(|body| body.coordinates[2]);
        along(&mut scene, [p.into(), Axis::difference(p, 1.0, q)], speed);
    } else {
        let [c, free, d] = NUMBERS;
        let torque = scene.control("torque");
        scene.torque_actuator("motor", first, second, torque);
        scene.torsional_spring_damper("spring", first, second, c, free, d);
        scene.joint_friction("viscous", ground, first, 0.3);
        scene.coulomb_friction("dry", first, second, 0.7, 0.2);
        scene.end_stop("stop", first, second, LIMITS.map(Into::into), LAWS[0].map(Into::into));
        scene.end_stop("hard", ground, first, LIMITS.map(Into::into), LAWS[1].map(Into::into));
        scene.applied_torque("moment", first, Constant, [0.4.into()]);
        if let Some(speed) = speed {
            scene.driven_angle("drive", first, second, ConstantSpeed, [0.5.into(), speed.into()]);
        }
    }
    scene.compile().expect("a chain")
}

/// Angular accelerations and the reaction of the drive, if there is one.
fn moving(by: By, angles: [f64; 2], rates: [f64; 2], is_driven: bool) -> Result<Vec<f64>, Error> {
    let system = chain(by, is_driven.then_some(rates[1] - rates[0]));
    let (q, v) = if let By::Space = by {
        (vec![angles[0], angles[1] - angles[0]], vec![rates[0], rates[1] - rates[0]])
    } else {
        let [(s, c), (s_2, c_2)] = angles.map(f64::sin_cos);
        let [w, w_2] = rates;
        let along = [0.4 * c_2 + 0.1 * s_2, 0.4 * s_2 - 0.1 * c_2];
        let q = vec![0.5 * c, 0.5 * s, angles[0], c + along[0], s + along[1], angles[1]];
        let second = [-s * w - along[1] * w_2, c * w + along[0] * w_2];
        (q, vec![-0.5 * s * w, 0.5 * c * w, w, second[0], second[1], w_2])
    };
    let (acceleration, lambda) = Mechanics::new(&system, &q, &v)?.with_controls(&[0.6])?.accelerations()?;
    let mut found = match by {
        By::Space => vec![acceleration[0], acceleration[0] + acceleration[1]],
        _ => vec![acceleration[2], acceleration[5]],
    };
    found.extend(is_driven.then(|| lambda[lambda.len() - 1]));
    Ok(found)
}

#[test]
fn parts_along_an_axis_move_a_chain_as_planar_parts_do() -> Result<(), Error> {
    let states = [([0.3, 0.8], [0.4, -0.3]), ([-0.4, -0.1], [-1.2, 0.9]), ([0.1, -0.4], [0.7, 0.75])];
    for (angles, rates) in states {
        for is_driven in [false, true] {
            let expected = moving(By::PlanarParts, angles, rates, is_driven)?;
            for by in [By::PlanarAxes, By::Space] {
                let own = moving(by, angles, rates, is_driven)?;
                let error = largest_difference(&own, &expected);
                assert!(error < 1e-11, "{by:?}: {own:?} for {expected:?}");
            }
        }
    }
    Ok(())
}

/// The square of a coordinate, moved.
struct Far;

impl Cost<1> for Far {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        (at.q[0] - 10.0).powi(2)
    }
}

/// A wheel that a part of this name slows down.
fn wheel(add: impl FnOnce(&mut Scene, planar::Body)) -> System {
    let mut scene = Scene::new();
    let wheel = scene.body("wheel", 1.0, 1.0, [0.0; 3]);
    scene.revolute("axle", planar::Body::GROUND.at(0.0, 0.0), wheel.at(0.0, 0.0));
    let torque = scene.control("torque");
    scene.motor("motor", wheel.coordinates[2], torque);
    add(&mut scene, wheel);
    scene.cost("end", Far, Sum::Terminal, [wheel.coordinates[2]], [], [], []);
    scene.compile().expect("a wheel")
}

/// The kinds of warnings of a gradient that name an element, and these elements.
fn warned(system: &System, steps: usize) -> Result<Vec<(&'static str, String)>, Error> {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 1.0 / steps as f64));
    inputs.controls.fill(-3.0);
    inputs.start.rate_mut()[2] = 1.3337;
    let named = |warning: &Warning| match warning {
        Warning::GridPhase { element, .. } => Some(("phase", element.clone())),
        Warning::UnresolvedElement { element, .. } => Some(("unresolved", element.clone())),
        _ => None,
    };
    Ok(gradient(system, &inputs, Settings::default())?.warnings.iter().filter_map(named).collect())
}

#[test]
fn parts_that_steps_do_not_resolve_are_named() -> Result<(), Error> {
    let ground = planar::Body::GROUND;
    let dry = |speed: f64| {
        [
            wheel(|scene, wheel| scene.axis_coulomb_friction("part", wheel.coordinates[2], 1.0, speed)),
            wheel(|scene, wheel| scene.coulomb_friction("part", ground, wheel, 1.0, speed)),
        ]
    };
    let stop = |stiffness: f64, width: f64| {
        let (limits, law) = ([-1.0, 0.1].map(Into::into), [stiffness, 0.0, width].map(Into::into));
        [
            wheel(|scene, wheel| scene.axis_end_stop("part", wheel.coordinates[2], limits, law)),
            wheel(|scene, wheel| scene.end_stop("part", ground, wheel, limits, law)),
        ]
    };
    for (systems, kinds) in [
        (dry(3e-6), &["phase", "unresolved"][..]),
        (dry(0.05), &[]),
        (stop(1e6, 0.0), &["phase", "unresolved"]),
        (stop(1e6, 1e-5), &["phase", "unresolved"]),
        (stop(2e3, 0.02), &[]),
    ] {
        let [own, planar] = [warned(&systems[0], 1000)?, warned(&systems[1], 1000)?];
        println!("{own:?}");
        assert_eq!(own, planar);
        assert!(own.iter().all(|(_, element)| element == "part"));
        assert_eq!(own.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), kinds);
    }
    Ok(())
}

#[test]
fn a_stop_without_a_width_is_an_event() -> Result<(), Error> {
    let law = |width: f64| [800.0.into(), 0.0.into(), width.into()];
    let stop = |width: f64| {
        wheel(|scene, wheel| {
            scene.axis_end_stop("stop", wheel.coordinates[2], [-0.3, 0.5].map(Into::into), law(width));
        })
    };
    assert_eq!(stop(0.01).events(), 0);
    let system = stop(0.0);
    assert_eq!(system.event_name(0), "stop");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.005));
    inputs.start.rate_mut()[2] = 2.0;
    let mut solver = Solver::new(&system, Settings::default());
    let phases = solver.find_phases(&inputs, 20)?;
    assert_eq!(phases.events.len(), 2);
    let motion = solver.simulate(&phases)?;
    assert!(phases.events.iter().all(|touch| (motion.q[(2, touch.node)] - 0.5).abs() < 1e-12));
    assert_gradient_is_exact_with("a located stop", &system, &phases, Settings::default());
    Ok(())
}

#[test]
fn bad_parts_are_refused_with_the_names_of_their_coordinates() {
    let refused = |add: &dyn Fn(&mut Scene, [Coordinate; 2])| {
        let mut scene = Scene::new();
        let q = scene.coordinates("wheels", ["a", "b"]);
        q.iter().enumerate().for_each(|(k, q)| scene.rotor(&format!("wheel {k}"), *q, 1.0, 1.0));
        add(&mut scene, q);
        scene.compile().expect_err("a part that is wrong")
    };
    let error = refused(&|scene, [a, _]| scene.rotor("rotor", a, -0.1, 3.0));
    let must_be = "finite and not negative";
    assert_eq!(error, Error::Parameter { what: "the inertia of `rotor` along `wheels.a`".into(), value: -0.1, must_be });
    let error = refused(&|scene, [a, _]| {
        let inertia = scene.design("inertia", -0.2);
        scene.rotor("rotor", a, inertia * 0.5, 3.0);
    });
    assert_says(&error, &["the inertia of `rotor` along `wheels.a` is -0.1"]);
    let error = refused(&|scene, [a, b]| {
        scene.axis_spring_damper("belt", Axis::difference(a, 2.0, b), 1.0, 0.0, f64::NAN);
    });
    assert_says(&error, &["`damping` of `belt` along `wheels.a`, `wheels.b` is NaN"]);
    let error = refused(&|scene, [_, b]| scene.axis_coulomb_friction("dry", b, 1.0, 0.0));
    assert_says(&error, &["the speed of `dry` along `wheels.b` is 0", "positive"]);
    let (law, smooth) = ([1.0, 0.0, 0.0].map(Into::into), [1.0, 0.0, -0.1].map(Into::into));
    let error = refused(&|scene, [a, _]| scene.axis_end_stop("stop", a, [0.2, 0.1].map(Into::into), law));
    assert_says(&error, &["the upper limit minus the lower limit of `stop` along `wheels.a`", "positive"]);
    let error = refused(&|scene, [a, _]| scene.axis_end_stop("stop", a, [0.1, 0.2].map(Into::into), smooth));
    assert_says(&error, &["the width of `stop`", "positive"]);
    let error = refused(&|scene, [a, _]| scene.axis_spring_damper("belt", Axis::difference(a, 2.0, a), 1.0, 0.0, 0.0));
    let element = "belt (spring)".into();
    assert_eq!(error, Error::RepeatedCoordinate { element, coordinate: "wheels.a".into() });

    let [far, _] = Scene::new().coordinates("far", ["a", "b"]);
    let mut other = Scene::new();
    let number = other.design("far", 1.0);
    type Adder<'a> = (&'a str, &'static str, &'a dyn Fn(&mut Scene, [Coordinate; 2]));
    let foreign: [Adder; 9] = [
        ("part", "coordinate", &|scene, _| scene.rotor("part", far, 1.0, 1.0)),
        ("part (spring)", "coordinate", &|scene, _| scene.axis_spring_damper("part", far, 1.0, 0.0, 0.0)),
        ("part", "coordinate", &|scene, _| scene.axis_coulomb_friction("part", far, 1.0, 1.0)),
        ("part", "coordinate", &|scene, _| scene.axis_end_stop("part", far, [0.1, 0.2].map(Into::into), law)),
        ("part", "coordinate", &|scene, _| scene.axis_force("part", far, Constant, [1.0.into()])),
        ("part", "coordinate", &|scene, _| _ = scene.driven_axis("part", far, Constant, [1.0.into()])),
        ("part", "coordinate", &|scene, [a, _]| _ = scene.linear_relation("part", [(a, 1.0), (far, 1.0)], 0.0)),
        ("part", "design variable", &|scene, [a, b]| scene.rotor("part", Axis::difference(a, number, b), 1.0, 1.0)),
        ("part", "design variable", &|scene, [a, _]| scene.axis_coulomb_friction("part", a, number, 1.0)),
    ];
    for (element, kind, add) in foreign {
        assert_eq!(refused(add), Error::Foreign { element: element.into(), kind });
    }
}
