//! Accelerations v̇ and reactions λ = dσ/dt of a state, element by element: Eq. (1a, 1c) differentiated in time.
//!
//! With D the derivative in time for given v̇ and λ, that is along (v, v̇, λ, 1) of (q, v, σ, t), at σ = 0,
//!
//! ```text
//!   f = 𝓛_q + Q − D 𝓛_v = 0      g = −D dΦ/dt = 0        which is  r − K(0) (v̇, λ) = 0
//! ```
//!
//! since λ does not depend on σ: what σ adds to 𝓛_q is what it adds to D 𝓛_v. For an adjoint (c, e) of these equations the derivatives of
//! c·f + e·g with respect to q, v, u, t and parameters are third derivatives of 𝓛, made by programs or by num-dual.

use std::sync::Arc;

use super::acceleration_kernels::{AccelerationKernels, rows_along};
use super::assembly::by_formula;
use super::batch::{Batch, Covector, Pair, Sums};
use super::branches::Branches;
use super::cost::CostRows;
use super::element::Element;
use super::formula::{Component, Formula};
use super::plain::{HyperPoint, add_sums};
use super::point::Layout;
use super::target::Target;
use super::view::NodeView;
use crate::number::{Hyper, hyper, hyper_parts};
use crate::program::{Kernel, Lanes};
use crate::{Error, System};

/// Elements of one formula.
struct Group {
    elements: Vec<usize>,
    /// r, and of each element where its components are added: n momenta, then m equations.
    right: Lanes,
    right_registers: Vec<f64>,
    sums: Vec<usize>,
    /// The derivatives of c·f + e·g, and with respect to what, by which factor.
    rows: Lanes,
    rows_registers: Vec<f64>,
    of: Vec<(Target, f64)>,
}

/// The equations of accelerations and reactions of a scene.
pub(crate) struct AccelerationEquations {
    layout: Layout,
    groups: Vec<Group>,
    /// Elements that num-dual evaluates.
    dual: Vec<(usize, usize)>,
    point: Vec<f64>,
}

impl AccelerationEquations {
    pub(crate) fn new(system: &System, elements: &[Element]) -> Self {
        let (n, m, k) = (system.n(), system.m(), system.k());
        let layout = Layout { n, m, k };
        let (mut groups, mut dual) = (Vec::new(), Vec::new());
        for (formula, members) in by_formula(elements) {
            let own: Vec<&Element> = members.iter().map(|&e| &elements[e]).collect();
            let bound: Vec<bool> = own[0].b.iter().map(|b| b.constant().is_none()).collect();
            match AccelerationKernels::new(&formula, &bound) {
                Some(kernels) => groups.push(Group::new(&layout, &formula, kernels, (members, &own))),
                None => dual.extend(own.iter().map(|element| (element.batch, element.item))),
            }
        }
        AccelerationEquations { layout, groups, dual, point: vec![0.0; layout.len()] }
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        for Group { elements: own, right, right_registers, rows, rows_registers, .. } in &mut self.groups {
            right.fix(|e| elements[own[e]].parameters(design), right_registers);
            rows.fix(|e| elements[own[e]].parameters(design), rows_registers);
        }
    }

    /// r at a state with σ = 0.
    pub(crate) fn right(&mut self, batches: &[Batch], at: &NodeView<f64>, right: &mut Pair) {
        let AccelerationEquations { layout, groups, dual, point } = self;
        let n = layout.n;
        right.v.fill(0.0);
        right.sigma.fill(0.0);
        layout.load(at, point);
        for Group { elements, right: program, right_registers, sums, .. } in groups {
            let count = elements.len();
            program.run(point, right_registers, |e, k, values| {
                for (&place, value) in sums[k * count + e..].iter().zip(values) {
                    *(if place < n { &mut right.v[place] } else { &mut right.sigma[place - n] }) += value;
                }
            });
        }
        dual.iter().for_each(|&(batch, item)| batches[batch].items[item].add_acceleration(at, right));
    }

    /// Adds the derivatives of c·f + e·g at a state with σ = 0 and its v̇ and λ.
    pub(crate) fn pull_back(&mut self, batches: &[Batch], at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        let AccelerationEquations { layout, groups, dual, point } = self;
        layout.load(at, point);
        layout.load_covector(&Covector { c: &with.v, d: &with.v, e: &with.sigma }, point);
        layout.load_accelerations(at, point);
        for Group { elements, rows: program, rows_registers, of, .. } in groups {
            let count = elements.len();
            program.run(point, rows_registers, |e, k, values| {
                for (&(target, factor), value) in of[k * count + e..].iter().zip(values) {
                    target.add(rows, factor * value);
                }
            });
        }
        dual.iter().for_each(|&(batch, item)| batches[batch].items[item].pull_back_acceleration(at, with, rows));
    }
}

impl Group {
    fn new(
        layout: &Layout,
        formula: &Arc<Formula>,
        kernels: AccelerationKernels,
        (elements, own): (Vec<usize>, &[&Element]),
    ) -> Self {
        let AccelerationKernels { right, components, rows, of } = kernels;
        let source = |e: usize, which: usize| layout.source(own[e], formula.shape.place(which));
        let lanes = |kernel: Kernel| Lanes::new(kernel, own.len(), source);
        let (right, rows) = (lanes(right), lanes(rows));
        let sum = |of: &Component, element: &Element| match *of {
            Component::Momentum(i) | Component::Force(i) => element.q[i],
            Component::Equation(j) => layout.n + element.sigma[j],
        };
        let sums = components.iter().flat_map(|of| own.iter().map(move |element| sum(of, element))).collect();
        let of = of.iter().flat_map(|of| own.iter().map(|element| Target::of(element, *of))).collect();
        let (right_registers, rows_registers) = (right.registers(), rows.registers());
        Group { elements, right, right_registers, sums, rows, rows_registers, of }
    }
}

/// Elements of one formula.
struct AlongGroup {
    elements: Vec<usize>,
    rows: Lanes,
    registers: Vec<f64>,
    of: Vec<(Target, f64)>,
}

/// What the derivatives of c·f + e·g change by along a direction, of all elements.
pub(crate) struct AccelerationSecondOrder {
    layout: Layout,
    groups: Vec<AlongGroup>,
    /// Elements without a program.
    branching: Vec<Branches>,
    point: Vec<f64>,
}

impl AccelerationSecondOrder {
    pub(crate) fn new(system: &System, elements: &[Element]) -> Self {
        let layout = Layout { n: system.n(), m: system.m(), k: system.k() };
        let (mut groups, mut branching) = (Vec::new(), Vec::new());
        for (formula, members) in by_formula(elements) {
            let own: Vec<&Element> = members.iter().map(|&e| &elements[e]).collect();
            let bound: Vec<bool> = own[0].b.iter().map(|b| b.constant().is_none()).collect();
            let Some((kernel, of)) = rows_along(&formula, &bound) else {
                branching.extend(members.iter().map(|&e| Branches::new(e, &bound)));
                continue;
            };
            let rows = Lanes::new(kernel, own.len(), |e, which| layout.source(own[e], formula.shape.place(which)));
            let of = of.iter().flat_map(|of| own.iter().map(|element| Target::of(element, *of))).collect();
            let registers = rows.registers();
            groups.push(AlongGroup { elements: members, rows, registers, of });
        }
        let point = vec![0.0; layout.len() + system.parameters().len()];
        AccelerationSecondOrder { layout, groups, branching, point }
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        for AlongGroup { elements: own, rows, registers, .. } in &mut self.groups {
            rows.fix(|e| elements[own[e]].with_factors(design), registers);
        }
    }

    /// Adds those changes at a state with σ = 0 and its v̇ and λ, which stay as they are.
    ///
    /// # Errors
    /// A formula without a program that panics when it is recorded.
    pub(crate) fn pull_back(
        &mut self,
        (batches, elements): (&[Batch], &[Element]),
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        with: &Pair,
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        let AccelerationSecondOrder { layout, groups, branching, point } = self;
        layout.load(at, point);
        layout.load_covector(&Covector { c: &with.v, d: &with.v, e: &with.sigma }, point);
        layout.load_direction_beside_accelerations(along, point);
        layout.load_accelerations(at, point);
        for AlongGroup { elements, rows: program, registers, of } in groups {
            let count = elements.len();
            program.run(point, registers, |e, k, values| {
                for (&(target, factor), value) in of[k * count + e..].iter().zip(values) {
                    target.add(rows, factor * value);
                }
            });
        }
        branching.iter_mut().try_for_each(|branches| {
            let element = &elements[branches.element];
            branches.pull_back((element, &batches[element.batch].items[element.item]), at, (layout, point), rows)
        })
    }
}

/// The derivatives of f and g at a state, at fixed v̇ and λ, along the direction of q, v, u, t and parameters that `direction` holds in the same places.
///
/// By the plain formulas, which is what lifted numbers need: ε₁ goes along the direction, ε₂ along the motion.
pub(crate) fn acceleration_tangent(system: &System, at: &NodeView<f64>, direction: &NodeView<f64>, result: &mut Pair) {
    // Values and derivatives along the direction, and rates along the motion of both.
    let list = |[x, along]: [&[f64]; 2], [rate, rate_along]: [&[f64]; 2]| {
        let of = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        let number = |i: usize| hyper(x[i], of(along, i), of(rate, i), of(rate_along, i));
        (0..x.len()).map(number).collect::<Vec<Hyper>>()
    };
    let none = vec![0.0; at.lambda.len()];
    let point = HyperPoint {
        q: list([at.q, direction.q], [at.v, direction.v]),
        v: list([at.v, direction.v], [at.v_dot, &[]]),
        sigma: list([none.as_slice(), &[]], [at.lambda, &[]]),
        u: list([at.u, direction.u], [&[], &[]]),
        t: hyper(at.t, direction.t, 1.0, 0.0),
        design: list([at.design, direction.design], [&[], &[]]),
        of_costs: Default::default(),
    };
    let mut sums = Sums::new(system.n(), system.m());
    add_sums(system.batches().iter(), &point.view(), &mut sums);
    let forces = sums.force().iter().zip(sums.l_v());
    result.v.iter_mut().zip(forces).for_each(|(x, (force, l_v))| *x = hyper_parts(force)[1] - hyper_parts(l_v)[3]);
    result.sigma.iter_mut().zip(sums.phi_dot()).for_each(|(x, phi_dot)| *x = -hyper_parts(phi_dot)[3]);
}
