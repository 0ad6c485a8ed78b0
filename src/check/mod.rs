//! Verifying derivatives: hand-derived blocks and gradients against oracles that share nothing with them.

mod agreement;
mod compare;
mod derivative;
mod diagnosis;
mod direct;
mod element;
mod formula;
mod gradient;
mod matrix;
mod oracle;
mod point;
mod random;
mod report;
mod ridders;
mod scale;
mod step;

pub use derivative::{Input, central_differences, complex_step, tangent};
pub use direct::{Sensitivity, direct_differentiation, no_change};
pub use element::{ElementCheck, constraint, cost, force, kinetic_energy, potential_energy};
pub use formula::Function;
pub use gradient::{DirectionReport, GradientCheck, GradientReport, Identity, Part, Remainder, Taylor, gradient};
pub use matrix::Matrix;
pub use point::Point;
pub use random::Random;
pub use report::{BlockReport, Diagnosis, Entry, Mistake, Report, Verdict};
pub use step::{State, StepCheck, StepPoint, Terms, step};
