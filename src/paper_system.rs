//! The paper's discrete equations with all 4n + m unknowns in dense form: the reference for the reduced adjoint sweep.
//!
//! Unknowns y = (v, ṗ*, q, p*, σ), 4n + m of them; γ = 2/Δt. In the equations of motion q̇_i and ṗ*_i are replaced according to Eq. (2) by
//! V = γ (q_i − q_{i−1}) − v_{i−1} and G = γ (p*_i − p*_{i−1}) − ṗ*_{i−1}, so that
//!
//! ```text
//!   f1 = v_i − V                    (2)          f3 = 𝓛_v(q_i, V, σ_i) − p*_i                      (3)
//!   f2 = ṗ*_i − G                   (2)          f4 = 𝓛_q(q_i, V, σ_i) + Q(q_i, V, u_i) − G        (3)
//!                                                f5 = dΦ/dt(q_i, V)                                (3)
//! ```
//!
//! The paper does not define f_0. We assume that f_0 determines y_0, with f1 = q_0 − q̄ and f2 = p*_0 − p̄ for the given values, and f3,
//! f4, f5 with v_0 and ṗ*_0 instead of V and G. Then Eq. (9) and (11) also hold for i = 0, and the first two parts of w_0 are −dJ/dq_0 and
//! −dJ/dp*_0.
//!
//! Every block is computed from these formulas by dual numbers, one column at a time. The module favours clarity over speed.

use nalgebra::{DMatrix, DMatrixView, DVector};
use num_dual::Dual64;
use std::ops::Range;

use crate::accelerations::CostSum;
use crate::motion::Refinement;
use crate::motion::column;
use crate::number::Real;
use crate::system::{Beside, CostFactors, NodeView, Sums};
use crate::{Error, Inputs, System, Trajectory};

/// A part of y, which is a block column of the tangent matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// v = q̇.
    V,
    /// ṗ*.
    PStarDot,
    /// q.
    Q,
    /// p*.
    PStar,
    /// σ.
    Sigma,
}

/// One of the discrete equations, which is a block row of the tangent matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equation {
    /// The trapezoidal rule for q.
    F1,
    /// The trapezoidal rule for p*.
    F2,
    /// Eq. (1a).
    F3,
    /// Eq. (1b).
    F4,
    /// Eq. (1c).
    F5,
}

impl Variable {
    /// All parts in the paper's order.
    pub const ALL: [Variable; 5] = [Variable::V, Variable::PStarDot, Variable::Q, Variable::PStar, Variable::Sigma];

    /// Symbol of this part.
    pub fn name(self) -> &'static str {
        ["v", "ṗ*", "q", "p*", "σ"][self as usize]
    }
}

impl Equation {
    /// All rows in the paper's order.
    pub const ALL: [Equation; 5] = [Equation::F1, Equation::F2, Equation::F3, Equation::F4, Equation::F5];

    /// Symbol of this equation.
    pub fn name(self) -> &'static str {
        ["f1", "f2", "f3", "f4", "f5"][self as usize]
    }
}

/// A tangent matrix ∂f/∂y with named blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent {
    /// The matrix, (4n + m) × (4n + m).
    pub matrix: DMatrix<f64>,
    n: usize,
    m: usize,
}

impl Tangent {
    /// The block of an equation and a variable.
    ///
    /// # Panics
    /// If `matrix` has another size.
    pub fn block(&self, row: Equation, column: Variable) -> DMatrixView<'_, f64> {
        let (rows, columns) = (part(row as usize, self.n, self.m), part(column as usize, self.n, self.m));
        self.matrix.view((rows.start, columns.start), (rows.len(), columns.len()))
    }
}

/// Range of part `k` of y (or of f) among the 4n + m entries.
pub(crate) fn part(k: usize, n: usize, m: usize) -> Range<usize> {
    k * n..if k < 4 { (k + 1) * n } else { 4 * n + m }
}

/// The gradient computed from Eq. (9), (11) and (12).
#[derive(Clone, Debug, PartialEq)]
pub struct PaperGradient {
    /// dJ/du_i in column i (k × (N + 1)).
    pub controls: DMatrix<f64>,
    /// dJ/db.
    pub design: DVector<f64>,
    /// dJ/dq_0 for constant p*_0.
    pub q0: DVector<f64>,
    /// dJ/dp*_0.
    pub p_star0: DVector<f64>,
    /// The paper's adjoint variables w_i in column i ((4n + m) × (N + 1)).
    pub w: DMatrix<f64>,
}

/// The discrete system of one motion in the paper's unknowns.
#[derive(Debug)]
pub struct PaperSystem<'a> {
    pub(crate) system: &'a System,
    pub(crate) inputs: &'a Inputs,
    pub(crate) trajectory: &'a Trajectory,
    refinement: Refinement,
}

/// All arguments of f_i and h_i, for any number type.
#[derive(Clone)]
pub(crate) struct Arguments<R> {
    pub(crate) y: DVector<R>,
    pub(crate) y_previous: DVector<R>,
    pub(crate) u: DVector<R>,
    /// Controls at the nodes before and after, for u̇ of the adjacent steps.
    pub(crate) u_beside: [DVector<R>; 2],
    pub(crate) b: DVector<R>,
}

impl<'a> PaperSystem<'a> {
    /// The system at the nodes of a motion.
    ///
    /// # Errors
    /// A motion that is incomplete, has restarts, steps of length zero or another scheme than the trapezoidal rule; inputs of another size; invalid inserted
    /// nodes.
    pub fn new(system: &'a System, inputs: &'a Inputs, trajectory: &'a Trajectory) -> Result<Self, Error> {
        if trajectory.computed == 0 || trajectory.computed < trajectory.times.len() {
            return Err(Error::Incomplete { expected: inputs.grid.nodes(), computed: trajectory.computed });
        }
        trajectory.check_fits(system, inputs)?;
        if !trajectory.scheme.is_trapezoidal() {
            return Err(Error::Scheme { found: trajectory.scheme.name });
        }
        if let Some(&node) = trajectory.restarted.first() {
            return Err(Error::Restarted { node, time: trajectory.times[node] });
        }
        if let Some(step) = inputs.grid.steps.iter().position(|dt| *dt == 0.0) {
            return Err(Error::TimeStep { step: trajectory.refinement(inputs)?.step_of_whole(step + 1), length: 0.0 });
        }
        Ok(PaperSystem { system, inputs, trajectory, refinement: trajectory.refinement(inputs)? })
    }

    /// y_i = (v, ṗ*, q, p*, σ)_i.
    ///
    /// # Panics
    /// If the motion has no node `i`.
    pub fn y(&self, i: usize) -> DVector<f64> {
        let y = self.trajectory.columns(i);
        DVector::from_vec([y.v, y.p_star_dot, y.q, y.p_star, y.sigma].concat())
    }

    /// The residual f_i for the given motion, which is zero up to rounding.
    ///
    /// # Panics
    /// If the motion has no node `i`.
    pub fn f(&self, i: usize) -> DVector<f64> {
        self.residual(i, &self.arguments(i)).map(|f| f.re)
    }

    /// ∂f_i/∂y_i, the left matrix of Eq. (10).
    ///
    /// # Panics
    /// If the motion has no node `i`.
    pub fn f_y(&self, i: usize) -> Tangent {
        self.tangent(i, |arguments| &mut arguments.y)
    }

    /// ∂f_i/∂y_{i−1}, the right matrix of Eq. (10) (there with i + 1 for i); zero for i = 0.
    ///
    /// # Panics
    /// If the motion has no node `i`.
    pub fn f_y_previous(&self, i: usize) -> Tangent {
        self.tangent(i, |arguments| &mut arguments.y_previous)
    }

    /// ∂f_i/∂u_i, (4n + m) × k.
    ///
    /// # Panics
    /// If the motion has no node `i`.
    pub fn f_u(&self, i: usize) -> DMatrix<f64> {
        self.columns(i, |arguments| &mut arguments.u)
    }

    /// ∂f_i/∂b, (4n + m) × the number of design variables.
    ///
    /// # Panics
    /// If the motion has no node `i`.
    pub fn f_b(&self, i: usize) -> DMatrix<f64> {
        self.columns(i, |arguments| &mut arguments.b)
    }

    /// Computes the gradient: solves Eq. (9) backwards with dense matrices and evaluates Eq. (11) and (12), without the factor Δt.
    ///
    /// # Errors
    /// A tangent matrix that is singular; a cost or adjoint variables that are not finite.
    pub fn gradient(&self) -> Result<PaperGradient, Error> {
        let (n, m, nodes) = (self.system.n(), self.system.m(), self.inputs.grid.nodes());
        let mut gradient = PaperGradient {
            controls: DMatrix::zeros(self.system.k(), nodes),
            design: DVector::zeros(self.system.designs()),
            q0: DVector::zeros(n),
            p_star0: DVector::zeros(n),
            w: DMatrix::zeros(4 * n + m, nodes),
        };
        self.trajectory.cost(self.system, self.inputs)?;
        let mut from_next = DVector::zeros(4 * n + m);
        for i in (0..nodes).rev() {
            let right = -self.cost_columns(i, |arguments| &mut arguments.y) - &from_next;
            let solved = self.f_y(i).matrix.transpose().lu().solve(&right);
            let w = solved.ok_or_else(|| self.singular(i))?;
            if let Some(&value) = w.iter().find(|w| !w.is_finite()) {
                return Err(Error::Overflow { what: format!("w at node {i}"), value });
            }
            let by_u = self.cost_columns(i, |arguments| &mut arguments.u) + self.f_u(i).tr_mul(&w);
            gradient.controls.column_mut(i).axpy(1.0, &by_u, 1.0);
            for (beside, other) in self.beside(i).into_iter().enumerate().filter(|_| self.system.has_control_rates()) {
                let by_other = self.cost_columns(i, |arguments| &mut arguments.u_beside[beside]);
                gradient.controls.column_mut(other).axpy(1.0, &by_other, 1.0);
            }
            gradient.design += self.cost_columns(i, |arguments| &mut arguments.b) + self.f_b(i).tr_mul(&w);
            if i > 0 {
                from_next = self.f_y_previous(i).matrix.tr_mul(&w);
            } else {
                gradient.q0 = -w.rows(0, n);
                gradient.p_star0 = -w.rows(n, n);
            }
            gradient.w.set_column(i, &w);
        }
        Ok(gradient)
    }

    fn singular(&self, i: usize) -> Error {
        let unknown = "an unknown of the full system".into();
        Error::SingularStep { step: i, time: self.trajectory.times[i], unknown, pivot: 0.0 }
    }

    /// The nodes before and after, or the node itself if there is none.
    fn beside(&self, i: usize) -> [usize; 2] {
        [i.saturating_sub(1), (i + 1).min(self.inputs.grid.steps.len())]
    }

    fn arguments(&self, i: usize) -> Arguments<Dual64> {
        let dual = |x: &DVector<f64>| x.map(Dual64::from_re);
        let u = |i: usize| dual(&DVector::from_column_slice(column(&self.inputs.controls, i)));
        Arguments {
            y: dual(&self.y(i)),
            y_previous: dual(&self.y(i.saturating_sub(1))),
            u: u(i),
            u_beside: self.beside(i).map(u),
            b: dual(&self.inputs.design),
        }
    }

    /// f_i for any arguments.
    pub(crate) fn residual<R: Real>(&self, i: usize, at: &Arguments<R>) -> DVector<R> {
        let (n, m) = (self.system.n(), self.system.m());
        let of = |y: &DVector<R>, which: Variable| {
            let range = part(which as usize, n, m);
            y.rows(range.start, range.len()).into_owned()
        };
        let [v, g, q, p_star, sigma] = Variable::ALL.map(|which| of(&at.y, which));
        let mut before = DVector::from_element(m, R::zero());
        let (first, second, velocity, rate) = if i == 0 {
            let given = self.trajectory.columns(0);
            let fixed = |x: &[f64]| DVector::from_iterator(n, x.iter().map(|&x| R::from(x)));
            (&q - fixed(given.q), &p_star - fixed(given.p_star), v, g)
        } else {
            let gamma = R::from(2.0 / self.inputs.grid.steps[i - 1]);
            let [v_previous, g_previous, q_previous, p_previous, sigma_previous] =
                Variable::ALL.map(|which| of(&at.y_previous, which));
            before = sigma_previous;
            let velocity = (&q - q_previous) * gamma - v_previous;
            let rate = (&p_star - p_previous) * gamma - g_previous;
            (&v - &velocity, &g - &rate, velocity, rate)
        };
        let mut sums = Sums::new(n, m);
        let state = [q.as_slice(), velocity.as_slice(), sigma.as_slice()];
        let time = R::from(self.trajectory.times[i]);
        let design = self.system.parameters().values(at.b.as_slice());
        let point = NodeView::of_equations(state, (at.u.as_slice(), time, &design));
        self.system.plain_sums(&point, &mut sums);
        for &(j, mu) in self.trajectory.compliance_into(i) {
            sums.parts_mut()[2][j] -= (sigma[j] - before[j]) * mu;
        }
        let third = DVector::from_column_slice(sums.l_v()) - p_star;
        let fourth = DVector::from_column_slice(sums.force()) - rate;
        let parts = [first, second, third, fourth, DVector::from_column_slice(sums.phi_dot())];
        DVector::from_iterator(4 * n + m, parts.iter().flat_map(|part| part.iter().copied()))
    }

    fn tangent(&self, i: usize, which: impl Fn(&mut Arguments<Dual64>) -> &mut DVector<Dual64>) -> Tangent {
        Tangent { matrix: self.columns(i, which), n: self.system.n(), m: self.system.m() }
    }

    /// The Jacobian of f_i with respect to one of its arguments.
    fn columns(&self, i: usize, which: impl Fn(&mut Arguments<Dual64>) -> &mut DVector<Dual64>) -> DMatrix<f64> {
        let mut arguments = self.arguments(i);
        let columns = which(&mut arguments).len();
        let mut jacobian = DMatrix::zeros(4 * self.system.n() + self.system.m(), columns);
        for k in 0..columns {
            which(&mut arguments)[k].eps = 1.0;
            jacobian.set_column(k, &self.residual(i, &arguments).map(|f| f.eps));
            which(&mut arguments)[k].eps = 0.0;
        }
        jacobian
    }

    /// The gradient of the cost at node `i` (h_i, or S at the last) with respect to one of its arguments.
    fn cost_columns(&self, i: usize, which: impl Fn(&mut Arguments<Dual64>) -> &mut DVector<Dual64>) -> DVector<f64> {
        let mut arguments = self.arguments(i);
        let (n, m) = (self.system.n(), self.system.m());
        let steps: Vec<Dual64> = self.inputs.grid.steps.iter().map(|&dt| Dual64::from_re(dt)).collect();
        let columns = which(&mut arguments).len();
        let mut costs = CostSum::new(&self.refinement, CostFactors::of_cost(self.system.outputs()));
        let place = (i, self.trajectory.compliance_from(i));
        DVector::from_fn(columns, |k, _| {
            which(&mut arguments)[k].eps = 1.0;
            let y = arguments.y.as_slice();
            let design = self.system.parameters().values(arguments.b.as_slice());
            let mut sum = 0.0;
            for &side in Beside::of(i, self.inputs.grid.nodes(), self.system.has_control_rates()) {
                let weights = self.refinement.weights(&self.trajectory.scheme, &steps, i, side);
                let u_dot = self.control_rates(&arguments, i, side.step(i));
                let at = NodeView {
                    v_dot: &[],
                    lambda: &[],
                    u_dot: u_dot.as_slice(),
                    v: &y[part(0, n, m)],
                    p_star_dot: &y[part(1, n, m)],
                    q: &y[part(2, n, m)],
                    p_star: &y[part(3, n, m)],
                    sigma: &y[part(4, n, m)],
                    u: arguments.u.as_slice(),
                    t: Dual64::from_re(self.trajectory.times[i]),
                    design: &design,
                };
                let mut add = |_, term: Dual64| sum += term.eps;
                if costs.add(self.system, (&at, place), &weights, &mut add).is_err() {
                    sum = f64::NAN;
                }
            }
            which(&mut arguments)[k].eps = 0.0;
            sum
        })
    }

    /// u̇ of a step adjacent to node `i`.
    fn control_rates(&self, at: &Arguments<Dual64>, i: usize, step: usize) -> DVector<Dual64> {
        let change = if step == i { &at.u - &at.u_beside[0] } else { &at.u_beside[1] - &at.u };
        self.inputs.grid.steps.get(step - 1).map_or(change.clone(), |length| change / Dual64::from_re(*length))
    }
}
