//! `assumptions`: varies the values that the paper does not state, and reports which of the paper's numbers each combination reproduces.

use std::path::Path;

use hamiltonian_adjoint::{Error as MotionError, Settings as SolverSettings, Solver};
use serde_json::{Value, json};

use crate::constraints::norms;
use crate::error::Error;
use crate::experiment::{Experiment, Optimum};
use crate::figures::fig2::{NEAR, PAPER_RIGHTMOST as RIGHTMOST};
use crate::files;
use crate::plot::{Axis, Chart, Place, Series, Style, colour};
use crate::settings::Settings;
use crate::statistics::median;
use crate::steepest_descent::LineSearch;
use crate::table::Table;

/// J₀ read from the axis of Fig. 3, and how closely it can be read.
const START: (f64, f64) = (15.0, 0.5);
/// Time at which the gradients of Fig. 6 differ most relative to their size, s; we assume that they vanish there; to two nodes.
const VANISHES: f64 = 0.52;
/// Range in which Φ generally lies.
const DRIFT: std::ops::RangeInclusive<f64> = 1e-5..=1e-4;
/// Largest J that counts as close to zero after the paper's iterations.
const ZERO: f64 = 1e-3;
const ITERATIONS: u32 = 300;
/// Number of printed rows; the files contain all rows.
const SHOWN: usize = 12;

/// m; a link of 1 m has about J = m l²/12 for 1 kg, one of 1.58 m for 0.4 kg.
const LENGTHS: [f64; 5] = [0.7, 0.85, 1.0, 1.25, 1.58];
const FIRST_STEPS: [f64; 3] = [50.0, 500.0, 2000.0];
const SHORTEN: [f64; 2] = [0.5, 0.8];

/// Results for one mechanism under the starting force.
struct Start {
    cost: f64,
    /// Time at which dJ/du is smallest, s.
    vanishes: f64,
    /// The median of ‖Φ‖∞.
    drift: f64,
}

pub fn run(folder: &Path) -> Result<bool, Error> {
    let usual = Settings::usual();
    draw(&usual, &folder.join("assumptions"))?;
    let (mut rows, mut all) = (Vec::new(), Vec::new());
    for length in LENGTHS {
        for friction_joint in 0..usual.links {
            let mechanism = Settings { length, friction_joint, iterations: ITERATIONS, ..usual.clone() };
            let start = start(&Experiment::new(mechanism.clone())?)?;
            for first in FIRST_STEPS {
                for shorten in SHORTEN {
                    let search = LineSearch { first, shorten, ..usual.search };
                    let experiment = Experiment::new(Settings { search, ..mechanism.clone() })?;
                    let (count, cells, record) = judged(&experiment.settings, &start, experiment.optimum()?);
                    rows.push((count, cells));
                    all.push(record);
                }
            }
        }
    }
    rows.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
    let best = rows.first().map_or(0, |(count, _)| *count);
    let heads = vec!["Agree", "l [m], joint", "α, ρ", "J₀", "dJ/du = 0 [s]", "Φ", "J at the end", "Rightmost [s]"];
    let table = Table { heads, rows: rows.into_iter().map(|(_, cells)| cells).collect() };
    let summary = format!(
        "{} combinations; at most {best} of the paper's five numbers agree (marked ✓): J₀ = {} ± {}, the gradient vanishes at {VANISHES} s, where the \
         paper's gradients differ most (we assume that they vanish there), the cart is furthest right at {RIGHTMOST} s (± {NEAR}), the median of Φ is between {:.0e} and {:.0e}, J < {ZERO:.0e} within {ITERATIONS} iterations. \
         l: link length; joint: that with friction; α, ρ: first step of the line search and the factor by which it is shortened. All of these are assumed.",
        table.rows.len(),
        START.0,
        START.1,
        DRIFT.start(),
        DRIFT.end(),
    );
    files::write(&folder.join("assumptions.md"), format!("# Assumptions\n\n{summary}\n\n{}", table.markdown()))?;
    files::write_json(&folder.join("assumptions.json"), &json!(all))?;
    let best = Table { heads: table.heads.clone(), rows: table.rows.iter().take(SHOWN).cloned().collect() };
    let place = folder.display();
    files::print(&format!(
        "{}\n{summary}\nThe table shows the first {SHOWN} combinations; assumptions.md, assumptions.json and the figure are in {place}\n",
        best.text()
    ))?;
    Ok(true)
}

fn start(Experiment { system, inputs, .. }: &Experiment) -> Result<Start, MotionError> {
    let mut solver = Solver::new(system, SolverSettings::default());
    solver.simulate(inputs)?;
    let (drift, times) = (median(&norms(&solver.trajectory().phi(system, solver.inputs())?)), inputs.grid.times());
    let gradient = solver.gradient()?;
    // The controls at the last nodes have hardly any effect, so their derivatives are nearly zero in any case.
    let inner = &gradient.controls.as_slice()[1..times.len() * 9 / 10];
    let smallest = inner.iter().map(|x| x.abs()).enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i + 1);
    Ok(Start { cost: gradient.value, vanishes: times[smallest], drift })
}

/// Number of the paper's numbers that a combination reproduces, with its table row and its JSON record.
fn judged(settings: &Settings, start: &Start, end: &Optimum) -> (usize, Vec<String>, Value) {
    let (LineSearch { first, shorten, .. }, last, rightmost) = (settings.search, end.end().cost, end.cart_rightmost_time());
    let agrees = [
        (start.cost - START.0).abs() <= START.1,
        (start.vanishes - VANISHES).abs() <= NEAR,
        DRIFT.contains(&start.drift),
        last < ZERO,
        (rightmost - RIGHTMOST).abs() <= NEAR,
    ];
    let count = agrees.iter().filter(|same| **same).count();
    let numbers = [
        format!("{:.2}", start.cost),
        format!("{:.2}", start.vanishes),
        format!("{:.0e}", start.drift),
        format!("{last:.0e} ({})", end.iterations()),
        format!("{rightmost:.2}"),
    ];
    let marked = numbers.into_iter().zip(agrees).map(|(text, same)| if same { format!("{text} ✓") } else { text });
    let choice = [
        format!("{count} of 5"),
        format!("{}, {}", settings.length, settings.friction_joint),
        format!("{first}, {shorten}"),
    ];
    let record = json!({
        "link_length_m": settings.length,
        "friction_joint": settings.friction_joint,
        "line_search_alpha": first,
        "line_search_backtrack": shorten,
        "initial_cost": start.cost,
        "gradient_vanishes_s": start.vanishes,
        "position_median": start.drift,
        "final_cost": last,
        "iterations": end.iterations(),
        "cart_rightmost_time_s": rightmost,
        "agrees": {
            "initial_cost": agrees[0],
            "gradient_vanishes": agrees[1],
            "position": agrees[2],
            "final_cost": agrees[3],
            "cart_rightmost": agrees[4],
        },
    });
    (count, choice.into_iter().chain(marked).collect(), record)
}

/// J₀ and the zero of its gradient over the link length, with the paper's values.
fn draw(usual: &Settings, stem: &Path) -> Result<(), Error> {
    let lengths: Vec<f64> = (0..=36).map(|k| 0.5 + 1.3 * f64::from(k) / 36.0).collect();
    let (mut costs, mut zeros) = (Vec::new(), Vec::new());
    for &length in &lengths {
        let start = start(&Experiment::new(Settings { length, ..usual.clone() })?)?;
        costs.push((length, start.cost));
        zeros.push((length, start.vanishes));
    }
    let ends = [lengths[0], lengths[lengths.len() - 1]];
    let level = |y: f64| ends.map(|x| (x, y)).to_vec();
    let right = |series: Series| Series { right_axis: true, ..series };
    let chart = Chart {
        x: Axis::linear("link length [m], not stated in the paper"),
        y: Axis::linear("J at u = 10 N [rad²]"),
        right: Some(Axis::linear("time at which dJ/du vanishes [s]")),
        legend: Place::UpperMiddle,
        series: vec![
            Series::new("J at the start (left axis)", costs, colour::BLUE, Style::Line),
            Series::new("about 15 in the paper", level(START.0), colour::BLUE, Style::Dashed),
            right(Series::new("zero of dJ/du (right axis)", zeros, colour::RED, Style::Circles)),
            right(Series::new(
                "0.52 s, where the paper's gradients differ most",
                level(VANISHES),
                colour::RED,
                Style::Dashed,
            )),
        ],
        ..Chart::default()
    };
    chart.save(stem)
}
