//! [`Formula`]: what a recorded formula says of its element, and the programs made of it; the same for all elements of one shape.
//!
//! With T_x the derivative by x, and every sum over what is there:
//!
//! ```text
//!   kinetic    𝓛_v = T_v,     𝓛_q = T_q                  applied     Q
//!   potential  𝓛_q = −V_q                                constraint  𝓛_v = Φ_qᵀσ,  𝓛_q = (dΦ/dt)_qᵀσ,  dΦ/dt = Φ_q v + Φ_t
//! ```
//!
//! Gradients are taken from the results to the arguments (reverse mode), second derivatives of them from the arguments to the results.

use super::block::{Block, BlockEntry};
use super::jet::ElementKind;
use super::shape::Shape;
use crate::program::{Expression, Function, Graph, Kernel, Node, Obstacle, Template};

/// A component of 𝓛_v, of 𝓛_q + Q or of dΦ/dt, by the element's own number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    Momentum(usize),
    Force(usize),
    Equation(usize),
}

/// What an element's sum c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt is differentiated by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputOf {
    Control(usize),
    Constant(usize),
    Time,
}

/// The programs of an element that has a graph.
#[derive(Clone, Debug)]
pub struct Kernels {
    /// 𝓛_v, 𝓛_q + Q and dΦ/dt, of a constraint without its linear columns, and which component each result is.
    pub first: Kernel,
    pub components: Vec<Component>,
    /// The entries that vary.
    pub second: Kernel,
    /// The entries that are constant.
    pub fixed: Kernel,
    /// 𝓛_v and 𝓛_q + Q, and Q_u by rows, of an element that is constant.
    pub at_zero: Kernel,
    /// Derivatives with respect to inputs.
    pub inputs: Kernel,
    pub inputs_of: Vec<InputOf>,
    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate.
    pub along: Kernel,
}

/// What is known of a formula.
#[derive(Clone, Debug)]
pub struct Formula {
    pub kind: ElementKind,
    pub shape: Shape,
    /// What was recorded; nothing where that failed, and then everything is taken to vary.
    pub template: Option<Template>,
    pub obstacle: Option<Obstacle>,
    /// All second derivatives are constant, and nothing depends on time.
    pub constant: bool,
    /// A constraint that is a sum of q_i, sin q_i, cos q_i.
    pub sinusoidal: bool,
    pub timed: bool,
    /// Second derivatives that vary along a motion, and those that do not.
    pub varying: Vec<BlockEntry>,
    pub fixed: Vec<BlockEntry>,
    pub kernels: Option<Kernels>,
}

impl Formula {
    /// Of a formula that has no graph: num-dual evaluates it at every point.
    pub fn unknown(kind: ElementKind, shape: Shape, obstacle: Option<Obstacle>) -> Self {
        Formula {
            kind,
            shape,
            template: None,
            obstacle,
            constant: false,
            sinusoidal: false,
            timed: true,
            varying: BlockEntry::all(kind, shape.n, shape.m),
            fixed: Vec::new(),
            kernels: None,
        }
    }

    /// Differentiates a recorded formula; `bound` says which constants are design variables.
    pub fn new(kind: ElementKind, shape: Shape, template: Template, bound: &[bool]) -> Self {
        Formula::compile(kind, shape, template, bound)
            .unwrap_or_else(|| Formula::unknown(kind, shape, Some(Obstacle::IsTooLong)))
    }

    fn compile(kind: ElementKind, shape: Shape, template: Template, bound: &[bool]) -> Option<Self> {
        let (mut graph, values) = template.graph();
        let derivatives = Derivatives::new(&mut graph, kind, shape, &values);
        let depends = template.depends(shape.sigma());
        let (timed, parameters) = (depends[shape.t()], template.parameters);
        let is_control = |i: usize| (shape.u()..shape.t()).contains(&i);
        let controls = derivatives.by_controls(&mut graph, shape, &values);
        let linear_in_controls = controls.iter().all(|slope| graph.is_fixed(*slope));
        let all_fixed = derivatives.entries.iter().all(|(_, node)| graph.is_fixed(*node));
        let constant = all_fixed && !timed && (linear_in_controls || !(0..depends.len()).any(is_control));
        let is_sum = kind == ElementKind::Holonomic && values.iter().all(|phi| is_sinusoidal(&graph, *phi));
        let sinusoidal = is_sum && !timed && !constant;

        let is_linear = derivatives.linear_columns(&graph, shape);
        let is_constant = |(entry, node): &(BlockEntry, Node)| match kind {
            ElementKind::Holonomic => entry.block == Block::PhiQ && is_linear[entry.col] && graph.is_fixed(*node),
            _ => constant,
        };
        let (fixed, varying): (Vec<_>, Vec<_>) = derivatives.entries.iter().copied().partition(is_constant);
        let (of, results): (Vec<_>, Vec<_>) = derivatives.components(&mut graph, shape, &is_linear).into_iter().unzip();
        let (inputs_of, by_inputs) = derivatives.by_inputs(&mut graph, shape, (bound, timed, !constant));
        let along = derivatives.along(&mut graph, shape);
        let at_zero: Vec<Node> = derivatives.l_v.iter().chain(&derivatives.force).chain(&controls).copied().collect();
        let nodes = |entries: &[(BlockEntry, Node)]| entries.iter().map(|(_, node)| *node).collect::<Vec<_>>();
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, parameters, results);
        let kernels = Kernels {
            first: kernel(&results)?,
            components: of,
            second: kernel(&nodes(&varying))?,
            fixed: kernel(&nodes(&fixed))?,
            at_zero: kernel(&at_zero)?,
            inputs: kernel(&by_inputs)?,
            inputs_of,
            along: kernel(&along)?,
        };
        let entries = |entries: Vec<(BlockEntry, Node)>| entries.into_iter().map(|(entry, _)| entry).collect();
        Some(Formula {
            kind,
            shape,
            template: Some(template),
            obstacle: None,
            constant,
            sinusoidal,
            timed,
            varying: entries(varying),
            fixed: entries(fixed),
            kernels: Some(kernels),
        })
    }

    /// Whether its derivatives vary within a step, other than as sines of angles, whose turns are looked at themselves.
    pub fn may_bend(&self) -> bool {
        self.timed || !self.constant && !self.sinusoidal
    }

    /// Whether it is evaluated at every iteration.
    pub fn is_varying(&self) -> bool {
        !self.constant && !self.sinusoidal
    }
}

/// First and second derivatives as nodes of the formula's graph.
struct Derivatives {
    kind: ElementKind,
    l_v: Vec<Node>,
    force: Vec<Node>,
    phi_dot: Vec<Node>,
    /// Φ_q and (dΦ/dt)_q by rows, and Φ_t.
    phi_q: Vec<Node>,
    phi_dot_q: Vec<Node>,
    phi_t: Vec<Node>,
    /// All second derivatives that are not zero by structure.
    entries: Vec<(BlockEntry, Node)>,
}

impl Derivatives {
    fn new(graph: &mut Graph, kind: ElementKind, shape: Shape, values: &[Node]) -> Self {
        let n = shape.n;
        let zero = graph.constant(0.0);
        let mut derivatives = Derivatives {
            kind,
            l_v: vec![zero; n],
            force: vec![zero; n],
            phi_dot: Vec::new(),
            phi_q: Vec::new(),
            phi_dot_q: Vec::new(),
            phi_t: Vec::new(),
            entries: Vec::new(),
        };
        let q: Vec<Node> = (0..n).map(|i| graph.input(i)).collect();
        let v: Vec<Node> = (0..n).map(|i| graph.input(shape.v() + i)).collect();
        match kind {
            ElementKind::Kinetic => derivatives.kinetic(graph, values[0], (&q, &v)),
            ElementKind::Potential => derivatives.potential(graph, values[0], &q),
            ElementKind::Applied => derivatives.applied(graph, values, (&q, &v)),
            ElementKind::Holonomic => derivatives.holonomic(graph, shape, values, (&q, &v)),
        }
        derivatives.entries.retain(|(_, node)| !graph.is_zero(*node));
        derivatives.entries.sort_by_key(|(entry, _)| (entry.block, entry.mirrored));
        derivatives
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

    /// The lower triangle of a block: the derivatives of the force.
    fn symmetric(&mut self, graph: &mut Graph, block: Block, q: &[Node]) {
        let one = graph.constant(1.0);
        for (i, x) in q.iter().enumerate() {
            let slopes = graph.forward(&self.force[i..], &[(*x, one)]);
            self.entries.extend((i..q.len()).map(|k| (BlockEntry::symmetric(block, k, i), slopes[k - i])));
        }
    }

    fn applied(&mut self, graph: &mut Graph, values: &[Node], (q, v): (&[Node], &[Node])) {
        let one = graph.constant(1.0);
        self.force = values.to_vec();
        for (block, x) in [(Block::ForceV, v), (Block::ForceQ, q)] {
            for (col, x) in x.iter().enumerate() {
                let slopes = graph.forward(values, &[(*x, one)]);
                self.entries
                    .extend(slopes.into_iter().enumerate().map(|(row, slope)| (BlockEntry::new(block, row, col), slope)));
            }
        }
    }

    fn holonomic(&mut self, graph: &mut Graph, shape: Shape, phi: &[Node], (q, v): (&[Node], &[Node])) {
        let (n, m, one) = (shape.n, shape.m, graph.constant(1.0));
        let t = graph.input(shape.t());
        let sigma: Vec<Node> = (0..m).map(|j| graph.input(shape.sigma() + j)).collect();
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
    fn linear_columns(&self, graph: &Graph, shape: Shape) -> Vec<bool> {
        let is_linear = |i: usize| self.phi_q.iter().skip(i).step_by(shape.n).all(|node| graph.is_fixed(*node));
        (0..shape.n).map(is_linear).collect()
    }

    /// What is evaluated at every iteration: of a constraint, without its linear columns.
    fn components(&self, graph: &mut Graph, shape: Shape, is_linear: &[bool]) -> Vec<(Component, Node)> {
        let (mut l_v, mut phi_dot) = (self.l_v.clone(), self.phi_dot.clone());
        if self.kind == ElementKind::Holonomic {
            let zero = graph.constant(0.0);
            let bent: Vec<usize> = (0..shape.n).filter(|&i| !is_linear[i]).collect();
            let v: Vec<Node> = bent.iter().map(|i| graph.input(shape.v() + i)).collect();
            (0..shape.n).filter(|&i| is_linear[i]).for_each(|i| l_v[i] = zero);
            for (j, phi_dot) in phi_dot.iter_mut().enumerate() {
                let row: Vec<Node> = bent.iter().map(|i| self.phi_q[j * shape.n + i]).collect();
                *phi_dot = sum_of_products(graph, &row, &v, self.phi_t[j]);
            }
        }
        let numbered = |of: fn(usize) -> Component, nodes: Vec<Node>| {
            nodes.into_iter().enumerate().map(move |(i, node)| (of(i), node)).collect::<Vec<_>>()
        };
        let mut all = numbered(Component::Momentum, l_v);
        all.extend(numbered(Component::Force, self.force.clone()));
        all.extend(numbered(Component::Equation, phi_dot));
        all.retain(|(_, node)| !graph.is_zero(*node));
        all
    }

    /// Q_u by rows.
    fn by_controls(&self, graph: &mut Graph, shape: Shape, values: &[Node]) -> Vec<Node> {
        if self.kind != ElementKind::Applied {
            return Vec::new();
        }
        let one = graph.constant(1.0);
        let columns: Vec<Vec<Node>> = (0..shape.k)
            .map(|k| {
                let u = graph.input(shape.u() + k);
                graph.forward(values, &[(u, one)])
            })
            .collect();
        (0..shape.n).flat_map(|i| columns.iter().map(move |column| column[i]).collect::<Vec<_>>()).collect()
    }

    /// The derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to inputs, without those that vanish.
    fn by_inputs(
        &self,
        graph: &mut Graph,
        shape: Shape,
        (bound, timed, by_controls): (&[bool], bool, bool),
    ) -> (Vec<InputOf>, Vec<Node>) {
        let controls = if by_controls { 0..shape.k } else { 0..0 };
        let mut of: Vec<InputOf> = controls.map(InputOf::Control).collect();
        of.extend((0..shape.p).filter(|&p| bound[p]).map(InputOf::Constant));
        of.extend(timed.then_some(InputOf::Time));
        let arguments: Vec<Node> = of
            .iter()
            .map(|of| match of {
                InputOf::Control(k) => graph.input(shape.u() + k),
                InputOf::Constant(p) => graph.parameter(*p),
                InputOf::Time => graph.input(shape.t()),
            })
            .collect();
        let sum = self.weighted(graph, shape);
        let slopes = graph.reverse(&sum, &arguments);
        of.into_iter().zip(slopes).filter(|(_, slope)| !graph.is_zero(*slope)).unzip()
    }

    /// The components of 𝓛_v, 𝓛_q + Q and dΦ/dt with c, d and e.
    fn weighted(&self, graph: &mut Graph, shape: Shape) -> Vec<(Node, Node)> {
        let mut all = Vec::new();
        for (nodes, first) in [(&self.l_v, shape.c()), (&self.force, shape.d()), (&self.phi_dot, shape.e())] {
            all.extend(nodes.iter().enumerate().map(|(i, node)| (*node, graph.input(first + i))));
        }
        all
    }

    /// Their sum of products, and its rate.
    fn along(&self, graph: &mut Graph, shape: Shape) -> [Node; 2] {
        let (x, y): (Vec<Node>, Vec<Node>) = self.weighted(graph, shape).into_iter().unzip();
        let zero = graph.constant(0.0);
        let sum = sum_of_products(graph, &x, &y, zero);
        let moving = shape.moving().enumerate();
        let tangents: Vec<(Node, Node)> =
            moving.map(|(k, which)| (graph.input(which), graph.input(shape.rates() + k))).collect();
        [sum, graph.forward(&[sum], &tangents)[0]]
    }
}

/// Σ x_i y_i + z.
fn sum_of_products(graph: &mut Graph, x: &[Node], y: &[Node], z: Node) -> Node {
    x.iter().zip(y).fold(z, |sum, (x, y)| {
        let product = graph.multiply(*x, *y);
        graph.add(sum, product)
    })
}

/// Whether it is a sum of fixed numbers and of fixed multiples of inputs and of sines and cosines of ±x + fixed, x one input.
fn is_sinusoidal(graph: &Graph, node: Node) -> bool {
    match graph.expression(node) {
        _ if graph.is_fixed(node) => true,
        Expression::Input(_) => true,
        Expression::Add(x, y) | Expression::Subtract(x, y) => is_sinusoidal(graph, x) && is_sinusoidal(graph, y),
        Expression::Multiply(factor, x) => graph.is_fixed(factor) && is_sinusoidal(graph, x),
        Expression::Of(Function::Negative, x) => is_sinusoidal(graph, x),
        Expression::Of(Function::Sin | Function::Cos, angle) => is_angle(graph, angle),
        _ => false,
    }
}

/// Whether it is ±x + fixed, x one input.
fn is_angle(graph: &Graph, node: Node) -> bool {
    match graph.expression(node) {
        Expression::Input(_) => true,
        Expression::Of(Function::Negative, x) => is_angle(graph, x),
        Expression::Add(x, y) | Expression::Subtract(x, y) => {
            graph.is_fixed(x) && is_angle(graph, y) || graph.is_fixed(y) && is_angle(graph, x)
        }
        _ => false,
    }
}
