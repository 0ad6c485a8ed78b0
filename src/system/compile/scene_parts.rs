//! The parts from which a system is compiled.

use std::ops::Range;

use crate::model::{Action, Gap, Param, SceneTag, Sketch, Switch};
use crate::system::cost::Costs;
use crate::system::formula::Batches;

/// A mechanism as a list of named parts.
#[derive(Clone, Default)]
pub(crate) struct Parts {
    /// The numbers of the scene.
    pub(crate) scene: SceneTag,
    pub(crate) coordinates: Vec<String>,
    /// The coordinates of each named group (a body), as ranges.
    pub(crate) groups: Vec<(String, Range<usize>)>,
    pub(crate) initial: Vec<f64>,
    pub(crate) controls: Vec<String>,
    /// The names of the outputs that are computed in addition to J.
    pub(crate) outputs: Vec<String>,
    /// The names of the events.
    pub(crate) events: Vec<String>,
    /// What happens at events.
    pub(crate) switches: Vec<Switch>,
    pub(crate) gaps: Vec<Gap>,
    /// Events at which a function becomes zero from one side only: 1 from above, −1 from below.
    pub(crate) sides: Vec<(usize, f64)>,
    /// Outputs that are only reported; optimisers constrain them only when told to.
    pub(crate) looked_at: Vec<usize>,
    /// Readings with their nodes and times, s.
    pub(crate) reading_times: Vec<(String, usize, f64)>,
    /// Outputs that are deviations from readings, divided by their known standard deviations.
    pub(crate) readings: Vec<String>,
    pub(crate) designs: Vec<(String, f64)>,
    /// Name and number of equations of each constraint.
    pub(crate) constraints: Vec<(String, usize)>,
    pub(crate) equations: usize,
    pub(crate) gravity: [Option<Param>; 3],
    pub(crate) sketch: Sketch,
    pub(crate) batches: Batches,
    pub(crate) costs: Costs,
    /// Parameters whose values are restricted to a range, with descriptions.
    pub(crate) positive: Vec<Required>,
    /// The bodies in space with their inertia tensors J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the centre of mass.
    pub(crate) tensors: Vec<(String, [Param; 6])>,
}

/// A parameter that must be positive, or nonnegative if `may_be_zero`.
#[derive(Clone)]
pub(crate) struct Required {
    pub(crate) param: Param,
    pub(crate) what: String,
    pub(crate) may_be_zero: bool,
}

impl Parts {
    /// Replaces the parameters of switches by their indices among the values.
    pub(in crate::system) fn resolve_switches(&mut self, mut resolve: impl FnMut(Param) -> Param) {
        for switch in &mut self.switches {
            if let Action::Impact(restitution) = &mut switch.action {
                *restitution = resolve(*restitution);
            }
        }
    }
}
