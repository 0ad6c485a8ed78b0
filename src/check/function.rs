//! Checks of hand-derived Jacobians of any vector function, also outside mechanics.

use std::ops::Range;

use super::block::Block;
use super::draw::{Drawn, check_magnitudes, draw};
use super::formula::Function;
use super::matrix::Matrix;
use super::plan::Plan;
use super::reference::Jacobian;
use super::report::Report;
use super::setting::Setting;
use crate::Error;
use crate::motion::check_size;
use crate::number::Random;

const TITLE: &str = "function";

/// A check of the Jacobian of a function, created by [`function`].
#[must_use = "a check does nothing until it is run"]
pub struct FunctionCheck<'a, F> {
    function: &'a F,
    inputs: Vec<String>,
    outputs: Vec<String>,
    magnitudes: Vec<f64>,
    given: Vec<Vec<f64>>,
    /// Number of random points, if it was set.
    count: Option<usize>,
    seed: u64,
    blocks: Vec<Block<'a>>,
}

/// Checks the hand-derived Jacobian of a function with named inputs and outputs.
///
/// ```
/// use hamiltonian_adjoint::{Scalar, check};
///
/// struct Polar;
/// impl check::Function for Polar {
///     fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
///         vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
///     }
/// }
///
/// let report = check::function(&Polar, ["r", "φ"], ["x", "y"])
///     .jacobian(|x| [[x[1].cos(), x[0] * x[1].sin()], [x[1].sin(), x[0] * x[1].cos()]])
///     .run();
/// assert!(!report.passed());
/// assert_eq!(report.blocks[0].diagnoses[0].text, "sign flipped in d(`x`)/d(`φ`)");
/// ```
pub fn function<'a, 'n, F: Function>(
    function: &'a F,
    inputs: impl IntoIterator<Item = &'n str>,
    outputs: impl IntoIterator<Item = &'n str>,
) -> FunctionCheck<'a, F> {
    let quoted = |name: &str| format!("`{name}`");
    let inputs: Vec<String> = inputs.into_iter().map(quoted).collect();
    FunctionCheck {
        function,
        magnitudes: vec![1.0; inputs.len()],
        inputs,
        outputs: outputs.into_iter().map(quoted).collect(),
        given: Vec::new(),
        count: None,
        seed: 1,
        blocks: Vec::new(),
    }
}

impl<'a, F: Function> FunctionCheck<'a, F> {
    /// Adds the hand-derived Jacobian, with one row for each output.
    pub fn jacobian<A: Matrix>(self, hand: impl Fn(&[f64]) -> A + 'a) -> Self {
        let count = self.inputs.len();
        self.block("f_x", 0..count, hand)
    }

    /// Adds hand-written values of the function, one for each output.
    pub fn value<A: Matrix>(self, hand: impl Fn(&[f64]) -> A + 'a) -> Self {
        let count = self.inputs.len();
        self.block("f", count..count + 1, hand)
    }

    fn block<A: Matrix>(mut self, name: &str, by: Range<usize>, hand: impl Fn(&[f64]) -> A + 'a) -> Self {
        let count = self.inputs.len();
        let hand = Box::new(move |x: &[f64]| hand(&x[..count]).dense());
        self.blocks.push(Block::new(name, Jacobian::new(self.function, by), hand));
        self
    }

    /// Sets the typical sizes of the inputs, 1 by default.
    pub fn magnitudes(mut self, sizes: &[f64]) -> Self {
        self.magnitudes = sizes.to_vec();
        self
    }

    /// Adds a point. Random points are then used only after a call of [`random_points`](Self::random_points).
    pub fn at(mut self, point: &[f64]) -> Self {
        self.given.push(point.to_vec());
        self
    }

    /// Sets the number of random points (12 by default, none if points are given) and their seed.
    pub fn random_points(mut self, count: usize, seed: u64) -> Self {
        (self.count, self.seed) = (Some(count), seed);
        self
    }

    /// Compares the given values and Jacobian.
    ///
    /// If nothing can be compared, the report's `refused` gives the reason: points or sizes of wrong length, a number of values that
    /// differs from that of the output names, or a formula that is not finite at any random point.
    pub fn run(self) -> Report {
        Plan::run(self.plan(), TITLE.to_string())
    }

    /// The points and the true values of all given blocks as JSON, for a program in another language that adds its own values: see
    /// [`Answers`](super::Answers).
    ///
    /// # Errors
    /// The reasons for which [`run`](Self::run) compares nothing.
    #[cfg(feature = "files")]
    pub fn worksheet(self) -> Result<String, Error> {
        let count = self.inputs.len();
        Ok(self.plan()?.worksheet(TITLE, |x| x[..count].to_vec()))
    }

    fn points(&self) -> Result<Drawn, Error> {
        let count = self.inputs.len();
        check_size("magnitudes of the function's inputs", count, self.magnitudes.len())?;
        self.given.iter().try_for_each(|point| check_size("point given to the check", count, point.len()))?;
        check_magnitudes(&self.inputs, &self.magnitudes)?;
        let fresh = |random: &mut Random| {
            let x = self.magnitudes.iter().map(|&size| random.away_from_zero(1.5 * size));
            x.chain([1.0]).collect()
        };
        let values = |x: &[f64]| self.function.value(&x[..count]);
        let finite = |x: &[f64]| values(x).iter().all(|y| y.is_finite());
        let signed: Vec<usize> = (0..count).collect();
        let given = self.given.iter().map(|x| [x.as_slice(), &[1.0]].concat()).collect();
        let drawn = draw(given, (self.count, self.seed), &signed, fresh, finite)?;
        let (names, what) = (self.outputs.len(), "values of the function (one for each output name)");
        drawn.points.iter().try_for_each(|point| check_size(what, names, values(point).len()))?;
        Ok(drawn)
    }

    fn plan(self) -> Result<Plan<'a>, Error> {
        let (drawn, count) = (self.points()?, self.inputs.len());
        let arguments = self.inputs.iter().cloned().chain([String::new()]).collect();
        let magnitudes = self.magnitudes.iter().copied().chain([1.0]).collect();
        let setting = Setting {
            free: (0..count).collect(),
            groups: vec![("x".to_string(), 0..count)],
            ..Setting::new(drawn, self.seed, 1e-11, arguments, magnitudes)
        };
        let blocks = self.blocks.into_iter().map(|block| Block { rows: self.outputs.clone(), ..block });
        Ok(Plan::new(setting, blocks))
    }
}
