//! The hand-derived Jacobian of any vector function, outside mechanics too.

use super::compare::{Block, MatrixAt, Setting, check};
use super::formula::{Derived, Function, Of};
use super::matrix::Matrix;
use super::random::Random;
use super::report::Report;

/// The Jacobian of a function to be checked; made by [`function`].
pub struct FunctionCheck<'a, F> {
    function: &'a F,
    inputs: Vec<String>,
    outputs: Vec<String>,
    magnitudes: Vec<f64>,
    given: Vec<Vec<f64>>,
    count: usize,
    seed: u64,
    hands: Vec<MatrixAt<'a>>,
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
        self.hands.push(Box::new(move |x| hand(x).dense()));
        self
    }

    /// The sizes of the inputs, all 1 at first.
    pub fn magnitudes(mut self, sizes: &[f64]) -> Self {
        self.magnitudes = sizes.to_vec();
        self
    }

    /// Compares at this point, and at no random ones.
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
    pub fn run(self) -> Report {
        let count = self.inputs.len();
        let mut random = Random::new(self.seed);
        let mut draw = || self.magnitudes.iter().map(|&size| random.away_from_zero(1.5 * size)).collect::<Vec<f64>>();
        let finite = |x: &Vec<f64>| self.function.value(x).iter().all(|y| y.is_finite());
        let mut drawn = || (0..100 * self.count).map(|_| draw()).filter(finite).take(self.count).collect();
        let points: Vec<Vec<f64>> = if self.given.is_empty() { drawn() } else { self.given };
        // Points or magnitudes of another length are no points.
        let fits = self.magnitudes.len() == count && points.iter().all(|x| x.len() == count);
        let setting = Setting {
            points: if fits { points } else { Vec::new() },
            seed: self.seed,
            magnitudes: self.magnitudes,
            arguments: self.inputs.clone(),
            groups: vec![("x".to_string(), 0..count)],
            factors: Vec::new(),
            tolerance: 1e-11,
        };
        let block = |hand: MatrixAt<'a>| Block {
            name: "f_x".into(),
            function: Box::new(Of(ByReference(self.function), Derived::Value)),
            by: 0..count,
            foundation: None,
            rows: self.outputs.clone(),
            columns: self.inputs.clone(),
            hand,
            terms: Vec::new(),
            others: Vec::new(),
            elsewhere: Vec::new(),
        };
        let blocks = self.hands.into_iter().map(|hand| check(&block(hand), &setting)).collect();
        Report { title: "function".into(), blocks, notes: Vec::new() }
    }
}

struct ByReference<'a, F>(&'a F);

impl<F: Function> Function for ByReference<'_, F> {
    fn value<S: crate::Scalar>(&self, x: &[S]) -> Vec<S> {
        self.0.value(x)
    }
}
