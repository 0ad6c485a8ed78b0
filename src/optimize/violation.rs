//! [`Violation`]: a constraint that does not hold.

use std::fmt;

use super::outcome::significant;
use super::problem::{Interval, Problem};

/// A constraint that does not hold at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The name of the constraint ([`Problem::constraint_name`]).
    pub name: String,
    /// The value c.
    pub value: f64,
    /// The interval in which c should be.
    pub interval: Interval,
}

impl Violation {
    /// The constraints of a problem with the values c that are violated by more than an allowed distance, the largest violation first.
    pub fn all(problem: &dyn Problem, c: &[f64], allowed: f64) -> Vec<Self> {
        let pairs = problem.constraints().into_iter().zip(c).enumerate();
        let is_violated = |by: f64| by > allowed && by.is_finite();
        let violated = pairs.filter(|(_, (interval, value))| is_violated(interval.violation(**value)));
        let mut all: Vec<Self> = violated
            .map(|(j, (interval, &value))| Violation { name: problem.constraint_name(j), value, interval })
            .collect();
        all.sort_by(|a, b| b.by().total_cmp(&a.by()));
        all
    }

    /// The distance of c from its interval.
    pub fn by(&self) -> f64 {
        self.interval.violation(self.value)
    }
}

/// For example "output `end` is 1.3 instead of 50, off by 48.7".
impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Interval { least, most } = self.interval;
        let wanted = match () {
            () if self.interval.is_equality() => "instead of",
            () if self.value < least => "instead of at least",
            () => "instead of at most",
        };
        let bound = if self.value < least { least } else { most };
        let [value, by] = [self.value, self.by()].map(|x| significant(x, 3));
        write!(f, "{} is {value} {wanted} {}, off by {by}", self.name, significant(bound, 6))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_that_is_left_is_named() {
        let of = |value, interval| Violation { name: "output `x`".into(), value, interval }.to_string();
        assert_eq!(of(1.25, Interval::equal(50.0)), "output `x` is 1.25 instead of 50, off by 48.8");
        assert_eq!(of(1.25, Interval::at_most(0.5)), "output `x` is 1.25 instead of at most 0.5, off by 0.75");
        assert_eq!(of(-3.0, Interval::new(-1.0, 2.0)), "output `x` is -3 instead of at least -1, off by 2");
    }
}
