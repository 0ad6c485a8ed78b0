//! [`Alike`]: the elements with a common formula. [`ElementPrograms`]: a program for all of them, and the destination of each result.

use std::collections::HashMap;
use std::sync::Arc;

use super::connections::Connections;
use super::differentiated::Formula;
use super::element::Element;
use super::labelled::Labelled;
use super::layout::Layout;
use super::shape::Shape;
use crate::program::{Kernel, Lanes};

/// The elements with a common formula.
pub(in crate::system) struct Alike<'a> {
    pub(in crate::system) formula: &'a Formula,
    pub(in crate::system) elements: Vec<&'a Element>,
    /// The numbers of the elements among all elements.
    pub(in crate::system) numbers: Vec<usize>,
}

impl<'a> Alike<'a> {
    /// Groups all elements by formula, in the order in which the formulas first occur.
    pub(in crate::system) fn all(elements: &'a [Element]) -> Vec<Self> {
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

    /// Whether each constant of the formula is bound to a design variable.
    pub(in crate::system) fn bound(&self) -> Vec<bool> {
        self.elements[0].to.bound()
    }

    /// The batch and the index in it, for each element.
    pub(in crate::system) fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        self.elements.iter().map(|element| element.place)
    }

    /// Prepares a program for these elements, evaluated side by side.
    pub(in crate::system) fn lanes(&self, layout: &Layout, kernel: impl Into<Arc<Kernel>>) -> Lanes {
        let to: Vec<&Connections> = self.elements.iter().map(|element| &element.to).collect();
        lanes(layout, (self.formula.shape, &to), kernel.into())
    }
}

/// Prepares a program for formulas of one shape with these connections, evaluated side by side.
fn lanes(layout: &Layout, (shape, to): (Shape, &[&Connections]), kernel: Arc<Kernel>) -> Lanes {
    Lanes::new(kernel, to.len(), |e, which| layout.source(to[e], shape.place(which)))
}

/// A program for the elements or costs of one formula; each result is added to a destination of type `T`.
#[derive(Clone, Debug)]
pub(in crate::system) struct ElementPrograms<T> {
    numbers: Vec<usize>,
    lanes: Lanes,
    registers: Vec<f64>,
    /// The destinations, ordered by result and within a result by element.
    to: Vec<T>,
}

impl<T> ElementPrograms<T> {
    /// Creates the program unless it has no results; `to` returns the destination of a result of an element.
    pub(in crate::system) fn new<R: Copy>(
        layout: &Layout,
        alike: &Alike,
        program: Labelled<R>,
        to: impl Fn(&Element, R) -> T,
    ) -> Option<Self> {
        let (lanes, to) = (alike.lanes(layout, program.kernel), |e: usize, of| to(alike.elements[e], of));
        (!program.of.is_empty()).then(|| ElementPrograms::of(alike.numbers.clone(), lanes, &program.of, to))
    }

    /// Creates the program of like costs; `to` returns the destination of a result of one of them.
    pub(in crate::system) fn of_costs<R: Copy>(
        layout: &Layout,
        (shape, connections): (Shape, &[&Connections]),
        program: &Labelled<R>,
        to: impl Fn(&Connections, R) -> T,
    ) -> Self {
        let lanes = lanes(layout, (shape, connections), program.kernel.clone());
        ElementPrograms::of((0..connections.len()).collect(), lanes, &program.of, |e, of| to(connections[e], of))
    }

    fn of<R: Copy>(numbers: Vec<usize>, lanes: Lanes, results: &[R], to: impl Fn(usize, R) -> T) -> Self {
        let (count, to) = (numbers.len(), &to);
        let to = results.iter().flat_map(|&of| (0..count).map(move |e| to(e, of))).collect();
        ElementPrograms { registers: lanes.registers(), numbers, lanes, to }
    }

    /// The destination of result `k` of one of the elements.
    pub(in crate::system) fn target(&self, e: usize, k: usize) -> &T {
        &self.to[k * self.numbers.len() + e]
    }

    /// Runs the preludes with the parameters of every element.
    pub(in crate::system) fn fix(&mut self, parameters: impl Fn(usize) -> Vec<f64>) {
        self.lanes.fix(|e| parameters(self.numbers[e]), &mut self.registers);
    }

    /// Runs the program at a point and passes every result to `add`.
    pub(in crate::system) fn run(&mut self, point: &[f64], mut add: impl FnMut(&T, f64)) {
        let (count, to) = (self.numbers.len(), &self.to);
        self.lanes.run(point, &mut self.registers, |e, k, values| {
            to[k * count + e..].iter().zip(values).for_each(|(to, value)| add(to, *value));
        });
    }
}
