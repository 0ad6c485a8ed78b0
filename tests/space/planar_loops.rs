//! Loops of bodies in space that move in a plane: some equations of the closing joints follow from others, or hold at all positions.

use hamiltonian_adjoint::planar::{self, Harmonic};
use hamiltonian_adjoint::spatial::{Body, Inertia, Marker, Spatial};
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Error, Grid, Inputs, Mechanics, Multiplier, Param, Scalar, Scene, Scheme, Settings, Solver,
    Start, Sum, System,
};
use nalgebra::{SVector, Vector3};

use crate::common::{assert_gradient_is_exact_with, assert_says, largest_difference, relative_error};

const AXES: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.3, 0.2, 0.9]];
const LENGTHS: [f64; 4] = [0.2, 0.6, 0.5, 0.7];
const GUESS: [f64; 3] = [1.0, -0.6, -1.9];

/// How the last bar is joined to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Closing {
    /// By two independent equations.
    Line,
    Hinge,
    Ball,
    /// By a ball joint whose axes are not those of the plane.
    SkewBall,
}

/// sin q + ½ v² of three angles.
struct Swing;

impl Cost<3, 0, 0, 0> for Swing {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _b: &SVector<S, 0>) -> S {
        (0..3).map(|i| at.q[i].sin() + at.v[i] * at.v[i] * 0.5).sum()
    }
}

/// sin q + ½ v² of one coordinate.
struct One;

impl Cost<1, 0, 0, 0> for One {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0].sin() + at.v[0] * at.v[0] * 0.5
    }
}

/// q − a, for an event.
struct Above(f64);

impl Cost<1, 0, 0, 0> for Above {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] - self.0
    }
}

/// The axes of the plane, and its normal.
fn plane(normal: [f64; 3]) -> [Vector3<f64>; 3] {
    let z = Vector3::from(normal).normalize();
    let x = Vector3::new(0.1, 1.0, 0.3).cross(&z).normalize();
    [x, z.cross(&x), z]
}

/// A marker on a bar with the axes of the plane, whose bodies have those of the ground.
fn along(body: Body, distance: impl Into<Param>, [x, _, z]: &[Vector3<f64>; 3]) -> Marker {
    let distance = distance.into();
    body.at((distance * x[0], distance * x[1], distance * x[2])).along_and_toward([z.x, z.y, z.z], [x.x, x.y, x.z])
}

fn bar(length: f64, x: &Vector3<f64>) -> Inertia {
    let centre = x * (length / 2.0);
    Inertia::principal(2.0 * length, [length.powi(3) / 6.0; 3]).centred_at([centre.x, centre.y, centre.z])
}

fn close(space: &mut Spatial, name: &str, closing: Closing, [a, b]: [Marker; 2]) -> Vec<Multiplier> {
    match closing {
        Closing::Line => space.point_on_line(name, a, b).to_vec(),
        Closing::Hinge => space.close_revolute(name, a, b).to_vec(),
        Closing::Ball => space.close_ball(name, a, b).to_vec(),
        Closing::SkewBall => space.close_ball(name, a.along([0.3, -0.5, 0.4]), b).to_vec(),
    }
}

/// A four-bar on a marker of a body; the lengths are the crank, the coupler, the rocker, and the distance on the body.
fn add_four_bar(
    scene: &mut Scene,
    name: &str,
    (base, axes): (Body, &[Vector3<f64>; 3]),
    (lengths, guess): ([Param; 4], [f64; 3]),
    closing: Closing,
) -> ([Coordinate; 3], Vec<Multiplier>) {
    let mut space = scene.spatial();
    let mut outer = along(base, 0.0, axes);
    let mut angles = Vec::new();
    for k in 0..3 {
        let body = space.body(&format!("{name} bar {k}"), bar(LENGTHS[k], &axes[0]));
        angles.push(space.revolute(&format!("{name} hinge {k}"), outer, along(body, 0.0, axes)).angle);
        outer = along(body, lengths[k], axes);
    }
    let (end, to) = (format!("{name} end"), along(base, lengths[3], axes));
    let equations = close(&mut space, &end, closing, [to, outer]);
    angles.iter().zip(guess).for_each(|(angle, guess)| scene.place(*angle, guess));
    ([angles[0], angles[1], angles[2]], equations)
}

/// A four-bar in a plane, with a torque on the crank; gravity acts in the plane.
fn four_bar(normal: [f64; 3], closing: Closing) -> Result<(System, [Coordinate; 3]), Error> {
    let mut scene = Scene::new();
    let axes = plane(normal);
    let gravity = axes[1] * -9.81;
    let torque = scene.control("torque");
    let [coupler, ground] = [1, 3].map(|k| scene.design(&format!("length {k}"), LENGTHS[k]).into());
    scene.spatial().gravity([gravity.x, gravity.y, gravity.z]);
    let lengths = [LENGTHS[0].into(), coupler, LENGTHS[2].into(), ground];
    let (angles, _) = add_four_bar(&mut scene, "loop", (Body::GROUND, &axes), (lengths, GUESS), closing);
    scene.motor("motor", angles[0], torque);
    scene.cost("swing", Swing, Sum::Terminal, angles, [], [], []);
    Ok((scene.compile()?, angles))
}

fn inputs(system: &System, hold: &[Coordinate], grid: Grid) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.start = Start::assembled(system).hold(hold);
    hold.iter().for_each(|q| inputs.start.rate_mut()[q.index()] = 2.0);
    inputs.controls.iter_mut().enumerate().for_each(|(k, u)| *u = 0.5 * (0.2 * k as f64).sin());
    inputs
}

/// The angular accelerations of the bars as bodies in the plane.
fn planar_accelerations(q: &[f64], v: &[f64], torque: f64) -> Result<[f64; 3], Error> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let control = scene.control("torque");
    let (mut place, mut outer, mut angle) = ([0.0; 2], planar::Body::GROUND.at(0.0, 0.0), 0.0);
    let (mut rate, mut moving) = (0.0, [0.0; 2]);
    let (mut bodies, mut all_q, mut all_v) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..3 {
        let (length, half) = (LENGTHS[k], LENGTHS[k] / 2.0);
        (angle, rate) = (angle + q[k], rate + v[k]);
        let (sin, cos) = f64::sin_cos(angle);
        let centre = [place[0] + half * cos, place[1] + half * sin, angle];
        let body = scene.body(&format!("bar {k}"), 2.0 * length, length.powi(3) / 6.0, centre);
        all_q.extend(centre);
        all_v.extend([moving[0] - rate * half * sin, moving[1] + rate * half * cos, rate]);
        scene.revolute(&format!("hinge {k}"), outer, body.at(-half, 0.0));
        outer = body.at(half, 0.0);
        place = [place[0] + length * cos, place[1] + length * sin];
        moving = [moving[0] - rate * length * sin, moving[1] + rate * length * cos];
        bodies.push(body);
    }
    scene.revolute("end", outer, planar::Body::GROUND.at(LENGTHS[3], 0.0));
    scene.torque_actuator("motor", planar::Body::GROUND, bodies[0], control);
    let system = scene.compile()?;
    let found = Mechanics::new(&system, &all_q, &all_v)?.with_controls(&[torque])?.accelerations()?.0;
    Ok([found[2], found[5] - found[2], found[8] - found[5]])
}

fn warnings(solver: &Solver) -> String {
    solver.report().warnings.iter().map(|warning| format!("{warning}\n")).collect()
}

#[test]
fn a_four_bar_in_space_moves_like_one_in_the_plane() -> Result<(), Error> {
    for normal in AXES {
        for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
            let settings = Settings { scheme, ..Settings::default() };
            let (system, [crank, ..]) = four_bar(normal, Closing::Line)?;
            let mut reference = Solver::new(&system, settings);
            let expected = reference.simulate(&inputs(&system, &[crank], Grid::uniform(100, 0.01)))?.q.clone();
            for closing in [Closing::Hinge, Closing::Ball, Closing::SkewBall] {
                let what = format!("{closing:?} about {normal:?}");
                let (system, [crank, ..]) = four_bar(normal, closing)?;
                let inputs = inputs(&system, &[crank], Grid::uniform(100, 0.01));
                let mut solver = Solver::new(&system, settings);
                let motion = solver.simulate(&inputs)?;
                let error = largest_difference(motion.q.as_slice(), expected.as_slice());
                println!("{what}: {error:.1e}");
                print!("{}", warnings(&solver));
                // Without a row that is zero, all three equations have a compliance.
                assert!(error < if closing == Closing::SkewBall { 1e-9 } else { 1e-11 }, "{what}: {error:.1e}");
                assert!(warnings(&solver).contains("`loop end` (equation 2)"));
                assert_eq!(solver.report().warnings.len(), 1);
                let motion = solver.trajectory().clone();
                let here = Mechanics::at_start(&system, &inputs)?;
                let planar = planar_accelerations(motion.q.column(0).as_slice(), motion.v.column(0).as_slice(), 0.0)?;
                let error = relative_error(here.accelerations()?.0.as_slice(), &planar);
                println!("{what}: accelerations {error:.1e}");
                assert!(error < 1e-12, "{what}: accelerations {error:.1e}");
                if closing == Closing::Hinge {
                    let sigma = motion.sigma.rows(2, 3).amax();
                    assert!(sigma < 1e-12, "{what}: {sigma:.1e}");
                }
            }
        }
    }
    Ok(())
}

#[test]
fn gradients_of_loops_with_equations_that_always_hold_are_exact() -> Result<(), Error> {
    for normal in [AXES[0], AXES[2]] {
        for closing in [Closing::Hinge, Closing::Ball, Closing::SkewBall] {
            for holds in [true, false] {
                let (system, [crank, ..]) = four_bar(normal, closing)?;
                let inputs = inputs(&system, &[crank][..usize::from(holds)], Grid::uniform(10, 0.01));
                for settings in [
                    Settings::default(),
                    Settings { scheme: Scheme::ESDIRK4, ..Settings::default() },
                    Settings { drift_bound: 0.0, ..Settings::default() },
                ] {
                    let what = format!("{closing:?} about {normal:?}, held {holds}, {}", settings.drift_bound);
                    assert_gradient_is_exact_with(&what, &system, &inputs, settings);
                }
            }
        }
    }
    Ok(())
}

#[test]
fn a_door_with_two_hinges() -> Result<(), Error> {
    for axis in AXES {
        let door = |hinges: usize, off: f64| {
            let mut scene = Scene::new();
            let axes = plane(axis);
            let mut space = scene.spatial();
            space.gravity([1.0, 2.0, -9.81]);
            let door = space.body("door", bar(0.8, &axes[0]));
            let angle = space.revolute("hinge 0", along(Body::GROUND, 0.0, &axes), along(door, 0.0, &axes)).angle;
            for k in 1..hinges {
                let [place, shifted] = [0.0, off].map(|off| axes[2] * (k as f64 + off) + axes[0] * off);
                let [ground, moving] =
                    [(Body::GROUND, place), (door, shifted)].map(|(body, p)| body.at([p.x, p.y, p.z]).along(axis));
                space.close_revolute(&format!("hinge {k}"), ground, moving);
            }
            scene.compile().map(|system| (system, angle))
        };
        let motion = |hinges: usize, off: f64, scheme| {
            let (system, angle) = door(hinges, off)?;
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.01));
            inputs.start.rate_mut()[angle.index()] = 1.0;
            let mut solver = Solver::new(&system, Settings { scheme, ..Settings::default() });
            let q = solver.simulate(&inputs)?.q.clone();
            Ok::<_, Error>((q, warnings(&solver)))
        };
        for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
            let expected = motion(1, 0.0, scheme)?.0;
            for hinges in [2, 3] {
                let (q, warnings) = motion(hinges, 0.0, scheme)?;
                let error = largest_difference(q.as_slice(), expected.as_slice());
                println!("{hinges} hinges about {axis:?}: {error:.1e}\n{warnings}");
                assert!(error < 1e-12 && warnings.contains("`hinge 1` (equation 4)"));
            }
        }
        let refused = motion(2, 0.01, Scheme::TRAPEZOIDAL).expect_err("hinges that are not in line");
        assert_says(&refused, &["hinge 1"]);
    }
    Ok(())
}

/// Mechanisms with several loops, or with loops of several kinds of bodies.
#[derive(Clone, Copy, Debug)]
enum Case {
    SideBySide,
    OnAMovingBody,
    Driven,
    PlanarBodies,
    SliderCrank,
    /// A parallelogram with a third crank: equations in the plane depend on each other too.
    ThreeCranks,
    /// A loop that opens at an event.
    Released,
}

fn case(which: Case, closing: Closing) -> Result<(System, Inputs), Error> {
    let (mut scene, mut event_at) = (Scene::new(), None);
    let axes = plane(AXES[2]);
    let length: Param = scene.design("length", LENGTHS[1]).into();
    let lengths = [LENGTHS[0].into(), length, LENGTHS[2].into(), LENGTHS[3].into()];
    let torque = scene.control("torque");
    scene.spatial().gravity([0.3, -9.81, 0.5]);
    let hold = match which {
        Case::SideBySide => {
            let (first, _) = add_four_bar(&mut scene, "loop", (Body::GROUND, &axes), (lengths, GUESS), closing);
            let (other, _) = add_four_bar(&mut scene, "other", (Body::GROUND, &plane(AXES[1])), (lengths, GUESS), closing);
            scene.motor("other motor", other[0], torque);
            vec![first[0], other[0]]
        }
        Case::OnAMovingBody | Case::Driven => {
            let mut space = scene.spatial();
            let table = space.body("table", Inertia::principal(3.0, [0.2, 0.3, 0.4]).centred_at([0.1, 0.2, 0.3]));
            let post = space.universal("post", Body::GROUND.origin(), table.at([0.1, 0.0, 0.4])).angles;
            let (angles, _) = add_four_bar(&mut scene, "loop", (table, &axes), (lengths, GUESS), closing);
            if let Case::Driven = which {
                scene.driven_axis("drive", angles[0], Harmonic, [GUESS[0], 0.4, 3.0, 0.0].map(Into::into));
                post.to_vec()
            } else {
                vec![angles[0], post[0], post[1]]
            }
        }
        Case::PlanarBodies => {
            let [a, b] = [("a", [0.1 * 1f64.cos(), 0.1 * 1f64.sin(), 1.0]), ("b", [0.2, 0.3, 0.4])]
                .map(|(name, place)| scene.body(name, 0.8, 0.02, place));
            scene.revolute("foot", planar::Body::GROUND.at(0.0, 0.0), a.at(-0.1, 0.0));
            scene.revolute("knee", a.at(0.1, 0.0), b.at(-0.3, 0.0));
            let mut space = scene.spatial();
            let (b, to) = (space.planar_body("b in space", b), Body::GROUND.at((length + 0.1, 0.1, 0.0)));
            let rocker = space.body("rocker", bar(0.5, &Vector3::x()));
            let hinge = space.revolute("hinge", b.at([0.3, 0.0, 0.0]), rocker.origin()).angle;
            let end = rocker.at([0.5, 0.0, 0.0]);
            close(&mut space, "loop end", closing, [to, end]);
            scene.place(hinge, -1.9);
            vec![a.coordinates[2]]
        }
        Case::SliderCrank => {
            let mut space = scene.spatial();
            let [crank, rod, slider] = [0.2, 0.6, 0.1].map(|l| space.body(&format!("part {l}"), bar(l, &axes[0])));
            let angle = space.revolute("crank hinge", along(Body::GROUND, 0.0, &axes), along(crank, 0.0, &axes)).angle;
            let knee = space.revolute("knee", along(crank, 0.2, &axes), along(rod, 0.0, &axes)).angle;
            let [x, ..] = axes;
            let rail = [Body::GROUND, slider].map(|body| body.origin().along([x.x, x.y, x.z]));
            let offset = space.prismatic("rail", rail[0], rail[1]).offset;
            let (to, end) = (along(slider, 0.0, &axes), along(rod, length, &axes));
            close(&mut space, "loop end", closing, [to, end]);
            [(angle, 1.0), (knee, -1.3), (offset, 0.65)].into_iter().for_each(|(q, guess)| scene.place(q, guess));
            vec![angle]
        }
        Case::ThreeCranks => {
            let mut space = scene.spatial();
            let bars = [0.2, 0.6, 0.2, 0.2].map(|length| bar(length, &axes[0]));
            let mut body = |k: usize| space.body(&format!("bar {k}"), bars[k]);
            let bodies = [body(0), body(1), body(2), body(3)];
            let on = |k: usize, distance: f64| along(bodies[k], distance, &axes);
            let joints = [(along(Body::GROUND, 0.0, &axes), 0), (on(0, 0.2), 1), (on(1, 0.6), 2), (on(1, 0.3), 3)];
            let angles = joints.map(|(outer, k)| space.revolute(&format!("hinge {k}"), outer, on(k, 0.0)).angle);
            close(&mut space, "loop end", closing, [along(Body::GROUND, 0.6, &axes), on(2, 0.2)]);
            close(&mut space, "middle", closing, [along(Body::GROUND, 0.3, &axes), on(3, 0.2)]);
            let back = 1.0 - std::f64::consts::PI;
            angles.into_iter().zip([1.0, -1.0, back, back]).for_each(|(q, guess)| scene.place(q, guess));
            vec![angles[0]]
        }
        Case::Released => {
            let (angles, equations) = add_four_bar(&mut scene, "loop", (Body::GROUND, &axes), (lengths, GUESS), closing);
            let event = scene.event("release", Above(1.2), [angles[0]], [], [], []);
            scene.open_at(event, &equations);
            event_at = Some(event.at(10));
            vec![angles[0]]
        }
    };
    scene.motor("motor", hold[0], torque);
    scene.cost("swing", One, Sum::Terminal, [hold[0]], [], [], []);
    let system = scene.compile()?;
    let [before, after] = [10, 20].map(|steps| Grid::uniform(steps, 0.01));
    let grid = if event_at.is_some() { before.then(&Grid::new(0.0, vec![0.0])).then(&after) } else { before.then(&after) };
    let mut inputs = inputs(&system, &hold, grid);
    inputs.events = event_at.into_iter().collect();
    Ok((system, inputs))
}

#[test]
fn several_loops_and_loops_on_other_bodies_move_as_if_closed_by_independent_equations() -> Result<(), Error> {
    use Case::{Driven, OnAMovingBody, PlanarBodies, Released, SideBySide, SliderCrank, ThreeCranks};
    for which in [SideBySide, OnAMovingBody, Driven, PlanarBodies, SliderCrank, ThreeCranks, Released] {
        // Compliances of equations in the plane change the motion; how much depends on what else has one.
        let within = if let ThreeCranks = which { 1e-9 } else { 1e-11 };
        for settings in [
            Settings::default(),
            Settings { scheme: Scheme::ESDIRK4, ..Settings::default() },
            Settings { drift_bound: 0.0, ..Settings::default() },
        ] {
            let run = |closing| {
                let (system, inputs) = case(which, closing)?;
                let mut solver = Solver::new(&system, settings);
                let q = solver.simulate(&inputs)?.q.clone();
                if closing == Closing::Hinge {
                    assert_gradient_is_exact_with(&format!("{which:?}"), &system, &inputs, settings);
                }
                Ok::<_, Error>((q, warnings(&solver)))
            };
            let (expected, _) = run(Closing::Line)?;
            for closing in [Closing::Hinge, Closing::Ball] {
                let (q, warnings) = run(closing)?;
                let error = largest_difference(q.as_slice(), expected.as_slice());
                println!("{which:?} {closing:?}: {error:.1e}\n{warnings}");
                assert!(error < within, "{which:?} {closing:?}: {error:.1e}");
                assert!(warnings.contains("`loop end` (equation 2)"));
            }
        }
    }
    Ok(())
}

#[test]
fn loops_that_cannot_close_and_straight_parallelograms_are_named() -> Result<(), Error> {
    for normal in AXES {
        for closing in [Closing::Hinge, Closing::Ball, Closing::SkewBall] {
            // The bars lead out of the plane of their hinges, or are too short.
            for (off, length) in [(0.01, LENGTHS[3]), (0.0, 2.0)] {
                let mut scene = Scene::new();
                let axes = plane(normal);
                let tilted = [axes[0] + axes[2] * off, axes[1], axes[2]];
                let lengths = [LENGTHS[0], LENGTHS[1], LENGTHS[2], length].map(Into::into);
                add_four_bar(&mut scene, "loop", (Body::GROUND, &tilted), (lengths, GUESS), closing);
                let system = scene.compile()?;
                let given = Inputs::at_rest(&system, Grid::uniform(10, 0.01));
                for start in [given.start.clone(), Start::assembled(&system)] {
                    let inputs = Inputs { start, ..given.clone() };
                    let refused = Solver::new(&system, Settings::default()).simulate(&inputs).map(|_| ());
                    assert_says(&refused.expect_err("a loop that cannot close"), &["loop end"]);
                }
            }
            let mut scene = Scene::new();
            let lengths = [0.2, 0.6, 0.2, 0.6].map(Into::into);
            let (axes, flat) = (plane(normal), [0.0, 0.0, -std::f64::consts::PI]);
            add_four_bar(&mut scene, "loop", (Body::GROUND, &axes), (lengths, flat), closing);
            let system = scene.compile()?;
            let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.01));
            let refused = Solver::new(&system, Settings::default()).simulate(&inputs).map(|_| ());
            assert_says(&refused.expect_err("a change point"), &["singular configuration", "loop end"]);
        }
    }
    Ok(())
}

#[test]
fn lengths_out_of_the_plane_break_the_dependence() -> Result<(), Error> {
    let mut scene = Scene::new();
    let axes = plane(AXES[2]);
    let [x, y, z] = axes[2].into();
    let off = scene.design("off", 0.0);
    let mut space = scene.spatial();
    let door = space.body("door", bar(0.5, &axes[0]));
    space.revolute("hinge", along(Body::GROUND, 0.0, &axes), along(door, 0.0, &axes));
    let beside = door.at((off * x, off * y, off * z)).along([x, y, z]);
    space.close_revolute("second hinge", along(Body::GROUND, 0.0, &axes), beside);
    let system = scene.compile()?;
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&Inputs::at_rest(&system, Grid::uniform(5, 0.01)))?;
    assert!(warnings(&solver).contains("any change of `off` alone"), "{}", warnings(&solver));
    Ok(())
}
