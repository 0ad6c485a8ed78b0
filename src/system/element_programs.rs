//! [`ElementPrograms`]: a program for all elements of one formula, and where each of its results is added.

use super::element::Element;
use super::formula::Formula;
use super::point::Layout;
use crate::program::{Kernel, Lanes};

/// See the module; a result goes to a `T`.
pub(super) struct ElementPrograms<T> {
    elements: Vec<usize>,
    lanes: Lanes,
    registers: Vec<f64>,
    /// Result by result, and of each element by element.
    to: Vec<T>,
}

impl<T> ElementPrograms<T> {
    /// For the elements of these numbers, which are `own`; `to` says where a result of an element goes, by what it is.
    pub(super) fn new<R: Copy>(
        layout: &Layout,
        formula: &Formula,
        (kernel, results): (Kernel, &[R]),
        (elements, own): (&[usize], &[&Element]),
        to: impl Fn(&Element, R) -> T,
    ) -> Self {
        let lanes = Lanes::new(kernel, own.len(), |e, which| layout.source(own[e], formula.shape.place(which)));
        let to = results.iter().flat_map(|&of| own.iter().map(|element| to(element, of)).collect::<Vec<T>>()).collect();
        ElementPrograms { elements: elements.to_vec(), registers: lanes.registers(), lanes, to }
    }

    /// Whether there is nothing to add.
    pub(super) fn is_empty(&self) -> bool {
        self.to.is_empty()
    }

    /// Runs the preludes, with the parameters of every element.
    pub(super) fn fix(&mut self, parameters: impl Fn(usize) -> Vec<f64>) {
        self.lanes.fix(|e| parameters(self.elements[e]), &mut self.registers);
    }

    /// Runs the program at a point, and adds every result.
    pub(super) fn run(&mut self, point: &[f64], mut add: impl FnMut(&T, f64)) {
        let (count, to) = (self.elements.len(), &self.to);
        self.lanes.run(point, &mut self.registers, |e, k, values| {
            to[k * count + e..].iter().zip(values).for_each(|(to, value)| add(to, *value));
        });
    }
}
