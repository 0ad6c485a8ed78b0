//! The tables of the report: findings, exactness on each grid, times.

use super::convergence::{Convergence, Reading};
use super::exactness::Exactness;
use super::{Measured, findings, order};
use crate::table::{Row, aligned, bars};

/// The errors for which times are looked up.
const ERRORS: [f64; 5] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11];

/// A table in two forms, with its title.
pub struct Table {
    /// In aligned columns.
    pub text: String,
    /// In Markdown.
    pub markdown: String,
}

/// All tables.
pub fn all(measured: &Measured, findings: &[Row]) -> [Table; 3] {
    let findings = findings::rows(findings);
    let exactness: Vec<[String; 5]> = measured.exactness.iter().map(exactness).collect();
    let schemes: Vec<&Convergence> = measured.convergence.iter().filter(|it| it.reading == Reading::Piece).collect();
    let mut times = times("J", &schemes, Convergence::cost_over_time);
    times.extend(self::times("dJ/d(101 knots)", &schemes, Convergence::gradient_over_time));
    [
        titled("Orders and exactness", findings.text(), findings.markdown()),
        new("Adjoint against complex step", ["Scheme", "Macro steps", "Steps", "dJ/du", "dJ/dΔt"], &exactness),
        new("Times to relative errors, only reported", ["Of", "Error", "Fastest first"], &times),
    ]
}

fn new<const C: usize>(title: &str, heads: [&str; C], rows: &[[String; C]]) -> Table {
    titled(title, aligned(heads, rows), bars(heads, rows))
}

fn titled(title: &str, text: String, markdown: String) -> Table {
    Table { text: format!("{title}\n\n{text}"), markdown: format!("### {title}\n\n{markdown}") }
}

/// The row of a grid.
fn exactness(grid: &Exactness) -> [String; 5] {
    let difference = |value: f64| format!("{value:.1e}");
    [
        grid.scheme.to_owned(),
        grid.macro_steps.to_string(),
        (grid.macro_steps * grid.stages).to_string(),
        difference(grid.controls),
        difference(grid.steps),
    ]
}

/// For each error the times of the schemes, where they reach it.
fn times(of: &str, schemes: &[&Convergence], runs: fn(&Convergence) -> Vec<(f64, f64)>) -> Vec<[String; 3]> {
    let at = |error: f64| {
        let times = schemes.iter().filter_map(|it| Some((order::time_for(error, &runs(it))?, it.scheme)));
        let mut times: Vec<(f64, &str)> = times.collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let words: Vec<String> = times.iter().map(|(time, scheme)| format!("{scheme}: {:.2} ms", 1e3 * time)).collect();
        (!words.is_empty()).then(|| [of.to_owned(), format!("{error:.0e}"), words.join("; ")])
    };
    ERRORS.into_iter().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work_precision::convergence::Run;
    use hamiltonian_adjoint::Composition;

    #[test]
    fn the_fastest_comes_first_and_errors_out_of_reach_are_left_out() {
        let run = |cost_error, cost_time_s| Run {
            macro_steps: 25,
            cost_error,
            cost_time_s,
            gradient_error: None,
            gradient_time_s: None,
        };
        let slow = Convergence::new(Composition::Trapezoidal, Reading::Piece, vec![run(1e-2, 1.0), run(1e-4, 2.0)]);
        let fast = Convergence::new(Composition::Suzuki4, Reading::Piece, vec![run(1e-6, 0.25)]);
        let rows = times("J", &[&slow, &fast], Convergence::cost_over_time);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0][2], "Suzuki, order 4: 250.00 ms; trapezoidal rule: 1414.21 ms");
        assert_eq!(rows[1][1..], ["1e-5", "Suzuki, order 4: 250.00 ms"]);
        assert!(times("gradient", &[&slow, &fast], Convergence::gradient_over_time).is_empty());
    }
}
