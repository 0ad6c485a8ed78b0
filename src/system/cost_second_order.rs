//! [`CostSecondOrder`]: the program for the change of a cost's value and gradient along a direction.

use super::cost_formula::{Partial, gradient};
use crate::program::{Kernel, Template};

/// The program whose results are h, D h, the partial derivatives of h, and D of these.
#[derive(Clone, Debug)]
pub struct CostSecondOrder {
    kernel: Kernel,
    pub partials: Vec<Partial>,
    arguments: usize,
    /// The numbers in the formula.
    numbers: Vec<f64>,
    fixed: Vec<f64>,
    registers: Vec<[f64; 1]>,
}

impl CostSecondOrder {
    /// Compiles a recorded cost with the given number of arguments; `bound` marks the constants that are design variables.
    ///
    /// The program's arguments are those of the cost, their rates, and the rates of the constants.
    pub fn new((template, numbers): (Template, Vec<f64>), arguments: usize, bound: &[bool]) -> Option<Self> {
        let (mut graph, values) = template.graph();
        let of = Partial::all(&template.depends(arguments), bound);
        let tangents = Vec::from_iter(of.iter().map(|of| match *of {
            Partial::Argument(which) => (graph.input(which), graph.input(arguments + which)),
            Partial::Constant(p) => (graph.parameter(p), graph.input(2 * arguments + p)),
        }));
        let (partials, slopes) = gradient(&mut graph, values[0], of);
        let first = [&values[..1], &slopes].concat();
        let changes = graph.forward(&first, &tangents);
        let results = [&first[..1], &changes[..1], &first[1..], &changes[1..]].concat();
        let kernel = Kernel::new(&mut graph, template.parameters, &results)?;
        let (fixed, registers) = (vec![0.0; kernel.fixed()], vec![[0.0]; kernel.main().registers()]);
        Some(CostSecondOrder { kernel, partials, arguments, numbers, fixed, registers })
    }

    /// Sets the values of the constants.
    pub fn fix(&mut self, b: impl Iterator<Item = f64>) {
        let parameters: Vec<f64> = b.chain(self.numbers.iter().copied()).collect();
        self.kernel.run_prelude(&parameters, |k, value| self.fixed[k] = value);
    }

    /// Returns h and D h, and passes on each partial derivative with its change.
    pub fn evaluate(
        &mut self,
        argument: impl Fn(usize) -> f64,
        rate: impl Fn(usize) -> f64,
        rate_of_constant: impl Fn(usize) -> f64,
        mut put: impl FnMut(Partial, [f64; 2]),
    ) -> [f64; 2] {
        let CostSecondOrder { kernel, partials, arguments, fixed, registers, .. } = self;
        let given = kernel.inputs().iter().map(|&which| match which.checked_sub(*arguments) {
            None => argument(which),
            Some(of) if of < *arguments => rate(of),
            Some(of) => rate_of_constant(of - *arguments),
        });
        registers.iter_mut().zip(given.chain(fixed.iter().copied())).for_each(|(register, x)| *register = [x]);
        kernel.main().run(registers);
        let from = |first: usize| kernel.main().results().skip(first).map(|register| registers[register][0]);
        for (of, (slope, change)) in partials.iter().zip(from(2).zip(from(2 + partials.len()))) {
            put(*of, [slope, change]);
        }
        let mut first = from(0);
        [0, 1].map(|_| first.next().unwrap_or(0.0))
    }
}
