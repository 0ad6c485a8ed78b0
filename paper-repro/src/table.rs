//! The table of what the paper states beside what we find.

use serde::{Deserialize, Serialize};
use std::fmt;

/// How our finding compares with the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Ours agrees with the paper.
    Reproduced,
    /// Ours is sound but not what the paper has.
    Differs,
    /// Ours could not be obtained.
    Failed,
    /// The paper gives no number, so there is only ours.
    #[serde(rename = "not stated")]
    NotStated,
    /// The paper leaves this open, and ours rests on an assumption.
    Assumed,
}

impl fmt::Display for Verdict {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Reproduced => "reproduced",
            Self::Differs => "differs",
            Self::Failed => "failed",
            Self::NotStated => "not stated",
            Self::Assumed => "assumed",
        })
    }
}

/// One statement of the paper and our counterpart.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// The figure, table or section that makes the statement.
    pub figure: String,
    /// What is stated.
    pub what: String,
    /// The value in the paper.
    pub paper: String,
    /// Our value.
    pub ours: String,
    /// How they compare.
    pub verdict: Verdict,
}

/// The heads of the columns.
const HEADS: [&str; 5] = ["Figure", "What", "Paper", "Ours", "Verdict"];
/// Characters to a line of the text table.
const LINE: usize = 110;
/// Between columns of the text table.
const GAP: &str = "  ";

/// The claims in aligned columns, wrapped to the line, with a rule where the figure changes.
pub fn text(claims: &[Claim]) -> String {
    aligned(HEADS, &claims.iter().map(cells).collect::<Vec<_>>())
}

/// Rows in aligned columns, wrapped to the line, with a rule where the first column changes.
pub fn aligned<const C: usize>(heads: [&str; C], rows: &[[String; C]]) -> String {
    let widths = widths(heads, rows);
    let rule = "─".repeat(widths.iter().sum::<usize>() + GAP.len() * (C - 1)) + "\n";
    let mut out = row(&heads.map(str::to_owned), &widths);
    for (index, cells) in rows.iter().enumerate() {
        if index == 0 || rows[index - 1][0] != cells[0] {
            out += &rule;
        }
        out += &row(cells, &widths);
    }
    out
}

/// Rows as a table of Markdown.
pub fn bars<const C: usize>(heads: [&str; C], rows: &[[String; C]]) -> String {
    let line = |cells: [String; C]| format!("| {} |\n", cells.map(|cell| escaped(&cell)).join(" | "));
    let head = line(heads.map(str::to_owned)) + &"|---".repeat(C) + "|\n";
    std::iter::once(head).chain(rows.iter().map(|cells| line(cells.clone()))).collect()
}

/// The cells of the claim.
fn cells(claim: &Claim) -> [String; 5] {
    let Claim { figure, what, paper, ours, verdict } = claim;
    [figure.clone(), what.clone(), paper.clone(), ours.clone(), verdict.to_string()]
}

/// The text on one line, its bars not mistaken for those between cells.
fn escaped(cell: &str) -> String {
    cell.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

/// Widths of the columns, the widest narrowed until a row fits the line.
fn widths<const C: usize>(heads: [&str; C], rows: &[[String; C]]) -> [usize; C] {
    let mut widths = heads.map(length);
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = length(cell).max(*width);
        }
    }
    let room = LINE - GAP.len() * (C - 1);
    while widths.iter().sum::<usize>() > room {
        if let Some(widest) = widths.iter_mut().max() {
            *widest -= 1;
        }
    }
    widths
}

/// One row, of as many lines as its longest cell needs.
fn row<const C: usize>(cells: &[String; C], widths: &[usize; C]) -> String {
    let columns: Vec<Vec<String>> = cells.iter().zip(widths).map(|(cell, width)| wrapped(cell, *width)).collect();
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

/// The text in lines no longer than the width, words broken only where they alone are longer.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        if let Some(line) = lines.last_mut().filter(|line| length(line) + 1 + length(word) <= width) {
            line.push(' ');
            line.push_str(word);
            continue;
        }
        let letters: Vec<char> = word.chars().collect();
        lines.extend(letters.chunks(width.max(1)).map(|piece| piece.iter().collect::<String>()));
    }
    lines
}

/// Characters of the text, each taken to be one column wide.
fn length(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(figure: &str, what: &str) -> Claim {
        let (paper, ours) = ("9 | 10".to_owned(), "word ".repeat(40));
        Claim { figure: figure.to_owned(), what: what.to_owned(), paper, ours, verdict: Verdict::NotStated }
    }

    #[test]
    fn text_fits_the_line() {
        let table = text(&[claim("Fig. 3", &"x".repeat(150)), claim("Fig. 4", "‖Φ‖ at the end")]);
        assert!(table.lines().all(|line| length(line) <= LINE), "{table}");
        assert_eq!(table.matches("word").count(), 80);
        assert_eq!(table.lines().filter(|line| line.starts_with('─')).count(), 2);
    }

    #[test]
    fn markdown_keeps_one_line_to_a_claim() {
        let table = bars(HEADS, &[cells(&claim("Fig. 3", "two\nlines"))]);
        assert_eq!(table.lines().count(), 3);
        assert!(table.contains("| two lines | 9 \\| 10 |"));
    }

    #[test]
    fn verdict_reads_as_written() {
        let written = serde_json::to_string(&Verdict::NotStated).unwrap();
        assert_eq!(written, format!("\"{}\"", Verdict::NotStated));
    }
}
