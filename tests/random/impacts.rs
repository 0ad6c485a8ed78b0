//! Motions with impacts and with constraints that open and close: contacts that are hit or closed, joints that are released, one or several equations
//! that close at an event and open again.

use std::collections::BTreeSet;

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Error, Event, Inputs, Mechanics, Multiplier, Scalar, Settings, Solver, Sum, System,
    Trajectory,
};
use nalgebra::{SVector, Vector1, Vector2};
use proptest::prelude::*;
use proptest::sample::select;

use crate::build;
use crate::crossed;
use crate::description::{Description, JointKind};
use crate::elements::Reaction;
use crate::exact::Moved;
use crate::regular;

/// What happens at an event, and when.
#[derive(Clone, Copy, Debug)]
pub struct Sought {
    what: What,
    /// The coordinates, the bodies or the multipliers.
    of: [usize; 3],
    /// The share of the nodes after the event before.
    place: f64,
    /// The factor of the steps before it.
    guess: f64,
}

#[derive(Clone, Copy, Debug)]
enum What {
    /// A point of a body hits a line, with this coefficient of restitution.
    Hit { at: [f64; 2], normal: f64, restitution: f64 },
    /// A point of a body stays on a line.
    Land { at: [f64; 2], normal: f64 },
    /// A function of coordinates changes no more.
    Stop { restitution: f64 },
    /// What the event before has hit is hit once more, wherever it is.
    Again { restitution: f64 },
    /// So many functions of coordinates change no more.
    Catch { rows: usize },
    /// So many equations of joints open, at a time or at an angle.
    Release { rows: usize, is_timed: bool },
    /// What the event before has closed opens.
    Leave,
}

/// Φ = w sin(a) + (1 − w) b − c; b = [c, w].
#[derive(Clone, Copy)]
struct Mixture;

impl Mixture {
    fn value<S: Scalar>(q: &Vector2<S>, b: &Vector2<S>) -> S {
        b[1] * q[0].sin() + (S::one() - b[1]) * q[1] - b[0]
    }
}

impl Constraint<2, 1, 2> for Mixture {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector2<S>, _t: S) -> Vector1<S> {
        Vector1::new(Mixture::value(q, b))
    }
}

impl Cost<2, 0, 0, 2> for Mixture {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, b: &Vector2<S>) -> S {
        Mixture::value(&at.q, b)
    }
}

/// t − b, and sin q + v − b.
struct Past;

impl Cost<0, 0, 0, 1> for Past {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, b: &SVector<S, 1>) -> S {
        at.t - b[0]
    }
}

struct Angle;

impl Cost<1, 0, 0, 1> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0].sin() + at.v[0] - b[0]
    }
}

/// h = sin v₀ + v₁² of a node.
struct Rates;

impl Cost<2, 0, 0, 0> for Rates {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v[0].sin() + at.v[1] * at.v[1] * 0.3
    }
}

pub fn scene_with_impacts() -> impl Strategy<Value = (Description, Vec<Sought>)> {
    let restitution = || prop_oneof![Just(0.0), Just(1e-3), Just(0.5), Just(1.0)];
    let at = || [-0.6..0.6, -0.6..0.6];
    let angle = || -3.0..3.0;
    let what = prop_oneof![
        4 => (at(), angle(), restitution()).prop_map(|(at, normal, restitution)| What::Hit { at, normal, restitution }),
        2 => (at(), angle()).prop_map(|(at, normal)| What::Land { at, normal }),
        1 => restitution().prop_map(|restitution| What::Stop { restitution }),
        1 => restitution().prop_map(|restitution| What::Again { restitution }),
        2 => (1..=3usize).prop_map(|rows| What::Catch { rows }),
        3 => (1..=3usize, any::<bool>()).prop_map(|(rows, is_timed)| What::Release { rows, is_timed }),
        2 => Just(What::Leave),
    ];
    let guess = prop_oneof![2 => Just(1.0), 1 => 0.3..2.0];
    let event = (what, [0..60usize, 0..60usize, 0..60usize], 0.0..0.6, guess);
    let event = event.prop_map(|(what, of, place, guess)| Sought { what, of, place, guess });
    let scene = prop_oneof![3 => regular::description(), 3 => crossed::description(), 1 => regular::redundant()];
    let iterations = select(vec![None, None, Some(3), Some(5)]);
    (scene, proptest::collection::vec(event, 1..=4), iterations).prop_map(|(mut description, events, iterations)| {
        let run = &mut description.run;
        run.tolerance = None;
        let sign = run.steps[0].signum();
        run.steps.iter_mut().for_each(|dt| *dt = dt.copysign(sign));
        if events.iter().any(|event| matches!(event.what, What::Again { .. })) {
            run.settings.position_tolerance = 10.0;
        }
        if let Some(max_iterations) = iterations {
            run.settings = Settings { max_iterations, max_halvings: 6, ..run.settings };
        }
        (description, events)
    })
}

/// Errors of events that do not come, or of too few nodes for them.
pub fn is_of_events(error: &Error) -> bool {
    matches!(
        error,
        Error::EventNotReached { .. } | Error::EventAtEnd { .. } | Error::EventNotLocated { .. } | Error::ClosesApart { .. }
    )
}

/// An event of a scene, the equations that it changes and the numbers of their levels among the design variables.
struct Placed {
    event: Event,
    equations: Vec<Multiplier>,
    levels: Vec<usize>,
    restitution: Option<f64>,
    kind: &'static str,
}

/// The scene of a description with its events; costs at events are added if there are so many of them.
fn build_scene(description: &Description, sought: &[Sought], costs_at: usize) -> (build::Built, Vec<Placed>) {
    let mut built = build::scene(description);
    let mut placed: Vec<Placed> = Vec::new();
    let mut levels = description.designs.len();
    let (coordinates, joints) = (built.coordinates.clone(), built.multipliers.clone());
    for (k, &Sought { what, of, .. }) in sought.iter().enumerate() {
        let scene = &mut built.scene;
        let coordinate = |i: usize| coordinates[i % coordinates.len()];
        let mut design = |scene: &mut hamiltonian_adjoint::Scene, name: &str| {
            levels += 1;
            (scene.design(&format!("{name} {k}"), 0.0), levels - 1)
        };
        let name = format!("event {k}");
        let of_part = &built.parts[of[0] % built.parts.len()];
        let is_loose = built.parts.len() < 2 || of_part.frame.coordinates().is_none();
        let what = match what {
            What::Hit { restitution, .. } if is_loose => What::Stop { restitution },
            What::Land { .. } if is_loose => What::Catch { rows: 1 },
            What::Release { rows, .. } if joints.is_empty() => What::Catch { rows },
            What::Again { restitution } if placed.last().is_none_or(|last| last.restitution.is_none()) => {
                What::Stop { restitution }
            }
            What::Leave if placed.last().is_none_or(|last| last.restitution.is_some()) => What::Catch { rows: 2 },
            what => what,
        };
        match what {
            What::Hit { at, normal, .. } | What::Land { at, normal } => {
                let (level, number) = design(scene, "level");
                let foot = Body::GROUND.at(level * normal.cos(), level * normal.sin());
                let contact = scene.rigid_contact(&name, foot, normal, of_part.frame.at(at[0], at[1]));
                let restitution = match what {
                    What::Hit { restitution, .. } => {
                        let (e, _) = design(scene, "restitution");
                        scene.impact_at(contact.event, contact.equation, e + restitution);
                        Some(restitution)
                    }
                    _ => {
                        scene.close_at(contact.event, &[contact.equation]);
                        None
                    }
                };
                let kind = if restitution.is_some() { "hit" } else { "land" };
                placed.push(Placed {
                    event: contact.event,
                    equations: vec![contact.equation],
                    levels: vec![number],
                    restitution,
                    kind,
                });
            }
            What::Stop { .. } | What::Catch { .. } => {
                let (rows, restitution) = match what {
                    What::Stop { restitution } => (1, Some(restitution)),
                    What::Catch { rows } => (rows, None),
                    _ => (1, None),
                };
                let (mut equations, mut numbers, mut event) = (Vec::new(), Vec::new(), None);
                for row in 0..rows {
                    let (level, number) = design(scene, &format!("level of row {row}"));
                    let [a, b] = [coordinate(of[1] + 2 * row), coordinate(of[2] + row)];
                    let (q, w) = ([a, if a == b { coordinate(of[2] + row + 1) } else { b }], 0.2 + 0.3 * row as f64);
                    let q = if q[0] == q[1] { return (built, placed) } else { q };
                    let [equation] = scene.constraint(&format!("{name}, {row}"), Mixture, q, [level.into(), w.into()]);
                    equations.push(equation);
                    numbers.push(number);
                    event.get_or_insert_with(|| scene.event(&name, Mixture, q, [], [], [level.into(), w.into()]));
                }
                let Some(event) = event else { continue };
                match restitution {
                    Some(e) => scene.impact_at(event, equations[0], e),
                    None => scene.close_at(event, &equations),
                }
                let kind = ["stop", "catch 1", "catch 2", "catch 3"][if restitution.is_some() { 0 } else { rows }];
                placed.push(Placed { event, equations, levels: numbers, restitution, kind });
            }
            What::Release { .. } | What::Leave | What::Again { .. } => {
                let (level, number) = design(scene, "level");
                let (equations, is_timed, kind) = match what {
                    What::Release { rows, is_timed } => {
                        let rows: BTreeSet<usize> = (0..rows).map(|row| (of[0] + row) % joints.len()).collect();
                        (rows.into_iter().map(|row| joints[row]).collect(), is_timed, "release")
                    }
                    What::Again { .. } => (placed[placed.len() - 1].equations.clone(), true, "again"),
                    _ => (placed[placed.len() - 1].equations.clone(), true, "leave"),
                };
                let event = match is_timed {
                    true => scene.event(&name, Past, [], [], [], [level.into()]),
                    false => scene.event(&name, Angle, [coordinate(of[1])], [], [], [level.into()]),
                };
                let restitution = match what {
                    What::Again { restitution } => {
                        scene.impact_at(event, equations[0], restitution);
                        Some(restitution)
                    }
                    _ => {
                        scene.open_at(event, &equations);
                        None
                    }
                };
                placed.push(Placed { event, equations, levels: vec![number], restitution, kind });
            }
        }
    }
    for k in 0..costs_at {
        if coordinates.len() > 1 {
            let q = [coordinates[k % coordinates.len()], coordinates[(k + 1) % coordinates.len()]];
            built.scene.cost(&format!("rates after {k}"), Rates, Sum::AfterEvent(k), q, [], [], []);
            built.scene.cost(&format!("rates before {k}"), Rates, Sum::Event(k), q, [], [], []);
        }
        if description.redundant.is_empty() {
            let sigma = [placed[k].equations[0]];
            built.scene.cost(&format!("impulse {k}"), Reaction, Sum::AfterEvent(k), [], sigma, [], [0.01.into()]);
        }
    }
    (built, placed)
}

/// The motion with its events; `Ok(Err(None))` if there are none.
///
/// # Errors
/// What is wrong with the motion.
pub fn run(
    description: &Description,
    sought: &[Sought],
    count: impl Fn(&str),
) -> Result<Result<Moved, Option<Error>>, String> {
    let (built, placed) = build_scene(description, sought, 0);
    let start = built.scene.compile().and_then(|system| {
        let inputs = build::inputs(&description.run, &system, &built.inertia)?;
        Ok((system, inputs))
    });
    let (system, mut inputs) = match start {
        Ok(start) => start,
        Err(error) => return Ok(Err(Some(error))),
    };
    let mut solver = Solver::new(&system, description.run.settings);
    if let Err(error) = solver.simulate(&inputs) {
        return Ok(Err(Some(error)));
    }
    let mut end = 0;
    for (k, of) in sought.iter().enumerate().take(placed.len()) {
        let Some(after) = add(&mut inputs, &system, &solver, (&placed[k], of), end) else { break };
        if let Err(error) = see_rows_closed(&mut solver, &mut inputs, &placed[k]) {
            count(placed[k].kind);
            return Ok(Err(Some(error)));
        }
        end = after;
    }
    drop(solver);
    if inputs.events.is_empty() {
        return Ok(Err(None));
    }
    let (built, placed) = build_scene(description, sought, inputs.events.len());
    let system = match built.scene.compile() {
        Ok(system) => system,
        Err(error) => return Ok(Err(Some(error))),
    };
    let known: Vec<_> = inputs.events.iter().map(|of| system.event(of.event.index()).at(of.node)).collect();
    inputs.events = known;
    inputs.open = inputs.open.iter().map(|of| system.multiplier(of.index())).collect();
    let mut solver = Solver::new(&system, description.run.settings);
    if let Err(error) = solver.simulate(&inputs) {
        return Ok(Err(Some(error)));
    }
    check(description, &system, &solver, &placed, &inputs)?;
    inputs.events.iter().enumerate().for_each(|(k, _)| count(placed[k].kind));
    let gradient = match solver.gradient() {
        Ok(gradient) => gradient.clone(),
        Err(error) => return Ok(Err(Some(error))),
    };
    drop(solver);
    Ok(Ok(Moved { system, inputs, gradient }))
}

/// Adds an event between two nodes of the current motion, behind a node, with its steps of length zero. Returns the node at their end; none if there
/// is no place for it.
fn add(
    inputs: &mut Inputs,
    system: &System,
    solver: &Solver,
    (placed, sought): (&Placed, &Sought),
    end: usize,
) -> Option<usize> {
    let (motion, stages) = (solver.trajectory(), inputs.grid.stages);
    let left = (inputs.grid.steps.len() - end) / stages;
    let node = end + stages * (1 + (sought.place * left as f64) as usize);
    if node + stages > inputs.grid.steps.len() {
        return None;
    }
    let value = |node: usize, row: usize| -> Option<f64> {
        let column = motion.column_of(node);
        let at = Mechanics::at_node(system, solver.inputs(), motion, column).ok()?;
        let q = sought.of[1] % system.n();
        Some(match (placed.kind, sought.what) {
            ("release", What::Release { is_timed: false, .. }) => motion.q[(q, column)].sin() + motion.v[(q, column)],
            ("release" | "leave" | "again", _) => motion.times[column],
            _ => at.phi()[placed.equations[row].index()],
        })
    };
    let [earlier, there] = [value(node - stages, 0)?, value(node, 0)?];
    // A gap is an event only where it comes from above.
    let is_gap = matches!(placed.kind, "hit" | "land");
    if (there - earlier).abs() < 1e-5 || is_gap && there > earlier {
        return None;
    }
    inputs.design[placed.levels[0]] += there + 0.37 * (earlier - there);
    for (row, level) in placed.levels.iter().enumerate().skip(1) {
        inputs.design[*level] += value(node, row)?;
    }
    inputs.grid.steps[end..node].iter_mut().for_each(|dt| *dt *= sought.guess);
    let zeros = stages * if placed.restitution.is_some() { 2 } else { 1 };
    inputs.grid.steps.splice(node..node, vec![0.0; zeros]);
    inputs.controls = inputs.controls.clone().insert_columns(node + 1, zeros, 0.3);
    inputs.events.push(placed.event.at(node));
    Some(node + zeros)
}

/// Simulates, and moves the levels of further equations that close at the last event such that they are satisfied there.
fn see_rows_closed(solver: &mut Solver, inputs: &mut Inputs, placed: &Placed) -> Result<(), Error> {
    for _ in 0..2 * placed.levels.len() {
        match solver.simulate(inputs).map(|_| ()) {
            Err(Error::ClosesApart { equation, violation, .. }) => {
                let row = equation.split(", ").nth(1).and_then(|row| row.trim_end_matches('`').parse::<usize>().ok());
                let row = row.unwrap_or(0);
                inputs.design[placed.levels[row.min(placed.levels.len() - 1)]] += violation;
            }
            other => return other,
        }
    }
    solver.simulate(inputs).map(|_| ())
}

/// That velocities, energies and multipliers change at the events as they must, and that closed equations hold.
fn check(
    description: &Description,
    system: &System,
    solver: &Solver,
    placed: &[Placed],
    inputs: &Inputs,
) -> Result<(), String> {
    let (motion, settings) = (solver.trajectory(), description.run.settings);
    let rates = motion.phi_dot(system, solver.inputs()).map_err(|error| error.to_string())?;
    let mut joints = description.bodies.iter().map(|bar| bar.joint).chain(description.loops.iter().map(|l| l.joint));
    let is_driven = joints.any(|j| matches!(j.kind, JointKind::ConstantSpeed { .. } | JointKind::Harmonic { .. }));
    let restarts = settings.rebase_every > 0 || settings.drift_bound < f64::INFINITY;
    let bar = |node: usize| 1e-10 * (1.0 + motion.v.column(node).amax());
    let compliances = |node: usize| motion.compliance.iter().rfind(|part| part.from <= node).map(|part| &part.equations[..]);
    for node in 0..motion.computed {
        let compliances = compliances(node).unwrap_or(&[]);
        let is_closed = |j: &usize| !compliances.iter().any(|(k, _)| k == j);
        if let Some(j) = (0..system.m()).filter(is_closed).find(|&j| rates[(j, node)].abs() > bar(node)) {
            return Err(format!("dΦ/dt = {:e} of closed equation {j} at node {node}", rates[(j, node)]));
        }
        let [before, now] = [node.saturating_sub(1), node].map(|node| motion.sigma.column(node));
        let is_same = |j: usize| (now[j] - before[j]).abs() <= 1e-12 * now[j].abs() + 1e-20;
        // An equation that has just opened may have been closed in the step before, and an impact changes σ in its second step.
        let of_step = compliances.iter().filter(|(j, mu)| *mu >= 1e30 && is_open(motion, *j, node.saturating_sub(1)));
        let is_event = inputs.grid.steps.contains(&0.0) && motion.times[node] == motion.times[node.saturating_sub(1)];
        if let Some((j, _)) = of_step.into_iter().find(|(j, _)| !(is_event || restarts || is_same(*j))) {
            return Err(format!("σ of open equation {j} changes by {:e} into node {node}", now[*j] - before[*j]));
        }
    }
    for (k, of) in inputs.events.iter().enumerate() {
        let zeros = if placed[k].restitution.is_some() { 2 } else { 1 };
        let [before, after] = [of.node, of.node + inputs.grid.stages * zeros].map(|node| motion.column_of(node));
        let energy = |node: usize| Mechanics::at_node(system, solver.inputs(), motion, node).map(|at| at.kinetic_energy());
        let [first, last] = [energy(before), energy(after)].map(|energy| energy.unwrap_or(f64::NAN));
        let grows = last.is_nan() || last > first * (1.0 + 1e-9) + 1e-12;
        if grows && !is_driven {
            return Err(format!("event {k}, {}: the energy changes from {first:e} to {last:e}", placed[k].kind));
        }
        if let Some(e) = placed[k].restitution {
            let [from, to] = [before, after].map(|node| rates[(placed[k].equations[0].index(), node)]);
            // Compliances of dependent constraints give way to an impulse.
            let share = if description.redundant.is_empty() { 1.0 } else { 1e3 };
            if (to + e * from).abs() > share * (bar(before) + bar(after)) {
                return Err(format!("event {k}: rate {to:e} after {from:e} with e = {e}"));
            }
        }
    }
    Ok(())
}

fn is_open(motion: &Trajectory, equation: usize, node: usize) -> bool {
    let part = motion.compliance.iter().rfind(|part| part.from <= node);
    part.is_some_and(|part| part.equations.iter().any(|(j, mu)| *j == equation && *mu >= 1e30))
}
