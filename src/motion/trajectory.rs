//! The motion: y_i at all nodes.

use std::ops::{Deref, DerefMut};

use nalgebra::DMatrix;

use super::column::{column, column_mut};
use super::open::closed;
use super::states::{ColumnsMut, States, rows_of_states};
use crate::number::Real;
use crate::system::{NodeView, Sums};
use crate::{Error, Inputs, Scheme, System};

/// A motion as data: y_i = (v, ṗ*, q, p*, σ)_i at the nodes i = 0 … N, one column each.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory<R = f64> {
    /// Number of computed nodes: N + 1, or fewer if a step failed.
    pub computed: usize,
    /// The states at the nodes, one column each: `motion.q` is short for `motion.nodes.q`, and so on; only the latter can be moved out.
    pub nodes: States<R>,
    /// Compliances of dependent constraints, in the order of the nodes from which they apply; empty if no constraints depend on each other (see
    /// `docs/long-and-hard-motions.md`) and none is open.
    pub compliance: Vec<Compliance>,
    /// Nodes inserted by halved steps.
    pub inserted: Vec<usize>,
    /// The scheme of the motion.
    pub scheme: Scheme,
    /// The states at the inner stages of all steps; empty for the trapezoidal rule. (The last stage of a step is a node.) For a scheme with S
    /// stages, stage s of the step that ends at node i is column i (S − 1) + s − 1; the columns of node 0 are zero.
    pub stages: States<R>,
    /// Nodes with restarts ([`Settings::drift_bound`](crate::Settings::drift_bound)).
    pub restarted: Vec<usize>,
}

/// Names of the numbers of rows and columns of the matrices q, v, p*, ṗ*, σ, u.
const NODES: [[&str; 2]; 6] = [
    ["the trajectory's coordinates", "the trajectory's coordinates: nodes"],
    ["the trajectory's velocities", "the trajectory's velocities: nodes"],
    ["the trajectory's momenta", "the trajectory's momenta: nodes"],
    ["the rates of the trajectory's momenta", "the rates of the trajectory's momenta: nodes"],
    ["the trajectory's multipliers", "the trajectory's multipliers: nodes"],
    ["the trajectory's controls (those of nodes are in the inputs)", "the trajectory's controls: nodes"],
];
const STAGES: [[&str; 2]; 6] = [["the trajectory's stages: rows", "the trajectory's stages: columns"]; 6];

/// Numbers of equations, and their compliances μ.
pub(crate) type Compliances = [(usize, f64)];

/// Compliances of dependent constraints that apply from a node onwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Compliance {
    /// The node from which they apply: the start or a restart.
    pub from: usize,
    /// Numbers of equations, and their μ in dΦ/dt = μ (σ_i − σ_{i−1}), (m/s)/(N s); a large μ means that the equation is left out, and 1e30 that it
    /// is open.
    pub equations: Vec<(usize, f64)>,
}

impl<R: Real> Trajectory<R> {
    /// A trajectory of zeros, to be filled with states computed elsewhere.
    pub fn zeros(system: &System, nodes: usize, scheme: Scheme) -> Self {
        let (n, m) = (system.n(), system.m());
        Trajectory {
            computed: 0,
            nodes: States::zeros(rows_of_states(n, m, 0), nodes),
            compliance: Vec::new(),
            inserted: Vec::new(),
            scheme,
            stages: States::zeros(rows_of_stages(system, &scheme), nodes * scheme.inner()),
            restarted: Vec::new(),
        }
    }

    /// Index of the last computed column; 0 if there is none.
    pub fn last(&self) -> usize {
        self.computed.saturating_sub(1)
    }

    /// Column of a node of the given grid; larger than the node's number if steps before it were halved, and at least `computed` if the
    /// node was not computed or does not exist.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Scheme, Trajectory, scenes::CartPendulum};
    ///
    /// let system = CartPendulum::default().scene().compile()?;
    /// let mut motion = Trajectory::<f64>::zeros(&system, 6, Scheme::TRAPEZOIDAL);
    /// motion.inserted = vec![2, 3]; // the second of three steps was halved, and its first half again
    /// assert_eq!([0, 1, 2, 3].map(|node| motion.column_of(node)), [0, 1, 4, 5]);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn column_of(&self, given_node: usize) -> usize {
        column_of(given_node, &self.inserted)
    }

    /// Number of values per node.
    pub(crate) fn len_of_node(n: usize, m: usize) -> usize {
        1 + rows_of_states(n, m, 0).iter().sum::<usize>()
    }

    /// Resizes to a number of nodes; existing nodes keep their values.
    pub(crate) fn resize(&mut self, nodes: usize) {
        self.nodes.resize(nodes);
        self.stages.resize(nodes * self.scheme.inner());
    }

    /// Stage s of the step that ends in column `k`; the last stage is the node itself.
    #[inline]
    pub(crate) fn stage(&self, k: usize, s: usize) -> NodeView<'_, R> {
        if s > self.scheme.inner() { self.columns(k) } else { self.stages.columns(k * self.scheme.inner() + s - 1) }
    }

    /// Sets the time and the controls of stage s, at the fraction c_s of the step that ends in column `k`; controls are linear between nodes.
    pub(crate) fn place_stage(&mut self, k: usize, s: usize, dt: R, [before, after]: [&[R]; 2]) {
        let (c, at) = (self.scheme.c(s), k * self.scheme.inner() + s - 1);
        self.stages.times[at] = self.times[k - 1] + dt * c;
        let ends = before.iter().zip(after);
        column_mut(&mut self.stages.u, at).iter_mut().zip(ends).for_each(|(u, (&a, &b))| *u = a * (1.0 - c) + b * c);
    }

    /// ẋ = (v, ṗ*) at stage s of the step that ends in column `k`; stage 0 is the previous node.
    #[inline]
    pub(crate) fn rates(&self, k: usize, s: usize) -> (&[R], &[R]) {
        let inner = self.scheme.inner();
        if 0 < s && s <= inner {
            return self.stages.columns(k * inner + s - 1).rates();
        }
        let k = if s == 0 { k - 1 } else { k };
        (column(&self.v, k), column(&self.p_star_dot, k))
    }

    /// Mutable stage s of the step that ends in column `k`.
    #[inline]
    pub(crate) fn stage_mut(&mut self, k: usize, s: usize) -> ColumnsMut<'_, R> {
        if s <= self.scheme.inner() {
            self.stages.columns_mut(k * self.scheme.inner() + s - 1)
        } else {
            self.nodes.columns_mut(k)
        }
    }

    /// The number of the last stage of a step, which is a node.
    pub(crate) fn last_stage(&self) -> usize {
        self.scheme.stages()
    }

    pub(crate) fn at<'a>(&'a self, (inputs, design): (&'a Inputs<R>, &'a [R]), i: usize) -> NodeView<'a, R> {
        self.columns(i).with_inputs((inputs.controls_at(i), design))
    }

    /// True if some constraints depend on each other.
    pub(crate) fn has_dependent(&self) -> bool {
        self.compliance.first().is_some_and(|part| closed(&part.equations).next().is_some())
    }

    /// The compliances of the step that begins at a node.
    pub(crate) fn compliance_from(&self, node: usize) -> &Compliances {
        let count = self.compliance.partition_point(|part| part.from <= node);
        self.compliance[..count].last().map_or(&[], |part| &part.equations)
    }

    /// The compliances of the step that ends at a node; for node 0, those of the start.
    pub(crate) fn compliance_into(&self, node: usize) -> &Compliances {
        self.compliance_from(node.saturating_sub(1))
    }

    /// Checks that the motion reaches the end of its grid.
    pub(crate) fn check_complete(&self, inputs: &Inputs<R>) -> Result<(), Error> {
        let (expected, computed) = (inputs.grid.nodes(), self.computed);
        if expected == computed { Ok(()) } else { Err(Error::Incomplete { expected, computed }) }
    }

    /// Φ(q_i, t_i) in m or rad (m × nodes).
    ///
    /// # Errors
    /// Inputs of wrong size, or numbers beyond the floating-point range.
    pub fn phi(&self, system: &System, inputs: &Inputs<R>) -> Result<DMatrix<R>, Error> {
        self.check_fits(system, inputs)?;
        let design = system.parameters().values(inputs.design.as_slice());
        let mut phi = DMatrix::from_element(system.m(), self.computed, R::zero());
        for i in 0..self.computed {
            system.phi_on(&self.at((inputs, &design), i), column_mut(&mut phi, i));
        }
        finite(system, "Φ", phi)
    }

    /// dΦ/dt(q_i, v_i, t_i) in m/s or rad/s (m × nodes), Eq. (1c).
    ///
    /// # Errors
    /// As [`phi`](Self::phi).
    pub fn phi_dot(&self, system: &System, inputs: &Inputs<R>) -> Result<DMatrix<R>, Error> {
        self.check_fits(system, inputs)?;
        let design = system.parameters().values(inputs.design.as_slice());
        let mut sums = Sums::new(system.n(), system.m());
        let mut phi_dot = DMatrix::from_element(system.m(), self.computed, R::zero());
        for i in 0..self.computed {
            system.plain_sums(&self.at((inputs, &design), i), &mut sums);
            column_mut(&mut phi_dot, i).copy_from_slice(sums.phi_dot());
        }
        finite(system, "dΦ/dt", phi_dot)
    }

    /// Checks that the sizes of the motion fit the system and the inputs.
    pub(crate) fn check_fits(&self, system: &System, inputs: &Inputs<R>) -> Result<(), Error> {
        let (n, m, nodes) = (system.n(), system.m(), self.times.len());
        let restarted = self.restarted.iter().max().map_or(0, |node| node.saturating_add(1));
        let compliant = self.compliance.iter().flat_map(|part| &part.equations).map(|(j, _)| j.saturating_add(1)).max();
        let compliant = compliant.unwrap_or(0);
        let sizes = [
            ("the trajectory's computed nodes", nodes.min(self.computed), self.computed),
            ("time nodes (`Solver::inputs` has those of the motion)", nodes, inputs.grid.nodes()),
            ("controls: rows (channels)", system.k(), inputs.controls.nrows()),
            ("controls: columns (nodes, one more than steps)", nodes, inputs.controls.ncols()),
            ("design variables", system.designs(), inputs.design.len()),
            ("the trajectory's restarted nodes", nodes.min(restarted), restarted),
            ("the trajectory's compliances: equations", m.min(compliant), compliant),
        ];
        let of_nodes = self.nodes.sizes(NODES, rows_of_states(n, m, 0), nodes);
        let of_stages = self.stages.sizes(STAGES, rows_of_stages(system, &self.scheme), nodes * self.scheme.inner());
        match of_nodes.chain(of_stages).chain(sizes).find(|(_, expected, found)| expected != found) {
            Some((what, expected, found)) => Err(Error::Size { what, expected, found }),
            None => Ok(()),
        }
    }

    /// Combines the numbers of this motion with those of another motion on the same grid.
    pub(crate) fn zip_map<A: Real, B: Real>(&self, other: &Trajectory<A>, make: impl Fn(R, A) -> B + Copy) -> Trajectory<B> {
        Trajectory {
            computed: self.computed,
            nodes: self.nodes.zip_map(&other.nodes, make),
            compliance: self.compliance.clone(),
            inserted: self.inserted.clone(),
            scheme: self.scheme,
            stages: self.stages.zip_map(&other.stages, make),
            restarted: self.restarted.clone(),
        }
    }
}

impl<R> Deref for Trajectory<R> {
    type Target = States<R>;

    #[inline]
    fn deref(&self) -> &States<R> {
        &self.nodes
    }
}

impl<R> DerefMut for Trajectory<R> {
    #[inline]
    fn deref_mut(&mut self) -> &mut States<R> {
        &mut self.nodes
    }
}

/// The column of a node of the given grid, with these nodes inserted.
pub(super) fn column_of(given_node: usize, inserted: &[usize]) -> usize {
    let is_before = |(before, inserted): &(usize, &usize)| **inserted <= given_node.saturating_add(*before);
    given_node.saturating_add(inserted.iter().enumerate().take_while(is_before).count())
}

/// Numbers of rows of the states at stages; the trapezoidal rule has none.
fn rows_of_stages(system: &System, scheme: &Scheme) -> [usize; 6] {
    if scheme.inner() > 0 { rows_of_states(system.n(), system.m(), system.k()) } else { [0; 6] }
}

/// Values of all equations at all nodes; an error if one of them is not finite.
fn finite<R: Real>(system: &System, what: &str, values: DMatrix<R>) -> Result<DMatrix<R>, Error> {
    let value = |at: usize| values.as_slice()[at].part(0);
    match (0..values.len()).find(|&at| !value(at).is_finite()) {
        Some(at) => {
            let (node, equation) = (at / values.nrows(), system.equation_name(at % values.nrows()));
            Err(Error::Overflow { what: format!("{what} of {equation} at node {node}"), value: value(at) })
        }
        None => Ok(values),
    }
}
