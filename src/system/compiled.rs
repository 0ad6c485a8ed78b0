//! [`System`]: a compiled scene.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::DVector;

use super::compile::{Names, Parameters, Required};
use super::cost::{Costs, Terms};
use super::formula::{Batches, Entry, Layout, NodeView, PlacedElement, Positions};
use super::rounding_rows::clear_rounding_rows;
use super::tangent::{Formulas, Sines};
use super::uncoupled::Uncoupled;
use crate::Error;
use crate::linear::{Breakdown, Symbolic};
use crate::model::{
    Control, Coordinate, Design, Event, Gap, Handle, Multiplier, Output, Param, SceneTag, Shape, Sketch, Switch,
};
use crate::program::Obstacle;

/// Rounding error allowed in a sum, relative to its terms.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// A compiled mechanism: n coordinates, m constraint equations, k controls.
///
/// It is immutable and can be shared between threads; [`Solver`](crate::Solver) contains the data of a run. Clones share their data.
#[derive(Clone)]
pub struct System(pub(super) Arc<Compiled>);

/// The data of a [`System`].
pub(super) struct Compiled {
    pub(super) n: usize,
    pub(super) m: usize,
    pub(super) k: usize,
    pub(super) batches: Batches,
    pub(super) formulas: Formulas,
    pub(super) costs: Costs,
    pub(super) terms: Terms,
    pub(super) symbolic: Symbolic,
    pub(super) positions: Positions,
    pub(super) sines: Sines,
    pub(super) loop_equations: Vec<usize>,
    pub(super) has_still_loops: bool,
    pub(super) switches: Vec<Switch>,
    pub(super) gaps: Vec<Gap>,
    pub(super) sides: Vec<(usize, f64)>,
    /// The energies that may be undefined at points where their derivatives are defined, by batch and item.
    pub(super) partly_defined: Vec<(usize, usize)>,
    pub(super) names: Names,
    pub(super) initial: Vec<f64>,
    pub(super) design: Vec<f64>,
    pub(super) parameters: Parameters,
    pub(super) positive: Vec<Required>,
    pub(super) tensors: Vec<(String, [Param; 6])>,
    pub(super) sketch: Sketch,
    /// The number of the scene.
    pub(super) scene: SceneTag,
    /// Fingerprint of the formulas that were compiled, and of those of the costs alone.
    pub(super) fingerprint: u64,
    pub(super) costs_compiled: u64,
    /// Whether any formula reads values.
    pub(super) reads_values: bool,
    pub(super) uncoupled: Uncoupled,
}

impl System {
    /// The number of coordinates.
    pub fn n(&self) -> usize {
        self.0.n
    }

    /// The number of constraint equations.
    pub fn m(&self) -> usize {
        self.0.m
    }

    /// The number of control channels (the paper's k).
    pub fn k(&self) -> usize {
        self.0.k
    }

    /// The number of design variables.
    pub fn designs(&self) -> usize {
        self.0.design.len()
    }

    /// The number of outputs in addition to J.
    pub fn outputs(&self) -> usize {
        self.0.names.outputs.len()
    }

    /// True if J has a cost; otherwise it is 0.
    pub fn has_cost(&self) -> bool {
        self.sums(0).next().is_some()
    }

    /// The number of events.
    pub fn events(&self) -> usize {
        self.0.names.events.len()
    }

    /// The name of an event.
    ///
    /// # Panics
    /// If the system has no such event.
    pub fn event_name(&self, event: usize) -> &str {
        &self.0.names.events[event]
    }

    /// True if the output is only reported; optimisers constrain it only when told to.
    pub(crate) fn is_report_only(&self, output: usize) -> bool {
        self.0.names.looked_at.contains(&output)
    }

    /// True if the output is the deviation from a reading, divided by its known standard deviation.
    pub(crate) fn is_reading(&self, output: usize) -> bool {
        self.0.names.readings[output]
    }

    /// Readings with their nodes and times, s.
    pub(crate) fn reading_times(&self) -> &[(String, usize, f64)] {
        &self.0.names.reading_times
    }

    /// The initial coordinates given in the scene, m or rad.
    pub fn initial_coordinates(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.0.initial)
    }

    /// The values of the design variables given in the scene.
    pub fn design_values(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.0.design)
    }

    /// The handle of coordinate `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`n`](Self::n).
    pub fn coordinate(&self, i: usize) -> Coordinate {
        assert!(i < self.0.n, "there are {} coordinates; index {i} does not exist", self.0.n);
        Coordinate(self.0.scene.handle(i))
    }

    /// The handle of design variable `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`designs`](Self::designs).
    pub fn design(&self, i: usize) -> Design {
        assert!(i < self.designs(), "there are {} design variables; index {i} does not exist", self.designs());
        Design(self.0.scene.handle(i))
    }

    /// The handle of output `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`outputs`](Self::outputs).
    pub fn output(&self, i: usize) -> Output {
        assert!(i < self.outputs(), "there are {} outputs; index {i} does not exist", self.outputs());
        Output(self.0.scene.handle(i))
    }

    /// The handle of event `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`events`](Self::events).
    pub fn event(&self, i: usize) -> Event {
        assert!(i < self.events(), "there are {} events; index {i} does not exist", self.events());
        Event(self.0.scene.handle(i))
    }

    /// The handle of the multiplier of constraint equation `j`, as returned by the scene.
    ///
    /// # Panics
    /// If `j` is not less than [`m`](Self::m).
    pub fn multiplier(&self, j: usize) -> Multiplier {
        assert!(j < self.0.m, "there are {} constraint equations; index {j} does not exist", self.0.m);
        Multiplier(self.0.scene.handle(j))
    }

    /// The multipliers of the equations that some event closes or hits, which are open at the start of a motion unless its inputs say otherwise.
    pub fn open_equations(&self) -> Vec<Multiplier> {
        self.open_at_start().into_iter().map(|j| self.multiplier(j)).collect()
    }

    /// The handle of control `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`k`](Self::k).
    pub fn control(&self, i: usize) -> Control {
        assert!(i < self.0.k, "there are {} controls; index {i} does not exist", self.0.k);
        Control(self.0.scene.handle(i))
    }

    /// Whether a handle belongs to the scene from which this system was compiled.
    pub(crate) fn owns(&self, handle: Handle) -> bool {
        self.0.scene.owns(&handle)
    }

    /// The index of an output.
    ///
    /// # Panics
    /// If the output belongs to another scene.
    pub(crate) fn place_of(&self, output: Output) -> usize {
        assert!(self.owns(output.0), "output {} belongs to another scene", output.index());
        output.index()
    }

    /// Whether a parameter belongs to the scene from which this system was compiled.
    pub(crate) fn knows(&self, param: Param) -> bool {
        param.belongs_to(self.0.scene.numbers()) && self.0.parameters.has(param)
    }

    /// Size s and width r of each node of the elimination tree, in the order of elimination. Such a node consists of s unknowns that are
    /// coupled with r unknowns eliminated later, and needs s (s + r)² multiplications per factorisation. All other unknowns are condensed,
    /// that is, eliminated in advance, once per step length.
    pub fn elimination(&self) -> Vec<[usize; 2]> {
        self.0.symbolic.nodes().map(|(size, width)| [size, width]).collect()
    }

    pub(crate) fn symbolic(&self) -> &Symbolic {
        &self.0.symbolic
    }

    /// The layout of the arguments of elements in a point.
    pub(super) fn layout(&self) -> Layout {
        Layout { n: self.0.n, m: self.0.m, k: self.0.k, p: self.0.parameters.len() }
    }

    /// The elements with their formulas on any numbers.
    pub(crate) fn batches(&self) -> &Batches {
        &self.0.batches
    }

    /// An element, given its batch and its index in the batch.
    pub(super) fn item(&self, place: (usize, usize)) -> &PlacedElement {
        self.0.batches.item(place)
    }

    pub(crate) fn placed(&self) -> impl Iterator<Item = &PlacedElement> {
        self.0.batches.items()
    }

    /// The formulas of the elements as they were compiled.
    pub(crate) fn formulas(&self) -> &Formulas {
        &self.0.formulas
    }

    /// The elements and costs without a program, with the reason. num-dual differentiates them at every point, which is slower but as
    /// exact.
    pub fn without_programs(&self) -> impl Iterator<Item = (&str, &'static str)> {
        self.obstacles().map(|(name, obstacle)| {
            let why = match obstacle {
                None => "the scene was compiled without programs",
                Some(Obstacle::Branches) => "its formula depends on a plain value (`re()`, a comparison, a branch)",
                Some(Obstacle::IsTooLong) => "its derivatives have too many operations to be compiled into a program",
                Some(Obstacle::Panics) => "its formula panics at the initial positions of the scene",
            };
            (name, why)
        })
    }

    /// The elements and costs whose derivatives have too many operations for a program.
    pub(crate) fn too_long(&self) -> impl Iterator<Item = &str> {
        self.obstacles().filter(|(_, obstacle)| *obstacle == Some(Obstacle::IsTooLong)).map(|(name, _)| name)
    }

    /// The elements and costs without a program; `None` if the scene was compiled without programs.
    fn obstacles(&self) -> impl Iterator<Item = (&str, Option<Obstacle>)> {
        let elements = self.0.formulas.elements.iter().filter(|element| element.formula.kernels.is_none());
        let costs = self.0.costs.terms().filter(|cost| !cost.has_program);
        let of_elements = elements.map(|element| (element.name.as_str(), element.formula.obstacle));
        of_elements.chain(costs.map(|cost| (cost.name, cost.obstacle)))
    }

    pub(crate) fn may_bend(&self) -> bool {
        self.0.formulas.assembly.bending() > 0
    }

    /// The positions of the unknowns of a step in the solver's order.
    pub(crate) fn positions(&self) -> &Positions {
        &self.0.positions
    }

    /// The sinusoidal constraints, with coefficients for the design values of the scene.
    pub(crate) fn sines(&self) -> &Sines {
        &self.0.sines
    }

    /// The constraint equations that close loops; only these can depend on other equations, in any position of the mechanism.
    pub(crate) fn loop_equations(&self) -> &[usize] {
        &self.0.loop_equations
    }

    /// True if no velocity changes some equation that closes a loop, at the initial coordinates and elsewhere.
    pub(crate) fn has_still_loops(&self) -> bool {
        self.0.has_still_loops
    }

    /// The entries of Φ_q; those of rows that vanish up to rounding are zero.
    pub(crate) fn phi_q(&self, at: &NodeView<f64>) -> Vec<Entry> {
        let mut entries = Vec::new();
        self.placed().for_each(|item| item.phi_q(at, &mut entries));
        clear_rounding_rows(&mut entries, (self.0.n, self.0.m));
        entries
    }

    /// Sets to zero those components of Φ that rounding of the coordinates explains, or of dΦ/dt that rounding of the velocities explains: at most
    /// a few units in the last place of the terms Φ_q q, or Φ_q v. No other coordinates or velocities could reduce them.
    pub(crate) fn take_rounding(&self, at: &NodeView<f64>, of: &[f64], values: &mut [f64]) {
        let mut terms = vec![0.0; self.0.m];
        self.phi_q(at).iter().for_each(|entry| terms[entry.row] += (entry.value * of[entry.col]).abs());
        for (value, terms) in values.iter_mut().zip(terms) {
            if terms.is_finite() && value.abs() <= ROUNDED * terms {
                *value = 0.0;
            }
        }
    }

    /// The number of stored derivatives at one node.
    pub(crate) fn block_len(&self) -> usize {
        self.0.sines.block_len() + self.0.formulas.assembly.block_len()
    }

    /// The drawing of the scene.
    pub(crate) fn sketch(&self) -> &Sketch {
        &self.0.sketch
    }

    /// The parameters of elements: design variables and expressions of them.
    pub(crate) fn parameters(&self) -> &Parameters {
        &self.0.parameters
    }

    /// Whether there are energies that may not be finite at points where their derivatives are.
    pub(crate) fn has_partly_defined_energies(&self) -> bool {
        !self.0.partly_defined.is_empty()
    }
}

/// Names.
impl System {
    /// The name of an output.
    ///
    /// # Panics
    /// If `k` is not less than [`outputs`](Self::outputs).
    pub fn output_name(&self, k: usize) -> &str {
        &self.0.names.outputs[k]
    }

    /// The name of a coordinate: the name of its group and its own name.
    ///
    /// # Panics
    /// If `i` is not less than [`n`](Self::n).
    pub fn coordinate_name(&self, i: usize) -> &str {
        &self.0.names.coordinates[i]
    }

    /// The name of a constraint equation: the name of the constraint and the number of the equation within the constraint.
    ///
    /// # Panics
    /// If `j` is not less than [`m`](Self::m).
    pub fn equation_name(&self, j: usize) -> &str {
        &self.0.names.equations[j]
    }

    /// Pairs of equations that are the components of one vector, as for hinges and welds.
    pub(crate) fn vector_equations(&self) -> impl Iterator<Item = Range<usize>> {
        let joints = self.sketch().drawn.iter().filter(|drawn| matches!(drawn.shape, Shape::Hinge | Shape::Weld));
        let joints: HashSet<&str> = joints.map(|drawn| drawn.name.as_str()).collect();
        let starts = self.0.names.constraints.iter().scan(0, |next, (name, count)| {
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
        &self.0.names.constraints
    }

    /// The name of a control channel.
    ///
    /// # Panics
    /// If `k` is not less than [`k`](Self::k).
    pub fn control_name(&self, k: usize) -> &str {
        &self.0.names.controls[k]
    }

    /// The name of a design variable.
    ///
    /// # Panics
    /// If `p` is not less than [`designs`](Self::designs).
    pub fn design_name(&self, p: usize) -> &str {
        &self.0.names.designs[p]
    }

    /// The name of an unknown of the reduced step: a velocity or a multiplier.
    pub(crate) fn unknown_name(&self, unknown: usize) -> String {
        if unknown < self.0.n {
            format!("the velocity of `{}`", self.0.names.coordinates[unknown])
        } else {
            format!("the multiplier of {}", self.0.names.equations[unknown - self.0.n])
        }
    }

    /// The name of an equation of the reduced step: a momentum equation or a velocity constraint.
    pub(crate) fn residual_name(&self, unknown: usize) -> String {
        match unknown.checked_sub(self.0.n) {
            None => format!("the momentum equation of `{}`", self.0.names.coordinates[unknown]),
            Some(j) => format!("the velocity constraint of {}", self.0.names.equations[j]),
        }
    }

    /// The error for a breakdown of the elimination of K, with the name of the unknown.
    pub(crate) fn singular_step(&self, breakdown: &Breakdown, step: usize, time: f64) -> Error {
        if step == 0 && breakdown.unknown < self.0.n && breakdown.scale == 0.0 {
            let what = format!("the inertia of `{}`", self.coordinate_name(breakdown.unknown));
            let must_be = "positive, unless a joint determines the coordinate and the scene is compiled with 0";
            return Error::Parameter { what, value: 0.0, must_be };
        }
        let unknown = self.unknown_name(breakdown.unknown);
        Error::SingularStep { step, time, unknown, pivot: breakdown.pivot / breakdown.scale }
    }
}

impl std::fmt::Debug for System {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (n, m, k) = (self.n(), self.m(), self.k());
        f.debug_struct("System").field("n", &n).field("m", &m).field("k", &k).finish_non_exhaustive()
    }
}
