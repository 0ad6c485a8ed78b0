//! The figures: errors of energy, constraints and gradients over time and over the step length.

use std::path::Path;

use super::row::{Curve, Quantity};
use crate::error::Error;
use crate::plot::{Axis, Colour, Legend, LineChart, Panels, Series, Style};

/// The size of one of three panels side by side.
const PANEL: (f64, f64) = (430.0, 420.0);

/// An error that says no more than that a motion is no motion.
const BEYOND: f64 = 1e2;

/// Draws both figures into the folder.
///
/// # Errors
/// Files that cannot be written.
pub fn draw(curves: &[Curve], folder: &Path) -> Result<(), Error> {
    for (over_time, name, x) in [(true, "stress_over_time", "time [s]"), (false, "stress_over_step", "step length [s]")] {
        let chart = |(of, title): (Quantity, &str)| {
            let shown = || curves.iter().filter(|curve| curve.over_time == over_time && curve.of == of);
            let mut mechanisms: Vec<&str> = shown().map(mechanism).collect();
            mechanisms.dedup();
            LineChart {
                title: title.to_owned(),
                x: Axis::log(x, 0.0),
                y: Axis::log(if of == Quantity::Drift { "‖Φ‖∞ [m, rad]" } else { "relative error" }, 1e-17),
                legend: Legend::Above,
                series: shown().map(|curve| series(curve, &mechanisms)).collect(),
                size: PANEL,
                ..LineChart::default()
            }
        };
        let titles = [
            (Quantity::Energy, "energy, largest error so far"),
            (Quantity::Drift, "constraints, largest violation so far"),
            (Quantity::Gradient, "adjoint against complex step"),
        ];
        let panels = Panels { charts: titles.map(chart).to_vec(), columns: 3, ..Panels::default() };
        panels.save(&folder.join(name))?;
    }
    Ok(())
}

/// The colour tells the mechanism, the style what is done at nodes; a curve ends where its motion has left all bounds.
fn series(curve: &Curve, mechanisms: &[&str]) -> Series {
    let colours = [Colour::BLUE, Colour::RED, Colour::GREEN, Colour::ORANGE, Colour::PURPLE, Colour::BLACK];
    let index = mechanisms.iter().position(|name| *name == mechanism(curve)).unwrap_or(0);
    Series {
        name: curve.name.clone(),
        points: curve.points.iter().copied().take_while(|(_, y)| *y <= BEYOND).collect(),
        colour: colours[index % colours.len()],
        style: match curve.name.rsplit_once(", ").map(|(_, how)| how) {
            Some("rebased") => Style::Dashed,
            Some("projected") => Style::Line,
            _ => Style::LineAndCircles,
        },
        right_axis: false,
    }
}

/// The name up to the comma.
fn mechanism(curve: &Curve) -> &str {
    curve.name.split(", ").next().unwrap_or(&curve.name)
}
