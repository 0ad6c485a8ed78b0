//! Patterns and values for the tests.

use super::{Group, Pattern};
use nalgebra::DMatrix;

/// Linear congruential generator.
pub(super) struct Random(pub(super) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = (self.0.wrapping_mul(6364136223846793005)).wrapping_add(1442695040888963407);
        self.0 >> 33
    }

    pub(super) fn below(&mut self, bound: usize) -> usize {
        self.next() as usize % bound
    }

    /// Uniform in (−1, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.next() as f64 / (1u64 << 30) as f64 - 1.0
    }
}

/// Groups of the given sizes with full diagonal blocks and full blocks for the edges.
pub(super) fn blocks(sizes: &[usize], edges: &[(usize, usize)]) -> Pattern {
    let mut pattern = Pattern::default();
    for &size in sizes {
        let unknowns = (pattern.size..pattern.size + size).collect();
        pattern.size += size;
        pattern.groups.push(Group { unknowns, ..Group::default() });
    }
    let loops = (0..sizes.len()).map(|g| (g, g));
    for (a, b) in edges.iter().copied().chain(loops) {
        for &i in &pattern.groups[a].unknowns {
            for &j in &pattern.groups[b].unknowns {
                pattern.entries.push((i, j));
            }
        }
    }
    pattern.constant = vec![false; pattern.size];
    pattern
}

/// Random values on the symmetrised pattern; structurally nonzero diagonal entries are near `diagonal`.
pub(super) fn fill(pattern: &Pattern, diagonal: f64, random: &mut Random) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(pattern.size, pattern.size);
    for &(i, j) in &pattern.entries {
        matrix[(i, j)] = random.unit();
        matrix[(j, i)] = random.unit();
    }
    for &(i, j) in pattern.entries.iter().filter(|(i, j)| i == j) {
        matrix[(i, j)] += diagonal;
    }
    matrix
}

/// A random tree; node 0 is its root.
pub(super) fn tree(sizes: &[usize], random: &mut Random) -> Pattern {
    let edges: Vec<_> = (1..sizes.len()).map(|b| (b, random.below(b))).collect();
    blocks(sizes, &edges)
}

pub(super) fn sizes(count: usize, largest: usize, random: &mut Random) -> Vec<usize> {
    (0..count).map(|_| 1 + random.below(largest)).collect()
}

/// Bodies (x, y, φ) with the multipliers (σ0, σ1) of the hinge to their parent; `usize::MAX` is the ground.
pub(super) fn bodies(parents: &[usize]) -> Pattern {
    let mut pattern = Pattern::default();
    for (b, &parent) in parents.iter().enumerate() {
        let own: Vec<usize> = (5 * b..5 * b + 5).collect();
        pattern.entries.extend((0..3).map(|k| (own[k], own[k])));
        for k in 0..2 {
            pattern.entries.extend([(own[3 + k], own[k]), (own[3 + k], own[2])]);
            if parent < b {
                pattern.entries.extend([5 * parent + k, 5 * parent + 2].map(|j| (own[3 + k], j)));
            }
        }
        pattern.constant.extend([true, true, false, false, false]);
        pattern.groups.push(Group { unknowns: own, ..Group::default() });
    }
    pattern.size = 5 * parents.len();
    pattern
}
