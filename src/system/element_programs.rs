//! [`Alike`]: the elements of one formula, and [`ElementPrograms`]: a program for all of them, and where each of its results is added.

use std::collections::HashMap;
use std::sync::Arc;

use super::element::Element;
use super::formula::Formula;
use super::point::Layout;
use crate::model::Param;
use crate::program::{Kernel, Lanes};

/// The elements of one formula.
pub(super) struct Alike<'a> {
    pub(super) formula: &'a Formula,
    pub(super) elements: Vec<&'a Element>,
    /// Their numbers among all elements.
    pub(super) numbers: Vec<usize>,
}

impl<'a> Alike<'a> {
    /// All elements by their formulas, in the order of the first of each.
    pub(super) fn all(elements: &'a [Element]) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        let mut known: HashMap<*const Formula, usize> = HashMap::new();
        for (number, element) in elements.iter().enumerate() {
            let at = *known.entry(Arc::as_ptr(&element.formula)).or_insert_with(|| {
                all.push(Alike { formula: &element.formula, elements: Vec::new(), numbers: Vec::new() });
                all.len() - 1
            });
            all[at].elements.push(element);
            all[at].numbers.push(number);
        }
        all
    }

    /// Which of the formula's constants are bound to design variables.
    pub(super) fn bound(&self) -> Vec<bool> {
        Param::which_are_bound(&self.elements[0].b)
    }

    /// Where they stand, by batch and item.
    pub(super) fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        self.elements.iter().map(|element| element.place)
    }

    /// A program for them, side by side.
    pub(super) fn lanes(&self, layout: &Layout, kernel: Kernel) -> Lanes {
        let source = |e: usize, which: usize| layout.source(self.elements[e], self.formula.shape.place(which));
        Lanes::new(kernel, self.elements.len(), source)
    }
}

/// See the module; a result goes to a `T`.
pub(super) struct ElementPrograms<T> {
    numbers: Vec<usize>,
    lanes: Lanes,
    registers: Vec<f64>,
    /// Result by result, and of each element by element.
    to: Vec<T>,
}

impl<T> ElementPrograms<T> {
    /// For elements of one formula, if there are any results; `to` says where a result of an element goes, by what it is.
    pub(super) fn new<R: Copy>(
        layout: &Layout,
        alike: &Alike,
        (kernel, results): (Kernel, &[R]),
        to: impl Fn(&Element, R) -> T,
    ) -> Option<Self> {
        let of_all = |&of: &R| alike.elements.iter().map(|element| to(element, of)).collect::<Vec<T>>();
        let (to, lanes) = (results.iter().flat_map(of_all).collect(), alike.lanes(layout, kernel));
        let programs = ElementPrograms { numbers: alike.numbers.clone(), registers: lanes.registers(), lanes, to };
        (!results.is_empty()).then_some(programs)
    }

    /// Runs the preludes, with the parameters of every element.
    pub(super) fn fix(&mut self, parameters: impl Fn(usize) -> Vec<f64>) {
        self.lanes.fix(|e| parameters(self.numbers[e]), &mut self.registers);
    }

    /// Runs the program at a point, and adds every result.
    pub(super) fn run(&mut self, point: &[f64], mut add: impl FnMut(&T, f64)) {
        let (count, to) = (self.numbers.len(), &self.to);
        self.lanes.run(point, &mut self.registers, |e, k, values| {
            to[k * count + e..].iter().zip(values).for_each(|(to, value)| add(to, *value));
        });
    }
}
