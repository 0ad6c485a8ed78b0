//! Eq. (1)–(12) of the paper, as printed in our copy, compared with true derivatives: formulas that hold, misprints, and numerical evidence.

mod blocks;
mod equations;
pub mod mechanisms;

use hamiltonian_adjoint::Error;
use std::fmt;

use crate::table::{Table, Verdict};

/// One printed formula.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Equation and block.
    pub place: String,
    pub printed: String,
    pub status: Verdict,
    /// The correct formula; empty if the printed one is correct.
    pub corrected: String,
    pub errors: Errors,
    /// Description of the difference.
    pub words: String,
}

/// Relative errors on both mechanisms, as printed and as corrected; NaN where nothing can be evaluated.
type Errors = [[f64; 2]; 2];

impl Finding {
    fn new(place: &str, status: Verdict, printed: &str, corrected: &str, errors: Errors, words: &str) -> Self {
        let corrected = if status == Verdict::Holds { "" } else { corrected };
        let [place, printed, corrected, words] = [place, printed, corrected, words].map(str::to_owned);
        Finding { place, printed, status, corrected, errors, words }
    }
}

/// All findings, as text (`Display`) and as a page of the guide ([`Findings::markdown`]).
pub struct Findings {
    pub findings: Vec<Finding>,
}

/// Compares every printed formula with the true one.
pub fn report() -> Result<Findings, Error> {
    let (constant, variable) = (mechanisms::constant_mass()?, mechanisms::variable_mass()?);
    let both = [&constant, &variable];
    let mut findings = equations::of_motion(&both)?;
    findings.extend(equations::of_variation(&both)?);
    findings.extend(blocks::findings(&both)?);
    findings.extend(equations::of_gradient(&constant)?);
    Ok(Findings { findings })
}

const HEADING: &str = "Every formula is evaluated as printed in our copy (a text recognition of the proceedings, which may itself \
have caused some of the misprints) and as corrected, at random states near two motions, and compared with dual numbers, complex step and Ridders' \
differences of the residual f. A is a cart with two links and a damper (constant M), B a double pendulum in its angles with \
friction and a constraint (M depends on q). Errors are relative to the size of an entry's row and column.";

const COMMAND: &str = "cargo run --release -p paper-repro -- jacobians";

fn number(error: f64) -> String {
    match error {
        0.0 => "0".to_string(),
        error if error.is_nan() => "–".to_string(),
        error => format!("{error:.0e}"),
    }
}

impl Findings {
    fn count(&self, status: Verdict) -> usize {
        self.findings.iter().filter(|finding| finding.status == status).count()
    }

    /// True if every corrected formula that can be evaluated is right; (1b) compares two discretisations, which agree up to their error.
    pub fn all_corrected_hold(&self) -> bool {
        let right = |error: &f64| error.is_nan() || *error < 1e-5;
        self.findings.iter().flat_map(|finding| &finding.errors[1]).all(right)
    }

    fn summary(&self) -> String {
        let [holds, constant, wrong] =
            [Verdict::Holds, Verdict::HoldsForConstantMass, Verdict::Misprinted].map(|s| self.count(s));
        format!(
            "{} formulas: {holds} hold, {constant} hold for constant M only, {wrong} are misprinted.",
            self.findings.len()
        )
    }

    pub fn markdown(&self) -> String {
        let heads = vec![
            "formula",
            "printed",
            "verdict",
            "corrected",
            "error as printed A / B",
            "error corrected A / B",
            "the difference",
        ];
        let row = |finding: &Finding| {
            let Finding { place, printed, status, corrected, errors, words } = finding.clone();
            let [as_printed, as_corrected] = errors.map(|both| both.map(number).join(" / "));
            vec![place, printed, status.to_string(), corrected, as_printed, as_corrected, words]
        };
        let table = Table { heads, rows: self.findings.iter().map(row).collect() };
        format!(
            "# The paper's equations, formula by formula\n\n{HEADING}\n`{COMMAND}` writes this page.\n\n{}\n\n{}",
            self.summary(),
            table.markdown()
        )
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{HEADING}\n\n{}\n", self.summary())?;
        for finding in &self.findings {
            let Finding { place, printed, status, corrected, errors, words } = finding;
            writeln!(f, "{status:20}  {place:34}  {printed}")?;
            if *status == Verdict::Holds {
                continue;
            }
            let [[pa, pb], [ca, cb]] = errors.map(|both| both.map(number));
            writeln!(f, "{:22}should be: {corrected}", "")?;
            writeln!(f, "{:22}errors: printed {pa} (A), {pb} (B); corrected {ca} (A), {cb} (B)", "")?;
            if !words.is_empty() {
                writeln!(f, "{:22}{words}", "")?;
            }
        }
        Ok(())
    }
}

/// The size of a difference relative to the reference.
fn relative(difference: f64, reference: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference.abs() / reference.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corrected_formula_is_right() {
        let findings = report().expect("both mechanisms run");
        println!("{findings}");
        for finding in &findings.findings {
            for error in finding.errors[1].into_iter().filter(|e| !e.is_nan()) {
                // In the row of (1b), two discretisations of one motion differ by O(Δt²). The error of a block of (10) is set to infinity unless the
                // check finds every entry right; if terms cancel, rounding relative to the remaining entry has no fixed bound.
                let within = match finding.place.as_str() {
                    "(1b)" => 1e-5,
                    place if place.starts_with("(10)") => f64::INFINITY,
                    _ => 1e-12,
                };
                assert!(error < within, "{}: {error:.1e}", finding.place);
            }
        }
    }
}
