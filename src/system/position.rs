//! [`PositionConstraints`]: Φ of all constraints at a point, by programs.

use super::element::Element;
use super::element_programs::{Alike, ElementPrograms};
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
        let layout = system.layout();
        let (mut programs, mut plain) = (Vec::new(), Vec::new());
        for alike in Alike::all(elements).iter().filter(|alike| alike.formula.kind == ElementKind::Holonomic) {
            let Some(kernel) = kernel(alike.formula) else {
                plain.extend(alike.places());
                continue;
            };
            let equations: Vec<usize> = (0..alike.formula.shape.m).collect();
            programs
                .extend(ElementPrograms::new(&layout, alike, (kernel, &equations), |element, j: usize| element.sigma[j]));
        }
        PositionConstraints { layout, programs, plain, point: vec![0.0; layout.len()] }
    }

    /// Runs all preludes.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64]) {
        self.programs.iter_mut().for_each(|programs| programs.fix(|e| elements[e].parameters(design)));
    }

    /// Writes Φ.
    pub(crate) fn evaluate(&mut self, system: &System, at: &NodeView<f64>, phi: &mut [f64]) {
        self.layout.load(at, &mut self.point);
        for programs in &mut self.programs {
            programs.run(&self.point, |&equation, value| phi[equation] = value);
        }
        for item in self.plain.iter().map(|&place| system.item(place)) {
            item.write_phi::<f64>(&*item.formula as &dyn OnNumbers<f64>, at, phi);
        }
    }
}

fn kernel(formula: &Formula) -> Option<Kernel> {
    let template = &formula.kernels.as_ref()?.template;
    let (mut graph, values) = template.graph();
    Kernel::new(&mut graph, template.parameters, &values)
}
