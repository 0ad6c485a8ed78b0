//! Exact discrete adjoint gradients of constrained multibody systems in Hamilton's canonical form.
//!
//! A mechanism is described by small elements ([`element`]), each a plain formula of a few coordinates: kinetic and potential energies,
//! forces, constraints, costs. A [`Scene`] lists them, [`Scene::compile`] checks them and detects on which arguments each depends, and a
//! [`Solver`] computes the motion for given [`Inputs`] and the [`Gradient`] of the cost with respect to all of them. The equations are
//! those of P. Maciąg, P. Malczyk, J. Frączek, *The Discrete Hamiltonian-Based Adjoint Method for Some Optimization Problems in Multibody
//! Dynamics* (<https://doi.org/10.1007/978-3-030-23132-3_43>), called "the paper" in this documentation; equation numbers such as "Eq. (9)"
//! are those of the paper.
//!
//! # Quickstart
//!
//! The paper's example, a cart with three links swung up by a force on the cart:
//!
//! ```
//! use hamiltonian_adjoint::check::{Input, complex_step};
//! use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};
//!
//! let system = CartPendulum::default().scene().compile()?;
//! let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
//! inputs.controls.fill(10.0);
//!
//! let mut solver = Solver::new(&system, Settings::default());
//! let motion = solver.simulate(&inputs)?;
//! let cart = motion.q[(0, motion.last())]; // m, at t = 2 s
//! let gradient = solver.gradient()?;
//! assert!((cart - 8.5233060709473052).abs() < 1e-12);
//! assert!((gradient.value - 15.18353832472497).abs() < 1e-12);
//!
//! // dJ/du at node 50, by the adjoint and by complex step.
//! let control = Input::Control { channel: 0, node: 50 };
//! let reference = complex_step(&system, &inputs, Settings::default(), &[control])?[0];
//! assert!((control.in_gradient(gradient) - reference).abs() < 1e-14);
//! # Ok::<(), hamiltonian_adjoint::Error>(())
//! ```
//!
//! To build your own mechanism, begin with [`Scene`]; for planar bodies and joints, see [`planar`]; for a formula of your own, see
//! [`element`]. The directory `examples` contains an example program for each of these.
//!
//! # The equations
//!
//! The equations of motion follow from one scalar function, the augmented Lagrangian 𝓛. With the kinetic energy T, the potential V,
//! holonomic constraints Φ(q, t) = 0 and multipliers σ (impulses),
//!
//! ```text
//! 𝓛(q, v, σ, t) = T(q, v) − V(q, t) + σᵀ dΦ/dt
//!
//! p*  = 𝓛_v                    (1a)   = M v + Φ_qᵀ σ
//! ṗ*  = 𝓛_q + Q(q, v, u, t)    (1b)   = Q + T_q − V_q + (dΦ/dt)_qᵀ σ
//! 0   = 𝓛_σ                    (1c)   = dΦ/dt = Φ_q v + Φ_t
//! ```
//!
//! | paper | subject | file in `src` |
//! |---|---|---|
//! | (1a)–(1c) | equations of motion, from the elements | `model/element.rs`, `system/` |
//! | | consistent start: v₀ and σ₀ from q₀ and p*₀; start assembled from a guess | `forward/start.rs`, `assembly/` |
//! | (2) | schemes as Butcher tableaux ([`Scheme`]); the trapezoidal rule is the default | `scheme/` |
//! | (3), (4) | the equations of one step, solved by Newton's method | `node/`, `forward/` |
//! | | tangent matrix K of the reduced step, and Kᵀ | `system/formula/block.rs`, `linear/` |
//! | | formulas as programs | `program/`, docs/programs.md |
//! | (5) | cost J = Σ h_i + S | `model/element.rs` ([`Cost`], [`Sum`]), `system/cost/rows.rs` |
//! | (6)–(10) | discrete adjoint equations, reduced to n + m unknowns per step | `adjoint/sweep.rs`; Eq. (9) for one node in `adjoint/stage.rs` |
//! | (2)–(12) | all 4n + m unknowns in the paper's blocks, as the reference for the reduced equations | `paper_system.rs` ([`paper_system`]) |
//! | (11), (12) | dJ/du without the factor Δt, dJ/db; dJ/dq₀, dJ/dv₀, dJ/dΔt | `adjoint/sweep.rs` |
//! | Section 4 | the example | `scene/scenes.rs` |
//! | | dependent constraints; restarts; halved steps; checkpoints | `redundancy/`, `event/restart/`, `motion/refinement.rs`, `solver/long/` |
//! | Fig. 6 | complex step, tangents, differences | `check/`, `solver/lifted/` |
//!
//! # Symbols
//!
//! | paper | code | paper | code |
//! |---|---|---|---|
//! | q, q̇ | `q`, `v` | Φ, Φ_q, Φ̇_q | `phi`, `phi_q`, `phi_dot_q` |
//! | p*, ṗ* | `p_star`, `p_star_dot` | σ | `sigma` |
//! | γ = 2/Δt | h = 1/γ = Δt/2, the half step | w | `w`; `a`, `b`, `c`, `d`, `e` ([`AdjointVariables`]) |
//! | f_y, f_u | `f_y`, `f_u` ([`paper_system`]) | y | the columns of a [`Trajectory`] |
//! | u | `u`, `controls` | design parameters | `b` of an element, `design` of the inputs |
//! | h, S | [`Cost`] with [`Sum::Plain`], [`Sum::Terminal`] | n, m, k | [`System::n`], [`System::m`], [`System::k`] |
//!
//! Derivatives are written as suffixes, such as `_q`. Units are SI: m, rad, s, kg, N; σ and p* are in N s (N m s for angles).
#![cfg_attr(docsrs, feature(doc_cfg))]

mod accelerations;
mod adjoint;
mod animation;
mod assembly;
pub mod check;
mod error;
mod estimate;
mod event;
#[cfg(feature = "files")]
mod files;
mod forward;
mod linear;
mod memory;
mod model;
mod motion;
mod node;
mod number;
mod operating_point;
pub mod optimize;
pub mod paper_system;
mod program;
mod redundancy;
mod scene;
mod scheme;
mod settings;
mod solver;
mod system;
#[cfg(feature = "files")]
mod text;
mod warning;

pub use adjoint::{AdjointVariables, Gradient};
pub use animation::Animation;
pub use error::Error;
pub use estimate::{Derivative, Estimate, Withdrawn, estimate};
#[cfg(feature = "files")]
pub use files::{Finished, PartEntry, PartKind, SceneFile, Study, Table, TextFunction};
pub use model::element::{
    self, Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy, ListConstraint, ListCost, ListForce,
    ListForcePoint, ListKineticEnergy, ListPoint, ListPotentialEnergy, ParameterFormula, PotentialEnergy, Sum,
};
pub use model::{Control, Coordinate, Design, Event, Multiplier, Output, Param};
pub use motion::{
    Compliance, Composition, Grid, Held, Inputs, Occurrence, Progress, Report, Start, States, Task, Trajectory,
};
pub use number::{Arithmetic, Cx, Hyper, Real, Scalar};
pub use operating_point::{Equilibrium, LinearModel, Sensitivity};
pub use scene::{EndState, Scene, axis, planar, scenes, spatial};
pub use scheme::Scheme;
pub use settings::Settings;
pub use solver::{LiftedSolver, LongSolver, Mechanics, Solver, State, Stopped, gradient, gradients, simulate};
pub use system::System;
pub use warning::Warning;

/// The linear algebra crate whose vectors and matrices the interfaces use.
pub use nalgebra;

// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(any(doc, doctest))]
#[allow(rustdoc::broken_intra_doc_links)]
pub mod guide;
