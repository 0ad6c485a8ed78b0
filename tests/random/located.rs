//! Motions with located events: levels of coordinates, velocities, multipliers and times of random scenes, from guesses that are good or poor.

use hamiltonian_adjoint::{Error, Event, Inputs, ListCost, ListPoint, Scalar, Solver, System, Trajectory};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::build;
use crate::crossed;
use crate::description::Description;
use crate::exact::Moved;
use crate::regular;

/// An event, and where it is expected.
#[derive(Clone, Copy, Debug)]
pub struct Sought {
    /// The weights of sin q, v, σ and t.
    weights: [f64; 4],
    /// The coordinate and the multiplier.
    of: [usize; 2],
    /// The share of the nodes before it.
    place: f64,
    /// The factor of the steps before it.
    guess: f64,
}

/// g = w · (sin q, v, σ, t) − b.
struct Level([f64; 4]);

impl Level {
    fn value<S: Scalar>(&self, x: [S; 4], b: S) -> S {
        x[0].sin() * self.0[0] + x[1] * self.0[1] + x[2] * self.0[2] + x[3] * self.0[3] - b
    }
}

impl ListCost for Level {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let sigma = at.sigma.first().copied().unwrap_or(S::zero());
        self.value([at.q[0], at.v[0], sigma, at.t], at.b[0])
    }
}

/// An event with its function, coordinate and multiplier. Contacts of the scene are events, too, so its number is not its place in the list.
struct Placed {
    level: Level,
    event: Event,
    of: (usize, Option<usize>),
}

impl Placed {
    fn along(&self, motion: &Trajectory, b: f64) -> Vec<f64> {
        let (q, sigma) = self.of;
        let row = |matrix: &DMatrix<f64>, node: usize| sigma.map_or(0.0, |sigma| matrix[(sigma, node)]);
        let at = |node: usize| [motion.q[(q, node)], motion.v[(q, node)], row(&motion.sigma, node), motion.times[node]];
        (0..motion.computed).map(|node| self.level.value(at(node), b)).collect()
    }
}

pub fn scene_with_events() -> impl Strategy<Value = (Description, Vec<Sought>)> {
    let weights = prop_oneof![
        3 => Just([1.0, 0.0, 0.0, 0.0]),
        3 => Just([0.0, 1.0, 0.0, 0.0]),
        1 => Just([0.0, 0.0, 1.0, 0.0]),
        1 => Just([0.0, 0.0, 0.0, 1.0]),
        4 => [-1.0..1.0, -1.0..1.0, -0.2..0.2, -1.0..1.0],
    ];
    let guess = prop_oneof![2 => Just(1.0), 1 => 0.3..2.0];
    let event = (weights, [0..60usize, 0..60usize], 0.0..1.0, guess);
    let event = event.prop_map(|(weights, of, place, guess)| Sought { weights, of, place, guess });
    let scene = prop_oneof![regular::description(), crossed::description()];
    (scene, proptest::collection::vec(event, 1..=3)).prop_map(|(mut description, mut events)| {
        let run = &mut description.run;
        run.tolerance = None;
        // Events of motions that turn back have no order.
        let sign = run.steps[0].signum();
        run.steps.iter_mut().for_each(|dt| *dt = dt.copysign(sign));
        events.sort_by(|a, b| a.place.total_cmp(&b.place));
        // Dependent constraints share their multipliers with few digits.
        description.redundant.clear();
        // Multipliers jump where a motion restarts.
        if run.settings.rebase_every > 0 || run.settings.drift_bound < f64::INFINITY {
            events.iter_mut().for_each(|event| event.weights[2] = 0.0);
        }
        (description, events)
    })
}

/// The motion with those events that change at their nodes along the motion without events; `Ok(Err(None))` if there are none.
///
/// # Errors
/// What is wrong with the motion.
pub fn run(description: &Description, sought: &[Sought]) -> Result<Result<Moved, Option<Error>>, String> {
    let mut built = build::scene(description);
    let mut placed = Vec::new();
    for (k, &Sought { weights, of, .. }) in sought.iter().enumerate() {
        let round = |len: usize, i: usize| (len > 0).then(|| i % len);
        let q = built.coordinates[of[0] % built.coordinates.len()];
        let sigma = round(built.multipliers.len(), of[1]).map(|i| built.multipliers[i]);
        let b = built.scene.design(&format!("level {k}"), 0.0);
        let sigmas: Vec<_> = sigma.into_iter().collect();
        let event = built.scene.list_event(&format!("event {k}"), Level(weights), &[q], &sigmas, &[], &[b.into()]);
        placed.push(Placed { level: Level(weights), event, of: (q.index(), sigma.map(|sigma| sigma.index())) });
    }
    let start = built.scene.compile().and_then(|system| {
        let mut inputs = build::inputs(&description.run, &system, &built.inertia)?;
        // Every other scene has controls that are functions of time.
        let timed = 0..if sought[0].of[0].is_multiple_of(2) { system.k() } else { 0 };
        inputs.controls_in_time = timed.map(|k| system.control(k)).collect();
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
    ask_for(&mut inputs, &system, solver.trajectory(), sought, &placed);
    if inputs.events.is_empty() {
        return Ok(Err(None));
    }
    if let Err(error) = solver.simulate(&inputs) {
        return Ok(Err(Some(error)));
    }
    check(&inputs, &system, solver.trajectory(), &placed)?;
    let gradient = match solver.gradient() {
        Ok(gradient) => gradient.clone(),
        Err(error) => return Ok(Err(Some(error))),
    };
    // On a composed grid, knots are at the ends of macro steps only, so that kinks within them move.
    let keeps_controls = inputs.controls_in_time.is_empty() || inputs.grid.stages == 1;
    if solver.trajectory().inserted.is_empty() && keeps_controls {
        let found = solver.inputs().clone();
        let q = solver.trajectory().q.clone();
        let again = solver.simulate(&found).map_err(|error| format!("simulated again: {error}"))?;
        let change = if again.inserted.is_empty() { (&again.q - q).amax() } else { f64::INFINITY };
        if change.is_nan() || change > 1e-9 {
            return Err(format!("simulated again, q changes by {change:e}"));
        }
    }
    drop(solver);
    Ok(Ok(Moved { system, inputs, gradient }))
}

/// Sets the levels to values before nodes of a motion, and the events to these nodes.
fn ask_for(inputs: &mut Inputs, system: &System, motion: &Trajectory, sought: &[Sought], placed: &[Placed]) {
    let (steps, stages, mut before) = (inputs.grid.steps.len(), inputs.grid.stages, 0);
    for (k, event) in sought.iter().enumerate() {
        let node = (1 + (event.place * steps as f64) as usize).next_multiple_of(stages).max(before + stages);
        if node > steps {
            return;
        }
        let g = placed[k].along(motion, 0.0);
        let [earlier, there] = [node - stages, node].map(|node| g[motion.column_of(node)]);
        if (there - earlier).abs() > 1e-6 {
            inputs.design[system.designs() - sought.len() + k] = there + 0.37 * (earlier - there);
            inputs.grid.steps[before..node].iter_mut().for_each(|dt| *dt *= event.guess);
            inputs.events.push(placed[k].event.at(node));
            before = node;
        }
    }
}

/// That every event is the first zero of its function after the event before, and that the motion ends when its grid does.
fn check(inputs: &Inputs, system: &System, motion: &Trajectory, placed: &[Placed]) -> Result<(), String> {
    let mut begin = 0;
    for event in &inputs.events {
        let k = placed.iter().position(|placed| placed.event == event.event).ok_or("an event that was not asked for")?;
        let b = inputs.design[system.designs() - placed.len() + k];
        let (g, at) = (placed[k].along(motion, b), motion.column_of(event.node));
        let size = g[begin..=at].iter().fold(b.abs(), |size, g| size.max(g.abs()));
        if g[at].is_nan() || g[at].abs() > 1e-6 * size {
            return Err(format!("g = {:e} of {size:e} at the node of event {k}", g[at]));
        }
        if inputs.grid.stages == 1 && g[begin + 1..at.max(begin + 1)].windows(2).any(|g| g[0] * g[1] < 0.0) {
            return Err(format!("an earlier zero of event {k} in {:?}", &g[begin..=at]));
        }
        begin = at;
    }
    let (end, steps) = (inputs.grid.times()[inputs.grid.steps.len()], inputs.grid.steps.len());
    let has_rest = inputs.events.last().is_some_and(|event| event.node < steps);
    let error = motion.times[motion.last()] - end;
    if has_rest && error.abs() > 1e-12 { Err(format!("the motion ends {error:e} s after its grid")) } else { Ok(()) }
}
