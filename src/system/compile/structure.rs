//! The sparsity pattern of the tangent matrix K, analysed once when a scene is compiled.
//!
//! Unknowns are numbered v (n), then σ (m). An entry is either constant or computed by an element at every iteration.

use std::ops::Range;

use super::groups::{self, Groups};
use crate::linear::{Pattern, Symbolic};
use crate::number::guarded;
use crate::system::formula::{Batches, BlockEntry, Element, ElementKind, Layout, NodeView, RelativeEntry};
use crate::system::tangent::{Assembly, Constants, Formulas, Places, Sines, Workspace};

impl Formulas {
    /// Assigns storage for the entries of K to every varying element.
    pub(in crate::system) fn new(elements: Vec<Element>, layout: Layout, symbolic: &Symbolic) -> Self {
        // Row and column of a varying entry are varying unknowns, so neither is condensed.
        let assembly = Assembly::new(&elements, layout, &|row, col| symbolic.slot(row, col).unwrap_or_default());
        Formulas { elements, assembly }
    }

    /// Computes the constant derivatives for the design variables of an initial state, and runs all preludes.
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

/// Result of the analysis of K.
pub(in crate::system) struct Analysis {
    pub(in crate::system) symbolic: Symbolic,
    pub(in crate::system) sines: Sines,
    /// The constraint equations that close loops; only these can depend on other equations, or open.
    pub(in crate::system) loop_equations: Vec<usize>,
}

/// Analyses K at the initial position of a scene.
pub(in crate::system) fn analyse(
    (elements, batches): (&[Element], &Batches),
    (blocks, may_open): (&[Range<usize>], &[usize]),
    (n, m): (usize, usize),
    at: &NodeView<f64>,
) -> Analysis {
    let (mut entries, mut constant) = entries(elements, (n, m));
    let mut values = Constants::new(n);
    constants(elements, at.design, &mut values);
    // A coordinate without inertia of its own has no pivot before other unknowns are eliminated, so it is not condensed.
    let mut inertia = vec![0.0; n];
    let diagonal = values.tangent().filter(|(row, col, power, _)| row == col && *power == 0 && *row < n);
    diagonal.for_each(|(i, _, _, value)| inertia[i] += value);
    let varying = elements.iter().filter(|e| e.kind() == ElementKind::Kinetic && !e.formula.varying.is_empty());
    // 2 T at the velocity 1 of one coordinate.
    let mut v = vec![0.0; n];
    for (element, &i) in varying.flat_map(|element| element.to.q.iter().map(move |i| (element, i))) {
        v[i] = 1.0;
        let item = batches.item(element.place);
        inertia[i] += guarded(|| item.energy(&NodeView { v: &v, ..*at })).map_or(f64::INFINITY, f64::abs);
        v[i] = 0.0;
    }
    inertia.iter().zip(&mut constant).for_each(|(inertia, constant)| *constant &= *inertia != 0.0);
    let Groups { groups, loop_equations } = groups::groups((elements, batches), (blocks, &inertia, may_open), (n, m), at);
    // Diagonal entries for compliances, in case the loop equations are dependent or open.
    for &j in &loop_equations {
        entries.push((n + j, n + j));
        constant[n + j] = false;
    }
    let symbolic = Symbolic::analyse(&Pattern { size: n + m, entries, constant, groups });
    let slot = |row, col| symbolic.slot(row, col).unwrap_or_default();
    let position = |unknown| symbolic.position(unknown);
    let sines = Sines::new(values.waves, &Places { n, position, slot });
    Analysis { symbolic, sines, loop_equations }
}

/// Structural nonzeros of K, and for each unknown whether its row and column are constant and its equations are linear in the state.
fn entries(elements: &[Element], (n, m): (usize, usize)) -> (Vec<(usize, usize)>, Vec<bool>) {
    let (mut entries, mut constant) = (Vec::new(), vec![true; n + m]);
    for element in elements {
        let mut add = |entry: &BlockEntry| {
            let [row, col] = element.unknowns(entry, n);
            entries.extend([(row, col), (col, row)]);
            [row, col]
        };
        element.formula.fixed.iter().for_each(|entry| _ = add(entry));
        let varying = element.formula.varying.iter().filter(|relative| relative.entry.block.is_in_tangent());
        for entry in varying.flat_map(RelativeEntry::parts) {
            add(&entry).into_iter().for_each(|unknown| constant[unknown] = false);
        }
        if element.formula.piecewise {
            element.to.q.iter().for_each(|&i| constant[i] = false);
            element.to.sigma.iter().for_each(|&j| constant[n + j] = false);
        }
    }
    (entries, constant)
}
