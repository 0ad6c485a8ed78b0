//! Adapters from any [`Problem`] to other optimisers: argmin, and IPOPT if it is installed at build time.
//!
//! `cargo run --release -p optimisers --example compare` compares them with the library's own methods.

mod argmin;
#[cfg(has_ipopt)]
mod interface;
#[cfg(has_ipopt)]
mod ipopt;

use std::fmt;

use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::{Options, Outcome, Problem};

pub use argmin::Argmin;

/// True if IPOPT was found at build time.
pub const HAS_IPOPT: bool = cfg!(has_ipopt);

/// Source of the second derivatives for IPOPT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hessian {
    /// Exact: products with all unit vectors.
    Exact,
    /// IPOPT's own approximation.
    LimitedMemory,
}

/// A run without an outcome.
#[derive(Debug)]
pub enum Failure {
    /// The problem's own error.
    Problem(Error),
    /// The problem has bounds or constraints, which the optimiser does not support.
    Constrained,
    /// IPOPT was not found at build time.
    NoIpopt,
    /// A problem that calls IPOPT while IPOPT evaluates it.
    Nested,
    /// IPOPT rejected the problem, with a value of its `ApplicationReturnStatus`.
    Refused(i32),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Failure::Problem(error) => error.fmt(f),
            Failure::Constrained => {
                write!(f, "the problem has bounds or constraints, which this optimiser does not support; use `ipopt`")
            }
            Failure::NoIpopt => {
                write!(f, "IPOPT was not found at build time: install it (Debian: coinor-libipopt-dev) and build again")
            }
            Failure::Nested => write!(
                f,
                "a problem that IPOPT evaluates calls IPOPT itself, which is not supported; solve the inner problem with another method"
            ),
            Failure::Refused(-10) => write!(f, "IPOPT does not accept more equality constraints than free variables"),
            Failure::Refused(-11) => write!(f, "IPOPT needs at least one variable"),
            Failure::Refused(status) => write!(f, "IPOPT rejected the problem with status {status}"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Problem(error)
    }
}

/// # Errors
/// The first value that is not finite.
fn finite(what: &str, all: &[f64]) -> Result<(), Error> {
    let bad = all.iter().find(|x| !x.is_finite());
    bad.map_or(Ok(()), |bad| Err(Error::NotFinite { what: what.into(), value: *bad }))
}

/// Minimises with IPOPT, which uses the options `iterations`, `stationarity` (its `tol`, relative to the gradient at the start) and `violation`. Calls from
/// several threads wait for each other, because its linear solver supports only one at a time.
///
/// # Errors
/// Invalid sizes, bounds or options, a start that cannot be evaluated, derivatives that the problem does not provide, a problem that IPOPT rejects or that
/// calls IPOPT itself, or missing IPOPT. A failure after the start is not an error; it becomes the reason with which the run ends.
pub fn ipopt<P: Problem>(problem: &mut P, start: &[f64], options: &Options, hessian: Hessian) -> Result<Outcome, Failure> {
    #[cfg(has_ipopt)]
    return ipopt::minimise(problem, start, options, hessian);
    #[cfg(not(has_ipopt))]
    {
        let _ = (problem, start, options, hessian);
        Err(Failure::NoIpopt)
    }
}
