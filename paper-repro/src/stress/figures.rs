//! The figures: errors of energy, constraints and gradients over time and over the step length.

use std::path::Path;

use super::row::{Curve, Quantity};
use crate::error::Error;
use crate::plot::{Axis, Chart, Panels, Place, Series, Style, colour};

/// The size of one of three panels side by side.
const PANEL: (f64, f64) = (430.0, 480.0);

/// An error that says no more than that a motion is no motion.
const BEYOND: f64 = 1e2;

/// Draws both figures into the folder.
pub fn draw(curves: &[Curve], folder: &Path) -> Result<(), Error> {
    for (over_time, name, x) in [(true, "stress_over_time", "time [s]"), (false, "stress_over_step", "step length [s]")] {
        let chart = |(of, title): (Quantity, &str)| {
            let shown = || curves.iter().filter(|curve| curve.over_time == over_time && curve.of == of);
            let mut mechanisms: Vec<&str> = shown().map(mechanism).collect();
            mechanisms.dedup();
            Chart {
                title: title.to_owned(),
                x: Axis::log(x, 0.0),
                y: Axis::log(if of == Quantity::Drift { "‖Φ‖∞ [m, rad]" } else { "relative error" }, 1e-17),
                legend: Place::UpperLeft,
                series: shown().map(|curve| series(curve, &mechanisms)).collect(),
                size: PANEL,
                ..Chart::default()
            }
        };
        let titles = [
            (Quantity::Energy, "energy, largest error so far"),
            (Quantity::Drift, "constraints, largest violation so far"),
            (Quantity::Gradient, "adjoint against complex step"),
        ];
        let panels = Panels { charts: titles.map(chart).to_vec(), columns: 3 };
        panels.save(&folder.join(name))?;
    }
    Ok(())
}

/// The colour tells the mechanism, the style what is done at nodes; a curve ends where its motion has left all bounds.
fn series(curve: &Curve, mechanisms: &[&str]) -> Series {
    let colours = [colour::BLUE, colour::RED, colour::GREEN, colour::ORANGE, colour::PURPLE, colour::BLACK];
    let index = mechanisms.iter().position(|name| *name == mechanism(curve)).unwrap_or(0);
    let style = match curve.name.rsplit_once(", ").map(|(_, how)| how) {
        Some("rebased") => Style::Dashed,
        Some("projected") => Style::Line,
        _ => Style::LineAndCircles,
    };
    let points = curve.points.iter().copied().take_while(|(_, y)| *y <= BEYOND).collect();
    Series::new(&curve.name, points, colours[index % colours.len()], style)
}

/// The name up to the comma.
fn mechanism(curve: &Curve) -> &str {
    curve.name.split(", ").next().unwrap_or(&curve.name)
}
