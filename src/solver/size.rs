//! Memory of a motion per node.

use crate::{Settings, System, Trajectory};

impl System {
    /// The memory in bytes that a [`Solver`](crate::Solver) needs for each node of a motion:
    ///
    /// ```text
    ///   8 (4 n + m + 1 + B),    B second derivatives that vary along the motion,
    /// ```
    ///
    /// which is
    ///
    /// | mechanism | bytes per node |
    /// |---|---|
    /// | cart with k links | 152 k + 120 |
    /// | ladder of l closed loops, each of three bars | 472 l + 8 |
    ///
    /// The memory per node grows with the number of bodies. Restarts, including those that change which redundant constraints are left out,
    /// need up to 16 (3 n + 3 m + 3 B + 6) bytes more, and stored adjoint variables need 8 (10 n + 3 m) bytes more. Inputs and gradient are
    /// not included. A scheme of S stages needs S times as much.
    pub fn bytes_per_node(&self, settings: &Settings) -> usize {
        let (n, m, blocks) = (self.n(), self.m(), self.block_len());
        // Lists grow by doubling, so they may occupy twice the memory of their contents.
        let restart = if settings.may_restart() { 2 * (3 * n + 3 * m + 3 * blocks + 6) } else { 0 };
        let adjoint = if settings.keep_adjoint { 10 * n + 3 * m } else { 0 };
        let (stages, inner) = (settings.scheme.stages(), settings.scheme.inner());
        let states = (Trajectory::<f64>::len_of_node(n, m) + blocks) * stages + self.k() * inner;
        (states + restart + adjoint) * size_of::<f64>()
    }
}
