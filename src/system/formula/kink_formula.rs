//! [`KinkFormula`]: programs for the functions whose zeros are the kinks of a formula.

use super::kind::ElementKind;
use super::labelled::{Labelled, gradient};
use super::shape::{Shape, Slot, bound_constants};
use crate::program::Template;

/// The kinks of a formula, numbered consecutively.
#[derive(Clone, Debug)]
pub struct KinkFormula {
    /// For each kink, whether it is rounded over the unit length of its function.
    pub is_smooth: Vec<bool>,
    /// The functions, labelled with their numbers.
    pub values: Labelled<usize>,
    /// Their derivatives with respect to the arguments of the formula.
    pub slopes: Labelled<(usize, Slot)>,
}

impl KinkFormula {
    /// `None` if there are no kinks, or if the programs are too long; `bound` marks the constants that are design variables.
    pub fn new(kind: ElementKind, template: &Template, shape: Shape, bound: &[bool]) -> Option<Self> {
        let (mut graph, results) = template.graph();
        // Second derivatives of forces, third derivatives of energies and constraints.
        let kinks = graph.kinks(&results, if kind == ElementKind::Applied { 2 } else { 3 });
        if kinks.is_empty() {
            return None;
        }
        let variables: Vec<Slot> = shape.of_element().chain(bound_constants(bound)).collect();
        let one = graph.constant(1.0);
        let mut slopes = Vec::new();
        for (k, kink) in kinks.iter().enumerate() {
            let of_kink = gradient(&mut graph, shape, &[(kink.node, one)], &variables);
            slopes.extend(of_kink.into_iter().map(|(slot, slope)| ((k, slot), slope)));
        }
        let is_smooth = kinks.iter().map(|kink| kink.is_smooth).collect();
        let values = kinks.iter().enumerate().map(|(k, kink)| (k, kink.node));
        let values = Labelled::new(&mut graph, template.parameters, values)?;
        Some(KinkFormula { is_smooth, values, slopes: Labelled::new(&mut graph, template.parameters, slopes)? })
    }
}
