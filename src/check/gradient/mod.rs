//! Checks of the gradient in four ways (discrete adjoint, direct differentiation, complex step, differences), with the Taylor test and
//! the dot-product identity.

mod directions;
mod hessian;
mod identity;
mod own;
mod print;
mod report;
mod sizes;
mod subject;
mod taylor;
mod watch;
mod ways;

pub use directions::Part;
pub use hessian::{HessianCheck, HessianReport, HessianRow, hessian};
pub use identity::Identity;
pub use report::{DirectionReport, GradientReport};
pub use taylor::{Remainder, Taylor};

use std::ops::ControlFlow;

use super::derivative::Input;
use super::draw::check_tolerance;
use super::report::Verdict;
use crate::number::Random;
use crate::{Error, Estimate, Gradient, Inputs, Output, Progress, Settings, Solver, System, Warning};
use directions::{only, product, random};
use identity::identity;
use own::Own;
use sizes::{Terms, sizes_of_inputs};
use subject::{Subject, warnings_of};
use taylor::taylor;
use watch::Watch;
use ways::Ways;

/// Errors are relative to at least these fractions of the largest dJ of a single input, and of a random direction.
const LITTLE_BESIDE: f64 = 1e-3;
const NOTHING_BESIDE: f64 = 1e-6;
/// Maximum number of single inputs that a complete check lists.
const MOST_LISTED: usize = 20;

/// A check of the gradient, created by [`gradient`].
#[must_use = "a check does nothing until it is run"]
pub struct GradientCheck<'a> {
    subject: Subject<'a>,
    directions: usize,
    seed: u64,
    complete: bool,
    tolerance: f64,
    own: Vec<Own>,
}

/// Checks the gradient of the system's cost at these inputs.
///
/// By default the check compares along one random direction in each part of the inputs and one in all of them. It uses copies of the system
/// and the inputs.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, check, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
/// inputs.controls.fill(10.0);
/// check::gradient(&system, &inputs, Settings::default()).run()?.assert_passed();
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub fn gradient<'a>(system: &'a System, inputs: &'a Inputs, settings: Settings) -> GradientCheck<'a> {
    // Moved initial values violate the constraints, which an ordinary simulation would reject.
    let settings =
        Settings { position_tolerance: f64::INFINITY, velocity_tolerance: f64::INFINITY, keep_adjoint: true, ..settings };
    let subject = Subject { system, inputs, settings, which: 0, watch: Watch::default() };
    GradientCheck { subject, directions: 1, seed: 1, complete: false, tolerance: 1e-9, own: Vec::new() }
}

impl GradientCheck<'_> {
    /// Checks the gradient of an output instead of J.
    pub fn output(mut self, output: Output) -> Self {
        self.subject = self.subject.of(output);
        self
    }

    /// Sets the number of random directions in each part of the inputs (1 by default) and their seed.
    pub fn directions(mut self, count: usize, seed: u64) -> Self {
        (self.directions, self.seed) = (count, seed);
        self
    }

    /// Also compares every single input, with three or more simulations for each.
    pub fn complete(mut self) -> Self {
        self.complete = true;
        self
    }

    /// Sets the tolerance of dJ, relative to the size of its terms (1e-9 by default).
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Compares your own gradient, for one part of the inputs, number by number with the library's checked gradient.
    ///
    /// The order is that of [`Inputs`]: controls column by column.
    pub fn own(mut self, name: &str, part: Part, values: impl IntoIterator<Item = f64>) -> Self {
        self.own.push(Own::new(name, part, values));
        self
    }

    /// Sets a progress callback for all motions and gradients of the check, as [`Solver::watch`](crate::Solver::watch). If it returns `Break`, the
    /// check stops with [`Error::Interrupted`].
    pub fn watch(mut self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) -> Self {
        self.subject.watch = Watch::new(callback);
        self
    }

    /// Runs the check.
    ///
    /// # Errors
    /// A motion that cannot be computed at the inputs, or a tolerance that is not between 0 and 1.
    pub fn run(&self) -> Result<GradientReport, Error> {
        let report = self.report();
        self.subject.watch.end()?;
        report
    }

    fn report(&self) -> Result<GradientReport, Error> {
        check_tolerance(self.tolerance)?;
        let (subject, of) = (&self.subject, self.subject.name()?);
        let (mut solver, gradient) = subject.solved()?;
        let warnings = warnings_of(&solver);
        let grid = (subject.which == 0).then(|| self.estimate(&solver, &gradient).ok()).flatten();
        let mut random_source = Random::new(self.seed);
        let parts = Part::all_of(subject.inputs);
        let sizes = sizes_of_inputs(subject.system, subject.inputs, &mut solver);
        let terms = Terms::new(subject.system, &sizes, &mut solver);
        let mut ways = Ways::new(subject.clone(), terms)?;
        let mut directions = Vec::new();
        for _ in 0..self.directions {
            for &part in &parts {
                let direction = random(&sizes, &[part], &mut random_source);
                directions.push(ways.compare(part.name().to_string(), &direction, &gradient, self.tolerance)?);
            }
        }
        let all = random(&sizes, &parts, &mut random_source);
        directions.push(ways.compare("all together".into(), &all, &gradient, self.tolerance)?);
        judge_among(&mut directions, NOTHING_BESIDE, self.tolerance);
        let taylor = taylor(|s| ways.value_along(&all, s), gradient.value, product(&gradient, &all).0);
        let varied = random(&sizes, &[Part::Controls, Part::Coordinates, Part::Rates], &mut random_source);
        let within = (ways.floor(&varied, gradient.value).0, self.tolerance);
        // The derivatives of the times of events are none of adjoint variables.
        let adjoint = solver.adjoint_variables().filter(|_| subject.inputs.events.is_empty());
        let identity = adjoint.map(|adjoint| identity(subject, &varied, (&gradient, adjoint), within));
        let identity = identity.transpose()?;
        // Read before single inputs are compared: those without much effect have a large relative rounding error.
        let (rounding, value) = (ways.rounding(), gradient.value);
        let (singles, worst_singles) =
            if self.complete { self.singles(&mut ways, &sizes, &gradient)? } else { Default::default() };
        let mut report = GradientReport {
            of,
            value,
            directions,
            singles,
            worst_singles,
            taylor,
            identity,
            rounding,
            warnings,
            has_kinks: gradient.warnings.iter().any(|warning| matches!(warning, Warning::GridPhase { .. })),
            grid: grid.map_or(String::new(), |grid| grid.in_words()),
            own: Vec::new(),
        };
        let trusted = report.verdict() == Verdict::Right;
        for own in &self.own {
            let rows = report.directions.iter().filter(|row| row.name == own.part.name());
            let trusted = trusted && rows.clone().all(|row| row.verdict == Verdict::Right);
            let raised = rows.map(|row| row.raised(self.tolerance)).fold(1.0, f64::max);
            let is_known = |input: Input| {
                let (adjoint, direct) = (input.in_gradient(&gradient), ways.direct(&only(subject.inputs, input, 1.0))?);
                Ok((adjoint - direct).abs() <= self.tolerance * adjoint.abs())
            };
            let truth = trusted.then_some(&gradient);
            report.own.push(own.compare(subject, &sizes, "gradient", truth, (self.tolerance, raised), is_known)?);
        }
        Ok(report)
    }

    /// The errors that the grid causes.
    fn estimate(&self, solver: &Solver, gradient: &Gradient) -> Result<Estimate, Error> {
        let Subject { inputs, settings, .. } = &self.subject;
        let mut coarser = self.subject.solver(Settings { keep_adjoint: false, ..*settings });
        Estimate::of_value(solver, gradient.clone())?.compared(&mut coarser, inputs)
    }

    /// Compares every input alone; returns their number, and the worst.
    fn singles(&self, ways: &mut Ways, sizes: &Inputs, gradient: &Gradient) -> Result<(usize, Vec<DirectionReport>), Error> {
        let Subject { system, inputs, .. } = self.subject;
        let (all, mut sizes) = (Input::all(inputs), sizes.clone());
        let mut rows = Vec::new();
        for input in &all {
            let direction = only(inputs, *input, *input.of(&mut sizes));
            rows.push(ways.compare(input.name(system), &direction, gradient, self.tolerance)?);
        }
        // A derivative that is nearly zero compared with those of the other inputs is no reason for alarm.
        judge_among(&mut rows, LITTLE_BESIDE, self.tolerance);
        let is_right = |row: &DirectionReport| row.verdict == Verdict::Right;
        rows.sort_by(|a, b| is_right(a).cmp(&is_right(b)).then(b.error().total_cmp(&a.error())));
        rows.truncate(MOST_LISTED);
        Ok((all.len(), rows))
    }
}

/// Judges the rows again, with errors relative to at least this fraction of the largest.
fn judge_among(rows: &mut [DirectionReport], part: f64, tolerance: f64) {
    let largest = rows.iter().fold(0.0f64, |m, row| m.max(row.scale()));
    rows.iter_mut().for_each(|row| row.judge(part * largest, tolerance));
}
