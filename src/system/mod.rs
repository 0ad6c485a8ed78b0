//! A compiled scene: batches of elements of equal type, their constant part, and the structure of the tangent matrix.

mod acceleration;
mod acceleration_kernels;
mod applied;
mod argument;
mod assembly;
mod batch;
mod block;
mod branches;
mod compile;
mod connections;
mod constants;
mod cost;
mod cost_factors;
mod cost_formula;
mod cost_second_order;
mod cost_terms;
mod costs;
mod derivatives;
mod difference;
#[cfg(test)]
mod difference_tests;
mod directional;
mod element;
mod element_programs;
mod energy;
mod fixed;
mod formula;
mod groups;
mod holonomic;
mod item;
mod jet;
mod locate_nonfinite;
mod lost_derivatives;
mod names;
mod node_problem;
mod parameters;
mod placed;
mod placed_cost;
mod plain;
mod plain_cost;
mod point;
mod position;
mod print;
mod products;
mod scatter;
mod scene_parts;
mod second_order;
mod second_order_kernels;
mod shape;
mod sinusoidal_constraints;
mod structure;
mod subset_of_coordinates;
mod typed;
mod verify;
#[cfg(test)]
pub(crate) mod verify_tests;
mod view;
mod weights;

use nalgebra::DVector;

pub(crate) use acceleration::{AccelerationEquations, AccelerationSecondOrder, acceleration_tangent};
pub(crate) use applied::Applied;
pub(crate) use assembly::Workspace;
pub(crate) use batch::{Batch, Covector, InputRows, Pair, Positions, StateRows, Sums, Within};
pub(crate) use connections::Connections;
pub(crate) use constants::{Constants, Entry};
pub(crate) use cost::CostRows;
pub(crate) use cost_factors::CostFactors;
pub(crate) use cost_formula::CostMemory;
pub(crate) use cost_second_order::CostSecondOrder;
pub(crate) use cost_terms::Depends;
use cost_terms::Terms;
pub(crate) use costs::Costs;
pub(crate) use energy::{Kinetic, Potential};
pub(crate) use fixed::Fixed;
pub(crate) use holonomic::Holonomic;
pub(crate) use item::PlacedElement;
pub(crate) use lost_derivatives::Order;
pub(crate) use node_problem::{Given, KnownPart};
pub(crate) use placed_cost::PlacedCost;
pub(crate) use position::PositionConstraints;
pub(crate) use products::Wanted;
pub(crate) use scene_parts::{Parts, Required};
pub(crate) use second_order::SecondOrderEquations;
pub(crate) use sinusoidal_constraints::Sines;
pub(crate) use subset_of_coordinates::Restricted;
pub(crate) use typed::AnyElement;
pub(crate) use view::{NodeValues, NodeView};
pub(crate) use weights::{Beside, GivenWeights, Weights};

use crate::Error;
use crate::linear::Symbolic;
use crate::model::{Control, Coordinate, Handle, Output, Param, Sketch};
use crate::number::Real;
use crate::program::Obstacle;
use compile::check_positive;
pub(crate) use element::Formulas;
pub(crate) use jet::ElementKind;
use names::Names;
use parameters::Parameters;
use plain::{add_sums, write_phi};
use point::Layout;

/// Rounding error allowed in a sum, relative to its terms.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// A compiled mechanism: n coordinates, m constraint equations, k controls.
///
/// It is immutable and can be shared between threads; [`Solver`](crate::Solver) contains the data of a run.
#[derive(Clone)]
pub struct System {
    n: usize,
    m: usize,
    k: usize,
    batches: Vec<Batch>,
    formulas: Formulas,
    costs: Costs,
    terms: Terms,
    symbolic: Symbolic,
    positions: Positions,
    sines: Sines,
    loop_equations: Vec<usize>,
    /// The energies that may be undefined at points where their derivatives are defined, by batch and item.
    partly_defined: Vec<(usize, usize)>,
    names: Names,
    initial: Vec<f64>,
    design: Vec<f64>,
    parameters: Parameters,
    positive: Vec<Required>,
    sketch: Sketch,
    /// The number of the scene.
    scene: u64,
    /// Fingerprint of the formulas that were compiled, and of those of the costs alone.
    fingerprint: u64,
    costs_compiled: u64,
    /// Whether any formula reads values.
    reads_values: bool,
}

impl System {
    /// The number of coordinates.
    pub fn n(&self) -> usize {
        self.n
    }

    /// The number of constraint equations.
    pub fn m(&self) -> usize {
        self.m
    }

    /// The number of control channels (the paper's k).
    pub fn k(&self) -> usize {
        self.k
    }

    /// The number of design variables.
    pub fn designs(&self) -> usize {
        self.design.len()
    }

    /// The number of outputs in addition to J.
    pub fn outputs(&self) -> usize {
        self.names.outputs.len()
    }

    /// True if the output is only reported; optimisers constrain it only when told to.
    pub(crate) fn is_report_only(&self, output: usize) -> bool {
        self.names.looked_at.contains(&output)
    }

    /// The initial coordinates given in the scene, m or rad.
    pub fn initial_coordinates(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.initial)
    }

    /// The values of the design variables given in the scene.
    pub fn design_values(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.design)
    }

    /// The handle of coordinate `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`n`](Self::n).
    pub fn coordinate(&self, i: usize) -> Coordinate {
        assert!(i < self.n, "there are {} coordinates; index {i} does not exist", self.n);
        Coordinate(Handle::of(self.scene, i))
    }

    /// The handle of control `i`, as returned by the scene.
    ///
    /// # Panics
    /// If `i` is not less than [`k`](Self::k).
    pub fn control(&self, i: usize) -> Control {
        assert!(i < self.k, "there are {} controls; index {i} does not exist", self.k);
        Control(Handle::of(self.scene, i))
    }

    /// Whether a handle belongs to the scene from which this system was compiled.
    pub(crate) fn owns(&self, handle: Handle) -> bool {
        handle.scene() == self.scene
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
        param.belongs_to(self.scene)
    }

    /// Size s and width r of each node of the elimination tree, in the order of elimination. Such a node consists of s unknowns that are
    /// coupled with r unknowns eliminated later, and needs s (s + r)² multiplications per factorisation. All other unknowns are condensed,
    /// that is, eliminated in advance, once per step length.
    pub fn elimination(&self) -> Vec<[usize; 2]> {
        self.symbolic.nodes().map(|(size, width)| [size, width]).collect()
    }

    pub(crate) fn symbolic(&self) -> &Symbolic {
        &self.symbolic
    }

    /// An element, given its batch and its index in the batch.
    fn item(&self, (batch, item): (usize, usize)) -> &PlacedElement {
        &self.batches[batch].items[item]
    }

    /// The layout of the arguments of elements in a point.
    fn layout(&self) -> Layout {
        Layout { n: self.n, m: self.m, k: self.k }
    }

    pub(crate) fn placed(&self) -> impl Iterator<Item = &PlacedElement> {
        self.batches.iter().flat_map(|batch| &batch.items)
    }

    fn of_kind(&self, kind: ElementKind) -> impl Iterator<Item = &Batch> {
        self.batches.iter().filter(move |batch| batch.kind() == Some(kind))
    }

    /// The formulas of the elements as they were compiled.
    pub(crate) fn formulas(&self) -> &Formulas {
        &self.formulas
    }

    /// The programs of the element `name` as text: the instructions that run once and those that run at every point.
    pub fn program(&self, name: &str) -> Option<String> {
        self.formulas.elements.iter().find(|element| element.name == name).map(print::print)
    }

    /// The elements and costs without a program, with the reason. num-dual differentiates them at every point, which is slower but as
    /// exact.
    pub fn without_programs(&self) -> impl Iterator<Item = (&str, &'static str)> {
        let elements = self.formulas.elements.iter().filter(|element| element.formula.kernels.is_none());
        let costs = self.costs.terms().filter(|cost| !cost.has_program);
        let of_elements = elements.map(|element| (element.name.as_str(), element.formula.obstacle));
        of_elements.chain(costs.map(|cost| (cost.name, cost.obstacle))).map(|(name, obstacle)| {
            let why = match obstacle {
                None => "the scene was compiled without programs",
                Some(Obstacle::Branches) => "its formula depends on a plain value (`re()`, a comparison, a branch)",
                Some(Obstacle::IsTooLong) => "its derivatives have too many operations to be compiled into a program",
                Some(Obstacle::Panics) => "its formula panics at the initial positions of the scene",
            };
            (name, why)
        })
    }

    /// The number of elements that may be nonlinear within a step: their derivatives vary other than as sines.
    pub(crate) fn bending(&self) -> usize {
        self.formulas.assembly.bending()
    }

    pub(crate) fn may_bend(&self) -> bool {
        self.bending() > 0
    }

    /// The name of an element, given its number.
    pub(crate) fn element_name(&self, element: usize) -> &str {
        &self.formulas.elements[element].name
    }

    /// The positions of the unknowns of a step in the solver's order.
    pub(crate) fn positions(&self) -> &Positions {
        &self.positions
    }

    /// The sinusoidal constraints, with coefficients for the design values of the scene.
    pub(crate) fn sines(&self) -> &Sines {
        &self.sines
    }

    /// The constraint equations that close loops; only these can depend on other equations, in any position of the mechanism.
    pub(crate) fn loop_equations(&self) -> &[usize] {
        &self.loop_equations
    }

    /// The entries of Φ_q.
    pub(crate) fn phi_q(&self, at: &NodeView<f64>) -> Vec<Entry> {
        let mut entries = Vec::new();
        self.placed().for_each(|item| item.phi_q(at, &mut entries));
        entries
    }

    /// Sets to zero those components of Φ that rounding of the coordinates explains, or of dΦ/dt that rounding of the velocities explains: at most
    /// a few units in the last place of the terms Φ_q q, or Φ_q v. No other coordinates or velocities could reduce them.
    pub(crate) fn take_rounding(&self, at: &NodeView<f64>, of: &[f64], values: &mut [f64]) {
        let mut terms = vec![0.0; self.m];
        self.phi_q(at).iter().for_each(|entry| terms[entry.row] += (entry.value * of[entry.col]).abs());
        for (value, terms) in values.iter_mut().zip(terms) {
            if terms.is_finite() && value.abs() <= ROUNDED * terms {
                *value = 0.0;
            }
        }
    }

    /// The number of stored derivatives at one node.
    pub(crate) fn block_len(&self) -> usize {
        self.sines.block_len() + self.formulas.assembly.block_len()
    }

    /// The drawing of the scene.
    pub(crate) fn sketch(&self) -> &Sketch {
        &self.sketch
    }

    pub(crate) fn check_design(&self, design: &[f64]) -> Result<(), Error> {
        let values = self.parameters.values(design);
        self.parameters.check(&values, &self.names.designs)?;
        check_positive(&self.positive, &values)
    }

    /// The parameters of elements: design variables and expressions of them.
    pub(crate) fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Evaluates 𝓛_v, 𝓛_q + Q and dΦ/dt by the plain formulas, on any number type.
    pub(crate) fn plain_sums<R: Real>(&self, at: &NodeView<R>, sums: &mut Sums<R>) {
        sums.clear();
        add_sums(self.batches.iter(), at, sums);
    }

    /// The contributions of the kinetic energies alone: T_v and T_q.
    pub(crate) fn kinetic_sums<R: Real>(&self, at: &NodeView<R>, sums: &mut Sums<R>) {
        sums.clear();
        add_sums(self.of_kind(ElementKind::Kinetic), at, sums);
    }

    /// T and V.
    pub(crate) fn energies(&self, at: &NodeView<f64>) -> [f64; 2] {
        let of = |kind| self.of_kind(kind).flat_map(|batch| &batch.items).map(|item| item.energy(at)).sum();
        [ElementKind::Kinetic, ElementKind::Potential].map(of)
    }

    /// Φ(q, t).
    pub(crate) fn phi<R: Real>(&self, at: &NodeView<R>, phi: &mut [R]) {
        write_phi(self.batches.iter(), at, phi);
    }

    /// Whether there are energies that may not be finite at points where their derivatives are.
    pub(crate) fn has_partly_defined_energies(&self) -> bool {
        !self.partly_defined.is_empty()
    }
}

impl std::fmt::Debug for System {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (n, m, k) = (self.n, self.m, self.k);
        f.debug_struct("System").field("n", &n).field("m", &m).field("k", &k).finish_non_exhaustive()
    }
}
