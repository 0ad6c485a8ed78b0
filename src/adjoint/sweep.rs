//! The backward sweep: the exact discrete adjoint of the step equations, and the gradient (Eq. 5–12).
//!
//! The Lagrangian Σ ℓ_i + Σ (aᵀE1 + bᵀE2 + cᵀE3 + dᵀE4 + eᵀE5)_i is stationary in all y_i. With half steps h before the node and h₊ after it (0 at
//! the end), J_x the cost's partial derivatives at the node, and a₊, b₊ of the next node:
//!
//! ```text
//!   ∂p*:  c = b − b₊ + J_p*                      ∂ṗ*:  d = −h b − h₊ b₊ + J_ṗ*
//!   ∂σ :  Φ_q c + (dΦ/dt)_q d + J_σ = 0
//!   ∂v :  −h a − h₊ a₊ + 𝓛_vvᵀ c + (𝓛_qv + Q_v)ᵀ d + Φ_qᵀ e + J_v = 0
//!   ∂q :  a − a₊ + 𝓛_vqᵀ c + (𝓛_qq + Q_q)ᵀ d + (dΦ/dt)_qᵀ e + J_q = 0
//! ```
//!
//! With other schemes A, B, α, β (`scheme/parts.rs`) replace a₊, b₊, h₊ a₊, h₊ b₊; [`stage`](super::stage) solves each stage.

use nalgebra::DMatrix;

use crate::adjoint::accuracy::Accuracy;
use crate::adjoint::cost_node::CostNode;
use crate::adjoint::growth::Growth;
use crate::adjoint::record::Record;
use crate::adjoint::resolution::Resolution;
use crate::adjoint::{AdjointVariables, Gradient};
use crate::event::{AfterRows, EarlierSigma};
use crate::linear::Breakdown;
use crate::motion::{Motion, Refinement, Report, StepEnd, column_mut};
use crate::node::Linearisation;
use crate::number::{add, add_dot, all_finite, total};
use crate::scheme::{Carried, StageAdjoint};
use crate::system::{CostRows, Covector, InputRows, NodeView, Pair, StateRows};
use crate::{Error, Scheme, Settings, Start, System};

/// The backward sweep and its workspace.
pub(crate) struct AdjointSweep {
    pub(crate) gradient: Gradient,
    pub(crate) report: Report,
    pub(super) variables: Option<AdjointVariables>,
    /// The adjoint variables of all stages, for second derivatives; true if they belong to the current motion and factors.
    pub(super) record: Option<Record>,
    pub(crate) is_recorded: bool,
    /// The stages of the current step, the last of which is the node, and the current stage.
    pub(crate) step: Vec<StageAdjoint>,
    pub(crate) stage: usize,
    /// Contributions of later stages to the current one.
    pub(crate) carried: Carried,
    /// True while nothing is carried, because no cost depends on later nodes.
    pub(super) is_idle: bool,
    pub(crate) cost: CostRows,
    pub(crate) cost_is_zero: bool,
    pub(crate) rows: StateRows,
    /// The right-hand side of the adjoint equations, overwritten by the solution (c, e); in the solver's order.
    pub(crate) right: Vec<f64>,
    /// (c, e) before its refinement.
    pub(super) solution: Vec<f64>,
    pub(super) cost_node: CostNode,
    pub(crate) zeros: Pair,
    /// For events: the derivatives behind them, their own adjoint variables, and their contribution to J_σ of an earlier node.
    pub(super) after: AfterRows,
    pub(super) own: Pair,
    pub(super) earlier: EarlierSigma,
    /// The node whose costs were evaluated before the sweep arrived there.
    pub(super) costs_known: Option<usize>,
    /// A node, and the derivatives of a function of its state to be added there.
    pub(super) source: Option<(usize, Box<CostRows>)>,
    pub(super) growth: Growth,
    pub(super) accuracy: Accuracy,
    /// dJ/du of the current node or stage.
    pub(crate) u: Vec<f64>,
    /// Sum of the explicit derivatives with respect to t over the nodes visited so far.
    pub(crate) time: f64,
    /// dJ/dz for the values z of the parameters.
    pub(super) design: Vec<f64>,
    pub(crate) resolution: Resolution,
    pub(crate) refinement: Refinement,
}

impl AdjointSweep {
    pub(crate) fn new(system: &System, scheme: Scheme) -> Self {
        let (n, m) = (system.n(), system.m());
        let zeros = |len| vec![0.0; len];
        let stage = StageAdjoint { a: zeros(n), b: zeros(n), c: zeros(n), d: zeros(n), e: zeros(m) };
        AdjointSweep {
            gradient: Gradient::empty(system),
            report: Report::default(),
            variables: None,
            record: None,
            is_recorded: false,
            step: vec![stage; scheme.stages()],
            stage: scheme.inner(),
            carried: Carried::new(n, m),
            is_idle: false,
            cost: CostRows::new((n, m, system.k()), system.parameters().len(), system.outputs()),
            design: vec![0.0; system.parameters().len()],
            rows: StateRows::new(n, m),
            cost_is_zero: true,
            right: zeros(n + m),
            solution: zeros(n + m),
            zeros: Pair::new(n, m),
            cost_node: CostNode::new(system),
            after: AfterRows { p_star: zeros(n), sigma: zeros(m) },
            own: Pair::new(n, m),
            earlier: EarlierSigma { node: None, rows: zeros(m) },
            costs_known: None,
            source: None,
            growth: Growth::default(),
            accuracy: Accuracy::default(),
            u: zeros(system.k()),
            time: 0.0,
            resolution: Resolution::new(system),
            refinement: Refinement::default(),
        }
    }

    /// Discards the results for another motion, and selects J as the function to be differentiated.
    pub(crate) fn forget(&mut self) {
        self.variables = None;
        self.is_recorded = false;
        self.cost.factors.choose(0);
    }

    pub(crate) fn variables(&self) -> Option<&AdjointVariables> {
        self.variables.as_ref()
    }

    /// Collects warnings, and returns an error if a sum has overflowed.
    pub(crate) fn finish(&mut self, system: &System, forward: &Report) -> Result<(), Error> {
        self.growth.tell(&mut self.report);
        self.resolution.tell(system, &mut self.report);
        self.gradient.warnings.clear();
        self.gradient.warnings.extend(forward.warnings.iter().chain(&self.report.warnings).cloned());
        self.gradient.check_finite(system, self.refinement.node_of_whole(0))
    }

    /// Sets the adjoint variables of a stage to zero.
    pub(super) fn clear_stage(&mut self, s: usize) {
        self.stage = s - 1;
        self.step[self.stage].clear();
    }

    /// Adds the contribution of a later event to the multipliers of this node.
    pub(super) fn take_earlier_sigma(&mut self, node: usize) {
        if self.earlier.node != Some(node) {
            return;
        }
        self.earlier.node = None;
        let terms = self.cost.sigma.iter_mut().zip(&mut self.earlier.rows);
        terms.for_each(|(sum, carried)| *sum += std::mem::take(carried));
        self.cost_is_zero = false;
    }

    /// Adds the derivatives with respect to the inputs of a stage at the fraction c of the step that ends at a node.
    pub(super) fn add_inner_inputs(&mut self, node: usize, c: f64) {
        // Controls are linear between nodes.
        self.refinement.add_controls(node - 1, 1.0 - c, &self.u, &mut self.gradient.controls);
        self.refinement.add_controls(node, c, &self.u, &mut self.gradient.controls);
        // A longer step shifts the stage by the fraction c of the change, and all later nodes by the whole change.
        self.refinement.add_step(node, (c - 1.0) * self.time, &mut self.gradient.steps);
    }

    /// Makes room for the gradient of J with respect to the given inputs and sets it to zero.
    ///
    /// # Errors
    /// The quantities on which a cost depends have changed.
    pub(crate) fn begin(&mut self, system: &System, motion: &Motion, settings: &Settings) -> Result<(), Error> {
        let inputs = &motion.inputs;
        let state = [inputs.start.q().as_slice(), &self.zeros.v, &self.zeros.sigma];
        let at = NodeView::of_equations(state, (&self.u, 0.0, &motion.design));
        system.fix_costs(&at, 1, &mut self.cost_node.programs)?;
        self.refinement = motion.refinement();
        self.earlier.rows.fill(0.0);
        self.earlier.node = None;
        self.costs_known = None;
        self.growth.begin(motion);
        self.cost_node.begin();
        self.accuracy = Accuracy::default();
        self.resolution.begin();
        let nodes = inputs.grid.nodes() - motion.trajectory.inserted.len();
        let gradient = &mut self.gradient;
        if gradient.controls.ncols() != nodes {
            gradient.controls = DMatrix::zeros(system.k(), nodes);
        }
        gradient.controls.fill(0.0);
        gradient.steps.clear();
        gradient.steps.resize(nodes - 1, 0.0);
        if std::mem::discriminant(&gradient.start) != std::mem::discriminant(&inputs.start) {
            gradient.start = inputs.start.clone();
        }
        gradient.value = 0.0;
        gradient.frozen = None;
        self.is_recorded = false;
        if let Some(record) = &mut self.record {
            record.fit(system, motion.blocks.ncols());
        }
        self.cost.factors.choose(0);
        self.design.fill(0.0);
        self.report = Report::default();
        self.time = 0.0;
        self.carried.clear();
        self.is_idle = true;
        self.variables = settings.keep_adjoint.then(|| AdjointVariables::zeros(system, inputs.grid.nodes()));
        Ok(())
    }

    pub(super) fn singular(&self, system: &System, motion: &Motion, node: usize, breakdown: &Breakdown) -> Error {
        system.singular_step(breakdown, self.refinement.step_of_whole(node), motion.at(node).t)
    }

    /// Adds the derivatives with respect to u, the design variables and the time of the current node.
    pub(super) fn input_rows<'a>(
        &mut self,
        system: &System,
        linearisation: &mut Linearisation,
        at: impl Fn() -> NodeView<'a, f64>,
        node: usize,
    ) -> Result<(), Error> {
        let StageAdjoint { c, d, e, .. } = &self.step[self.stage];
        linearisation.evaluation.constants.pull_back_controls(d, &mut self.u);
        let with = Covector { c, d, e };
        let evaluations = &mut self.report.input_evaluations;
        let mut rows = InputRows { u: &mut self.u, design: &mut self.design, time: &mut self.time, evaluations };
        if system.formulas().assembly.has_input_derivatives() {
            linearisation.evaluation.pull_back_inputs(system, &at(), &with, &mut rows);
        }
        if node == 0 {
            // The start time is not an input: √t may begin at t = 0.
            self.time = 0.0;
        }
        if all_finite(&self.u) && all_finite(&self.design) && self.time.is_finite() {
            return Ok(());
        }
        // Overflowed sums are reported at the end.
        system.find_bad_input(&at(), self.refinement.node_of_whole(node)).map_or(Ok(()), Err)
    }

    /// dJ/dΔt_i = −Σ_s Σ_j a_sj (a_sᵀ v_j + b_sᵀ ṗ*_j) + explicit time of this and all later nodes.
    pub(super) fn step_row(&mut self, motion: &Motion, end: Option<&StepEnd>, i: usize) {
        let (trajectory, k) = (&motion.trajectory, i - motion.first);
        let (scheme, last) = (&trajectory.scheme, trajectory.last_stage());
        let rates = |j: usize| match (j, end) {
            (j, Some(end)) if j == last => (end.v, end.p_star_dot),
            (j, _) => trajectory.rates(k, j),
        };
        let mut own = [0.0; 4];
        for (stage, row) in self.step.iter().zip(scheme.rows) {
            // Two rates at a time; if their number is odd, the last one is paired with itself.
            for (pair, weights) in row.chunks(2).enumerate() {
                let (first, second) = (weights[0], weights.get(1).copied().unwrap_or(0.0));
                let ((v, rate), (next_v, next_rate)) = (rates(2 * pair), rates(2 * pair + weights.len() - 1));
                add_dot(&stage.a, (first, v), (second, next_v), &mut own);
                add_dot(&stage.b, (first, rate), (second, next_rate), &mut own);
            }
        }
        self.refinement.add_step(i, self.time - total(own), &mut self.gradient.steps);
    }

    /// Stores the adjoint variables of node `i`, if requested.
    pub(super) fn store(&mut self, i: usize) {
        let Some(variables) = &mut self.variables else { return };
        let (node, carried, cost) = (&self.step[self.stage], &self.carried, &self.cost);
        // a₀ is used for dJ/dq₀ but is not an adjoint variable, because node 0 has no E1.
        column_mut(&mut variables.b, i).copy_from_slice(&node.b);
        column_mut(&mut variables.c, i).copy_from_slice(&node.c);
        column_mut(&mut variables.d, i).copy_from_slice(&node.d);
        column_mut(&mut variables.e, i).copy_from_slice(&node.e);
        column_mut(&mut variables.s, i).copy_from_slice(&self.earlier.rows);

        let n = node.a.len();
        let (first, rest) = column_mut(&mut variables.w, i).split_at_mut(2 * n);
        for k in 0..n {
            let at_start = (node.a[k], node.b[k]);
            let (alpha, beta) = carried.alpha_and_beta(k);
            let inside = (alpha - cost.v[k], beta - cost.p_star_dot[k]);
            (first[k], first[n + k]) = if i > 0 { inside } else { at_start };
        }
        rest[..n].copy_from_slice(&node.c);
        rest[n..2 * n].copy_from_slice(&node.d);
        rest[2 * n..].copy_from_slice(&node.e);
    }

    /// dJ/dp*₀ = J_p* − c₀ − b₁ and dJ/dq₀ = J_q − a₁ + 𝓛_vqᵀ c₀ + …; then from p*₀ = T_v(q₀, v₀; b) to v₀, q₀ and b.
    pub(super) fn start_rows(&mut self, system: &System, motion: &Motion, linearisation: &mut Linearisation) {
        // At node 0, a is a₁ − 𝓛_vqᵀ c₀ − … − J_q and b is c₀ + b₁ − J_p*.
        let StageAdjoint { a, b, .. } = &self.step[self.stage];
        self.gradient.start.q_mut().iter_mut().zip(a).for_each(|(q, a)| *q = -a);
        self.gradient.start.rate_mut().iter_mut().zip(b).for_each(|(p, b)| *p = -b);
        if let Start::Velocity { q, v } = &mut self.gradient.start {
            let with = Covector { c: v.as_slice(), d: &self.zeros.v, e: &self.zeros.sigma };
            let (at, blocks) = motion.given_start();
            linearisation.evaluation.pull_back(system, blocks, &with, &mut self.rows);
            let (mut u, mut time) = (vec![0.0; system.k()], 0.0);
            let (design, evaluations) = (self.design.as_mut_slice(), &mut self.report.input_evaluations);
            let mut rows = InputRows { u: &mut u, design, time: &mut time, evaluations };
            linearisation.evaluation.pull_back_inputs(system, &at, &with, &mut rows);
            v.copy_from_slice(&self.rows.v);
            add(q.as_mut_slice(), &self.rows.q);
        }
    }
}
