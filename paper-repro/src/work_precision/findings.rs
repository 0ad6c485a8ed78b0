//! What was expected, what was found, and whether that will do; times are never judged.

use std::fmt;

use serde::Serialize;

use super::Measured;
use super::convergence::{Convergence, Reading};
use super::exactness::Exactness;
use super::order;

/// Relative differences up to this are rounding.
const ROUNDING: f64 = 1e-12;
/// How far an observed order may be from the promised one, as a share of that.
const SHARE: f64 = 0.05;
/// The errors for which the fastest scheme is looked for.
const ERRORS: [f64; 5] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11];

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
    findings.extend(fastest("fastest for J", &measured.convergence, Convergence::cost_over_time));
    findings.extend(fastest("fastest for the gradient", &measured.convergence, Convergence::gradient_over_time));
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
        let worst = |difference: fn(&Exactness) -> f64| grids.iter().map(difference).fold(0.0, f64::max);
        let (controls, steps) = (worst(|grid| grid.controls), worst(|grid| grid.steps));
        let counts: Vec<String> = grids.iter().map(|grid| grid.macro_steps.to_string()).collect();
        Finding {
            what: "adjoint against complex step",
            of: format!("{}, N = {}", grids[0].scheme, counts.join(", ")),
            expected: format!("≤ {ROUNDING:.0e}"),
            found: format!("dJ/du {controls:.1e}, dJ/dΔt {steps:.1e}"),
            verdict: exact(controls.max(steps)),
        }
    };
    all.chunk_by(|a, b| a.scheme == b.scheme).map(of_one_scheme).collect()
}

/// The errors of the methods and their costs.
fn methods(measured: &Measured) -> Vec<Finding> {
    let what = "gradient of the scheme, N = 100";
    let exacts = measured.methods.exact.iter().map(|method| Finding {
        what,
        of: method.name.to_owned(),
        expected: format!("≤ {ROUNDING:.0e}"),
        found: format!("{:.1e}, in the time of {:.3} simulations", method.error, method.cost),
        verdict: exact(method.error),
    });
    let stepped = measured.methods.stepped.iter().map(|method| {
        let (size, error) = method.best();
        Finding {
            what,
            of: method.name.to_owned(),
            expected: "depends on the step".to_owned(),
            found: format!("{error:.1e} at best, with {size:.0e} N, in the time of {:.0} simulations", method.cost),
            verdict: Verdict::Reported,
        }
    });
    exacts.chain(stepped).collect()
}

/// The scheme that reaches each error first.
fn fastest(what: &'static str, all: &[Convergence], runs: fn(&Convergence) -> Vec<(f64, f64)>) -> Vec<Finding> {
    let sound: Vec<&Convergence> = all.iter().filter(|scheme| scheme.reading == Reading::Piece).collect();
    let at = |error: f64| {
        let times = sound.iter().filter_map(|scheme| Some((order::time_for(error, &runs(scheme))?, scheme.label())));
        let mut times: Vec<(f64, String)> = times.collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let words = times.iter().map(|(time, scheme)| format!("{scheme} {:.3} ms", 1e3 * time));
        (!times.is_empty()).then(|| Finding {
            what,
            of: format!("relative error of {error:.0e}"),
            expected: "times are not judged".to_owned(),
            found: words.collect::<Vec<_>>().join(", "),
            verdict: Verdict::Reported,
        })
    };
    ERRORS.into_iter().filter_map(at).collect()
}

/// Whether a relative difference is only rounding.
fn exact(difference: f64) -> Verdict {
    if difference <= ROUNDING { Verdict::Confirmed } else { Verdict::Failed }
}
