//! What was expected, what was found, and whether that will do; times are never judged.

use std::fmt;

use serde::Serialize;

use super::Measured;
use super::convergence::{Convergence, Reading};
use super::exactness::Exactness;
use crate::statistics::largest;

/// Relative differences up to this are rounding.
const ROUNDING: f64 = 1e-12;
/// How far an observed order may be from the promised one, as a share of that.
const SHARE: f64 = 0.05;

/// Whether a finding is as expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It is.
    Confirmed,
    /// It is not.
    Failed,
    /// It is only told.
    Reported,
}

impl fmt::Display for Verdict {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Confirmed => "confirmed",
            Self::Failed => "failed",
            Self::Reported => "reported",
        })
    }
}

/// A line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: &'static str,
    /// The scheme or method.
    pub of: String,
    /// What theory says.
    pub expected: String,
    /// What was measured.
    pub found: String,
    /// How they compare.
    pub verdict: Verdict,
}

impl Finding {
    /// The heads of the columns.
    pub const HEADS: [&str; 5] = ["What", "Scheme or method", "Expected", "Found", "Verdict"];

    /// The cells of the columns.
    pub fn cells(&self) -> [String; 5] {
        let Finding { what, of, expected, found, verdict } = self;
        [(*what).to_owned(), of.clone(), expected.clone(), found.clone(), verdict.to_string()]
    }
}

/// All findings about what was measured.
pub fn all(measured: &Measured) -> Vec<Finding> {
    let mut findings = orders(&measured.convergence);
    findings.extend(exactness(&measured.exactness));
    findings.extend(methods(measured));
    findings
}

/// The orders of J, then those of the gradient.
fn orders(all: &[Convergence]) -> Vec<Finding> {
    let finding = |what, scheme: &Convergence, found: Option<f64>| {
        let smooth = scheme.reading == Reading::Piece;
        let promised = scheme.order as f64;
        let near = found.is_some_and(|found| (found - promised).abs() <= SHARE * promised);
        Finding {
            what,
            of: scheme.label(),
            expected: if smooth { promised.to_string() } else { format!("less than {promised}: kinks inside macro steps") },
            found: found.map_or("no two runs above rounding".to_owned(), |found| format!("{found:.2}")),
            verdict: match smooth {
                false => Verdict::Reported,
                true if near => Verdict::Confirmed,
                true => Verdict::Failed,
            },
        }
    };
    let by_pieces = all.iter().filter(|scheme| scheme.reading == Reading::Piece);
    let costs = by_pieces.map(|scheme| finding("order of J", scheme, scheme.order_of_cost));
    let gradients = all.iter().map(|scheme| finding("order of dJ/d(101 knots)", scheme, scheme.order_of_gradient));
    costs.chain(gradients).collect()
}

/// The worst differences of each scheme.
fn exactness(all: &[Exactness]) -> Vec<Finding> {
    let of_one_scheme = |grids: &[Exactness]| {
        let worst = |difference: fn(&Exactness) -> f64| largest(&grids.iter().map(difference).collect::<Vec<_>>());
        let (controls, steps) = (worst(|grid| grid.controls), worst(|grid| grid.steps));
        let counts: Vec<String> = grids.iter().map(|grid| grid.macro_steps.to_string()).collect();
        Finding {
            what: "adjoint against complex step, worst grid",
            of: format!("{}, N = {}", grids[0].scheme, counts.join(", ")),
            expected: format!("≤ {ROUNDING:.0e}"),
            found: format!("dJ/du {controls:.1e}, dJ/dΔt {steps:.1e}"),
            verdict: exact(largest(&[controls, steps])),
        }
    };
    all.chunk_by(|a, b| a.scheme == b.scheme).map(of_one_scheme).collect()
}

/// The errors of the methods and their costs.
fn methods(measured: &Measured) -> Vec<Finding> {
    let what = "dJ/du at 101 nodes, against 128-bit floats";
    let exacts = measured.methods.exact.iter().map(|method| Finding {
        what,
        of: method.name.to_owned(),
        expected: format!("≤ {ROUNDING:.0e}"),
        found: format!("{:.1e}, in the time of {} simulations", method.error, cost(method.cost)),
        verdict: exact(method.error),
    });
    let stepped = measured.methods.stepped.iter().map(|method| {
        let (size, error) = method.best();
        Finding {
            what,
            of: method.name.to_owned(),
            expected: "depends on the step".to_owned(),
            found: format!("{error:.1e} at best, with {size:.0e} N, in the time of {} simulations", cost(method.cost)),
            verdict: Verdict::Reported,
        }
    });
    exacts.chain(stepped).collect()
}

/// The number in about three digits.
fn cost(simulations: f64) -> String {
    if simulations < 10.0 { format!("{simulations:.2}") } else { format!("{simulations:.0}") }
}

/// Whether a relative difference is only rounding.
fn exact(difference: f64) -> Verdict {
    if difference <= ROUNDING { Verdict::Confirmed } else { Verdict::Failed }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hamiltonian_adjoint::Composition;

    /// Orders as they would be found.
    fn scheme(reading: Reading, order: Option<f64>) -> Convergence {
        let mut scheme = Convergence::new(Composition::Suzuki4, reading, Vec::new());
        (scheme.order_of_cost, scheme.order_of_gradient) = (order, order);
        scheme
    }

    #[test]
    fn an_order_must_be_found_and_be_the_promised_one_unless_the_control_has_kinks_inside_macro_steps() {
        let verdicts = |reading, order| orders(&[scheme(reading, order)]).iter().map(|it| it.verdict).collect::<Vec<_>>();
        assert_eq!(verdicts(Reading::Piece, Some(3.9)), [Verdict::Confirmed; 2]);
        assert_eq!(verdicts(Reading::Piece, Some(3.7)), [Verdict::Failed; 2]);
        assert_eq!(verdicts(Reading::Piece, Some(f64::NAN)), [Verdict::Failed; 2]);
        assert_eq!(verdicts(Reading::Piece, None), [Verdict::Failed; 2]);
        assert_eq!(verdicts(Reading::Time, Some(2.0)), [Verdict::Reported]);
    }

    #[test]
    fn the_worst_grid_of_a_scheme_decides() {
        let grid = |macro_steps, steps| Exactness { scheme: "a", macro_steps, stages: 1, controls: 1e-14, steps };
        let verdict = |grids: &[Exactness]| exactness(grids)[0].verdict;
        assert_eq!(verdict(&[grid(25, 1e-13), grid(50, 1e-13)]), Verdict::Confirmed);
        assert_eq!(verdict(&[grid(25, 1e-11), grid(50, 1e-13)]), Verdict::Failed);
        assert_eq!(verdict(&[grid(25, f64::NAN)]), Verdict::Failed);
    }
}
