//! The canonical order of nodes, which depends on the formulas alone and not on the order in which they were recorded.

use std::hash::{Hash, Hasher};

use super::expression::{Expression, Node};
use super::graph::{Graph, Map, Mixer};

/// A number that depends on a formula alone, after the least of its inputs.
type Key = (usize, u64);

impl Graph {
    /// The results in a graph of their own, whose nodes follow each other as the results need them. Of arguments that commute, the one with the least input
    /// is first.
    pub(crate) fn canonical(&self, results: &[Node]) -> (Graph, Vec<Node>) {
        let (keys, mut graph, mut made) = (self.keys(results), Graph::default(), Map::<Node, Node>::default());
        let mut open: Vec<Node> = results.iter().rev().copied().collect();
        while let Some(&node) = open.last() {
            let expression = self.expression(node);
            let mut missing: Vec<Node> = expression.arguments().filter(|x| !made.contains_key(x)).collect();
            if missing.is_empty() {
                let new = graph.make(expression.map(|x| made[&x]));
                made.insert(node, new);
                open.pop();
                continue;
            }
            if commutes(expression) {
                missing.sort_by_key(|x| keys[x]);
            }
            open.extend(missing.into_iter().rev());
        }
        (graph, results.iter().map(|node| made[node]).collect())
    }

    fn keys(&self, results: &[Node]) -> Map<Node, Key> {
        let mut keys: Map<Node, Key> = Map::default();
        for node in self.reachable(results.iter().copied()) {
            let expression = self.expression(node);
            let mut of: Vec<Key> = expression.arguments().map(|x| keys[&x]).collect();
            if commutes(expression) {
                of.sort_unstable();
            }
            let first = of.iter().map(|(first, _)| *first).chain(expression.input()).min().unwrap_or(usize::MAX);
            let mut mixer = Mixer::default();
            expression.map(|_| Node(0)).hash(&mut mixer);
            of.iter().for_each(|(_, key)| mixer.write_u64(*key));
            keys.insert(node, (first, mixer.finish()));
        }
        keys
    }
}

/// True if both arguments of an operation can be exchanged.
fn commutes(expression: Expression) -> bool {
    matches!(expression, Expression::Add(..) | Expression::Multiply(..))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_recording_does_not_matter() {
        let record = |order: [usize; 4]| {
            let mut graph = Graph::default();
            for i in order {
                graph.input(i);
            }
            let x: Vec<Node> = (0..4).map(|i| graph.input(i)).collect();
            let (a, b) = (graph.multiply(x[0], x[1]), graph.multiply(x[2], x[3]));
            let pair = if order[0] == 0 { [a, b] } else { [b, a] };
            let sums = pair.map(|product| graph.add(product, x[order[1]]));
            let all = graph.multiply(sums[0], sums[1]);
            let all = graph.subtract(all, x[1]);
            let (graph, results) = graph.canonical(&[all, x[order[1]]]);
            (graph.expressions().collect::<Vec<_>>(), results)
        };
        assert_eq!(record([0, 2, 1, 3]), record([3, 2, 0, 1]));
        assert_ne!(record([0, 2, 1, 3]), record([0, 3, 1, 2]));
    }
}
