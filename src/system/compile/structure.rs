//! The sparsity pattern of the tangent matrix K, analysed once when a scene is compiled.
//!
//! Unknowns are numbered v (n), then σ (m). An entry is either constant or computed by an element at every iteration.

use std::ops::Range;
use std::sync::OnceLock;

use super::groups::{self, Groups};
use super::postponed;
use crate::linear::{Pattern, Symbolic};
use crate::number::guarded;
use crate::system::formula::{Batches, Block, BlockEntry, Element, ElementKind, Entry, Layout, NodeView, RelativeEntry};
use crate::system::rounding_rows::clear_rounding_rows;
use crate::system::tangent::{Assembly, Constants, Formulas, Places, Sines, Workspace};

impl Formulas {
    /// Assigns storage for the entries of K to every varying element.
    pub(in crate::system) fn new(elements: Vec<Element>, layout: Layout, symbolic: &Symbolic) -> Self {
        // Row and column of a varying entry are varying unknowns, so neither is condensed.
        let assembly = Assembly::new(&elements, layout, &|row, col| symbolic.slot(row, col).unwrap_or_default());
        Formulas { elements, assembly, second_order: OnceLock::new() }
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
    /// True if Φ_q has a zero row of a loop at both points.
    pub(in crate::system) has_still_loops: bool,
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
    let moved: Vec<f64> = (1..).zip(at.q).map(|(i, q)| q + 0.3 + 0.4 * f64::from(i).sin()).collect();
    let points = [*at, NodeView { q: &moved, ..*at }];
    let phi_q = points.map(|at| phi_q(elements, batches, (n, m), &at));
    let mut inertia = vec![0.0; n];
    mass(elements, batches, at).iter().filter(|e| e.row == e.col).for_each(|e| inertia[e.row] += e.value);
    // A coordinate without inertia has no pivot before other unknowns are eliminated, so it is not condensed. Its diagonal entry says that it is no
    // multiplier.
    for i in (0..n).filter(|i| inertia[*i] == 0.0) {
        entries.push((i, i));
        constant[i] = false;
    }
    let Groups { groups, loop_equations } = groups::groups(elements, (blocks, &inertia, may_open), (n, &phi_q));
    // Diagonal entries for compliances, in case the loop equations are dependent or open.
    for &j in &loop_equations {
        entries.push((n + j, n + j));
        constant[n + j] = false;
    }
    let masses = if inertia.contains(&0.0) { points.map(|at| mass(elements, batches, &at)).to_vec() } else { Vec::new() };
    let matrices = masses.iter().zip(&phi_q).flat_map(|(mass, phi_q)| tangents(n, mass, phi_q, may_open));
    let mut pattern = Pattern { size: n + m, coordinates: n, entries, constant, groups };
    let symbolic = postponed::analyse(&mut pattern, &Vec::from_iter(matrices));
    let slot = |row, col| symbolic.slot(row, col).unwrap_or_default();
    let position = |unknown| symbolic.position(unknown);
    let sines = Sines::new(values.waves, &Places { n, position, slot });
    let is_still = |j: &usize| phi_q.iter().all(|phi_q| phi_q[*j].iter().all(|e| e.value == 0.0));
    let has_still_loops = loop_equations.iter().any(is_still);
    Analysis { symbolic, sines, loop_equations, has_still_loops }
}

/// The entries of M; NaN for elements that are not defined. As those of Φ_q, they are computed by the programs, so that scenes with equal programs
/// have equal patterns.
fn mass(elements: &[Element], batches: &Batches, at: &NodeView<f64>) -> Vec<Entry> {
    let mut entries = Vec::new();
    for element in elements.iter().filter(|element| element.kind() == ElementKind::Kinetic) {
        if let Some(mass) = element.block(Block::Vv, at) {
            entries.extend(mass);
        } else if guarded(|| batches.item(element.place).mass(at, &mut entries)).is_none() {
            entries.extend(element.to.q.iter().map(|&i| Entry { row: i, col: i, value: f64::NAN }));
        }
    }
    entries
}

/// Φ_q by rows; those that vanish up to rounding are zero.
fn phi_q(elements: &[Element], batches: &Batches, (n, m): (usize, usize), at: &NodeView<f64>) -> Vec<Vec<Entry>> {
    let mut entries = Vec::new();
    for element in elements.iter().filter(|element| element.kind() == ElementKind::Holonomic) {
        match element.block(Block::PhiQ, at) {
            Some(phi_q) => entries.extend(phi_q),
            // Missing rows are not owned by any body.
            None => _ = guarded(|| batches.item(element.place).phi_q(at, &mut entries)),
        }
    }
    clear_rounding_rows(&mut entries, (n, m));
    let mut rows = vec![Vec::new(); m];
    entries.into_iter().for_each(|e: Entry| rows[e.row].push(e));
    rows
}

/// K(0) with all constraints, and without all or all but one of those that may open.
fn tangents(n: usize, mass: &[Entry], phi_q: &[Vec<Entry>], may_open: &[usize]) -> Vec<Vec<Entry>> {
    let with = |is_closed: &dyn Fn(usize) -> bool| {
        let rows = phi_q.iter().flatten().filter(|e| is_closed(e.row) || !may_open.contains(&e.row));
        mass.iter().filter(|e| e.row >= e.col).copied().chain(rows.map(|e| Entry { row: n + e.row, ..*e })).collect()
    };
    let mut tangents = vec![with(&|_| true)];
    if !may_open.is_empty() {
        tangents.push(with(&|_| false));
        tangents.extend(may_open.iter().map(|&closed| with(&|row| row == closed)));
    }
    tangents
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
