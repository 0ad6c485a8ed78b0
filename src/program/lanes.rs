//! [`Lanes`]: a kernel for many elements with a common formula, evaluated side by side in chunks.

use std::ops::Range;
use std::sync::Arc;

use super::kernel::Kernel;
use super::places::Places;
use super::program::Program;

/// Elements that are computed side by side. If there are fewer elements than lanes, the last lanes repeat the last element; in the last of several
/// chunks, the first lanes repeat elements of the chunk before.
#[derive(Clone, Debug)]
struct Chunk {
    first: usize,
    /// The lanes whose results are used.
    own: Range<usize>,
    lanes: usize,
    /// The total number of lanes in earlier chunks.
    offset: usize,
}

/// A kernel, and the places from which each element reads its inputs.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    kernel: Arc<Kernel>,
    chunks: Vec<Chunk>,
    lanes: usize,
    /// The places of the inputs, for each chunk.
    sources: Vec<Places>,
}

/// Chunks of sixteen lanes, of eight or four for the rest, and of one: decoding an instruction takes as long as executing it for eight elements.
fn chunks(elements: usize) -> Vec<Chunk> {
    let (mut chunks, mut done, mut offset) = (Vec::new(), 0, 0);
    while done < elements {
        let lanes = match elements - done {
            1 => 1,
            2..=4 => 4,
            5..=12 => 8,
            _ => 16,
        };
        let first = done.min(elements.saturating_sub(lanes));
        let end = (done + lanes).min(elements);
        chunks.push(Chunk { first, own: done - first..end - first, lanes, offset });
        (done, offset) = (end, offset + lanes);
    }
    chunks
}

impl Chunk {
    /// The element of a lane.
    fn element(&self, lane: usize) -> usize {
        self.first + lane.min(self.own.end - 1)
    }

    /// The places of the numbers of this chunk's elements.
    fn places(&self, numbers: usize, place: impl Fn(usize, usize) -> usize) -> Places {
        let of = |number| (0..self.lanes).map(move |lane| (self.element(lane), number));
        Places::new((0..numbers).flat_map(of).map(|(element, number)| place(element, number) as u32).collect(), self.lanes)
    }
}

/// The results of a chunk, stored in registers.
#[derive(Clone, Copy)]
struct Results<'a, const L: usize> {
    program: &'a Program,
    registers: &'a [[f64; L]],
}

impl<'a, const L: usize> Results<'a, L> {
    fn iter(self) -> impl Iterator<Item = &'a [f64; L]> {
        self.program.results().map(move |register| &self.registers[register])
    }
}

/// The destination of results.
trait Sink {
    /// Stores the results of chunk number `which`.
    fn take<const L: usize>(&mut self, which: usize, chunk: &Chunk, results: Results<L>);
}

/// Passes each result of the given lanes to `to`: the first element, the number of the result, and the values.
#[inline(always)]
fn show<const L: usize>(chunk: &Chunk, lanes: Range<usize>, results: Results<L>, to: &mut impl FnMut(usize, usize, &[f64])) {
    // Plain loops compile faster than iterators that are passed on, because this code is compiled for every `to`.
    if lanes.len() == L {
        // The length of this slice is known to the compiler.
        for (k, values) in results.iter().enumerate() {
            to(chunk.first, k, values);
        }
    } else {
        for (k, values) in results.iter().enumerate() {
            to(chunk.first + lanes.start, k, &values[lanes.clone()]);
        }
    }
}

/// Passes every element once.
struct Put<F>(F);

impl<F: FnMut(usize, usize, &[f64])> Sink for Put<F> {
    #[inline]
    fn take<const L: usize>(&mut self, _: usize, chunk: &Chunk, results: Results<L>) {
        show(chunk, chunk.own.clone(), results, &mut self.0);
    }
}

/// Also passes the elements repeated from the previous chunk, so that most slices have the full number of lanes.
struct Write<F>(F);

impl<F: FnMut(usize, usize, &[f64])> Sink for Write<F> {
    #[inline]
    fn take<const L: usize>(&mut self, _: usize, chunk: &Chunk, results: Results<L>) {
        show(chunk, 0..chunk.own.end, results, &mut self.0);
    }
}

/// Adds the results to sums, and subtracts the first of them elsewhere.
struct Add<'a> {
    targets: [&'a [Places]; 2],
    sums: &'a mut [f64],
}

impl Sink for Add<'_> {
    #[inline]
    fn take<const L: usize>(&mut self, which: usize, chunk: &Chunk, results: Results<L>) {
        let [plus, minus] = self.targets.map(|targets| &targets[which]);
        if chunk.own.len() == L {
            plus.add(results.iter().copied(), self.sums);
            minus.add(results.iter().map(negative), self.sums);
        } else {
            let counted = |values: &[f64; L]| {
                let mut counted = [0.0; L];
                counted[chunk.own.clone()].copy_from_slice(&values[chunk.own.clone()]);
                counted
            };
            plus.add(results.iter().map(counted), self.sums);
            minus.add(results.iter().map(|values| negative(&counted(values))), self.sums);
        }
    }
}

#[inline(always)]
fn negative<const L: usize>(values: &[f64; L]) -> [f64; L] {
    values.map(|x| -x)
}

impl Lanes {
    /// Prepares a kernel for a number of elements; `source` returns the place of input number `which` of an element in a point.
    pub(crate) fn new(kernel: Arc<Kernel>, elements: usize, source: impl Fn(usize, usize) -> usize) -> Self {
        let (chunks, inputs) = (chunks(elements), kernel.inputs());
        let sources = chunks.iter().map(|chunk| chunk.places(inputs.len(), |element, k| source(element, inputs[k])));
        let (sources, lanes) = (sources.collect(), chunks.iter().map(|chunk| chunk.lanes).sum());
        Lanes { kernel, chunks, lanes, sources }
    }

    /// The places to which the first results of the first stage are added; `target` returns the place for an element and the number of a result.
    pub(crate) fn targets(&self, results: usize, target: impl Fn(usize, usize) -> usize) -> Vec<Places> {
        self.chunks.iter().map(|chunk| chunk.places(results, &target)).collect()
    }

    pub(crate) fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// Registers for all elements; they keep the results of the preludes, and those of a stage for the next one.
    pub(crate) fn registers(&self) -> Vec<f64> {
        vec![0.0; self.lanes * self.kernel.main().registers()]
    }

    /// Runs the prelude of every element.
    pub(crate) fn fix(&self, parameters: impl Fn(usize) -> Vec<f64>, registers: &mut [f64]) {
        let inputs = self.kernel.inputs().len();
        for chunk in &self.chunks {
            let own = self.own(chunk, registers);
            for lane in 0..chunk.lanes {
                let parameters = parameters(chunk.element(lane));
                self.kernel.run_prelude(&parameters, |k, value| own[(inputs + k) * chunk.lanes + lane] = value);
            }
        }
    }

    /// The registers of the elements of a chunk.
    fn own<'a>(&self, chunk: &Chunk, registers: &'a mut [f64]) -> &'a mut [f64] {
        let of_lane = self.kernel.main().registers();
        &mut registers[chunk.offset * of_lane..][..chunk.lanes * of_lane]
    }

    /// Runs the kernel, or its first stage, for all elements at a point; `put` receives the first of several elements, the number of the result and
    /// their values.
    pub(crate) fn run(&self, point: &[f64], registers: &mut [f64], put: impl FnMut(usize, usize, &[f64])) {
        self.each(0, Some(point), registers, &mut Put(put));
    }

    /// Runs the kernel, or its first stage, for all elements at a point, adds its results to sums and subtracts the first of them elsewhere.
    pub(crate) fn run_and_add(&self, point: &[f64], registers: &mut [f64], targets: &[Vec<Places>; 2], sums: &mut [f64]) {
        let targets = targets.each_ref().map(Vec::as_slice);
        self.each(0, Some(point), registers, &mut Add { targets, sums });
    }

    /// Runs a later stage at the point of the last `run`; `write` receives some results twice.
    pub(crate) fn go_on(&self, stage: usize, registers: &mut [f64], write: impl FnMut(usize, usize, &[f64])) {
        self.each(stage, None, registers, &mut Write(write));
    }

    fn each(&self, stage: usize, point: Option<&[f64]>, registers: &mut [f64], sink: &mut impl Sink) {
        for which in 0..self.chunks.len() {
            match self.chunks[which].lanes {
                1 => self.run_chunk::<1>(which, stage, point, registers, sink),
                4 => self.run_chunk::<4>(which, stage, point, registers, sink),
                8 => self.run_chunk::<8>(which, stage, point, registers, sink),
                _ => self.run_chunk::<16>(which, stage, point, registers, sink),
            }
        }
    }

    #[inline]
    fn run_chunk<const L: usize>(
        &self,
        which: usize,
        stage: usize,
        point: Option<&[f64]>,
        registers: &mut [f64],
        sink: &mut impl Sink,
    ) {
        let (program, chunk) = (self.kernel.stage(stage), &self.chunks[which]);
        let registers = self.own(chunk, registers).as_chunks_mut::<L>().0;
        if let Some(point) = point {
            self.sources[which].gather(point, registers);
        }
        program.run(registers);
        sink.take(which, chunk, Results { program, registers });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Function, Graph};

    #[test]
    fn a_stage_goes_on_with_what_the_one_before_computed_and_may_be_run_again() {
        // The function b exp(y sin x) and its derivatives f_x and f_xx.
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

    /// Compares the results of every element with the formulas, at two points.
    fn run_stages(kernel: &Kernel, elements: usize) {
        let number = |k: usize| (0.7 * k as f64).sin();
        let lanes = Lanes::new(Arc::new(kernel.clone()), elements, |element, which| 2 * element + which);
        let mut registers = lanes.registers();
        lanes.fix(|element| vec![1.0 + number(element)], &mut registers);
        for round in 0..2 {
            let point: Vec<f64> = (0..2 * elements).map(|k| number(k + 5 * round)).collect();
            let expected = |e: usize| {
                let (sin, cos) = point[2 * e].sin_cos();
                let (y, f) = (point[2 * e + 1], (1.0 + number(e)) * (point[2 * e + 1] * sin).exp());
                [f, f * y * cos, f * (y * cos * y * cos - y * sin)]
            };
            let mut seen = vec![[false; 3]; elements];
            let mut holds = |first: usize, which: usize, values: &[f64]| {
                for (k, value) in values.iter().enumerate() {
                    let expected = expected(first + k)[which];
                    assert!((value - expected).abs() < 1e-14, "{value} {expected}");
                    seen[first + k][which] = true;
                }
                values.len()
            };
            let mut count = 0;
            lanes.run(&point, &mut registers, |first, _, values| count += holds(first, 0, values));
            assert_eq!(count, elements);
            lanes.go_on(1, &mut registers, |first, k, values| _ = holds(first, 1 + k, values));
            lanes.go_on(1, &mut registers, |first, k, values| _ = holds(first, 1 + k, values));
            assert!(seen.as_flattened().iter().all(|&seen| seen));
        }
    }
}
