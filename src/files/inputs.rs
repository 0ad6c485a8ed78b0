//! [`Inputs`] to and from JSON.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::names::Named;
use crate::{Coordinate, Error, Grid, Held, Inputs, Multiplier, Start, System};

const FORMAT: &str = "hamiltonian-adjoint inputs";
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u32,
    grid: GridPart,
    start: StartPart,
    /// The values at all nodes.
    controls: Named<Vec<f64>>,
    design: Named<f64>,
    /// Events and their nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    events: Vec<(String, usize)>,
    /// The controls that are functions of time although events move the nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    controls_in_time: Vec<String>,
    /// The numbers of the constraint equations that are open at the start; if it is missing, those of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    open: Option<Vec<usize>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GridPart {
    /// Time of the start, s.
    start: f64,
    steps: Vec<f64>,
    stages: usize,
    /// Numbers of nodes before and after, for a part of a longer motion.
    #[serde(default, skip_serializing_if = "is_whole")]
    around: [usize; 2],
}

fn is_whole(around: &[usize; 2]) -> bool {
    *around == [0, 0]
}

/// q₀, and v₀ or p*₀; for a guess, also the held coordinates and velocities.
#[derive(Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum StartPart {
    Velocity { q: Named<f64>, v: Named<f64> },
    Momentum { q: Named<f64>, p_star: Named<f64> },
    Assembled { q: Named<f64>, v: Named<f64>, held_coordinates: Vec<String>, held_velocities: Vec<String> },
}

pub(super) fn coordinates(system: &System) -> impl Iterator<Item = &str> {
    (0..system.n()).map(|i| system.coordinate_name(i))
}

pub(super) fn controls(system: &System) -> impl Iterator<Item = &str> {
    (0..system.k()).map(|k| system.control_name(k))
}

pub(super) fn designs(system: &System) -> impl Iterator<Item = &str> {
    (0..system.designs()).map(|p| system.design_name(p))
}

pub(super) fn by_coordinates(system: &System, x: &DVector<f64>) -> Named<f64> {
    Named::new(coordinates(system), x.iter().copied())
}

pub(super) fn by_controls(system: &System, u: &DMatrix<f64>) -> Named<Vec<f64>> {
    Named::new(controls(system), u.row_iter().map(|row| row.iter().copied().collect()))
}

impl Inputs {
    /// The inputs as JSON, each value under its name and to the last bit.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, scenes::CartPendulum};
    ///
    /// let system = CartPendulum::default().scene().compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.1));
    /// inputs.controls.fill(1.0 / 3.0);
    /// let json = inputs.to_json(&system)?;
    /// assert!(json.contains("\"force on the cart\""));
    /// assert_eq!(Inputs::from_json(&system, &json)?, inputs);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// Inputs that do not fit the system.
    pub fn to_json(&self, system: &System) -> Result<String, Error> {
        self.check(system)?;
        let by_name = |x: &DVector<f64>| by_coordinates(system, x);
        let names =
            |held: &[Coordinate]| held.iter().map(|q| system.coordinate_name(q.index()).to_string()).collect::<Vec<_>>();
        let start = match &self.start {
            Start::Velocity { q, v } => StartPart::Velocity { q: by_name(q), v: by_name(v) },
            Start::Momentum { q, p_star } => StartPart::Momentum { q: by_name(q), p_star: by_name(p_star) },
            Start::Assembled { q, v, held } => StartPart::Assembled {
                q: by_name(q),
                v: by_name(v),
                held_coordinates: names(&held.coordinates),
                held_velocities: names(&held.velocities),
            },
        };
        let file = File {
            format: FORMAT.into(),
            version: VERSION,
            grid: GridPart {
                start: self.grid.start,
                steps: self.grid.steps.clone(),
                stages: self.grid.stages,
                around: self.grid.around,
            },
            start,
            controls: by_controls(system, &self.controls),
            design: Named::new(designs(system), self.design.iter().copied()),
            events: self.events.iter().map(|of| (system.event_name(of.event.index()).to_string(), of.node)).collect(),
            controls_in_time: self.controls_in_time.iter().map(|of| system.control_name(of.index()).to_string()).collect(),
            open: (self.open != system.open_equations()).then(|| self.open.iter().map(Multiplier::index).collect()),
        };
        serde_json::to_string_pretty(&file).map_err(|error| wrong("the whole file", &error.to_string()))
    }

    /// Reads inputs from JSON as [`to_json`](Self::to_json) writes it.
    ///
    /// # Errors
    /// A malformed file (with line and column), missing or unknown names, or lists of wrong length.
    pub fn from_json(system: &System, json: &str) -> Result<Self, Error> {
        let file: File = super::read_json("inputs", json)?;
        super::check_format("inputs", (&file.format, file.version), (FORMAT, VERSION))?;
        let state = |part: &str, x: Named<f64>| x.in_order("inputs", part, coordinates(system)).map(DVector::from_vec);
        let start = match file.start {
            StartPart::Velocity { q, v } => Start::Velocity { q: state("start.q", q)?, v: state("start.v", v)? },
            StartPart::Momentum { q, p_star } => {
                Start::Momentum { q: state("start.q", q)?, p_star: state("start.p_star", p_star)? }
            }
            StartPart::Assembled { q, v, held_coordinates, held_velocities } => Start::Assembled {
                q: state("start.q", q)?,
                v: state("start.v", v)?,
                held: Held {
                    coordinates: held(system, "start.held_coordinates", &held_coordinates)?,
                    velocities: held(system, "start.held_velocities", &held_velocities)?,
                },
            },
        };
        let of = file.grid;
        let grid = Grid { start: of.start, steps: of.steps, stages: of.stages, around: of.around };
        let rows = file.controls.in_order("inputs", "controls", controls(system))?;
        let nodes = grid.nodes();
        for (row, name) in rows.iter().zip(controls(system)) {
            if row.len() != nodes {
                let problem = format!("{} values for {nodes} nodes (one more than steps)", row.len());
                return Err(wrong(&format!("`controls`, `{name}`"), &problem));
            }
        }
        let controls = DMatrix::from_fn(rows.len(), nodes, |k, i| rows[k][i]);
        let design = DVector::from_vec(file.design.in_order("inputs", "design", designs(system))?);
        let events = file.events.iter().map(|(name, node)| {
            let event = (0..system.events()).find(|&event| system.event_name(event) == name);
            let event = event.ok_or_else(|| wrong("`events`", &format!("the system has no `{name}`")))?;
            Ok(system.event(event).at(*node))
        });
        let events = events.collect::<Result<_, Error>>()?;
        let in_time = file.controls_in_time.iter().map(|name| {
            let control = (0..system.k()).find(|&k| system.control_name(k) == name);
            control
                .map(|k| system.control(k))
                .ok_or_else(|| wrong("`controls_in_time`", &format!("the system has no `{name}`")))
        });
        let controls_in_time = in_time.collect::<Result<_, Error>>()?;
        let open = file.open.map_or_else(|| Ok(system.open_equations()), |open| equations(system, &open))?;
        let inputs = Inputs { grid, start, controls, design, events, controls_in_time, open };
        inputs.check(system)?;
        Ok(inputs)
    }
}

fn equations(system: &System, open: &[usize]) -> Result<Vec<Multiplier>, Error> {
    let missing = |j: usize| wrong("`open`", &format!("the system has no constraint equation {j}"));
    open.iter().map(|&j| if j < system.m() { Ok(system.multiplier(j)) } else { Err(missing(j)) }).collect()
}

fn held(system: &System, part: &str, names: &[String]) -> Result<Vec<Coordinate>, Error> {
    let find = |name: &String| {
        let at = coordinates(system).position(|known| known == name);
        at.map(|i| system.coordinate(i)).ok_or_else(|| wrong(&format!("`{part}`"), &format!("the system has no `{name}`")))
    };
    names.iter().map(find).collect()
}

fn wrong(place: &str, problem: &str) -> Error {
    Error::File { kind: "inputs", place: place.to_string(), problem: problem.to_string() }
}
