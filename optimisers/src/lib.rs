//! Other optimisers on any [`Problem`]: argmin, and IPOPT where it is installed when this is built.
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

/// Whether IPOPT was there when this was built.
pub const HAS_IPOPT: bool = cfg!(has_ipopt);

/// Where IPOPT gets second derivatives from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hessian {
    /// All products with unit vectors.
    Exact,
    /// None: its own approximation.
    LimitedMemory,
}

/// What is no outcome.
#[derive(Debug)]
pub enum Failure {
    /// The problem's own error.
    Problem(Error),
    /// Bounds or constraints, which the optimiser does not know.
    Constrained,
    /// IPOPT was not found when this was built.
    NoIpopt,
    /// A problem that calls IPOPT while IPOPT asks it.
    Nested,
    /// What IPOPT says of what it was given, a number of its `ApplicationReturnStatus`.
    Refused(i32),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Failure::Problem(error) => error.fmt(f),
            Failure::Constrained => {
                write!(f, "the problem has bounds or constraints, which this optimiser does not know; take `ipopt`")
            }
            Failure::NoIpopt => {
                write!(
                    f,
                    "IPOPT was not found when this was built: install it (Debian: coinor-libipopt-dev) and build again"
                )
            }
            Failure::Nested => write!(
                f,
                "a problem that IPOPT asks calls IPOPT itself, which cannot be done; solve the inner one another way"
            ),
            Failure::Refused(-10) => write!(f, "IPOPT wants no more equality constraints than there are free variables"),
            Failure::Refused(-11) => write!(f, "IPOPT wants at least one variable"),
            Failure::Refused(status) => write!(f, "IPOPT refuses the problem with its status {status}"),
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
/// The first that is no number.
fn finite(what: &str, all: &[f64]) -> Result<(), Error> {
    let bad = all.iter().find(|x| !x.is_finite());
    bad.map_or(Ok(()), |bad| Err(Error::NotFinite { what: what.into(), value: *bad }))
}

/// Minimises by IPOPT: `iterations`, `stationarity` (its `tol`, in parts of the gradient at the start) and `violation` of the options count. Calls of several
/// threads wait for each other: its linear solver knows one at a time.
///
/// # Errors
/// Sizes, bounds or options that do not fit, a start without a value, derivatives that the problem does not have, a problem that IPOPT refuses or that calls
/// IPOPT itself, or no IPOPT. What cannot be computed behind the start is no error, but the reason with which it ends.
pub fn ipopt<P: Problem>(problem: &mut P, start: &[f64], options: &Options, hessian: Hessian) -> Result<Outcome, Failure> {
    #[cfg(has_ipopt)]
    return ipopt::minimise(problem, start, options, hessian);
    #[cfg(not(has_ipopt))]
    {
        let _ = (problem, start, options, hessian);
        Err(Failure::NoIpopt)
    }
}
