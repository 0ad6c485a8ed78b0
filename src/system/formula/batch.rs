//! [`Batch`]: all elements of one type in one list.

use std::any::TypeId;

#[cfg(feature = "files")]
use super::graph_formula::GraphFormula;
use super::kind::ElementKind;
use super::placed_element::PlacedElement;
use super::recordings::Recordings;
use super::view::NodeView;
use crate::model::Param;

/// All elements of one type.
#[derive(Clone)]
pub struct Batch {
    /// The type, and the coordinates that are present if some are missing.
    pub of: (TypeId, &'static [usize]),
    pub items: Vec<PlacedElement>,
}

impl Batch {
    /// The kind of the elements in this batch.
    pub fn kind(&self) -> Option<ElementKind> {
        self.items.first().map(|item| item.formula.kind())
    }

    /// Replaces the parameters of all elements by means of `resolve`.
    pub fn resolve(&mut self, resolve: &mut dyn FnMut(Param) -> Param) {
        self.items.iter_mut().flat_map(|item| &mut item.to.b).for_each(|b| *b = resolve(*b));
    }

    /// Records the formulas of all elements; `at` provides the values for formulas that branch on them.
    pub fn prepare(&mut self, at: &NodeView<f64>, into: &mut Recordings) {
        for (place, item) in self.items.iter_mut().enumerate() {
            let formula = into.add(item, (into.batch, place), at);
            item.depends = formula.kernels.as_ref().map(|kernels| item.depends(&kernels.template));
        }
        into.batch += 1;
    }
}

/// All elements of a scene.
#[derive(Clone, Default)]
pub struct Batches(pub Vec<Batch>);

impl Batches {
    /// Adds an element to the batch of its type and coordinates, and returns its batch and its place there.
    pub fn push(&mut self, of: (TypeId, &'static [usize]), item: PlacedElement) -> (usize, usize) {
        self.push_to(self.0.iter().position(|batch| batch.of == of), of, item)
    }

    /// Adds an element to a batch, or to a new one.
    fn push_to(&mut self, batch: Option<usize>, of: (TypeId, &'static [usize]), item: PlacedElement) -> (usize, usize) {
        let batch = batch.unwrap_or_else(|| {
            self.0.push(Batch { of, items: Vec::new() });
            self.0.len() - 1
        });
        let items = &mut self.0[batch].items;
        items.push(item);
        (batch, items.len() - 1)
    }

    /// Adds the formula of a file to a batch, or to one of its own.
    #[cfg(feature = "files")]
    pub fn push_like(&mut self, batch: Option<usize>, item: PlacedElement) -> (usize, usize) {
        self.push_to(batch, (TypeId::of::<GraphFormula>(), &[]), item)
    }

    /// The batch of the element with this name.
    #[cfg(feature = "files")]
    pub fn batch_of(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|batch| batch.items.iter().any(|item| item.name == name))
    }

    /// An element, given its batch and its index in the batch.
    pub fn item(&self, (batch, item): (usize, usize)) -> &PlacedElement {
        &self.0[batch].items[item]
    }

    /// The elements of one kind.
    pub fn of_kind(&self, kind: ElementKind) -> impl Iterator<Item = &Batch> {
        self.0.iter().filter(move |batch| batch.kind() == Some(kind))
    }

    /// All elements, batch by batch.
    pub fn items(&self) -> impl Iterator<Item = &PlacedElement> {
        self.0.iter().flat_map(|batch| &batch.items)
    }
}
