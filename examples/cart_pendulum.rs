//! Cost, final angles and gradient of the cart with k links for your own controls, as one JSON object.
//!
//! `cargo run --release --example cart_pendulum -- --help`

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read, Write};
use std::num::IntErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver};

const HELP: &str = "\
Simulates the cart with K hanging links and prints cost and gradient as one JSON object.

usage: cargo run --release --example cart_pendulum -- [options]

  --links K            number of links (3)
  --length L           length of a link in m (1)
  --friction-joint J   the hinge with friction; 0 is that of the cart and the first link (0)
  --steps N            number of time steps (100)
  --dt DT              length of a step in s (0.02)
  --controls FILE      the force on the cart in N at the N + 1 nodes, one number per line;
                       blank lines and comments after # are ignored
  --force F            or a constant force in N (10)
  --repeat R           number of repetitions; the times are medians (1)
  --help               print this text

Each option can be given once. Limits: 20000 links, as many nodes as fit into 1 GiB (1.2 million with 3 links), and
100 million links x steps x repetitions, which take some minutes. The library's LongSolver has no such limits.

output
  cost                 J = 1/2 sum (phi_j - pi/2)^2 at the end
  final_angles         phi_j at the end, rad
  gradient             dJ/du_i for i = 0 ... N, 1/N, without a factor dt
  newton_iterations    total number of Newton iterations
  phi_max, phi_dot_max largest violation of the constraints at position (m, rad) and velocity level
  forward_s            seconds for the simulation
  value_and_gradient_s seconds for the simulation and the adjoint sweep
  warnings             warnings of the library about the motion; also printed to standard error

exit status: 0; 1 if the simulation fails or its results cannot be printed; 2 if the arguments or the file are wrong
";

/// Each step of longer chains takes seconds.
const MOST_LINKS: usize = 20_000;
/// Memory of all data stored per node.
const MOST_BYTES: usize = 1 << 30;
/// links × steps × repetitions.
const MOST_WORK: usize = 100_000_000;

/// Reason for an exit with an error.
#[derive(Debug, PartialEq)]
pub enum Failure {
    /// Wrong arguments or a wrong file.
    Usage(String),
    /// A simulation that failed.
    Simulation(String),
    /// A result that could not be printed.
    Output(String),
}

enum Controls {
    Constant(f64),
    File(PathBuf),
}

struct Options {
    mechanism: CartPendulum,
    steps: usize,
    dt: f64,
    controls: Controls,
    repeat: usize,
}

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let (status, message) = match answer(&arguments).and_then(|text| print(&text, &mut io::stdout())) {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => (2, format!("{message} (try --help)")),
        Err(Failure::Simulation(message) | Failure::Output(message)) => (1, message),
    };
    say(&format!("error: {message}"));
    ExitCode::from(status)
}

/// The whole program except for printing its result.
pub fn answer(arguments: &[impl AsRef<OsStr>]) -> Result<String, Failure> {
    if arguments.iter().any(|argument| argument.as_ref() == "--help" || argument.as_ref() == "-h") {
        return Ok(HELP.into());
    }
    let options = parse(arguments)?;
    let controls = match &options.controls {
        Controls::Constant(force) => vec![*force; options.steps + 1],
        Controls::File(file) => read_controls(file, options.steps + 1)?,
    };
    compute(&options, &controls).map_err(|error| Failure::Simulation(error.to_string()))
}

/// Prints the whole text; returns an error if, for example, a disk is full or a pipe is closed.
pub fn print(text: &str, out: &mut impl Write) -> Result<(), Failure> {
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|error| Failure::Output(format!("cannot print the results: {error}")))
}

/// Prints a line to standard error; unlike `eprintln!` it does not panic if standard error is closed.
fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

fn usage<T>(message: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::Usage(message.into()))
}

fn parse(arguments: &[impl AsRef<OsStr>]) -> Result<Options, Failure> {
    let mechanism = CartPendulum::default();
    let mut options = Options { mechanism, steps: 100, dt: 0.02, controls: Controls::Constant(10.0), repeat: 1 };
    let (mut force, mut file, mut seen) = (None, None, Vec::new());
    let mut rest = arguments.iter().map(AsRef::as_ref);
    while let Some(flag) = rest.next() {
        let known = ["--links", "--length", "--friction-joint", "--steps", "--dt", "--controls", "--force", "--repeat"];
        let Some(flag) = known.into_iter().find(|known| flag == *known) else {
            return usage(format!("unknown argument `{}`", shown(&flag.to_string_lossy())));
        };
        if seen.contains(&flag) {
            return usage(format!("{flag} is given twice"));
        }
        seen.push(flag);
        let Some(value) = rest.next() else { return usage(format!("{flag} needs a value")) };
        let text = &*value.to_string_lossy();
        match flag {
            "--links" => options.mechanism.links = positive_count(flag, text)?,
            "--length" => options.mechanism.link_length = number(flag, text)?,
            "--friction-joint" => options.mechanism.friction_joint = count(flag, text)?,
            "--steps" => options.steps = positive_count(flag, text)?,
            "--dt" => options.dt = number(flag, text)?,
            "--controls" if text.is_empty() => return usage("--controls needs the name of a file"),
            "--controls" => file = Some(value.into()),
            "--force" => force = Some(number(flag, text)?),
            _ => options.repeat = positive_count(flag, text)?,
        }
    }
    options.controls = match (force, file) {
        (Some(_), Some(_)) => return usage("give --force or --controls, not both"),
        (Some(force), None) => Controls::Constant(force),
        (None, Some(file)) => Controls::File(file),
        (None, None) => options.controls,
    };
    check(&options)?;
    Ok(options)
}

/// Checks the options before any memory is allocated.
fn check(options: &Options) -> Result<(), Failure> {
    let (CartPendulum { links, friction_joint, link_length, .. }, steps) = (options.mechanism, options.steps);
    if links > MOST_LINKS {
        return usage(format!("--links {links}: at most {MOST_LINKS}"));
    }
    if friction_joint >= links {
        return usage(format!("--friction-joint {friction_joint}: {links} links have the joints 0 to {}", links - 1));
    }
    if link_length <= 0.0 {
        return usage(format!("--length {link_length}: a link must be longer than 0"));
    }
    if options.dt == 0.0 {
        return usage("--dt 0: a step must have a length");
    }
    // `System::bytes_per_node`, inputs, gradient, and the printed numbers.
    let most_steps = MOST_BYTES / (152 * links + 400);
    if steps > most_steps {
        return usage(format!("--steps {steps}: at most {most_steps} with {links} links, because the nodes need 1 GiB"));
    }
    let most_repeats = MOST_WORK / (links * steps);
    if options.repeat > most_repeats {
        return usage(format!("--repeat {}: at most {most_repeats} with {links} links and {steps} steps", options.repeat));
    }
    Ok(())
}

/// The beginning of a text in one line, with escaped special characters.
fn shown(text: &str) -> String {
    text.chars().take(60).flat_map(char::escape_debug).collect()
}

fn number(place: &str, text: &str) -> Result<f64, Failure> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => usage(format!("{place}: `{}` is not a finite number", shown(text))),
    }
}

fn count(flag: &str, text: &str) -> Result<usize, Failure> {
    match text.parse() {
        Ok(value) => Ok(value),
        // Is rejected later with a message that states the permitted range.
        Err(error) if *error.kind() == IntErrorKind::PosOverflow => Ok(usize::MAX),
        Err(_) => usage(format!("{flag}: `{}` is not a whole number of at least 0", shown(text))),
    }
}

fn positive_count(flag: &str, text: &str) -> Result<usize, Failure> {
    match count(flag, text)? {
        0 => usage(format!("{flag} must be at least 1")),
        value => Ok(value),
    }
}

fn read_controls(file: &Path, expected: usize) -> Result<Vec<f64>, Failure> {
    let name = shown(&file.to_string_lossy());
    // A device file may be endless.
    let most = 1_000_000 + 100 * expected;
    let mut text = String::new();
    let read = File::open(file).and_then(|file| file.take(most as u64 + 1).read_to_string(&mut text));
    let length = read.or_else(|error| usage(format!("{name}: {error}")))?;
    if length > most {
        return usage(format!("{name}: more than {most} bytes, but {} steps need {expected} numbers", expected - 1));
    }
    let mut controls = Vec::new();
    // Some editors write a byte order mark at the beginning of a file.
    for (line, content) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let value = content.split('#').next().unwrap_or("").trim();
        if !value.is_empty() {
            controls.push(number(&format!("{name}:{}", line + 1), value)?);
        }
    }
    match controls.len() {
        found if found == expected => Ok(controls),
        found => usage(format!("{name}: {found} numbers, but {} steps need {expected}", expected - 1)),
    }
}

fn compute(options: &Options, controls: &[f64]) -> Result<String, hamiltonian_adjoint::Error> {
    let system = options.mechanism.scene().compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(options.steps, options.dt));
    inputs.controls.copy_from_slice(controls);
    let mut solver = Solver::new(&system, Settings::default());
    let (mut forward, mut both) = (Vec::new(), Vec::new());
    for _ in 0..options.repeat {
        let start = Instant::now();
        solver.simulate(&inputs)?;
        forward.push(start.elapsed().as_secs_f64());
        solver.gradient()?;
        both.push(start.elapsed().as_secs_f64());
    }
    let gradient = solver.gradient()?.clone();
    let motion = solver.trajectory();
    let warnings: Vec<String> =
        solver.report().warnings.iter().chain(&solver.adjoint_report().warnings).map(ToString::to_string).collect();
    warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
    let last = motion.last();
    let angles = (1..=options.mechanism.links).map(|link| motion.q[(3 * link + 2, last)]);
    // `{:?}` writes a number with enough digits to reproduce it exactly, and a text in quotes.
    Ok(format!(
        "{{\n  \"cost\": {:?},\n  \"final_angles\": {},\n  \"gradient\": {},\n  \"newton_iterations\": {},\n  \
         \"phi_max\": {:?},\n  \"phi_dot_max\": {:?},\n  \"forward_s\": {:?},\n  \"value_and_gradient_s\": {:?},\n  \"warnings\": {}\n}}\n",
        gradient.value,
        list(angles),
        list(gradient.controls.iter().copied()),
        solver.report().newton_iterations,
        motion.phi(&system, solver.inputs())?.amax(),
        motion.phi_dot(&system, solver.inputs())?.amax(),
        median(forward),
        median(both),
        list(warnings.iter()),
    ))
}

fn list<T: std::fmt::Debug>(values: impl Iterator<Item = T>) -> String {
    let values: Vec<String> = values.map(|x| format!("{x:?}")).collect();
    format!("[{}]", values.join(", "))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
