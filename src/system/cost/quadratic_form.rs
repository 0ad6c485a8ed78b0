//! [`QuadraticForm`]: a cost that is a polynomial of degree two in many arguments, evaluated with a matrix.

use std::sync::Arc;

use super::cost_programs::Gradient;
use crate::number::all_finite;
use crate::program::{Kernel, Template};
use crate::system::formula::{Connections, Layout, Place, Shape, Slot};

/// A polynomial c + gᵀx + ½ xᵀH x of n arguments.
#[derive(Debug)]
pub struct QuadraticForm {
    /// The arguments x.
    variables: Vec<Slot>,
    /// The program for c, g and H at x = 0; H is stored by columns.
    coefficients: Kernel,
    /// Whether digits may cancel in this form that the original formula keeps.
    may_cancel: bool,
}

/// With fewer arguments, a program is at least as fast as a matrix.
const FEW: usize = 6;

/// The time of one instruction in units of the time per matrix entry; a sum of squares exceeds this ratio, a full quadratic form does not.
const ENTRIES: usize = 8;

/// Smallest accepted ratio of a value to the sum of the magnitudes of its terms. Below it, as for squares of small differences of large
/// numbers, the original formula is evaluated.
const LEAST_OF_VALUE: f64 = 1.0 / 64.0;
/// Smallest accepted ratio of a slope to the sum of the magnitudes of its terms.
const LEAST_OF_SLOPE: f64 = 1.0 / 1024.0;

impl QuadraticForm {
    /// The quadratic form of a cost with this program if it is one, in arguments alone, and if a matrix is faster.
    pub fn new(template: &Template, shape: Shape, program: &Gradient) -> Option<Self> {
        let variables: Vec<Slot> = program.of.iter().filter_map(|(_, slot)| *slot).collect();
        let is_worth_it = variables.len() >= FEW && variables.len().pow(2) <= ENTRIES * program.kernel.main().len();
        if !is_worth_it || variables.iter().any(|slot| matches!(slot, Slot::B(_))) {
            return None;
        }
        let (mut graph, values) = template.graph();
        let (one, arguments) = (graph.constant(1.0), shape.nodes(&mut graph, &variables));
        let slopes = graph.reverse(&[(values[0], one)], &arguments);
        let second: Vec<_> = arguments.into_iter().flat_map(|x| graph.forward(&slopes, &[(x, one)])).collect();
        let first = [&values[..1], &slopes].concat();
        if !second.iter().all(|node| graph.is_fixed(*node)) || graph.is_piecewise(first.iter().copied()) {
            return None;
        }
        let may_cancel = graph.multiplies_sums([values[0]]);
        let coefficients = Kernel::new(&mut graph, template.parameters + shape.p, &[first, second].concat())?;
        Some(QuadraticForm { variables, coefficients, may_cancel })
    }

    /// Computes the value and the gradient g + H x from these coefficients. Returns false if digits cancel; `sizes` is workspace.
    fn evaluate(&self, coefficients: &[f64], x: &[f64], results: &mut [f64], sizes: &mut [f64]) -> bool {
        let (first, matrix) = coefficients.split_at(1 + x.len());
        let (constant, linear) = (first[0], &first[1..]);
        let (value, slopes) = results.split_at_mut(1);
        multiply(matrix, x, slopes, |h, x| h * x);
        value[0] = x.iter().zip(linear).zip(&*slopes).fold(constant, |value, ((x, g), y)| value + x * (g + 0.5 * y));
        slopes.iter_mut().zip(linear).for_each(|(y, g)| *y += g);
        if !self.may_cancel {
            return true;
        }
        multiply(matrix, x, sizes, |h, x| (h * x).abs());
        let (mut magnitude, mut cancels) = (constant.abs(), false);
        for ((x, g), (slope, size)) in x.iter().zip(linear).zip(slopes.iter().zip(&*sizes)) {
            magnitude += x.abs() * (g.abs() + 0.5 * size);
            cancels |= slope.abs() < LEAST_OF_SLOPE * (g.abs() + size);
        }
        !cancels && value[0].abs() >= LEAST_OF_VALUE * magnitude
    }
}

/// The quadratic forms of like costs.
pub struct Forms {
    form: Arc<QuadraticForm>,
    /// The places of the arguments x in a point, cost by cost.
    sources: Vec<usize>,
    coefficients: Vec<Vec<f64>>,
    /// Whether all coefficients are finite.
    are_finite: bool,
    x: Vec<f64>,
    sizes: Vec<f64>,
    results: Vec<f64>,
}

impl Forms {
    pub fn new(layout: Layout, to: &[&Connections], form: Arc<QuadraticForm>) -> Self {
        let source = |&to: &&Connections| {
            let places = form.variables.iter().map(|slot| Place::Of(*slot));
            places.map(|place| layout.source(to, place)).collect::<Vec<usize>>()
        };
        let (n, sources) = (form.variables.len(), to.iter().flat_map(source).collect());
        let (coefficients, results) = (vec![Vec::new(); to.len()], vec![0.0; to.len() * (1 + n)]);
        Forms { form, sources, coefficients, are_finite: false, x: vec![0.0; n], sizes: vec![0.0; n], results }
    }

    /// Sets the constants of each cost.
    pub fn fix(&mut self, parameters: impl Fn(usize) -> Vec<f64>) {
        let of = |e| self.form.coefficients.evaluate(&parameters(e), |_| 0.0);
        self.coefficients = (0..self.coefficients.len()).map(of).collect();
        self.are_finite = self.coefficients.iter().all(|coefficients| all_finite(coefficients));
    }

    /// Evaluates all forms, and returns each result with the numbers of its cost and of the result; `None` if digits cancel in any of them.
    pub fn evaluate(&mut self, point: &[f64]) -> Option<impl Iterator<Item = (usize, usize, f64)>> {
        let Forms { form, sources, coefficients, are_finite, x, sizes, results } = self;
        let n = x.len();
        let mut all = sources.chunks_exact(n).zip(coefficients).zip(results.chunks_exact_mut(1 + n));
        let holds = *are_finite
            && all.all(|((sources, coefficients), results)| {
                x.iter_mut().zip(sources).for_each(|(x, &source)| *x = point[source]);
                form.evaluate(coefficients, x, results, sizes)
            });
        holds.then(|| results.iter().enumerate().map(move |(k, x)| (k / (1 + n), k % (1 + n), *x)))
    }
}

/// Sums the products of a matrix's columns with a vector.
fn multiply(columns: &[f64], x: &[f64], into: &mut [f64], product: impl Fn(f64, f64) -> f64) {
    into.fill(0.0);
    for (column, &x) in columns.chunks_exact(into.len()).zip(x) {
        into.iter_mut().zip(column).for_each(|(y, &h)| *y += product(h, x));
    }
}
