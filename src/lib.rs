//! Exact discrete adjoint gradients of constrained multibody systems in Hamilton's canonical form.
#![warn(missing_docs)]

pub mod adjoint;
pub mod check;
mod complex_step;
pub mod element;
pub mod error;
mod evaluation;
mod inputs;
mod lifted;
mod linear;
pub mod paper_system;
pub mod planar;
mod predict;
mod scalar;
mod scene;
pub mod scenes;
mod settings;
mod simulate;
mod solver;
mod start;
mod system;
pub mod trace;
mod trajectory;
mod trapezoid;

pub use adjoint::{AdjointVariables, Gradient};
pub use complex_step::Cx;
pub use element::{Constraint, Cost, CostPoint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Sum};
pub use error::{Error, Stopped};
pub use inputs::{Grid, Inputs, Start};
pub use lifted::LiftedSolver;
pub use scalar::{Arithmetic, Real, Scalar};
pub use scene::{Control, Coordinate, Design, Multiplier, Multipliers, Param, Scene};
pub use settings::Settings;
pub use solver::{Solver, gradient, simulate};
pub use system::System;
pub use trajectory::{Report, Trajectory};
