//! The rows of all reports: subject, expected result, actual result and verdict; as tables and as JSON.

use std::fmt;

use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

/// Comparison of the actual result with the expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Our result agrees with the paper.
    Reproduced,
    /// Our result is valid but differs from the paper's.
    Differs,
    /// The paper states no number to compare with.
    NotStated,
    /// The paper does not state this value; ours is an assumption.
    Assumed,
    Confirmed,
    Reported,
    /// All numbers are within their bounds; a formula is right.
    Holds,
    /// A formula is right on mechanisms with constant mass matrix only.
    HoldsForConstantMass,
    /// A formula is wrong as printed.
    Misprinted,
    /// The library returned a specific error, and this is an acceptable result.
    Refused,
    /// Numbers exceed their bounds, and the library's report contains the corresponding warning.
    Warned,
    Failed,
}

impl Verdict {
    /// `Reproduced` if our result agrees with the paper, else `Differs`.
    pub fn reproduced_if(same: bool) -> Self {
        if same { Self::Reproduced } else { Self::Differs }
    }

    /// The word in tables, and the word in JSON files.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Reproduced => ("reproduced", "reproduced"),
            Self::Differs => ("differs", "differs"),
            Self::NotStated => ("not stated", "not stated"),
            Self::Assumed => ("assumed", "assumed"),
            Self::Confirmed => ("confirmed", "confirmed"),
            Self::Reported => ("only reported", "reported"),
            Self::Holds => ("holds", "held"),
            Self::HoldsForConstantMass => ("holds for constant M", "held for constant M"),
            Self::Misprinted => ("MISPRINTED", "misprinted"),
            Self::Refused => ("refused with an error", "refused"),
            Self::Warned => ("warned", "told"),
            Self::Failed => ("FAILED", "failed"),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(self.words().0)
    }
}

/// A line of a report.
#[derive(Clone, Debug)]
pub struct Row {
    /// Group, subject, expected result and actual result.
    pub cells: [String; 4],
    pub verdict: Verdict,
    /// Further entries of the JSON object.
    pub more: Vec<(&'static str, Value)>,
}

impl Row {
    /// A row with group, subject, expected result, actual result and verdict.
    pub fn new(
        of: &str,
        what: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        verdict: Verdict,
    ) -> Self {
        Row { cells: [of.into(), what.into(), expected.into(), found.into()], verdict, more: Vec::new() }
    }
}

/// Rows with the names of their cells, in JSON and in the heading of a table.
pub struct Rows<'a> {
    pub keys: [&'static str; 4],
    pub heads: [&'static str; 4],
    pub rows: &'a [Row],
}

impl Rows<'_> {
    pub fn table(&self) -> Table {
        let heads = [&self.heads[..], &["Verdict"]].concat();
        let words = |row: &Row| [&row.cells[..], &[row.verdict.to_string()]].concat();
        Table { heads, rows: self.rows.iter().map(words).collect() }
    }

    /// Number of rows with this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|row| row.verdict == verdict).count()
    }
}

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let object = |row: &Row| -> Map<String, Value> {
            let cells = self.keys.iter().copied().zip(row.cells.iter().cloned().map(Value::from));
            let verdict = ("verdict", Value::from(row.verdict.words().1));
            let more = row.more.iter().cloned();
            cells.chain([verdict]).chain(more).map(|(key, value)| (key.to_owned(), value)).collect()
        };
        out.collect_seq(self.rows.iter().map(object))
    }
}

/// Cells in rows and columns.
pub struct Table {
    pub heads: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
}

/// Characters per line of a text.
const LINE: usize = 120;
/// Separator between the columns of a text.
const GAP: &str = "  ";
/// Joins two names; a line may break after it.
const DASH: char = '–';

impl Table {
    /// Aligned columns, wrapped to the line, with a rule where the first column changes.
    pub fn text(&self) -> String {
        let widths = self.widths();
        let rule = "─".repeat(widths.iter().sum::<usize>() + GAP.len() * (widths.len() - 1)) + "\n";
        let mut out = row(&self.heads, &widths);
        for (index, cells) in self.rows.iter().enumerate() {
            if index == 0 || self.rows[index - 1][0] != cells[0] {
                out += &rule;
            }
            out += &row(cells, &widths);
        }
        out
    }

    /// A table in Markdown: each cell on one line, with escaped bars.
    pub fn markdown(&self) -> String {
        let escaped = |cell: &str| cell.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|");
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let head = line(self.heads.iter().map(|&head| head.to_owned()).collect()) + &"|---".repeat(self.heads.len()) + "|\n";
        let rows = self.rows.iter().map(|cells| line(cells.iter().map(|cell| escaped(cell)).collect()));
        std::iter::once(head).chain(rows).collect()
    }

    /// Widths of the columns: the widest are narrowed until a row fits the line, first those wider than their longest words.
    fn widths(&self) -> Vec<usize> {
        let column = |c: usize, of: fn(&str) -> usize| {
            self.rows.iter().map(|cells| of(&cells[c])).fold(of(self.heads[c]), usize::max)
        };
        let mut widths: Vec<usize> = (0..self.heads.len()).map(|c| column(c, length)).collect();
        let words: Vec<usize> = (0..self.heads.len()).map(|c| column(c, longest_word)).collect();
        let room = LINE - GAP.len() * (widths.len() - 1);
        while widths.iter().sum::<usize>() > room {
            let widest = (0..widths.len()).max_by_key(|&c| (widths[c] > words[c], widths[c]));
            if let Some(c) = widest {
                widths[c] -= 1;
            }
        }
        widths
    }
}

/// One row, with as many lines as its longest cell needs.
fn row(cells: &[impl AsRef<str>], widths: &[usize]) -> String {
    let columns: Vec<Vec<String>> = cells.iter().zip(widths).map(|(cell, width)| wrapped(cell.as_ref(), *width)).collect();
    let height = columns.iter().map(Vec::len).max().unwrap_or(0);
    let line = |index: usize| {
        let cells = columns.iter().zip(widths).map(|(lines, width)| {
            let words = lines.get(index).map_or("", String::as_str);
            format!("{words:width$}")
        });
        cells.collect::<Vec<_>>().join(GAP).trim_end().to_owned() + "\n"
    };
    (0..height).map(line).collect()
}

/// The text wrapped to the width; only words longer than the width are broken.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (gap, word) in words(text) {
        if let Some(line) = lines.last_mut().filter(|line| length(line) + length(gap) + length(word) <= width) {
            line.push_str(gap);
            line.push_str(word);
            continue;
        }
        let letters: Vec<char> = word.chars().collect();
        lines.extend(letters.chunks(width.max(1)).map(|piece| piece.iter().collect::<String>()));
    }
    lines
}

/// The words, each with the separator before it; the first of two words joined by a dash includes the dash.
fn words(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let joined = |words| std::iter::once(" ").chain(std::iter::repeat("")).zip(words);
    text.split_whitespace().flat_map(move |words: &str| joined(words.split_inclusive(DASH)))
}

fn longest_word(text: &str) -> usize {
    words(text).map(|(_, word)| length(word)).max().unwrap_or(0)
}

/// Number of characters of the text; each is assumed to be one column wide.
fn length(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::rows;

    fn row(of: &str, what: &str) -> Row {
        Row::new(of, what, "9 | 10", "word ".repeat(40), Verdict::NotStated)
    }

    #[test]
    fn text_fits_the_line() {
        let table = rows(&[row("Fig. 3", &"x".repeat(150)), row("Fig. 4", "‖Φ‖ at the end")]).table().text();
        assert!(table.lines().all(|line| length(line) <= LINE), "{table}");
        assert_eq!(table.matches("word").count(), 80);
        assert_eq!(table.lines().filter(|line| line.starts_with('─')).count(), 2);
    }

    #[test]
    fn words_are_not_broken_where_another_column_can_be_narrower() {
        let cells = ["incompressible", "incompressible", "one two three"];
        let table =
            Table { heads: vec![""; 9], rows: vec![cells.repeat(3).into_iter().map(str::to_owned).collect()] }.text();
        assert_eq!((table.matches("incompressible").count(), table.matches("three").count()), (6, 3), "{table}");
        assert!(table.lines().all(|line| length(line) <= LINE), "{table}");
        assert_eq!(wrapped("Levenberg–Marquardt again", 10), ["Levenberg–", "Marquardt", "again"]);
        assert_eq!(wrapped("Levenberg–Marquardt again", 30), ["Levenberg–Marquardt again"]);
        assert_eq!(wrapped("a – b", 30), ["a – b"]);
    }

    #[test]
    fn markdown_keeps_one_line_to_a_row() {
        let table = rows(&[row("Fig. 3", "two\nlines")]).table().markdown();
        assert_eq!(table.lines().count(), 3);
        assert!(table.contains("| two lines | 9 \\| 10 |"));
    }

    #[test]
    fn json_has_the_cells_under_their_keys_and_what_else_there_is() {
        let row = Row { more: vec![("seconds", 0.5.into())], ..Row::new("a", "b", "c", "d", Verdict::Warned) };
        let json = serde_json::to_string(&rows(&[row])).unwrap();
        assert_eq!(json, r#"[{"figure":"a","what":"b","paper":"c","ours":"d","verdict":"told","seconds":0.5}]"#);
    }
}
