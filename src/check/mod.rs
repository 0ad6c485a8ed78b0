//! Derivatives by other ways, to compare with: complex step, tangents and differences through the entire simulation.

mod derivative;

pub use derivative::{Input, central_differences, complex_step, tangent};
