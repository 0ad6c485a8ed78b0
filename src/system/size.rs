//! How large the problem of one step is: the nodes of its elimination.

use super::System;

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
}
