//! `optimise`: inputs that minimise J.

use clap::{Args, ValueEnum};
use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::{
    self, Free, Interval, MotionProblem, Outcome, Quantity, Reason, Variables, augmented_lagrangian, interior_point, lbfgs,
    levenberg_marquardt, silent,
};

use crate::Failure;
use crate::commands::{Known, Task};
use crate::files::say;

/// Options of an optimisation.
#[derive(Args)]
pub struct Optimise {
    #[command(flatten)]
    task: Task,
    /// Free inputs: `controls`, `design`, `q0`, `rate0`, `duration`, or one of them by its name (design.mass); separated by commas or repeated
    #[arg(long, default_value = "controls", value_delimiter = ',', value_name = "PART[.NAME]")]
    free: Vec<String>,
    /// Bounds of what is free, or of an output (outputs.NAME); one side may be missing (0..)
    #[arg(long, value_name = "PART[.NAME]=LEAST..MOST")]
    bounds: Vec<String>,
    /// Magnitude of what is free, if magnitudes differ by powers of ten
    #[arg(long, value_name = "PART[.NAME]=X")]
    scale: Vec<String>,
    /// Method of optimisation
    #[arg(long, value_enum, default_value_t = Method::InteriorPoint)]
    method: Method,
    /// Largest number of iterations
    #[arg(long, default_value_t = 1000, value_name = "N")]
    iterations: usize,
    /// Tolerance of the gradient, relative to its terms at the point, at most to its value at the start
    #[arg(long, default_value = "1e-7", value_name = "X")]
    stationarity: f64,
    /// Tolerance of the outputs
    #[arg(long, default_value = "1e-9", value_name = "X")]
    violation: f64,
    /// Value of J at which the method stops
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    target: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// Bounds and outputs, with products of the Hessian
    InteriorPoint,
    /// Bounds, with gradients alone
    Lbfgs,
    /// Bounds and outputs, with gradients alone
    AugmentedLagrangian,
    /// Least squares of the outputs instead of J
    LevenbergMarquardt,
}

/// Writes the best inputs found, whether or not the method converged.
pub fn run(options: &Optimise) -> Result<(), Failure> {
    let known = options.task.read()?;
    let mut problem = options.problem(&known)?;
    let outcome = options.solve(&mut problem).map_err(|error| known.failure(error))?;
    known.warn(&outcome.warnings);
    if outcome.reason == Reason::NoStart {
        return Err(Failure::failed(&known.place, outcome));
    }
    let best = problem.inputs_at(&outcome.x).to_json(&known.system);
    options.task.output.write(&best.map_err(|error| known.failure(error))?)?;
    if !outcome.reason.is_converged() {
        return Err(Failure::failed(&known.place, outcome));
    }
    say(&format!("{}: {outcome}", known.place));
    Ok(())
}

impl Optimise {
    /// The problem with its free quantities and bounds.
    fn problem(&self, known: &Known) -> Result<MotionProblem, Failure> {
        let mut free: Vec<Free> = Vec::new();
        for item in &self.free {
            free.extend(quantities(known, item)?.into_iter().map(Free::new));
        }
        let mut outputs = Vec::new();
        for text in &self.bounds {
            let (item, interval) = assigned(text, interval)?;
            match item.strip_prefix("outputs.") {
                Some(name) => {
                    let output = known.scene.output_named(name);
                    outputs.push((output.ok_or_else(|| Failure::wrong(item, "the scene has no such output"))?, interval));
                }
                None => change(known, &mut free, item, |of| of.bounds = interval)?,
            }
        }
        for text in &self.scale {
            let (item, scale) = assigned(text, |text| text.parse().ok())?;
            change(known, &mut free, item, |of| of.scale = scale)?;
        }
        let wrong = |error| Failure::wrong(&known.place, error);
        let variables = Variables::new(&known.system, &known.inputs, free).map_err(wrong)?;
        let problem = MotionProblem::new(&known.system, known.settings, known.inputs.clone(), variables);
        let mut problem = problem.map_err(wrong)?;
        outputs.into_iter().for_each(|(output, interval)| problem.constrain(output, interval));
        Ok(problem)
    }

    fn solve(&self, problem: &mut MotionProblem) -> Result<Outcome, Error> {
        let options = optimize::Options {
            iterations: self.iterations,
            target: self.target,
            stationarity: self.stationarity,
            violation: self.violation,
            ..optimize::Options::default()
        };
        let start = problem.start();
        match self.method {
            Method::InteriorPoint => interior_point(problem, &start, &options, &mut silent),
            Method::Lbfgs => lbfgs(problem, &start, &options, &mut silent),
            Method::AugmentedLagrangian => augmented_lagrangian(problem, &start, &options, &mut silent),
            Method::LevenbergMarquardt => levenberg_marquardt(problem, &start, &options, &mut silent).map(|fit| fit.outcome),
        }
    }
}

/// The quantities that an item denotes.
fn quantities(Known { scene, system, .. }: &Known, item: &str) -> Result<Vec<Quantity>, Failure> {
    let (part, name) = item.split_once('.').map_or((item, None), |(part, name)| (part, Some(name)));
    let is_meant = |known: &str| name.is_none_or(|name| name == known);
    let coordinates = || (0..system.n()).filter(|i| is_meant(system.coordinate_name(*i))).map(|i| system.coordinate(i));
    let found: Vec<Quantity> = match part {
        "controls" => {
            let meant = (0..system.k()).filter(|k| is_meant(system.control_name(*k)));
            meant.map(|k| Quantity::Control(system.control(k))).collect()
        }
        "design" => {
            let meant = (0..system.designs()).map(|p| system.design_name(p)).filter(|name| is_meant(name));
            meant.filter_map(|name| scene.design_named(name)).map(Quantity::Design).collect()
        }
        "q0" => coordinates().map(Quantity::Coordinate).collect(),
        "rate0" => coordinates().map(Quantity::Rate).collect(),
        "duration" => vec![Quantity::Duration],
        _ => Vec::new(),
    };
    let problem = "this is none of controls, design, q0, rate0, duration, and none of them with its name, as design.mass";
    if found.is_empty() { Err(Failure::wrong(item, problem)) } else { Ok(found) }
}

/// Changes the free quantities that an item denotes.
fn change(known: &Known, free: &mut [Free], item: &str, change: impl Fn(&mut Free)) -> Result<(), Failure> {
    for quantity in quantities(known, item)? {
        let of = free.iter_mut().find(|of| of.quantity == quantity);
        change(of.ok_or_else(|| Failure::wrong(item, "this is not free"))?);
    }
    Ok(())
}

/// An item and the value that is assigned to it. Names may contain `=`.
fn assigned<T>(text: &str, value: fn(&str) -> Option<T>) -> Result<(&str, T), Failure> {
    let parts = text.rsplit_once('=').and_then(|(item, of)| Some((item, value(of)?)));
    parts.ok_or_else(|| Failure::wrong(text, "this does not have the form that --help shows"))
}

/// `least..most`; a missing side is infinite.
fn interval(text: &str) -> Option<Interval> {
    let (least, most) = text.split_once("..")?;
    let number = |text: &str, missing: f64| if text.is_empty() { Some(missing) } else { text.parse().ok() };
    Some(Interval::new(number(least, f64::NEG_INFINITY)?, number(most, f64::INFINITY)?))
}
