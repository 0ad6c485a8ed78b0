//! Sets of entries of a block, and how people call them.

use std::cmp::Ordering;
use std::fmt;

use super::Evidence;
use crate::check::report::{Diagnosis, Mistake};

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

    /// The line in which an entry stands.
    pub(super) fn of(self, (i, j): (usize, usize)) -> usize {
        [i, j][self as usize]
    }

    /// The entry that stands in another line at the same place.
    pub(super) fn entry_in(self, line: usize, (i, j): (usize, usize)) -> (usize, usize) {
        match self {
            Lines::Rows => (line, j),
            Lines::Columns => (i, line),
        }
    }
}

/// Some entries of a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mask {
    pub(super) entries: Vec<(usize, usize)>,
}

impl Mask {
    pub(super) fn all(evidence: &Evidence) -> Self {
        let columns = evidence.columns();
        Mask { entries: (0..evidence.rows()).flat_map(|i| (0..columns).map(move |j| (i, j))).collect() }
    }

    /// The entries that are wrong at some point.
    pub(super) fn wrong(evidence: &Evidence) -> Self {
        let is_wrong = |&entry: &(usize, usize)| (0..evidence.at.len()).any(|p| evidence.excess(p, entry) > 1.0);
        Mask { entries: Mask::all(evidence).entries.into_iter().filter(is_wrong).collect() }
    }

    /// One for each row, or column, that it has entries of.
    pub(super) fn by(&self, lines: Lines) -> Vec<Mask> {
        let mut numbers: Vec<usize> = self.entries.iter().map(|&entry| lines.of(entry)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let one = |k| Mask { entries: self.entries.iter().copied().filter(|&entry| lines.of(entry) == k).collect() };
        numbers.into_iter().map(one).collect()
    }

    pub(super) fn singles(&self) -> Vec<Mask> {
        self.entries.iter().map(|&e| Mask { entries: vec![e] }).collect()
    }

    /// The text and where that is.
    pub(super) fn says(&self, evidence: &Evidence, mistake: Mistake, text: impl fmt::Display) -> Diagnosis {
        Diagnosis { mistake, text: format!("{text} {}", self.place(evidence)) }
    }

    /// "in the whole block", "in row …", "in the entry …": for the end of a sentence.
    pub(super) fn place(&self, evidence: &Evidence) -> String {
        let (rows, columns) = (&evidence.block.rows, &evidence.block.columns);
        if self.entries.len() == evidence.rows() * evidence.columns() {
            return "in the whole block".into();
        }
        if let [(i, j)] = self.entries[..] {
            return format!("in d({})/d({})", rows[i], columns[j]);
        }
        for lines in Lines::BOTH {
            if let [line] = &self.by(lines)[..] {
                return format!("in the {} of {}", lines.word(), lines.names(evidence)[lines.of(line.entries[0])]);
            }
        }
        let sides = [("on", Ordering::Equal), ("below", Ordering::Greater), ("above", Ordering::Less)];
        match sides.iter().find(|(_, side)| self.entries.iter().all(|(i, j)| i.cmp(j) == *side)) {
            Some((side, _)) => format!("{side} the diagonal"),
            None => format!("in {} of the {} entries", self.entries.len(), evidence.rows() * evidence.columns()),
        }
    }
}
