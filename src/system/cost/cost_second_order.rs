//! [`CostSecondOrder`]: the program for the change of a cost's value and gradient along a direction.

use super::cost_program::{gradient, plain};
use crate::program::{Kernel, Template};
use crate::system::formula::{Shape, Slot};

/// Its results are h, D h, the partial derivatives of h and D of them.
#[derive(Clone, Debug)]
pub struct CostSecondOrder {
    kernel: Kernel,
    /// The variables of the partial derivatives.
    partials: Vec<Slot>,
    /// The arguments of the program, and whether each stands for its rate.
    inputs: Vec<(Slot, bool)>,
    /// The numbers in the formula.
    numbers: Vec<f64>,
    fixed: Vec<f64>,
    registers: Vec<[f64; 1]>,
}

impl CostSecondOrder {
    /// Compiles a recorded cost with derivatives with respect to these variables.
    ///
    /// Arguments of the program are those of the cost, then their rates and those of the constants.
    pub fn new((template, numbers): (Template, Vec<f64>), shape: Shape, variables: Vec<Slot>) -> Option<Self> {
        let (mut graph, values) = template.graph();
        let of_slot = |slot: &Slot| {
            let rate = graph.input(shape.len() + shape.number(*slot));
            (shape.node(&mut graph, *slot), rate)
        };
        let tangents: Vec<_> = variables.iter().map(of_slot).collect();
        let (partials, slopes) = gradient(&mut graph, shape, values[0], variables);
        let first = [&values[..1], &slopes].concat();
        let changes = graph.forward(&first, &tangents);
        let results = [&first[..1], &changes[..1], &first[1..], &changes[1..]].concat();
        let kernel = Kernel::new(&mut graph, template.parameters, &results)?;
        let input = |&which: &usize| {
            let rate = which.checked_sub(shape.len());
            (plain(shape, rate.unwrap_or(which)), rate.is_some())
        };
        let inputs = kernel.inputs().iter().map(input).collect();
        let (fixed, registers) = (vec![0.0; kernel.fixed()], vec![[0.0]; kernel.main().registers()]);
        Some(CostSecondOrder { kernel, partials, inputs, numbers, fixed, registers })
    }

    /// Sets the values of the constants.
    pub fn fix(&mut self, b: impl Iterator<Item = f64>) {
        let parameters: Vec<f64> = b.chain(self.numbers.iter().copied()).collect();
        self.kernel.run_prelude(&parameters, |k, value| self.fixed[k] = value);
    }

    /// Returns h and D h; `put` receives each partial derivative with its change, by its variable.
    pub fn evaluate(
        &mut self,
        read: impl Fn(Slot) -> f64,
        rate: impl Fn(Slot) -> f64,
        mut put: impl FnMut(Slot, [f64; 2]),
    ) -> [f64; 2] {
        let CostSecondOrder { kernel, partials, inputs, fixed, registers, .. } = self;
        let given = inputs.iter().map(|&(slot, is_rate)| if is_rate { rate(slot) } else { read(slot) });
        registers.iter_mut().zip(given.chain(fixed.iter().copied())).for_each(|(register, x)| *register = [x]);
        kernel.main().run(registers);
        let from = |first: usize| kernel.main().results().skip(first).map(|register| registers[register][0]);
        for (slot, (slope, change)) in partials.iter().zip(from(2).zip(from(2 + partials.len()))) {
            put(*slot, [slope, change]);
        }
        let mut first = from(0);
        [0, 1].map(|_| first.next().unwrap_or(0.0))
    }
}
