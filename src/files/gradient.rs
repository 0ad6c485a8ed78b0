//! [`Gradient`] to JSON, each value under the name of its input.

use serde::Serialize;

use super::inputs::{by_controls, by_coordinates, designs};
use super::names::Named;
use crate::{Error, Gradient, Start, System};

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
            format: "hamiltonian-adjoint gradient",
            version: 1,
            value: self.value,
            start: match self.start {
                Start::Velocity { .. } => "velocity",
                Start::Momentum { .. } => "momentum",
                Start::Assembled { .. } => "assembled",
            },
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
