//! [`Assembly`]: the elements that are evaluated at every point, grouped by formula, and the destinations of their results.

use std::sync::OnceLock;

use super::products::{Products, Wanted};
use super::scatter::Scatter;
use super::second_order::SecondOrderEquations;
use crate::number::larger;
use crate::program::{Lanes, Places};
use crate::system::formula::{
    Alike, Argument, Batches, BlockEntry, Component, Covector, Element, InputRows, Kernels, Layout, NodeView, RelativeEntry,
    StateRows, Sums, Within,
};

/// Elements with a common formula whose derivatives vary along a motion.
#[derive(Clone, Debug)]
struct Group {
    elements: Vec<usize>,
    state: Lanes,
    /// Where components are added to the sums, and where the first of them are subtracted.
    sums: [Vec<Places>; 2],
}

/// Elements with a common formula that has derivatives with respect to inputs.
#[derive(Clone, Debug)]
struct InputGroup {
    elements: Vec<usize>,
    inputs: Lanes,
    /// The input and the factor of each result, for each element.
    of: Vec<(Argument, f64)>,
}

/// Elements with a common formula that may be nonlinear within a step.
#[derive(Clone, Debug)]
struct BendingGroup {
    elements: Vec<usize>,
    along: Lanes,
}

/// All elements that are evaluated at every point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assembly {
    layout: Layout,
    groups: Vec<Group>,
    input_groups: Vec<InputGroup>,
    /// Elements that num-dual evaluates, and elements whose derivatives with respect to inputs it evaluates.
    dual: Vec<usize>,
    dual_inputs: Vec<usize>,
    /// The number of second derivatives of the elements in `dual`, which are stored last.
    dual_len: usize,
    /// Elements that may be nonlinear within a step: the groups that have programs, and all such elements, in which these groups come first.
    bending_groups: Vec<BendingGroup>,
    bending: Vec<usize>,
    /// Elements whose second derivatives are stored, ordered by entry and within an entry by element; their number, and where each is added.
    varying: Vec<usize>,
    len: usize,
    tangent: Vec<Scatter>,
    products: Vec<Products>,
}

/// The registers of all programs, including the results of the preludes for one set of design variables.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    state: Vec<Vec<f64>>,
    inputs: Vec<Vec<f64>>,
    along: Vec<Vec<f64>>,
    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate at both ends of a step, for every element that may be nonlinear.
    ends: [[Vec<f64>; 2]; 2],
    point: Vec<f64>,
    /// The point at which derivatives with respect to inputs are evaluated.
    input_point: Vec<f64>,
}

impl Assembly {
    /// Assembles all elements of a scene; `slot` returns the index at which K stores an entry.
    pub(crate) fn new(elements: &[Element], layout: Layout, slot: &dyn Fn(usize, usize) -> usize) -> Self {
        let mut assembly = Assembly { layout, ..Assembly::default() };
        for alike in Alike::all(elements) {
            let (formula, own) = (alike.formula, &alike.elements);
            let Some(kernels) = &formula.kernels else {
                assembly.dual.extend(&alike.numbers);
                assembly.dual_inputs.extend(&alike.numbers);
                continue;
            };
            if formula.may_bend() {
                let (elements, along) = (alike.numbers.clone(), alike.lanes(&layout, kernels.along.clone()));
                assembly.bending_groups.push(BendingGroup { elements, along });
            }
            if !kernels.inputs.of.is_empty() {
                let of = kernels.inputs.of.iter().flat_map(|slot| own.iter().map(|element| element.to.argument(*slot)));
                let (of, inputs) = (of.collect(), alike.lanes(&layout, kernels.inputs.kernel.clone()));
                assembly.input_groups.push(InputGroup { elements: alike.numbers.clone(), inputs, of });
            }
            if formula.is_varying() {
                let state = alike.lanes(&layout, kernels.state.clone());
                let targets = |of: &[Component]| state.targets(of.len(), |e, k| layout.sum(own[e], of[k]));
                let sums = [targets(&kernels.components), targets(&kernels.negatives)];
                assembly.groups.push(Group { elements: alike.numbers, state, sums });
            }
        }
        let programmed = assembly.bending_groups.iter().flat_map(|group| &group.elements);
        let others = assembly.dual.iter().filter(|&&e| elements[e].formula.may_bend());
        assembly.bending = programmed.chain(others).copied().collect();
        let programmed = assembly.groups.iter().map(|group| group.elements.clone());
        let lists: Vec<Vec<usize>> = programmed.chain(assembly.dual.iter().map(|&e| vec![e])).collect();
        lists.into_iter().for_each(|members| assembly.store(elements, members, slot));
        assembly.dual_len = assembly.dual.iter().map(|&e| elements[e].formula.varying.len()).sum();
        assembly
    }

    /// Reserves storage for the second derivatives of the elements of one formula.
    fn store(&mut self, elements: &[Element], members: Vec<usize>, slot: &dyn Fn(usize, usize) -> usize) {
        let own: Vec<&Element> = members.iter().map(|&e| &elements[e]).collect();
        let slots = |e: usize, entry: &BlockEntry| {
            let [row, col] = own[e].unknowns(entry, self.layout.n);
            [slot(row, col) as u32, slot(col, row) as u32]
        };
        let varying = &own[0].formula.varying;
        self.tangent.extend(Scatter::all(varying, own.len(), self.len, slots));
        for entries in varying.chunk_by(RelativeEntry::is_like) {
            self.products.extend(Products::all(entries, &own, self.len));
            self.len += entries.len() * own.len();
        }
        self.varying.extend(members);
    }

    /// The number of second derivatives at a point.
    pub(crate) fn block_len(&self) -> usize {
        self.len
    }

    /// Whether any element is evaluated at every point.
    pub(crate) fn is_empty(&self) -> bool {
        self.varying.is_empty()
    }

    /// The number of elements that are evaluated at every point.
    pub(crate) fn elements(&self) -> usize {
        self.varying.len()
    }

    pub(crate) fn workspace(&self) -> Workspace {
        Workspace {
            state: self.groups.iter().map(|group| group.state.registers()).collect(),
            inputs: self.input_groups.iter().map(|group| group.inputs.registers()).collect(),
            along: self.bending_groups.iter().map(|group| group.along.registers()).collect(),
            ends: [(); 2].map(|()| [(); 2].map(|()| vec![0.0; self.bending.len()])),
            point: vec![0.0; self.layout.len()],
            input_point: vec![0.0; self.layout.len()],
        }
    }

    /// Runs all preludes for the design variables of an initial state.
    pub(crate) fn fix(&self, parameters: impl Fn(usize) -> Vec<f64>, workspace: &mut Workspace) {
        for (group, registers) in self.groups.iter().zip(&mut workspace.state) {
            group.state.fix(|e| parameters(group.elements[e]), registers);
        }
        for (group, registers) in self.input_groups.iter().zip(&mut workspace.inputs) {
            group.inputs.fix(|e| parameters(group.elements[e]), registers);
        }
        for (group, registers) in self.bending_groups.iter().zip(&mut workspace.along) {
            group.along.fix(|e| parameters(group.elements[e]), registers);
        }
    }

    /// Writes the second derivatives at the point that was evaluated last.
    pub(crate) fn second(&self, workspace: &mut Workspace, blocks: &mut [f64]) {
        let mut begin = 0;
        for (group, registers) in self.groups.iter().zip(&mut workspace.state) {
            let count = group.elements.len();
            let own = &mut blocks[begin..][..count * group.state.kernel().stage(Kernels::SECOND).results().len()];
            group.state.go_on(Kernels::SECOND, registers, |e, k, values| match values {
                [value] => own[k * count + e] = *value,
                _ => own[k * count + e..][..values.len()].copy_from_slice(values),
            });
            begin += own.len();
        }
    }

    /// Adds the varying entries of K(h) to its values, computed from the stored blocks.
    pub(crate) fn scatter(&self, blocks: &[f64], h: f64, values: &mut [f64]) {
        self.tangent.iter().for_each(|scatter| scatter.add(blocks, h, values));
    }

    /// Adds the derivatives of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to v, q and σ, computed from the stored blocks.
    pub(crate) fn pull_back(&self, blocks: &[f64], with: &Covector, wanted: impl Wanted, rows: &mut StateRows) {
        self.products.iter().for_each(|products| products.pull_back(blocks, with, wanted, rows));
    }

    /// Adds the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along a direction of the state, computed from the stored blocks.
    pub(crate) fn push_forward(&self, blocks: &[f64], along: (&NodeView<f64>, impl Wanted), sums: &mut Sums<f64>) {
        self.products.iter().for_each(|products| products.push_forward(blocks, along, sums));
    }

    /// The number of elements that may be nonlinear within a step.
    pub(crate) fn bending(&self) -> usize {
        self.bending.len()
    }

    /// Whether `pull_back_inputs` adds anything.
    pub(crate) fn has_input_derivatives(&self) -> bool {
        !self.input_groups.is_empty() || !self.dual_inputs.is_empty()
    }
}

/// The elements of a scene with their formulas, and the assembly of those that are evaluated at every point.
#[derive(Debug)]
pub struct Formulas {
    pub elements: Vec<Element>,
    pub assembly: Assembly,
    /// Compiled when it is first needed.
    pub(in crate::system) second_order: OnceLock<SecondOrderEquations>,
}

impl Formulas {
    /// The second-order equations, for any design variables.
    pub(crate) fn second_order(&self) -> SecondOrderEquations {
        self.second_order.get_or_init(|| SecondOrderEquations::new(self.assembly.layout, &self.elements)).clone()
    }

    /// Adds 𝓛_v, 𝓛_q + Q and dΦ/dt of all elements except constant and sinusoidal ones; also writes the blocks of elements that num-dual evaluates.
    pub(crate) fn first(
        &self,
        batches: &Batches,
        at: &NodeView<f64>,
        workspace: &mut Workspace,
        (sums, blocks): (&mut Sums<f64>, &mut [f64]),
    ) {
        let Formulas { elements, assembly, .. } = self;
        let Workspace { point, state, .. } = workspace;
        assembly.layout.load(at, point);
        for (group, registers) in assembly.groups.iter().zip(state) {
            group.state.run_and_add(point, registers, &group.sums, &mut sums.all);
        }
        let mut rest = &mut blocks[assembly.block_len() - assembly.dual_len..];
        for &e in &assembly.dual {
            let (own, after) = rest.split_at_mut(elements[e].formula.varying.len());
            batches.item(elements[e].place).evaluate(at, sums, own);
            rest = after;
        }
    }

    /// Adds the derivatives with respect to u (except for constant elements), design variables and time.
    pub(crate) fn pull_back_inputs(
        &self,
        batches: &Batches,
        at: &NodeView<f64>,
        with: &Covector,
        workspace: &mut Workspace,
        rows: &mut InputRows,
    ) {
        let Formulas { elements, assembly, .. } = self;
        if !assembly.input_groups.is_empty() {
            assembly.layout.load(at, &mut workspace.input_point);
            assembly.layout.load_covector(with, &mut workspace.input_point);
        }
        let Workspace { input_point: point, inputs, .. } = workspace;
        for (group, registers) in assembly.input_groups.iter().zip(inputs) {
            let count = group.elements.len();
            group.inputs.run(point, registers, |e, k, values| {
                group.of[k * count + e..].iter().zip(values).for_each(|(of, value)| rows.add(*of, *value));
            });
        }
        for &e in &assembly.dual_inputs {
            batches.item(elements[e].place).pull_back_inputs(at, with, rows);
        }
    }

    /// Reports the nonlinearity of each element that may be nonlinear within a step between `ends`; `change` is the change of the arguments.
    pub(crate) fn look_within(
        &self,
        batches: &Batches,
        (ends, change): ([&NodeView<f64>; 2], &NodeView<f64>),
        with: &Covector,
        workspace: &mut Workspace,
        show: &mut dyn FnMut(Within),
    ) {
        let Formulas { elements, assembly, .. } = self;
        let Workspace { along, ends: values, input_point: point, .. } = workspace;
        assembly.layout.load_covector(with, point);
        assembly.layout.load_direction(change, point);
        for (end, at) in ends.into_iter().enumerate() {
            assembly.layout.load(at, point);
            let mut begin = 0;
            for (group, registers) in assembly.bending_groups.iter().zip(&mut *along) {
                group.along.run(point, registers, |e, k, results| {
                    values[end][k][begin + e..][..results.len()].copy_from_slice(results);
                });
                begin += group.elements.len();
            }
            for (i, &e) in assembly.bending.iter().enumerate().skip(begin) {
                let [value, rate] = batches.item(elements[e].place).along(at, change, with);
                (values[end][0][i], values[end][1][i]) = (value, rate);
            }
        }
        let [begin, end] = values.each_ref().map(|[value, rate]| value.iter().zip(rate));
        for (&element, ((begin, begin_rate), (end, end_rate))) in assembly.bending.iter().zip(begin.zip(end)) {
            let (change, told) = (end - begin, 0.5 * (begin_rate + end_rate));
            show(Within { element, missed: change - told, change: larger(change.abs(), told.abs()) });
        }
    }
}
