//! The pattern of the tangent matrix K, found once when a scene is compiled.
//!
//! Unknowns are numbered v (n), then σ (m). An entry is constant, or is written by an element at every iteration.

use std::ops::Range;

use super::assembly::{Assembly, Workspace};
use super::batch::Batch;
use super::constants::Constants;
use super::element::{Element, Formulas};
use super::groups::{self, Groups};
use super::point::Layout;
use super::sines::{Places, Sines};
use super::view::NodeView;
use crate::linear::{Pattern, Symbolic};

impl Formulas {
    /// Tells every varying element where its entries of K are stored.
    pub(super) fn new(elements: Vec<Element>, layout: Layout, symbolic: &Symbolic) -> Self {
        let mut assembly = Assembly::new(&elements, layout);
        // Row and column of a varying entry vary, so neither is condensed.
        assembly.place(&|row, col| symbolic.slot(row, col).unwrap_or_default());
        Formulas { elements, assembly }
    }

    /// The constant derivatives for the design variables of a start, and what programs compute once.
    pub(crate) fn set_design(&self, design: &[f64], into: &mut Constants, workspace: &mut Workspace) {
        constants(&self.elements, design, into);
        self.assembly.fix(|e| self.elements[e].parameters(design), workspace);
    }
}

fn constants(elements: &[Element], design: &[f64], into: &mut Constants) {
    into.clear();
    elements.iter().for_each(|element| element.add_constants(&element.parameters(design), into));
    into.compress();
}

/// What is known of K when a scene has been compiled.
pub(super) struct Analysis {
    pub(super) symbolic: Symbolic,
    pub(super) sines: Sines,
    /// The constraint equations that close loops: the only ones that can depend on others.
    pub(super) loop_equations: Vec<usize>,
}

/// Analyses K.
pub(super) fn analyse(
    (elements, batches): (&[Element], &[Batch]),
    blocks: &[Range<usize>],
    (n, m): (usize, usize),
    at: &NodeView<f64>,
) -> Analysis {
    let (mut entries, mut constant) = entries(elements, (n, m));
    let Groups { groups, loop_equations } = groups::groups((elements, batches), blocks, (n, m), at);
    // Room for a compliance, should the loops depend on each other.
    for &j in &loop_equations {
        entries.push((n + j, n + j));
        constant[n + j] = false;
    }
    let symbolic = Symbolic::analyse(&Pattern { size: n + m, entries, constant, groups });
    let slot = |row, col| symbolic.slot(row, col).unwrap_or_default();
    let mut values = Constants::new(n);
    constants(elements, at.design, &mut values);
    let position = |unknown| symbolic.position(unknown);
    let sines = Sines::new(values.waves, &Places { n, position, slot });
    Analysis { symbolic, sines, loop_equations }
}

/// Structural nonzeros of K, and which unknowns have only constant entries in row and column.
fn entries(elements: &[Element], (n, m): (usize, usize)) -> (Vec<(usize, usize)>, Vec<bool>) {
    let (mut entries, mut constant) = (Vec::new(), vec![true; n + m]);
    for element in elements {
        for entry in element.formula.fixed.iter().chain(&element.formula.varying) {
            let [row, col] = element.unknowns(entry, n);
            entries.extend([(row, col), (col, row)]);
        }
        for entry in &element.formula.varying {
            element.unknowns(entry, n).iter().for_each(|&unknown| constant[unknown] = false);
        }
    }
    (entries, constant)
}
