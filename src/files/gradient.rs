//! [`Gradient`] to JSON, each value under the name of its input, and directions of inputs from such files.

use nalgebra::{DMatrix, DVector};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::inputs::{by_controls, by_coordinates, controls, coordinates, designs};
use super::names::Named;
use crate::{Error, Gradient, Inputs, Start, System};

const FORMAT: &str = "hamiltonian-adjoint gradient";
const VERSION: u32 = 1;

#[derive(Serialize)]
struct File {
    format: &'static str,
    version: u32,
    /// J.
    value: f64,
    /// Kind of the start.
    start: &'static str,
    #[serde(flatten)]
    derivatives: Derivatives,
    #[serde(skip_serializing_if = "Option::is_none")]
    frozen: Option<Derivatives>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Derivatives {
    /// dJ/du at all nodes.
    controls: Named<Vec<f64>>,
    design: Named<f64>,
    /// dJ/dq₀, and dJ/dv₀ or dJ/dp*₀.
    q0: Named<f64>,
    rate0: Named<f64>,
    steps: Vec<f64>,
}

impl Derivatives {
    fn new(system: &System, gradient: &Gradient) -> Self {
        Derivatives {
            controls: by_controls(system, &gradient.controls),
            design: Named::new(designs(system), gradient.design.iter().copied()),
            q0: by_coordinates(system, gradient.start.q()),
            rate0: by_coordinates(system, gradient.start.rate()),
            steps: gradient.steps.clone(),
        }
    }
}

impl Gradient {
    /// The gradient as JSON, each derivative under the name of its input; those at frozen grid phase, if any, in `frozen`.
    ///
    /// # Errors
    /// A gradient of another system.
    pub fn to_json(&self, system: &System) -> Result<String, Error> {
        let sizes = [
            ("dJ/dq₀", system.n(), self.start.q().len()),
            ("dJ/du: rows (channels)", system.k(), self.controls.nrows()),
            ("dJ/db", system.designs(), self.design.len()),
        ];
        if let Some((what, expected, found)) = sizes.into_iter().find(|(_, expected, found)| expected != found) {
            return Err(Error::Size { what, expected, found });
        }
        let file = File {
            format: FORMAT,
            version: VERSION,
            value: self.value,
            start: kind(&self.start),
            derivatives: Derivatives::new(system, self),
            frozen: self.frozen.as_ref().map(|frozen| Derivatives::new(system, frozen)),
            warnings: self.warnings.iter().map(ToString::to_string).collect(),
        };
        let problem = |error: serde_json::Error| Error::File {
            kind: "gradient",
            place: "the whole file".into(),
            problem: error.to_string(),
        };
        serde_json::to_string_pretty(&file).map_err(problem)
    }
}

fn kind(start: &Start) -> &'static str {
    match start {
        Start::Velocity { .. } => "velocity",
        Start::Momentum { .. } => "momentum",
        Start::Assembled { .. } => "assembled",
    }
}

/// The file of a gradient as a direction.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Direction {
    format: String,
    version: u32,
    start: Option<String>,
    controls: Option<Named<Vec<f64>>>,
    design: Option<Named<f64>>,
    q0: Option<Named<f64>>,
    rate0: Option<Named<f64>>,
    steps: Option<Vec<f64>>,
    #[serde(rename = "value")]
    _value: Option<IgnoredAny>,
    #[serde(rename = "frozen")]
    _frozen: Option<IgnoredAny>,
    #[serde(rename = "warnings")]
    _warnings: Option<IgnoredAny>,
}

impl Inputs {
    /// Reads a direction of these inputs ([`no_change`](Self::no_change)) from JSON as [`Gradient::to_json`] writes it; missing parts are zero.
    ///
    /// # Errors
    /// A malformed file (with line and column), missing or unknown names within a part, lists of wrong length, or another kind of start.
    pub fn direction_from_json(&self, system: &System, json: &str) -> Result<Inputs, Error> {
        const KIND: &str = "direction";
        let wrong = |place: String, problem: String| Error::File { kind: KIND, place, problem };
        let file: Direction = super::read_json(KIND, json)?;
        super::check_format(KIND, (&file.format, file.version), (FORMAT, VERSION))?;
        let expected = kind(&self.start);
        if let Some(found) = file.start.filter(|found| found != expected) {
            return Err(wrong("`start`".into(), format!("the kind `{found}`, but the inputs have `{expected}`")));
        }
        let mut direction = self.no_change();
        if let Some(part) = file.controls {
            let rows = part.in_order(KIND, "controls", controls(system))?;
            let nodes = direction.controls.ncols();
            if let Some((row, name)) = rows.iter().zip(controls(system)).find(|(row, _)| row.len() != nodes) {
                return Err(wrong(format!("`controls`, `{name}`"), format!("{} values for {nodes} nodes", row.len())));
            }
            direction.controls = DMatrix::from_fn(rows.len(), nodes, |k, i| rows[k][i]);
        }
        if let Some(part) = file.design {
            direction.design = DVector::from_vec(part.in_order(KIND, "design", designs(system))?);
        }
        if let Some(part) = file.q0 {
            *direction.start.q_mut() = DVector::from_vec(part.in_order(KIND, "q0", coordinates(system))?);
        }
        if let Some(part) = file.rate0 {
            *direction.start.rate_mut() = DVector::from_vec(part.in_order(KIND, "rate0", coordinates(system))?);
        }
        if let Some(steps) = file.steps {
            direction.grid.steps = steps;
        }
        self.check_direction(&direction, 0)?;
        Ok(direction)
    }
}
