//! Accelerations v̇ and reactions λ = dσ/dt at a state, element by element: the time derivatives of Eqs. (1a) and (1c).
//!
//! Let D denote the time derivative for given v̇ and λ, that is, the derivative along (v, v̇, λ, 1) of (q, v, σ, t), at σ = 0. Then
//!
//! ```text
//!   f = 𝓛_q + Q − D 𝓛_v = 0      g = −D dΦ/dt = 0        which is  r − K(0) (v̇, λ) = 0
//! ```
//!
//! λ does not depend on σ, because σ adds the same terms to 𝓛_q and to D 𝓛_v. For an adjoint (c, e) of these equations, the derivatives of
//! c·f + e·g with respect to q, v, u, t and parameters are third derivatives of 𝓛; programs or num-dual compute them.

use super::branches::Branches;
use crate::system::cost::CostRows;
use crate::system::formula::{
    AccelerationKernels, Alike, Argument, Component, Covector, Element, ElementPrograms, Layout, NodeView, Pair,
    equations_along, rows_along,
};
use crate::{Error, System};

/// The equations for the accelerations and reactions of a scene.
#[derive(Default)]
pub(crate) struct AccelerationEquations {
    layout: Layout,
    /// r: n momenta, then m equations.
    right: Vec<ElementPrograms<usize>>,
    /// Derivatives of c·f + e·g; each result has its argument and a factor.
    rows: Vec<ElementPrograms<(Argument, f64)>>,
    /// Elements that num-dual evaluates.
    dual: Vec<(usize, usize)>,
    point: Vec<f64>,
}

impl AccelerationEquations {
    pub(crate) fn new(system: &System, elements: &[Element]) -> Self {
        let layout = system.layout();
        let point = vec![0.0; layout.len()];
        let mut all = AccelerationEquations { layout, point, ..AccelerationEquations::default() };
        for alike in &Alike::all(elements) {
            let Some(kernels) = AccelerationKernels::new(alike.formula, &alike.bound()) else {
                all.dual.extend(alike.places());
                continue;
            };
            let AccelerationKernels { right, rows } = kernels;
            let sum = |element: &Element, of| place(&layout, element, of);
            all.right.extend(ElementPrograms::new(&layout, alike, right, sum));
            all.rows.extend(ElementPrograms::new(&layout, alike, rows, |element, slot| element.to.argument(slot)));
        }
        all
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        let parameters = |e: usize| elements[e].parameters(design);
        self.right.iter_mut().for_each(|programs| programs.fix(parameters));
        self.rows.iter_mut().for_each(|programs| programs.fix(parameters));
    }

    /// Computes r at a state with σ = 0.
    pub(crate) fn right(&mut self, system: &System, at: &NodeView<f64>, right: &mut Pair) {
        let AccelerationEquations { layout, right: all, dual, point, .. } = self;
        right.v.fill(0.0);
        right.sigma.fill(0.0);
        layout.load(at, point);
        for programs in all {
            programs.run(point, |&place, value| *sum(layout.n, right, place) += value);
        }
        dual.iter().for_each(|&place| system.item(place).add_acceleration(at, right));
    }

    /// Adds the derivatives of c·f + e·g at a state with σ = 0, for its v̇ and λ.
    pub(crate) fn pull_back(&mut self, system: &System, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        let AccelerationEquations { layout, rows: all, dual, point, .. } = self;
        layout.load(at, point);
        layout.load_covector(&Covector { c: &with.v, d: &with.v, e: &with.sigma }, point);
        layout.load_accelerations(at, point);
        for programs in all {
            programs.run(point, |(argument, factor), value| rows.add(*argument, factor * value));
        }
        dual.iter().for_each(|&place| system.item(place).pull_back_acceleration(at, with, rows));
    }
}

/// The sum to which a component of an element's f or g is added: n momenta, then m equations.
fn place(layout: &Layout, element: &Element, of: Component) -> usize {
    match of {
        Component::Momentum(i) | Component::Force(i) => element.to.q[i],
        Component::Equation(j) => layout.n + element.to.sigma[j],
    }
}

fn sum(n: usize, sums: &mut Pair, place: usize) -> &mut f64 {
    if place < n { &mut sums.v[place] } else { &mut sums.sigma[place - n] }
}

/// Directional derivatives of f, of g, and of the derivatives of c·f + e·g, for all elements.
pub(crate) struct AccelerationSecondOrder {
    layout: Layout,
    tangents: Vec<ElementPrograms<usize>>,
    rows: Vec<ElementPrograms<(Argument, f64)>>,
    /// Elements without a program.
    branching: Vec<Branches>,
    point: Vec<f64>,
}

impl AccelerationSecondOrder {
    /// Creates the programs and runs all preludes for these design variables.
    pub(crate) fn fixed(system: &System, elements: &[Element], design: &[f64]) -> Self {
        let mut all = AccelerationSecondOrder::new(system, elements);
        all.fix(elements, design);
        all
    }

    fn new(system: &System, elements: &[Element]) -> Self {
        let layout = system.layout();
        let point = vec![0.0; layout.len()];
        let mut all =
            AccelerationSecondOrder { layout, tangents: Vec::new(), rows: Vec::new(), branching: Vec::new(), point };
        for alike in &Alike::all(elements) {
            let bound = alike.bound();
            let Some((changes, rows)) = equations_along(alike.formula, &bound).zip(rows_along(alike.formula, &bound)) else {
                all.branching.extend(alike.numbers.iter().map(|&e| Branches::new(e, &bound)));
                continue;
            };
            let sum = |element: &Element, of| place(&layout, element, of);
            all.tangents.extend(ElementPrograms::new(&layout, alike, changes, sum));
            all.rows.extend(ElementPrograms::new(&layout, alike, rows, |element, slot| element.to.argument(slot)));
        }
        all
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        let parameters = |e: usize| elements[e].with_factors(design);
        self.tangents.iter_mut().for_each(|programs| programs.fix(parameters));
        self.rows.iter_mut().for_each(|programs| programs.fix(parameters));
    }

    /// Computes the directional derivatives of f and g at a state with σ = 0, with v̇ and λ fixed.
    pub(crate) fn changes(
        &mut self,
        (system, elements): (&System, &[Element]),
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        result: &mut Pair,
    ) {
        let AccelerationSecondOrder { layout, tangents, branching, point, .. } = self;
        result.v.fill(0.0);
        result.sigma.fill(0.0);
        layout.load(at, point);
        layout.load_direction(along, point);
        layout.load_accelerations(at, point);
        for programs in tangents {
            programs.run(point, |&place, value| *sum(layout.n, result, place) += value);
        }
        let without_programs = branching.iter().map(|branches| system.item(elements[branches.element].place));
        without_programs.for_each(|item| item.add_acceleration_change((at, along), result));
    }

    /// Adds the directional derivatives of the derivatives of c·f + e·g at a state with σ = 0, with v̇ and λ fixed.
    ///
    /// # Errors
    /// A formula without a program panics while it is recorded.
    pub(crate) fn pull_back(
        &mut self,
        (system, elements): (&System, &[Element]),
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        with: &Pair,
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        let AccelerationSecondOrder { layout, rows: all, branching, point, .. } = self;
        layout.load(at, point);
        layout.load_covector(&Covector { c: &with.v, d: &with.v, e: &with.sigma }, point);
        layout.load_direction(along, point);
        layout.load_accelerations(at, point);
        for programs in all {
            programs.run(point, |(argument, factor), value| rows.add(*argument, factor * value));
        }
        branching.iter_mut().try_for_each(|branches| {
            let element = &elements[branches.element];
            branches.pull_back((element, system.item(element.place)), at, (layout, point), rows)
        })
    }
}

/// Computes the directional derivatives of f and g of all elements at a state with σ = 0, with v̇ and λ fixed, by the plain formulas, as lifted
/// numbers require.
pub(crate) fn acceleration_tangent(
    (system, elements): (&System, &[Element]),
    (at, along): (&NodeView<f64>, &NodeView<f64>),
    result: &mut Pair,
) {
    result.v.fill(0.0);
    result.sigma.fill(0.0);
    elements.iter().for_each(|element| system.item(element.place).add_acceleration_change((at, along), result));
}
