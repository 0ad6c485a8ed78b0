//! [`Grid`]: the times at which a motion is computed.

use crate::motion::Clock;
use crate::number::Real;
use crate::{Error, memory};

/// The times of the nodes 0 … N: a start and N step lengths, which may differ and may be negative.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<R = f64> {
    /// t₀ in s.
    pub start: R,
    /// Δt_1 … Δt_N in s.
    pub steps: Vec<R>,
    /// So many consecutive steps are the stages of one macro step ([`Grid::composed`]), at whose end alone a motion may be
    /// restarted ([`Settings::drift_bound`](crate::Settings::drift_bound)); 1 where every step is one by itself. Steps that are left over end no macro step.
    pub stages: usize,
    /// How many nodes of a longer motion come before its first and behind its last: none, unless it is a [`part`](Grid::part) of one. The macro steps are those
    /// of the longer motion.
    pub around: [usize; 2],
}

impl Grid {
    /// N equal steps from t = 0.
    ///
    /// # Panics
    /// If they cannot be held in memory.
    pub fn uniform(steps: usize, dt: f64) -> Self {
        memory::require("the steps of a grid", steps, size_of::<f64>());
        Grid::new(0.0, vec![dt; steps])
    }

    /// Nodes at all of these times, in their order, and between them as many equal steps as none is longer than `longest`, s: for readings between steps, and
    /// for controls that bend.
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
    /// No time at all, or one that is not finite; a length that is not positive, or so short that the steps cannot be held in memory.
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
        // A length that divides an interval but for rounding does; one beyond all intervals is no reason to leave them out.
        let at_least_one = |steps: f64, pair: &[f64]| steps.max(if pair[0] == pair[1] { 0.0 } else { 1.0 });
        let count = |pair: &[f64]| at_least_one(((pair[1] - pair[0]).abs() / longest * (1.0 - 1e-12)).ceil(), pair) as usize;
        memory::check("the steps of a grid", times.windows(2).map(count).fold(0, usize::saturating_add), size_of::<f64>())?;
        let steps = times.windows(2).flat_map(|pair| vec![(pair[1] - pair[0]) / count(pair) as f64; count(pair)]);
        Ok(Grid::new(start, steps.collect()))
    }

    /// The time since the start at each node, to rounding, whenever the start.
    pub(crate) fn passed(&self) -> Vec<f64> {
        clocks(0.0, &self.steps).map(Clock::time).collect()
    }
}

impl<R: Real> Grid<R> {
    /// Steps of any lengths, each by itself.
    pub fn new(start: R, steps: Vec<R>) -> Self {
        Grid { start, steps, stages: 1, around: [0, 0] }
    }

    /// The part between two nodes, in which nodes keep their numbers: what counts at one of them ([`Sum::Node`](crate::Sum::Node)) counts in the part that has
    /// it, and where one part ends and the next begins in the first of the two; errors and warnings name them so. Restarts that are counted stand at the nodes at which they stood, also where
    /// a part begins inside of a macro step. Such a part has the order of the [`Composition`](crate::Composition) if it begins with the q and p\* of its first node
    /// ([`Start::Momentum`](crate::Start::Momentum)).
    ///
    /// # Panics
    /// If there are no such nodes.
    pub fn part(&self, first: usize, last: usize) -> Self {
        let [before, behind] = self.around;
        // Numbers beyond their range are refused with the inputs.
        let around = [before.saturating_add(first), behind.saturating_add(self.steps.len() - last)];
        Grid { start: self.time(first), steps: self.steps[first..last].to_vec(), stages: self.stages, around }
    }

    /// The times of the nodes 0 … N, each right to rounding however many steps are before it.
    pub fn times(&self) -> Vec<R> {
        clocks(self.start, &self.steps).map(Clock::time).collect()
    }

    /// The same into a list.
    pub(crate) fn write_times(&self, times: &mut [R]) {
        times.iter_mut().zip(clocks(self.start, &self.steps)).for_each(|(time, clock)| *time = clock.time());
    }

    /// The time of one node.
    pub(crate) fn time(&self, node: usize) -> R {
        clocks(self.start, &self.steps[..node]).last().map_or(self.start, Clock::time)
    }

    /// How many macro steps of the whole motion end up to a node, if one ends there.
    pub(crate) fn macro_steps(&self, node: usize) -> Option<usize> {
        let before = self.around[0] + node;
        before.is_multiple_of(self.stages).then(|| before / self.stages)
    }

    /// The nodes behind the first at which macro steps end.
    pub(crate) fn macro_ends(&self) -> impl Iterator<Item = usize> {
        (1..self.nodes()).filter(|&node| self.macro_steps(node).is_some())
    }

    /// The number of nodes, N + 1.
    pub fn nodes(&self) -> usize {
        self.steps.len() + 1
    }
}

/// The clocks at the nodes.
fn clocks<R: Real>(start: R, steps: &[R]) -> impl Iterator<Item = Clock<R>> {
    let after = steps.iter().scan(Clock::new(start), |clock, &dt| {
        *clock = clock.after(dt);
        Some(*clock)
    });
    std::iter::once(Clock::new(start)).chain(after)
}
