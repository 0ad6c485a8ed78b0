//! Motions, gradients and optima of scenes in files, for shells and programs in other languages.

mod check;
mod commands;
mod files;
mod optimise;
mod settings;

use std::fmt::Display;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hamiltonian_adjoint::{Animation, SceneFile};

use commands::Task;
use files::Output;

/// Motions and exact gradients of multibody systems in files.
///
/// Scenes and inputs are JSON files of the library hamiltonian-adjoint; docs/command-line.md describes a session. Results are JSON; warnings and errors
/// are printed to standard error. The exit status is 0; 1 if a computation failed or its result could not be written; 2 if arguments or files are wrong.
#[derive(Parser)]
#[command(name = "hamiltonian-adjoint", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Names and sizes of a scene, its warnings, and the formulas without a program
    Describe {
        /// File of the scene; `-` for standard input
        scene: PathBuf,
        #[command(flatten)]
        output: Output,
    },
    /// The JSON Schema of scene files, with which editors complete and check them
    Schema {
        #[command(flatten)]
        output: Output,
    },
    /// Inputs at rest, as a file that can be edited
    Inputs(commands::AtRest),
    /// The same inputs on an adaptive grid, on which the estimated error of every step is below a tolerance; controls remain the same functions of time
    Adapt {
        #[command(flatten)]
        task: Task,
        /// Largest estimated error of a step, m or rad; relative for coordinates and velocities larger than 1
        #[arg(long, value_name = "X")]
        within: f64,
    },
    /// The motion as JSON, or as CSV if the name of the file ends in .csv; if a step has no solution, the motion up to this step
    Simulate(Task),
    /// J and its derivatives with respect to all inputs
    Gradient(Task),
    /// All outputs and their gradients
    Jacobian(Task),
    /// The product of the Hessian of J with a direction
    HessianProduct {
        #[command(flatten)]
        task: Task,
        /// File of the direction, in the form of a gradient; missing parts are zero
        #[arg(long, value_name = "FILE")]
        along: PathBuf,
    },
    /// Compares gradients and Hessian products with complex step, dual numbers and differences; exit status 1 if one is wrong
    Check(check::Check),
    /// Inputs that minimise J; outputs must be zero unless they have other bounds
    #[command(alias = "optimize")]
    Optimise(optimise::Optimise),
    /// The motion as an animated HTML page; if a step has no solution, up to this step
    Animate(Task),
}

/// The reason for an exit status other than 0.
struct Failure {
    status: u8,
    message: String,
}

impl Failure {
    /// A wrong argument or file.
    fn wrong(place: impl Display, problem: impl Display) -> Self {
        Failure { status: 2, message: format!("{place}: {problem}") }
    }

    /// A computation that failed, or a result that cannot be written.
    fn failed(place: impl Display, problem: impl Display) -> Self {
        Failure { status: 1, message: format!("{place}: {problem}") }
    }
}

fn main() -> ExitCode {
    let result = match Cli::try_parse() {
        Ok(cli) => run(&cli.command),
        Err(asked) if !asked.use_stderr() => files::print(&asked.to_string()),
        Err(wrong) => {
            files::say(wrong.to_string().trim_end());
            return ExitCode::from(2);
        }
    };
    let Err(Failure { status, message }) = result else { return ExitCode::SUCCESS };
    files::say(&format!("error: {message}"));
    ExitCode::from(status)
}

fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Describe { scene, output } => commands::describe(scene, output),
        Command::Schema { output } => output.write(&SceneFile::schema()),
        Command::Inputs(options) => commands::at_rest(options),
        Command::Adapt { task, within } => commands::adapt(task, *within),
        Command::Simulate(task) => task.run(&task.read()?, true, |system, solver| match task.output.is_csv() {
            true => solver.trajectory().to_csv(system, solver.inputs()),
            false => solver.trajectory().to_json(system),
        }),
        Command::Gradient(task) => task.run(&task.read()?, false, |system, solver| solver.gradient()?.to_json(system)),
        Command::Jacobian(task) => task.run(&task.read()?, false, commands::jacobian),
        Command::HessianProduct { task, along } => commands::hessian_product(task, along),
        Command::Check(options) => check::run(options),
        Command::Optimise(options) => optimise::run(options),
        Command::Animate(task) => task.run(&task.read()?, true, |system, solver| {
            Ok(Animation::new(system, solver.inputs(), solver.trajectory())?.html())
        }),
    }
}
