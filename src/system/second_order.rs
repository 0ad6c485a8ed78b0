//! Third derivatives of 𝓛 and second ones of Q along a direction, element by element: what second-order sweeps are made of.

use std::sync::Arc;

use super::assembly::by_formula;
use super::batch::{Batch, Covector, Sums};
use super::cost::CostRows;
use super::element::Element;
use super::formula::Formula;
use super::point::Layout;
use super::second_order_kernels::SecondOrderKernels;
use super::target::Target;
use super::view::NodeView;
use crate::System;
use crate::program::{Kernel, Lanes};

/// Elements of one formula.
struct Group {
    elements: Vec<usize>,
    /// Changes with the inputs, and of each element where they are added among all sums.
    changes: Lanes,
    changes_registers: Vec<f64>,
    sums: Vec<usize>,
    /// The derivatives of D ψ, and with respect to what, by which factor.
    rows: Lanes,
    rows_registers: Vec<f64>,
    of: Vec<(Target, f64)>,
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
                Some(kernels) => groups.push(Group::new(&layout, &formula, kernels, (members, &own))),
                None => dual.extend(own.iter().map(|element| (element.batch, element.item))),
            }
        }
        let point = vec![0.0; layout.len() + system.parameters().len()];
        SecondOrderEquations { layout, groups, dual, point }
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        let parameters = |e: usize| elements[e].with_factors(design);
        for Group { elements: own, changes, changes_registers, rows, rows_registers, .. } in &mut self.groups {
            changes.fix(|e| parameters(own[e]), changes_registers);
            rows.fix(|e| parameters(own[e]), rows_registers);
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
        if groups.iter().any(|group| !group.sums.is_empty()) {
            layout.load(at, point);
            layout.load_direction(along, point);
        }
        for Group { elements, changes, changes_registers, sums: places, .. } in
            groups.iter_mut().filter(|group| !group.sums.is_empty())
        {
            let count = elements.len();
            changes.run(point, changes_registers, |e, k, values| {
                places[k * count + e..].iter().zip(values).for_each(|(&place, value)| sums.all[place] += value);
            });
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
        if groups.iter().any(|group| !group.of.is_empty()) {
            layout.load(at, point);
            layout.load_covector(with, point);
            layout.load_direction(along, point);
        }
        for Group { elements, rows: program, rows_registers, of, .. } in
            groups.iter_mut().filter(|group| !group.of.is_empty())
        {
            let count = elements.len();
            program.run(point, rows_registers, |e, k, values| {
                for (&(target, factor), value) in of[k * count + e..].iter().zip(values) {
                    target.add(rows, factor * value);
                }
            });
        }
        dual.iter().for_each(|&(batch, item)| batches[batch].items[item].pull_back_along((at, along), with, rows));
    }
}

impl Group {
    fn new(
        layout: &Layout,
        formula: &Arc<Formula>,
        kernels: SecondOrderKernels,
        (elements, own): (Vec<usize>, &[&Element]),
    ) -> Self {
        let SecondOrderKernels { changes, components, rows, of } = kernels;
        let source = |e: usize, which: usize| layout.source(own[e], formula.shape.place(which));
        let lanes = |kernel: Kernel| Lanes::new(kernel, own.len(), source);
        let (changes, rows) = (lanes(changes), lanes(rows));
        let sums = components.iter().flat_map(|of| own.iter().map(|element| layout.sum(element, *of))).collect();
        let of = of.iter().flat_map(|of| own.iter().map(|element| Target::of(element, *of))).collect();
        let (changes_registers, rows_registers) = (changes.registers(), rows.registers());
        Group { elements, changes, changes_registers, sums, rows, rows_registers, of }
    }
}
