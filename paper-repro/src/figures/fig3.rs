//! Fig. 3: cost and first-order optimality over the iterations.

use std::path::Path;

use super::rounded;
use crate::error::Error;
use crate::experiment::{Experiment, Optimum};
use crate::plot::{Axis, Chart, Series, Style, colour};
use crate::steepest_descent::{Iterate, LineSearch};
use crate::table::{Row, Verdict};

/// J at u = 10 N with the usual assumptions, from 128-bit arithmetic.
const REFERENCE: f64 = 15.18353832472497;
/// Initial value of the paper's curve, read from its axis.
const PAPER_START: f64 = 15.0;
/// Largest cost that counts as close to zero.
const ZERO: f64 = 1e-3;
/// Iterations after which the paper's cost is close to zero.
const PAPER_ITERATIONS: u32 = 300;

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let optimum = experiment.optimum()?;
    let points = |value: fn(&Iterate) -> f64| -> Vec<(f64, f64)> {
        (0..).zip(&optimum.history).map(|(i, iterate)| (f64::from(i), value(iterate))).collect()
    };
    let cost = Series::new("cost J (left axis)", points(|iterate| iterate.cost), colour::BLUE, Style::Circles);
    let gradients = points(|iterate| iterate.gradient);
    let optimality = Series::new("‖∇J‖∞ (right axis)", gradients, colour::RED, Style::Crosses);
    let optimality = Series { right_axis: true, ..optimality };
    let chart = Chart {
        x: Axis::linear("iteration"),
        y: Axis::linear("cost J [rad²], linear scale"),
        right: Some(Axis::log("‖∇J‖∞ [rad²/N], logarithmic scale", 0.0)),
        series: vec![optimality, cost],
        caption: experiment.settings.caption(3, "", true),
        ..Chart::default()
    };
    chart.save(stem)?;
    Ok(claims(experiment, optimum))
}

fn claims(experiment: &Experiment, optimum: &Optimum) -> Vec<Row> {
    let (start, end, made) = (&optimum.history[0], optimum.end(), optimum.iterations());
    let below = optimum.first_below(1e-10).map_or("never".to_owned(), |i| format!("after {i} iterations"));
    let at_start = rounded(start.cost);
    // If fewer iterations were made than requested, the text states the reason.
    let ended = if made < experiment.settings.iterations as usize {
        ", after which no step of the line search lowers J"
    } else {
        ""
    };
    let at_end = format!("{} after {made} iterations{ended}; below 1e-10 {below}", rounded(end.cost));
    let gradients = format!("{:.1e} and {:.1e} rad²/N", start.gradient, end.gradient);
    let (exact, close) = (start_verdict(experiment, start.cost), end_verdict(experiment, end.cost));
    vec![
        Row::new("Fig. 3", "J at the start, u = 10 N", "about 15 (read from the axis)", at_start, exact),
        Row::new("Fig. 3", "J at the end", "close to zero after 300 iterations", at_end, close),
        Row::new("Fig. 3", "‖∇J‖∞ at the start and at the end", "curve only", gradients, Verdict::NotStated),
    ]
}

/// With the default assumptions the value is known to all digits; with others only the paper's axis can be compared.
fn start_verdict(experiment: &Experiment, cost: f64) -> Verdict {
    let exact = (cost - REFERENCE).abs() <= 1e-9;
    if experiment.settings.usual_mechanism() && !exact {
        Verdict::Failed
    } else {
        Verdict::reproduced_if((cost - PAPER_START).abs() < 0.5)
    }
}

/// With the default assumptions and the paper's number of iterations the descent must succeed; otherwise it may end elsewhere.
fn end_verdict(experiment: &Experiment, cost: f64) -> Verdict {
    let settings = &experiment.settings;
    let must = settings.usual_mechanism() && settings.search == LineSearch::USUAL && settings.iterations >= PAPER_ITERATIONS;
    let close = cost < ZERO;
    if must && !close { Verdict::Failed } else { Verdict::reproduced_if(close) }
}
