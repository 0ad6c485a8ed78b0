//! [`CostFormula`]: a recorded cost, and the program for its value and gradient.

use super::derivatives::without_zeros;
use crate::program::{Graph, Kernel, Node, Obstacle, Template};

/// What a cost is differentiated by: one of its arguments, or one of its constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partial {
    Argument(usize),
    Constant(usize),
}

impl Partial {
    /// By all arguments that a cost depends on, and all constants that are bound.
    pub(super) fn all(depends: &[bool], bound: &[bool]) -> Vec<Partial> {
        let arguments = (0..depends.len()).filter(|&i| depends[i]).map(Partial::Argument);
        arguments.chain((0..bound.len()).filter(|&p| bound[p]).map(Partial::Constant)).collect()
    }
}

/// The program of a cost.
#[derive(Clone, Debug)]
pub struct CostFormula {
    /// Which arguments it depends on.
    pub depends: Vec<bool>,
    template: Template,
    /// The numbers in it.
    numbers: Vec<f64>,
    kernel: Kernel,
    /// What the results after the first, the value, are.
    partials: Vec<Partial>,
    /// Of a polynomial of degree two in many arguments.
    quadratic: Option<Quadratic>,
    /// Where what the prelude computes, or a quadratic form, stands among those of all costs.
    offset: usize,
}

/// A polynomial of degree two, c + gᵀx + ½ xᵀH x.
#[derive(Clone, Debug)]
struct Quadratic {
    /// The second derivatives H by columns, which are constant.
    second: Kernel,
    /// The value as it is written, for where the sum cancels: a sum of squares far smaller than the numbers in it.
    value: Kernel,
}

/// Of the magnitudes that are added up in a value, at least so much must be left of it.
const LEAST_LEFT: f64 = 1.0 / 64.0;

/// For fewer arguments than these a program is at least as fast as a matrix.
const FEW: usize = 6;

/// An instruction takes as long as so many entries of a matrix: a sum of squares has more entries than that, a full quadratic form has not.
const ENTRIES: usize = 8;

/// What preludes computed for a set of design variables, and memory for registers.
#[derive(Clone, Debug, Default)]
pub struct CostMemory {
    /// Whether the programs of all costs can be run: those that were fixed, for formulas as they are now.
    pub is_ready: bool,
    /// The design variables that preludes were run for.
    pub design: Vec<f64>,
    fixed: Vec<f64>,
    registers: Vec<[f64; 1]>,
    /// x, then H x.
    x: Vec<f64>,
    product: Vec<f64>,
}

impl CostFormula {
    /// Of a recorded cost with so many arguments; `bound` says which constants are design variables.
    pub fn new(
        (template, numbers): (Template, Vec<f64>),
        arguments: usize,
        bound: &[bool],
        offset: usize,
    ) -> Result<Self, Obstacle> {
        let (mut graph, values) = template.graph();
        let depends = template.depends(arguments);
        let (partials, slopes) = gradient(&mut graph, values[0], Partial::all(&depends, bound));
        let results = [&values[..1], &slopes].concat();
        let kernel = Kernel::new(&mut graph, template.parameters, &results).ok_or(Obstacle::IsTooLong)?;
        let is_worth_it = partials.len() >= FEW && partials.len().pow(2) <= ENTRIES * kernel.main().len();
        let quadratic = is_worth_it.then(|| quadratic(&mut graph, &partials, &results, template.parameters)).flatten();
        Ok(CostFormula { depends, template, numbers, kernel, partials, quadratic, offset })
    }

    /// Where the next cost's fixed numbers may stand.
    pub fn end(&self) -> usize {
        let n = self.partials.len();
        self.offset + self.quadratic.as_ref().map_or(self.kernel.fixed(), |form| n * n + 2 * n + 1 + form.value.fixed())
    }

    /// Takes over constants, and the numbers in the formula if it was recorded anew; whether its program is still the right one.
    pub fn fix(&self, b: &[f64], now: Option<&(Template, Vec<f64>)>, memory: &mut CostMemory) -> bool {
        let numbers = now.map_or(&self.numbers, |(_, numbers)| numbers);
        if now.is_some_and(|(template, _)| *template != self.template) {
            return false;
        }
        let parameters: Vec<f64> = b.iter().chain(numbers).copied().collect();
        memory.fixed.resize(memory.fixed.len().max(self.end()), 0.0);
        let program = self.program();
        memory.registers.resize(memory.registers.len().max(program.main().registers()), [0.0]);
        let (n, first) = (self.partials.len(), self.first_of_prelude());
        program.run_prelude(&parameters, |k, value| memory.fixed[first + k] = value);
        let Some(form) = &self.quadratic else { return true };
        memory.x.resize(memory.x.len().max(n), 0.0);
        memory.product.resize(memory.product.len().max(n), 0.0);
        let (matrix, rest) = memory.fixed[self.offset..first].split_at_mut(n * n);
        matrix.copy_from_slice(&form.second.evaluate(&parameters, |_| 0.0));
        let (sums, at_zero) = rest.split_at_mut(n);
        at_zero.copy_from_slice(&self.kernel.evaluate(&parameters, |_| 0.0));
        for (sum, column) in sums.iter_mut().zip(matrix.chunks_exact(n)) {
            *sum = column.iter().map(|h| h.abs()).sum();
        }
        memory.fixed[self.offset..first].iter().all(|x| x.is_finite())
    }

    /// What runs at every node: value and slopes, or the value alone where a matrix makes the slopes.
    fn program(&self) -> &Kernel {
        self.quadratic.as_ref().map_or(&self.kernel, |form| &form.value)
    }

    /// Where what its prelude computes stands, behind the quadratic form if there is one.
    fn first_of_prelude(&self) -> usize {
        self.end() - self.program().fixed()
    }

    /// c + gᵀx + ½ xᵀH x, with c and g at zero, unless it cancels; and g + H x.
    fn evaluate_quadratic(
        &self,
        memory: &mut CostMemory,
        argument: impl Fn(usize) -> f64,
        mut put: impl FnMut(Partial, f64),
    ) -> Option<f64> {
        let (n, CostMemory { fixed, x, product, .. }) = (self.partials.len(), memory);
        let (matrix, rest) = fixed[self.offset..self.first_of_prelude()].split_at(n * n);
        let (sums, at_zero) = rest.split_at(n);
        let (constant, gradient) = (at_zero[0], &at_zero[1..]);
        let (x, product) = (&mut x[..n], &mut product[..n]);
        for (x, of) in x.iter_mut().zip(&self.partials) {
            *x = if let Partial::Argument(which) = of { argument(*which) } else { 0.0 };
        }
        product.fill(0.0);
        for (column, x) in matrix.chunks_exact(n).zip(&*x) {
            product.iter_mut().zip(column).for_each(|(y, h)| *y += h * x);
        }
        for ((of, y), g) in self.partials.iter().zip(&*product).zip(gradient) {
            put(*of, g + y);
        }
        let (mut value, mut magnitude) = (constant, constant.abs());
        for ((x, g), (y, sum)) in x.iter().zip(gradient).zip(product.iter().zip(sums)) {
            value += x * (g + 0.5 * y);
            // |x_i H_ij x_j| is at most ½ |H_ij| (x_i² + x_j²).
            magnitude += (x * g).abs() + 0.5 * sum * x * x;
        }
        (value.abs() >= LEAST_LEFT * magnitude).then_some(value)
    }

    /// The value, and each partial derivative by what it is one.
    pub fn evaluate(
        &self,
        memory: &mut CostMemory,
        argument: impl Fn(usize) -> f64,
        mut put: impl FnMut(Partial, f64),
    ) -> f64 {
        if self.quadratic.is_some()
            && let Some(value) = self.evaluate_quadratic(memory, &argument, &mut put)
        {
            return value;
        }
        let (program, CostMemory { fixed, registers, .. }) = (self.program(), &mut *memory);
        let fixed = &fixed[self.first_of_prelude()..self.end()];
        let given = program.inputs().iter().map(|&which| argument(which)).chain(fixed.iter().copied());
        registers.iter_mut().zip(given).for_each(|(register, x)| *register = [x]);
        program.main().run(registers);
        let mut results = program.main().results().map(|register| registers[register][0]);
        let value = results.next().unwrap_or(0.0);
        if self.quadratic.is_none() {
            self.partials.iter().zip(results).for_each(|(of, slope)| put(*of, slope));
        }
        value
    }
}

/// A polynomial of degree two, if it is one of arguments alone; from its value and slopes.
fn quadratic(graph: &mut Graph, partials: &[Partial], results: &[Node], parameters: usize) -> Option<Quadratic> {
    let one = graph.constant(1.0);
    let mut second = Vec::new();
    for of in partials {
        let Partial::Argument(which) = of else { return None };
        let x = graph.input(*which);
        second.extend(graph.forward(&results[1..], &[(x, one)]));
    }
    let is_quadratic = !second.is_empty() && second.iter().all(|node| graph.is_fixed(*node));
    if !is_quadratic || graph.is_piecewise(results.iter().copied()) {
        return None;
    }
    let [second, value] = [&second[..], &results[..1]].map(|results| Kernel::new(graph, parameters, results));
    Some(Quadratic { second: second?, value: value? })
}

/// The partial derivatives of a node, without those that vanish.
pub(super) fn gradient(graph: &mut Graph, value: Node, of: Vec<Partial>) -> (Vec<Partial>, Vec<Node>) {
    let one = graph.constant(1.0);
    let arguments: Vec<Node> = of
        .iter()
        .map(|of| match of {
            Partial::Argument(which) => graph.input(*which),
            Partial::Constant(p) => graph.parameter(*p),
        })
        .collect();
    let slopes = graph.reverse(&[(value, one)], &arguments);
    without_zeros(graph, of.into_iter().zip(slopes))
}
