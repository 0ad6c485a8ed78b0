//! [`Recordings`]: the elements of a scene as they are recorded.

use std::collections::HashMap;
use std::sync::Arc;

use super::differentiated::Formula;
use super::element::Element;
use super::kind::ElementKind;
use super::placed_element::PlacedElement;
use super::shape::Shape;
use super::view::NodeView;
use crate::number::guarded;
use crate::program::{Obstacle, Template};

/// Key of a formula: the kind of element, its shape, which constants are bound, and the recorded template.
type Key = (ElementKind, Shape, Vec<bool>, Template);

/// The elements of a scene while they are recorded; each formula is differentiated once.
#[derive(Default)]
pub struct Recordings {
    pub elements: Vec<Element>,
    /// The number of the batch that is being recorded.
    pub batch: usize,
    /// Whether num-dual evaluates all elements.
    without_programs: bool,
    known: HashMap<Key, Arc<Formula>>,
}

impl Recordings {
    pub fn new(without_programs: bool) -> Self {
        Recordings { without_programs, ..Recordings::default() }
    }

    /// Records an element.
    pub fn add(&mut self, item: &PlacedElement, place: (usize, usize), at: &NodeView<f64>) -> Arc<Formula> {
        let (kind, shape) = (item.formula.kind(), item.shape);
        let (formula, numbers) = self.formula((kind, shape), item.to.bound(), || item.record(at));
        let element = item.element(place, formula.clone(), numbers);
        debug_assert!(
            Arc::strong_count(&formula) > 3 || guarded(|| item.agrees(&element, at)) != Some(false),
            "the program of `{}` does not agree with num-dual",
            item.name
        );
        self.elements.push(element);
        formula
    }

    /// The compiled formula of a recording, and the numbers in it.
    pub fn formula(
        &mut self,
        (kind, shape): (ElementKind, Shape),
        bound: Vec<bool>,
        record: impl FnOnce() -> Result<(Template, Vec<f64>), Obstacle>,
    ) -> (Arc<Formula>, Vec<f64>) {
        match record() {
            Ok((template, numbers)) if !self.without_programs => {
                let formula = self.known.entry((kind, shape, bound, template));
                let formula = formula.or_insert_with_key(|(_, _, bound, template)| {
                    Arc::new(Formula::new(kind, shape, template.clone(), bound))
                });
                (formula.clone(), numbers)
            }
            other => (Arc::new(Formula::unknown(kind, shape, other.err())), Vec::new()),
        }
    }
}
