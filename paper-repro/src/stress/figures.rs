//! The figures: errors of energy, constraints and gradients over time and over the step length.

use std::path::Path;

use super::row::{Curve, Quantity};
use crate::error::Error;
use crate::plot::{Axis, Chart, Colour, Panels, Place, Series, Style, colour};
use crate::statistics::distinct;

/// The size of one of three panels side by side.
const PANEL: (f64, f64) = (430.0, 480.0);

/// Larger errors are not shown: the motion is meaningless.
const BEYOND: f64 = 1e2;

const PANELS: [(Quantity, &str, &str); 3] = [
    (Quantity::Energy, "energy, largest error so far", "relative error"),
    (Quantity::Drift, "constraints, largest violation so far", "‖Φ‖∞ [m, rad]"),
    (Quantity::Gradient, "adjoint against complex step", "relative error"),
];

const TREATMENTS: [(&str, Style); 3] =
    [("as integrated", Style::LineAndCircles), ("rebased", Style::Dashed), ("projected", Style::Line)];

/// Draws both figures into the folder.
pub fn draw(curves: &[Curve], folder: &Path) -> Result<(), Error> {
    let mechanisms = distinct(curves.iter().map(mechanism));
    for (over_time, name, x) in [(true, "stress_over_time", "time [s]"), (false, "stress_over_step", "step length [s]")] {
        let shown = |of| curves.iter().filter(move |curve| curve.over_time == over_time && curve.of == of);
        let charts = PANELS.map(|(of, title, y)| Chart {
            title: title.to_owned(),
            x: Axis::log(x, 0.0),
            y: Axis::log(y, 1e-17),
            legend: Place::UpperLeft,
            series: series(shown(of), &mechanisms),
            size: PANEL,
            ..Chart::default()
        });
        Panels::new(charts.to_vec(), 3).save(&folder.join(name))?;
    }
    Ok(())
}

/// The curves of a panel, followed by samples that explain their colours and styles.
fn series<'a>(curves: impl Iterator<Item = &'a Curve>, mechanisms: &[&str]) -> Vec<Series> {
    const COLOURS: [Colour; 6] = [colour::BLUE, colour::RED, colour::GREEN, colour::ORANGE, colour::PURPLE, colour::BLACK];
    let (mut known, mut used) = (Vec::new(), Vec::new());
    let mut all = Vec::new();
    for curve in curves {
        let (index, treatment) = (mechanisms.iter().position(|name| *name == mechanism(curve)), treatment(curve));
        let index = index.unwrap_or(0);
        known.extend((!known.contains(&index)).then_some(index));
        used.extend((!used.contains(&treatment)).then_some(treatment));
        let points = curve.points.iter().copied().take_while(|(_, y)| *y <= BEYOND).collect();
        let line = Series::new(&curve.name, points, COLOURS[index % COLOURS.len()], TREATMENTS[treatment].1);
        all.push(Series { listed: false, ..line });
    }
    used.sort_unstable();
    let sample = |name, colour, style| Series::new(name, Vec::new(), colour, style);
    all.extend(known.iter().map(|index| sample(mechanisms[*index], COLOURS[index % COLOURS.len()], Style::Line)));
    all.extend(used.iter().map(|index| sample(TREATMENTS[*index].0, colour::GREY, TREATMENTS[*index].1)));
    all
}

/// The part of the name before the first comma.
fn mechanism(curve: &Curve) -> &str {
    curve.name.split(", ").next().unwrap_or(&curve.name)
}

/// Index of the treatment at nodes, which is named after the last comma.
fn treatment(curve: &Curve) -> usize {
    let last = curve.name.rsplit(", ").next();
    TREATMENTS.iter().position(|(name, _)| last == Some(name)).unwrap_or(0)
}
