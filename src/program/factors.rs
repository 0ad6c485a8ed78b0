//! Transformations of results that reduce the number of multiplications.
//!
//! ```text
//!   (a b) c,  (a d) b    →    p = a b,  p c,  p d        the most frequent pairs of factors are multiplied once
//!   f a ± f b            →    f (a ± b)                  for a fixed factor f
//!   f a ± g a            →    (f ± g) a                  for fixed factors f and g
//! ```
//!
//! The order of sums is preserved, because a small difference of large numbers may be exact in the order in which it was written.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::expression::{Expression, Node};
use super::graph::{Graph, Map};

/// Products of more factors are left unchanged, because they have too many pairs.
const MOST: usize = 50;

/// The nodes from which some results are computed, in order, and the number of uses of each node.
struct Needed {
    nodes: Vec<Node>,
    uses: Vec<usize>,
}

impl Needed {
    fn new(graph: &Graph, results: &[Node]) -> Self {
        let (nodes, mut uses) = (graph.reachable(results.iter().copied()), vec![0; graph.len()]);
        let arguments = nodes.iter().flat_map(|&node| graph.expression(node).arguments());
        arguments.chain(results.iter().copied()).for_each(|node| uses[node.index()] += 1);
        Needed { nodes, uses }
    }

    fn is_used_once(&self, node: Node) -> bool {
        self.uses[node.index()] == 1
    }
}

impl Graph {
    /// Equivalent results that require fewer multiplications.
    pub(super) fn factored(&mut self, results: &[Node]) -> Vec<Node> {
        let needed = Needed::new(self, results);
        let products = Products::new(self, &needed);
        let results = self.rebuilt(&needed, results, |graph, node, map| products.rebuild(graph, node, map));
        let needed = Needed::new(self, &results);
        self.rebuilt(&needed, &results, |graph, node, map| graph.sum_of_multiples(node, &needed, map))
    }

    /// The results, with all nodes they need computed by `rebuild` or, if it returns `None`, by the same operation as before.
    ///
    /// The arguments of angles are left unchanged: angles jump at ±π if a difference that was exactly zero is rounded.
    fn rebuilt(
        &mut self,
        needed: &Needed,
        results: &[Node],
        rebuild: impl Fn(&mut Self, Node, &[Node]) -> Option<Node>,
    ) -> Vec<Node> {
        let is_angle = |node: &&Node| matches!(self.expression(**node), Expression::Atan2(..));
        let angles: Vec<Node> = needed.nodes.iter().filter(is_angle).copied().collect();
        let mut stays = self.fixed();
        self.reachable(angles).into_iter().for_each(|node| stays[node.index()] = true);
        let mut map: Vec<Node> = (0..self.len()).map(|i| Node(i as u32)).collect();
        let is_loose = self.is_loose;
        for node in needed.nodes.iter().copied().filter(|node| !stays[node.index()]) {
            self.is_loose = !self.is_signed(node);
            let made = rebuild(self, node, &map).unwrap_or_else(|| {
                let expression = self.expression(node);
                let anew = expression.map(|x| map[x.index()]);
                if anew == expression { node } else { self.make(anew) }
            });
            map[node.index()] = made;
        }
        self.is_loose = is_loose;
        results.iter().map(|node| map[node.index()]).collect()
    }

    /// Rewrites f a ± f b as f (a ± b), if neither product has another use, and f a ± g a as (f ± g) a.
    fn sum_of_multiples(&mut self, node: Node, needed: &Needed, map: &[Node]) -> Option<Node> {
        let (terms, join): (_, fn(&mut Graph, Node, Node) -> Node) = match self.expression(node) {
            _ if self.is_signed(node) => return None,
            Expression::Add(x, y) => ([x, y], Graph::add),
            Expression::Subtract(x, y) => ([x, y], Graph::subtract),
            _ => return None,
        };
        let [(f, a), (g, b)] = terms.map(|term| self.multiple(map[term.index()]));
        if self.is_fixed(a) || self.is_fixed(b) {
            return None;
        }
        if a == b {
            let factor = join(self, f, g);
            return Some(self.multiply(factor, a));
        }
        let is_free = self.value(f) != Some(1.0) && terms.iter().all(|term| needed.is_used_once(*term));
        (f == g && is_free).then(|| {
            let sum = join(self, a, b);
            self.multiply(f, sum)
        })
    }

    /// The fixed factor of a node, which may be 1, and the other factor.
    fn multiple(&mut self, node: Node) -> (Node, Node) {
        self.fixed_factor(node).unwrap_or_else(|| (self.constant(1.0), node))
    }
}

/// The number of products that contain each pair of factors.
#[derive(Default)]
struct Pairs {
    /// The products that have contained a pair, and the number of those that still contain it.
    holders: Map<(u32, u32), (Vec<Node>, usize)>,
    /// Each pair with every number of products greater than one in which it has occurred.
    queue: BinaryHeap<(usize, Reverse<(u32, u32)>)>,
}

impl Pairs {
    fn add(&mut self, pair: (u32, u32), node: Node) {
        let (holders, count) = self.holders.entry(pair).or_default();
        holders.push(node);
        *count += 1;
        self.queue.extend((*count > 1).then_some((*count, Reverse(pair))));
    }

    fn remove(&mut self, pair: (u32, u32)) {
        let (_, count) = self.holders.entry(pair).or_default();
        *count -= 1;
        self.queue.extend((*count > 1).then_some((*count, Reverse(pair))));
    }

    /// Removes and returns the pair that occurs in most products (at least two), with all products that have contained it.
    fn most_frequent(&mut self) -> Option<((u32, u32), Vec<Node>)> {
        while let Some((count, Reverse(pair))) = self.queue.pop() {
            let (holders, now) = self.holders.entry(pair).or_default();
            if *now == count && !holders.is_empty() {
                return Some((pair, std::mem::take(holders)));
            }
        }
        None
    }
}

/// Products of varying factors, each with all of its factors.
struct Products {
    /// Factors, or pairs of factors, which are numbered after all nodes. Omits nodes that are not products or are used in one other product only.
    factors: Map<Node, Vec<u32>>,
    /// The pairs that were replaced by a factor.
    joined: Vec<(u32, u32)>,
    /// The number of nodes, which is also the number of the first pair.
    nodes: u32,
}

impl Products {
    /// Collects the products among the needed nodes and joins frequent pairs.
    fn new(graph: &Graph, needed: &Needed) -> Self {
        let mut factors = Map::<Node, Vec<u32>>::default();
        for &node in &needed.nodes {
            let Some(pair) = varying_factors(graph, node) else { continue };
            let mut own = Vec::new();
            for factor in pair {
                let inner = if needed.is_used_once(factor) { factors.remove(&factor) } else { None };
                own.extend(inner.unwrap_or_else(|| vec![factor.0]));
            }
            own.sort_unstable();
            factors.insert(node, own);
        }
        factors.retain(|_, factors| factors.len() <= MOST);
        let mut products = Products { factors, joined: Vec::new(), nodes: graph.len() as u32 };
        products.join_pairs();
        products.factors.retain(|_, factors| factors.iter().any(|&factor| factor >= products.nodes));
        products
    }

    /// Replaces the most frequent pair of factors by its product until no pair occurs twice.
    fn join_pairs(&mut self) {
        let mut pairs = Pairs::default();
        for (&node, factors) in &self.factors {
            pairs_of(factors).into_iter().for_each(|pair| pairs.add(pair, node));
        }
        while let Some((pair, holders)) = pairs.most_frequent() {
            let joined = self.nodes + self.joined.len() as u32;
            self.joined.push(pair);
            for node in holders {
                let Some(factors) = self.factors.get_mut(&node) else { continue };
                let before = pairs_of(factors);
                if before.binary_search(&pair).is_err() {
                    continue;
                }
                for factor in <[u32; 2]>::from(pair) {
                    if let Some(at) = factors.iter().position(|other| *other == factor) {
                        factors.remove(at);
                    }
                }
                factors.push(joined);
                let after = pairs_of(factors);
                before.into_iter().filter(|pair| after.binary_search(pair).is_err()).for_each(|pair| pairs.remove(pair));
                after.into_iter().filter(|pair| pair.1 == joined).for_each(|pair| pairs.add(pair, node));
            }
        }
    }

    /// Computes a product from its factors and pairs.
    fn rebuild(&self, graph: &mut Graph, node: Node, map: &[Node]) -> Option<Node> {
        let factors = self.factors.get(&node)?.iter().map(|&factor| self.node(graph, factor, map)).collect::<Vec<_>>();
        factors.into_iter().reduce(|x, y| graph.multiply(x, y))
    }

    /// The node of a factor or of a pair of factors.
    fn node(&self, graph: &mut Graph, factor: u32, map: &[Node]) -> Node {
        let Some(pair) = factor.checked_sub(self.nodes) else { return map[factor as usize] };
        let (x, y) = self.joined[pair as usize];
        let [x, y] = [x, y].map(|factor| self.node(graph, factor, map));
        graph.multiply(x, y)
    }
}

/// The factors of a product if both of them vary.
fn varying_factors(graph: &Graph, node: Node) -> Option<[Node; 2]> {
    match graph.expression(node) {
        Expression::Multiply(x, y) if !graph.is_fixed(x) && !graph.is_fixed(y) => Some([x, y]),
        _ => None,
    }
}

/// All pairs of the given sorted factors, without duplicates.
fn pairs_of(factors: &[u32]) -> Vec<(u32, u32)> {
    let pairs = factors.iter().enumerate().flat_map(|(i, &x)| factors[i + 1..].iter().map(move |&y| (x, y)));
    let mut pairs: Vec<_> = pairs.collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of multiplications before and after the transformation; also checks that the values agree.
    fn multiplications(graph: &mut Graph, results: &[Node]) -> [usize; 2] {
        let count = |graph: &Graph, results: &[Node]| {
            let nodes = graph.reachable(results.iter().copied()).into_iter();
            nodes.filter(|&node| matches!(graph.expression(node), Expression::Multiply(..)) && !graph.is_fixed(node)).count()
        };
        let factored = graph.factored(results);
        let values: Vec<f64> = graph.evaluate(&[1.7, -0.6], &[0.3, 1.2, -0.8, 2.1]);
        for (old, new) in results.iter().zip(&factored) {
            let (old, new) = (values[old.index()], values[new.index()]);
            assert!((old - new).abs() <= 1e-15 * old.abs(), "{old} {new}");
        }
        [count(graph, results), count(graph, &factored)]
    }

    fn product(graph: &mut Graph, factors: &[Node]) -> Node {
        factors.iter().copied().reduce(|x, y| graph.multiply(x, y)).expect("factors")
    }

    #[test]
    fn a_pair_of_factors_that_stands_in_several_products_is_multiplied_once() {
        let mut graph = Graph::default().loose();
        let [x, y, z, w] = [0, 1, 2, 3].map(|which| graph.input(which));
        let results = [[x, y, z], [x, w, y], [y, z, w], [x, x, y]].map(|factors| product(&mut graph, &factors));
        // x y occurs with z, with w and with x; y z w is computed by two multiplications.
        assert_eq!(multiplications(&mut graph, &results), [8, 6]);
        // The product x z, which is needed as a result, is used.
        let mut graph = Graph::default().loose();
        let [x, y, z] = [0, 1, 2].map(|which| graph.input(which));
        let results = [[x, y, z], [x, z, z]].map(|factors| product(&mut graph, &factors));
        let results = [results[0], results[1], graph.multiply(x, z)];
        assert_eq!(multiplications(&mut graph, &results), [4, 3]);
    }

    #[test]
    fn fixed_factors_go_in_front_of_sums_unless_their_products_are_needed() {
        let mut graph = Graph::default().loose();
        let [x, y] = [0, 1].map(|which| graph.input(which));
        let [f, g] = [0, 1].map(|which| graph.parameter(which));
        let [fx, fy, gx, gy] = [(f, x), (f, y), (g, x), (g, y)].map(|(factor, x)| graph.multiply(factor, x));
        let (sum, difference, other) = (graph.add(fx, fy), graph.subtract(fx, gx), graph.add(fx, gy));
        assert_eq!(multiplications(&mut graph, &[sum]), [2, 1]);
        assert_eq!(multiplications(&mut graph, &[difference]), [2, 1]);
        assert_eq!(multiplications(&mut graph, &[sum, fx]), [2, 2]);
        assert_eq!(multiplications(&mut graph, &[other]), [2, 2]);
    }

    #[test]
    fn angles_of_points_are_what_they_were() {
        let mut graph = Graph::default().loose();
        let [x, y] = [0, 1].map(|which| graph.input(which));
        let f = graph.parameter(1);
        let [fx, fy] = [x, y].map(|x| graph.multiply(f, x));
        let (above, right) = (graph.subtract(fx, fy), graph.constant(-1.0));
        let angle = graph.atan2(above, right);
        assert_eq!(graph.factored(&[angle]), [angle]);
    }
}
