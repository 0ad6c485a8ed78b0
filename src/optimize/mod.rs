//! Optimisation: free variables, costs, constraints, and methods.
//!
//! The methods minimise f(x) subject to l ≤ x ≤ u and l_c ≤ c(x) ≤ u_c. [`MotionProblem`] is such a problem with the cost J and the outputs of a
//! motion; any other type that implements [`Problem`] can be minimised, too. The gradient of f + wᵀc costs one backward sweep for any number
//! of constraints.
//!
//! | method | for |
//! |---|---|
//! | [`solve`](solve()) | motions from one state to another: from a guess of the states, by segments that are joined to one motion |
//! | [`interior_point`](interior_point()) | many variables, bounds, equalities and inequalities, with exact products of the Hessian |
//! | [`homotopy`](homotopy()) | problems that `interior_point` does not solve directly, by a sequence of easier problems |
//! | [`MultipleShooting`] | motions whose end is too sensitive to their beginning: divided into segments, as a problem for the methods above |
//! | [`stages`](stages()) | the problems of [`MultipleShooting`], with many segments: the work of an iteration is that of a few sweeps over the motion |
//! | [`levenberg_marquardt`] | sums of squares of residuals c(x), with fewer or more residuals than variables |
//! | [`identify`](identify()) | parameters from readings of several experiments ([`Trials`]), also from guesses that are far away |
//! | [`lbfgs`](lbfgs()) | many variables and bounds, with gradients alone |
//! | [`augmented_lagrangian`](augmented_lagrangian()) | many variables, bounds and constraints, with gradients alone |
//!
//! ```
//! use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, lbfgs, silent};
//! use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
//!
//! let scene = CartPendulum::default().scene();
//! let force = scene.control_named("force on the cart").expect("its only control");
//! let system = scene.compile()?;
//! let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
//! inputs.controls.fill(10.0);
//!
//! let variables = Variables::new(&system, &inputs, vec![Free::control(force)])?;
//! let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
//! let start = problem.start();
//! let outcome = lbfgs(&mut problem, &start, &Options { target: Some(1e-10), ..Options::default() }, &mut silent)?;
//! assert!(outcome.value < 1e-10 && outcome.evaluations < 80);
//! # Ok::<(), hamiltonian_adjoint::Error>(())
//! ```

mod augmented_lagrangian;
mod barrier;
mod chi_squared;
mod counted;
mod degenerate;
mod fit;
mod free;
mod held;
mod homotopy;
mod identify;
mod interior_point;
mod lbfgs;
mod least_squares;
mod line_search;
mod motion_problem;
mod multi_start;
mod multiple_shooting;
mod norm;
mod outcome;
mod problem;
mod projection;
mod segment;
mod sizes;
mod solve;
mod spline;
mod stages;
mod trials;
mod trust_region;
mod variables;
mod violation;

pub use augmented_lagrangian::augmented_lagrangian;
pub use fit::Fit;
pub use free::{Free, Quantity};
pub use homotopy::homotopy;
pub use identify::{Identified, identify};
pub use interior_point::interior_point;
pub use lbfgs::lbfgs;
pub use least_squares::levenberg_marquardt;
pub use motion_problem::MotionProblem;
pub use multi_start::{lowest, multi_start};
pub use multiple_shooting::MultipleShooting;
pub use outcome::{Iterate, Options, Outcome, Reason, Watcher, log_to, silent};
pub use problem::{Interval, Problem};
pub use solve::{Attempt, Guess, Parameter, Search, Sensitivity, Solved, sensitivities, solve};
pub use stages::stages;
pub use trials::Trials;
pub use variables::Variables;
pub use violation::Violation;
