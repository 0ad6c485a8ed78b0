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

/// Memory for the registers of any kernel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Registers(Vec<f64>);

impl Registers {
    /// Makes room.
    pub(crate) fn fit(&mut self, lanes: &Lanes) {
        let widest = lanes.chunks.iter().map(|chunk| chunk.lanes).max().unwrap_or(0);
        let len = widest * lanes.kernel.main().registers();
        self.0.resize(self.0.len().max(len), 0.0);
    }
}

/// Groups of eight, of four for what is left, and one by itself.
fn chunks(elements: usize) -> Vec<Chunk> {
    let (mut chunks, mut first, mut offset) = (Vec::new(), 0, 0);
    while first < elements {
        let lanes = match elements - first {
            1 => 1,
            2..=4 => 4,
            _ => 8,
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

    /// The length of what preludes compute.
    pub(crate) fn fixed_len(&self) -> usize {
        self.lanes * self.kernel.fixed()
    }

    /// Runs the prelude of every element.
    pub(crate) fn fix(&self, parameters: impl Fn(usize) -> Vec<f64>, fixed: &mut [f64]) {
        for chunk in &self.chunks {
            let own = &mut fixed[chunk.offset * self.kernel.fixed()..][..chunk.lanes * self.kernel.fixed()];
            for lane in 0..chunk.lanes {
                let parameters = parameters(chunk.first + lane.min(chunk.elements - 1));
                self.kernel.run_prelude(&parameters, |k, value| own[k * chunk.lanes + lane] = value);
            }
        }
    }

    /// Runs the kernel for all elements at a point; `put` gets the first of some elements, the number of the result and their values.
    pub(crate) fn run(
        &self,
        point: &[f64],
        fixed: &[f64],
        registers: &mut Registers,
        mut put: impl FnMut(usize, usize, &[f64]),
    ) {
        for chunk in &self.chunks {
            match chunk.lanes {
                1 => self.run_chunk::<1>(chunk, point, fixed, registers, &mut put),
                4 => self.run_chunk::<4>(chunk, point, fixed, registers, &mut put),
                _ => self.run_chunk::<8>(chunk, point, fixed, registers, &mut put),
            }
        }
    }

    #[inline]
    fn run_chunk<const L: usize>(
        &self,
        chunk: &Chunk,
        point: &[f64],
        fixed: &[f64],
        registers: &mut Registers,
        put: &mut impl FnMut(usize, usize, &[f64]),
    ) {
        let (inputs, constants) = (self.kernel.inputs().len(), self.kernel.fixed());
        let registers = registers.0[..L * self.kernel.main().registers()].as_chunks_mut::<L>().0;
        let sources = self.sources[chunk.offset * inputs..][..L * inputs].as_chunks::<L>().0;
        for (register, source) in registers.iter_mut().zip(sources) {
            *register = source.map(|place| point[place as usize]);
        }
        let fixed = fixed[chunk.offset * constants..][..L * constants].as_chunks::<L>().0;
        registers[inputs..][..constants].copy_from_slice(fixed);
        self.kernel.main().run(registers);
        for (k, register) in self.kernel.main().results().enumerate() {
            put(chunk.first, k, &registers[register][..chunk.elements]);
        }
    }
}
