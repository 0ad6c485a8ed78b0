//! The equations of a step: residual, tangent matrix K, products with its blocks, and second derivatives along a direction.

mod acceleration;
mod assembly;
mod branches;
mod constants;
mod directional;
mod element_constants;
mod node_problem;
mod position;
mod products;
mod scatter;
mod second_order;
mod sinusoidal_constraints;

pub(crate) use acceleration::{AccelerationEquations, AccelerationSecondOrder, acceleration_tangent};
pub(in crate::system) use assembly::Assembly;
pub(crate) use assembly::{Formulas, Workspace};
pub(crate) use constants::Constants;
pub(crate) use node_problem::{Given, KnownPart};
pub(crate) use position::PositionConstraints;
pub(crate) use products::{Entries, Row, Variable, Wanted, all, of_force, row_q};
pub(crate) use second_order::SecondOrderEquations;
pub(in crate::system) use sinusoidal_constraints::Places;
pub(crate) use sinusoidal_constraints::Sines;
