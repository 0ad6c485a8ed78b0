//! [`Clock`]: times correct to rounding for any number of steps.

use crate::number::Real;

/// The time at a node, and the rounding error of the additions up to it (Dekker 1971). All parts of a dual or complex number are summed in this way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock<R = f64> {
    time: R,
    lost: R,
}

impl<R: Real> Clock<R> {
    /// A clock that starts at this time.
    pub(crate) fn new(time: R) -> Self {
        Clock { time, lost: R::zero() }
    }

    /// The clock after a step of length `dt`.
    pub(crate) fn after(self, dt: R) -> Self {
        let (sum, lost) = exact_sum(self.time, dt);
        let (time, lost) = exact_sum(sum, lost + self.lost);
        Clock { time, lost }
    }

    /// t in s.
    pub(crate) fn time(self) -> R {
        self.time
    }
}

/// a + b, and its rounding error (Knuth 1969).
fn exact_sum<R: Real>(a: R, b: R) -> (R, R) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

#[cfg(test)]
mod tests {
    use crate::{Grid, Inputs, LongSolver, Settings, Solver, scenes::CartPendulum};

    /// Exact times by integer arithmetic: each step is a multiple of 2⁻⁶⁰ s.
    fn exact(steps: &[f64]) -> Vec<f64> {
        let unit = 2f64.powi(60);
        let sums = steps.iter().scan(0i128, |sum, dt| {
            *sum += (dt * unit) as i128;
            Some(*sum as f64 / unit)
        });
        std::iter::once(0.0).chain(sums).collect()
    }

    #[test]
    fn times_are_right_to_rounding_after_a_million_steps() {
        let grid = Grid::uniform(1_000_000, 2f64.powi(-60) * (1e-3 * 2f64.powi(60)).round());
        assert_eq!(grid.times(), exact(&grid.steps));
        assert_eq!(grid.times(), grid.passed());
        assert_eq!(grid.time(777_777), grid.times()[777_777]);
        // The steps cancel, so the last time is exact.
        let grid = Grid::new(1e6, [0.1, 0.7, -0.1, -0.7].repeat(1000));
        assert_eq!(grid.times()[4000], 1e6);
    }

    #[test]
    fn a_motion_a_window_over_it_and_its_grid_have_the_same_times() -> Result<(), crate::Error> {
        let system = CartPendulum::default().scene().compile()?;
        let inputs = Inputs::at_rest(&system, Grid::uniform(3000, 1e-3));
        let mut solver = Solver::new(&system, Settings::default());
        let times = solver.simulate(&inputs)?.times.clone();
        assert_eq!(times, inputs.grid.times());
        let (mut long, mut seen) = (LongSolver::new(&system, Settings::default(), 300_000), Vec::new());
        long.simulate(&inputs, |state| seen.push(state.time))?;
        assert_eq!(seen, times);
        Ok(())
    }
}
