//! [`Formula`]: the properties of a recorded formula and the programs compiled from it, shared by all elements with this formula.
//!
//! With T_x the derivative with respect to x, and with sums over all equations:
//!
//! ```text
//!   kinetic    𝓛_v = T_v,     𝓛_q = T_q                  applied     Q
//!   potential  𝓛_q = −V_q                                constraint  𝓛_v = Φ_qᵀσ,  𝓛_q = (dΦ/dt)_qᵀσ,  dΦ/dt = Φ_q v + Φ_t
//! ```
//!
//! First derivatives are computed in reverse mode, second derivatives by differentiating these in forward mode.

use super::block::{Block, BlockEntry};
use super::derivatives::Derivatives;
use super::difference::RelativeEntry;
use super::kind::ElementKind;
use super::kink_formula::KinkFormula;
use super::labelled::Labelled;
use super::shape::{Shape, Slot};
use crate::program::{Expression, Function, Graph, Kernel, Node, Obstacle, Template};

/// A component of 𝓛_v, of 𝓛_q + Q or of dΦ/dt, numbered within the element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    Momentum(usize),
    Force(usize),
    Equation(usize),
}

impl Component {
    /// The index of the component in the sums 𝓛_v (n), 𝓛_q + Q (n) and dΦ/dt of a scene.
    #[inline]
    pub fn place(self, (q, sigma): (&[usize], &[usize]), n: usize) -> usize {
        match self {
            Component::Momentum(i) => q[i],
            Component::Force(i) => n + q[i],
            Component::Equation(j) => 2 * n + sigma[j],
        }
    }
}

/// The programs compiled from a formula that has a graph.
#[derive(Clone, Debug)]
pub struct Kernels {
    pub template: Template,
    /// Evaluated at a state: first 𝓛_v, 𝓛_q + Q and dΦ/dt (for a constraint, without its linear columns), then the varying entries.
    pub state: Kernel,
    /// The component of each result of the first stage, and the components whose negatives the first results are.
    pub components: Vec<Component>,
    pub negatives: Vec<Component>,
    /// Constant entries.
    pub fixed: Kernel,
    /// 𝓛_v, 𝓛_q + Q, and Q_u by rows, for an element that is constant.
    pub at_zero: Kernel,
    /// The derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to controls, constants and time.
    pub inputs: Labelled<Slot>,
    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate.
    pub along: Kernel,
    /// `None` if the formula has no kinks.
    pub kinks: Option<KinkFormula>,
}

impl Kernels {
    /// The stage of `state` that computes the varying entries.
    pub const SECOND: usize = 1;

    /// The components and the varying entries for one element; slow.
    pub fn at_state(&self, parameters: &[f64], input: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let mut components = self.state.evaluate(parameters, input);
        let entries = components.split_off(self.components.len());
        (components, entries)
    }
}

/// Properties of a formula.
#[derive(Clone, Debug)]
pub struct Formula {
    pub kind: ElementKind,
    pub shape: Shape,
    /// The reason why the formula has no graph, unless programs were disabled.
    pub obstacle: Option<Obstacle>,
    /// All second derivatives are constant, and nothing depends on time or is piecewise.
    pub constant: bool,
    /// First derivatives depend on signs or comparisons that do not show in second derivatives, as for |x| or max(x, y).
    pub piecewise: bool,
    /// A constraint that is a sum of multiples of q_i, sin q_i and cos q_i.
    pub sinusoidal: bool,
    pub timed: bool,
    /// An energy that may be undefined at points where its derivatives are defined, such as ln q for q < 0.
    pub partly_defined: bool,
    /// Second derivatives that vary along a motion, and those that are constant.
    pub varying: Vec<RelativeEntry>,
    pub fixed: Vec<BlockEntry>,
    /// `None` if the formula has no graph; all derivatives are then assumed to vary.
    pub kernels: Option<Kernels>,
}

impl Formula {
    /// A formula without a graph, which num-dual evaluates at every point.
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

    /// Differentiates a recorded formula; `bound` marks the constants that are design variables.
    pub fn new(kind: ElementKind, shape: Shape, template: Template, bound: &[bool]) -> Self {
        Formula::compile(kind, shape, template, bound)
            .unwrap_or_else(|| Formula::unknown(kind, shape, Some(Obstacle::IsTooLong)))
    }

    fn compile(kind: ElementKind, shape: Shape, template: Template, bound: &[bool]) -> Option<Self> {
        let (mut graph, derivatives) = Derivatives::new(kind, shape, &template);
        let (timed, parameters) = (template.depends(shape.c())[shape.number(Slot::T)], template.parameters);
        let partly_defined = is_energy(kind) && graph.is_partly_defined(&derivatives.values, 2 * shape.n);
        let controls = derivatives.by_controls(&mut graph);
        let linear_in_controls = controls.iter().all(|slope| graph.is_fixed(*slope));
        let all_fixed = derivatives.entries.iter().all(|(_, node)| graph.is_fixed(*node));
        let sums = [&derivatives.l_v, &derivatives.force, &derivatives.phi_dot].into_iter().flatten();
        let piecewise = graph.is_piecewise(sums.copied());
        let constant = all_fixed && !timed && !piecewise && (linear_in_controls || shape.k == 0);
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
        let by_inputs = derivatives.by_inputs(&mut graph, (bound, timed, !constant));
        let along = derivatives.along(&mut graph);
        let at_zero: Vec<Node> = derivatives.l_v.iter().chain(&derivatives.force).chain(&controls).copied().collect();
        let state = Kernel::in_stages(&mut graph, parameters, &[&first, &second])?;
        let inputs = Labelled::new(&mut graph, parameters, by_inputs)?;
        let mut kernel = |results: &[Node]| Kernel::new(&mut graph, parameters, results);
        let kernels = Kernels {
            state,
            components,
            negatives,
            fixed: kernel(&fixed_nodes)?,
            at_zero: kernel(&at_zero)?,
            inputs,
            along: kernel(&along)?,
            kinks: KinkFormula::new(kind, &template, shape, bound),
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

    /// True if derivatives may vary within a step in another way than as sines and cosines of angles; the change of those angles is checked
    /// separately.
    pub fn may_bend(&self) -> bool {
        self.timed || !self.constant && !self.sinusoidal
    }

    /// Whether the formula is evaluated at every iteration.
    pub fn is_varying(&self) -> bool {
        !self.constant && !self.sinusoidal
    }
}

fn is_energy(kind: ElementKind) -> bool {
    matches!(kind, ElementKind::Kinetic | ElementKind::Potential)
}

/// True if every node is a sum of fixed numbers and of fixed multiples of inputs and of sines and cosines of ±x + fixed, where x is one input.
fn are_sinusoidal(graph: &Graph, nodes: &[Node]) -> bool {
    // Two flags per node: it is such a sum; it is ±x + fixed. Arguments precede their users, so no recursion is needed for long sums.
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
