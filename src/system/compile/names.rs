//! Names for reports and error messages.

use std::collections::HashSet;

use super::scene_parts::Parts;
use crate::error::quoted;

#[derive(Debug)]
pub(in crate::system) struct Names {
    pub(in crate::system) coordinates: Vec<String>,
    /// Constraints, each with its number of equations.
    pub(in crate::system) constraints: Vec<(String, usize)>,
    pub(in crate::system) equations: Vec<String>,
    pub(in crate::system) controls: Vec<String>,
    pub(in crate::system) designs: Vec<String>,
    pub(in crate::system) outputs: Vec<String>,
    pub(in crate::system) looked_at: Vec<usize>,
    /// Readings with their nodes and times, s.
    pub(in crate::system) reading_times: Vec<(String, usize, f64)>,
    /// Outputs that are deviations from readings, divided by their known standard deviations.
    pub(in crate::system) readings: Vec<bool>,
    pub(in crate::system) events: Vec<String>,
}

impl Names {
    pub(in crate::system) fn new(scene: &Parts) -> Self {
        let equation = |name: &str, rows: usize, j: usize| match rows {
            1 => quoted(name),
            _ => format!("{} (equation {j})", quoted(name)),
        };
        let constraints = scene.constraints.iter();
        Names {
            coordinates: scene.coordinates.clone(),
            constraints: scene.constraints.clone(),
            equations: constraints.flat_map(|(name, rows)| (0..*rows).map(|j| equation(name, *rows, j))).collect(),
            controls: scene.controls.clone(),
            outputs: scene.outputs.clone(),
            looked_at: scene.looked_at.clone(),
            reading_times: scene.reading_times.clone(),
            readings: readings(scene),
            events: scene.events.clone(),
            designs: scene.designs.iter().map(|(name, _)| name.clone()).collect(),
        }
    }
}

/// For each output, true if it is declared to be a reading.
fn readings(scene: &Parts) -> Vec<bool> {
    let known: HashSet<&str> = scene.readings.iter().map(String::as_str).collect();
    scene.outputs.iter().map(|name| known.contains(name.as_str())).collect()
}
