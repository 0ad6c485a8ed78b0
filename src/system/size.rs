//! How large the problem of one step is: the nodes of its elimination, and the memory of a node in time.

use super::System;
use crate::{Settings, Trajectory};

/// How the tangent matrix of a step is solved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Elimination {
    /// The number of unknowns that are condensed once per step length.
    pub condensed: usize,
    /// What is left, in the order in which it is eliminated at every iteration.
    pub nodes: Vec<EliminationNode>,
}

/// Unknowns that are eliminated together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EliminationNode {
    /// The number s of its unknowns.
    pub size: usize,
    /// The number r of later unknowns that it is coupled with.
    pub width: usize,
}

impl EliminationNode {
    /// The multiplications of its elimination but for a constant factor: s³ + 2 s² r + s r².
    pub fn work(&self) -> usize {
        self.size.saturating_add(self.width).saturating_pow(2).saturating_mul(self.size)
    }
}

impl System {
    /// How the tangent matrix of a step is solved: the widths of its nodes say whether that takes linear time.
    pub fn elimination(&self) -> Elimination {
        Elimination {
            condensed: self.symbolic.condensed(),
            nodes: self.symbolic.nodes().map(|(size, width)| EliminationNode { size, width }).collect(),
        }
    }

    /// The memory in bytes that a [`Solver`](crate::Solver) needs for each node of a motion:
    ///
    /// ```text
    ///   8 (4 n + m + 1 + B),    B second derivatives that vary along the motion,
    /// ```
    ///
    /// which is
    ///
    /// | mechanism | bytes a node |
    /// |---|---|
    /// | cart with k links | 152 k + 120 |
    /// | ladder of l closed loops, each of three bars | 472 l + 8 |
    ///
    /// and so grows with the number of bodies. Restarts need up to 16 (3 n + 3 m + 3 B + 5) more, kept adjoint variables
    /// 8 (8 n + 3 m); inputs and gradient are not counted.
    pub fn bytes_per_node(&self, settings: &Settings) -> usize {
        let (n, m, blocks) = (self.n, self.m, self.block_len());
        // Their lists grow as they are filled, to twice what they hold.
        let restart = if settings.may_restart() { 2 * (3 * n + 3 * m + 3 * blocks + 5) } else { 0 };
        let adjoint = if settings.keep_adjoint { 8 * n + 3 * m } else { 0 };
        (Trajectory::<f64>::len_of_node(n, m) + blocks + restart + adjoint) * size_of::<f64>()
    }
}
