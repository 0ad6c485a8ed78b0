//! `optimise`: optimal control of the paper's cart, and problems of closed mechanisms, by the methods of the library, with the work and the result of each.

mod acrobot;
mod arm;
mod figures;
mod four_bar;
mod mechanisms;
mod problems;
mod rail;
mod runs;
mod starts;

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use hamiltonian_adjoint::Error as MotionError;
use hamiltonian_adjoint::optimize::{
    Guess, Interval, Iterate, MotionProblem, Options as MethodOptions, Outcome, Solved, Variables, Watcher,
    augmented_lagrangian, homotopy, interior_point, lbfgs, levenberg_marquardt, solve,
};
use hamiltonian_adjoint::scenes::CartPendulum;

use crate::bar::bar;
use crate::error::Error;
use crate::files;
use crate::statistics::{distinct, median};
use crate::stopwatch::{Repeats, value_and_gradient};
use crate::table::Table;
use problems::{Name, Posed};
use runs::{Found, Run};

/// Solves problems of optimal control and identification with the library's methods
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Problems to solve [default: all]
    #[arg(long = "problem", value_enum, value_name = "NAME")]
    problems: Vec<Name>,
    /// Solve each problem from so many starts with random controls, too, and search for the shortest times and for motions of the arm from 40
    /// starts
    #[arg(long, value_name = "N", default_value_t = 0)]
    starts: usize,
}

/// A method: its name and a function that calls it.
type Method = (&'static str, fn(&mut MotionProblem, &[f64], &MethodOptions, &mut Watcher) -> Result<Outcome, MotionError>);

const LBFGS: Method = ("L-BFGS", |problem, start, options, watch| lbfgs(problem, start, options, watch));
const AUGMENTED: Method =
    ("augmented Lagrangian", |problem, start, options, watch| augmented_lagrangian(problem, start, options, watch));
const INTERIOR: Method = ("interior point", |problem, start, options, watch| interior_point(problem, start, options, watch));
/// From 2.5 s to the required duration.
const HOMOTOPY: Method = ("homotopy in the final time", |problem, start, options, watch| {
    let steps = problem.inputs_at(start).grid.steps;
    let (first, last) = (Name::Rest.duration() / steps.len() as f64, steps[0]);
    let mut set =
        |problem: &mut MotionProblem, s: f64| problem.change(|inputs| inputs.grid.steps.fill(first + s * (last - first)));
    homotopy(problem, start, options, &mut set, watch)
});
/// In segments, from a straight line of states.
const SOLVE: Method = ("solve", |problem, _, options, watch| {
    let Solved { outcome, .. } = solve(problem, Guess::Straight, options, watch)?;
    Ok(outcome)
});
/// In segments, from 40 random starts.
const SEARCH: Method = ("solve, 40 starts", |problem, _, options, watch| {
    let Solved { outcome, .. } = solve(problem, Guess::Straight.starts(40), options, watch)?;
    Ok(outcome)
});
const LEAST_SQUARES: Method = ("Levenberg–Marquardt", |problem, start, options, watch| {
    levenberg_marquardt(problem, start, options, watch).map(|fit| fit.outcome)
});

pub fn run(options: &Options, folder: &Path) -> Result<bool, Error> {
    let asked = if options.problems.is_empty() { Name::value_variants() } else { &options.problems };
    let names = distinct(asked.iter().copied());
    let mut runs = Vec::new();
    let (mut found, mut started) = (String::new(), Vec::new());
    let bar = bar("optimise", names.len());
    for name in names {
        bar.set_message(name.text());
        bar.tick();
        bar.inc(1);
        if matches!(name, Name::Identify | Name::FourBar) {
            let (run, words) = if name == Name::Identify { identify(folder)? } else { synthesise() };
            runs.extend(run);
            found += &words;
            continue;
        }
        let methods: &[Method] = match name {
            Name::Paper => &[LBFGS, LEAST_SQUARES, INTERIOR],
            Name::RestSooner => &[SOLVE, INTERIOR, HOMOTOPY, AUGMENTED],
            Name::Time | Name::TimeRest if options.starts > 0 => &[SOLVE, SEARCH, INTERIOR, AUGMENTED],
            Name::Arm | Name::ArmLimits if options.starts > 0 => &[SOLVE, SEARCH],
            Name::Periodic => &[INTERIOR, AUGMENTED],
            _ if name.is_cart() => &[SOLVE, INTERIOR, AUGMENTED],
            _ => &[SOLVE],
        };
        for method in methods {
            runs.push(run_method(name, *method)?);
        }
        if name.has_ends() && options.starts > 0 {
            let of_starts = starts::solved(name, options.starts)?;
            found += &starts::sentence(&of_starts);
            started.extend(of_starts);
        }
    }
    bar.finish_and_clear();
    let gradient = one_gradient()?;
    let table = Table {
        heads: vec![
            "Problem",
            "Method",
            "Iterations",
            "Simulations",
            "Gradients",
            "Products",
            "Time [ms]",
            "Relative to one gradient",
            "Value",
            "Violation",
            "End",
        ],
        rows: runs.iter().map(|run| run.cells(gradient)).collect(),
    };
    let words = format!(
        "The cart of the paper with {} links and 100 steps, started from u = 10 N, and other machines, started without controls. Times are medians of up to 5 runs on one thread; one value with its gradient takes {:.3} ms. \
         Each method ends in a nearby minimum; the problem of the shortest time has several.{found}",
        CartPendulum::default().links,
        1e3 * gradient
    );
    files::write(&folder.join("optimise.md"), format!("# Optimal control\n\n{words}\n\n{}", table.markdown()))?;
    files::write_json(&folder.join("optimise.json"), &runs.iter().map(Run::record).collect::<Vec<_>>())?;
    if options.starts > 0 {
        files::write_json(&folder.join("optimise_starts.json"), &started)?;
    }
    figures::draw(&runs, folder)?;
    figures::iterations(&runs, folder)?;
    figures::motions(&runs, folder)?;
    files::print(&format!("{}\n{words}\n{} are in {}\n", table.text(), written(&runs), folder.display()))?;
    Ok(true)
}

/// The last of 100 fits, and how often the true values lay within two standard errors.
fn identify(folder: &Path) -> Result<(Option<Run>, String), Error> {
    const REPEATS: usize = 100;
    let begin = Instant::now();
    let mechanisms::Identified { within, of, fit } = mechanisms::identify(REPEATS)?;
    let milliseconds = 1e3 * begin.elapsed().as_secs_f64() / REPEATS as f64;
    let words = format!(
        " Identification: {within} of {of} parameters of {REPEATS} repetitions, with readings from a finer grid, lie within two standard errors; the time is that of one repetition, \
         including its scenes."
    );
    figures::residuals(&fit.outcome.constraints, &mechanisms::times_of_readings(), folder)?;
    let run = Run { name: Name::Identify, method: LEAST_SQUARES.0, outcome: fit.outcome, milliseconds, found: None };
    Ok((Some(run), words))
}

/// The best of 20 starts.
fn synthesise() -> (Option<Run>, String) {
    const STARTS: usize = 20;
    let begin = Instant::now();
    let found = four_bar::synthesise(STARTS);
    let milliseconds = 1e3 * begin.elapsed().as_secs_f64() / STARTS as f64;
    let Some(four_bar::Synthesis { best, alike, converged }) = found else {
        return (None, format!(" Four-bar: no linkage was found from {STARTS} starts."));
    };
    let words = format!(
        " Four-bar: {converged} of {STARTS} starts converge to a linkage, {alike} of them to the best one, which deviates from the path by {:.2} mm (root mean \
         square); the time is that of one start, the other numbers are those of the best one.",
        1e3 * best.value.sqrt()
    );
    (Some(Run { name: Name::FourBar, method: INTERIOR.0, outcome: best, milliseconds, found: None }), words)
}

/// Options with a tolerance that the accuracy of the cost permits.
fn options(name: Name, method: &str) -> MethodOptions {
    if method.starts_with(SOLVE.0) {
        return MethodOptions::default();
    }
    let target = (name == Name::Paper).then_some(1e-10);
    MethodOptions { target, stationarity: 1e-5, iterations: 2000, ..MethodOptions::default() }
}

fn pose(name: Name) -> Result<Posed, MotionError> {
    match name {
        Name::Periodic => mechanisms::periodic(),
        Name::Rail => rail::pose(),
        Name::Arm | Name::ArmLimits => arm::three(name == Name::ArmLimits),
        Name::Chain => arm::chain(100),
        Name::ChainFiner => arm::chain(500),
        Name::ChainFinest => arm::chain(2000),
        Name::Acrobot => acrobot::pose(),
        _ => problems::cart(name),
    }
}

fn run_method(name: Name, (method, minimise): Method) -> Result<Run, Error> {
    let (posed, options) = (pose(name)?, options(name, method));
    let variables = Variables::new(&posed.system, &posed.inputs, posed.free.clone())?;
    let ((outcome, inputs, iterates), milliseconds) = timed(|| {
        let (settings, inputs) = (posed.settings, posed.inputs.clone());
        let mut problem = MotionProblem::new(&posed.system, settings, inputs, variables.clone())?;
        for (output, to) in &posed.constraints {
            let is_asked = name != Name::Paper || method == LEAST_SQUARES.0;
            problem.constrain(*output, if is_asked { *to } else { Interval::FREE });
        }
        let (start, mut seen) = (problem.start(), Vec::new());
        let mut keep = |_: &Iterate, x: &[f64]| {
            // At the beginning of a round, a method reports an iterate again.
            if seen.last().is_none_or(|last: &Vec<f64>| last != x) {
                seen.push(x.to_vec());
            }
            ControlFlow::Continue(())
        };
        let begin = Instant::now();
        let outcome = minimise(&mut problem, &start, &options, &mut keep)?;
        let time = begin.elapsed();
        let iterates = seen.iter().map(|x| problem.inputs_at(x)).collect();
        let inputs = problem.inputs_at(&outcome.x);
        Ok(((outcome, inputs, iterates), time))
    })?;
    Ok(Run { name, method, outcome, milliseconds, found: Some(Found { posed, inputs, iterates }) })
}

/// The result of `work` and the median of its run times in ms; short work is repeated up to five times.
fn timed<T>(mut work: impl FnMut() -> Result<(T, Duration), Error>) -> Result<(T, f64), Error> {
    let mut times = Vec::new();
    loop {
        let (result, time) = work()?;
        times.push(1e3 * time.as_secs_f64());
        if times.len() == 5 || times.iter().sum::<f64>() >= 500.0 {
            return Ok((result, median(&times)));
        }
    }
}

/// Time of a simulation and its gradient, s.
fn one_gradient() -> Result<f64, Error> {
    let Posed { system, inputs, .. } = pose(Name::Paper)?;
    let repeats = Repeats { turns: 3, turn: Duration::from_millis(30) };
    Ok(repeats.times(&mut [value_and_gradient(&system, &inputs)])?[0])
}

/// Description of the written files.
fn written(runs: &[Run]) -> &'static str {
    if runs.iter().any(|run| run.found.is_some()) {
        "optimise.md, optimise.json, figures, and motions before and after the optimisation"
    } else if runs.iter().any(|run| run.name == Name::Identify) {
        "optimise.md, optimise.json and the residuals"
    } else {
        "optimise.md and optimise.json"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_ten_links_comes_to_rest_in_a_pose() {
        let found = run_method(Name::Chain, SOLVE).expect("fits").outcome;
        // IPOPT: 0.60596 in minimal coordinates.
        assert!(found.reason.is_converged() && found.value < 0.607, "{found}");
    }

    #[test]
    fn only_what_is_there_is_announced() {
        assert_eq!(written(&[]), "optimise.md and optimise.json");
    }
}
