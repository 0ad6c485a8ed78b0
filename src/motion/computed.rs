//! [`Motion`]: a motion as data, complete for the adjoint sweep.

use nalgebra::{DMatrix, DVector};

use super::Scales;
use super::ahead::Ahead;
use super::events::Events;
use super::grid::Grid;
use super::inputs::{Inputs, Start};
use super::trajectory::{Compliance, Trajectory};
use crate::motion::{Assembly, column};
use crate::system::NodeView;
use crate::{Scheme, System, Warning};

/// A motion, or a window over it.
pub(crate) struct Motion {
    /// Inputs on the computed grid; while there is a gap, the steps ahead are stored after it.
    pub(crate) inputs: Inputs,
    /// The values of the parameters, from the design variables of the inputs.
    pub(crate) design: Vec<f64>,
    /// The assembly of the start, if it was a guess.
    pub(crate) assembly: Option<Assembly>,
    /// Warning about derivatives with respect to design variables, for a given start.
    pub(crate) given_start: Option<Warning>,
    pub(crate) ahead: Ahead,
    /// True while an adaptive grid is being constructed, so that the last node is not the end.
    pub(crate) is_growing: bool,
    /// The node stored in column 0 of the trajectory.
    pub(crate) first: usize,
    pub(crate) trajectory: Trajectory,
    /// The second derivatives of all varying elements, one column per stage.
    pub(crate) blocks: DMatrix<f64>,
    /// Second derivatives at the given start, and σ = 0 there.
    pub(crate) start_blocks: Vec<f64>,
    pub(crate) no_sigma: Vec<f64>,
    pub(crate) events: Events,
    /// For a motion with located events, the factors of the given steps.
    pub(crate) scales: Scales,
    /// The small compliances of all equations that close loops, with none of them left out; empty unless some depend on each other.
    pub(crate) shared: Vec<(usize, f64)>,
    /// For each column, true if the end of its step was badly predicted, so that the step is checked for unresolved forces.
    pub(crate) surprising: Vec<bool>,
}

impl Motion {
    pub(crate) fn new(system: &System, scheme: Scheme) -> Self {
        let inputs = Inputs {
            grid: Grid::new(0.0, Vec::new()),
            start: Start::Velocity { q: DVector::zeros(0), v: DVector::zeros(0) },
            controls: DMatrix::zeros(0, 0),
            design: DVector::zeros(0),
            events: Vec::new(),
            controls_in_time: Vec::new(),
            open: Vec::new(),
        };
        Motion {
            inputs,
            design: Vec::new(),
            assembly: None,
            given_start: None,
            ahead: Ahead::new(),
            is_growing: false,
            first: 0,
            trajectory: Trajectory::zeros(system, 0, scheme),
            blocks: DMatrix::zeros(0, 0),
            start_blocks: Vec::new(),
            no_sigma: vec![0.0; system.m()],
            events: Events::default(),
            scales: Scales::default(),
            shared: Vec::new(),
            surprising: Vec::new(),
        }
    }

    /// The arguments of equations and costs at a node.
    pub(crate) fn at(&self, node: usize) -> NodeView<'_, f64> {
        self.trajectory.columns(node - self.first).with_inputs((self.inputs.controls_at(node), &self.design))
    }

    /// True if both motions have the same steps, the same events at the same nodes and the same left-out equations: only then are
    /// quantities computed from them the same function of the inputs.
    pub(crate) fn is_like(&self, other: &Motion) -> bool {
        let left_out = |motion: &Motion| -> Vec<(usize, Vec<usize>)> {
            let parts = motion.trajectory.compliance.iter();
            parts.map(|part| (part.from, part.equations.iter().map(|&(j, _)| j).collect())).collect()
        };
        self.trajectory.inserted == other.trajectory.inserted
            && self.events.are_alike(&other.events)
            && left_out(self) == left_out(other)
    }

    /// Sets the compliances from a node on.
    pub(crate) fn set_compliance(&mut self, from: usize, equations: Vec<(usize, f64)>) {
        let parts = &mut self.trajectory.compliance;
        let at = parts.partition_point(|part| part.from < from);
        if parts.get(at).is_some_and(|part| part.from == from) {
            parts.remove(at);
        }
        parts.insert(at, Compliance { from, equations });
    }

    /// (q₀, v₀, σ = 0) as given, from which p*₀ = T_v was computed, and the second derivatives there; v₀ may violate dΦ/dt = 0 within a tolerance.
    pub(crate) fn given_start(&self) -> (NodeView<'_, f64>, &[f64]) {
        (NodeView { v: self.inputs.start.rate().as_slice(), sigma: &self.no_sigma, ..self.at(0) }, &self.start_blocks)
    }

    /// The arguments of equations and costs at a stage of the step that ends at a node; the last stage is the node itself.
    pub(crate) fn at_stage(&self, node: usize, s: usize) -> NodeView<'_, f64> {
        if s == self.trajectory.last_stage() {
            return self.at(node);
        }
        NodeView { design: &self.design, ..self.trajectory.stage(node - self.first, s) }
    }

    /// The column of the second derivatives of a stage.
    #[inline]
    pub(crate) fn block_column(&self, k: usize, s: usize) -> usize {
        k * self.trajectory.last_stage() + s - 1
    }

    /// The second derivatives of a stage of the step that ends at a node.
    #[inline]
    pub(crate) fn stage_blocks(&self, node: usize, s: usize) -> &[f64] {
        column(&self.blocks, self.block_column(node - self.first, s))
    }

    /// The second derivatives of a node.
    pub(crate) fn node_blocks(&self, node: usize) -> &[f64] {
        self.stage_blocks(node, self.trajectory.last_stage())
    }

    /// True if the end of the step was badly predicted.
    pub(crate) fn is_surprising(&self, node: usize) -> bool {
        self.surprising.get(node - self.first).is_some_and(|surprising| *surprising)
    }

    /// Whether an event is located at the time of an end of the given step that contains or ends at a node.
    #[inline]
    pub(crate) fn has_located_end(&self, node: usize) -> bool {
        !self.inputs.events.is_empty() && self.is_beside_event(node)
    }

    fn is_beside_event(&self, node: usize) -> bool {
        let step = self.node_of_whole(node);
        let goes_on = |node: usize| self.node_of_whole(node) == step || self.length(node) == 0.0;
        let first = (1..node).rev().find(|&node| !goes_on(node)).unwrap_or(0);
        let last = (node + 1..self.nodes()).find(|&node| !goes_on(node)).unwrap_or(self.nodes()) - 1;
        let [first, last] = [first, last].map(|node| self.node_of_whole(node));
        self.inputs.events.iter().any(|event| (first..=last).contains(&event.node))
    }

    /// The time of a node, s.
    pub(crate) fn time(&self, node: usize) -> f64 {
        self.trajectory.times[node - self.first]
    }

    /// The length of the step that ends at a node, s.
    pub(crate) fn length(&self, node: usize) -> f64 {
        node.checked_sub(1).map_or(0.0, |before| self.inputs.grid.steps[before])
    }
}
