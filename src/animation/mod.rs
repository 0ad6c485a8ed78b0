//! A motion as an animated picture: one HTML page, or SVG.
//!
//! Planar bodies are drawn with their hinges, sliders, rods, springs, cylinders, wheels and contacts, and controls as arrows. User-defined
//! elements have no position in the plane: draw them with [`Scene::draw_spring`](crate::Scene::draw_spring) and
//! [`Scene::draw_rod`](crate::Scene::draw_rod) between points of bodies, or with [`Animation::line`] as a function of the state.
//!
//! Bodies in space are drawn as the homogeneous cuboids with their mass and principal moments of inertia, with their joints, on a floor perpendicular to
//! gravity. The page then shows a view that can be turned; SVG pictures are parallel projections. Bodies in the plane lie in the x–y plane.

mod drawing;
mod figure;
mod flat;
mod isometric;
mod page;
mod shapes;
mod space;
mod text;
mod vector;

use std::path::Path;

use crate::model::FORCE;
use crate::motion::column;
use crate::{Coordinate, Error, Inputs, Mechanics, System, Trajectory};
use figure::Figure;
use space::Space;

/// Maximum number of frames; if there are more nodes, some are left out evenly.
const MOST_FRAMES: usize = 1500;
/// Maximum number of controls, and of coordinates without a body, that are plotted by default.
const MOST_PLOTS: usize = 4;
/// Maximum number of these plots if there are bodies in space: an arm has up to seven joints.
const MOST_PLOTS_IN_SPACE: usize = 7;

/// An animation of a motion, to be written as an HTML page or as an SVG picture.
///
/// ```
/// use hamiltonian_adjoint::{Animation, Grid, Inputs, Settings, Solver, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
/// inputs.controls.fill(10.0);
/// let mut solver = Solver::new(&system, Settings::default());
/// let motion = solver.simulate(&inputs)?.clone();
/// let animation = Animation::new(&system, solver.inputs(), &motion)?.title("A cart with three links");
/// let page = animation.html();
/// assert!(page.starts_with("<!doctype html>") && page.len() < 300_000);
/// // animation.write_html("cart.html")? writes it.
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "an animation shows nothing until it is written"]
pub struct Animation {
    title: String,
    /// The nodes that are shown, their times, s, and their coordinates.
    nodes: Vec<usize>,
    times: Vec<f64>,
    q: Vec<Vec<f64>>,
    figure: Figure,
    /// The bodies in space, if there are any.
    space: Option<Space>,
    plots: Vec<Plot>,
}

/// A quantity over time.
#[derive(Clone, Debug)]
struct Plot {
    name: String,
    unit: String,
    values: Vec<f64>,
}

impl Animation {
    /// An animation of the computed nodes. `inputs` are those of the motion, on the grid that was used:
    /// [`Solver::inputs`](crate::Solver::inputs).
    ///
    /// # Errors
    /// Inputs that do not belong to the motion, a motion without nodes, or coordinates that are not finite.
    pub fn new(system: &System, inputs: &Inputs, motion: &Trajectory) -> Result<Self, Error> {
        motion.check_fits(system, inputs)?;
        if motion.computed == 0 {
            return Err(Error::Incomplete { expected: inputs.grid.nodes(), computed: 0 });
        }
        let every = motion.computed.div_ceil(MOST_FRAMES);
        let mut nodes: Vec<usize> = (0..motion.computed).step_by(every).collect();
        if nodes.last() != Some(&motion.last()) {
            nodes.push(motion.last());
        }
        let states = nodes.iter().map(|&node| Mechanics::at_node(system, inputs, motion, node));
        let states = states.collect::<Result<Vec<Mechanics>, Error>>()?;
        let controls: Vec<Vec<f64>> = Vec::from_iter(
            (0..system.k()).map(|k| nodes.iter().map(|&node| column(&inputs.controls, node)[k]).collect::<Vec<f64>>()),
        );
        let figure = Figure::new(system, &states, &controls);
        let space = Space::new(system, &states);
        let most = if space.is_some() { MOST_PLOTS_IN_SPACE } else { MOST_PLOTS };
        let units = system.sketch().units_of_controls(system.k(), system.n());
        let of_coordinates = system.sketch().units_of_coordinates(system.n());
        let of_control = |k: usize| Plot {
            name: system.control_name(k).to_string(),
            unit: units[k].of(FORCE).to_string(),
            values: controls[k].clone(),
        };
        let mut plots: Vec<Plot> = (0..system.k().min(most)).map(of_control).collect();
        let energy = states.iter().map(Mechanics::energy).collect();
        plots.push(Plot { name: "energy".into(), unit: "J".into(), values: energy });
        let q: Vec<Vec<f64>> = states.iter().map(|at| at.q().to_vec()).collect();
        let drawn: Vec<Coordinate> = system.sketch().bodies.iter().flat_map(|(_, frame)| frame.own_coordinates()).collect();
        let others = (0..system.n()).filter(|&i| drawn.iter().all(|of| of.index() != i)).take(most);
        plots.extend(others.map(|i| Plot {
            name: system.coordinate_name(i).to_string(),
            unit: of_coordinates[i].of(("m", "rad")).into(),
            values: q.iter().map(|q| q[i]).collect(),
        }));
        let times = nodes.iter().map(|&node| motion.times[node]).collect();
        Ok(Animation { title: "Motion".into(), nodes, times, q, figure, space, plots })
    }

    /// Sets the title.
    pub fn title(mut self, title: &str) -> Self {
        self.title = title.to_string();
        self
    }

    /// Adds a plot of a quantity with one value for each node of the motion; values that are not finite leave gaps.
    ///
    /// # Errors
    /// Fewer values than nodes.
    pub fn plot(mut self, name: &str, unit: &str, values: &[f64]) -> Result<Self, Error> {
        let expected = self.nodes.last().map_or(0, |last| last + 1);
        if values.len() < expected {
            return Err(Error::Size { what: "values of a plot (one for each node)", expected, found: values.len() });
        }
        let values = self.nodes.iter().map(|&node| values[node]).collect();
        self.plots.push(Plot { name: name.to_string(), unit: unit.to_string(), values });
        Ok(self)
    }

    /// The motion as one self-contained HTML page: a player with a slider, speeds, trails and plots.
    pub fn html(&self) -> String {
        page::html(self)
    }

    /// The configuration at the last displayed node before `time`, s, as SVG.
    pub fn svg(&self, time: f64) -> String {
        let goes_back = self.times.last() < self.times.first();
        let frame = self.times.iter().rposition(|t| if goes_back { *t >= time } else { *t <= time }).unwrap_or(0);
        match &self.space {
            Some(space) => isometric::still(&space.framed(&self.figure), frame, &self.title),
            None => vector::still(&self.figure.framed(), frame, &self.title),
        }
    }

    /// The motion as an animated SVG that repeats; one cycle takes as long as the motion, or ten seconds if the motion is shorter than 10
    /// µs or longer than 10⁷ s.
    pub fn animated_svg(&self) -> String {
        match &self.space {
            Some(space) => isometric::animated(&space.framed(&self.figure), &self.times, &self.title),
            None => vector::animated(&self.figure.framed(), &self.times, &self.title),
        }
    }

    /// Writes the page. An existing file is replaced only after the whole page was written.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_html(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        text::write_whole(path.as_ref(), &self.html())
    }
}
