//! An arm of seven links, written as one element in its seven absolute angles: prints cost, gradient and run times as one JSON object.
//!
//! There are no bodies and no joints: the kinetic energy T(q, v) and the potential energy V(q) of the whole arm are formulas of seven coordinates, which are
//! compiled to programs. With `--num-dual` dual numbers differentiate them at every point instead.
//!
//! `cargo run --release --example arm -- --steps 100 --repeat 200`

use std::f64::consts::FRAC_PI_2;
use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;

use hamiltonian_adjoint::{
    Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Solver, Sum,
    System,
};
use nalgebra::SVector;

const HELP: &str = "\
usage: cargo run --release --example arm -- [--steps N] [--repeat R] [--num-dual] [--print]

  --steps N     number of time steps of 0.01 s (100)
  --repeat R    number of repetitions; the times are medians (1)
  --num-dual    differentiate with dual numbers at every point, without programs
  --print       print the programs of the arm instead

exit status: 0; 1 if the simulation fails or its results cannot be printed; 2 if the arguments are wrong
";

const LINKS: usize = 7;

/// Links of length 1 m with their centres in the middle; q = angles from the horizontal, b = [m, J].
struct Arm;

impl KineticEnergy<LINKS, 2> for Arm {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, LINKS>, v: &SVector<S, LINKS>, b: &SVector<S, 2>) -> S {
        // Velocity of the hinge at which the link begins.
        let (mut x, mut y, mut energy) = (S::zero(), S::zero(), S::zero());
        for k in 0..LINKS {
            let (sin, cos) = q[k].sin_cos();
            let link = [sin * v[k], cos * v[k]];
            let centre = [x - link[0] * 0.5, y + link[1] * 0.5];
            energy += (b[0] * (centre[0] * centre[0] + centre[1] * centre[1]) + b[1] * v[k] * v[k]) * 0.5;
            (x, y) = (x - link[0], y + link[1]);
        }
        energy
    }
}

impl PotentialEnergy<LINKS, 2> for Arm {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, LINKS>, b: &SVector<S, 2>, _t: S) -> S {
        let (mut y, mut height) = (S::zero(), S::zero());
        for angle in q.iter() {
            let sin = angle.sin();
            height += y + sin * 0.5;
            y += sin;
        }
        b[0] * height * 9.81
    }
}

/// A torque u − b v on the first angle.
struct Shoulder;

impl Force<1, 1, 1> for Shoulder {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([at.u[0] - b[0] * at.v[0]])
    }
}

/// ½ (φ − π/2)².
struct Upright;

impl Cost<1> for Upright {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        let error = at.q[0] - FRAC_PI_2;
        error * error * 0.5
    }
}

fn system(with_programs: bool) -> Result<System, hamiltonian_adjoint::Error> {
    let mut scene = Scene::new();
    let q = scene.coordinates("arm", ["1", "2", "3", "4", "5", "6", "7"]);
    q.iter().for_each(|q| scene.place(*q, 0.3 - FRAC_PI_2));
    let b = [0.4.into(), 0.083.into()];
    scene.kinetic_energy("arm", Arm, q, b);
    scene.potential_energy("weight", Arm, q, b);
    let torque = scene.control("torque");
    scene.force("shoulder", Shoulder, [q[0]], [torque], [0.2.into()]);
    for (k, q) in q.iter().enumerate() {
        scene.cost(&format!("link {}", k + 1), Upright, Sum::Terminal, [*q], [], [], []);
    }
    if with_programs { scene.compile() } else { scene.compile_without_programs() }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Reason for an exit with an error.
#[derive(Debug, PartialEq)]
pub enum Failure {
    /// Wrong arguments.
    Usage(String),
    /// A simulation that failed, or a result that could not be printed.
    Run(String),
}

impl From<hamiltonian_adjoint::Error> for Failure {
    fn from(error: hamiltonian_adjoint::Error) -> Self {
        Self::Run(error.to_string())
    }
}

fn main() -> ExitCode {
    let (status, message) = match answer(std::env::args_os().skip(1)).and_then(|text| print(&text)) {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => (2, format!("{message} (try --help)")),
        Err(Failure::Run(message)) => (1, message),
    };
    // Unlike `eprintln!` this does not panic if standard error is closed.
    let _ = writeln!(io::stderr(), "error: {message}");
    ExitCode::from(status)
}

/// Prints the whole text; returns an error if, for example, a disk is full or a pipe is closed.
fn print(text: &str) -> Result<(), Failure> {
    let written = io::stdout().write_all(text.as_bytes()).and_then(|()| io::stdout().flush());
    written.map_err(|error| Failure::Run(format!("cannot print the results: {error}")))
}

/// The whole program except for printing its result.
pub fn answer(arguments: impl Iterator<Item = OsString>) -> Result<String, Failure> {
    let (mut steps, mut repeat, mut with_programs, mut print) = (100, 1, true, false);
    let mut seen = Vec::new();
    let mut arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
    while let Some(argument) = arguments.next() {
        let mut number = || {
            let text = arguments.next().ok_or_else(|| Failure::Usage(format!("{argument} needs a value")))?;
            let number = text.parse().ok().filter(|n| (1..=1_000_000).contains(n));
            number.ok_or_else(|| {
                Failure::Usage(format!("{argument}: `{}` is not a whole number from 1 to 1000000", shown(&text)))
            })
        };
        match argument.as_str() {
            "--steps" => steps = number()?,
            "--repeat" => repeat = number()?,
            "--num-dual" => with_programs = false,
            "--print" => print = true,
            "--help" | "-h" => return Ok(HELP.into()),
            _ => return Err(Failure::Usage(format!("unknown argument `{}`", shown(&argument)))),
        }
        if seen.contains(&argument) {
            return Err(Failure::Usage(format!("{argument} is given twice")));
        }
        seen.push(argument);
    }
    if print && !with_programs {
        return Err(Failure::Usage(
            "give --num-dual or --print, not both: with --num-dual there are no programs to print".into(),
        ));
    }
    let system = system(with_programs)?;
    if print {
        let programs = ["weight", "arm"].into_iter().filter_map(|name| system.program(name));
        return Ok(programs.collect::<Vec<_>>().join("\n") + "\n");
    }
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.01));
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, Settings::default());
    let (mut forward, mut both) = (Vec::new(), Vec::new());
    for _ in 0..repeat {
        let begin = Instant::now();
        solver.simulate(&inputs)?;
        forward.push(begin.elapsed().as_secs_f64());
        solver.gradient()?;
        both.push(begin.elapsed().as_secs_f64());
    }
    let gradient = solver.gradient()?;
    let answer = serde_json::json!({
        "cost": gradient.value,
        "gradient": gradient.controls.as_slice(),
        "forward_s": median(forward),
        "value_and_gradient_s": median(both),
    });
    Ok(format!("{answer}\n"))
}

/// The beginning of a text in one line, with escaped special characters.
fn shown(text: &str) -> String {
    text.chars().take(60).flat_map(char::escape_debug).collect()
}
