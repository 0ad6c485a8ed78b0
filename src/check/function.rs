//! The hand-derived Jacobian of any vector function, outside mechanics too.

use super::compare::{Block, MatrixAt, Setting, check};
use super::draw::{Drawn, check_magnitudes, draw};
use super::formula::{Function, Plain, Values};
use super::matrix::Matrix;
use super::random::Random;
use super::report::Report;
#[cfg(feature = "files")]
use super::worksheet;
use crate::Error;

/// The Jacobian of a function to be checked; made by [`function`].
pub struct FunctionCheck<'a, F> {
    function: &'a F,
    inputs: Vec<String>,
    outputs: Vec<String>,
    magnitudes: Vec<f64>,
    given: Vec<Vec<f64>>,
    count: usize,
    seed: u64,
    /// Each with whether it is the function's values instead of its Jacobian.
    hands: Vec<(bool, MatrixAt<'a>)>,
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
pub fn function<'a, F: Function, const I: usize, const O: usize>(
    function: &'a F,
    inputs: [&str; I],
    outputs: [&str; O],
) -> FunctionCheck<'a, F> {
    let quoted = |name: &&str| format!("`{name}`");
    FunctionCheck {
        function,
        inputs: inputs.iter().map(quoted).collect(),
        outputs: outputs.iter().map(quoted).collect(),
        magnitudes: vec![1.0; I],
        given: Vec::new(),
        count: 12,
        seed: 1,
        hands: Vec::new(),
    }
}

impl<'a, F: Function> FunctionCheck<'a, F> {
    /// The Jacobian, one row for each output.
    pub fn jacobian<A: Matrix>(mut self, hand: impl Fn(&[f64]) -> A + 'a) -> Self {
        self.hands.push((false, Box::new(move |x| hand(x).dense())));
        self
    }

    /// The function's values, one for each output.
    pub fn value<A: Matrix>(mut self, hand: impl Fn(&[f64]) -> A + 'a) -> Self {
        self.hands.push((true, Box::new(move |x| hand(x).dense())));
        self
    }

    /// The sizes of the inputs, all 1 at first.
    pub fn magnitudes(mut self, sizes: &[f64]) -> Self {
        self.magnitudes = sizes.to_vec();
        self
    }

    /// Compares at this point and where the function bends near it, and at no random ones.
    pub fn at(mut self, point: &[f64]) -> Self {
        self.given.push(point.to_vec());
        self
    }

    /// The number of random points (12 at first) and their seed.
    pub fn random_points(mut self, count: usize, seed: u64) -> Self {
        (self.count, self.seed) = (count, seed);
        self
    }

    /// Compares everything that was handed in.
    ///
    /// What cannot be compared is refused in the report: points or magnitudes of another length, more or fewer values than names of
    /// outputs, a formula that is finite at no random point.
    pub fn run(self) -> Report {
        Report::of("function".to_string(), self.each_block(check))
    }

    /// The points and the true blocks there of everything that was handed in, as JSON, for a program in any language to put its own beside: see
    /// [`Answers`](super::Answers).
    ///
    /// # Errors
    /// What [`run`](Self::run) refuses.
    #[cfg(feature = "files")]
    pub fn worksheet(self) -> Result<String, Error> {
        let count = self.inputs.len();
        let at = |x: &[f64]| x[..count].to_vec();
        let (blocks, _) = self.each_block(|block, setting| worksheet::block(block, setting, at))?;
        Ok(worksheet::of("function", blocks))
    }

    fn points(&self) -> Result<Drawn, Error> {
        let expected = self.inputs.len();
        let fits = |what: &'static str, found: usize| {
            if found == expected { Ok(()) } else { Err(Error::Size { what, expected, found }) }
        };
        fits("magnitudes of the function's inputs", self.magnitudes.len())?;
        self.given.iter().try_for_each(|point| fits("point given to the check", point.len()))?;
        check_magnitudes(&self.inputs, &self.magnitudes)?;
        let with_one = |mut x: Vec<f64>| {
            x.push(1.0);
            x
        };
        let fresh =
            |random: &mut Random| with_one(self.magnitudes.iter().map(|&size| random.away_from_zero(1.5 * size)).collect());
        let finite = |x: &[f64]| self.function.value(&x[..expected]).iter().all(|y| y.is_finite());
        let signed: Vec<usize> = (0..expected).collect();
        let given = self.given.iter().cloned().map(with_one).collect();
        draw(given, (self.count, self.seed), &signed, fresh, finite)
    }

    /// Refuses a function that has another number of values than names for them.
    fn check_outputs(&self, points: &[Vec<f64>]) -> Result<(), Error> {
        let (names, what) = (self.outputs.len(), "values of the function, of which each has a name");
        let count = |point: &Vec<f64>| self.function.value(&point[..self.inputs.len()]).len();
        match points.iter().map(count).find(|&found| found != names) {
            Some(found) => Err(Error::Size { what, expected: names, found }),
            None => Ok(()),
        }
    }

    /// What is made of every block, and notes on the points.
    fn each_block<T>(self, mut make: impl FnMut(&Block, &Setting) -> T) -> Result<(Vec<T>, Vec<String>), Error> {
        let drawn = self.points()?;
        self.check_outputs(&drawn.points)?;
        let count = self.inputs.len();
        let size = |x: &f64| if *x == 0.0 { 1.0 } else { x.abs() };
        let notes = drawn.note(self.count).into_iter().collect();
        let setting = Setting {
            points: drawn.points,
            parents: drawn.parents,
            given: !self.given.is_empty(),
            free: (0..count).collect(),
            kinds: vec![(0..count).collect()],
            settle: Box::new(|_| ()),
            admissible: Box::new(|_| true),
            seed: self.seed,
            magnitudes: self.magnitudes.iter().map(size).chain([1.0]).collect(),
            arguments: self.inputs.iter().cloned().chain([String::new()]).collect(),
            groups: vec![("x".to_string(), 0..count)],
            factors: Vec::new(),
            tolerance: 1e-11,
        };
        let block = |(values, hand): (bool, MatrixAt<'a>)| {
            let of = Plain(self.function);
            let by = if values { count..count + 1 } else { 0..count };
            Block {
                name: if values { "f" } else { "f_x" }.into(),
                function: if values { Box::new(Values(of)) } else { Box::new(of) },
                columns: setting.arguments[by.clone()].to_vec(),
                by,
                foundation: None,
                rows: self.outputs.clone(),
                hand: Box::new(move |x| hand(&x[..count])),
                terms: Vec::new(),
                others: Vec::new(),
                elsewhere: Vec::new(),
            }
        };
        Ok((self.hands.into_iter().map(|hand| make(&block(hand), &setting)).collect(), notes))
    }
}
