//! Numbers for your own controls: cost, motion and gradient of the cart with k links, as one JSON object.
//!
//! `cargo run --release --example cart_pendulum -- --help`

use std::process::ExitCode;
use std::time::Instant;

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver};

const HELP: &str = "\
Simulates the cart with K hanging links and prints cost and gradient as one JSON object.

usage: cargo run --release --example cart_pendulum -- [options]

  --links K            number of links (3)
  --length L           length of a link in m (1)
  --friction-joint J   the hinge with friction, 0 joins the cart and the first link (0)
  --steps N            number of time steps (100)
  --dt DT              length of a step in s (0.02)
  --controls FILE      the force on the cart in N at the N + 1 nodes, one number a line;
                       blank lines and what follows # are skipped
  --force F            or a constant force in N (10)
  --repeat R           how often to compute; the times are medians (1)
  --help               this text

output
  cost                 J = 1/2 sum (phi_j - pi/2)^2 at the end
  final_angles         phi_j at the end, rad
  gradient             dJ/du_i for i = 0 ... N, 1/N, without a factor dt
  newton_iterations    of all steps
  phi_max, phi_dot_max largest violation of the constraints at position (m, rad) and velocity level
  forward_s            seconds for the simulation
  value_and_gradient_s seconds for the simulation and the adjoint sweep

exit status: 0; 1 if the simulation fails; 2 if the arguments or the file are wrong
";

/// What stops the program.
#[derive(Debug, PartialEq)]
pub enum Failure {
    /// Wrong arguments or a wrong file.
    Usage(String),
    /// A simulation that did not come to its end.
    Simulation(String),
}

enum Controls {
    Constant(f64),
    File(String),
}

struct Options {
    mechanism: CartPendulum,
    steps: usize,
    dt: f64,
    controls: Controls,
    repeat: usize,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match answer(&arguments) {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(Failure::Usage(message)) => {
            eprintln!("error: {message}\ntry --help");
            ExitCode::from(2)
        }
        Err(Failure::Simulation(message)) => {
            eprintln!("error: {message}");
            ExitCode::from(1)
        }
    }
}

/// The whole program but for printing.
pub fn answer(arguments: &[String]) -> Result<String, Failure> {
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        return Ok(HELP.into());
    }
    let options = parse(arguments)?;
    let controls = match &options.controls {
        Controls::Constant(force) => vec![*force; options.steps + 1],
        Controls::File(file) => read_controls(file, options.steps + 1)?,
    };
    compute(&options, &controls).map_err(|error| Failure::Simulation(error.to_string()))
}

fn usage<T>(message: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::Usage(message.into()))
}

fn parse(arguments: &[String]) -> Result<Options, Failure> {
    let mechanism = CartPendulum::default();
    let mut options = Options { mechanism, steps: 100, dt: 0.02, controls: Controls::Constant(10.0), repeat: 1 };
    let (mut force, mut file) = (None, None);
    let mut rest = arguments.iter();
    while let Some(flag) = rest.next() {
        let known = ["--links", "--length", "--friction-joint", "--steps", "--dt", "--controls", "--force", "--repeat"];
        if !known.contains(&flag.as_str()) {
            return usage(format!("unknown argument `{flag}`"));
        }
        let Some(value) = rest.next() else { return usage(format!("{flag} needs a value")) };
        match flag.as_str() {
            "--links" => options.mechanism.links = positive_count(flag, value)?,
            "--length" => options.mechanism.link_length = number(flag, value)?,
            "--friction-joint" => options.mechanism.friction_joint = count(flag, value)?,
            "--steps" => options.steps = positive_count(flag, value)?,
            "--dt" => options.dt = number(flag, value)?,
            "--controls" => file = Some(value.clone()),
            "--force" => force = Some(number(flag, value)?),
            _ => options.repeat = positive_count(flag, value)?,
        }
    }
    options.controls = match (force, file) {
        (Some(_), Some(_)) => return usage("give --force or --controls, not both"),
        (Some(force), None) => Controls::Constant(force),
        (None, Some(file)) => Controls::File(file),
        (None, None) => options.controls,
    };
    let CartPendulum { links, friction_joint, link_length, .. } = options.mechanism;
    if friction_joint >= links {
        return usage(format!("--friction-joint {friction_joint}: {links} links have the joints 0 to {}", links - 1));
    }
    if link_length <= 0.0 {
        return usage(format!("--length {link_length}: a link must be longer than 0"));
    }
    if options.dt == 0.0 {
        return usage("--dt 0: a step must have a length");
    }
    Ok(options)
}

fn number(place: &str, text: &str) -> Result<f64, Failure> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => usage(format!("{place}: `{text}` is not a number")),
    }
}

fn count(flag: &str, text: &str) -> Result<usize, Failure> {
    text.parse().or_else(|_| usage(format!("{flag}: `{text}` is not a whole number from 0 up")))
}

fn positive_count(flag: &str, text: &str) -> Result<usize, Failure> {
    match count(flag, text)? {
        0 => usage(format!("{flag} must be at least 1")),
        value => Ok(value),
    }
}

fn read_controls(file: &str, expected: usize) -> Result<Vec<f64>, Failure> {
    let text = std::fs::read_to_string(file).or_else(|error| usage(format!("{file}: {error}")))?;
    let mut controls = Vec::new();
    for (line, content) in text.lines().enumerate() {
        let value = content.split('#').next().unwrap_or("").trim();
        if !value.is_empty() {
            controls.push(number(&format!("{file}:{}", line + 1), value)?);
        }
    }
    match controls.len() {
        found if found == expected => Ok(controls),
        found => usage(format!("{file}: {found} numbers, but {} steps need {expected}", expected - 1)),
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
    let last = motion.computed - 1;
    let angles = (1..=options.mechanism.links).map(|link| motion.q[(3 * link + 2, last)]);
    // `{:?}` writes a number with the digits that give it back exactly.
    Ok(format!(
        "{{\n  \"cost\": {:?},\n  \"final_angles\": {},\n  \"gradient\": {},\n  \"newton_iterations\": {},\n  \
         \"phi_max\": {:?},\n  \"phi_dot_max\": {:?},\n  \"forward_s\": {:?},\n  \"value_and_gradient_s\": {:?}\n}}\n",
        gradient.value,
        list(angles),
        list(gradient.controls.iter().copied()),
        solver.report().newton_iterations,
        motion.phi(&system, solver.inputs())?.amax(),
        motion.phi_dot(&system, solver.inputs())?.amax(),
        median(forward),
        median(both),
    ))
}

fn list(numbers: impl Iterator<Item = f64>) -> String {
    let numbers: Vec<String> = numbers.map(|x| format!("{x:?}")).collect();
    format!("[{}]", numbers.join(", "))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
