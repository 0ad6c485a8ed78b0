//! Verifying derivatives: hand-derived blocks and gradients against oracles that share nothing with them.

mod agreement;
mod compare;
mod derivative;
mod diagnosis;
mod element;
mod formula;
mod matrix;
mod oracle;
mod point;
mod random;
mod report;
mod ridders;
mod scale;
mod step;

pub use derivative::{Input, central_differences, complex_step, tangent};
pub use element::{ElementCheck, constraint, cost, force, kinetic_energy, potential_energy};
pub use formula::Function;
pub use matrix::Matrix;
pub use point::Point;
pub use random::Random;
pub use report::{BlockReport, Diagnosis, Entry, Mistake, Report, Verdict};
pub use step::{State, StepCheck, StepPoint, Terms, step};
