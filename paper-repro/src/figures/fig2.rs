//! Fig. 2: four snapshots of the swing-up under the identified force.

use std::path::Path;

use super::{link, shapes};
use crate::error::Error;
use crate::experiment::{Experiment, Optimum};
use crate::plot::{Scene, SceneChart, Shape, colour};
use crate::statistics::largest;
use crate::table::{Row, Verdict};

/// Pictures, the first with the cart at its right-most position.
const FRAMES: usize = 4;
/// When that is in the paper, s.
const PAPER_RIGHTMOST: f64 = 1.26;

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let optimum = experiment.optimum()?;
    let scenes = frames(optimum).map(|node| scene(experiment, optimum, node)).collect();
    let key = [
        ("snapshot, with the path of the free end", colour::RED),
        ("initial position", colour::GREY),
        ("final position", colour::BLUE),
    ];
    let chart =
        SceneChart { labels: Some(["x [m]", "y [m]"]), key: key.to_vec(), scenes, columns: 2, ..SceneChart::default() };
    chart.save(stem)?;
    Ok(claims(experiment, optimum))
}

/// Nodes from the right-most position on, evenly spaced, the last before the end.
fn frames(optimum: &Optimum) -> impl Iterator<Item = usize> {
    let (first, end) = (optimum.cart_rightmost(), optimum.motion.computed.saturating_sub(1));
    (0..FRAMES).map(move |frame| first + frame * (end - first) / FRAMES)
}

fn scene(experiment: &Experiment, optimum: &Optimum, node: usize) -> Scene {
    let (motion, length) = (&optimum.motion, experiment.settings.length);
    let pose = |node: usize, colour, width| shapes(motion.q.column(node).as_view(), length, colour, width);
    let mut shapes = pose(0, colour::GREY, 2.0);
    shapes.extend(pose(motion.computed - 1, colour::BLUE, 2.0));
    let tip = last_tips(experiment, optimum, node);
    shapes.push(Shape::trail(tip, colour::RED));
    shapes.extend(pose(node, colour::RED, 3.0));
    Scene { title: format!("t = {:.2} s", motion.times[node]), shapes }
}

/// The way of the chain's free end up to the node.
fn last_tips(experiment: &Experiment, optimum: &Optimum, node: usize) -> Vec<(f64, f64)> {
    let (q, length) = (&optimum.motion.q, experiment.settings.length);
    let last = q.nrows() - 3;
    (0..=node).map(|i| link((q[(last, i)], q[(last + 1, i)], q[(last + 2, i)]), length)[1]).collect()
}

fn claims(experiment: &Experiment, optimum: &Optimum) -> Vec<Row> {
    let time = optimum.cart_rightmost_time();
    // Half a step of the grid.
    let same = (time - PAPER_RIGHTMOST).abs() < 0.01;
    let why = if same { "" } else { "; depends on the assumed link length, friction joint and line search" };
    let example = experiment.settings.example();
    let end = optimum.motion.q.column(optimum.motion.computed - 1);
    let worst = largest((1..=example.links).map(|j| end[3 * j + 2] - example.target_angle));
    let rightmost = ("time of the cart's right-most position", format!("{PAPER_RIGHTMOST} s"), format!("{time:.2} s{why}"));
    let upright = format!("largest |φ_j − π/2| = {worst:.1e} rad");
    vec![
        Row::new("Fig. 2", rightmost.0, rightmost.1, rightmost.2, Verdict::reproduced_if(same)),
        // A hundredth of a radian cannot be seen.
        Row::new("Fig. 2", "final position", "all links upright", upright, Verdict::reproduced_if(worst < 0.01)),
    ]
}
