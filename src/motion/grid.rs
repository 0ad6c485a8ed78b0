//! [`Grid`]: the times at which a motion is computed.

use crate::motion::Clock;
use crate::number::Real;
use crate::{Error, memory};

/// The time grid of nodes 0 … N: a start time and N step lengths, which may differ and may be negative.
///
/// In a step of length 0.0, after the first one, controls may jump: q and p\* stay, and the equations are solved again with the controls of the next
/// node. Costs are evaluated at both nodes. On a composed grid it takes the place of a whole macro step.
///
/// ```
/// use hamiltonian_adjoint::Grid;
///
/// let grid = Grid::uniform(10, 0.1).then(&Grid::new(0.0, vec![0.0])).then(&Grid::uniform(10, 0.1));
/// assert_eq!(grid.times()[10], grid.times()[11]); // controls before and after t = 1 s
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<R = f64> {
    /// t₀ in s.
    pub start: R,
    /// Δt_1 … Δt_N in s.
    pub steps: Vec<R>,
    /// Number of consecutive steps that form one macro step ([`Grid::composed`]); 1 if every step is a macro step. A motion restarts at
    /// ends of macro steps only ([`Settings::drift_bound`](crate::Settings::drift_bound)). An incomplete macro step at the end of the grid
    /// has no restart.
    pub stages: usize,
    /// Numbers of nodes of a longer motion before the first and after the last node of this grid; zero unless the grid is a [`part`](Grid::part) of a
    /// longer one. Macro steps are counted from the start of the longer motion.
    pub around: [usize; 2],
}

impl Grid {
    /// A grid of N equal steps of `dt`, s, from t = 0.
    ///
    /// # Panics
    /// If the grid does not fit into memory.
    pub fn uniform(steps: usize, dt: f64) -> Self {
        memory::require("the steps of a grid", steps, size_of::<f64>());
        Grid::new(0.0, vec![dt; steps])
    }

    /// A grid of N steps over a duration, s, from t = 0, that are short at both ends: t_i = T x³ (10 − 15 x + 6 x²) with x = i/N. Use it for the
    /// steps within a contact whose force is not smooth where it begins and ends, such as Hertz' law δ^1.5; schemes then keep their order.
    ///
    /// ```
    /// use hamiltonian_adjoint::Grid;
    ///
    /// let grid = Grid::uniform(10, 0.045).then(&Grid::graded(6, 0.02)).then(&Grid::uniform(10, 0.033));
    /// assert_eq!(grid.steps.len(), 26);
    /// assert!((grid.times()[16] - 0.47).abs() < 1e-14);
    /// ```
    ///
    /// # Panics
    /// If the grid does not fit into memory.
    pub fn graded(steps: usize, duration: f64) -> Self {
        memory::require("the steps of a grid", steps, size_of::<f64>());
        let at = |i: usize| {
            let x = i as f64 / steps as f64;
            duration * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
        };
        Grid::new(0.0, (0..steps).map(|i| at(i + 1) - at(i)).collect())
    }

    /// This grid, followed by the steps of another one.
    #[must_use]
    pub fn then(mut self, other: &Grid) -> Self {
        self.steps.extend_from_slice(&other.steps);
        self
    }

    /// A grid with nodes at the given times, s, and equal steps between them, none longer than `longest`, s. Use it if there are
    /// measurements, or kinks of controls, at these times.
    ///
    /// ```
    /// use hamiltonian_adjoint::Grid;
    ///
    /// let grid = Grid::through(&[0.0, 0.137, 0.25], 0.05)?;
    /// assert_eq!(grid.nodes(), 1 + 3 + 3);
    /// assert_eq!(grid.times()[3], 0.137);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// An empty list, a time that is not finite, or a length that is not positive or so short that the steps do not fit into memory.
    pub fn through(times: &[f64], longest: f64) -> Result<Self, Error> {
        if let Some(&value) = times.iter().find(|t| !t.is_finite()) {
            return Err(Error::NotFinite { what: "a time of `Grid::through`".into(), value });
        }
        if longest.is_nan() || longest <= 0.0 {
            let (what, must_be) = ("the longest step of `Grid::through`".into(), "positive");
            return Err(Error::Parameter { what, value: longest, must_be });
        }
        let Some(&start) = times.first() else {
            return Err(Error::Size { what: "the times of `Grid::through`", expected: 1, found: 0 });
        };
        // A length that divides an interval up to rounding divides it; an interval shorter than the length has one step.
        let at_least_one = |steps: f64, pair: &[f64]| steps.max(if pair[0] == pair[1] { 0.0 } else { 1.0 });
        let count = |pair: &[f64]| at_least_one(((pair[1] - pair[0]).abs() / longest * (1.0 - 1e-12)).ceil(), pair) as usize;
        memory::check("the steps of a grid", times.windows(2).map(count).fold(0, usize::saturating_add), size_of::<f64>())?;
        let steps = times.windows(2).flat_map(|pair| vec![(pair[1] - pair[0]) / count(pair) as f64; count(pair)]);
        Ok(Grid::new(start, steps.collect()))
    }
}

impl<R: Real> Grid<R> {
    /// A grid of steps of the given lengths, s; every step is a macro step.
    pub fn new(start: R, steps: Vec<R>) -> Self {
        Grid { start, steps, stages: 1, around: [0, 0] }
    }

    /// The part of the grid between two nodes. Its nodes keep their numbers in costs at single nodes ([`Sum::Node`](crate::Sum::Node)), errors and
    /// warnings. A node shared by two parts belongs to the first of them, unless the second one has no steps. Restarts remain at the nodes of the
    /// whole grid, even if a part begins inside a macro step. A part has the order of the [`Composition`](crate::Composition) if it starts with the
    /// q and p\* of its first node ([`Start::Momentum`](crate::Start::Momentum)).
    ///
    /// # Panics
    /// If the grid does not contain these nodes in this order.
    pub fn part(&self, first: usize, last: usize) -> Self {
        let [before, behind] = self.around;
        // An overflow is reported when the inputs are checked.
        let around = [before.saturating_add(first), behind.saturating_add(self.steps.len() - last)];
        Grid { start: self.time(first), steps: self.steps[first..last].to_vec(), stages: self.stages, around }
    }

    /// The times of the nodes 0 … N, s, each correct to rounding for any number of steps.
    pub fn times(&self) -> Vec<R> {
        clocks(self.start, &self.steps).map(Clock::time).collect()
    }

    /// Time since the start at each node, s, correct to rounding for any start time.
    pub(crate) fn passed(&self) -> Vec<R> {
        passed(&self.steps)
    }

    /// Writes the times of the nodes 0 … N, s.
    pub(crate) fn write_times(&self, times: &mut [R]) {
        times.iter_mut().zip(clocks(self.start, &self.steps)).for_each(|(time, clock)| *time = clock.time());
    }

    /// The time of one node.
    pub(crate) fn time(&self, node: usize) -> R {
        clocks(self.start, &self.steps[..node]).last().map_or(self.start, Clock::time)
    }

    /// Number of macro steps of the whole motion before a node; `None` if the node is inside a macro step.
    pub(crate) fn macro_steps(&self, node: usize) -> Option<usize> {
        let before = self.around[0] + node;
        before.is_multiple_of(self.stages).then(|| before / self.stages)
    }

    /// The nodes after the first at which macro steps end.
    pub(crate) fn macro_ends(&self) -> impl Iterator<Item = usize> {
        (1..self.nodes()).filter(|&node| self.macro_steps(node).is_some())
    }

    /// The number of nodes, N + 1.
    pub fn nodes(&self) -> usize {
        self.steps.len() + 1
    }
}

/// The times of the nodes 0 … N since the start, for steps of these lengths.
pub(crate) fn passed<R: Real>(steps: &[R]) -> Vec<R> {
    clocks(R::zero(), steps).map(Clock::time).collect()
}

/// The clocks at the nodes 0 … N.
fn clocks<R: Real>(start: R, steps: &[R]) -> impl Iterator<Item = Clock<R>> {
    let after = steps.iter().scan(Clock::new(start), |clock, &dt| {
        *clock = clock.after(dt);
        Some(*clock)
    });
    std::iter::once(Clock::new(start)).chain(after)
}
