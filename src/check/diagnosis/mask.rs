//! Sets of entries of a block, and their names in texts.

use std::cmp::Ordering;
use std::fmt;

use super::evidence::{At, Evidence};
use crate::check::report::{Diagnosis, Mistake};

/// Factor on the tolerance when a guess is compared with the user's values.
const SLACK: f64 = 8.0;
/// Allowed error of a guess relative to itself, whatever the size of the entry.
const ROUNDING: f64 = 1e-13;

/// The rows of a block, or its columns.
#[derive(Clone, Copy)]
pub(super) enum Lines {
    Rows,
    Columns,
}

impl Lines {
    pub(super) const BOTH: [Lines; 2] = [Lines::Rows, Lines::Columns];

    pub(super) fn word(self) -> &'static str {
        ["row", "column"][self as usize]
    }

    pub(super) fn names<'e>(self, evidence: &Evidence<'e>) -> &'e [String] {
        [&evidence.block.rows, &evidence.block.columns][self as usize]
    }

    /// The row or column of an entry.
    pub(super) fn of(self, (i, j): At) -> usize {
        [i, j][self as usize]
    }

    /// The entry at the same position in another line.
    pub(super) fn entry_in(self, line: usize, (i, j): At) -> At {
        match self {
            Lines::Rows => (line, j),
            Lines::Columns => (i, line),
        }
    }
}

/// Some entries of a block.
pub(super) struct Mask<'e> {
    pub(super) of: &'e Evidence<'e>,
    pub(super) entries: Vec<At>,
}

impl<'e> Mask<'e> {
    pub(super) fn all(of: &'e Evidence) -> Self {
        Mask { of, entries: of.entries().collect() }
    }

    /// The entries for which a condition is true.
    pub(super) fn only(&self, is: impl Fn(&At) -> bool) -> Self {
        Mask { of: self.of, entries: self.entries.iter().copied().filter(is).collect() }
    }

    /// The entries that are wrong at some point.
    pub(super) fn wrong(of: &'e Evidence) -> Self {
        Mask::all(of).only(|&entry| (0..of.at.len()).any(|p| of.excess(p, entry) > 1.0))
    }

    /// One mask for each row, or column, that contains some of the entries.
    pub(super) fn by(&self, lines: Lines) -> Vec<Self> {
        let mut numbers: Vec<usize> = self.entries.iter().map(|&entry| lines.of(entry)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.into_iter().map(|k| self.only(|&entry| lines.of(entry) == k)).collect()
    }

    pub(super) fn singles(&self) -> Vec<Self> {
        self.entries.iter().map(|single| self.only(|entry| entry == single)).collect()
    }

    pub(super) fn truth(&self, p: usize, entry: At) -> f64 {
        self.of.at[p].truth[entry]
    }

    /// True if the user's values are the expected ones in these entries, at all points, and the expected ones differ from the true ones:
    /// a guess that equals the truth cannot explain an error that barely exceeds its tolerance.
    pub(super) fn explains(&self, expected: impl Fn(usize, At) -> f64) -> bool {
        let differs = |p: usize, &e: &At| {
            let error = (expected(p, e) - self.of.at[p].truth[e]).abs();
            error.is_nan() || error > self.of.at[p].tolerance[e]
        };
        let is_another = || (0..self.of.at.len()).any(|p| self.entries.iter().any(|entry| differs(p, entry)));
        self.holds(&expected) && is_another()
    }

    /// True if these are the true values in these entries, at all points.
    pub(super) fn are_true(&self, values: impl Fn(usize, At) -> f64) -> bool {
        let within = |p: usize, &e: &At| (values(p, e) - self.truth(p, e)).abs() <= SLACK * self.of.at[p].tolerance[e];
        (0..self.of.at.len()).all(|p| self.entries.iter().all(|entry| within(p, entry)))
    }

    /// True if the nonzero values of a term differ: any constant is a multiple of any other.
    pub(super) fn varies(&self, term: impl Fn(usize, At) -> f64) -> bool {
        let values = (0..self.of.at.len()).flat_map(|p| self.entries.iter().map(move |&e| (p, e)));
        let mut values = values.map(|(p, e)| term(p, e).abs()).filter(|x| *x > 0.0);
        values.next().is_some_and(|first| values.any(|x| (x / first - 1.0).abs() > 1e-3))
    }

    /// The sign with which the expected values explain the user's, if there is one.
    pub(super) fn up_to_sign(&self, expected: impl Fn(usize, At) -> f64) -> Option<f64> {
        [1.0, -1.0].into_iter().find(|sign| self.explains(|p, e| sign * expected(p, e)))
    }

    /// True if the user's values are the expected ones in these entries, at all points.
    pub(super) fn holds(&self, expected: impl Fn(usize, At) -> f64) -> bool {
        (0..self.of.at.len()).all(|p| self.holds_at(p, |e| expected(p, e)))
    }

    /// True if the user's values are the expected ones in these entries, at one point.
    pub(super) fn holds_at(&self, p: usize, expected: impl Fn(At) -> f64) -> bool {
        self.entries.iter().all(|&e| {
            let x = expected(e);
            // A multiple of the true value has a multiple of its rounding error, and the value of another entry has that entry's rounding error.
            let grown = (x / self.of.at[p].truth[e]).abs().max(1.0);
            let grown = if grown.is_finite() { grown } else { 1.0 };
            let within = (grown * self.of.at[p].tolerance[e]).max(ROUNDING * x.abs());
            x.is_finite() && (self.of.at[p].hand[e] - x).abs() <= SLACK * within
        })
    }

    /// The least-squares solution c of hand = base + c · term, in units of the entries' sizes; `None` if it does not fit.
    pub(super) fn multiple(&self, base: impl Fn(usize, At) -> f64, term: impl Fn(usize, At) -> f64) -> Option<f64> {
        let product = |a: &dyn Fn(usize, At) -> f64| {
            let one = |p: usize, &e: &At| {
                let size = self.of.at[p].scale[e].max(f64::MIN_POSITIVE);
                a(p, e) / size * (term(p, e) / size)
            };
            (0..self.of.at.len()).map(|p| self.entries.iter().map(|entry| one(p, entry)).sum::<f64>()).sum::<f64>()
        };
        let c = product(&|p, e| self.of.at[p].hand[e] - base(p, e)) / product(&term);
        (c.is_finite() && self.explains(|p, e| base(p, e) + c * term(p, e))).then_some(c)
    }

    /// Diagnosis with a text to which the place is added.
    pub(super) fn says(&self, mistake: Mistake, text: impl fmt::Display) -> Diagnosis {
        Diagnosis { mistake, text: format!("{text} {}", self.place()) }
    }

    /// Place of the entries for the end of a sentence: "in the whole block", "in the row of …", "in d(…)/d(…)".
    pub(super) fn place(&self) -> String {
        let (rows, columns) = (&self.of.block.rows, &self.of.block.columns);
        if self.entries.len() == rows.len() * columns.len() {
            return "in the whole block".into();
        }
        if let [(i, j)] = self.entries[..] {
            return format!("in d({})/d({})", rows[i], columns[j]);
        }
        for lines in Lines::BOTH {
            if let [line] = &self.by(lines)[..] {
                return format!("in the {} of {}", lines.word(), lines.names(self.of)[lines.of(line.entries[0])]);
            }
        }
        let sides = [("on", Ordering::Equal), ("below", Ordering::Greater), ("above", Ordering::Less)];
        match sides.iter().find(|(_, side)| self.entries.iter().all(|(i, j)| i.cmp(j) == *side)) {
            Some((side, _)) => format!("{side} the diagonal"),
            None => format!("in {} of the {} entries", self.entries.len(), rows.len() * columns.len()),
        }
    }
}
