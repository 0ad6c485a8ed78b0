//! [`Derivatives`]: the contributions of a formula to 𝓛_v, 𝓛_q + Q and dΦ/dt, and their derivatives, as nodes of the formula's graph.

use super::block::{Block, BlockEntry};
use super::difference::{Differences, Pairs};
use super::differentiated::Component;
use super::kind::ElementKind;
use super::labelled::{gradient, without_zeros};
use super::shape::{Shape, Slot, bound_constants};
use crate::program::{Graph, Node, Template};

/// Contributions of a formula and their derivatives, as nodes of its graph.
pub(in crate::system) struct Derivatives {
    pub(in crate::system) kind: ElementKind,
    pub(in crate::system) shape: Shape,
    /// T, V, Q or Φ.
    pub(in crate::system) values: Vec<Node>,
    pub(in crate::system) l_v: Vec<Node>,
    pub(in crate::system) force: Vec<Node>,
    pub(in crate::system) phi_dot: Vec<Node>,
    /// Φ_q and (dΦ/dt)_q by rows, and Φ_t.
    pub(in crate::system) phi_q: Vec<Node>,
    phi_dot_q: Vec<Node>,
    phi_t: Vec<Node>,
    /// Q_v and Q_q by columns.
    force_v: Vec<Node>,
    force_q: Vec<Node>,
    /// All second derivatives that are not structurally zero.
    pub(in crate::system) entries: Vec<(BlockEntry, Node)>,
}

impl Derivatives {
    /// Differentiates a recorded formula; returns its graph and the derivatives.
    pub(in crate::system) fn new(kind: ElementKind, shape: Shape, template: &Template) -> (Graph, Self) {
        let (mut graph, values) = template.graph();
        let n = shape.n;
        let zero = graph.constant(0.0);
        let mut derivatives = Derivatives {
            kind,
            shape,
            values: values.clone(),
            l_v: vec![zero; n],
            force: vec![zero; n],
            phi_dot: Vec::new(),
            phi_q: Vec::new(),
            phi_dot_q: Vec::new(),
            phi_t: Vec::new(),
            force_v: Vec::new(),
            force_q: Vec::new(),
            entries: Vec::new(),
        };
        let q: Vec<Node> = (0..n).map(|i| graph.input(i)).collect();
        let v: Vec<Node> = (0..n).map(|i| graph.input(shape.number(Slot::V(i)))).collect();
        match kind {
            ElementKind::Kinetic => derivatives.kinetic(&mut graph, values[0], (&q, &v)),
            ElementKind::Potential => derivatives.potential(&mut graph, values[0], &q),
            ElementKind::Applied => derivatives.applied(&mut graph, &values, (&q, &v)),
            ElementKind::Holonomic => derivatives.holonomic(&mut graph, &values, (&q, &v)),
        }
        derivatives.entries.retain(|(_, node)| !graph.is_zero(*node));
        derivatives.entries.sort_by_key(|(entry, _)| (entry.block, entry.mirrored));
        (graph, derivatives)
    }

    fn kinetic(&mut self, graph: &mut Graph, energy: Node, (q, v): (&[Node], &[Node])) {
        let (n, one) = (q.len(), graph.constant(1.0));
        let gradient = graph.reverse(&[(energy, one)], &[v, q].concat());
        self.l_v = gradient[..n].to_vec();
        self.force = gradient[n..].to_vec();
        for (i, v) in v.iter().enumerate() {
            let slopes = graph.forward(&gradient, &[(*v, one)]);
            self.entries.extend((i..n).map(|k| (BlockEntry::symmetric(Block::Vv, k, i), slopes[k])));
            self.entries.extend((0..n).map(|k| (BlockEntry::new(Block::Vq, i, k), slopes[n + k])));
        }
        self.symmetric(graph, Block::Qq, q);
    }

    fn potential(&mut self, graph: &mut Graph, energy: Node, q: &[Node]) {
        let minus = graph.constant(-1.0);
        self.force = graph.reverse(&[(energy, minus)], q);
        self.symmetric(graph, Block::Qq, q);
    }

    /// Adds the lower triangle of a symmetric block: the derivatives of the force.
    fn symmetric(&mut self, graph: &mut Graph, block: Block, q: &[Node]) {
        let one = graph.constant(1.0);
        for (i, x) in q.iter().enumerate() {
            let slopes = graph.forward(&self.force[i..], &[(*x, one)]);
            self.entries.extend((i..q.len()).map(|k| (BlockEntry::symmetric(block, k, i), slopes[k - i])));
        }
    }

    fn applied(&mut self, graph: &mut Graph, values: &[Node], (q, v): (&[Node], &[Node])) {
        let (n, one) = (q.len(), graph.constant(1.0));
        self.force = values.to_vec();
        let mut columns = |x: &[Node]| x.iter().flat_map(|x| graph.forward(values, &[(*x, one)])).collect();
        (self.force_v, self.force_q) = (columns(v), columns(q));
        for (block, columns) in [(Block::ForceV, &self.force_v), (Block::ForceQ, &self.force_q)] {
            self.entries.extend(columns.iter().enumerate().map(|(k, slope)| (BlockEntry::new(block, k % n, k / n), *slope)));
        }
    }

    fn holonomic(&mut self, graph: &mut Graph, phi: &[Node], (q, v): (&[Node], &[Node])) {
        let (shape, one) = (self.shape, graph.constant(1.0));
        let (n, m) = (shape.n, shape.m);
        let t = graph.input(shape.number(Slot::T));
        let sigma: Vec<Node> = (0..m).map(|j| graph.input(shape.number(Slot::Sigma(j)))).collect();
        for &phi in phi {
            let row = graph.reverse(&[(phi, one)], &[q, &[t]].concat());
            self.phi_q.extend(&row[..n]);
            self.phi_t.push(row[n]);
        }
        let along: Vec<(Node, Node)> = q.iter().copied().zip(v.iter().copied()).chain([(t, one)]).collect();
        self.phi_dot_q = graph.forward(&self.phi_q, &along);
        self.phi_dot = (0..m).map(|j| sum_of_products(graph, &self.phi_q[j * n..][..n], v, self.phi_t[j])).collect();
        let zero = graph.constant(0.0);
        let column = |rows: &[Node], i: usize| (0..m).map(|j| rows[j * n + i]).collect::<Vec<_>>();
        self.l_v = (0..n).map(|i| sum_of_products(graph, &column(&self.phi_q, i), &sigma, zero)).collect();
        self.force = (0..n).map(|i| sum_of_products(graph, &column(&self.phi_dot_q, i), &sigma, zero)).collect();
        for (i, x) in q.iter().enumerate() {
            let slopes = graph.forward(&self.l_v[i..], &[(*x, one)]);
            let rates = graph.forward(&slopes, &along);
            let entry = |block| move |k| BlockEntry::symmetric(block, k, i);
            self.entries.extend((i..n).map(entry(Block::PhiQq)).zip(slopes));
            self.entries.extend((i..n).map(entry(Block::PhiDotQq)).zip(rates));
        }
        for (block, rows) in [(Block::PhiQ, &self.phi_q), (Block::PhiDotQ, &self.phi_dot_q)] {
            self.entries.extend(rows.iter().enumerate().map(|(k, node)| (BlockEntry::new(block, k / n, k % n), *node)));
        }
    }

    /// The coordinates in which all equations of a constraint are linear.
    pub(in crate::system) fn linear_columns(&self, graph: &Graph) -> Vec<bool> {
        let is_linear = |i: usize| self.phi_q.iter().skip(i).step_by(self.shape.n).all(|node| graph.is_fixed(*node));
        (0..self.shape.n).map(is_linear).collect()
    }

    /// The differences of coordinates on which the derivatives depend, if they depend on differences only.
    pub(in crate::system) fn differences(&self, graph: &Graph) -> Differences {
        let n = self.shape.n;
        let find = |rows: &[Vec<Node>]| Pairs::find(graph, n, rows.iter().map(Vec::as_slice));
        let of_forces = |nodes: &[Node]| find(&[nodes.to_vec()]);
        let rows = |columns: &[Node]| -> Vec<Vec<Node>> {
            (0..n).map(|row| columns.iter().skip(row).step_by(n).copied().collect()).collect()
        };
        match self.kind {
            ElementKind::Kinetic => {
                let (v, q) = (of_forces(&self.l_v), of_forces(&self.force));
                Differences { momentum: v.clone(), force: q.clone(), v, q }
            }
            ElementKind::Potential => Differences::of_coordinates(of_forces(&self.force)),
            ElementKind::Applied => Differences {
                momentum: Pairs::none(n),
                force: of_forces(&self.force),
                v: find(&rows(&self.force_v)),
                q: find(&rows(&self.force_q)),
            },
            ElementKind::Holonomic => {
                let phi_q: Vec<Vec<Node>> = self.phi_q.chunks(n.max(1)).map(<[Node]>::to_vec).collect();
                Differences::of_coordinates(find(&phi_q))
            }
        }
    }

    /// The components that are evaluated at every iteration; for a constraint, without its linear columns.
    pub(in crate::system) fn without_linear_columns(
        &self,
        graph: &mut Graph,
        is_linear: &[bool],
    ) -> (Vec<Component>, Vec<Node>) {
        let (shape, mut l_v, mut phi_dot) = (self.shape, self.l_v.clone(), self.phi_dot.clone());
        if self.kind == ElementKind::Holonomic {
            let zero = graph.constant(0.0);
            let bent: Vec<usize> = (0..shape.n).filter(|&i| !is_linear[i]).collect();
            let v: Vec<Node> = bent.iter().map(|&i| graph.input(shape.number(Slot::V(i)))).collect();
            (0..shape.n).filter(|&i| is_linear[i]).for_each(|i| l_v[i] = zero);
            for (j, phi_dot) in phi_dot.iter_mut().enumerate() {
                let row: Vec<Node> = bent.iter().map(|i| self.phi_q[j * shape.n + i]).collect();
                *phi_dot = sum_of_products(graph, &row, &v, self.phi_t[j]);
            }
        }
        without_zeros(graph, components([&l_v, &self.force, &phi_dot]))
    }

    /// Q_u by rows.
    pub(in crate::system) fn by_controls(&self, graph: &mut Graph) -> Vec<Node> {
        let shape = self.shape;
        if self.kind != ElementKind::Applied {
            return Vec::new();
        }
        let one = graph.constant(1.0);
        let columns: Vec<Vec<Node>> = (0..shape.k)
            .map(|k| {
                let u = graph.input(shape.number(Slot::U(k)));
                graph.forward(&self.values, &[(u, one)])
            })
            .collect();
        (0..shape.n).flat_map(|i| columns.iter().map(move |column| column[i]).collect::<Vec<_>>()).collect()
    }

    /// The derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to inputs.
    pub(in crate::system) fn by_inputs(
        &self,
        graph: &mut Graph,
        (bound, timed, by_controls): (&[bool], bool, bool),
    ) -> Vec<(Slot, Node)> {
        let controls = if by_controls { 0..self.shape.k } else { 0..0 };
        let mut of: Vec<Slot> = controls.map(Slot::U).collect();
        of.extend(bound_constants(bound));
        of.extend(timed.then_some(Slot::T));
        let weighted = self.weighted(graph);
        gradient(graph, self.shape, &weighted, &of)
    }

    /// The components of 𝓛_v, 𝓛_q + Q and dΦ/dt, paired with c, d and e.
    pub(in crate::system) fn weighted(&self, graph: &mut Graph) -> Vec<(Node, Node)> {
        let (shape, mut all) = (self.shape, Vec::new());
        for (nodes, first) in [(&self.l_v, shape.c()), (&self.force, shape.d()), (&self.phi_dot, shape.e())] {
            all.extend(nodes.iter().enumerate().map(|(i, node)| (*node, graph.input(first + i))));
        }
        all
    }

    /// ψ = c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate.
    pub(in crate::system) fn along(&self, graph: &mut Graph) -> [Node; 2] {
        let sum = self.weighted_sum(graph);
        let shape = self.shape;
        let moving = shape.states().into_iter().chain((0..shape.k).map(Slot::U)).chain([Slot::T]);
        let tangents: Vec<(Node, Node)> =
            moving.map(|slot| (graph.input(shape.number(slot)), graph.input(shape.rate(slot)))).collect();
        [sum, graph.forward(&[sum], &tangents)[0]]
    }

    /// ψ = c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt.
    pub(in crate::system) fn weighted_sum(&self, graph: &mut Graph) -> Node {
        let (x, y): (Vec<Node>, Vec<Node>) = self.weighted(graph).into_iter().unzip();
        let zero = graph.constant(0.0);
        sum_of_products(graph, &x, &y, zero)
    }
}

/// Σ x_i y_i + z.
pub(in crate::system) fn sum_of_products(graph: &mut Graph, x: &[Node], y: &[Node], z: Node) -> Node {
    x.iter().zip(y).fold(z, |sum, (x, y)| {
        let product = graph.multiply(*x, *y);
        graph.add(sum, product)
    })
}

/// The nodes of 𝓛_v, 𝓛_q + Q and dΦ/dt (or of corresponding quantities), each with its component.
pub(in crate::system) fn components([l_v, force, phi_dot]: [&[Node]; 3]) -> Vec<(Component, Node)> {
    let momenta = (0..).map(Component::Momentum).zip(l_v);
    let forces = (0..).map(Component::Force).zip(force);
    let equations = (0..).map(Component::Equation).zip(phi_dot);
    momenta.chain(forces).chain(equations).map(|(of, node)| (of, *node)).collect()
}
