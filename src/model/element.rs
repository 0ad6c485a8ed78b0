//! Elements: energies, forces, constraints and costs that depend on a few coordinates, each a plain formula written by the user.
//!
//! Together the elements of a scene give the augmented Lagrangian and the generalized forces,
//!
//! ```text
//! 𝓛(q, v, σ, t) = Σ T(q, v) − Σ V(q, t) + Σ σᵀ dΦ/dt(q, v, t),      Q = Σ Q(q, v, u, t)
//! ```
//!
//! `N` is the number of coordinates of the element (not of the scene), `M` of its constraint equations, `K` of its control channels, `P` of
//! its physical constants `b`. A constant is either a number or depends on design variables of the scene. Write every mass, length or stiffness as
//! an entry of `b`, so that each of them can become a design variable later.
//!
//! The number types `S` are listed at [`Scalar`]. When the scene is compiled, the library detects on which arguments a formula does not
//! depend and in which it is linear; nothing needs to be declared.

use nalgebra::SVector;

use crate::Scalar;

/// Kinetic energy T(q, v; b) in J.
///
/// It contributes to p* = T_v + Φ_qᵀσ (Eq. 1a) and the term T_q to Eq. (1b), which is zero for the paper's constant mass matrices.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a kinetic energy for these numbers of coordinates and constants",
    note = "implement `KineticEnergy<N, P>` with N the number of coordinates and P that of constants in the given lists"
)]
pub trait KineticEnergy<const N: usize, const P: usize = 0>: Send + Sync + 'static {
    /// T(q, v; b).
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, N>, v: &SVector<S, N>, b: &SVector<S, P>) -> S;
}

/// Potential energy V(q, t; b) in J; its force is −V_q.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a potential energy for these numbers of coordinates and constants",
    note = "implement `PotentialEnergy<N, P>` with N the number of coordinates and P that of constants in the given lists"
)]
pub trait PotentialEnergy<const N: usize, const P: usize = 0>: Send + Sync + 'static {
    /// V(q, t; b).
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, P>, t: S) -> S;
}

/// Generalized force Q(q, v, u, t; b) of Eq. (1b), in N for a length, N m for an angle.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a force for these numbers of coordinates, controls and constants",
    note = "implement `Force<N, K, P>` with N the number of coordinates, K that of controls and P that of constants in the given lists"
)]
pub trait Force<const N: usize, const K: usize = 0, const P: usize = 0>: Send + Sync + 'static {
    /// Q(q, v, u, t; b), one component for each coordinate.
    fn force<S: Scalar>(&self, at: &ForcePoint<S, N, K>, b: &SVector<S, P>) -> SVector<S, N>;
}

/// The arguments of a [`Force`] at one point.
#[derive(Clone, Copy, Debug)]
pub struct ForcePoint<S, const N: usize, const K: usize> {
    /// Coordinates, m or rad.
    pub q: SVector<S, N>,
    /// Velocities, m/s or rad/s.
    pub v: SVector<S, N>,
    /// Controls.
    pub u: SVector<S, K>,
    /// Time, s.
    pub t: S,
}

/// Holonomic constraint Φ(q, t; b) = 0, in m or rad.
///
/// The velocity form dΦ/dt = Φ_q v + Φ_t (Eq. 1c) and all derivatives follow from this one function. A constraint that depends on `t`
/// is a prescribed motion of a joint.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a constraint for these numbers of coordinates, equations and constants",
    note = "implement `Constraint<N, M, P>` with N the number of coordinates, M that of equations (and multipliers) and P that of constants"
)]
pub trait Constraint<const N: usize, const M: usize, const P: usize = 0>: Send + Sync + 'static {
    /// Φ(q, t; b).
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, P>, t: S) -> SVector<S, M>;
}

/// A term of the cost: h(y, u, t; b) along the motion, or S(y, u, t; b) at its end (Eq. 5).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a cost for these numbers of coordinates, multipliers, controls and constants",
    note = "implement `Cost<N, M, K, P>` with the numbers of coordinates, multipliers, controls and constants in the given lists"
)]
pub trait Cost<const N: usize, const M: usize = 0, const K: usize = 0, const P: usize = 0>: Send + Sync + 'static {
    /// The value at one node.
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, M, K>, b: &SVector<S, P>) -> S;
}

/// The arguments of a [`Cost`] at one node: the paper's y = (q̇, ṗ*, q, p*, σ) for the element's coordinates, with u and t.
#[derive(Clone, Copy, Debug)]
pub struct CostPoint<S, const N: usize, const M: usize, const K: usize> {
    /// Coordinates, m or rad.
    pub q: SVector<S, N>,
    /// Velocities, m/s or rad/s.
    pub v: SVector<S, N>,
    /// Augmented momenta, N s or N m s.
    pub p_star: SVector<S, N>,
    /// Rates ṗ* of the augmented momenta, N or N m.
    pub p_star_dot: SVector<S, N>,
    /// Accelerations v̇, m/s² or rad/s². They are functions of q, v, u and t with exact derivatives, and are computed only if a cost reads
    /// v̇ or λ.
    pub v_dot: SVector<S, N>,
    /// Multipliers (impulses) of the chosen constraints, N s or N m s.
    pub sigma: SVector<S, M>,
    /// Reactions λ = dσ/dt of the chosen constraints, N or N m. The constraint forces are −Φ_qᵀλ, with M v̇ = Q + … − Φ_qᵀλ: a revolute
    /// joint acts with −λ on its second body and with λ on its first. λ depends on q, v, u and t, but not on σ, so it is the same before
    /// and after a restart. For dependent constraints λ is not unique: a cost on λ then has the value for one possible λ, and computing its
    /// gradient returns an error.
    pub lambda: SVector<S, M>,
    /// Controls.
    pub u: SVector<S, K>,
    /// Rates of the controls in a step, u̇ = (u_i − u_{i−1})/Δt_i. For [`Sum::Trapezoidal`] and [`Sum::Integral`] the cost is evaluated
    /// twice, with the rates of the two adjacent steps, and each value has half of its step as its weight. For [`Sum::Plain`] it is
    /// evaluated with the rate of the step that begins at the node. For [`Sum::AllNodes`] and for a single node it is evaluated with the
    /// rate of the step that ends at the node, if there is one. The gradient includes the resulting dependence on neighbouring controls and
    /// step lengths.
    pub u_dot: SVector<S, K>,
    /// Time, s.
    pub t: S,
}

/// A term of the cost as a function of lists whose lengths are known only at run time, such as the energy of a chain of n links or a
/// full quadratic form.
///
/// ```
/// use hamiltonian_adjoint::{ListCost, ListPoint, Scalar, Sum, scenes::CartPendulum};
///
/// /// (Σ q²)².
/// struct Fourth;
/// impl ListCost for Fourth {
///     fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
///         at.q.iter().map(|q| *q * *q).sum::<S>().powi(2)
///     }
/// }
///
/// for links in [2, 5] {
///     let mut cart = CartPendulum::with_links(links).mechanism();
///     let angles: Vec<_> = cart.links.iter().map(|link| link.coordinates[2]).collect();
///     cart.scene.list_cost("angles", Fourth, Sum::Integral, &angles, &[], &[], &[]);
///     cart.scene.compile()?;
/// }
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub trait ListCost: Send + Sync + 'static {
    /// The value at one node.
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S;
}

/// The arguments of a [`ListCost`] at one node: the lists of [`CostPoint`], in the order of the given handles.
#[derive(Clone, Copy, Debug)]
pub struct ListPoint<'a, S> {
    /// Coordinates, m or rad.
    pub q: &'a [S],
    /// Velocities, m/s or rad/s.
    pub v: &'a [S],
    /// Augmented momenta, N s or N m s.
    pub p_star: &'a [S],
    /// Rates ṗ* of the augmented momenta, N or N m.
    pub p_star_dot: &'a [S],
    /// Accelerations, m/s² or rad/s².
    pub v_dot: &'a [S],
    /// Multipliers (impulses), N s or N m s.
    pub sigma: &'a [S],
    /// Reactions, N or N m.
    pub lambda: &'a [S],
    /// Controls.
    pub u: &'a [S],
    /// Rates of the controls.
    pub u_dot: &'a [S],
    /// Time, s.
    pub t: S,
    /// Constants.
    pub b: &'a [S],
}

/// Kinetic energy T(q, v; b) in J of lists whose lengths are known only at run time, such as that of a tree of bodies.
pub trait ListKineticEnergy: Send + Sync + 'static {
    /// T(q, v; b).
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S;
}

/// Potential energy V(q, t; b) in J of lists whose lengths are known only at run time.
pub trait ListPotentialEnergy: Send + Sync + 'static {
    /// V(q, t; b).
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], t: S) -> S;
}

/// Generalized force Q(q, v, u, t; b) of lists whose lengths are known only at run time, in N for a length, N m for an angle.
pub trait ListForce: Send + Sync + 'static {
    /// Writes Q(q, v, u, t; b), one component for each coordinate; `force` contains zeros at first.
    fn force<S: Scalar>(&self, at: &ListForcePoint<S>, b: &[S], force: &mut [S]);
}

/// The arguments of a [`ListForce`] at one point.
#[derive(Clone, Copy, Debug)]
pub struct ListForcePoint<'a, S> {
    /// Coordinates, m or rad.
    pub q: &'a [S],
    /// Velocities, m/s or rad/s.
    pub v: &'a [S],
    /// Controls.
    pub u: &'a [S],
    /// Time, s.
    pub t: S,
}

/// Holonomic constraint Φ(q, t; b) = 0 of lists whose lengths are known only at run time, in m or rad.
pub trait ListConstraint: Send + Sync + 'static {
    /// Writes Φ(q, t; b), one component for each equation; `phi` contains zeros at first.
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], t: S, phi: &mut [S]);
}

/// A parameter as a user-defined formula of other parameters, for [`Scene::parameter`](crate::Scene::parameter).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a formula for this number of parameters",
    note = "implement `ParameterFormula<N>` with N the number of given parameters"
)]
pub trait ParameterFormula<const N: usize> {
    /// The value of the parameter, computed from the values of the other parameters.
    fn value<S: Scalar>(&self, x: &SVector<S, N>) -> S;
}

/// Rule by which the values of a cost at the nodes are summed.
///
/// The nodes are those of the given grid, 0 … N, including those between the steps of a composed step. Nodes inserted by halved steps
/// contribute only to [`Sum::Integral`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sum {
    /// Σ h_i over i = 0 … N − 1, as in Eq. (5): without the last node, at which [`Sum::Terminal`] is evaluated.
    Plain,
    /// Σ h_i over all nodes, i = 0 … N: for a soft maximum or a penalty that must include the last node.
    AllNodes,
    /// Σ Δt_{i+1} h_i over i = 0 … N − 1: the rectangle rule for ∫ h dt.
    Rectangle,
    /// Σ Δt_i (h_{i−1} + h_i)/2 over i = 1 … N: the trapezoidal rule for ∫ h dt.
    Trapezoidal,
    /// Σ Δt Σ_s b_s h_s over all steps and their stages: ∫ h dt with the weights, and hence the order, of the [`Scheme`](crate::Scheme).
    /// For the trapezoidal rule these are the trapezoidal weights. Nodes inserted by halved steps are included.
    Integral,
    /// h_N only: the terminal cost S of Eq. (5). In a part of a motion ([`Grid::part`](crate::Grid::part)) it counts if the part ends the motion.
    Terminal,
    /// h_i at this node of the given grid only, for example the residual of a reading.
    Node(usize),
    /// h_i at the node of this event only, counted from 0 in [`Inputs::events`](crate::Inputs::events); 0 if the inputs have fewer events.
    Event(usize),
    /// h_i only at the end of the steps of length zero that follow the node of this event: after an impact.
    AfterEvent(usize),
}

impl Sum {
    /// True if the weight of a node depends on the steps on both sides, so that it may vanish although its derivatives do not.
    pub(crate) fn is_of_both_steps(self) -> bool {
        matches!(self, Sum::Trapezoidal | Sum::Integral)
    }
}
