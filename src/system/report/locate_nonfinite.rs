//! Identification of the formula that is not finite, and of the arguments that cause it.

use crate::error::quoted;
use crate::program::Obstacle;
use crate::system::cost::{Along, CostRows, Suspect, Weights};
use crate::system::formula::{Argument, Covector, NodeView, PlacedElement};
use crate::{Error, System};
use num_dual::Dual64;

/// The largest number of arguments that are listed.
const MOST: usize = 4;

/// Formats a number with six significant digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

impl System {
    /// The error for a suspect; values that `at` does not contain are omitted.
    fn blame(&self, Suspect { element, arguments }: Suspect, at: &NodeView<f64>, node: usize) -> Error {
        Error::Model { element: quoted(element), arguments: self.list(&arguments, at), node, time: at.t }
    }

    fn list(&self, arguments: &[Argument], at: &NodeView<f64>) -> String {
        let more = (arguments.len() > MOST).then(|| "…".to_string());
        let named = arguments.iter().take(MOST).map(|argument| self.describe(*argument, at));
        named.chain(more).collect::<Vec<String>>().join(", ")
    }

    /// The name of an argument.
    pub(in crate::system) fn argument_name(&self, argument: Argument) -> String {
        let nowhere = NodeView::of_equations([&[], &[], &[]], (&[], f64::NAN, &[]));
        if argument == Argument::T { "t".into() } else { self.describe(argument, &nowhere) }
    }

    fn describe(&self, argument: Argument, at: &NodeView<f64>) -> String {
        let names = &self.0.names;
        let what = match argument {
            Argument::Q(i) => quoted(&names.coordinates[i]),
            Argument::V(i) => format!("the velocity of {}", quoted(&names.coordinates[i])),
            Argument::PStar(i) => format!("p* of {}", quoted(&names.coordinates[i])),
            Argument::PStarDot(i) => format!("dp*/dt of {}", quoted(&names.coordinates[i])),
            Argument::VDot(i) => format!("the acceleration of {}", quoted(&names.coordinates[i])),
            Argument::Lambda(j) => format!("λ of {}", names.equations[j]),
            Argument::Sigma(j) => format!("σ of {}", names.equations[j]),
            Argument::U(k) => quoted(&names.controls[k]),
            Argument::UDot(k) => format!("du/dt of {}", quoted(&names.controls[k])),
            Argument::B(p) => self.0.parameters.name(p, &names.designs),
            Argument::T => "t".into(),
        };
        let (list, i) = argument.place();
        at.list(list).get(i).map_or(what.clone(), |value| format!("{what} = {}", number(*value)))
    }

    /// The first cost whose value or derivatives are not finite at a node, as an error; `rows` is overwritten.
    pub(crate) fn find_bad_cost(
        &self,
        at: &NodeView<f64>,
        weights: &Weights<f64>,
        rows: &mut CostRows,
        node: usize,
    ) -> Option<Error> {
        Some(self.blame(self.0.costs.find_not_finite((at, None), weights, rows)?, at, node))
    }

    /// The first cost that is not finite; if there is none, the element or input that causes it. `rows` is overwritten.
    pub(crate) fn bad_cost(&self, at: &NodeView<f64>, weights: &Weights<f64>, rows: &mut CostRows, node: usize) -> Error {
        self.find_bad_cost(at, weights, rows, node).unwrap_or_else(|| self.bad_part_of_cost(at, node))
    }

    /// The element or input that causes a cost not to be finite, if the cost alone does not.
    pub(crate) fn bad_part_of_cost(&self, at: &NodeView<f64>, node: usize) -> Error {
        // Accelerations depend on the derivatives of forces.
        let of_element = self.find_not_finite(at, node).or_else(|| self.find_bad_input(at, node));
        of_element.unwrap_or_else(|| self.blame(Suspect { element: "the cost", arguments: Vec::new() }, at, node))
    }

    /// The first cost whose derivatives along a direction are not finite at a node, as an error; `rows` is overwritten.
    pub(crate) fn bad_cost_along(&self, of: Along, weights: &Weights<Dual64>, rows: &mut CostRows, node: usize) -> Error {
        self.second_derivative(self.0.costs.find_not_finite(of, weights, rows), of.0, node)
    }

    /// The first element whose second derivatives along a direction are not finite at a node, as an error; `rows` is overwritten.
    pub(crate) fn bad_element_along(
        &self,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        with: &Covector,
        rows: &mut CostRows,
        node: usize,
    ) -> Error {
        let found = self.placed().find(|item| {
            rows.clear();
            item.pull_back_along((at, along), with, rows);
            !rows.is_finite()
        });
        let suspect = found.map(|item| Suspect { element: &item.name, arguments: rows.bad_arguments() });
        self.second_derivative(suspect, at, node)
    }

    fn second_derivative(&self, suspect: Option<Suspect>, at: &NodeView<f64>, node: usize) -> Error {
        let what = || format!("a second derivative at node {node}");
        suspect.map_or_else(|| Error::Overflow { what: what(), value: f64::NAN }, |suspect| self.blame(suspect, at, node))
    }

    /// The first element whose derivative with respect to an input is not finite at a node, as an error.
    pub(crate) fn find_bad_input(&self, at: &NodeView<f64>, node: usize) -> Option<Error> {
        let of = |item: &PlacedElement| Some(vec![item.find_bad_input(at)?]);
        self.blame_element(of, &at.without_momenta(), node)
    }

    /// The first energy that is not finite at a node although its derivatives are (ln q for q < 0), as an error.
    pub(crate) fn find_undefined_energy(&self, at: &NodeView<f64>, node: usize) -> Option<Error> {
        let mut items = self.0.partly_defined.iter().map(|&place| self.item(place));
        let undefined = items.find(|item| !item.energy(at).is_finite())?;
        let suspect = Suspect { element: &undefined.name, arguments: undefined.arguments(at) };
        Some(self.blame(suspect, at, node))
    }

    /// Returns an error if a formula panics at a start. Only those that panicked when the scene was compiled are evaluated.
    pub(crate) fn check_panics(&self, start: &NodeView<f64>) -> Result<(), Error> {
        let panicked = |obstacle| obstacle == Some(Obstacle::Panics);
        let elements = self.0.formulas.elements.iter().filter(|element| panicked(element.formula.obstacle));
        let elements = elements.map(|element| self.item(element.place)).filter(|item| item.panics(start));
        let costs = self.0.costs.items().iter().filter(|cost| panicked(cost.obstacle) && cost.of.panics(start));
        let mut names = elements.map(|item| &item.name).chain(costs.map(|cost| &cost.of.name));
        let error = |element: &String| Error::Panics { element: element.clone(), time: start.t };
        names.next().map_or(Ok(()), |element| Err(error(element)))
    }

    /// The first element whose contributions are not finite at a node, as an error.
    pub(crate) fn find_not_finite(&self, at: &NodeView<f64>, node: usize) -> Option<Error> {
        self.blame_element(|item| item.find_not_finite(at), &at.without_momenta(), node)
    }

    /// The error for a constraint equation that is not finite at node 0.
    pub(crate) fn constraint_not_finite(&self, at: &NodeView<f64>, equation: usize) -> Error {
        // Found by its equation, since a constraint may have several.
        let item = self.placed().find(|item| item.to.sigma.contains(&equation));
        let arguments = item.and_then(|item| item.find_undefined_phi(at).or_else(|| item.find_not_finite(at)));
        let arguments = self.list(&arguments.unwrap_or_default(), at);
        Error::Model { element: self.equation_name(equation).into(), arguments, node: 0, time: at.t }
    }

    /// The first element for which `find` returns arguments, as an error.
    fn blame_element(
        &self,
        find: impl Fn(&PlacedElement) -> Option<Vec<Argument>>,
        at: &NodeView<f64>,
        node: usize,
    ) -> Option<Error> {
        let found = self.placed().find_map(|item| Some(Suspect { element: &item.name, arguments: find(item)? }));
        Some(self.blame(found?, at, node))
    }
}
