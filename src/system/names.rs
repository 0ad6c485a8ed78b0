//! Names for reports and error messages.

use super::parameters::Parameters;
use super::parts::Parts;
use crate::error::quoted;

#[derive(Clone, Debug)]
pub(super) struct Names {
    pub(super) coordinates: Vec<String>,
    pub(super) equations: Vec<String>,
    pub(super) controls: Vec<String>,
    pub(super) designs: Vec<String>,
    pub(super) outputs: Vec<String>,
    /// Of design variables and of expressions of them.
    pub(super) parameters: Vec<String>,
}

impl Names {
    pub(super) fn new(scene: &Parts, parameters: &Parameters) -> Self {
        let equation = |name: &str, rows: usize, j: usize| match rows {
            1 => quoted(name),
            _ => format!("{} (equation {j})", quoted(name)),
        };
        let constraints = scene.constraints.iter();
        let designs: Vec<String> = scene.designs.iter().map(|(name, _)| name.clone()).collect();
        Names {
            coordinates: scene.coordinates.clone(),
            equations: constraints.flat_map(|(name, rows)| (0..*rows).map(|j| equation(name, *rows, j))).collect(),
            controls: scene.controls.clone(),
            outputs: scene.outputs.clone(),
            parameters: parameters.names(&designs),
            designs,
        }
    }
}
