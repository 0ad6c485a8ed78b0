//! An element of a compiled scene, independent of its type: its connections and the properties of its formula.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use super::assembly::Assembly;
use super::block::{Block, BlockEntry};
use super::connections::Connections;
use super::constants::{Constants, Entry};
use super::formula::Formula;
use super::item::PlacedElement;
use super::jet::ElementKind;
use super::shape::{Place, Shape, Slot};
use super::sinusoidal_constraints::SinusoidalTerm;
use super::view::NodeView;
use crate::number::guarded;
use crate::program::{Obstacle, Template};

/// An element of a compiled scene.
#[derive(Clone, Debug)]
pub struct Element {
    pub name: String,
    /// The batch of the element, and its index in the batch.
    pub place: (usize, usize),
    pub to: Connections,
    pub formula: Arc<Formula>,
    /// The numbers in the formula that may differ between elements of one formula.
    pub numbers: Vec<f64>,
}

/// Key of a formula: the kind of element, its shape, which constants are bound, and the recorded template.
type Key = (ElementKind, Shape, Vec<bool>, Template);

/// The elements of a scene while they are recorded; each formula is differentiated once.
#[derive(Default)]
pub struct Recordings {
    pub elements: Vec<Element>,
    /// The number of the batch that is being recorded.
    pub batch: usize,
    /// Whether num-dual evaluates all elements.
    without_programs: bool,
    known: HashMap<Key, Arc<Formula>>,
}

impl Recordings {
    pub fn new(without_programs: bool) -> Self {
        Recordings { without_programs, ..Recordings::default() }
    }

    /// Records an element.
    pub fn add(&mut self, item: &PlacedElement, place: (usize, usize), at: &NodeView<f64>) -> Arc<Formula> {
        let (kind, shape) = (item.formula.kind(), item.shape);
        let (formula, numbers) = self.formula((kind, shape), item.to.bound(), || item.record(at));
        let element = item.element(place, formula.clone(), numbers);
        debug_assert!(
            Arc::strong_count(&formula) > 3 || guarded(|| item.agrees(&element, at)) != Some(false),
            "the program of `{}` does not agree with num-dual",
            item.name
        );
        self.elements.push(element);
        formula
    }

    /// The compiled formula of a recording, and the numbers in it.
    pub fn formula(
        &mut self,
        (kind, shape): (ElementKind, Shape),
        bound: Vec<bool>,
        record: impl FnOnce() -> Result<(Template, Vec<f64>), Obstacle>,
    ) -> (Arc<Formula>, Vec<f64>) {
        match record() {
            Ok((template, numbers)) if !self.without_programs => {
                let formula = self.known.entry((kind, shape, bound, template));
                let formula = formula.or_insert_with_key(|(_, _, bound, template)| {
                    Arc::new(Formula::new(kind, shape, template.clone(), bound))
                });
                (formula.clone(), numbers)
            }
            other => (Arc::new(Formula::unknown(kind, shape, other.err())), Vec::new()),
        }
    }
}

/// The elements of a scene with their formulas, and the assembly of those that are evaluated at every point.
#[derive(Clone, Debug)]
pub struct Formulas {
    pub elements: Vec<Element>,
    pub assembly: Assembly,
}

impl Element {
    pub fn kind(&self) -> ElementKind {
        self.formula.kind
    }

    /// Whether another formula has the same flags and the same structural nonzeros.
    pub fn has_places_of(&self, other: &Element) -> bool {
        let flags = |formula: &Formula| {
            let Formula { constant, piecewise, sinusoidal, timed, ref kernels, .. } = *formula;
            (constant, piecewise, sinusoidal, timed, kernels.is_some())
        };
        let (own, other) = (&*self.formula, &*other.formula);
        flags(own) == flags(other) && own.varying == other.varying && own.fixed == other.fixed
    }

    /// Row and column of an entry in the scene's numbering; rows of constraints are numbered among the equations.
    pub fn row_and_col(&self, entry: &BlockEntry) -> [usize; 2] {
        let row = if entry.block.has_equations() { self.to.sigma[entry.row] } else { self.to.q[entry.row] };
        [row, self.to.q[entry.col]]
    }

    /// The unknowns (n velocities, then multipliers) of the row and the column of an entry.
    pub fn unknowns(&self, entry: &BlockEntry, n: usize) -> [usize; 2] {
        let [row, col] = self.row_and_col(entry);
        [if entry.block.has_equations() { n + row } else { row }, col]
    }

    /// The values of the constants, followed by the numbers in the formula.
    pub fn parameters(&self, design: &[f64]) -> Vec<f64> {
        self.to.constants(design).chain(self.numbers.iter().copied()).collect()
    }

    /// [`parameters`](Self::parameters), followed by the factor of each constant (its ratio to the parameter it is bound to).
    pub fn with_factors(&self, design: &[f64]) -> Vec<f64> {
        let factors = self.to.b.iter().map(|b| b.bound().map_or(0.0, |(_, factor)| factor));
        self.parameters(design).into_iter().chain(factors).collect()
    }

    /// Adds the constant second derivatives and the coefficients of the sinusoidal terms.
    pub fn add_constants(&self, parameters: &[f64], into: &mut Constants) {
        let Some(kernels) = &self.formula.kernels else { return };
        let none = |_| 0.0;
        for (entry, value) in self.formula.fixed.iter().zip(kernels.fixed.evaluate(parameters, none)) {
            into.add(entry, self.row_and_col(entry), value);
        }
        if self.formula.constant && self.kind() != ElementKind::Holonomic {
            let values = kernels.at_zero.evaluate(parameters, none);
            let n = self.to.q.len();
            into.add_first(&self.to.q, &values[..n], &values[n..2 * n]);
            for (k, value) in values[2 * n..].iter().enumerate() {
                into.add_control(self.to.q[k / self.to.u.len()], self.to.u[k % self.to.u.len()], *value);
            }
        }
        if self.formula.sinusoidal {
            self.add_waves(parameters, into);
        }
    }

    /// Computes a, α, β of a q + α sin q + β cos q from its slopes a + α cos q − β sin q at q = 0, π/2 and π.
    fn add_waves(&self, parameters: &[f64], into: &mut Constants) {
        let Some(kernels) = &self.formula.kernels else { return };
        let slopes = [0.0, FRAC_PI_2, 2.0 * FRAC_PI_2].map(|angle| {
            let is_angle = |which| matches!(self.formula.shape.place(which), Place::Of(Slot::Q(_)));
            kernels.at_state(parameters, |which| if is_angle(which) { angle } else { 0.0 }).1
        });
        // Each of these slopes depends on one coordinate, so none is relative to another.
        let varying = self.formula.varying.iter().map(|relative| &relative.entry);
        for (k, entry) in varying.enumerate().filter(|(_, entry)| entry.block == Block::PhiQ) {
            let [at_0, at_90, at_180] = slopes.each_ref().map(|slopes| slopes[k]);
            // π is not exact in binary, so a coefficient that should be zero is left with a rounding error.
            let rounding = 4.0 * f64::EPSILON * at_0.abs().max(at_90.abs()).max(at_180.abs());
            let clean = |x: f64| if x.abs() <= rounding { 0.0 } else { x };
            let linear = clean(0.5 * (at_0 + at_180));
            let (sine, cosine) = (clean(0.5 * (at_0 - at_180)), clean(linear - at_90));
            let [equation, coordinate] = self.row_and_col(entry);
            into.waves.push(SinusoidalTerm { coordinate, equation, sine, cosine });
            into.add_phi_q(Entry { row: equation, col: coordinate, value: linear });
        }
    }
}
