//! The figures and numbers of section 4 of the paper, beside ours.

#[path = "../../tests/scenes/assembly.rs"]
mod assembly;
mod assumptions;
mod bar;
#[path = "../../tests/scenes/by_hand.rs"]
mod by_hand;
mod constraints;
mod error;
mod experiment;
mod figures;
mod files;
mod flags;
mod jacobians;
#[path = "../../tests/scenes/mechanisms.rs"]
mod mechanisms;
mod optimise;
mod player;
mod plot;
#[path = "../../tests/scenes/resolved.rs"]
mod resolved;
mod settings;
mod statistics;
mod steepest_descent;
mod stopwatch;
mod stress;
mod summary;
mod table;
mod timing;
mod truth;
mod work_precision;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use error::Error;
use experiment::Experiment;
use figures::{fig1, fig2, fig3, fig4, fig5, fig6};
use settings::Settings;
use table::{Row, Verdict};

/// Reproduces the figures and numbers of the paper's numerical example and compares them with ours.
///
/// Each figure is written as SVG, CSV and a caption, the numbers as summary.json, the motion as swing-up.html. The exit status is 1 if a claim
/// that must hold fails or if a result cannot be computed, written or printed, and 2 if the arguments are wrong.
#[derive(Parser)]
#[command(version, override_usage = "paper-repro [OPTIONS] [PARTS]...\n       paper-repro [--out <FOLDER>] <COMMAND>")]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Figures and measurements to compute [default: all]
    #[arg(value_enum)]
    parts: Vec<Part>,
    /// Folder for the files [default: paper-repro/out]
    #[arg(long, value_name = "FOLDER", global = true)]
    out: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
}

/// A figure or a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum Part {
    /// Layout of the mechanism
    Fig1,
    /// Snapshots of the swing-up
    Fig2,
    /// Cost and optimality over the iterations
    Fig3,
    /// Constraints on three levels
    Fig4,
    /// Force during the optimisation
    Fig5,
    /// Gradient by two methods
    Fig6,
    /// Adjoint against complex step
    Timing,
    /// The swing-up as an animated page (swing-up.html) and as an animated picture (swing-up.svg)
    Player,
}

impl Part {
    fn make(self, experiment: &Experiment, folder: &Path) -> Result<Vec<Row>, Error> {
        match self {
            Part::Fig1 => fig1::draw(experiment, &folder.join("fig1")),
            Part::Fig2 => fig2::draw(experiment, &folder.join("fig2")),
            Part::Fig3 => fig3::draw(experiment, &folder.join("fig3")),
            Part::Fig4 => fig4::draw(experiment, &folder.join("fig4")),
            Part::Fig5 => fig5::draw(experiment, &folder.join("fig5")),
            Part::Fig6 => fig6::draw(experiment, &folder.join("fig6")),
            Part::Timing => Ok(timing::claims(experiment.timing()?)),
            Part::Player => player::write(experiment, folder).map(|()| Vec::new()),
        }
    }
}

/// Commands other than the paper's figures.
#[derive(Subcommand)]
enum Command {
    /// Compares every formula of the paper, as printed in our copy, with the true derivatives
    Jacobians,
    WorkPrecision(work_precision::Options),
    Stress(stress::Options),
    /// Varies the values that the paper does not state, and reports which of its numbers each combination reproduces
    Assumptions,
    Optimise(optimise::Options),
    /// Draws the derivative of a bouncing ball over the number of steps, beside that of the motion itself (truth.svg)
    Truth,
}

fn main() -> ExitCode {
    let (status, problem) = match start() {
        Ok(true) => return ExitCode::SUCCESS,
        Ok(false) => (1, "a claim that must hold failed".to_owned()),
        Err(error) => (if matches!(error, Error::Usage(_)) { 2 } else { 1 }, error.to_string()),
    };
    files::say(&format!("error: {problem}"));
    ExitCode::from(status)
}

/// Runs the requested command; true if all claims that must hold do hold.
fn start() -> Result<bool, Error> {
    let cli = match Cli::command().try_get_matches().and_then(read) {
        Ok(cli) => cli,
        Err(asked) if !asked.use_stderr() => return files::print(&asked.to_string()).map(|()| true),
        Err(wrong) => return Err(Error::Usage(in_a_line(&wrong.to_string()))),
    };
    cli.settings.check()?;
    let folder = files::folder(cli.out.as_deref())?;
    match &cli.command {
        Some(Command::Jacobians) => compare_equations(&folder),
        Some(Command::WorkPrecision(options)) => work_precision::run(options, &folder),
        Some(Command::Stress(options)) => stress::run(options, &folder),
        Some(Command::Assumptions) => assumptions::run(&folder),
        Some(Command::Optimise(options)) => optimise::run(options, &folder),
        Some(Command::Truth) => truth::run(&folder),
        None => run(cli, &folder).map(|claims| claims.iter().all(|claim| claim.verdict != Verdict::Failed)),
    }
}

/// The parsed arguments; before a command, only the folder may be given.
fn read(matches: ArgMatches) -> Result<Cli, clap::Error> {
    let mut command = Cli::command();
    command.build();
    let is_given = |id: &str| id != "out" && matches.value_source(id) == Some(ValueSource::CommandLine);
    let given = command.get_arguments().find(|argument| is_given(argument.get_id().as_str())).map(ToString::to_string);
    match (given, matches.subcommand_name()) {
        (Some(given), Some(name)) => {
            Err(command.error(ErrorKind::ArgumentConflict, format!("`{name}` does not take {given}")))
        }
        _ => Cli::from_arg_matches(&matches),
    }
}

/// The error and the allowed values in one line, without the usage.
fn in_a_line(error: &str) -> String {
    let lines: Vec<&str> = error.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
    lines.join(" ").trim_start_matches("error: ").to_owned()
}

/// Computes the requested parts and prints the table.
fn run(cli: Cli, folder: &Path) -> Result<Vec<Row>, Error> {
    let mut parts = if cli.parts.is_empty() { Part::value_variants().to_vec() } else { cli.parts };
    parts.sort();
    parts.dedup();
    let mut claims = cli.settings.assumptions();
    let experiment = Experiment::new(cli.settings)?;
    for part in parts {
        claims.extend(part.make(&experiment, folder)?);
    }
    files::write_json(&folder.join("summary.json"), &summary::of(&experiment, &claims))?;
    experiment.warnings.borrow().iter().for_each(|warning| files::say(&format!("warning: {warning}")));
    files::print(&format!(
        "{}\nfigures, data and summary.json are in {}\n",
        summary::rows(&claims).table().text(),
        folder.display()
    ))?;
    Ok(claims)
}

/// Writes and prints the comparison of the paper's formulas with true derivatives; true if all corrected formulas are right.
fn compare_equations(folder: &Path) -> Result<bool, Error> {
    let findings = jacobians::report()?;
    files::write(&folder.join("jacobians.txt"), findings.to_string())?;
    files::write(&folder.join("jacobians.md"), findings.markdown())?;
    files::print(&format!("{findings}\njacobians.txt and jacobians.md are in {}\n", folder.display()))?;
    Ok(findings.all_corrected_hold())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_stand_beside_the_parts_of_the_paper() {
        Cli::command().debug_assert();
        let read = |line: &str| Cli::command().try_get_matches_from(line.split(' ')).and_then(read);
        let cli = read("paper-repro work-precision --short --out folder").unwrap_or_else(|e| panic!("{e}"));
        assert!(cli.out.is_some() && matches!(cli.command, Some(Command::WorkPrecision(options)) if options.short));
        let cli = read("paper-repro stress --short").unwrap_or_else(|e| panic!("{e}"));
        assert!(cli.out.is_none() && matches!(cli.command, Some(Command::Stress(options)) if options.short));
        let parts = |line: &str| read(line).map(|cli| (cli.command.is_none(), cli.parts.len()));
        assert!(matches!(parts("paper-repro fig1 timing --out folder"), Ok((true, 2))));
        assert!(matches!(parts("paper-repro"), Ok((true, 0))));
        let cli = read("paper-repro --out folder stress").unwrap_or_else(|e| panic!("{e}"));
        assert!(cli.out.is_some() && matches!(cli.command, Some(Command::Stress(_))));
        let cli = read("paper-repro fig1 --gravity -1e-3").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((cli.parts.len(), cli.settings.gravity), (1, -1e-3));
        for line in ["paper-repro --links 2 stress", "paper-repro fig1 --out folder stress", "paper-repro fig1 stress"] {
            assert!(read(line).is_err(), "{line}");
        }
        // The problem of `work-precision` is fixed by the references, so it has no flags for another one.
        assert!(read("paper-repro work-precision --links 2").is_err());
    }
}
