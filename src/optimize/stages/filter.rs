//! [`Filter`]: acceptance of steps by a filter of pairs of violation θ and value φ (Wächter and Biegler 2006).

/// Fractions by which θ or φ must improve on a pair of the filter.
const BETTER: f64 = 1e-5;
/// Exponents and the factor of the switching condition.
const OF_SLOPE: f64 = 2.3;
const OF_VIOLATION: f64 = 1.1;
/// Fraction of the predicted decrease of φ that is required.
const ARMIJO: f64 = 1e-8;
/// Violations above and below these multiples of the first one are rejected, or small. Far from a minimum, from much larger ones no step leads back.
const MOST: f64 = 10.0;
const MOST_NEAR: f64 = 1e4;
const SMALL: f64 = 1e-4;
/// Changes of φ below this fraction of it are rounding errors.
const ROUNDING: f64 = 1e-14;

/// A violation θ and a value φ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub violation: f64,
    pub value: f64,
}

/// Kind of an accepted step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Accepted {
    /// φ decreases as predicted.
    Decrease,
    /// θ or φ decreases; the point before the step becomes a pair of the filter.
    Filtered,
}

/// Pairs that no later point may be worse than in both numbers.
pub(super) struct Filter {
    pairs: Vec<Pair>,
    most: f64,
    small: f64,
}

impl Filter {
    /// The filter for a start near a minimum, or far from any.
    pub(super) fn new(first: Pair, is_near: bool) -> Self {
        let (size, most) = (first.violation.max(1.0), if is_near { MOST_NEAR } else { MOST });
        Filter { pairs: Vec::new(), most: most * size, small: SMALL * size }
    }

    /// Removes all pairs, for another φ.
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
    }

    /// Adds the point before a filtered step.
    pub(super) fn add(&mut self, of: Pair) {
        self.pairs.push(Pair { violation: (1.0 - BETTER) * of.violation, value: of.value - BETTER * of.violation });
    }

    /// Decides about a step of length α from `before` to `after`; `slope` is dφ/dα.
    pub(super) fn accepts(&self, before: Pair, after: Pair, alpha: f64, slope: f64) -> Option<Accepted> {
        let Pair { violation, value } = after;
        let is_worse = |pair: &Pair| violation >= pair.violation && value >= pair.value;
        if !(violation + value).is_finite() || violation > self.most || self.pairs.iter().any(is_worse) {
            return None;
        }
        let switches = slope < 0.0 && alpha * (-slope).powf(OF_SLOPE) > before.violation.powf(OF_VIOLATION);
        if before.violation <= self.small && switches {
            let allowed = before.value + ARMIJO * alpha * slope + ROUNDING * before.value.abs().max(1.0);
            return (value <= allowed).then_some(Accepted::Decrease);
        }
        let is_better = violation <= (1.0 - BETTER) * before.violation || value <= before.value - BETTER * before.violation;
        is_better.then_some(Accepted::Filtered)
    }
}
