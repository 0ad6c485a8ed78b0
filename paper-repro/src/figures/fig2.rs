//! Fig. 2: four snapshots of the swing-up under the identified force.

use std::path::Path;

use super::{link, pose, trail};
use crate::error::Error;
use crate::experiment::{Experiment, Optimum};
use crate::plot::{Axis, Chart, Panels, Series, Style, colour};
use crate::statistics::{largest, range};
use crate::table::{Row, Verdict};

/// Number of pictures; the first shows the cart at its rightmost position.
const FRAMES: usize = 4;
/// Time of this position in the paper, s, and the accepted deviation: two nodes.
pub const PAPER_RIGHTMOST: f64 = 1.26;
pub const NEAR: f64 = 0.04;

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let optimum = experiment.optimum()?;
    let pictures: Vec<Chart> = frames(optimum).map(|node| picture(experiment, optimum, node)).collect();
    // All pictures show the same region of the plane, with a margin around the mechanism.
    let points = || pictures.iter().flat_map(|picture| &picture.series).flat_map(|shape| &shape.points);
    let extents = [range(points().map(|point| point.0)), range(points().map(|point| point.1))];
    let room = 0.06 * extents.map(|(low, high)| high - low).into_iter().fold(0.0, f64::max);
    let axis = |label, (low, high): (f64, f64)| Axis { range: Some((low - room, high + room)), ..Axis::linear(label) };
    let axes =
        |picture| Chart { x: axis("x [m]", extents[0]), y: axis("y [m]", extents[1]), ..picture }.equally_scaled(350.0);
    let mut panels = Panels::new(pictures, 2);
    panels.charts = panels.charts.into_iter().map(axes).collect();
    panels.charts[0].caption = experiment.settings.caption(2, "", true);
    panels.save_shapes(stem)?;
    Ok(claims(experiment, optimum))
}

/// Evenly spaced nodes from the rightmost position on, the last before the end; from the start if the cart is rightmost at the end.
fn frames(optimum: &Optimum) -> impl Iterator<Item = usize> {
    let (rightmost, end) = (optimum.cart_rightmost(), optimum.motion.last());
    let first = if rightmost + FRAMES > end { 0 } else { rightmost };
    (0..FRAMES).map(move |frame| first + frame * (end - first) / FRAMES)
}

fn picture(experiment: &Experiment, optimum: &Optimum, node: usize) -> Chart {
    let (motion, length) = (&optimum.motion, experiment.settings.length);
    let at = |node: usize, colour, width| pose(motion.q.column(node).as_view(), length, colour, width);
    let mut series = at(0, colour::GREY, 2.0);
    series.extend(at(motion.last(), colour::BLUE, 2.0));
    series.push(trail(last_tips(experiment, optimum, node), colour::RED));
    series.extend(at(node, colour::RED, 3.0));
    let key = [
        ("snapshot, with the path of the free end", colour::RED),
        ("initial position", colour::GREY),
        ("final position", colour::BLUE),
    ];
    series.extend(key.map(|(name, colour)| Series { width: 3.0, ..Series::new(name, Vec::new(), colour, Style::Line) }));
    Chart { title: format!("t = {:.2} s", motion.times[node]), series, ..Chart::default() }
}

/// The path of the chain's free end up to the node.
fn last_tips(experiment: &Experiment, optimum: &Optimum, node: usize) -> Vec<(f64, f64)> {
    let (q, length) = (&optimum.motion.q, experiment.settings.length);
    let last = q.nrows() - 3;
    (0..=node).map(|i| link((q[(last, i)], q[(last + 1, i)], q[(last + 2, i)]), length)[1]).collect()
}

fn claims(experiment: &Experiment, optimum: &Optimum) -> Vec<Row> {
    let time = optimum.cart_rightmost_time();
    let same = (time - PAPER_RIGHTMOST).abs() <= NEAR;
    let why = if same { "" } else { "; depends on the assumed link length, friction joint and line search" };
    let example = experiment.settings.example();
    let end = optimum.motion.q.column(optimum.motion.last());
    let worst = largest((1..=example.links).map(|j| end[3 * j + 2] - example.target_angle));
    let rightmost =
        ("time of the cart's rightmost position, to two nodes", format!("{PAPER_RIGHTMOST} s"), format!("{time:.2} s{why}"));
    let upright = format!("largest |φ_j − π/2| = {worst:.1e} rad");
    vec![
        Row::new("Fig. 2", rightmost.0, rightmost.1, rightmost.2, Verdict::reproduced_if(same)),
        // A deviation of a hundredth of a radian is not visible.
        Row::new("Fig. 2", "final position", "all links upright", upright, Verdict::reproduced_if(worst < 0.01)),
    ]
}
