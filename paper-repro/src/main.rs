//! The figures and numbers of section 4 of the paper, beside ours.

mod constraints;
mod error;
mod experiment;
mod figures;
mod jacobians;
mod parts;
pub mod plot;
mod settings;
mod statistics;
mod steepest_descent;
mod stress;
mod summary;
pub mod table;
mod timing;
mod work_precision;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand, error::ErrorKind};

use error::Error;
use experiment::Experiment;
use parts::Part;
use settings::Settings;
use summary::Summary;
use table::{Claim, Verdict};

/// Reproduces the figures and numbers of the paper's numerical example and compares them with ours.
///
/// Each figure is written as SVG, PNG and CSV, the numbers as summary.json. The exit status is 1 if a claim
/// that must hold does not.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// What to make [default: everything]
    #[arg(value_enum)]
    parts: Vec<Part>,
    /// Folder for the files [default: paper-repro/out]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
}

/// What else there is besides the paper's figures.
#[derive(Subcommand)]
enum Command {
    /// Compares every formula of the paper, as printed in our copy, with the true derivatives
    Jacobians {
        /// Folder for jacobians.txt and jacobians.md [default: paper-repro/out]
        #[arg(long, value_name = "FOLDER")]
        out: Option<PathBuf>,
    },
    WorkPrecision(work_precision::Options),
    Stress(stress::Options),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    if let Some(problem) = cli.settings.problem() {
        Cli::command().error(ErrorKind::ValueValidation, problem).exit();
    }
    let holds = match &cli.command {
        Some(Command::Jacobians { out }) => compare_equations(out.clone()),
        Some(Command::WorkPrecision(options)) => work_precision::run(options),
        Some(Command::Stress(options)) => stress::run(options),
        None => run(cli).map(|claims| claims.iter().all(|claim| claim.verdict != Verdict::Failed)),
    };
    match holds {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("error: a claim that must hold failed");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Makes what is asked for and prints the table.
fn run(cli: Cli) -> Result<Vec<Claim>, Error> {
    let folder = cli.out.unwrap_or_else(settings::default_folder);
    let mut parts = if cli.parts.is_empty() { Part::PAPER.to_vec() } else { cli.parts };
    parts.sort();
    parts.dedup();
    write(&folder, |folder| std::fs::create_dir_all(folder))?;
    let mut claims = cli.settings.assumptions();
    let experiment = Experiment::new(cli.settings)?;
    for part in parts {
        claims.extend(part.make(&experiment, &folder)?);
    }
    let summary = serde_json::to_string_pretty(&Summary::new(&experiment, &claims));
    write(&folder.join("summary.json"), |path| std::fs::write(path, summary? + "\n"))?;
    // A reader who closes the pipe early has what they want.
    let _ =
        writeln!(std::io::stdout(), "{}\nfigures, data and summary.json are in {}", table::text(&claims), folder.display());
    Ok(claims)
}

/// Writes and prints how the paper's formulas compare with the true derivatives; whether all corrected ones are right.
fn compare_equations(out: Option<PathBuf>) -> Result<bool, Error> {
    let folder = out.unwrap_or_else(settings::default_folder);
    write(&folder, |folder| std::fs::create_dir_all(folder))?;
    let findings = jacobians::report()?;
    write(&folder.join("jacobians.txt"), |path| std::fs::write(path, findings.to_string()))?;
    write(&folder.join("jacobians.md"), |path| std::fs::write(path, findings.markdown()))?;
    // A reader who closes the pipe early has what they want.
    let _ = writeln!(
        std::io::stdout(),
        "{findings}
jacobians.txt and jacobians.md are in {}",
        folder.display()
    );
    Ok(findings.all_corrected_hold())
}

/// Names the path in the error, if there is one.
fn write(path: &Path, how: impl FnOnce(&Path) -> std::io::Result<()>) -> Result<(), Error> {
    how(path).map_err(|source| Error::File { path: path.to_owned(), source })
}
