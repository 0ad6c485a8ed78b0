//! Names for reports and error messages.

use std::collections::HashSet;
use std::ops::Range;

use super::scene_parts::Parts;
use crate::error::quoted;
use crate::linear::Breakdown;
use crate::model::Shape;
use crate::{Error, System};

#[derive(Clone, Debug)]
pub(super) struct Names {
    pub(super) coordinates: Vec<String>,
    /// Constraints, each with its number of equations.
    constraints: Vec<(String, usize)>,
    pub(super) equations: Vec<String>,
    pub(super) controls: Vec<String>,
    pub(super) designs: Vec<String>,
    pub(super) outputs: Vec<String>,
    pub(super) looked_at: Vec<usize>,
}

impl Names {
    pub(super) fn new(scene: &Parts) -> Self {
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
            designs: scene.designs.iter().map(|(name, _)| name.clone()).collect(),
        }
    }
}

impl System {
    /// The name of an output.
    ///
    /// # Panics
    /// If `k` is not less than [`outputs`](Self::outputs).
    pub fn output_name(&self, k: usize) -> &str {
        &self.names.outputs[k]
    }

    /// The name of a coordinate: the name of its group and its own name.
    ///
    /// # Panics
    /// If `i` is not less than [`n`](Self::n).
    pub fn coordinate_name(&self, i: usize) -> &str {
        &self.names.coordinates[i]
    }

    /// The name of a constraint equation: the name of the constraint and the number of the equation within the constraint.
    ///
    /// # Panics
    /// If `j` is not less than [`m`](Self::m).
    pub fn equation_name(&self, j: usize) -> &str {
        &self.names.equations[j]
    }

    /// Pairs of equations that are the components of one vector, as for hinges and welds.
    pub(crate) fn vector_equations(&self) -> impl Iterator<Item = Range<usize>> {
        let joints = self.sketch().drawn.iter().filter(|drawn| matches!(drawn.shape, Shape::Hinge | Shape::Weld));
        let joints: HashSet<&str> = joints.map(|drawn| drawn.name.as_str()).collect();
        let starts = self.names.constraints.iter().scan(0, |next, (name, count)| {
            let first = *next;
            *next += count;
            Some((first, name, *count))
        });
        let of_joints = starts.filter(move |(_, name, count)| *count >= 2 && joints.contains(name.as_str()));
        of_joints.map(|(first, ..)| first..first + 2)
    }

    /// The names of the constraints with their numbers of equations, in the order of the equations.
    #[cfg(feature = "files")]
    pub(crate) fn constraints(&self) -> &[(String, usize)] {
        &self.names.constraints
    }

    /// The name of a control channel.
    ///
    /// # Panics
    /// If `k` is not less than [`k`](Self::k).
    pub fn control_name(&self, k: usize) -> &str {
        &self.names.controls[k]
    }

    /// The name of a design variable.
    ///
    /// # Panics
    /// If `p` is not less than [`designs`](Self::designs).
    pub fn design_name(&self, p: usize) -> &str {
        &self.names.designs[p]
    }

    /// The name of an unknown of the reduced step: a velocity or a multiplier.
    pub(crate) fn unknown_name(&self, unknown: usize) -> String {
        if unknown < self.n {
            format!("the velocity of `{}`", self.names.coordinates[unknown])
        } else {
            format!("the multiplier of {}", self.names.equations[unknown - self.n])
        }
    }

    /// The name of an equation of the reduced step: a momentum equation or a velocity constraint.
    pub(crate) fn residual_name(&self, unknown: usize) -> String {
        match unknown.checked_sub(self.n) {
            None => format!("the momentum equation of `{}`", self.names.coordinates[unknown]),
            Some(j) => format!("the velocity constraint of {}", self.names.equations[j]),
        }
    }

    /// The error for a breakdown of the elimination of K, with the name of the unknown.
    pub(crate) fn singular_step(&self, breakdown: &Breakdown, step: usize, time: f64) -> Error {
        let unknown = self.unknown_name(breakdown.unknown);
        Error::SingularStep { step, time, unknown, pivot: breakdown.pivot / breakdown.scale }
    }
}
