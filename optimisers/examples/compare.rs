//! The library's own methods, argmin and IPOPT (where it was found) on problems of the paper's cart, in one run:
//!
//! `cargo run --release -p optimisers --example compare`
//!
//! `-- --serve NAME` serves a program in another language instead: it reads lines with the variables as a JSON list and writes lines with `value`,
//! `gradient`, `constraints` and `jacobian`; the first line written contains `start`, `bounds` and `constraints` (`optimisers/scipy_compare.py`).

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::io::{BufRead, Write};
use std::time::Instant;

use argmin::core::{Executor, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, Options, Outcome, Problem, Variables, interior_point, lbfgs, lowest, multi_start, silent,
};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Error as MotionError, Grid, Inputs, Output, Settings, Solver, Sum, System};
use optimisers::{Argmin, HAS_IPOPT, Hessian, ipopt};
use serde_json::json;

const NAMES: [&str; 5] = ["paper", "effort", "rest", "time", "time-rest"];

/// The problems, as in `cargo run --release -p paper-repro -- optimise`.
struct Posed {
    system: System,
    inputs: Inputs,
    free: Vec<Free>,
    constraints: Vec<(Output, Interval)>,
}

fn pose(name: &str) -> Result<Posed, Box<dyn Error>> {
    let mut cart = CartPendulum::default().mechanism();
    let (force, mut constraints) = (cart.force, Vec::new());
    let (at_rest, is_timed) = (name.ends_with("rest"), name.starts_with("time"));
    for (j, link) in cart.links.iter().enumerate() {
        let angle = link.coordinates[2];
        if name == "paper" {
            cart.scene.cost(&format!("angle {j}"), AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
            continue;
        }
        let end = cart.scene.end_state(angle);
        constraints.push((end.position, Interval::equal(FRAC_PI_2)));
        constraints.extend(at_rest.then_some((end.rate, Interval::ZERO)));
    }
    if at_rest {
        constraints.push((cart.scene.end_state(cart.cart.coordinates[0]).rate, Interval::ZERO));
    }
    match is_timed {
        true => cart.scene.time("time", 1.0),
        false if name != "paper" => cart.scene.effort("effort", force, 1e-4),
        false => {}
    }
    let free = match is_timed {
        true => vec![Free::control(force).within(-50.0, 50.0).scaled(10.0), Free::duration().within(0.5, 5.0)],
        false => vec![Free::control(force)],
    };
    let system = cart.scene.compile()?;
    let duration = if at_rest { 2.5 } else { 2.0 };
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, duration / 100.0));
    inputs.controls.fill(10.0);
    Ok(Posed { system, inputs, free, constraints })
}

fn problem(Posed { system, inputs, free, constraints }: &Posed) -> Result<MotionProblem, MotionError> {
    let variables = Variables::new(system, inputs, free.clone())?;
    let mut problem = MotionProblem::new(system, Settings::default(), inputs.clone(), variables)?;
    constraints.iter().for_each(|(output, to)| problem.constrain(*output, *to));
    Ok(problem)
}

/// A method, called with a start.
type Solve<'a> = &'a mut dyn FnMut(&mut MotionProblem, &[f64]) -> Result<Outcome, Box<dyn Error>>;

/// A row of the table; the time is the median of up to 5 runs.
fn row((name, method, gradient): (&str, &str, f64), posed: &Posed, solve: Solve) -> Result<(), Box<dyn Error>> {
    let (mut times, mut last) = (Vec::new(), None);
    while times.len() < 5 && times.iter().sum::<f64>() < 1.0 {
        let mut problem = problem(posed)?;
        let start = problem.start();
        let begin = Instant::now();
        let outcome = solve(&mut problem, &start);
        times.push(begin.elapsed().as_secs_f64());
        last = Some(outcome);
    }
    times.sort_by(f64::total_cmp);
    let time = times[times.len() / 2];
    match last {
        Some(Ok(Outcome { value, violation, reason, iterations, evaluations, gradients, products, .. })) => println!(
            "| {name} | {method} | {iterations} | {evaluations} | {gradients} | {products} | {:.1} | {:.0} | {value:.6} | {violation:.0e} | {reason:?} |",
            1e3 * time,
            time / gradient
        ),
        Some(Err(error)) => {
            println!("| {name} | {method} | | | | | {:.1} | {:.0} | | | {error} |", 1e3 * time, time / gradient)
        }
        None => {}
    }
    Ok(())
}

/// argmin's L-BFGS, with its own counters.
fn by_argmin(problem: &mut MotionProblem, start: &[f64], options: &Options) -> Result<Outcome, Box<dyn Error>> {
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), options.memory);
    let target = options.target.unwrap_or(f64::NEG_INFINITY);
    let executor = Executor::new(Argmin::new(problem)?, solver).configure(|state| {
        state.param(start.to_vec()).counting(true).max_iters(options.iterations as u64).target_cost(target)
    });
    let run = executor.run()?;
    let state = run.state();
    let x = state.get_best_param().cloned().unwrap_or_default();
    let count = |of: &str| state.get_func_counts().get(of).copied().unwrap_or(0) as usize;
    let (evaluations, gradients) = (count("cost_count"), count("gradient_count"));
    let iterations = state.get_iter() as usize;
    let end = lbfgs(problem, &x, &Options { iterations: 0, ..*options }, &mut silent)?;
    let history = vec![end.history[0]; 1 + iterations];
    let outcome = Outcome { iterations, evaluations, gradients, history, ..end };
    Ok(outcome)
}

fn compare() -> Result<(), Box<dyn Error>> {
    let first = pose("paper")?;
    let mut solver = Solver::new(&first.system, Settings::default());
    let begin = Instant::now();
    for _ in 0..200 {
        solver.simulate(&first.inputs)?;
        solver.gradient()?;
    }
    let gradient = begin.elapsed().as_secs_f64() / 200.0;
    println!(
        "One value with its gradient: {:.3} ms. IPOPT {}.\n",
        1e3 * gradient,
        if HAS_IPOPT { "was found" } else { "was not found" }
    );
    println!(
        "| Problem | Method | Iterations | Simulations | Gradients | Products | ms | relative to one gradient | Value | Violation | End |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for name in NAMES {
        let posed = pose(name)?;
        let target = (name == "paper").then_some(1e-10);
        let options = Options { target, stationarity: 1e-5, iterations: 2000, ..Options::default() };
        if name == "paper" {
            row((name, "L-BFGS", gradient), &posed, &mut |problem, start| {
                Ok(lbfgs(problem, start, &options, &mut silent)?)
            })?;
            row((name, "argmin L-BFGS", gradient), &posed, &mut |problem, start| by_argmin(problem, start, &options))?;
        }
        row((name, "interior point", gradient), &posed, &mut |problem, start| {
            Ok(interior_point(problem, start, &options, &mut silent)?)
        })?;
        for (method, hessian) in
            [("IPOPT, exact Hessian", Hessian::Exact), ("IPOPT, limited memory", Hessian::LimitedMemory)]
        {
            if HAS_IPOPT {
                // IPOPT has no target value: it continues until the gradient is small.
                row((name, method, gradient), &posed, &mut |problem, start| Ok(ipopt(problem, start, &options, hessian)?))?;
            }
        }
    }
    speed_up()
}

/// The problem of least effort from 40 starts, on one thread and on all cores.
fn speed_up() -> Result<(), Box<dyn Error>> {
    let posed = pose("effort")?;
    let start = |k: usize| (0..=100).map(|i| 15.0 * ((0.02 * i as f64 + 0.7) * (1.0 + 0.2 * k as f64)).sin()).collect();
    let starts: Vec<Vec<f64>> = (0..40).map(start).collect();
    let options = Options { stationarity: 1e-5, iterations: 500, ..Options::default() };
    let make = || problem(&posed);
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut one_thread = 0.0;
    println!();
    for threads in [1, all] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let begin = Instant::now();
        let solve = |problem: &mut MotionProblem, start: &[f64]| interior_point(problem, start, &options, &mut silent);
        let outcomes = pool.install(|| multi_start(&starts, make, solve));
        let time = begin.elapsed().as_secs_f64();
        one_thread = if threads == 1 { time } else { one_thread };
        let best = lowest(&outcomes, 1e-9).map_or(f64::NAN, |outcome| outcome.value);
        println!(
            "40 starts of `effort` on {threads} threads: {time:.2} s, {:.2} times as fast as on one; best {best:.9}",
            one_thread / time
        );
    }
    Ok(())
}

fn serve(name: &str) -> Result<(), Box<dyn Error>> {
    let posed = pose(name)?;
    let mut problem = problem(&posed)?;
    let pairs = |of: Vec<Interval>| {
        let finite = |x: f64| x.is_finite().then_some(x);
        of.iter().map(|of| json!([finite(of.least), finite(of.most)])).collect::<Vec<_>>()
    };
    let asked: Vec<usize> = posed.constraints.iter().map(|(output, _)| output.index()).collect();
    let constraints: Vec<Interval> = asked.iter().map(|&j| problem.constraints()[j]).collect();
    let mut out = std::io::stdout().lock();
    let head = json!({ "start": problem.start(), "bounds": pairs(problem.bounds()), "constraints": pairs(constraints) });
    writeln!(out, "{head}")?;
    out.flush()?;
    for line in std::io::stdin().lock().lines() {
        let x: Vec<f64> = serde_json::from_str(&line?)?;
        let mut c = vec![0.0; problem.constraints().len()];
        let answer = match problem.evaluate(&x, &mut c) {
            Err(error) => json!({ "error": error.to_string() }),
            Ok(value) => {
                let mut gradient = vec![0.0; x.len()];
                problem.gradient(1.0, &vec![0.0; c.len()], &mut gradient)?;
                let mut jacobian = Vec::new();
                for &j in &asked {
                    let (mut weights, mut row) = (vec![0.0; c.len()], vec![0.0; x.len()]);
                    weights[j] = 1.0;
                    problem.gradient(0.0, &weights, &mut row)?;
                    jacobian.push(row);
                }
                let c: Vec<f64> = asked.iter().map(|&j| c[j]).collect();
                json!({ "value": value, "gradient": gradient, "constraints": c, "jacobian": jacobian })
            }
        };
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => compare(),
        ["--serve", name] if NAMES.contains(&name) => serve(name),
        _ => Err(format!("give nothing, or --serve and one of {}", NAMES.join(", ")).into()),
    }
}
