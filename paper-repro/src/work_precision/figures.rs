//! The figures: errors over run time and over steps, and errors of several methods for the gradient.

use std::path::Path;

use super::Measured;
use super::convergence::Convergence;
use super::knots::Reading;
use super::methods::Methods;
use super::stiff;
use crate::error::Error;
use crate::plot::{Axis, Chart, Panels, Place, Point, Series, Style, colour};
use crate::statistics::range;

/// The size of one of two panels side by side.
const PANEL: (f64, f64) = (450.0, 420.0);
/// Range of the relative errors that are shown.
const ERRORS: (f64, f64) = (1e-15, 1e-1);

/// Draws all figures into the folder.
pub fn draw(measured: &Measured, folder: &Path) -> Result<(), Error> {
    let all: Vec<&Convergence> = measured.convergence.iter().collect();
    let smooth: Vec<&Convergence> = all.iter().copied().filter(|scheme| scheme.reading == Reading::Piece).collect();
    let (cost, gradient) = ("cost J", "gradient dJ/d(101 knots)");
    let milliseconds = |points: Vec<Point>| points.into_iter().map(|(time, error)| (1e3 * time, error)).collect();
    let over_time = [
        chart(cost, smooth.iter().map(|scheme| series(scheme, scheme.label(), milliseconds(scheme.cost_over_time())))),
        chart(gradient, all.iter().map(|scheme| series(scheme, scheme.label(), milliseconds(scheme.gradient_over_time())))),
    ];
    side_by_side(over_time, "run time [ms]").save(&folder.join("work_precision"))?;

    let label = |scheme: &Convergence, order: Option<f64>| match order {
        Some(order) => format!("{}: {order:.2}", scheme.label()),
        None => scheme.label(),
    };
    let titles = [cost, gradient].map(|title| format!("{title}, observed orders"));
    let over_steps = [
        chart(&titles[0], smooth.iter().map(|it| series(it, label(it, it.order_of_cost), it.cost_over_steps()))),
        chart(&titles[1], all.iter().map(|it| series(it, label(it, it.order_of_gradient), it.gradient_over_steps()))),
    ];
    side_by_side(over_steps, "steps of the rule: stages × macro steps").save(&folder.join("convergence"))?;
    stiff::chart(&measured.stiff).save(&folder.join("stiff"))?;
    methods(&measured.methods).save(&folder.join("gradient_methods"))
}

fn series(scheme: &Convergence, name: String, points: Vec<Point>) -> Series {
    let smooth = scheme.reading == Reading::Piece;
    let style = if smooth { Style::LineAndCircles } else { Style::Dashed };
    Series::new(name, points, scheme.colour, style)
}

fn chart(title: &str, series: impl Iterator<Item = Series>) -> Chart {
    Chart {
        title: title.to_owned(),
        y: Axis { range: Some(ERRORS), ..Axis::log("relative error", 0.0) },
        legend: Place::LowerLeft,
        series: series.collect(),
        size: PANEL,
        ..Chart::default()
    }
}

/// The panels with a common range of their horizontal axes.
fn side_by_side(charts: [Chart; 2], x: &str) -> Panels {
    let values = charts.iter().flat_map(|chart| &chart.series).flat_map(|it| &it.points).map(|it| it.0);
    let axis = Axis { range: Some(stretch(values)), ..Axis::log(x, 0.0) };
    let charts = charts.map(|chart| Chart { x: axis.clone(), ..chart });
    Panels::new(charts.to_vec(), 2)
}

/// Range from the least to the greatest value with a margin on a logarithmic axis.
fn stretch(values: impl Iterator<Item = f64>) -> (f64, f64) {
    const ROOM: f64 = 1.5;
    let (least, greatest) = range(values);
    (least / ROOM, greatest * ROOM)
}

/// Errors over the step size, with constant levels for methods without step size, and least errors over the time.
fn methods(measured: &Methods) -> Panels {
    let named = |name: &str, colour, style, points| Series::new(name, points, colour, style);
    // The third curve is complex step, too.
    let exact = || measured.exact.iter().zip([(colour::BLACK, Style::Line), (colour::ORANGE, Style::Dashed)]);
    let stepped = || measured.stepped.iter().zip([colour::BLUE, colour::RED, colour::GREEN]);
    let (least, greatest) = stretch(measured.stepped.iter().flat_map(|method| &method.errors).map(|run| run.0));
    let level = |error| vec![(least, error), (greatest, error)];
    let levels = exact().map(|(it, (colour, style))| named(it.name, colour, style, level(it.error)));
    let curves = stepped().map(|(it, colour)| named(it.name, colour, Style::LineAndCircles, it.errors.clone()));
    let over_size = Chart {
        x: Axis { range: Some((least, greatest)), ..Axis::log("step size [N]", 0.0) },
        y: Axis { range: Some((1e-15, 1e2)), ..Axis::log("relative error", 0.0) },
        legend: Place::UpperRight,
        ..chart("101 derivatives, over step size", curves.chain(levels))
    };
    let costs = measured.exact.iter().map(|it| it.cost).chain(measured.stepped.iter().map(|it| it.cost));
    let times = stretch(costs);
    let best = stepped().map(|(it, colour)| named(it.name, colour, Style::Circles, vec![(it.cost, it.best().1)]));
    let points = exact().map(|(it, (colour, _))| named(it.name, colour, Style::Circles, vec![(it.cost, it.error)]));
    let over_cost = Chart {
        title: "101 derivatives, over time".to_owned(),
        x: Axis { range: Some(times), ..Axis::log("time [simulations], error at the best step size", 0.0) },
        series: best.chain(points).collect(),
        ..over_size.clone()
    };
    Panels::new(vec![over_size, over_cost], 2)
}
