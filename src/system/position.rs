//! [`PositionConstraints`]: Φ of all constraints at a point, by programs.

use super::assembly::by_formula;
use super::batch::Batch;
use super::element::Element;
use super::element_programs::ElementPrograms;
use super::formula::Formula;
use super::jet::ElementKind;
use super::point::Layout;
use super::typed::OnNumbers;
use super::view::NodeView;
use crate::System;
use crate::program::Kernel;

/// See the module; made when a motion asks for Φ on its way.
pub(crate) struct PositionConstraints {
    layout: Layout,
    programs: Vec<ElementPrograms<usize>>,
    /// Constraints without a program.
    plain: Vec<(usize, usize)>,
    point: Vec<f64>,
}

impl PositionConstraints {
    pub(crate) fn new(system: &System, elements: &[Element]) -> Self {
        let layout = Layout { n: system.n(), m: system.m(), k: system.k() };
        let (mut programs, mut plain) = (Vec::new(), Vec::new());
        for (formula, members) in
            by_formula(elements).into_iter().filter(|(formula, _)| formula.kind == ElementKind::Holonomic)
        {
            let own: Vec<&Element> = members.iter().map(|&e| &elements[e]).collect();
            let Some(kernel) = kernel(&formula) else {
                plain.extend(own.iter().map(|element| (element.batch, element.item)));
                continue;
            };
            let equations: Vec<usize> = (0..formula.shape.m).collect();
            let equation = |element: &Element, j: usize| element.sigma[j];
            programs.push(ElementPrograms::new(&layout, &formula, (kernel, &equations), (&members, &own), equation));
        }
        PositionConstraints { layout, programs, plain, point: vec![0.0; layout.len()] }
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        self.programs.iter_mut().for_each(|programs| programs.fix(|e| elements[e].parameters(design)));
    }

    /// Writes Φ.
    pub(crate) fn evaluate(&mut self, batches: &[Batch], at: &NodeView<f64>, phi: &mut [f64]) {
        self.layout.load(at, &mut self.point);
        for programs in &mut self.programs {
            programs.run(&self.point, |&equation, value| phi[equation] = value);
        }
        for &(batch, item) in &self.plain {
            let item = &batches[batch].items[item];
            item.write_phi::<f64>(&*item.formula as &dyn OnNumbers<f64>, at, phi);
        }
    }
}

fn kernel(formula: &Formula) -> Option<Kernel> {
    formula.kernels.as_ref()?;
    let template = formula.template.as_ref()?;
    let (mut graph, values) = template.graph();
    Kernel::new(&mut graph, template.parameters, &values)
}
