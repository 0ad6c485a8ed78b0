//! [`Registers`]: which registers of a program hold which nodes while it is planned.

use super::expression::Node;
use super::program::{Instruction, Operation, Register};

/// Not a register.
const NONE: u32 = u32::MAX;

/// See the module.
pub(super) struct Registers {
    pub(super) of: Vec<u32>,
    /// How often a node is needed yet.
    pub(super) uses: Vec<usize>,
    /// The given ones, and those that hold what later stages need.
    is_kept: Vec<bool>,
    pub(super) next: u32,
    free: Vec<u32>,
}

impl Registers {
    /// With the first ones given.
    pub(super) fn new(nodes: usize, given: impl Iterator<Item = Node>) -> Self {
        let (mut of, mut next) = (vec![NONE; nodes], 0);
        for node in given {
            of[node.0 as usize] = next;
            next += 1;
        }
        Registers { of, uses: vec![0; nodes], is_kept: vec![true; next as usize], next, free: Vec::new() }
    }

    /// Keeps what is needed yet, however often what comes is run, and nothing else.
    pub(super) fn keep(&mut self) {
        let given = self.is_kept.len();
        self.is_kept.resize(self.next as usize, false);
        let live = self.of.iter().zip(&self.uses).filter(|(register, uses)| **register != NONE && **uses > 0);
        live.for_each(|(register, _)| self.is_kept[*register as usize] = true);
        self.free = (given as u32..self.next).filter(|&register| !self.is_kept[register as usize]).collect();
    }

    /// The registers of an instruction, whose arguments may have been needed for the last time.
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
