//! [`Turns`]: which of the starts of a search begin in segments, and which as one motion.

/// The work of a start in segments relative to that of one as one motion: the median of the searches for the shortest times of the paper's cart.
const WORK: f64 = 4.0;
/// One of so many starts goes the other way, because the minima that it leads to are others.
const OTHER: usize = 4;

/// How often either way led to a minimum.
#[derive(Default)]
pub(super) struct Turns {
    one_motion: Tally,
    segments: Tally,
}

#[derive(Default)]
struct Tally {
    starts: usize,
    minima: usize,
}

impl Turns {
    /// True if start number `which` begins as one motion: most starts go the way that led to more minima for the same work.
    pub(super) fn is_one_motion(&self, which: usize) -> bool {
        let is_better = self.one_motion.share() >= self.segments.share() / WORK;
        // Their places among all starts change, so that they are not always those near the best outcome.
        let is_other = which % OTHER == (which / OTHER) % OTHER;
        is_better != is_other
    }

    pub(super) fn count(&mut self, is_one_motion: bool, is_minimum: bool) {
        let tally = if is_one_motion { &mut self.one_motion } else { &mut self.segments };
        tally.starts += 1;
        tally.minima += usize::from(is_minimum);
    }
}

impl Tally {
    /// The expected share of starts that lead to a minimum, if all shares are equally likely before the first start (Laplace's rule of succession).
    fn share(&self) -> f64 {
        (self.minima + 1) as f64 / (self.starts + 2) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of starts as one motion among many, if each way leads to a minimum in one of so many starts.
    fn starts_as_one_motion(one_motion: usize, segments: usize) -> usize {
        let mut turns = Turns::default();
        (1..=100)
            .filter(|&which| {
                let is_one = turns.is_one_motion(which);
                turns.count(is_one, which.is_multiple_of(if is_one { one_motion } else { segments }));
                is_one
            })
            .count()
    }

    #[test]
    fn most_starts_go_the_way_that_leads_to_minima() {
        assert!(starts_as_one_motion(3, 2) > 65);
        assert!(starts_as_one_motion(1000, 3) < 40);
        assert!(starts_as_one_motion(1000, 1000).abs_diff(50) < 30);
    }
}
