//! [`Accelerations`]: v̇ and λ of a state, their derivatives, and costs on them.
//!
//! ```text
//!   K(0) (v̇, λ) = r(q, v, u, t; b)          K(0) = [𝓛_vv Φ_qᵀ; Φ_q 0]
//!   K(0) (c, e) = (h_v̇, h_λ),               h gains ∂[c·f + e·g] with respect to q, v, u, t and b
//! ```
//!
//! with f and g of `system/tangent/acceleration.rs`; r is the value of both at v̇ = 0 and λ = 0.

use super::state::{State, without_sigma};

use crate::motion::Compliances;
use crate::number::{Real, all_finite};
use crate::system::{
    AccelerationEquations, AccelerationSecondOrder, CostRows, Covector, NodeValues, NodeView, Pair, SecondOrderEquations,
    acceleration_tangent,
};
use crate::{Error, System};

/// Workspace for accelerations and reactions.
pub(crate) struct Accelerations {
    state: State,
    equations: AccelerationEquations,
    /// Created for the first product with a Hessian or a direction.
    second: Option<AccelerationSecondOrder>,
    /// True if the workspace belongs to the current motion and its design variables.
    is_ready: bool,
    /// v̇ and λ of the last state.
    x: Pair,
    /// c and e of the last cost.
    adjoint: Pair,
    /// Change of c and e along a direction.
    change: Pair,
    zeros: Pair,
    /// λ at a distance from that of the last state.
    aside: Vec<f64>,
}

impl Accelerations {
    pub(crate) fn new(system: &System) -> Self {
        let pair = || Pair::new(system.n(), system.m());
        Accelerations {
            state: State::new(system),
            equations: AccelerationEquations::default(),
            second: None,
            is_ready: false,
            x: pair(),
            adjoint: pair(),
            change: pair(),
            zeros: pair(),
            aside: vec![0.0; system.m()],
        }
    }

    /// Begins another motion: formulas and design variables may have changed.
    pub(crate) fn begin(&mut self) {
        self.is_ready = false;
    }

    fn prepare(&mut self, system: &System, at: &NodeView<f64>) -> Result<(), Error> {
        let evaluation = &mut self.state.linearisation.evaluation;
        let known = evaluation.fingerprint();
        evaluation.set_start(system, at)?;
        let elements = &evaluation.formulas(system).elements;
        if known.is_none() || known != evaluation.fingerprint() {
            (self.equations, self.second) = (AccelerationEquations::new(system, elements), None);
        }
        self.equations.fix(elements, at.design);
        if let Some(second) = &mut self.second {
            second.fix(elements, at.design);
        }
        self.is_ready = true;
        Ok(())
    }

    /// Computes v̇ and λ at a node, or at a stage of the step that ends there, with the compliances of the motion from there on.
    ///
    /// # Errors
    /// A singular mass matrix or configuration; forces that are not finite.
    pub(crate) fn evaluate(
        &mut self,
        system: &System,
        at: &NodeView<f64>,
        (node, compliance): (usize, &Compliances),
    ) -> Result<(), Error> {
        self.evaluate_under(system, at, (node, compliance), &[])
    }

    /// Computes v̇ and λ under additional forces on the coordinates, N or N m; an empty list stands for none.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub(crate) fn evaluate_under(
        &mut self,
        system: &System,
        at: &NodeView<f64>,
        place: (usize, &Compliances),
        forces: &[f64],
    ) -> Result<(), Error> {
        self.right(system, at, place.0)?;
        let Accelerations { state, x, .. } = self;
        state.right.v.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        state.factor(system, at, place)?;
        state.solve(system, x);
        Ok(())
    }

    /// Computes r, the right-hand side for v̇ and λ at a state.
    ///
    /// # Errors
    /// Forces that are not finite.
    pub(crate) fn right(&mut self, system: &System, at: &NodeView<f64>, node: usize) -> Result<&Pair, Error> {
        if !self.is_ready {
            self.prepare(system, at)?;
        }
        let Accelerations { state, equations, .. } = self;
        equations.right(system, &without_sigma(at, &state.zeros), &mut state.right);
        if !all_finite(&state.right.v) || !all_finite(&state.right.sigma) {
            let unknown = Error::Overflow { what: "a force".into(), value: f64::NAN };
            return Err(system.find_not_finite(&at.without_momenta(), node).unwrap_or(unknown));
        }
        Ok(&state.right)
    }

    /// A state with the v̇ and λ computed last.
    pub(crate) fn with<'a>(&'a self, at: NodeView<'a, f64>) -> NodeView<'a, f64> {
        NodeView { v_dot: &self.x.v, lambda: &self.x.sigma, ..at }
    }

    /// v̇ and λ computed last.
    pub(crate) fn found(self) -> Pair {
        self.x
    }

    /// Marks v̇ and λ as unknown (NaN).
    pub(crate) fn forget(&mut self) {
        self.x.v.fill(f64::NAN);
        self.x.sigma.fill(f64::NAN);
    }

    /// Adds to the rows of a cost the contributions of its derivatives with respect to v̇ and λ of the last state, which is `at`.
    ///
    /// # Errors
    /// The cost depends on a reaction that other constraints may take over.
    pub(crate) fn pull_back(&mut self, system: &System, at: &NodeView<f64>, rows: &mut CostRows) -> Result<(), Error> {
        if rows.v_dot.iter().chain(&rows.lambda).all(|x| *x == 0.0) {
            return Ok(());
        }
        self.find_adjoint(system, at, rows)?;
        let Accelerations { state, equations, x, adjoint, .. } = self;
        let at = NodeView { v_dot: &x.v, lambda: &x.sigma, ..without_sigma(at, &state.zeros) };
        equations.pull_back(system, &at, adjoint, rows);
        Ok(())
    }

    /// Computes c and e of a cost; an error if the cost depends on a reaction that other constraints may take over.
    fn find_adjoint(&mut self, system: &System, at: &NodeView<f64>, rows: &CostRows) -> Result<(), Error> {
        let Accelerations { state, adjoint, .. } = self;
        state.right.v.copy_from_slice(&rows.v_dot);
        state.right.sigma.copy_from_slice(&rows.lambda);
        state.solve(system, adjoint);
        match state.find_undetermined(system, at) {
            Some(equation) => {
                Err(Error::UndeterminedReaction { equation: system.equation_name(equation).to_string(), time: at.t })
            }
            None => Ok(()),
        }
    }

    /// Checks that costs do not depend on a reaction that other constraints may take over. The check uses another λ than that of the last state,
    /// where derivatives may happen to be zero. A sum of reactions that the motion determines is the same for every λ. `gradient` adds the
    /// derivatives at a λ to rows.
    ///
    /// # Errors
    /// A cost depends on such a reaction.
    pub(crate) fn check_aside(
        &mut self,
        system: &System,
        at: &NodeView<f64>,
        rows: &mut CostRows,
        gradient: impl FnOnce(&NodeView<f64>, &mut CostRows),
    ) -> Result<(), Error> {
        for (j, (aside, lambda)) in self.aside.iter_mut().zip(&self.x.sigma).enumerate() {
            *aside = lambda + 0.5 + 0.3 * (j as f64).sin();
        }
        rows.clear();
        gradient(&NodeView { lambda: &self.aside, ..self.with(*at) }, rows);
        rows.v_dot.fill(0.0);
        // A formula that is not finite at this λ shows nothing about the reaction.
        let is_asked = all_finite(&rows.lambda) && rows.lambda.iter().any(|x| *x != 0.0);
        if is_asked { self.find_adjoint(system, at, rows) } else { Ok(()) }
    }

    /// True if constraints depend on each other at this state, so that reactions may not be determined.
    pub(crate) fn is_compliant(&self) -> bool {
        !self.state.linearisation.evaluation.compliance().is_empty()
    }

    /// v̇ and λ of the last state, which is `at`, and their changes along a direction.
    pub(crate) fn along(&mut self, system: &System, at: &NodeView<f64>, along: &NodeView<f64>) -> [&Pair; 2] {
        self.along_under(system, (at, along), &[]);
        [&self.x, &self.adjoint]
    }

    /// Changes of f and g along a direction, for constant v̇ and λ, at a state at which r, or v̇ and λ, were computed.
    pub(crate) fn changes(&mut self, system: &System, (at, along): (&NodeView<f64>, &NodeView<f64>), x: &Pair) -> &Pair {
        let Accelerations { state, second, .. } = self;
        change(state, second, system, (at, along), x);
        &state.right
    }

    /// Change of v̇ and λ along a direction, with a change of additional forces, at the state of [`evaluate_under`](Self::evaluate_under).
    pub(crate) fn along_under(
        &mut self,
        system: &System,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        forces: &[f64],
    ) -> &Pair {
        let Accelerations { state, second, x, adjoint, .. } = self;
        change(state, second, system, (at, along), x);
        state.right.v.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        state.solve(system, adjoint);
        adjoint
    }

    /// Changes along a direction, including the change of v̇ and λ, of the contributions that [`pull_back`](Self::pull_back) adds to `first`. `rows`
    /// contains the changes of the cost's own derivatives.
    ///
    /// # Errors
    /// A formula without a program panics when it is recorded.
    pub(crate) fn pull_back_along(
        &mut self,
        system: &System,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        equations_along: &mut SecondOrderEquations,
        (first, rows): (&mut CostRows, &mut CostRows),
    ) -> Result<(), Error> {
        let Accelerations { state, equations, second, x, adjoint, change, zeros, .. } = self;
        let elements = &state.linearisation.evaluation.formulas(system).elements;
        let second = second.get_or_insert_with(|| AccelerationSecondOrder::fixed(system, elements, at.design));
        state.right.v.copy_from_slice(&first.v_dot);
        state.right.sigma.copy_from_slice(&first.lambda);
        state.solve(system, adjoint);
        let here = NodeView { v_dot: &x.v, lambda: &x.sigma, ..without_sigma(at, zeros) };
        let fixed = NodeView { sigma: &zeros.sigma, ..*along };
        // K̇ (c, e).
        first.clear();
        let with = Covector { c: &adjoint.v, d: &zeros.v, e: &adjoint.sigma };
        let evaluation = &state.linearisation.evaluation;
        evaluation.pull_back_along(&evaluation.blocks, &fixed, &with, first);
        equations_along.pull_back(system.batches(), (&here, &fixed), &with, first);
        let less = |(right, (row, less)): (&mut f64, (&f64, &f64))| *right = row - less;
        state.right.v.iter_mut().zip(rows.v_dot.iter().zip(&first.v)).for_each(less);
        state.right.sigma.iter_mut().zip(rows.lambda.iter().zip(&first.sigma)).for_each(less);
        state.solve(system, change);
        equations.pull_back(system, &here, change, rows);
        let elements = &state.linearisation.evaluation.formulas(system).elements;
        second.pull_back((system, elements), (&here, &fixed), adjoint, rows)?;
        // The rows are linear in v̇ and λ.
        let moved = NodeView { v_dot: along.v_dot, lambda: along.lambda, ..here };
        equations.pull_back(system, &moved, adjoint, rows);
        let still = NodeView { v_dot: &zeros.v, lambda: &zeros.sigma, ..here };
        adjoint.subtract_from(zeros);
        equations.pull_back(system, &still, adjoint, rows);
        Ok(())
    }

    /// v̇ and λ on another number type: real parts by `evaluate`, derivatives in every other part by programs or by the plain formulas.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate); numbers with derivatives along two directions at once, which are not supported.
    pub(crate) fn lift<R: Real>(
        &mut self,
        system: &System,
        at: &NodeView<R>,
        (place, by_programs): ((usize, &Compliances), bool),
    ) -> Result<[Vec<R>; 2], Error> {
        if R::PARTS > 2 {
            return Err(Error::NoHyperDual);
        }
        let part = |part: usize| NodeValues::of_equations(at, |x| x.part(part));
        let real = part(0);
        self.evaluate(system, &real.view(), place)?;
        let Accelerations { state, second, x, adjoint, zeros, .. } = self;
        let mut lifted = [&x.v, &x.sigma].map(|x| x.iter().map(|&x| R::from(x)).collect::<Vec<R>>());
        let here = NodeView { v_dot: &x.v, lambda: &x.sigma, ..without_sigma(&real.view(), zeros) };
        for k in 1..R::PARTS {
            let (elements, along) = (&state.linearisation.evaluation.formulas(system).elements, part(k));
            let (of, at) = ((system, &elements[..]), (&here, &along.view()));
            if by_programs {
                let second = second.get_or_insert_with(|| AccelerationSecondOrder::fixed(system, elements, here.design));
                second.changes(of, at, &mut state.right);
            } else {
                acceleration_tangent(of, at, &mut state.right);
            }
            state.solve(system, adjoint);
            for (all, own) in lifted.iter_mut().zip([&adjoint.v, &adjoint.sigma]) {
                all.iter_mut().zip(own).for_each(|(x, own)| x.add_to_part(k, *own));
            }
        }
        Ok(lifted)
    }
}

/// Writes the changes of f and g along a direction, for constant v̇ and λ, to the right-hand side.
fn change(
    state: &mut State,
    second: &mut Option<AccelerationSecondOrder>,
    system: &System,
    (at, along): (&NodeView<f64>, &NodeView<f64>),
    x: &Pair,
) {
    let here = NodeView { v_dot: &x.v, lambda: &x.sigma, ..without_sigma(at, &state.zeros) };
    let elements = &state.linearisation.evaluation.formulas(system).elements;
    let second = second.get_or_insert_with(|| AccelerationSecondOrder::fixed(system, elements, at.design));
    second.changes((system, elements), (&here, along), &mut state.right);
}
