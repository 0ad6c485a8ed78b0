//! [`CostFormula`]: a recorded cost, and the program for its value and gradient.

use crate::program::{Graph, Kernel, Node, Obstacle, Template};

/// What a cost is differentiated by: one of its arguments, or one of its constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partial {
    Argument(usize),
    Constant(usize),
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
    /// Where what the prelude computes stands among that of all costs.
    offset: usize,
}

/// What preludes computed for a set of design variables, and memory for registers.
#[derive(Clone, Debug, Default)]
pub struct CostMemory {
    /// Whether the programs of all costs can be run: those that were fixed, for formulas as they are now.
    pub is_ready: bool,
    /// The design variables that preludes were run for.
    pub design: Vec<f64>,
    fixed: Vec<f64>,
    registers: Vec<[f64; 1]>,
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
        let of = (0..arguments).filter(|&i| depends[i]).map(Partial::Argument);
        let of: Vec<Partial> = of.chain((0..bound.len()).filter(|&p| bound[p]).map(Partial::Constant)).collect();
        let (partials, slopes) = gradient(&mut graph, values[0], of);
        let results = [&values[..1], &slopes].concat();
        let kernel = Kernel::new(&mut graph, template.parameters, &results).ok_or(Obstacle::IsTooLong)?;
        Ok(CostFormula { depends, template, numbers, kernel, partials, offset })
    }

    /// Where the next cost's fixed numbers may stand.
    pub fn end(&self) -> usize {
        self.offset + self.kernel.fixed()
    }

    /// Takes over constants, and the numbers in the formula if it was recorded anew; whether its program is still the right one.
    pub fn fix(&self, b: &[f64], now: Option<&(Template, Vec<f64>)>, memory: &mut CostMemory) -> bool {
        let numbers = now.map_or(&self.numbers, |(_, numbers)| numbers);
        if now.is_some_and(|(template, _)| *template != self.template) {
            return false;
        }
        let parameters: Vec<f64> = b.iter().chain(numbers).copied().collect();
        memory.fixed.resize(memory.fixed.len().max(self.end()), 0.0);
        memory.registers.resize(memory.registers.len().max(self.kernel.main().registers()), [0.0]);
        self.kernel.run_prelude(&parameters, |k, value| memory.fixed[self.offset + k] = value);
        true
    }

    /// The value, and each partial derivative by what it is one.
    pub fn evaluate(
        &self,
        memory: &mut CostMemory,
        argument: impl Fn(usize) -> f64,
        mut put: impl FnMut(Partial, f64),
    ) -> f64 {
        let CostMemory { fixed, registers, .. } = memory;
        let given =
            self.kernel.inputs().iter().map(|&which| argument(which)).chain(fixed[self.offset..self.end()].iter().copied());
        registers.iter_mut().zip(given).for_each(|(register, x)| *register = [x]);
        self.kernel.main().run(registers);
        let mut results = self.kernel.main().results().map(|register| registers[register][0]);
        let value = results.next().unwrap_or(0.0);
        self.partials.iter().zip(results).for_each(|(of, slope)| put(*of, slope));
        value
    }
}

/// The partial derivatives of a node, without those that vanish.
fn gradient(graph: &mut Graph, value: Node, of: Vec<Partial>) -> (Vec<Partial>, Vec<Node>) {
    let one = graph.constant(1.0);
    let arguments: Vec<Node> = of
        .iter()
        .map(|of| match of {
            Partial::Argument(which) => graph.input(*which),
            Partial::Constant(p) => graph.parameter(*p),
        })
        .collect();
    let slopes = graph.reverse(&[(value, one)], &arguments);
    of.into_iter().zip(slopes).filter(|(_, slope)| !graph.is_zero(*slope)).unzip()
}
