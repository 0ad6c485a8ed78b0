//! The derivative of a bouncing ball's height over the number of steps: of the discrete motion, at frozen grid phase, with located events, and of the motion
//! itself.

use std::path::Path;

use hamiltonian_adjoint::{Cost, CostPoint, Force, ForcePoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, System};
use nalgebra::SVector;

use crate::error::Error;
use crate::files;
use crate::plot::{Axis, Caption, Chart, Place, Series, Style, colour};

/// dz/dh of the motion, by an integration that finds the contact.
const TRUE: f64 = 0.502_377;
const DURATION: f64 = 0.8;
/// The range of the vertical axis.
const SHOWN: (f64, f64) = (-3.0, 4.0);

/// A floor that pushes with k depth^1.5.
struct Floor;

impl Force<1, 0, 1> for Floor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * (-at.q[0]).max(S::zero()).powf(1.5)])
    }
}

struct Height;

impl Cost<1> for Height {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

fn ball() -> Result<System, hamiltonian_adjoint::Error> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let ball = scene.particle("ball", 1.0, [0.0, 1.0]);
    scene.force("floor", Floor, [ball.coordinates[1]], [], [1e6.into()]);
    scene.cost("z", Height, Sum::Terminal, [ball.coordinates[1]], [], [], []);
    scene.event("contact", Height, [ball.coordinates[1]], [], [], []);
    scene.compile()
}

/// Draws truth.svg; true if from 1,000 steps on the derivatives at frozen grid phase are right to 5 %, and those with located events to 1 %.
pub fn run(folder: &Path) -> Result<bool, Error> {
    let system = ball()?;
    let mut solver = Solver::new(&system, Settings::default());
    let (mut plain, mut frozen, mut located) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..240 {
        let steps = (400.0 * 16f64.powf(f64::from(k) / 239.0)) as usize;
        let inputs = Inputs::at_rest(&system, Grid::uniform(steps, DURATION / steps as f64));
        solver.simulate(&inputs)?;
        let gradient = solver.gradient()?;
        let of = |gradient: &hamiltonian_adjoint::Gradient| (steps as f64, gradient.start.q()[1]);
        plain.push(of(gradient));
        frozen.extend(gradient.frozen.as_deref().map(of));
        let phases = solver.find_phases(&inputs, 4)?;
        solver.simulate(&phases)?;
        located.push((phases.grid.steps.len() as f64, solver.gradient()?.start.q()[1]));
    }
    // With 12 steps in the contact, or more.
    let far = |points: &[(f64, f64)]| {
        let fine = points.iter().filter(|point| point.0 >= 1000.0);
        fine.map(|point| (point.1 - TRUE).abs()).fold(0.0, f64::max)
    };
    let off = [far(&plain), far(&frozen), far(&located)];
    let shown = plain.iter().map(|&(x, y)| (x, if (SHOWN.0..SHOWN.1).contains(&y) { y } else { f64::NAN }));
    let chart = Chart {
        caption: Caption {
            text: "The derivative of the height of a ball after one bounce, by the height of its fall.".into(),
            shown: false,
        },
        x: Axis::log("steps in 0.8 s", 0.0),
        y: Axis { range: Some(SHOWN), ..Axis::linear("dz/dh") },
        legend: Place::UpperRight,
        series: vec![
            Series::new("of the discrete motion", shown.collect(), colour::RED, Style::Circles),
            Series::new(
                "of the motion",
                [plain[0], plain[239]].iter().map(|p| (p.0, TRUE)).collect(),
                colour::BLACK,
                Style::Dashed,
            ),
            Series::new("at frozen grid phase", frozen, colour::BLUE, Style::Line),
            Series::new("with located events", located, colour::GREEN, Style::Line),
        ],
        ..Chart::default()
    };
    chart.save(&folder.join("truth"))?;
    files::print(&format!(
        "dz/dh of a bouncing ball is {TRUE}. Largest difference on grids of 1,000 to 6,400 steps: {:.1}, at frozen grid phase {:.3}, with located events {:.4}\ntruth.svg is in {}\n",
        off[0],
        off[1],
        off[2],
        folder.display()
    ))?;
    Ok(off[1] < 0.05 * TRUE && off[2] < 0.01 * TRUE)
}
