//! Results of the adjoint sweep: J with its derivatives, and the adjoint variables.

use nalgebra::{DMatrix, DVector};

use crate::motion::column_mut;
use crate::number::all_finite;
use crate::scheme::Carried;
use crate::{Error, Start, System, Warning};

/// A cost and its derivatives with respect to all inputs of the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// The cost J.
    pub value: f64,
    /// dJ/du_i in column i = 0 … N (k × (N + 1)), Eq. (11) without the factor Δt.
    pub controls: DMatrix<f64>,
    /// dJ/db, Eq. (12). If the start is given, it is held constant; if it depends on b (a hinge moves, a length changes), use
    /// [`Start::Assembled`](crate::Start::Assembled) for the total derivative.
    pub design: DVector<f64>,
    /// dJ/dq₀ and dJ/dv₀, or dJ/dp*₀ if the start contains p*₀.
    pub start: Start,
    /// dJ/dΔt_i of the steps i = 1 … N. Their sum, weighted with the fractions of the steps in the duration, is the derivative with respect to the
    /// final time.
    pub steps: Vec<f64>,
    /// The derivatives at frozen grid phase: those of a grid that moves with the kinks of the motion, where contacts begin or end or friction
    /// reverses. `None` if no kink of an element lies between two nodes. They are close to the derivatives of the continuous motion where the others
    /// are not ([`Warning::GridPhase`]).
    pub frozen: Option<Box<Gradient>>,
    /// Warnings of the motion and of the backward sweep.
    pub warnings: Vec<Warning>,
}

/// The adjoint variables, that is, the multipliers of the step equations E1 … E5 stated at the fields `a` … `e`, with one column for each node 0 … N
/// (a₀ = b₀ = 0).
#[derive(Clone, Debug, PartialEq)]
pub struct AdjointVariables {
    /// Multiplier of E1, q − q₋ − h (v + v₋). For a scheme with several stages a, b and e are sums over the stages of the step.
    pub a: DMatrix<f64>,
    /// Multiplier of E2, p* − p*₋ − h (ṗ* + ṗ*₋).
    pub b: DMatrix<f64>,
    /// Multiplier of E3, 𝓛_v − p*.
    pub c: DMatrix<f64>,
    /// Multiplier of E4, 𝓛_q + Q − ṗ*.
    pub d: DMatrix<f64>,
    /// Multiplier of E5, dΦ/dt.
    pub e: DMatrix<f64>,
    /// Δt Σ_s a_s0 a_s over the stages s of the step that ends at the node, with the first entries a_s0 of the rows of the
    /// [`Scheme`](crate::Scheme) and the multipliers a_s of the stages: the negative derivative of J with respect to the velocities at the
    /// beginning of the step, for constant q and p*.
    pub alpha: DMatrix<f64>,
    /// Δt Σ_s a_s0 b_s, as in `alpha`: the negative derivative of J with respect to ṗ* at the beginning of the step.
    pub beta: DMatrix<f64>,
    /// The part of dJ/dσ₋ that acts through σ after the restart, where σ₋ is σ at the beginning of a macro step that ends with a restart (m × (N +
    /// 1); 0 at other nodes).
    pub s: DMatrix<f64>,
    /// The paper's w of Eq. (9), (4n + m) × (N + 1): w = (h₊ a₊ − J_v, h₊ b₊ − J_ṗ*, c, d, e), and at node 0
    /// (−dJ/dq₀, −dJ/dp*₀, c, d, e), see [`paper_system`](crate::paper_system).
    pub w: DMatrix<f64>,
}

impl Gradient {
    /// A gradient for a motion without nodes.
    pub(super) fn empty(system: &System) -> Self {
        let (n, controls) = (system.n(), DMatrix::zeros(system.k(), 0));
        let start = Start::Velocity { q: DVector::zeros(n), v: DVector::zeros(n) };
        let (design, steps, warnings) = (DVector::zeros(system.designs()), Vec::new(), Vec::new());
        Gradient { value: 0.0, controls, design, start, steps, frozen: None, warnings }
    }

    /// Multiplies all derivatives by a factor.
    pub(super) fn multiply(&mut self, factor: f64) {
        self.controls *= factor;
        self.design *= factor;
        *self.start.q_mut() *= factor;
        *self.start.rate_mut() *= factor;
        self.steps.iter_mut().for_each(|d| *d *= factor);
        self.frozen.iter_mut().for_each(|frozen| frozen.multiply(factor));
    }

    /// Returns an error if a sum over the nodes has overflowed; `first` is the number of the first node.
    pub(crate) fn check_finite(&self, system: &System, first: usize) -> Result<(), Error> {
        let Gradient { value, controls, design, start, steps, .. } = self;
        let rate = format!("dJ/d{}", start.rate_symbol());
        let parts: [(&str, &[f64]); 6] = [
            ("J", std::slice::from_ref(value)),
            ("dJ/du", controls.as_slice()),
            ("dJ/db", design.as_slice()),
            ("dJ/dq₀", start.q().as_slice()),
            (&rate, start.rate().as_slice()),
            ("dJ/dΔt", steps),
        ];
        let bad = parts.into_iter().find_map(|(name, values)| {
            if all_finite(values) {
                return None;
            }
            let k = values.iter().position(|x| !x.is_finite())?;
            let what = match name {
                "dJ/db" => format!("{name} of `{}`", system.design_name(k)),
                "dJ/du" => format!("{name} of `{}` at node {}", system.control_name(k % system.k()), first + k / system.k()),
                "dJ/dΔt" => format!("{name} of step {}", first + k + 1),
                "J" => "J".into(),
                _ => format!("{name} of `{}`", system.coordinate_name(k)),
            };
            Some(Error::Overflow { what, value: values[k] })
        });
        bad.map_or(Ok(()), Err)
    }
}

impl AdjointVariables {
    pub(crate) fn zeros(system: &System, nodes: usize) -> Self {
        let state = || DMatrix::zeros(system.n(), nodes);
        let (e, w) = (DMatrix::zeros(system.m(), nodes), DMatrix::zeros(4 * system.n() + system.m(), nodes));
        AdjointVariables {
            a: state(),
            b: state(),
            c: state(),
            d: state(),
            alpha: state(),
            beta: state(),
            s: e.clone(),
            e,
            w,
        }
    }

    /// Stores the adjoint variables that the step ending at a node carries back to its beginning.
    pub(crate) fn store_step(&mut self, node: usize, carried: &Carried) {
        column_mut(&mut self.a, node).copy_from_slice(&carried.a);
        column_mut(&mut self.b, node).copy_from_slice(&carried.b);
        column_mut(&mut self.e, node).copy_from_slice(&carried.e);
        for k in 0..carried.a.len() {
            (self.alpha[(k, node)], self.beta[(k, node)]) = carried.alpha_and_beta(k);
        }
    }
}
