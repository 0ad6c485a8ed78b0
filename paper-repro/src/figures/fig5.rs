//! Fig. 5: the force on the cart in the course of the optimisation.

use std::path::Path;

use super::{rounded, with_kink};
use crate::error::Error;
use crate::experiment::{Experiment, Optimum};
use crate::plot::{Axis, Chart, Series, Style, colour, scientific};
use crate::statistics::range;
use crate::table::{Row, Verdict};

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let (optimum, times) = (experiment.optimum()?, experiment.inputs.grid.times());
    let colours = [colour::GREY, colour::GREEN, colour::RED, colour::BLUE];
    let series = snapshots(optimum).into_iter().zip(colours).map(|(iteration, colour)| {
        let iterate = &optimum.history[iteration];
        let name = format!("iteration {iteration}, J = {}", scientific(&rounded(iterate.cost)));
        let force = Series::over(&times, &iterate.u, name, colour, Style::Line);
        if iteration == optimum.iterations() { with_kink(force, 1) } else { force }
    });
    let chart = Chart {
        x: Axis::linear("time t [s]"),
        y: Axis::linear("force on the cart F [N]"),
        series: series.collect(),
        caption: experiment.settings.caption(
            5,
            ": the start, the first iterations at which J is below 1/4 and 1/100 of its initial value, and the last iteration",
            true,
        ),
        ..Chart::default()
    };
    chart.save(stem)?;
    Ok(claims(optimum))
}

/// The start, the first iterates whose cost is below 1/4 and 1/100 of the initial cost, and the end.
fn snapshots(optimum: &Optimum) -> Vec<usize> {
    let (start, end) = (optimum.history[0].cost, optimum.history.len() - 1);
    let first_below = |share: f64| optimum.first_below(share * start).unwrap_or(end);
    let mut snapshots = vec![0, first_below(0.25), first_below(0.01), end];
    snapshots.dedup();
    snapshots
}

fn claims(optimum: &Optimum) -> Vec<Row> {
    let [start, end] = [&optimum.history[0], optimum.end()].map(|iterate| range(iterate.u.iter().copied()));
    let (first, verdict) = match start {
        (10.0, 10.0) => ("10 N, constant".to_owned(), Verdict::Reproduced),
        (least, most) => (format!("{least} to {most} N"), Verdict::Failed),
    };
    let last = format!("{:.0} to {:.0} N", end.0, end.1);
    vec![
        Row::new("Fig. 5", "force at the start", "10 N, constant", first, verdict),
        Row::new("Fig. 5", "force at the end", "curve only", last, Verdict::NotStated),
    ]
}
