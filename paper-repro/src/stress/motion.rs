//! Motions of any length, and errors of their gradients.

use hamiltonian_adjoint::check::{Input, complex_step, direct_differentiation};
use hamiltonian_adjoint::{
    Error, Grid, Inputs, LongSolver, Mechanics, Report, Settings, Start, State, System, Warning, gradient,
};
use nalgebra::{DMatrix, DVector};

use crate::mechanisms as scenes;
use crate::statistics::largest;

/// Bytes for a motion that is not stored: inputs of two million steps and a window.
const MEMORY: usize = 80_000_000;

/// The multipliers are reset at nodes whose numbers are multiples of this.
pub fn rebased(rebase_every: usize) -> Settings {
    Settings { rebase_every, ..Settings::default() }
}

/// Settings for steps that are shorter by this factor: treatments that do not apply to every node apply at the same times.
pub fn refined(settings: Settings, by: usize) -> Settings {
    match settings.rebase_every {
        0 | 1 => settings,
        every => Settings { rebase_every: by * every, ..settings },
    }
}

/// Position constraints are satisfied at every node by projection.
pub fn projected() -> Settings {
    Settings { drift_bound: 0.0, ..Settings::default() }
}

/// Permitted growth of the error, last tenth over first, if it is bounded, …
pub const BOUNDED: f64 = 1.25;
/// four times as much if the motion is rebased at every tenth or hundredth node, because σ is at most ½ R in the middle of its range R
/// and 2 R when it is reset, …
pub const WANDERS: f64 = 4.0;
/// … and ten times as much if it grows in proportion to time.
pub const IN_PROPORTION: f64 = 10.0 * BOUNDED;

/// Effect of σ on a motion that is never rebased: σ grows like ∫λ dt, the error of a step like Δt² σ, …
pub const GROWS: &str = "multipliers have grown until a step has no solution";
/// … and if steps still have solutions, positions drift.
pub const APART: &str = "positions have drifted from their constraints";

/// A step without a solution.
pub fn no_solution(error: &Error) -> bool {
    matches!(
        error,
        Error::Newton { .. } | Error::Projection { .. } | Error::SingularStep { .. } | Error::SingularConfiguration { .. }
    )
}

/// True if the warning reports drifted positions.
pub fn drifted(warning: &Warning) -> bool {
    matches!(warning, Warning::Drift { .. })
}

/// The name of a row's curve in short.
pub fn in_figures(name: &str) -> String {
    name.replace(" at every node", "").replace(", kept moving", "").replace(" without friction", "")
}

/// A motion with equal steps and the same force in all controls.
pub struct March<'a> {
    pub system: &'a System,
    pub start: Start,
    pub steps: usize,
    pub dt: f64,
    pub control: fn(f64) -> f64,
    pub settings: Settings,
}

impl<'a> March<'a> {
    /// From rest, without controls.
    pub fn new(system: &'a System, steps: usize, dt: f64) -> Self {
        let start = Start::Velocity { q: system.initial_coordinates(), v: DVector::zeros(system.n()) };
        March { system, start, steps, dt, control: |_| 0.0, settings: Settings::default() }
    }

    pub fn inputs(&self) -> Inputs {
        let mut inputs = Inputs::at_rest(self.system, Grid::uniform(self.steps, self.dt));
        inputs.start = self.start.clone();
        let times = inputs.grid.times();
        inputs.controls = DMatrix::from_fn(self.system.k(), times.len(), |_, i| (self.control)(times[i]));
        inputs
    }

    pub fn run(&self, see: impl FnMut(&State)) -> Result<Report, Error> {
        let (report, result) = self.attempt(see);
        result.map(|()| report)
    }

    fn attempt(&self, see: impl FnMut(&State)) -> (Report, Result<(), Error>) {
        let mut solver = LongSolver::new(self.system, self.settings, MEMORY);
        let result = solver.simulate(&self.inputs(), see);
        (solver.report().clone(), result)
    }

    /// A value and the time of each node, up to a step without a solution.
    pub fn record(&self, mut number: impl FnMut(&State) -> f64) -> Record {
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(self.steps + 1);
        let (report, result) = self.attempt(|state| points.push((state.time, number(state))));
        Record { points, warnings: report.warnings, stopped: result.err() }
    }

    /// ‖Φ‖∞ and the time of each node, up to a step without a solution.
    pub fn violations(&self) -> Record {
        self.record(|at| mechanics(self.system, at).phi().amax())
    }
}

/// The mechanics of a scene at a state, without its controls.
pub fn mechanics(system: &System, at: &State) -> Mechanics {
    Mechanics::new(system, at.q, at.v).and_then(|here| here.at_time(at.time)).expect("a state of this scene")
}

/// A value over time, the warnings of the report, and the error if the motion ended early.
#[derive(Default)]
pub struct Record {
    pub points: Vec<(f64, f64)>,
    pub warnings: Vec<Warning>,
    pub stopped: Option<Error>,
}

impl Record {
    pub fn complete(self) -> Result<Vec<(f64, f64)>, Error> {
        self.stopped.map_or(Ok(self.points), Err)
    }
}

/// Running maximum of the |deviation| from the first value, at up to a hundred nodes.
pub fn envelope(record: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let start = record.first().map_or(0.0, |first| first.1);
    let stride = record.len().div_ceil(100).max(1);
    let mut most = 0.0f64;
    let so_far = record.chunks(stride).map(|chunk| {
        most = most.max(largest(chunk.iter().map(|(_, value)| value - start)));
        (chunk[chunk.len() - 1].0, most)
    });
    so_far.filter(|(time, _)| *time > 0.0).collect()
}

/// The largest |deviation| from the first value among the nodes of the given fractions of the record; 0 if there are none.
pub fn deviation(record: &[(f64, f64)], (from, to): (f64, f64)) -> f64 {
    let at = |share: f64| (share * record.len() as f64) as usize;
    let start = record.first().map_or(0.0, |first| first.1);
    largest(record[at(from)..at(to)].iter().map(|(_, value)| value - start))
}

/// The largest deviation in the last share of a record over that in the first.
pub fn last_over_first(record: &[(f64, f64)], share: f64) -> f64 {
    deviation(record, (1.0 - share, 1.0)) / deviation(record, (0.0, share))
}

/// Start at rest; all controls are this wave with the given amplitude.
pub fn shaken(system: &System, steps: usize, dt: f64, amplitude: f64) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, dt));
    let nodes = inputs.controls.ncols();
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| {
        *u = amplitude * (0.4 + (7.0 * i as f64 / nodes as f64).sin());
    });
    inputs
}

/// A kind of inputs.
pub type Kind = fn(&Input) -> bool;

pub const CONTROLS: Kind = |input| matches!(input, Input::Control { .. });
pub const DESIGN: Kind = |input| matches!(input, Input::Design(_));
pub const COORDINATES: Kind = |input| matches!(input, Input::Coordinate(_));
pub const RATES: Kind = |input| matches!(input, Input::Rate(_));
pub const STEPS: Kind = |input| matches!(input, Input::Step(_));

/// The relative differences of the adjoint from complex step with respect to inputs of these kinds, each relative to the largest derivative
/// of its kind; up to `most` inputs of each kind are compared.
pub fn gradient_errors<const K: usize>(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    most: usize,
    kinds: [Kind; K],
) -> Result<[f64; K], Error> {
    let gradient = gradient(system, inputs, settings)?;
    let all = Input::all(inputs);
    let mut errors = [0.0; K];
    for (error, kind) in errors.iter_mut().zip(kinds) {
        let of_kind: Vec<Input> = all.iter().filter(|input| kind(input)).copied().collect();
        let adjoint: Vec<f64> = of_kind.iter().map(|input| input.in_gradient(&gradient)).collect();
        let stride = of_kind.len().div_ceil(most).max(1);
        let sample: Vec<Input> = of_kind.into_iter().step_by(stride).collect();
        let reference = complex_step(system, inputs, settings, &sample)?;
        let difference = largest(adjoint.iter().step_by(stride).zip(&reference).map(|(a, b)| a - b));
        *error = if difference == 0.0 { 0.0 } else { difference / largest(&adjoint) };
    }
    Ok(errors)
}

/// The largest difference of all kinds.
pub fn gradient_error(system: &System, inputs: &Inputs, settings: Settings, most: usize) -> Result<f64, Error> {
    let kinds = [CONTROLS, DESIGN, COORDINATES, RATES, STEPS];
    Ok(largest(gradient_errors(system, inputs, settings, most, kinds)?))
}

/// The largest difference of the kinds that keep all constraints satisfied: controls, p*₀ and steps. Constraints that are dependent, or
/// nearly so, contradict each other when q₀ is changed.
pub fn gradient_error_on_constraints(system: &System, inputs: &Inputs, most: usize) -> Result<f64, Error> {
    let start = match &inputs.start {
        Start::Velocity { q, .. } => Start::Momentum { q: q.clone(), p_star: DVector::zeros(system.n()) },
        momentum => momentum.clone(),
    };
    let inputs = Inputs { start, ..inputs.clone() };
    Ok(largest(gradient_errors(system, &inputs, Settings::default(), most, [CONTROLS, RATES, STEPS])?))
}

/// Gradient error of the paper's cart under 10 N for this step length, over 100 steps or 2 s, because later the motion is chaotic.
pub fn gradient_error_of_cart(dt: f64, settings: Settings) -> Result<f64, Error> {
    let system = scenes::paper_cart(3)?;
    let march = March { control: |_| 10.0, ..March::new(&system, ((2.0 / dt) as usize).min(100), dt) };
    gradient_error(&system, &march.inputs(), settings, 12)
}

/// Amplification of a change of the start: the largest |δq| caused by a change of size 1 in all v₀ or p*₀.
///
/// Rounding errors are amplified alike, so two computations of one motion or its gradient cannot agree better.
pub fn amplification(system: &System, inputs: &Inputs) -> Result<f64, Error> {
    let mut direction = inputs.no_change();
    direction.start.rate_mut().fill(1.0);
    let settings = Settings { position_tolerance: f64::INFINITY, velocity_tolerance: f64::INFINITY, ..Settings::default() };
    Ok(direct_differentiation(system, inputs, settings, &direction)?.motion.q.amax())
}
