//! A ball of 1 kg falls on an elastic floor: its height z at the end and dz/dh, where h is the height of the fall, as one JSON object.
//!
//! The gradient of the discrete motion is exact and yet far from the derivative of the motion, because it depends on where between two nodes the
//! contact begins and ends. [`Gradient::frozen`](hamiltonian_adjoint::Gradient::frozen) does not. Best is a grid that has nodes where the contact begins
//! and ends ([`Solver::find_phases`]).
//!
//! `cargo run --release --example bounce -- --stiffness 1e6 --exponent 1.5 --height 1 --time 0.8`

use std::collections::BTreeMap;
use std::process::ExitCode;

use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Estimate, Force, ForcePoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, System,
    estimate,
};
use nalgebra::SVector;

const HELP: &str = "\
Drops a ball of 1 kg on an elastic floor and prints its height and the derivative of this height as one JSON object.

usage: cargo run --release --example bounce -- [options]

  --stiffness K   the floor pushes with K d^E at the depth d (1e6 N/m^E)
  --exponent E    1 for a spring, 1.5 for Hertz' law (1.5)
  --height H      the height of the fall in m (1)
  --time T        the end of the motion in s (0.8)
  --steps N       about N steps (1000), and at least 24 within each contact

output
  z               the height at the end, m
  dz_dheight      dz/dH with nodes where contacts begin and end: the number to use
  plain, frozen   dz/dH on N equal steps: of the discrete motion, and at frozen grid phase
  uncertainty     an estimate of the error of dz_dheight; null if there is none that can be trusted
  warnings        warnings of the library for the motion of dz_dheight

exit status: 0; 1 if the simulation fails; 2 if the arguments are wrong
";

/// The least number of steps within a contact.
const INSIDE: usize = 24;

/// The floor under the height q.
struct Floor {
    exponent: f64,
}

impl Force<1, 0, 1> for Floor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        let depth = (-at.q[0]).max(S::zero());
        SVector::from([b[0] * depth.powf(self.exponent)])
    }
}

struct Height;

impl Cost<1> for Height {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|argument| argument == "--help") {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    let result = match parse(&arguments) {
        Ok(options) => bounce(&options).map_err(|error| (1, error.to_string())),
        Err(message) => Err((2, message)),
    };
    match result {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err((status, message)) => {
            eprintln!("error: {message}");
            ExitCode::from(status)
        }
    }
}

fn parse(arguments: &[String]) -> Result<BTreeMap<&'static str, f64>, String> {
    let known = ["--stiffness", "--exponent", "--height", "--time", "--steps"];
    let mut options =
        BTreeMap::from([("--stiffness", 1e6), ("--exponent", 1.5), ("--height", 1.0), ("--time", 0.8), ("--steps", 1000.0)]);
    for pair in arguments.chunks(2) {
        let flag = known.into_iter().find(|known| *known == pair[0]);
        let flag = flag.ok_or_else(|| format!("unknown argument `{}` (try --help)", pair[0]))?;
        let value = pair.get(1).and_then(|text| text.parse::<f64>().ok()).filter(|value| value.is_finite());
        options.insert(flag, value.ok_or_else(|| format!("{flag} needs a finite number"))?);
    }
    let least = [("--stiffness", 0.0, "0"), ("--exponent", 1.0, "1"), ("--time", 1e-9, "1e-9"), ("--steps", 8.0, "8")];
    for (flag, least, name) in least {
        if options.get(flag).is_some_and(|value| *value < least) {
            return Err(format!("{flag} must be at least {name}"));
        }
    }
    match options.get("--steps").filter(|steps| **steps > 1e7 || steps.fract() != 0.0) {
        Some(steps) => Err(format!("--steps {steps} is not a whole number up to 1e7")),
        None => Ok(options),
    }
}

fn system(stiffness: f64, exponent: f64, height: f64) -> Result<System, Error> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let ball = scene.particle("ball", 1.0, [0.0, height]);
    scene.force("floor", Floor { exponent }, [ball.coordinates[1]], [], [stiffness.into()]);
    scene.cost("z", Height, Sum::Terminal, [ball.coordinates[1]], [], [], []);
    scene.event("contact", Height, [ball.coordinates[1]], [], [], []);
    scene.compile()
}

fn bounce(options: &BTreeMap<&str, f64>) -> Result<String, Error> {
    let (height, time, steps) = (options["--height"], options["--time"], options["--steps"] as usize);
    let system = system(options["--stiffness"], options["--exponent"], height)?;
    let mut solver = Solver::new(&system, Settings::default());
    let uniform = Inputs::at_rest(&system, Grid::uniform(steps, time / steps as f64));
    solver.simulate(&uniform)?;
    let gradient = solver.gradient()?;
    let plain = gradient.start.q()[1];
    let frozen = gradient.frozen.as_ref().map_or(plain, |frozen| frozen.start.q()[1]);
    let located = solver.find_phases(&uniform, INSIDE)?;
    let Estimate { value: z, gradient, derivatives, .. } = estimate(&system, &located, Settings::default())?;
    let by_height = derivatives.iter().find(|derivative| derivative.of == "q₀ of `ball.y`");
    let uncertainty = by_height.map_or("null".into(), |derivative| format!("{:?}", derivative.uncertainty));
    let warnings: Vec<String> = gradient.warnings.iter().map(ToString::to_string).collect();
    let dz_dheight = gradient.start.q()[1];
    Ok(format!(
        "{{\n  \"z\": {z:?},\n  \"dz_dheight\": {dz_dheight:?},\n  \"plain\": {plain:?},\n  \"frozen\": {frozen:?},\n  \"uncertainty\": {uncertainty},\n  \"warnings\": {warnings:?}\n}}\n"
    ))
}
