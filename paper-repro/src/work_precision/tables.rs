//! The tables of the report: findings, exactness on each grid, times.

use super::convergence::Convergence;
use super::exactness::Exactness;
use super::knots::Reading;
use super::tolerance::Tolerance;
use super::{Measured, findings, order};
use crate::table::{Row, Table};

/// The errors for which times are looked up.
const ERRORS: [f64; 5] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11];

/// All tables with their titles.
pub fn all(measured: &Measured, findings: &[Row]) -> [(&'static str, Table); 4] {
    let exactness = Table {
        heads: vec!["Scheme", "Macro steps", "Steps", "dJ/du", "dJ/dΔt"],
        rows: measured.exactness.iter().map(exactness).collect(),
    };
    let tolerances = Table {
        heads: vec!["Motion", "Scheme", "Tolerance", "Steps", "Error", "Uniform steps for this error"],
        rows: measured.tolerances.iter().map(Tolerance::cells).collect(),
    };
    let schemes: Vec<&Convergence> = measured.convergence.iter().filter(|it| it.reading == Reading::Piece).collect();
    let mut rows = times("J", &schemes, Convergence::cost_over_time);
    rows.extend(times("dJ/d(101 knots)", &schemes, Convergence::gradient_over_time));
    [
        ("Orders and exactness", findings::rows(findings).table()),
        ("Adjoint against complex step", exactness),
        ("Grids by tolerance, only reported", tolerances),
        ("Times to relative errors, only reported", Table { heads: vec!["Of", "Error", "Fastest first"], rows }),
    ]
}

fn exactness(grid: &Exactness) -> Vec<String> {
    let Exactness { scheme, macro_steps, stages, controls, steps } = grid;
    let all = macro_steps * stages;
    vec![scheme.to_string(), macro_steps.to_string(), all.to_string(), format!("{controls:.1e}"), format!("{steps:.1e}")]
}

/// For each error, the times of the schemes that reach it.
fn times(of: &str, schemes: &[&Convergence], runs: fn(&Convergence) -> Vec<(f64, f64)>) -> Vec<Vec<String>> {
    let at = |error: f64| {
        let times = schemes.iter().filter_map(|it| Some((order::time_for(error, &runs(it))?, it.scheme)));
        let mut times: Vec<(f64, &str)> = times.collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let words: Vec<String> = times.iter().map(|(time, scheme)| format!("{scheme}: {:.2} ms", 1e3 * time)).collect();
        (!words.is_empty()).then(|| vec![of.to_owned(), format!("{error:.0e}"), words.join("; ")])
    };
    ERRORS.into_iter().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work_precision::METHODS;
    use crate::work_precision::convergence::Run;

    #[test]
    fn the_fastest_comes_first_and_errors_out_of_reach_are_left_out() {
        let run = |cost_error, cost_time_s| Run {
            macro_steps: 25,
            cost_error,
            cost_time_s,
            gradient_error: None,
            gradient_time_s: None,
        };
        let slow = Convergence::new(&METHODS[0], Reading::Piece, vec![run(1e-2, 1.0), run(1e-4, 2.0)]);
        let fast = Convergence::new(&METHODS[1], Reading::Piece, vec![run(1e-6, 0.25)]);
        let rows = times("J", &[&slow, &fast], Convergence::cost_over_time);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0][2], "Suzuki, order 4: 250.00 ms; trapezoidal rule: 1414.21 ms");
        assert_eq!(rows[1][1..], ["1e-5", "Suzuki, order 4: 250.00 ms"]);
        assert!(times("gradient", &[&slow, &fast], Convergence::gradient_over_time).is_empty());
    }
}
