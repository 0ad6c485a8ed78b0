//! Products of the Hessian computed in three ways: by the library along either of two directions, and by hyper-dual numbers through the
//! whole simulation or, if these are not supported, by differences of gradients.

use std::fmt;
use std::ops::ControlFlow;

use super::super::draw::check_tolerance;
use super::super::report::{BlockReport, Verdict, outcome};
use super::Part;
use super::directions::{only, product, random};
use super::own::Own;
use super::print::{explain_difference, print_warnings};
use super::report::DIFFERENCED;
use super::sizes::{Terms, sizes_of_inputs};
use super::subject::{Subject, warnings_of};
use super::taylor::FIRST_STEP;
use super::watch::Watch;
use super::ways::Way;
use crate::check::Input;
use crate::number::Random;
use crate::{Error, Hyper, Inputs, Output, Progress, Settings, System};

/// Rounding error relative to the largest of all rows, of the gradient and of its terms; products below it, as for a linear J, count as zero.
const ROUNDING: f64 = 1e-14;

/// A check of products of the Hessian, created by [`hessian`].
#[must_use = "a check does nothing until it is run"]
pub struct HessianCheck<'a> {
    subject: Subject<'a>,
    seed: u64,
    tolerance: f64,
    /// The user's products, with their directions.
    own: Vec<(Own, Inputs)>,
}

/// Checks products of the Hessian of the system's cost at these inputs: aᵀH b for a random direction a in each part of the inputs and b in all.
///
/// Hyper-dual numbers do not support costs on accelerations or reactions. The products of such costs are compared with differences of
/// gradients, within the error of these.
///
/// ```
/// use hamiltonian_adjoint::check::{self, Part};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
/// inputs.controls.fill(10.0);
/// check::hessian(&system, &inputs, Settings::default()).run()?.assert_passed();
///
/// // A product of your own, which is wrong here: the Hessian is not zero.
/// let mut push = inputs.no_change();
/// push.controls.fill(1.0);
/// let check = check::hessian(&system, &inputs, Settings::default());
/// let report = check.own("mine", Part::Controls, push, vec![0.0; 51]).run()?;
/// assert!(!report.passed());
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub fn hessian<'a>(system: &'a System, inputs: &'a Inputs, settings: Settings) -> HessianCheck<'a> {
    let subject = Subject { system, inputs, settings, which: 0, watch: Watch::default() };
    HessianCheck { subject, seed: 1, tolerance: 1e-9, own: Vec::new() }
}

impl HessianCheck<'_> {
    /// Checks products of the Hessian of an output instead of J.
    pub fn output(mut self, output: Output) -> Self {
        self.subject = self.subject.of(output);
        self
    }

    /// Sets the seed of the random directions.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the tolerance of aᵀH b, relative to the size of its terms (1e-9 by default).
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Compares your own product with this direction, for one part of the inputs, number by number with the library's checked product.
    ///
    /// The order is that of [`Inputs`]: controls column by column.
    pub fn own(mut self, name: &str, part: Part, direction: Inputs, values: impl IntoIterator<Item = f64>) -> Self {
        self.own.push((Own::new(name, part, values), direction));
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
    /// A motion that cannot be computed or has no products, a direction of wrong size, or a tolerance that is not between 0 and 1.
    pub fn run(&self) -> Result<HessianReport, Error> {
        let report = self.report();
        self.subject.watch.end()?;
        report
    }

    fn report(&self) -> Result<HessianReport, Error> {
        check_tolerance(self.tolerance)?;
        let (subject, of) = (&self.subject, self.subject.name()?);
        let (mut solver, gradient) = subject.solved()?;
        let warnings = warnings_of(&solver);
        let sizes = sizes_of_inputs(subject.system, subject.inputs, &mut solver);
        let mut random_source = Random::new(self.seed);
        let parts = Part::all_of(subject.inputs);
        let all = random(&sizes, &parts, &mut random_source);
        let of_all = solver.hessian_product(&all)?.clone();
        let mut reference = Way::<Hyper>::new(subject.clone())?;
        let rows = parts.iter().map(|&part| {
            let direction = random(&sizes, &[part], &mut random_source);
            let (along, size) = product(&of_all, &direction);
            let (transposed, other) = product(solver.hessian_product(&direction)?, &all);
            let (value, error) = reference.product([&direction, &all])?;
            Ok((part.name(), [along, transposed, value], size.max(other).max(value.abs()), error))
        });
        let rows = rows.collect::<Result<Vec<_>, Error>>()?;
        // If J is of third or higher order here, its products are rounding errors of its changes nearby.
        let nearby = |s: f64| (reference.beside(&all, s, |solver| solver.value_of(subject.which)) - gradient.value).abs();
        let nearby = nearby(FIRST_STEP).max(nearby(-FIRST_STEP));
        let terms = Terms::new(subject.system, &sizes, &mut solver).along(&all);
        let largest = rows.iter().fold(product(&gradient, &all).1.max(nearby).max(terms), |largest, row| largest.max(row.2));
        let rows = rows
            .into_iter()
            .map(|(name, values, size, error)| HessianRow::new(name, values, [size, largest, error], self.tolerance));
        let rows = rows.collect();
        let (by_differences, rounding) = (!reference.goes_through, reference.rounding);
        let mut report = HessianReport { of, rows, by_differences, rounding, warnings, own: Vec::new() };
        let is_trusted = report.library() == Verdict::Right;
        for (own, along) in &self.own {
            let product = solver.hessian_product(along)?;
            let truth = is_trusted.then_some(product);
            let is_known = |input: Input| {
                let direction = only(subject.inputs, input, 1.0);
                let (product, (value, error)) = (input.in_gradient(product), reference.product([&direction, along])?);
                Ok((product - value).abs() + error <= self.tolerance * product.abs())
            };
            report.own.push(own.compare(subject, &sizes, "product", truth, (self.tolerance, 1.0), is_known)?);
        }
        Ok(report)
    }
}

/// One value aᵀH b, computed in three ways.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct HessianRow {
    /// The inputs that a changes; b changes all.
    pub name: &'static str,
    /// a · (H b).
    pub product: f64,
    /// b · (H a).
    pub transposed: f64,
    /// The reference by hyper-dual numbers or differences of gradients.
    pub reference: f64,
    /// Error of the reference: 0 for hyper-dual numbers, ∞ if there is no reference.
    pub uncertainty: f64,
    /// Scale of the errors: the larger value of √Σ (H b)_j² a_j² for the two products; 0 if it is not larger than rounding errors.
    pub size: f64,
    /// The outcome.
    pub verdict: Verdict,
}

impl HessianRow {
    fn new(
        name: &'static str,
        [product, transposed, reference]: [f64; 3],
        [size, largest, uncertainty]: [f64; 3],
        tolerance: f64,
    ) -> Self {
        let floor = (ROUNDING * largest).max(uncertainty);
        // Both may have this rounding error.
        let near = |x: f64| (x - reference).abs() <= (tolerance * size).max(2.0 * floor);
        let verdict = match near(product) && near(transposed) {
            _ if uncertainty.is_nan() || uncertainty > DIFFERENCED * largest => Verdict::NothingCompared,
            true => Verdict::Right,
            false => Verdict::Wrong,
        };
        let size = if size <= floor && uncertainty.is_finite() { 0.0 } else { size };
        HessianRow { name, product, transposed, reference, uncertainty, size, verdict }
    }

    /// The larger relative error of the two products.
    pub fn error(&self) -> f64 {
        let difference = (self.product - self.reference).abs().max((self.transposed - self.reference).abs());
        if self.size == 0.0 { 0.0 } else { difference / self.size }
    }
}

/// Report of a check of Hessian products.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct HessianReport {
    /// The checked function: J or an output.
    pub of: String,
    /// One row for each part of the inputs.
    pub rows: Vec<HessianRow>,
    /// True if the reference is differences of gradients.
    pub by_differences: bool,
    /// Rounding of the hyper-dual reference, relative to the unknowns of a step (see
    /// [`LiftedSolver::rounding`](crate::LiftedSolver::rounding)).
    pub rounding: f64,
    /// Warnings of the motion and its gradient ([`Report::warnings`](crate::Report::warnings)), as text.
    pub warnings: Vec<String>,
    /// The user's products.
    pub own: Vec<BlockReport>,
}

outcome!(HessianReport);

impl HessianReport {
    /// The overall verdict, including the user's products.
    pub fn verdict(&self) -> Verdict {
        self.library().with(&self.own)
    }

    fn library(&self) -> Verdict {
        let is = |verdict| self.rows.iter().any(|row| row.verdict == verdict);
        if is(Verdict::Wrong) {
            Verdict::Wrong
        } else if is(Verdict::NothingCompared) || self.rows.iter().all(|row| row.size == 0.0) {
            Verdict::NothingCompared
        } else {
            Verdict::Right
        }
    }
}

impl fmt::Display for HessianReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let library = self.library();
        let summary = match library {
            Verdict::NothingCompared if self.rows.iter().all(|row| row.size == 0.0) => {
                "FAILED, because nothing was compared: the function is linear in the inputs".to_string()
            }
            Verdict::NothingCompared if self.rows.iter().any(|row| row.uncertainty == f64::INFINITY) => {
                "FAILED, because nothing was compared: no neighbouring motion uses the same steps, so differences of \
                 gradients do not exist; use shorter steps, so that none is halved"
                    .to_string()
            }
            Verdict::NothingCompared => "FAILED, because differences of gradients are too inaccurate here".to_string(),
            other => other.to_string(),
        };
        let own = if library == self.verdict() { "" } else { "; but see your own product" };
        writeln!(f, "products of the Hessian of {}, a·H b with b in all inputs: {summary}{own}", self.of)?;
        let way = if self.by_differences { "by differences" } else { "by hyper-dual numb." };
        writeln!(f, "  {:20}  {way:>19}  {:>9}  {:>9}   verdict", "a in", "a·(H b)", "b·(H a)")?;
        for row in &self.rows {
            let off = |x: f64| match row.size {
                0.0 => format!("{:.1e}", 0.0),
                _ if row.reference.is_nan() => "–".to_string(),
                size => format!("{:.1e}", (x - row.reference).abs() / size),
            };
            let HessianRow { name, product, transposed, reference, .. } = row;
            let verdict = if row.size == 0.0 { Verdict::NothingCompared } else { row.verdict };
            let [product, transposed] = [product, transposed].map(|x| off(*x));
            writeln!(f, "  {name:20}  {reference:>+19.12e}  {product:>9}  {transposed:>9}   {verdict}")?;
        }
        if self.rows.iter().any(|row| row.verdict == Verdict::Wrong) {
            explain_difference(f, self.rounding)?;
        }
        print_warnings(f, &self.warnings)?;
        self.own.iter().try_for_each(|own| write!(f, "{own}"))
    }
}
