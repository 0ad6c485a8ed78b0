//! [`Registers`]: the assignment of registers to nodes while a program is scheduled.

use super::expression::Node;
use super::program::{Instruction, Operation, Register};

/// Marks a node without a register.
const NONE: u32 = u32::MAX;

/// The assignment of registers to nodes, and the free registers.
pub(super) struct Registers {
    pub(super) of: Vec<u32>,
    /// The number of remaining uses of each node.
    pub(super) uses: Vec<usize>,
    /// Registers that are not reused: the given ones, and those that later stages need.
    is_kept: Vec<bool>,
    pub(super) next: u32,
    free: Vec<u32>,
}

impl Registers {
    /// Assigns the first registers to the given nodes.
    pub(super) fn new(nodes: usize, given: impl Iterator<Item = Node>) -> Self {
        let (mut of, mut next) = (vec![NONE; nodes], 0);
        for node in given {
            of[node.0 as usize] = next;
            next += 1;
        }
        Registers { of, uses: vec![0; nodes], is_kept: vec![true; next as usize], next, free: Vec::new() }
    }

    /// Protects the nodes that are needed later, so that later stages can run repeatedly, and frees all other registers.
    pub(super) fn keep(&mut self) {
        let given = self.is_kept.len();
        self.is_kept.resize(self.next as usize, false);
        let live = self.of.iter().zip(&self.uses).filter(|(register, uses)| **register != NONE && **uses > 0);
        live.for_each(|(register, _)| self.is_kept[*register as usize] = true);
        self.free = (given as u32..self.next).filter(|&register| !self.is_kept[register as usize]).collect();
    }

    /// Assigns the registers of an instruction; arguments that are used for the last time free theirs.
    pub(super) fn take(
        &mut self,
        operation: Operation,
        arguments: &[Option<Node>; 3],
        results: &[Option<Node>; 2],
    ) -> Instruction {
        let of = arguments.map(|node| node.map_or(0, |node| self.of[node.0 as usize]));
        for node in arguments.iter().flatten().map(|node| node.0 as usize) {
            self.uses[node] -= 1;
            let is_kept = self.is_kept.get(self.of[node] as usize).is_some_and(|kept| *kept);
            if self.uses[node] == 0 && !is_kept {
                self.free.push(self.of[node]);
            }
        }
        let into = results.map(|node| node.map_or(0, |node| self.free_one(node)));
        let [into, cosine] = into.map(|register| register as Register);
        let [x, y, z] = of.map(|register| register as Register);
        Instruction { of: if operation == Operation::SinCos { [x, cosine, 0] } else { [x, y, z] }, into }
    }

    fn free_one(&mut self, node: Node) -> u32 {
        let register = self.free.pop().unwrap_or_else(|| {
            self.next += 1;
            self.next - 1
        });
        self.of[node.0 as usize] = register;
        register
    }
}
