//! The equations of a step in real numbers: linear terms, sinusoidal terms, and terms evaluated by programs or dual numbers.
//!
//! With x = (v, σ) in the solver's order, the residual of a step is r(x) = k + L x + N(x): k and the sparse matrix L
//! are known when the step begins, and only N and its derivative N′ are evaluated at every iteration.

use super::linear_part::LinearPart;
use crate::linear::{Breakdown, Factorization, Matrix};
use crate::motion::{Compliances, Report};
use crate::number::by_fours;
use crate::system::{
    Constants, CostRows, Covector, Entries, Formulas, Given, InputRows, KnownPart, NodeView, Pair, PositionConstraints, Row,
    Sines, StateRows, Sums, Variable, Wanted, Within, Workspace, all, of_force, row_q,
};
use crate::{Error, System};

/// All elements of a system for one set of design variables, and their derivatives at the last evaluated point.
pub(crate) struct Evaluation {
    pub(crate) constants: Constants,
    sines: Sines,
    /// The parts of N′: states of the angles, then second derivatives of the other elements.
    pub(crate) blocks: Vec<f64>,
    linear: LinearPart,
    /// The formulas and the design variables for which the constants were computed.
    fingerprint: Option<u64>,
    design: Vec<f64>,
    /// The formulas, if they differ from the compiled ones.
    formulas: Option<Formulas>,
    workspace: Workspace,
    elements: Option<Elements>,
    /// Present in motions that evaluate Φ.
    positions: Option<PositionConstraints>,
}

/// Workspace for elements that are evaluated at every point: their point and sums in the scene's order.
struct Elements {
    q: Vec<f64>,
    x: Pair,
    sums: Sums<f64>,
    rows: StateRows,
}

impl Evaluation {
    pub(crate) fn new(system: &System) -> Self {
        let (n, m) = (system.n(), system.m());
        let elements =
            || Elements { q: vec![0.0; n], x: Pair::new(n, m), sums: Sums::new(n, m), rows: StateRows::new(n, m) };
        Evaluation {
            constants: Constants::new(n),
            sines: system.sines().clone(),
            blocks: vec![0.0; system.block_len()],
            linear: LinearPart::default(),
            fingerprint: None,
            design: Vec::new(),
            formulas: None,
            workspace: system.formulas().assembly.workspace(),
            elements: (!system.formulas().assembly.is_empty()).then(elements),
            positions: None,
        }
    }

    /// Sets the design variables of a start and the current formulas.
    pub(crate) fn set_start(&mut self, system: &System, start: &NodeView<f64>) -> Result<(), Error> {
        let fingerprint = system.fingerprint();
        if self.fingerprint == Some(fingerprint) && self.design == start.design {
            return Ok(());
        }
        self.fingerprint = None;
        let own = system.formulas_now(start, fingerprint)?;
        if own.is_some() || self.formulas.is_some() {
            self.workspace = own.as_ref().unwrap_or(system.formulas()).assembly.workspace();
            self.formulas = own;
            self.positions = None;
        }
        let formulas = self.formulas.as_ref().unwrap_or(system.formulas());
        formulas.set_design(start.design, &mut self.constants, &mut self.workspace);
        if let Some(positions) = &mut self.positions {
            positions.fix(&formulas.elements, start.design, &self.constants);
        }
        self.sines.set_coefficients(&mut self.constants.waves);
        self.linear.set(system, &self.constants);
        self.design.clear();
        self.design.extend_from_slice(start.design);
        // Constants that are not finite at this start may be finite at the next one.
        self.fingerprint = self.constants.are_finite().then_some(fingerprint);
        Ok(())
    }

    /// Fingerprint of the evaluated formulas.
    pub(crate) fn fingerprint(&self) -> Option<u64> {
        self.fingerprint
    }

    /// The evaluated formulas.
    pub(crate) fn formulas<'a>(&'a self, system: &'a System) -> &'a Formulas {
        self.formulas.as_ref().unwrap_or(system.formulas())
    }

    /// Sets the compliances of constraint equations.
    pub(crate) fn set_compliance(&mut self, compliance: &Compliances) {
        self.linear.set_compliance(compliance);
    }

    /// Sets the additional inertia of coordinates, for factors that serve as a preconditioner.
    pub(crate) fn set_inertia(&mut self, inertia: &[(usize, f64)]) {
        self.linear.set_inertia(inertia);
    }

    /// Equations with a compliance, and their μ.
    pub(crate) fn compliance(&self) -> &Compliances {
        self.linear.compliance()
    }

    /// Selects or computes the matrix L for the half step h.
    pub(crate) fn set_step<F: Factorization>(
        &mut self,
        system: &System,
        h: f64,
        matrix: &mut Matrix<F>,
    ) -> Result<(), Breakdown> {
        self.linear.select(system, h, matrix)
    }

    /// True if elements other than sums of sines are evaluated at every point; only these may have terms in the rows of condensed unknowns.
    pub(crate) fn has_elements(&self) -> bool {
        self.elements.is_some()
    }

    /// Begins a step.
    pub(crate) fn begin(&mut self) {
        self.sines.forget();
    }

    /// Writes −k of r(x) = k + L x + N(x), in the solver's order.
    pub(crate) fn step_constants(&self, system: &System, from: &KnownPart, given: Given, r: &mut [f64]) {
        self.constants.step_constants(from, given, system.positions(), r);
        for &(j, mu) in self.linear.compliance() {
            r[system.positions().sigma[j]] -= mu * from.sigma[j];
        }
    }

    /// r −= N(x), with the parts of N′ that are computed along with N; [`second`](Self::second) computes the others.
    pub(crate) fn subtract_nonlinear(
        &mut self,
        system: &System,
        from: &KnownPart,
        given: Given,
        x: &[f64],
        r: &mut [f64],
        report: &mut Report,
    ) {
        let (angles, rest) = self.blocks.split_at_mut(self.sines.block_len());
        self.sines.subtract_residual(from.q, from.h, x, r, angles);
        report.sine_evaluations += self.sines.angles();
        let Some(elements) = &mut self.elements else { return };
        elements.load(system, from, x);
        let Elements { q, x, sums, .. } = elements;
        sums.clear();
        let at = given.at(q, &x.v, &x.sigma);
        let formulas = self.formulas.as_ref().unwrap_or(system.formulas());
        formulas.first(system.batches(), &at, &mut self.workspace, (sums, rest));
        report.element_evaluations += formulas.assembly.elements();
        // Of the sums only 𝓛_q + Q is needed later.
        let [l_v, force, phi_dot] = sums.parts_mut();
        // Not 0 · Q, which may be NaN: at h = 0 forces do not contribute.
        if from.h != 0.0 {
            l_v.iter_mut().zip(&*force).for_each(|(l_v, force)| *l_v -= from.h * force);
        }
        by_fours(l_v, &system.positions().v, |l_v, &position| r[position] -= l_v);
        by_fours(phi_dot, &system.positions().sigma, |phi_dot, &position| r[position] -= phi_dot);
    }

    /// Computes the second derivatives in N′ at the last evaluated point.
    pub(crate) fn second(&mut self, system: &System, report: &mut Report) {
        if self.elements.is_some() {
            let assembly = &self.formulas.as_ref().unwrap_or(system.formulas()).assembly;
            assembly.second(&mut self.workspace, &mut self.blocks[self.sines.block_len()..]);
            report.second_derivatives += assembly.elements();
        }
    }

    /// Writes Φ at any point of the motion.
    pub(crate) fn phi(&mut self, system: &System, at: &NodeView<f64>, phi: &mut [f64]) {
        self.positions(system).0.evaluate(system, at, phi);
    }

    /// Writes Φ at a node with these blocks.
    pub(crate) fn phi_of_node(&mut self, system: &System, at: &NodeView<f64>, blocks: &[f64], phi: &mut [f64]) {
        let (positions, sines) = self.positions(system);
        positions.evaluate_node(system, at, (sines, &blocks[..sines.block_len()]), phi);
    }

    fn positions(&mut self, system: &System) -> (&mut PositionConstraints, &Sines) {
        let Evaluation { formulas, positions, design, constants, sines, .. } = self;
        let elements = &formulas.as_ref().unwrap_or(system.formulas()).elements;
        let make = || {
            let mut made = PositionConstraints::new(system, elements);
            made.fix(elements, design, constants);
            made
        };
        (positions.get_or_insert_with(make), sines)
    }

    /// Writes 𝓛_q + Q at the last evaluated point, which is (q, v) in the scene's order, with the controls u.
    pub(crate) fn force(&self, q: &[f64], v: &[f64], given: Given, force: &mut [f64]) {
        let at = given.at(q, v, &[]);
        self.constants.force(&at, force);
        // 𝓛_q = 𝓛_qv v for sinusoidal terms.
        let angles = &self.blocks[..self.sines.block_len()];
        self.sines.push_forward(angles, &at, |row, of| (row, of) == (Row::V, Variable::D), |_, i, x| force[i] += x);
        if let Some(elements) = &self.elements {
            force.iter_mut().zip(elements.sums.force()).for_each(|(sum, force)| *sum += force);
        }
    }

    /// Assembles K(h) from L and the parts of N′.
    pub(crate) fn assemble<F: Factorization>(&self, system: &System, h: f64, blocks: &[f64], matrix: &mut Matrix<F>) {
        let values = matrix.reset();
        let (angles, rest) = blocks.split_at(self.sines.block_len());
        self.sines.scatter(angles, h, values);
        self.formulas(system).assembly.scatter(rest, h, values);
    }

    /// The adjoint rows of all elements for any c, d, e (see [`system`](crate::system)).
    pub(crate) fn pull_back(&self, system: &System, blocks: &[f64], with: &Covector, rows: &mut StateRows) {
        rows.clear();
        let (angles, rest) = blocks.split_at(self.sines.block_len());
        let mut add = |row: Row, i: usize, x: f64| row.of_mut(rows)[i] += x;
        self.constants.pull_back(&[], with, all, &mut add);
        self.sines.pull_back(angles, with, all, add);
        self.formulas(system).assembly.pull_back(rest, with, all, rows);
    }

    /// The changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of the state and of the controls of constant elements.
    pub(crate) fn push_forward(&self, system: &System, blocks: &[f64], along: &NodeView<f64>, sums: &mut Sums<f64>) {
        sums.clear();
        self.constants.push_forward_controls(along.u, sums.parts_mut()[1]);
        self.push_forward_state(system, blocks, (along, all), sums);
    }

    /// The change of 𝓛_q + Q alone, along a direction of the state; the other sums are left as they are.
    pub(crate) fn push_forward_to_force(
        &self,
        system: &System,
        blocks: &[f64],
        along: &NodeView<f64>,
        sums: &mut Sums<f64>,
    ) {
        sums.parts_mut()[1].fill(0.0);
        self.push_forward_state(system, blocks, (along, of_force), sums);
    }

    #[inline(always)]
    fn push_forward_state(
        &self,
        system: &System,
        blocks: &[f64],
        (along, wanted): (&NodeView<f64>, impl Wanted),
        sums: &mut Sums<f64>,
    ) {
        let (angles, rest) = blocks.split_at(self.sines.block_len());
        let mut parts = sums.parts_mut();
        let mut add = |of: Variable, i: usize, x: f64| parts[of as usize][i] += x;
        self.constants.push_forward(&[], along, wanted, &mut add);
        self.sines.push_forward(angles, along, wanted, add);
        self.formulas(system).assembly.push_forward(rest, (along, wanted), sums);
    }

    /// Adds the derivatives of the directional change of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to the state, for sinusoidal elements.
    pub(crate) fn pull_back_along(&self, blocks: &[f64], along: &NodeView<f64>, with: &Covector, rows: &mut CostRows) {
        self.sines.pull_back_along(&blocks[..self.sines.block_len()], along, with, rows);
    }

    /// Adds the derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to u, design variables and time, except constant ones.
    pub(crate) fn pull_back_inputs(&mut self, system: &System, at: &NodeView<f64>, with: &Covector, rows: &mut InputRows) {
        let formulas = self.formulas.as_ref().unwrap_or(system.formulas());
        formulas.pull_back_inputs(system.batches(), at, with, &mut self.workspace, rows);
    }

    /// Calls `show` for each element that may bend within a step, with `chord` as the ends of the step and the change of its arguments.
    pub(crate) fn look_within(
        &mut self,
        system: &System,
        chord: ([&NodeView<f64>; 2], &NodeView<f64>),
        with: &Covector,
        show: &mut dyn FnMut(Within),
    ) {
        let formulas = self.formulas.as_ref().unwrap_or(system.formulas());
        formulas.look_within(system.batches(), chord, with, &mut self.workspace, show);
    }

    /// Adds −μ e, the adjoint rows of the compliances.
    pub(crate) fn pull_back_compliance(&self, e: &[f64], rows: &mut [f64]) {
        self.linear.compliance().iter().for_each(|&(j, mu)| rows[j] -= mu * e[j]);
    }

    /// right −= (∂v + h ∂q, ∂σ) for c = e = 0, in the solver's order: the contribution of d alone to the adjoint equations.
    pub(crate) fn subtract_force_rows(&mut self, system: &System, h: f64, blocks: &[f64], d: &[f64], right: &mut [f64]) {
        let positions = system.positions();
        let only_d = Covector { c: &[], d, e: &[] };
        self.pull_back_to(system, blocks, &only_d, of_force, |row, i, x| match row {
            Row::V => right[positions.v[i]] -= x,
            Row::Q => right[positions.v[i]] -= h * x,
            Row::Sigma => right[positions.sigma[i]] -= x,
        });
    }

    /// a −= ∂q, the adjoint row of the coordinates, for any c, d, e.
    pub(crate) fn subtract_row_q(&mut self, system: &System, blocks: &[f64], with: &Covector, a: &mut [f64]) {
        self.pull_back_to(system, blocks, with, row_q, |_, i, x| a[i] -= x);
    }

    /// Calls `add` with contributions to the adjoint rows.
    #[inline(always)]
    fn pull_back_to(
        &mut self,
        system: &System,
        blocks: &[f64],
        with: &Covector,
        wanted: impl Wanted,
        mut add: impl FnMut(Row, usize, f64),
    ) {
        let (angles, rest) = blocks.split_at(self.sines.block_len());
        self.constants.pull_back(&[], with, wanted, &mut add);
        self.sines.pull_back(angles, with, wanted, &mut add);
        let Some(Elements { rows, .. }) = &mut self.elements else { return };
        rows.clear();
        self.formulas.as_ref().unwrap_or(system.formulas()).assembly.pull_back(rest, with, wanted, rows);
        for row in Row::ALL.into_iter().filter(|row| Variable::ALL.into_iter().any(|of| wanted(*row, of))) {
            row.of_mut(rows).iter().enumerate().for_each(|(i, x)| add(row, i, *x));
        }
    }
}

impl Elements {
    fn load(&mut self, system: &System, from: &KnownPart, x: &[f64]) {
        self.x.load(system.positions(), x);
        for ((q, &start), &v) in self.q.iter_mut().zip(from.q).zip(&self.x.v) {
            *q = start + from.h * v;
        }
    }
}
