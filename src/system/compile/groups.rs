//! Groups of unknowns that are eliminated together, and the order that these groups must respect.
//!
//! A body is grouped with the multipliers of the joints that carry it: the block [M Φ_qᵀ; Φ_q 0] of a body and the constraints it
//! *owns* is regular if their rows of Φ_q, restricted to the body's coordinates, have full rank. Bodies are numbered from
//! the ground outwards, which makes them a tree, and a body may own only constraints that join it to its parent (the ground, for a root). Then the
//! owned rows of any set of bodies are block triangular with full-rank blocks on the diagonal, and every order of elimination is possible. A
//! constraint that no body can own closes a loop. It waits until all bodies of its loop, up to the body at which the two branches
//! of the tree meet, have been eliminated; it also waits for that body if the constraint touches it, because its rows may be singular otherwise.
//!
//! If a body has as many rows as coordinates and their determinant varies, they lose rank at some point of a motion (x = l sin φ at φ = π/2, for
//! a body that has φ alone); such rows are not owned.
//!
//! An internal constraint, such as the length of a rod given by its two ends, counts as a joint to the ground. Then every body is a root that owns
//! its internal constraints, and every joint waits for its two bodies only: the multipliers of a chain's joints form a chain of small nodes,
//! which requires a third of the work of nodes that contain a body and its joint (40 rods: 17,426 multiplications against 53,851).

use nalgebra::DMatrix;
use std::collections::{BTreeSet, VecDeque};
use std::ops::Range;

use crate::linear::{Branch, Group, equilibrate};
use crate::system::formula::{Block, Element, ElementKind, Entry, RelativeEntry};

/// A constraint: its equations and the blocks of coordinates that it touches.
struct Joint {
    equations: Vec<usize>,
    blocks: Vec<usize>,
}

/// Bodies numbered from the ground outwards.
struct Tree {
    rank: Vec<usize>,
    parent: Vec<Option<usize>>,
    /// The number of bodies from this one to the root, both included.
    depth: Vec<usize>,
    /// A distant ancestor. Any ancestor is reached in a number of leaps that grows like the logarithm of the depth.
    leap: Vec<Option<usize>>,
}

/// The groups of unknowns, and the equations that close loops.
pub(in crate::system) struct Groups {
    pub(in crate::system) groups: Vec<Group>,
    pub(in crate::system) loop_equations: Vec<usize>,
}

pub(in crate::system) fn groups(
    elements: &[Element],
    (blocks, inertia, may_open): (&[Range<usize>], &[f64], &[usize]),
    (n, phi_q): (usize, &[Vec<Vec<Entry>>; 2]),
) -> Groups {
    let block_of: Vec<usize> = blocks.iter().enumerate().flat_map(|(b, range)| range.clone().map(move |_| b)).collect();
    let (may_open, joints): (Vec<Joint>, Vec<Joint>) =
        joints(elements, &block_of).into_iter().partition(|joint| joint.equations.iter().any(|j| may_open.contains(j)));
    let tree = Tree::new(blocks.len(), &joints);
    let body =
        |(range, &parent): (&Range<usize>, _)| Group { unknowns: range.clone().collect(), parent, ..Group::default() };
    let mut groups: Vec<Group> = blocks.iter().zip(&tree.parent).map(body).collect();
    // A body without inertia of its own is assigned that of the bodies it carries.
    for (child, parent) in tree.parent.iter().enumerate() {
        let parent = parent.filter(|&parent| inertia[blocks[parent].clone()].contains(&0.0));
        parent.into_iter().for_each(|parent| groups[parent].after.push(Branch { from: child, length: 1 }));
    }
    let mut owned: Vec<Vec<usize>> = vec![Vec::new(); blocks.len()];
    // A body that a constraint carries only for a time does not own it.
    let mut loop_equations = may_open;
    for joint in joints {
        let regular = |&b: &usize| can_own(&owned[b], &joint.equations, (&blocks[b], inertia), phi_q);
        match tree.carried_by(&joint.blocks).filter(regular) {
            Some(b) => {
                owned[b].extend(&joint.equations);
                groups[b].unknowns.extend(joint.equations.iter().map(|j| n + j));
            }
            None => loop_equations.push(joint),
        }
    }
    for joint in &loop_equations {
        let after = tree.loop_of(&joint.blocks);
        groups.push(Group { unknowns: joint.equations.iter().map(|j| n + j).collect(), after, ..Group::default() });
    }
    Groups { groups, loop_equations: loop_equations.into_iter().flat_map(|joint| joint.equations).collect() }
}

fn joints(elements: &[Element], block_of: &[usize]) -> Vec<Joint> {
    let constraints = elements.iter().filter(|element| element.kind() == ElementKind::Holonomic);
    let mut joints: Vec<Joint> = constraints
        .map(|constraint| {
            // Coordinates on which Φ does not depend are not touched by the constraint.
            let varying = constraint.formula.varying.iter().flat_map(RelativeEntry::parts);
            let slopes = constraint.formula.fixed.iter().copied().chain(varying);
            let touched = slopes.filter(|entry| entry.block == Block::PhiQ).map(|entry| constraint.to.q[entry.col]);
            let blocks: BTreeSet<usize> = touched.map(|i| block_of[i]).collect();
            Joint { equations: constraint.to.sigma.clone(), blocks: blocks.into_iter().collect() }
        })
        .collect();
    joints.sort_by_key(|joint| joint.equations.first().copied());
    joints
}

impl Tree {
    /// Breadth-first search from all bodies that are joined to the ground; a free component starts at its first body.
    fn new(count: usize, joints: &[Joint]) -> Self {
        let mut neighbours = vec![Vec::new(); count];
        for joint in joints {
            for (&a, &b) in joint.blocks.iter().flat_map(|a| joint.blocks.iter().map(move |b| (a, b))) {
                neighbours[a].push(b);
            }
        }
        let grounded = joints.iter().filter(|joint| joint.blocks.len() == 1).map(|joint| (joint.blocks[0], None));
        let mut tree = Tree {
            rank: vec![usize::MAX; count],
            parent: vec![None; count],
            depth: vec![1; count],
            leap: vec![None; count],
        };
        let mut next = 0;
        for start in std::iter::once(grounded.collect()).chain((0..count).map(|body| vec![(body, None)])) {
            let mut queue = VecDeque::from(start);
            while let Some((body, parent)) = queue.pop_front() {
                if tree.rank[body] != usize::MAX {
                    continue;
                }
                tree.rank[body] = next;
                tree.hang(body, parent);
                next += 1;
                queue.extend(neighbours[body].iter().map(|&outer| (outer, Some(body))));
            }
        }
        tree
    }

    fn hang(&mut self, body: usize, parent: Option<usize>) {
        let Some(parent) = parent else { return };
        self.parent[body] = Some(parent);
        self.depth[body] = self.depth[parent] + 1;
        // Two leaps of equal length are combined into one.
        let depth = |body: Option<usize>| body.map_or(0, |body| self.depth[body]);
        let first = self.leap[parent];
        let second = first.and_then(|body| self.leap[body]);
        let alike = self.depth[parent] - depth(first) == depth(first) - depth(second);
        self.leap[body] = if alike { second } else { Some(parent) };
    }

    /// The body that a constraint on these blocks joins to its parent, if it does so.
    fn carried_by(&self, blocks: &[usize]) -> Option<usize> {
        let body = blocks.iter().copied().max_by_key(|&b| self.rank[b])?;
        let others = blocks.iter().copied().filter(|&b| b != body);
        others.eq(self.parent[body]).then_some(body)
    }

    /// The bodies between those that a constraint touches and the meeting point of their branches, which is included only if touched.
    fn loop_of(&self, blocks: &[usize]) -> Vec<Branch> {
        let meeting = match blocks {
            [first, others @ ..] if !others.is_empty() => {
                others.iter().try_fold(*first, |meeting, &body| self.meeting(meeting, body))
            }
            _ => None,
        };
        let end = meeting.map_or(0, |body| self.depth[body] - usize::from(blocks.contains(&body)));
        let branches = blocks.iter().map(|&from| Branch { from, length: self.depth[from] - end });
        branches.filter(|branch| branch.length > 0).collect()
    }

    /// The body at which the branches of two bodies meet, if they meet before the ground.
    fn meeting(&self, a: usize, b: usize) -> Option<usize> {
        let (mut a, mut b) = if self.depth[a] < self.depth[b] { (b, a) } else { (a, b) };
        while self.depth[a] > self.depth[b] {
            let far = self.leap[a].filter(|&far| self.depth[far] >= self.depth[b]);
            a = far.or(self.parent[a])?;
        }
        // At equal depths, leaps have equal length.
        while a != b {
            let up = if self.leap[a] == self.leap[b] { &self.parent } else { &self.leap };
            (a, b) = (up[a]?, up[b]?);
        }
        Some(a)
    }
}

/// A row of Φ_q whose part of a block is below this share of it is zero there: a plane does not move with a body that moves in it.
const ROUNDING: f64 = 1e-12;

/// A body does not own rows that differ by less than this in units in which its inertia is 1: the square of the difference would be their pivot, which
/// buries the inertia of the other bodies that they touch. An axis that is tilted by 1e-7 makes such rows.
const DIFFERENT: f64 = 1e-2;

/// Whether a body's block stays regular when these equations are added to those it owns, for Φ_q at two positions.
fn can_own(
    owned: &[usize],
    more: &[usize],
    (block, inertia): (&Range<usize>, &[f64]),
    phi_q: &[Vec<Vec<Entry>>; 2],
) -> bool {
    let rows: Vec<usize> = owned.iter().chain(more).copied().collect();
    if rows.len() > block.len() {
        return false;
    }
    let [mut matrix, elsewhere] = phi_q.each_ref().map(|phi_q| restricted(phi_q, &rows, block));
    let whole = |row: usize| phi_q[0][row].iter().fold(0.0f64, |sum, entry| sum.hypot(entry.value));
    // False for NaN.
    let has_part = |(row, part): (&usize, f64)| part > ROUNDING * whole(*row);
    if !rows.iter().zip(matrix.row_iter().map(|row| row.norm())).all(has_part) {
        return false;
    }
    if rows.len() == block.len() {
        let [here, there] = [&matrix, &elsewhere].map(|matrix| matrix.determinant());
        // False for NaN.
        let is_constant = (here - there).abs() <= 1e-6 * here.abs();
        if !is_constant {
            return false;
        }
    }
    let own = &inertia[block.clone()];
    if own.iter().all(|inertia| *inertia > 0.0) {
        let scaled = DMatrix::from_fn(rows.len(), block.len(), |r, i| matrix[(r, i)] / own[i].sqrt());
        let lengths: Vec<f64> = scaled.row_iter().map(|row| row.norm()).collect();
        if !has_rank(DMatrix::from_fn(rows.len(), block.len(), |r, i| scaled[(r, i)] / lengths[r]), DIFFERENT) {
            return false;
        }
    }
    equilibrate(&mut matrix);
    has_rank(matrix, 1e-6)
}

/// True if all pivots of a matrix that has at least as many columns as rows exceed `least`. Singular values are not used because their iteration may not terminate.
fn has_rank(matrix: DMatrix<f64>, least: f64) -> bool {
    let rows = matrix.nrows();
    let pivots = matrix.full_piv_lu().u();
    (0..rows).all(|r| pivots[(r, r)].abs() > least)
}

/// Rows of Φ_q restricted to the coordinates of a block.
fn restricted(phi_q: &[Vec<Entry>], rows: &[usize], block: &Range<usize>) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(rows.len(), block.len());
    for (r, &row) in rows.iter().enumerate() {
        for e in phi_q[row].iter().filter(|e| block.contains(&e.col)) {
            matrix[(r, e.col - block.start)] = e.value;
        }
    }
    matrix
}
