//! Comparison of the user's gradient with that of the library, which has been checked before.

use super::Part;
use super::subject::Subject;
use crate::check::Input;
use crate::check::report::{BlockReport, Diagnosis, Entry, Mistake, Verdict};
use crate::{Error, Gradient, Inputs};

/// Maximum number of wrong entries that are listed.
const LISTED: usize = 4;

/// The user's numbers for one part of the inputs.
pub(super) struct Own {
    name: String,
    pub part: Part,
    values: Vec<f64>,
}

impl Own {
    pub(super) fn new(name: &str, part: Part, values: impl IntoIterator<Item = f64>) -> Self {
        Own { name: name.to_string(), part, values: values.into_iter().collect() }
    }

    /// Compares number by number, relative to the largest in units of the inputs' sizes, times `raised` if the gradient is only rounding.
    ///
    /// The true values are those of the library, if they are confirmed.
    ///
    /// A design variable near zero gives no scale: if its derivative `is_known` to all digits, the error is relative to the derivative.
    pub(super) fn compare(
        &self,
        &Subject { system, inputs, .. }: &Subject,
        sizes: &Inputs,
        what: &str,
        truth: Option<&Gradient>,
        (tolerance, raised): (f64, f64),
        mut is_known: impl FnMut(Input) -> Result<bool, Error>,
    ) -> Result<BlockReport, Error> {
        let (hand, part) = (&self.values, self.part);
        let all = part.inputs(inputs);
        let name = format!("{} (own {what}, {})", self.name, part.name());
        let mut report =
            BlockReport { name, size: (1, all.len()), points: 1, tolerance, allowed: tolerance, ..BlockReport::default() };
        let Some(gradient) = truth else {
            let note = format!("the library's {what} is not confirmed here, so there is nothing to compare with");
            return Ok(BlockReport { notes: vec![note], ..report });
        };
        let truth: Vec<f64> = all.iter().map(|input| input.in_gradient(gradient)).collect();
        if hand.len() != truth.len() {
            let text = format!("{} numbers instead of {}", hand.len(), truth.len());
            let diagnoses = vec![Diagnosis { mistake: Mistake::Shape, text }];
            return Ok(BlockReport { verdict: Verdict::Wrong, diagnoses, ..report });
        }
        if truth.is_empty() {
            let note = "there are no such inputs: nothing was compared".into();
            return Ok(BlockReport { notes: vec![note], ..report });
        }
        let units = units(sizes, part);
        let largest = truth.iter().zip(&units).fold(0.0f64, |most, (g, unit)| most.max((g * unit).abs()));
        // NaN counts as infinitely wrong.
        let error = |j: usize| if hand[j].is_nan() { f64::INFINITY } else { (hand[j] - truth[j]).abs() };
        let mut scale: Vec<f64> = units.iter().map(|unit| raised * largest / unit).collect();
        for (j, scale) in scale.iter_mut().enumerate().filter(|_| part == Part::Design) {
            let own = truth[j].abs();
            if error(j) > tolerance * own && error(j) <= tolerance * *scale && is_known(all[j])? {
                *scale = own;
            }
        }
        let within: Vec<f64> = scale.iter().map(|scale| tolerance * scale).collect();
        let mut wrong: Vec<usize> = (0..truth.len()).filter(|&j| error(j) > within[j]).collect();
        report.absolute_error = (0..truth.len()).map(error).fold(0.0, f64::max);
        let relative = |j: usize| if error(j) == 0.0 { 0.0 } else { error(j) / scale[j] };
        report.relative_error = (0..truth.len()).map(relative).fold(0.0, f64::max);
        report.wrong_entries = wrong.len();
        report.verdict = if wrong.is_empty() { Verdict::Right } else { Verdict::Wrong };
        if !wrong.is_empty() {
            let names: Vec<String> = all.iter().map(|input| input.name(system)).collect();
            let (steps, channels) = (&inputs.grid.steps, part.channels(inputs).unwrap_or(0));
            let errors = (within.as_slice(), report.relative_error);
            report.diagnoses.push(diagnose(hand, &truth, &wrong, &names, (steps, channels), errors));
            wrong.sort_by(|&a, &b| relative(b).total_cmp(&relative(a)));
            let entry = |&j: &usize| {
                let (row, column, hand, truth, allowed) = ("J".into(), names[j].clone(), hand[j], truth[j], within[j]);
                Entry { row, column, hand, truth, allowed, point: 0, at: Vec::new() }
            };
            report.entries = wrong.iter().take(LISTED).map(entry).collect();
        }
        Ok(report)
    }
}

/// Units in which entries are compared: the sizes of their inputs, or the largest size in the channel.
fn units(sizes: &Inputs, part: Part) -> Vec<f64> {
    let own = part.of(sizes);
    let Some(channels) = part.channels(sizes) else { return own.to_vec() };
    let largest = |k: usize| own.iter().skip(k).step_by(channels).copied().fold(0.0, f64::max);
    let largest: Vec<f64> = (0..channels).map(largest).collect();
    (0..own.len()).map(|j| largest[j % channels]).collect()
}

/// Diagnosis of wrong numbers; `channels` is the number of values at each node (0 if not a series), `worst` the largest relative error.
fn diagnose(
    hand: &[f64],
    truth: &[f64],
    wrong: &[usize],
    names: &[String],
    (steps, channels): (&[f64], usize),
    (within, worst): (&[f64], f64),
) -> Diagnosis {
    let count = truth.len();
    let is = |expected: &dyn Fn(usize) -> f64| (0..count).all(|j| (hand[j] - expected(j)).abs() <= 8.0 * within[j]);
    let says = |mistake, text: String| Diagnosis { mistake, text };
    let dt = steps.first().copied().unwrap_or(1.0);
    if hand.iter().any(|x| !x.is_finite()) {
        return says(Mistake::NotFinite, "infinite or not a number".into());
    }
    if is(&|j| -truth[j]) {
        return says(Mistake::SignFlipped, "sign flipped in all entries".into());
    }
    let factors = [
        (dt, "Δt: J as in Eq. (5) has none, see Eq. (11)"),
        (1.0 / dt, "1/Δt"),
        (2.0, "2"),
        (0.5, "½"),
        (0.5 * dt, "Δt/2"),
        (2.0 / dt, "γ"),
    ];
    for (factor, name) in factors.into_iter().flat_map(|(x, name)| [(x, name.to_string()), (-x, format!("−({name})"))]) {
        if is(&|j| factor * truth[j]) {
            return says(Mistake::Factor, format!("constant factor {name}"));
        }
    }
    if wrong.iter().all(|&j| hand[j] == 0.0) {
        let list: Vec<&str> = wrong.iter().take(3).map(|&j| names[j].as_str()).collect();
        let more = if wrong.len() > 3 { " …" } else { "" };
        return says(Mistake::Zero, format!("zero where it should not be: {}{more}", list.join(", ")));
    }
    if let [one] = wrong {
        return says(Mistake::Unexplained, format!("only the derivative by {} is wrong", names[*one]));
    }
    let is_end = |&j: &usize| j < channels || j + channels >= count;
    if count > 2 * channels && wrong.iter().all(is_end) {
        return says(
            Mistake::Unexplained,
            "only the ends of the motion are wrong: check how the sweep starts and ends".into(),
        );
    }
    // Tried after simpler mistakes: if neighbours are equal, shifted values are equal, too.
    let shifted = |by: usize, back: bool| {
        let from = |j: usize| if back { j.checked_sub(by) } else { Some(j + by).filter(|&k| k < count) };
        (0..count).filter_map(|j| from(j).map(|k| (j, k))).all(|(j, k)| (hand[j] - truth[k]).abs() <= 8.0 * within[j])
    };
    let moved = [
        (1, "one", "entry j holds the derivative of input j"),
        (channels, "a node", "node i has the derivatives of node i"),
    ];
    let ways = moved.into_iter().filter(|(by, ..)| *by > 0 && count > 2 * by).flat_map(|way| [(way, true), (way, false)]);
    if let Some(((_, what, which), back)) = ways.into_iter().find(|&((by, ..), back)| shifted(by, back)) {
        let sign = if back { "−" } else { "+" };
        return says(Mistake::OtherArgument, format!("moved by {what}: {which} {sign} 1"));
    }
    if worst < 1e-3 {
        let digits = (-worst.log10()).floor();
        return says(Mistake::FewDigits, format!("right to {digits:.0} digits only: differences, or loose tolerances"));
    }
    says(Mistake::Unexplained, format!("no simple explanation; {} of {count} are wrong", wrong.len()))
}
