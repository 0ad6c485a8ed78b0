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
use super::derivatives::Derivatives;
use super::difference::RelativeEntry;
use super::jet::ElementKind;
use super::shape::Shape;
use super::typed::Slot;
use crate::program::{Expression, Function, Graph, Kernel, Node, Obstacle, Template};

/// A component of 𝓛_v, of 𝓛_q + Q or of dΦ/dt, by the element's own number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    Momentum(usize),
    Force(usize),
    Equation(usize),
}

impl Component {
    /// Where it is summed among 𝓛_v (n), 𝓛_q + Q (n) and dΦ/dt of a scene.
    #[inline]
    pub fn place(self, (q, sigma): (&[usize], &[usize]), n: usize) -> usize {
        match self {
            Component::Momentum(i) => q[i],
            Component::Force(i) => n + q[i],
            Component::Equation(j) => 2 * n + sigma[j],
        }
    }
}

/// The graph of a formula that could be recorded, and the programs made of it.
#[derive(Clone, Debug)]
pub struct Kernels {
    pub template: Template,
    /// At a state: first 𝓛_v, 𝓛_q + Q and dΦ/dt, of a constraint without its linear columns, then the entries that vary.
    pub state: Kernel,
    /// Which component each result of the first stage is, and of which ones the first results are the negatives.
    pub components: Vec<Component>,
    pub negatives: Vec<Component>,
    /// The entries that are constant.
    pub fixed: Kernel,
    /// 𝓛_v and 𝓛_q + Q, and Q_u by rows, of an element that is constant.
    pub at_zero: Kernel,
    /// The derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to controls, constants and time, and with respect to which.
    pub inputs: Kernel,
    pub inputs_of: Vec<Slot>,
    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate.
    pub along: Kernel,
}

impl Kernels {
    /// The stage of `state` after the first one.
    pub const SECOND: usize = 1;

    /// The components and the entries that vary; slow.
    pub fn at_state(&self, parameters: &[f64], input: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let mut components = self.state.evaluate(parameters, input);
        let entries = components.split_off(self.components.len());
        (components, entries)
    }
}

/// What is known of a formula.
#[derive(Clone, Debug)]
pub struct Formula {
    pub kind: ElementKind,
    pub shape: Shape,
    /// Why it has no graph, unless none was asked for.
    pub obstacle: Option<Obstacle>,
    /// All second derivatives are constant, and nothing depends on time or is piecewise.
    pub constant: bool,
    /// First derivatives depend on signs or comparisons, of which second ones show nothing: those of |x| or max(x, y).
    pub piecewise: bool,
    /// A constraint that is a sum of q_i, sin q_i, cos q_i.
    pub sinusoidal: bool,
    pub timed: bool,
    /// An energy that may be undefined where its derivatives are not, as ln q for q < 0.
    pub partly_defined: bool,
    /// Second derivatives that vary along a motion, and those that do not.
    pub varying: Vec<RelativeEntry>,
    pub fixed: Vec<BlockEntry>,
    /// None without a graph: then everything is taken to vary.
    pub kernels: Option<Kernels>,
}

impl Formula {
    /// Of a formula that has no graph: num-dual evaluates it at every point.
    pub fn unknown(kind: ElementKind, shape: Shape, obstacle: Option<Obstacle>) -> Self {
        Formula {
            kind,
            shape,
            obstacle,
            constant: false,
            piecewise: false,
            sinusoidal: false,
            timed: true,
            partly_defined: is_energy(kind),
            varying: BlockEntry::all(kind, shape.n, shape.m).into_iter().map(RelativeEntry::from).collect(),
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
        let (mut graph, derivatives) = Derivatives::new(kind, shape, &template);
        let depends = template.depends(shape.sigma());
        let (timed, parameters) = (depends[shape.t()], template.parameters);
        let partly_defined = is_energy(kind) && graph.is_partly_defined(&derivatives.values, shape.u());
        let is_control = |i: usize| (shape.u()..shape.t()).contains(&i);
        let controls = derivatives.by_controls(&mut graph);
        let linear_in_controls = controls.iter().all(|slope| graph.is_fixed(*slope));
        let all_fixed = derivatives.entries.iter().all(|(_, node)| graph.is_fixed(*node));
        let sums = [&derivatives.l_v, &derivatives.force, &derivatives.phi_dot].into_iter().flatten();
        let piecewise = graph.is_piecewise(sums.copied());
        let is_free = !(0..depends.len()).any(is_control);
        let constant = all_fixed && !timed && !piecewise && (linear_in_controls || is_free);
        let is_sum = kind == ElementKind::Holonomic && are_sinusoidal(&graph, &derivatives.values);
        let sinusoidal = is_sum && !timed && !constant;

        let is_linear = derivatives.linear_columns(&graph);
        let is_constant = |(entry, node): &(BlockEntry, Node)| match kind {
            ElementKind::Holonomic => entry.block == Block::PhiQ && is_linear[entry.col] && graph.is_fixed(*node),
            _ => constant,
        };
        let (fixed, varying): (Vec<(BlockEntry, Node)>, Vec<_>) = derivatives.entries.iter().copied().partition(is_constant);
        let differences = derivatives.differences(&graph);
        let (varying, second) = differences.entries(varying);
        let (components, first) = derivatives.without_linear_columns(&mut graph, &is_linear);
        let (components, negatives, first) = differences.components(&components, &first);
        let (fixed, fixed_nodes): (Vec<BlockEntry>, Vec<Node>) = fixed.into_iter().unzip();
        let (inputs_of, by_inputs) = derivatives.by_inputs(&mut graph, (bound, timed, !constant));
        let along = derivatives.along(&mut graph);
        let at_zero: Vec<Node> = derivatives.l_v.iter().chain(&derivatives.force).chain(&controls).copied().collect();
        let state = Kernel::in_stages(&mut graph, parameters, &[&first, &second])?;
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, parameters, results);
        let kernels = Kernels {
            state,
            components,
            negatives,
            fixed: kernel(&fixed_nodes)?,
            at_zero: kernel(&at_zero)?,
            inputs: kernel(&by_inputs)?,
            inputs_of,
            along: kernel(&along)?,
            template,
        };
        Some(Formula {
            kind,
            shape,
            obstacle: None,
            constant,
            piecewise,
            sinusoidal,
            timed,
            partly_defined,
            varying,
            fixed,
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

fn is_energy(kind: ElementKind) -> bool {
    matches!(kind, ElementKind::Kinetic | ElementKind::Potential)
}

/// True if every node is a sum of fixed numbers and of fixed multiples of inputs and of sines and cosines of ±x + fixed, x being one input.
fn are_sinusoidal(graph: &Graph, nodes: &[Node]) -> bool {
    // For every node: is it such a sum, and is it ±x + fixed. Arguments come first, so that no recursion grows with the length of a sum.
    let mut known = vec![[false; 2]; graph.len()];
    for node in graph.reachable(nodes.iter().copied()) {
        let (is_fixed, of) = (|x: Node| graph.is_fixed(x), |x: Node| known[x.index()]);
        known[node.index()] = match graph.expression(node) {
            _ if is_fixed(node) => [true, false],
            Expression::Input(_) => [true; 2],
            Expression::Add(x, y) | Expression::Subtract(x, y) => {
                [of(x)[0] && of(y)[0], is_fixed(x) && of(y)[1] || is_fixed(y) && of(x)[1]]
            }
            Expression::Multiply(factor, x) => [is_fixed(factor) && of(x)[0], false],
            Expression::Of(Function::Negative, x) => of(x),
            Expression::Of(Function::Sin | Function::Cos, angle) => [of(angle)[1], false],
            _ => [false; 2],
        };
    }
    nodes.iter().all(|node| known[node.index()][0])
}
