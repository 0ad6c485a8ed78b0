//! [`Kinks`]: the kinks of the elements along a motion, that is, the zeros of the functions [`Graph::kinks`](crate::program::Graph::kinks).

use std::collections::HashMap;

use super::System;
use super::cost::CostRows;
use super::formula::{Alike, Argument, Element, ElementPrograms, Layout, NodeView};

/// The functions whose zeros are kinks, of all elements that have any.
#[derive(Default)]
pub(crate) struct Kinks {
    all: Vec<Kink>,
    groups: Vec<Group>,
    layout: Layout,
    point: Vec<f64>,
}

/// A kink of an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kink {
    /// The number of the element among all elements.
    pub(crate) element: usize,
    /// Whether it is rounded over the unit length of its function.
    pub(crate) is_smooth: bool,
}

/// The kinks of the elements with a common formula.
struct Group {
    values: Option<ElementPrograms<usize>>,
    slopes: Option<ElementPrograms<(usize, (Argument, f64))>>,
}

impl System {
    /// Whether any element has a kink that is known.
    pub(crate) fn has_kinks(&self) -> bool {
        let mut kernels = self.0.formulas.elements.iter().filter_map(|element| element.formula.kernels.as_ref());
        kernels.any(|kernels| kernels.kinks.is_some())
    }
}

impl Kinks {
    /// The kinks of these elements, for a motion with these values of the parameters.
    pub(crate) fn new(system: &System, elements: &[Element], design: &[f64]) -> Self {
        let layout = system.layout();
        let mut kinks = Kinks { layout, ..Kinks::default() };
        Alike::all(elements).iter().for_each(|alike| kinks.add(alike));
        if !kinks.all.is_empty() {
            kinks.point = vec![0.0; layout.len()];
        }
        let parameters = |number: usize| elements[number].parameters(design);
        for Group { values, slopes } in &mut kinks.groups {
            values.iter_mut().for_each(|values| values.fix(parameters));
            slopes.iter_mut().for_each(|slopes| slopes.fix(parameters));
        }
        kinks
    }

    fn add(&mut self, alike: &Alike) {
        let Some(formula) = alike.formula.kernels.as_ref().and_then(|kernels| kernels.kinks.as_ref()) else { return };
        let (first, count) = (self.all.len(), formula.is_smooth.len());
        for &element in &alike.numbers {
            self.all.extend(formula.is_smooth.iter().map(|&is_smooth| Kink { element, is_smooth }));
        }
        let numbers: HashMap<(usize, usize), usize> = alike.places().zip(0..).collect();
        let which = |element: &Element, k: usize| first + count * numbers[&element.place] + k;
        let values = ElementPrograms::new(&self.layout, alike, formula.values.clone(), which);
        let slopes = ElementPrograms::new(&self.layout, alike, formula.slopes.clone(), |element, (k, slot)| {
            (which(element, k), element.to.argument(slot))
        });
        self.groups.push(Group { values, slopes });
    }

    pub(crate) fn all(&self) -> &[Kink] {
        &self.all
    }

    /// The name of the element of a kink.
    pub(crate) fn element<'a>(&self, system: &'a System, kink: usize) -> &'a str {
        &system.formulas().elements[self.all[kink].element].name
    }

    /// Evaluates the functions of all kinks.
    pub(crate) fn evaluate(&mut self, at: &NodeView<f64>, values: &mut [f64]) {
        self.layout.load(at, &mut self.point);
        for programs in self.groups.iter_mut().filter_map(|group| group.values.as_mut()) {
            programs.run(&self.point, |&which, value| values[which] = value);
        }
    }

    /// Adds the derivatives of the function of one kink.
    pub(crate) fn add_slopes(&mut self, kink: usize, at: &NodeView<f64>, rows: &mut CostRows) {
        self.layout.load(at, &mut self.point);
        for programs in self.groups.iter_mut().filter_map(|group| group.slopes.as_mut()) {
            programs.run(&self.point, |&(which, (argument, factor)), slope| {
                if which == kink {
                    rows.add(argument, factor * slope);
                }
            });
        }
    }
}
