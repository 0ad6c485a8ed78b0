//! A row of the report: the trial, the measured numbers with their bounds, and the verdict.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use hamiltonian_adjoint::{Error, Warning};
use serde::Serialize;
use serde_json::json;

use crate::table::{Row, Verdict};

/// A number and its bounds, `None` if it is only reported.
#[derive(Clone, Debug, Serialize)]
pub struct Measure {
    what: String,
    value: f64,
    least: Option<f64>,
    most: Option<f64>,
}

impl Measure {
    pub fn at_most(what: impl Into<String>, value: f64, most: f64) -> Self {
        Measure { what: what.into(), value, least: None, most: Some(most) }
    }

    pub fn between(what: impl Into<String>, value: f64, (least, most): (f64, f64)) -> Self {
        Measure { what: what.into(), value, least: Some(least), most: Some(most) }
    }

    pub fn at_least(what: impl Into<String>, value: f64, least: f64) -> Self {
        Measure { what: what.into(), value, least: Some(least), most: None }
    }

    /// Without bounds.
    pub fn reported(what: impl Into<String>, value: f64) -> Self {
        Measure { what: what.into(), value, least: None, most: None }
    }

    fn is_judged(&self) -> bool {
        self.least.is_some() || self.most.is_some()
    }

    /// True if the value is within the bounds; false for NaN.
    fn holds(&self) -> bool {
        let above = self.least.is_none_or(|least| self.value >= least);
        !self.is_judged() || (above && self.most.is_none_or(|most| self.value <= most))
    }

    fn expected(&self) -> Option<String> {
        let what = &self.what;
        match (self.least, self.most) {
            (Some(least), Some(most)) => Some(format!("{what} in {least:?} … {most:?}")),
            (None, Some(most)) if most >= 0.1 => Some(format!("{what} ≤ {most:?}")),
            (None, Some(most)) => Some(format!("{what} ≤ {most:.0e}")),
            (Some(least), None) => Some(format!("{what} ≥ {least:?}")),
            (None, None) => None,
        }
    }

    fn got(&self) -> String {
        let large = self.least.is_some() || self.most.is_some_and(|most| most >= 0.01);
        let plain = large && (0.01..1e4).contains(&self.value.abs());
        if plain { format!("{} {:.2}", self.what, self.value) } else { format!("{} {:.1e}", self.what, self.value) }
    }
}

/// Quantity that a curve of a figure shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    Energy,
    Drift,
    Gradient,
}

/// A curve for the figures: errors over time (s), or over the step length (s).
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    pub of: Quantity,
    pub over_time: bool,
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// Result of a trial and warnings of the report; if an error stopped it, the curves up to that point.
#[derive(Default)]
pub struct Found {
    pub measures: Vec<Measure>,
    pub curves: Vec<Curve>,
    pub warnings: Vec<Warning>,
    pub stopped: Option<Error>,
}

impl From<Vec<Measure>> for Found {
    fn from(measures: Vec<Measure>) -> Self {
        Found { measures, ..Found::default() }
    }
}

/// Errors that are an acceptable result, with the reason.
struct Refusal {
    why: &'static str,
    is: Box<dyn Fn(&Error) -> bool>,
    /// True if only this error is acceptable.
    must: bool,
}

/// True if a warning is an acceptable result.
type Warns = fn(&Warning) -> bool;

/// One trial of the report.
pub struct Trial {
    group: &'static str,
    tried: String,
    refusal: Option<Refusal>,
    /// Warnings that are an acceptable result if numbers exceed their bounds, with the reason.
    warning: Option<(&'static str, Warns)>,
    run: Box<dyn Fn() -> Result<Found, Error>>,
}

impl Trial {
    /// A trial that judges the result of `run`: measures alone, or with curves for the figures ([`Found`]).
    pub fn new<F: Into<Found>>(tried: impl Into<String>, run: impl Fn() -> Result<F, Error> + 'static) -> Self {
        Trial { group: "", tried: tried.into(), refusal: None, warning: None, run: Box::new(move || run().map(F::into)) }
    }

    /// Such an error of the library is also acceptable, for the given reason.
    pub fn or_refused(self, why: &'static str, is: impl Fn(&Error) -> bool + 'static) -> Self {
        Trial { refusal: Some(Refusal { why, is: Box::new(is), must: false }), ..self }
    }

    /// Only such an error of the library is acceptable, for the given reason.
    pub fn must_refuse(self, why: &'static str, is: impl Fn(&Error) -> bool + 'static) -> Self {
        Trial { refusal: Some(Refusal { why, is: Box::new(is), must: true }), ..self }
    }

    /// If bounds are exceeded, such a warning in the library's report is also acceptable, for the given reason.
    pub fn or_warned(self, why: &'static str, is: Warns) -> Self {
        Trial { warning: Some((why, is)), ..self }
    }

    pub fn of_group(self, group: &'static str) -> Self {
        Trial { group, ..self }
    }

    /// Group and name of the trial.
    pub fn name(&self) -> String {
        format!("{}: {}", self.group, self.tried)
    }

    /// Runs the trial. A panic is caught: this row fails, the report continues.
    pub fn judge(&self) -> (Row, Vec<Curve>) {
        let start = Instant::now();
        let stopped_by = |error| Found { stopped: Some(error), ..Found::default() };
        let found = catch_unwind(AssertUnwindSafe(|| (self.run)().unwrap_or_else(stopped_by)));
        let seconds = start.elapsed().as_secs_f64();
        let (expected, got, verdict) = match &found {
            Ok(Found { stopped: Some(error), .. }) => self.stopped(error),
            Ok(Found { measures, warnings, .. }) => self.measured(measures, warnings),
            Err(_) => ("no panic".to_owned(), "a panic".to_owned(), Verdict::Failed),
        };
        let Found { measures, curves, stopped, .. } = found.unwrap_or_default();
        let measures = if stopped.is_none() { measures } else { Vec::new() };
        let more = vec![("measures", json!(measures)), ("seconds", json!(seconds))];
        (Row { more, ..Row::new(self.group, &self.tried, self.expected(expected), got, verdict) }, curves)
    }

    /// The expected and the measured numbers, and the verdict.
    fn measured(&self, measures: &[Measure], warnings: &[Warning]) -> (String, String, Verdict) {
        let expected: Vec<String> = measures.iter().filter_map(Measure::expected).collect();
        let got = measures.iter().map(Measure::got).collect::<Vec<_>>().join(", ");
        let must_refuse = self.refusal.as_ref().is_some_and(|refusal| refusal.must);
        let holds = !must_refuse && measures.iter().any(Measure::is_judged) && measures.iter().all(Measure::holds);
        let warning = warnings.iter().find(|warning| self.warning.is_some_and(|(_, is)| is(warning)));
        let (got, verdict) = match warning {
            _ if holds => (got, Verdict::Holds),
            Some(warning) => (format!("{got}; {warning}"), Verdict::Warned),
            None => (got, Verdict::Failed),
        };
        (expected.join(", "), got, verdict)
    }

    /// The expected and the actual result, and the verdict, of a trial that an error stopped.
    fn stopped(&self, error: &Error) -> (String, String, Verdict) {
        match &self.refusal {
            Some(refusal) if (refusal.is)(error) => (String::new(), error.to_string(), Verdict::Refused),
            _ => ("no error".to_owned(), error.to_string(), Verdict::Failed),
        }
    }

    /// The expected numbers, with the acceptable errors and warnings.
    fn expected(&self, measured: String) -> String {
        let expected = match &self.refusal {
            Some(Refusal { why, must, .. }) if *must || measured.is_empty() => return format!("an error: {why}"),
            Some(Refusal { why, .. }) => format!("{measured}; or an error: {why}"),
            None => measured,
        };
        match &self.warning {
            Some((why, _)) => format!("{expected}; or a warning: {why}"),
            None => expected,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(trial: Trial) -> Verdict {
        trial.judge().0.verdict
    }

    fn with(measures: &[Measure]) -> Trial {
        let measures = measures.to_vec();
        Trial::new("tried", move || Ok(measures.clone()))
    }

    #[test]
    fn a_number_out_of_bounds_fails_and_so_does_one_that_is_none() {
        assert_eq!(verdict(with(&[Measure::at_most("error", 1e-13, 1e-12)])), Verdict::Holds);
        assert_eq!(verdict(with(&[Measure::at_most("error", 1e-11, 1e-12)])), Verdict::Failed);
        assert_eq!(verdict(with(&[Measure::at_most("error", f64::NAN, 1e-12)])), Verdict::Failed);
        assert_eq!(verdict(with(&[Measure::between("order", 1.5, (1.9, 2.1))])), Verdict::Failed);
        assert_eq!(verdict(with(&[Measure::between("order", 2.05, (1.9, 2.1))])), Verdict::Holds);
        let told = Measure::reported("size", f64::INFINITY);
        assert_eq!(verdict(with(std::slice::from_ref(&told))), Verdict::Failed, "nothing was judged");
        assert_eq!(verdict(with(&[told, Measure::at_most("error", 0.0, 0.0)])), Verdict::Holds);
    }

    #[test]
    fn an_error_fails_unless_it_is_an_answer_and_a_panic_always() {
        let stops = || Trial::new("tried", || Err::<Found, _>(Error::EmptyScene));
        assert_eq!(verdict(stops()), Verdict::Failed);
        let row = stops().or_refused("nothing there", |_| true).judge().0;
        assert_eq!(row.verdict, Verdict::Refused);
        assert_eq!(row.cells[2..], ["an error: nothing there".to_owned(), Error::EmptyScene.to_string()]);
        let only = |is: fn(&Error) -> bool| stops().must_refuse("nothing there", is).judge().0.verdict;
        assert_eq!(only(|error| *error == Error::EmptyScene), Verdict::Refused);
        assert_eq!(only(|error| *error != Error::EmptyScene), Verdict::Failed, "another error");
        assert_eq!(verdict(with(&[Measure::at_most("error", 0.0, 0.1)]).must_refuse("why", |_| true)), Verdict::Failed);
        let out_of_range: Vec<f64> = Vec::new();
        let panics = Trial::new("tried", move || Ok(vec![Measure::reported("first", out_of_range[0])]));
        assert_eq!(verdict(panics.or_refused("any", |_| true)), Verdict::Failed);
    }

    #[test]
    fn what_is_out_of_bounds_may_be_told_by_a_warning_that_is_an_answer() {
        let growth = Warning::AdjointGrowth { factor: 1e9 };
        let trial = |value: f64, warnings: &[Warning]| {
            let warnings = warnings.to_vec();
            let found = move || Found {
                measures: vec![Measure::at_most("error", value, 1e-12)],
                warnings: warnings.clone(),
                ..Found::default()
            };
            Trial::new("tried", move || Ok(found()))
        };
        let is: fn(&Warning) -> bool = |warning| matches!(warning, Warning::AdjointGrowth { .. });
        assert_eq!(verdict(trial(1.0, std::slice::from_ref(&growth)).or_warned("it grows", is)), Verdict::Warned);
        assert_eq!(verdict(trial(0.0, std::slice::from_ref(&growth)).or_warned("it grows", is)), Verdict::Holds);
        assert_eq!(verdict(trial(1.0, &[]).or_warned("it grows", is)), Verdict::Failed, "nothing was said");
        assert_eq!(
            verdict(trial(1.0, std::slice::from_ref(&growth)).or_warned("else", |_| false)),
            Verdict::Failed,
            "not that"
        );
        assert_eq!(verdict(trial(1.0, &[growth])), Verdict::Failed, "no answer here");
    }
}
