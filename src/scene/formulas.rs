//! Formulas that are graphs, for scene files.

use std::sync::Arc;

use super::Scene;
use super::ready::Added;
use crate::model::element::Sum;
use crate::model::{Multiplier, Output};
use crate::system::{Connections, EVENTS, ElementKind, GraphFormula, PlacedCost, PlacedElement};

/// What the function of a cost is added to.
#[derive(Clone, Copy)]
pub(crate) enum Summed {
    /// J.
    Cost(Sum),
    Term(Output, Sum),
    /// Its zero is an event.
    Event,
}

impl Scene {
    /// Adds an element, to the elements like the one at `like` if there is one.
    pub(crate) fn add_element(
        &mut self,
        name: &str,
        (kind, formula): (ElementKind, GraphFormula),
        to: Connections,
        like: Option<usize>,
    ) {
        self.elements.push(name.to_string());
        let item = PlacedElement { is_graph: true, ..PlacedElement::new(name, formula.element(kind), to) };
        let place = self.parts.batches.push_like(like, item);
        self.note(name, Added::Element(place));
    }

    /// Adds a cost, a term of an output, or an event.
    pub(crate) fn add_function(&mut self, name: &str, of: Summed, formula: GraphFormula, to: Connections) {
        let (output, sum) = match of {
            Summed::Cost(sum) => (0, sum),
            Summed::Term(output, sum) => (1 + output.index(), sum),
            Summed::Event => (EVENTS + self.parts.events.len(), Sum::AllNodes),
        };
        match of {
            Summed::Event => self.parts.events.push(name.to_string()),
            _ => self.costs_named.push(name.to_string()),
        }
        let place = self.parts.costs.push(PlacedCost::of_formula((name, output, sum), Arc::new(formula), to));
        self.note(name, Added::Function(place));
    }

    /// Adds the equations of a constraint and returns their numbers.
    pub(crate) fn add_equations(&mut self, name: &str, count: usize) -> Vec<usize> {
        self.equations(name, count).collect()
    }

    /// The element at a place that was noted.
    pub(crate) fn element(&self, place: (usize, usize)) -> &PlacedElement {
        self.parts.batches.item(place)
    }

    /// The batch of the element with this name.
    pub(crate) fn batch_of(&self, name: &str) -> Option<usize> {
        self.parts.batches.batch_of(name)
    }

    /// The cost, term or event that was noted with this number, and its use.
    pub(crate) fn function(&self, which: usize) -> (&PlacedCost, Summed) {
        let cost = self.parts.costs.item(which);
        let of = match cost.summed() {
            (0, sum) => Summed::Cost(sum),
            (event, _) if event >= EVENTS => Summed::Event,
            (output, sum) => Summed::Term(Output(self.parts.scene.handle(output - 1)), sum),
        };
        (cost, of)
    }

    pub(crate) fn output_name(&self, output: Output) -> &str {
        &self.parts.outputs[output.index()]
    }

    /// The constraint of an equation, its number of equations, and the number of the equation there.
    fn place_of(&self, equation: usize) -> Option<(&str, usize, usize)> {
        let mut first = 0;
        for (name, count) in &self.parts.constraints {
            if equation < first + count {
                return Some((name, *count, equation - first));
            }
            first += count;
        }
        None
    }

    /// The number of an element, counted in the order in which elements were added.
    pub(crate) fn number_of_element(&self, name: &str) -> usize {
        self.elements.iter().position(|known| known == name).unwrap_or(usize::MAX)
    }

    /// The name of an equation: that of its constraint, and its number there if it has several.
    pub(crate) fn multiplier_name(&self, equation: usize) -> String {
        match self.place_of(equation) {
            Some((name, 1, _)) => name.to_string(),
            Some((name, _, which)) => format!("{name}.{which}"),
            None => String::new(),
        }
    }

    /// The multiplier with a name as [`multiplier_name`](Self::multiplier_name) returns it.
    pub(crate) fn multiplier_named(&self, name: &str) -> Option<Multiplier> {
        if let Some([only]) = self.multipliers_named(name).as_deref() {
            return Some(*only);
        }
        let (constraint, which) = name.rsplit_once('.')?;
        let all = self.multipliers_named(constraint)?;
        (all.len() > 1).then(|| all.get(which.parse::<usize>().ok()?).copied())?
    }
}
