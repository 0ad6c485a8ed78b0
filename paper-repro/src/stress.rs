//! `stress`: cases in which the method or the arithmetic might fail, with a bound for each number and a verdict for each row.

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
mod singular;
pub mod stiff;
mod units;

use std::path::Path;

use serde_json::json;

use crate::bar::bar;
use crate::error::Error;
use crate::files;
use crate::table::{Row, Rows, Verdict};
use row::{Curve, Trial};

/// Tests extreme values, long motions and singular configurations, and reports the results
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// Use shorter motions; takes less than a minute
    #[arg(long)]
    pub short: bool,
}

/// Reference to the tests with random scenes.
const RANDOM: &str = "Random scenes are tested by `RANDOM_SCENES=2000 cargo test --release --test random -- --nocapture`.";

/// Runs all trials, writes the files and prints the table; false if a row failed.
pub fn run(options: &Options, folder: &Path) -> Result<bool, Error> {
    let trials = trials(options.short);
    let bar = bar("stress", trials.len());
    let judge = |trial: &Trial| {
        bar.set_message(trial.name());
        let judged = trial.judge();
        bar.inc(1);
        judged
    };
    let (rows, curves): (Vec<Row>, Vec<Vec<Curve>>) = trials.iter().map(judge).unzip();
    bar.finish_and_clear();
    let curves = curves.concat();
    figures::draw(&curves, folder)?;
    let (keys, heads) = (["group", "tried", "expected", "got"], ["Group", "Tried", "Expected", "Got"]);
    let rows = Rows { keys, heads, rows: &rows };
    let table = rows.table();
    let verdicts = [Verdict::Holds, Verdict::Refused, Verdict::Warned, Verdict::Failed];
    let [hold, refused, warned, failed] = verdicts.map(|verdict| rows.count(verdict));
    let summary = format!(
        "{} rows: {hold} hold, {refused} refused with an error (if a specific error is an acceptable result), {warned} warned \
         (if a specific warning is an acceptable result), {failed} failed.",
        rows.rows.len()
    );
    files::write(&folder.join("stress.md"), format!("# Stress\n\n{summary} {RANDOM}\n\n{}", table.markdown()))?;
    files::write_json(&folder.join("stress.json"), &json!({"short": options.short, "rows": rows, "curves": curves}))?;
    let place = folder.display();
    files::print(&format!("{}\n{summary}\nfigures, stress.md and stress.json are in {place}\n", table.text()))?;
    Ok(failed == 0)
}

/// All trials, group by group.
fn trials(short: bool) -> Vec<Trial> {
    let groups = [
        // This group is first because it judges the peak memory of the whole process.
        ("long runs", long_runs::trials(short)),
        ("extremes", extremes::trials(short)),
        ("units", units::trials()),
        ("chaos", chaos::trials(short)),
        ("conserved", conserved::trials(short)),
        ("drift", drift::trials(short)),
        ("hard starts", hard_starts::trials()),
        ("condition", conditioning::trials(short)),
        ("singular", singular::trials()),
        ("redundant", redundant::trials()),
        ("stiff parts", stiff::trials()),
    ];
    let named = |(group, trials): (_, Vec<Trial>)| trials.into_iter().map(move |trial| trial.of_group(group));
    groups.into_iter().flat_map(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
