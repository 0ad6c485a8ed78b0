//! [`CostFormula`]: a recorded cost and the program for its value and gradient.

use std::sync::Arc;

use super::cost_program::CostProgram;
use crate::program::Template;
use crate::system::formula::Slot;

/// The program of a cost with its numbers.
#[derive(Clone, Debug)]
pub struct CostFormula {
    pub program: Arc<CostProgram>,
    /// The numbers in the formula.
    numbers: Vec<f64>,
    /// The first index of this cost's part of `CostMemory::fixed`: the quadratic form, if any, and the results of the prelude.
    offset: usize,
}

/// Smallest accepted ratio of a value to the sum of the magnitudes of its terms. Below it, as for squares of small differences of large
/// numbers, the original formula is evaluated.
const LEAST_OF_VALUE: f64 = 1.0 / 64.0;
/// Smallest accepted ratio of a slope to the sum of the magnitudes of its terms.
const LEAST_OF_SLOPE: f64 = 1.0 / 1024.0;

/// Results of the preludes for one set of design variables, and memory for registers.
#[derive(Clone, Debug, Default)]
pub struct CostMemory {
    /// Whether the programs of all costs are prepared and agree with the present formulas.
    pub is_ready: bool,
    /// The formulas and the design variables for which the preludes were run.
    pub fingerprint: Option<u64>,
    pub design: Vec<f64>,
    fixed: Vec<f64>,
    registers: Vec<[f64; 1]>,
    /// x, H x, and Σ |H_ij x_j|.
    x: Vec<f64>,
    product: Vec<f64>,
    sizes: Vec<f64>,
}

impl CostFormula {
    pub fn new(program: Arc<CostProgram>, numbers: Vec<f64>, offset: usize) -> Self {
        CostFormula { program, numbers, offset }
    }

    /// The first index that the next cost may use.
    pub fn end(&self) -> usize {
        self.first_of_prelude() + self.program.kernel.fixed()
    }

    /// Sets the constants and, if the formula was recorded again, the plain numbers in it. Returns whether the program still applies.
    pub fn fix(&self, b: &[f64], now: Option<&(Template, Vec<f64>)>, memory: &mut CostMemory) -> bool {
        let numbers = now.map_or(&self.numbers, |(_, numbers)| numbers);
        if now.is_some_and(|(template, _)| *template != self.program.template) {
            return false;
        }
        let parameters: Vec<f64> = b.iter().chain(numbers).copied().collect();
        memory.fixed.resize(memory.fixed.len().max(self.end()), 0.0);
        memory.registers.resize(memory.registers.len().max(self.program.kernel.main().registers()), [0.0]);
        let (n, first) = (self.program.partials.len(), self.first_of_prelude());
        self.program.kernel.run_prelude(&parameters, |k, value| memory.fixed[first + k] = value);
        let Some(form) = &self.program.quadratic else { return true };
        for list in [&mut memory.x, &mut memory.product, &mut memory.sizes] {
            list.resize(list.len().max(n), 0.0);
        }
        let (matrix, at_zero) = memory.fixed[self.offset..first].split_at_mut(n * n);
        matrix.copy_from_slice(&form.second.evaluate(&parameters, |_| 0.0));
        at_zero.copy_from_slice(&self.program.kernel.evaluate(&parameters, |_| 0.0));
        memory.fixed[self.offset..first].iter().all(|x| x.is_finite())
    }

    /// The first index of the results of the prelude, which follow the quadratic form if there is one.
    fn first_of_prelude(&self) -> usize {
        let n = self.program.partials.len();
        self.offset + if self.program.quadratic.is_some() { n * n + 1 + n } else { 0 }
    }

    /// Computes c + gᵀx + ½ xᵀH x and g + H x, with c and g evaluated at zero; returns `None` if digits cancel.
    fn evaluate_quadratic(
        &self,
        may_cancel: bool,
        memory: &mut CostMemory,
        read: impl Fn(Slot) -> f64,
        mut put: impl FnMut(usize, f64),
    ) -> Option<f64> {
        let (n, CostMemory { fixed, x, product, sizes, .. }) = (self.program.partials.len(), memory);
        let (matrix, at_zero) = fixed[self.offset..self.first_of_prelude()].split_at(n * n);
        let (constant, gradient) = (at_zero[0], &at_zero[1..]);
        let (x, product, sizes) = (&mut x[..n], &mut product[..n], &mut sizes[..n]);
        x.iter_mut().zip(&self.program.partials).for_each(|(x, of)| *x = read(*of));
        multiply(matrix, x, product, |h, x| h * x);
        let value = x.iter().zip(gradient).zip(&*product).fold(constant, |value, ((x, g), y)| value + x * (g + 0.5 * y));
        product.iter_mut().zip(gradient).for_each(|(y, g)| *y += g);
        if may_cancel {
            multiply(matrix, x, sizes, |h, x| (h * x).abs());
            let (mut magnitude, mut cancels) = (constant.abs(), false);
            for ((x, g), (slope, size)) in x.iter().zip(gradient).zip(product.iter().zip(&*sizes)) {
                magnitude += x.abs() * (g.abs() + 0.5 * size);
                cancels |= slope.abs() < LEAST_OF_SLOPE * (g.abs() + size);
            }
            if cancels || value.abs() < LEAST_OF_VALUE * magnitude {
                return None;
            }
        }
        product.iter().enumerate().for_each(|(k, slope)| put(k, *slope));
        Some(value)
    }

    /// Returns the value, and passes each partial derivative to `put`.
    pub fn evaluate(&self, memory: &mut CostMemory, read: impl Fn(Slot) -> f64, mut put: impl FnMut(usize, f64)) -> f64 {
        if let Some(form) = &self.program.quadratic
            && let Some(value) = self.evaluate_quadratic(form.may_cancel, memory, &read, &mut put)
        {
            return value;
        }
        let CostMemory { fixed, registers, .. } = memory;
        let fixed = &fixed[self.first_of_prelude()..self.end()];
        let given = self.program.inputs.iter().map(|slot| read(*slot)).chain(fixed.iter().copied());
        registers.iter_mut().zip(given).for_each(|(register, x)| *register = [x]);
        self.program.kernel.main().run(registers);
        let mut results = self.program.kernel.main().results().map(|register| registers[register][0]);
        let value = results.next().unwrap_or(0.0);
        results.enumerate().for_each(|(k, slope)| put(k, slope));
        value
    }
}

/// Sums the products of a matrix's columns with a vector.
fn multiply(columns: &[f64], x: &[f64], into: &mut [f64], product: impl Fn(f64, f64) -> f64) {
    into.fill(0.0);
    for (column, &x) in columns.chunks_exact(into.len()).zip(x) {
        into.iter_mut().zip(column).for_each(|(y, &h)| *y += product(h, x));
    }
}
