//! How large corrections are, and when they have become rounding.

use crate::node::NOISE;
use crate::number::Real;

/// Corrections below this that have not been halved by so many more are rounding as well, of a matrix close to singular.
///
/// Corrections by a wrong matrix, or along a slow projection, shrink at every one, if slowly, or grow from the first.
const LOST: (f64, usize) = (1e-5, 4);
/// So are those below this part of all, where a part is what is left of terms that cancel, such as the force of a body that creeps.
const LOST_OF_ALL: f64 = 1e-12;

/// The sizes of corrections, one after the other.
#[derive(Clone, Copy)]
pub(super) struct Shrinking {
    pub(super) last: f64,
    /// The last that was half of the one that was halved before: slow corrections halve in several.
    halved: f64,
    /// How many corrections have not halved it.
    idle: usize,
}

impl Shrinking {
    pub(super) fn new() -> Self {
        Shrinking { last: f64::INFINITY, halved: f64::INFINITY, idle: 0 }
    }

    /// Whether corrections have become rounding: wrong blocks make them shrink slowly, but shrink.
    pub(super) fn is_stalled(&mut self, Size { of_part: size, of_all }: Size) -> bool {
        let is_noise = size <= NOISE && size >= self.last;
        (self.halved, self.idle) = if size <= 0.5 * self.halved { (size, 0) } else { (self.halved, self.idle + 1) };
        self.last = size;
        is_noise || (size <= LOST.0 || of_all <= LOST_OF_ALL) && self.idle >= LOST.1
    }
}

/// The size of a correction.
#[derive(Clone, Copy, Default)]
pub(super) struct Size {
    /// Relative to the part that it corrects.
    pub(super) of_part: f64,
    /// Relative to that, or to the real part times the perturbation of the inputs if that is larger: what hardly depends on the inputs is
    /// known to few digits of its own, and is small.
    pub(super) of_all: f64,
}

impl Size {
    pub(super) fn max(self, other: Size) -> Size {
        Size { of_part: self.of_part.max(other.of_part), of_all: self.of_all.max(other.of_all) }
    }
}

/// Adds a correction to one part and returns its size in the maximum norm, relative to a floor at least, if the part is finite
/// after it.
pub(super) fn add<R: Real>(x: &mut [R], part: usize, delta: &[f64], (floor, unit): (f64, f64)) -> Option<Size> {
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
