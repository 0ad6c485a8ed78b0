//! `stress`: where the method or the arithmetic might give way, with a bound for each number and a verdict for each row.

mod assembly;
mod chaos;
mod conditioning;
mod conserved;
mod drift;
mod extremes;
mod figures;
mod hard_starts;
mod long_runs;
mod motion;
mod redundant;
mod row;
mod scenes;
mod singular;
mod units;

use std::path::PathBuf;

use serde::Serialize;

use crate::error::Error;
use crate::{files, table};
use row::{Curve, Row, Trial, Verdict};

/// Tries extremes, long motions and singular configurations and says what held
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// Folder for the files [default: paper-repro/out]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Shorter motions: less than a minute
    #[arg(long)]
    short: bool,
}

/// The contents of `stress.json`.
#[derive(Serialize)]
struct Report<'a> {
    short: bool,
    rows: &'a [Row],
    curves: &'a [Curve],
}

/// What is tried elsewhere.
const RANDOM: &str = "Random scenes are tried by `RANDOM_SCENES=2000 cargo test --release --test random -- --nocapture`.";

/// Tries everything, writes the files, prints the table; false if a row failed.
///
/// # Errors
/// Files that cannot be written.
pub fn run(options: &Options) -> Result<bool, Error> {
    let folder = files::folder(options.out.as_deref())?;
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    for trial in trials(options.short) {
        let (row, more) = trial.judge();
        rows.push(row);
        curves.extend(more);
    }
    figures::draw(&curves, &folder)?;
    let cells: Vec<[String; 5]> = rows.iter().map(Row::cells).collect();
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let verdicts = [Verdict::Held, Verdict::Refused, Verdict::Told, Verdict::Failed];
    let [held, refused, told, failed] = verdicts.map(count);
    let summary = format!(
        "{} rows: {held} held, {refused} refused (a typed error where that is an answer), {told} told (a warning that is one), {failed} failed.",
        rows.len()
    );
    let markdown = format!("# Stress\n\n{summary} {RANDOM}\n\n{}", table::bars(Row::HEADS, &cells));
    files::write(&folder.join("stress.md"), markdown)?;
    files::write_json(&folder.join("stress.json"), &Report { short: options.short, rows: &rows, curves: &curves })?;
    let table = table::aligned(Row::HEADS, &cells);
    files::print(&format!("{table}\n{summary}\nfigures, stress.md and stress.json are in {}\n", folder.display()))?;
    Ok(failed == 0)
}

/// All trials, group by group.
fn trials(short: bool) -> Vec<Trial> {
    let groups = [
        // First, for what is judged there is the memory that the process ever had.
        long_runs::trials(short),
        extremes::trials(short),
        units::trials(),
        chaos::trials(short),
        conserved::trials(short),
        drift::trials(short),
        hard_starts::trials(),
        conditioning::trials(short),
        singular::trials(),
        redundant::trials(),
    ];
    groups.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cli, Command};
    use clap::Parser;

    #[test]
    fn it_stands_beside_the_parts_of_the_paper() {
        let cli =
            Cli::try_parse_from("paper-repro stress --short --out folder".split(' ')).unwrap_or_else(|e| panic!("{e}"));
        assert!(matches!(cli.command, Some(Command::Stress(Options { short: true, out: Some(_) }))));
    }

    #[test]
    fn every_row_has_a_name_of_its_own() {
        let rows: Vec<String> = trials(true).iter().map(Trial::name).collect();
        let mut names = rows.clone();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), rows.len());
        assert!(trials(false).len() >= rows.len());
    }
}
