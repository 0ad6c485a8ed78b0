//! Expected and actual results with verdicts; times are never judged.

use super::Measured;
use super::convergence::Convergence;
use super::exactness::Exactness;
use super::knots::Reading;
use crate::statistics::largest;
use crate::table::{Row, Rows, Verdict};

/// Relative differences up to this are rounding.
const ROUNDING: f64 = 1e-12;
/// Permitted deviation of an observed order, relative to the theoretical one.
const SHARE: f64 = 0.05;

/// The rows of the table.
pub fn rows(rows: &[Row]) -> Rows<'_> {
    Rows { keys: ["what", "of", "expected", "found"], heads: ["What", "Scheme or method", "Expected", "Found"], rows }
}

/// All findings about the measurements.
pub fn all(measured: &Measured) -> Vec<Row> {
    let mut findings = orders(&measured.convergence);
    findings.extend(exactness(&measured.exactness));
    findings.extend(methods(measured));
    findings
}

/// The orders of J, then those of the gradient.
fn orders(all: &[Convergence]) -> Vec<Row> {
    let finding = |what, scheme: &Convergence, found: Option<f64>| {
        let smooth = scheme.reading == Reading::Piece;
        let promised = scheme.order as f64;
        let near = found.is_some_and(|found| (found - promised).abs() <= SHARE * promised);
        let (expected, verdict) = match smooth {
            false => (format!("less than {promised}: kinks inside macro steps"), Verdict::Reported),
            true => (promised.to_string(), if near { Verdict::Confirmed } else { Verdict::Failed }),
        };
        let found = found.map_or("fewer than two runs above rounding".to_owned(), |found| format!("{found:.2}"));
        Row::new(what, scheme.label(), expected, found, verdict)
    };
    let by_pieces = all.iter().filter(|scheme| scheme.reading == Reading::Piece);
    let costs = by_pieces.map(|scheme| finding("order of J", scheme, scheme.order_of_cost));
    let gradients = all.iter().map(|scheme| finding("order of dJ/d(101 knots)", scheme, scheme.order_of_gradient));
    costs.chain(gradients).collect()
}

/// The largest differences of each scheme.
fn exactness(all: &[Exactness]) -> Vec<Row> {
    let of_one_scheme = |grids: &[Exactness]| {
        let worst = |difference: fn(&Exactness) -> f64| largest(grids.iter().map(difference));
        let (controls, steps) = (worst(|grid| grid.controls), worst(|grid| grid.steps));
        let counts: Vec<String> = grids.iter().map(|grid| grid.macro_steps.to_string()).collect();
        let of = format!("{}, N = {}", grids[0].scheme, counts.join(", "));
        let found = format!("dJ/du {controls:.1e}, dJ/dΔt {steps:.1e}");
        let verdict = exact(largest([controls, steps]));
        Row::new("adjoint against complex step, worst grid", of, format!("≤ {ROUNDING:.0e}"), found, verdict)
    };
    all.chunk_by(|a, b| a.scheme == b.scheme).map(of_one_scheme).collect()
}

/// The errors and costs of the methods.
fn methods(measured: &Measured) -> Vec<Row> {
    let what = "dJ/du at 101 nodes, compared with 128-bit floats";
    let exacts = measured.methods.exact.iter().map(|method| {
        let found = format!("{:.1e}, in the time of {} simulations", method.error, cost(method.cost));
        Row::new(what, method.name, format!("≤ {ROUNDING:.0e}"), found, exact(method.error))
    });
    let stepped = measured.methods.stepped.iter().map(|method| {
        let (size, error) = method.best();
        let found = format!("{error:.1e} at best, with {size:.0e} N, in the time of {} simulations", cost(method.cost));
        Row::new(what, method.name, "depends on the step", found, Verdict::Reported)
    });
    exacts.chain(stepped).collect()
}

/// The number with about three digits.
fn cost(simulations: f64) -> String {
    if simulations < 10.0 { format!("{simulations:.2}") } else { format!("{simulations:.0}") }
}

/// Verdict on a relative difference: it must be a rounding error.
fn exact(difference: f64) -> Verdict {
    if difference <= ROUNDING { Verdict::Confirmed } else { Verdict::Failed }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work_precision::METHODS;

    /// Orders as if they had been observed.
    fn scheme(reading: Reading, order: Option<f64>) -> Convergence {
        let mut scheme = Convergence::new(&METHODS[1], reading, Vec::new());
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
