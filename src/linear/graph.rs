//! An undirected graph under elimination of its vertices.

use std::collections::BTreeSet;

#[cfg(test)]
thread_local! {
    /// The number of neighbours visited or moved by this thread.
    pub(super) static VISITS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

/// Counts visits, in tests only.
fn count(_visits: usize) {
    #[cfg(test)]
    VISITS.set(VISITS.get() + _visits);
}

/// Undirected graph without loops, as the set of neighbours of each vertex.
#[derive(Debug, Clone)]
pub(super) struct Graph {
    neighbours: Vec<BTreeSet<usize>>,
}

impl Graph {
    /// The graph of `size` vertices without edges.
    pub(super) fn new(size: usize) -> Self {
        Self { neighbours: vec![BTreeSet::new(); size] }
    }

    /// Number of vertices, the eliminated ones included.
    pub(super) fn size(&self) -> usize {
        self.neighbours.len()
    }

    /// Neighbours of vertex `v` in ascending order.
    pub(super) fn neighbours(&self, v: usize) -> impl Iterator<Item = usize> {
        self.neighbours[v].iter().copied().inspect(|_| count(1))
    }

    /// Whether {a, b} is an edge.
    pub(super) fn adjacent(&self, a: usize, b: usize) -> bool {
        count(1);
        self.neighbours[a].contains(&b)
    }

    /// The number of neighbours of vertex `v`.
    pub(super) fn degree(&self, v: usize) -> usize {
        self.neighbours[v].len()
    }

    /// The common neighbours of two vertices, found in time that depends on the smaller of their degrees.
    pub(super) fn common(&self, a: usize, b: usize) -> impl Iterator<Item = usize> {
        let (few, many) = if self.degree(a) < self.degree(b) { (a, b) } else { (b, a) };
        self.neighbours(few).filter(move |&w| self.adjacent(w, many))
    }

    /// Adds the edge {a, b}; a loop is ignored.
    pub(super) fn connect(&mut self, a: usize, b: usize) {
        if a != b {
            self.neighbours[a].insert(b);
            self.neighbours[b].insert(a);
        }
    }

    /// Removes vertex `v`, connects its neighbours to one another (the fill), and returns them.
    pub(super) fn eliminate(&mut self, v: usize) -> Vec<usize> {
        let clique = self.remove(v);
        count(clique.len() * clique.len());
        for &a in &clique {
            self.neighbours[a].extend(clique.iter().filter(|&&b| b != a));
        }
        clique
    }

    /// Removes vertex `v` with its edges and returns its neighbours.
    pub(super) fn remove(&mut self, v: usize) -> Vec<usize> {
        let neighbours: Vec<usize> = std::mem::take(&mut self.neighbours[v]).into_iter().collect();
        for &a in &neighbours {
            self.neighbours[a].remove(&v);
        }
        neighbours
    }

    /// The graph of the classes of vertices; two classes are adjacent if they contain adjacent vertices.
    pub(super) fn quotient(&self, classes: usize, class_of: &[usize]) -> Graph {
        let mut quotient = Graph::new(classes);
        for a in 0..self.size() {
            for b in self.neighbours(a) {
                quotient.connect(class_of[a], class_of[b]);
            }
        }
        quotient
    }
}
