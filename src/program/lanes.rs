//! [`Lanes`]: a kernel for many elements of one shape, in groups that are computed side by side.

use super::kernel::Kernel;

/// Elements that are computed side by side, as many as there are lanes; the last ones repeat the last element.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    first: usize,
    elements: usize,
    lanes: usize,
    /// The number of lanes before it.
    offset: usize,
}

/// A kernel and where each element takes its inputs from.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    kernel: Kernel,
    chunks: Vec<Chunk>,
    lanes: usize,
    /// Of each chunk, the places of the inputs, lane by lane.
    sources: Vec<u32>,
}

/// Groups of sixteen, of eight or four for what is left, and one by itself: to read an instruction takes as long as to do it for eight.
fn chunks(elements: usize) -> Vec<Chunk> {
    let (mut chunks, mut first, mut offset) = (Vec::new(), 0, 0);
    while first < elements {
        let lanes = match elements - first {
            1 => 1,
            2..=4 => 4,
            5..=12 => 8,
            _ => 16,
        };
        chunks.push(Chunk { first, elements: lanes.min(elements - first), lanes, offset });
        first += lanes;
        offset += lanes;
    }
    chunks
}

impl Lanes {
    /// Places a kernel: `source` says where input number `which` of an element stands among all of a point.
    pub(crate) fn new(kernel: Kernel, elements: usize, source: impl Fn(usize, usize) -> usize) -> Self {
        let chunks = chunks(elements);
        let mut sources = Vec::new();
        for chunk in &chunks {
            for &which in kernel.inputs() {
                let element = |lane: usize| chunk.first + lane.min(chunk.elements - 1);
                sources.extend((0..chunk.lanes).map(|lane| source(element(lane), which) as u32));
            }
        }
        let lanes = chunks.iter().map(|chunk| chunk.lanes).sum();
        Lanes { kernel, chunks, lanes, sources }
    }

    pub(crate) fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// Registers for all elements, in which what preludes compute stays, and what a stage leaves to the next one.
    pub(crate) fn registers(&self) -> Vec<f64> {
        vec![0.0; self.lanes * self.kernel.main().registers()]
    }

    /// Runs the prelude of every element.
    pub(crate) fn fix(&self, parameters: impl Fn(usize) -> Vec<f64>, registers: &mut [f64]) {
        let inputs = self.kernel.inputs().len();
        for chunk in &self.chunks {
            let own = self.own(chunk, registers);
            for lane in 0..chunk.lanes {
                let parameters = parameters(chunk.first + lane.min(chunk.elements - 1));
                self.kernel.run_prelude(&parameters, |k, value| own[(inputs + k) * chunk.lanes + lane] = value);
            }
        }
    }

    /// The registers of some elements.
    fn own<'a>(&self, chunk: &Chunk, registers: &'a mut [f64]) -> &'a mut [f64] {
        let of_lane = self.kernel.main().registers();
        &mut registers[chunk.offset * of_lane..][..chunk.lanes * of_lane]
    }

    /// Runs the kernel, or its first stage, for all elements at a point; `put` gets the first of some elements, the number of the result and
    /// their values.
    pub(crate) fn run(&self, point: &[f64], registers: &mut [f64], put: impl FnMut(usize, usize, &[f64])) {
        let inputs = self.kernel.inputs().len();
        for chunk in &self.chunks {
            let sources = &self.sources[chunk.offset * inputs..][..chunk.lanes * inputs];
            let given = &mut self.own(chunk, registers)[..sources.len()];
            given.iter_mut().zip(sources).for_each(|(register, &place)| *register = point[place as usize]);
        }
        self.go_on(0, registers, put);
    }

    /// Goes on with a later stage, at the point of the last `run`.
    pub(crate) fn go_on(&self, stage: usize, registers: &mut [f64], mut put: impl FnMut(usize, usize, &[f64])) {
        for chunk in &self.chunks {
            match chunk.lanes {
                1 => self.run_stage::<1>(chunk, stage, registers, &mut put),
                4 => self.run_stage::<4>(chunk, stage, registers, &mut put),
                8 => self.run_stage::<8>(chunk, stage, registers, &mut put),
                _ => self.run_stage::<16>(chunk, stage, registers, &mut put),
            }
        }
    }

    #[inline]
    fn run_stage<const L: usize>(
        &self,
        chunk: &Chunk,
        stage: usize,
        registers: &mut [f64],
        put: &mut impl FnMut(usize, usize, &[f64]),
    ) {
        let (program, registers) = (self.kernel.stage(stage), self.own(chunk, registers).as_chunks_mut::<L>().0);
        program.run(registers);
        if chunk.elements == L {
            // Of a length that the compiler knows.
            program.results().enumerate().for_each(|(k, register)| put(chunk.first, k, &registers[register]));
        } else {
            program
                .results()
                .enumerate()
                .for_each(|(k, register)| put(chunk.first, k, &registers[register][..chunk.elements]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Function, Graph};

    #[test]
    fn a_stage_goes_on_with_what_the_one_before_computed_and_may_be_run_again() {
        // f = b exp(y sin x), then f_x and f_xx.
        let mut graph = Graph::default();
        let [x, y] = [0, 1].map(|which| graph.input(which));
        let b = graph.parameter(0);
        let sine = graph.function(Function::Sin, x);
        let exponent = graph.multiply(y, sine);
        let exp = graph.function(Function::Exp, exponent);
        let f = graph.multiply(b, exp);
        let one = graph.constant(1.0);
        let slope = graph.forward(&[f], &[(x, one)])[0];
        let second = graph.forward(&[slope], &[(x, one)])[0];
        let kernel = Kernel::in_stages(&mut graph, 1, &[&[f], &[slope, second]]).expect("short");
        let text = kernel.stage(1).to_string();
        assert!(!text.contains("exp") && !text.contains("sin") && !text.contains("cos"), "{text}");

        [1, 3, 11, 14, 37].into_iter().for_each(|elements| run_stages(&kernel, elements));
    }

    /// Holds every element to the formulas, at two points.
    fn run_stages(kernel: &Kernel, elements: usize) {
        let number = |k: usize| (0.7 * k as f64).sin();
        let lanes = Lanes::new(kernel.clone(), elements, |element, which| 2 * element + which);
        let mut registers = lanes.registers();
        lanes.fix(|element| vec![1.0 + number(element)], &mut registers);
        for round in 0..2 {
            let point: Vec<f64> = (0..2 * elements).map(|k| number(k + 5 * round)).collect();
            let expected = |e: usize| {
                let (sin, cos) = point[2 * e].sin_cos();
                let (y, f) = (point[2 * e + 1], (1.0 + number(e)) * (point[2 * e + 1] * sin).exp());
                [f, f * y * cos, f * (y * cos * y * cos - y * sin)]
            };
            let mut count = 0;
            let mut holds = |first: usize, which: usize, values: &[f64]| {
                for (k, value) in values.iter().enumerate() {
                    let expected = expected(first + k)[which];
                    assert!((value - expected).abs() < 1e-14, "{value} {expected}");
                }
                count += values.len();
            };
            lanes.run(&point, &mut registers, |first, _, values| holds(first, 0, values));
            lanes.go_on(1, &mut registers, |first, k, values| holds(first, 1 + k, values));
            lanes.go_on(1, &mut registers, |first, k, values| holds(first, 1 + k, values));
            assert_eq!(count, 5 * elements);
        }
    }
}
