//! Third derivatives of 𝓛 and second derivatives of Q along a direction, element by element, for second-order sweeps.

use crate::system::cost::CostRows;
use crate::system::formula::{
    Alike, Argument, Batches, Covector, Element, ElementPrograms, Layout, NodeView, SecondOrderKernels, Sums,
};

/// The second-order equations of all elements of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct SecondOrderEquations {
    layout: Layout,
    /// Changes along the inputs, which are added to the sums.
    changes: Vec<ElementPrograms<usize>>,
    /// The derivatives of D ψ; each result has its argument and a factor.
    rows: Vec<ElementPrograms<(Argument, f64)>>,
    /// Elements that num-dual evaluates.
    dual: Vec<(usize, usize)>,
    point: Vec<f64>,
}

impl SecondOrderEquations {
    pub(super) fn new(layout: Layout, elements: &[Element]) -> Self {
        let point = vec![0.0; layout.len()];
        let mut all = SecondOrderEquations { layout, point, ..SecondOrderEquations::default() };
        for alike in &Alike::all(elements) {
            let Some(kernels) = SecondOrderKernels::new(alike.formula, &alike.bound()) else {
                all.dual.extend(alike.places());
                continue;
            };
            let SecondOrderKernels { changes, rows } = kernels;
            let sum = |element: &Element, of| layout.sum(element, of);
            all.changes.extend(ElementPrograms::new(&layout, alike, changes, sum));
            all.rows.extend(ElementPrograms::new(&layout, alike, rows, |element, slot| element.to.argument(slot)));
        }
        all
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        let parameters = |e: usize| elements[e].with_factors(design);
        self.changes.iter_mut().for_each(|programs| programs.fix(parameters));
        self.rows.iter_mut().for_each(|programs| programs.fix(parameters));
    }

    /// Adds the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along the inputs u, t and b, except along the controls of constant elements.
    pub(crate) fn add_changes(
        &mut self,
        batches: &Batches,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        sums: &mut Sums<f64>,
    ) {
        let SecondOrderEquations { layout, changes, dual, point, .. } = self;
        if !changes.is_empty() {
            layout.load(at, point);
            layout.load_direction(along, point);
        }
        for programs in changes {
            programs.run(point, |&place, value| sums.all[place] += value);
        }
        dual.iter().for_each(|&place| batches.item(place).add_changes(at, along, sums));
    }

    /// Adds the derivatives of D ψ, except those of sinusoidal elements with respect to the state.
    pub(crate) fn pull_back(
        &mut self,
        batches: &Batches,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        with: &Covector,
        rows: &mut CostRows,
    ) {
        let SecondOrderEquations { layout, rows: all, dual, point, .. } = self;
        if !all.is_empty() {
            layout.load(at, point);
            layout.load_covector(with, point);
            layout.load_direction(along, point);
        }
        for programs in all {
            programs.run(point, |(argument, factor), value| rows.add(*argument, factor * value));
        }
        dual.iter().for_each(|&place| batches.item(place).pull_back_along((at, along), with, rows));
    }
}
