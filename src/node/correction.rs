//! Sizes of corrections in numbers of other types, a test whether they have become rounding error, and their failures.

use super::convergence::NOISE;
use crate::Error;
use crate::motion::Motion;
use crate::number::Real;

/// Corrections below the first number that the second number of further ones has not halved are also rounding error (nearly singular matrix).
///
/// With a wrong matrix, or in a slow projection, every correction shrinks, even if slowly, or corrections grow from the first one on.
const LOST: (f64, usize) = (1e-5, 4);
/// The same holds if `of_all` is below this: the part may be a remainder of terms that cancel, such as the force on a creeping body.
const LOST_OF_ALL: f64 = 1e-12;

/// Size of a correction, relative to the parts of the unknowns, below which the iteration stops, after two corrections at least.
pub(crate) const SETTLED: f64 = 1e-14;

/// Sizes of successive corrections.
#[derive(Clone, Copy)]
pub(crate) struct Shrinking {
    pub(crate) last: f64,
    /// The last size that was at most half of the previous such size: slow corrections need several to halve.
    halved: f64,
    /// Number of corrections since then.
    idle: usize,
}

impl Shrinking {
    pub(crate) fn new() -> Self {
        Shrinking { last: f64::INFINITY, halved: f64::INFINITY, idle: 0 }
    }

    /// True if corrections have become rounding error. With wrong blocks they shrink slowly, but they do shrink.
    pub(crate) fn is_stalled(&mut self, Size { of_part: size, of_all }: Size) -> bool {
        let is_noise = size <= NOISE && size >= self.last;
        (self.halved, self.idle) = if size <= 0.5 * self.halved { (size, 0) } else { (self.halved, self.idle + 1) };
        self.last = size;
        is_noise || (size <= LOST.0 || of_all <= LOST_OF_ALL) && self.idle >= LOST.1
    }
}

/// The size of a correction.
#[derive(Clone, Copy, Default)]
pub(crate) struct Size {
    /// Relative to the part that it corrects.
    pub(crate) of_part: f64,
    /// Relative to the larger of the part and of the real part times the perturbation of the inputs: a quantity that hardly depends on the inputs
    /// has a small part with few correct digits.
    pub(crate) of_all: f64,
}

impl Size {
    pub(crate) fn max(self, other: Size) -> Size {
        Size { of_part: self.of_part.max(other.of_part), of_all: self.of_all.max(other.of_all) }
    }
}

/// Adds a correction to one part and returns its size in the maximum norm, relative to the larger of the part and `floor`; `None` if the part
/// is not finite afterwards.
pub(crate) fn add_correction<R: Real>(x: &mut [R], part: usize, delta: &[f64], (floor, unit): (f64, f64)) -> Option<Size> {
    let (mut change, mut size, mut real) = (0.0f64, floor, 0.0f64);
    for (x, &delta) in x.iter_mut().zip(delta) {
        x.add_to_part(part, delta);
        if !x.part(part).is_finite() {
            return None;
        }
        change = change.max(delta.abs());
        size = size.max(x.part(part).abs());
        real = real.max(x.part(0).abs());
    }
    let relative_to = |size: f64| if change == 0.0 { 0.0 } else { change / size };
    Some(Size { of_part: relative_to(size), of_all: relative_to(size.max(unit * real)) })
}

/// Error for a quantity that overflows at a node.
pub(crate) fn overflow(motion: &Motion, node: usize, what: &str) -> Error {
    Error::Overflow { what: format!("{what} at node {}", motion.node_of_whole(node)), value: f64::INFINITY }
}

/// Error for corrections at a node that do not converge.
pub(crate) fn diverged(motion: &Motion, node: usize, (iterations, residual): (usize, f64), what: &str) -> Error {
    Error::Newton {
        step: motion.step_of_whole(node),
        time: motion.time(node),
        iterations,
        length: motion.length(node),
        residual,
        equation: what.into(),
        driven: Vec::new(),
        jump: None,
    }
}
