//! The fill that the elimination of each vertex of a graph would cause, updated while vertices are eliminated.
//!
//! Vertices have weights s. With N(w) the neighbours of w and D(w) = Σ s_a over them, the fill Σ s_a s_b over the pairs a, b of N(w) that are not
//! adjacent changes with an edge {a, b} by
//!
//! ```text
//!   fill(w) −= s_a s_b               for all w in N(a) ∩ N(b)
//!   fill(a) += s_b (D(a) − C),       fill(b) += s_a (D(b) − C),       C = Σ s_w over N(a) ∩ N(b)
//! ```
//!
//! so the cost of an edge is proportional to the smaller degree of its two ends.

use super::graph::Graph;

/// A weighted graph under elimination, with the fill and the degree D of every remaining vertex.
pub(super) struct Fill<'a> {
    graph: Graph,
    sizes: &'a [usize],
    fill: Vec<usize>,
    degree: Vec<usize>,
}

impl<'a> Fill<'a> {
    /// Computes the fill of a graph whose vertices have these weights.
    pub(super) fn new(graph: &Graph, sizes: &'a [usize]) -> Self {
        let zeros = || vec![0; sizes.len()];
        let mut fill = Fill { graph: Graph::new(sizes.len()), sizes, fill: zeros(), degree: zeros() };
        for a in 0..graph.size() {
            graph.neighbours(a).take_while(|&b| b < a).for_each(|b| fill.connect((a, b), &mut Vec::new()));
        }
        fill
    }

    /// The fill of a vertex.
    pub(super) fn of(&self, w: usize) -> usize {
        self.fill[w]
    }

    /// Σ s over the neighbours of a vertex.
    pub(super) fn degree(&self, w: usize) -> usize {
        self.degree[w]
    }

    /// Eliminates a vertex; returns its neighbours in ascending order and stores all vertices whose fill or degree changed in `changed`.
    pub(super) fn eliminate(&mut self, v: usize, changed: &mut Vec<usize>) -> Vec<usize> {
        changed.clear();
        let clique: Vec<usize> = self.graph.neighbours(v).collect();
        for &w in &clique {
            let common: usize = self.graph.common(v, w).map(|x| self.sizes[x]).sum();
            self.degree[w] -= self.sizes[v];
            self.fill[w] -= self.sizes[v] * (self.degree[w] - common);
        }
        self.graph.remove(v);
        changed.extend(&clique);
        for (k, &a) in clique.iter().enumerate() {
            clique[..k].iter().for_each(|&b| self.connect((a, b), changed));
        }
        changed.sort_unstable();
        changed.dedup();
        clique
    }

    /// Adds an edge if it does not exist; its ends are not appended to `changed`.
    fn connect(&mut self, (a, b): (usize, usize), changed: &mut Vec<usize>) {
        if self.graph.adjacent(a, b) {
            return;
        }
        let (s_a, s_b) = (self.sizes[a], self.sizes[b]);
        let mut common = 0;
        for w in self.graph.common(a, b) {
            common += self.sizes[w];
            self.fill[w] -= s_a * s_b;
            changed.push(w);
        }
        self.fill[a] += s_b * (self.degree[a] - common);
        self.fill[b] += s_a * (self.degree[b] - common);
        self.degree[a] += s_b;
        self.degree[b] += s_a;
        self.graph.connect(a, b);
    }
}
