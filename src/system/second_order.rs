//! Third derivatives of 𝓛 and second ones of Q along a direction, element by element: what second-order sweeps are made of.

use super::assembly::by_formula;
use super::batch::{Batch, Covector, Sums};
use super::cost::CostRows;
use super::element::Element;
use super::element_programs::ElementPrograms;
use super::formula::Formula;
use super::point::Layout;
use super::second_order_kernels::SecondOrderKernels;
use super::target::Target;
use super::view::NodeView;
use crate::System;

/// Elements of one formula.
struct Group {
    /// Changes with the inputs, which are added among all sums.
    changes: ElementPrograms<usize>,
    /// The derivatives of D ψ, with respect to what, by which factor.
    rows: ElementPrograms<(Target, f64)>,
}

/// All elements of a scene that anything is to be computed of.
pub(crate) struct SecondOrderEquations {
    layout: Layout,
    groups: Vec<Group>,
    /// Elements that num-dual evaluates.
    dual: Vec<(usize, usize)>,
    point: Vec<f64>,
}

impl SecondOrderEquations {
    pub(crate) fn new(system: &System, elements: &[Element]) -> Self {
        let layout = Layout { n: system.n(), m: system.m(), k: system.k() };
        let (mut groups, mut dual) = (Vec::new(), Vec::new());
        for (formula, members) in by_formula(elements) {
            let own: Vec<&Element> = members.iter().map(|&e| &elements[e]).collect();
            let bound: Vec<bool> = own[0].b.iter().map(|b| b.constant().is_none()).collect();
            match SecondOrderKernels::new(&formula, &bound) {
                Some(kernels) if kernels.of.is_empty() && kernels.components.is_empty() => {}
                Some(kernels) => groups.push(Group::new(&layout, &formula, kernels, (&members, &own))),
                None => dual.extend(own.iter().map(|element| (element.batch, element.item))),
            }
        }
        let point = vec![0.0; layout.len() + system.parameters().len()];
        SecondOrderEquations { layout, groups, dual, point }
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        let parameters = |e: usize| elements[e].with_factors(design);
        for Group { changes, rows } in &mut self.groups {
            changes.fix(parameters);
            rows.fix(parameters);
        }
    }

    /// Adds the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt with the inputs u, t and b, without the controls of constant elements.
    pub(crate) fn add_changes(
        &mut self,
        batches: &[Batch],
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        sums: &mut Sums<f64>,
    ) {
        let SecondOrderEquations { layout, groups, dual, point } = self;
        if groups.iter().any(|group| !group.changes.is_empty()) {
            layout.load(at, point);
            layout.load_direction(along, point);
        }
        for Group { changes, .. } in groups.iter_mut().filter(|group| !group.changes.is_empty()) {
            changes.run(point, |&place, value| sums.all[place] += value);
        }
        dual.iter().for_each(|&(batch, item)| batches[batch].items[item].add_changes(at, along, sums));
    }

    /// Adds the derivatives of D ψ, without those of sinusoidal elements by their states.
    pub(crate) fn pull_back(
        &mut self,
        batches: &[Batch],
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        with: &Covector,
        rows: &mut CostRows,
    ) {
        let SecondOrderEquations { layout, groups, dual, point } = self;
        if groups.iter().any(|group| !group.rows.is_empty()) {
            layout.load(at, point);
            layout.load_covector(with, point);
            layout.load_direction(along, point);
        }
        for Group { rows: programs, .. } in groups.iter_mut().filter(|group| !group.rows.is_empty()) {
            programs.run(point, |(target, factor), value| target.add(rows, factor * value));
        }
        dual.iter().for_each(|&(batch, item)| batches[batch].items[item].pull_back_along((at, along), with, rows));
    }
}

impl Group {
    fn new(layout: &Layout, formula: &Formula, kernels: SecondOrderKernels, of: (&[usize], &[&Element])) -> Self {
        let SecondOrderKernels { changes, components, rows, of: arguments } = kernels;
        let sum = |element: &Element, of| layout.sum(element, of);
        Group {
            changes: ElementPrograms::new(layout, formula, (changes, &components), of, sum),
            rows: ElementPrograms::new(layout, formula, (rows, &arguments), of, Target::of),
        }
    }
}
