//! [`Samples`]: the function of an event along a phase, and polynomials through its values at nodes.

/// Values below this fraction of the largest one are on no side of zero.
const ROUNDING: f64 = 1e-12;

/// The function of an event at the nodes of a phase, by the time since its beginning.
#[derive(Default)]
pub(super) struct Samples(pub(super) Vec<(f64, f64)>);

impl Samples {
    /// The last time, and the function there.
    pub(super) fn end(&self) -> (f64, f64) {
        self.0[self.0.len() - 1]
    }

    /// True if the function has been on a side of zero, or if the side is 0, for any.
    pub(super) fn has_been_on(&self, side: f64) -> bool {
        self.begin(side).is_some()
    }

    /// The first node with the function on this side.
    fn begin(&self, side: f64) -> Option<usize> {
        let least = ROUNDING * self.largest();
        if side == 0.0 { Some(0) } else { self.0.iter().position(|(_, g)| side * g > least) }
    }

    /// The first zero after the beginning to which the function comes from a side, by a cubic polynomial, and whether it is in the last step; `None` if the
    /// sign does not change.
    pub(super) fn first_zero(&self, begins_with_zero: bool, side: f64) -> Option<(f64, bool)> {
        let samples = &self.0;
        let first = usize::from(begins_with_zero).max(self.begin(side)?);
        let changes = |a: f64, b: f64| a == 0.0 || b == 0.0 || (a < 0.0) != (b < 0.0);
        let at = (first + 1..samples.len()).find(|&i| changes(samples[i - 1].1, samples[i].1))?;
        let from = at.saturating_sub(2).min(samples.len().saturating_sub(4));
        let root = zero_between(&samples[from..samples.len().min(from + 4)], samples[at - 1], samples[at]);
        Some((root, at + 1 == samples.len()))
    }

    /// The largest |g|.
    pub(super) fn largest(&self) -> f64 {
        self.0.iter().fold(0.0f64, |largest, (_, g)| largest.max(g.abs()))
    }

    /// The time of a minimum of |g| between nodes at which the parabola through three of them has the other sign.
    pub(super) fn missed(&self) -> Option<f64> {
        let vertex = |three: &[(f64, f64)]| {
            let [(a, f), (b, g), (c, h)] = [three[0], three[1], three[2]];
            let (left, right) = ((g - f) / (b - a), (h - g) / (c - b));
            let bend = (right - left) / (c - a);
            let at = 0.5 * (a + b) - 0.5 * left / bend;
            let value = f + (at - a) * (left + bend * (at - b));
            (g.abs() <= f.abs() && g.abs() <= h.abs() && f * g > 0.0 && g * h > 0.0 && value * g < 0.0).then_some(at)
        };
        let inner = &self.0[1.min(self.0.len())..];
        inner.windows(3).find_map(vertex)
    }

    /// dg/dt at the last node, by a cubic polynomial.
    pub(super) fn slope_at_end(&self) -> f64 {
        let last = &self.0[self.0.len().saturating_sub(4)..];
        let (end, _) = self.end();
        (0..last.len()).map(|i| last[i].1 * slope_of_basis(last, i, end)).sum()
    }

    /// The smallest |g| after the first node, and its time.
    pub(super) fn closest(&self) -> (f64, f64) {
        let later = self.0.iter().skip(1);
        later.fold((0.0, f64::INFINITY), |least, &(t, g)| if g.abs() < least.1.abs() { (t, g) } else { least })
    }
}

/// The zero of the polynomial through some samples between two of them, by bisection.
fn zero_between(samples: &[(f64, f64)], (mut low, before): (f64, f64), (mut high, _): (f64, f64)) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let value: f64 = (0..samples.len()).map(|i| samples[i].1 * basis(samples, i, middle)).sum();
        *(if value != 0.0 && (value < 0.0) == (before < 0.0) { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// The Lagrange polynomial of sample i.
fn basis(samples: &[(f64, f64)], i: usize, t: f64) -> f64 {
    let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
    others.map(|(_, other)| (t - other.0) / (samples[i].0 - other.0)).product()
}

/// The derivative of the Lagrange polynomial of sample i at a sample.
fn slope_of_basis(samples: &[(f64, f64)], i: usize, t: f64) -> f64 {
    let others = |without: usize| samples.iter().enumerate().filter(move |(j, _)| *j != i && *j != without);
    let terms = others(i).map(|(j, other)| {
        let rest: f64 = others(j).map(|(_, other)| (t - other.0) / (samples[i].0 - other.0)).product();
        rest / (samples[i].0 - other.0)
    });
    terms.sum()
}
