//! The pattern of the tangent matrix K, found once when a scene is compiled.
//!
//! Unknowns are numbered v (n), then σ (m). An entry is constant, or is written by an element at every iteration.

use std::collections::BTreeSet;
use std::ops::Range;

use super::assembly::{Assembly, Workspace};
use super::batch::Batch;
use super::block::BlockEntry;
use super::constants::Constants;
use super::difference::RelativeEntry;
use super::element::{Element, Formulas};
use super::groups::{self, Groups};
use super::jet::ElementKind;
use super::point::Layout;
use super::sinusoidal_constraints::{Places, Sines};
use super::view::NodeView;
use crate::System;
use crate::linear::{Pattern, Symbolic};

impl Formulas {
    /// Tells every varying element where its entries of K are stored.
    pub(super) fn new(elements: Vec<Element>, layout: Layout, symbolic: &Symbolic) -> Self {
        // Row and column of a varying entry vary, so neither is condensed.
        let assembly = Assembly::new(&elements, layout, &|row, col| symbolic.slot(row, col).unwrap_or_default());
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
    let mut values = Constants::new(n);
    constants(elements, at.design, &mut values);
    // What has no inertia of its own has no pivot ahead of what determines it.
    let mut inertia = vec![0.0; n];
    let diagonal = values.tangent().filter(|(row, col, power, _)| row == col && *power == 0 && *row < n);
    diagonal.for_each(|(i, _, _, value)| inertia[i] += value);
    let varying = elements.iter().filter(|e| e.kind() == ElementKind::Kinetic && !e.formula.varying.is_empty());
    varying.flat_map(|element| &element.q).for_each(|&i| inertia[i] = f64::INFINITY);
    inertia.iter().zip(&mut constant).for_each(|(inertia, constant)| *constant &= *inertia != 0.0);
    let Groups { groups, loop_equations } = groups::groups((elements, batches), (blocks, &inertia), (n, m), at);
    // Room for a compliance, should the loops depend on each other.
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

/// Structural nonzeros of K, and which unknowns have only constant entries in row and column, and equations that are linear in the state.
fn entries(elements: &[Element], (n, m): (usize, usize)) -> (Vec<(usize, usize)>, Vec<bool>) {
    let (mut entries, mut constant) = (Vec::new(), vec![true; n + m]);
    for element in elements {
        let mut add = |entry: &BlockEntry| {
            let [row, col] = element.unknowns(entry, n);
            entries.extend([(row, col), (col, row)]);
            [row, col]
        };
        element.formula.fixed.iter().for_each(|entry| _ = add(entry));
        for entry in element.formula.varying.iter().flat_map(RelativeEntry::parts) {
            add(&entry).into_iter().for_each(|unknown| constant[unknown] = false);
        }
        if element.formula.piecewise {
            element.q.iter().for_each(|&i| constant[i] = false);
            element.sigma.iter().for_each(|&j| constant[n + j] = false);
        }
    }
    (entries, constant)
}

impl System {
    /// All coordinates in a few lists, of which none holds two coordinates of one element of these kinds; of kinetic energies: M couples none of a list with
    /// another.
    pub(crate) fn uncoupled_coordinates(&self, kinds: &[ElementKind]) -> Vec<Vec<usize>> {
        let elements = self.formulas.elements.iter().filter(|element| kinds.contains(&element.kind()));
        let energies: Vec<&[usize]> = elements.map(|element| element.q.as_slice()).collect();
        let mut of_coordinate = vec![Vec::new(); self.n];
        for (e, q) in energies.iter().enumerate() {
            q.iter().for_each(|&i| of_coordinate[i].push(e));
        }
        let (mut list_of, mut lists) = (vec![usize::MAX; self.n], Vec::new());
        for i in 0..self.n {
            let coupled = of_coordinate[i].iter().flat_map(|&e| energies[e]);
            let used: BTreeSet<usize> = coupled.map(|&j| list_of[j]).collect();
            list_of[i] = (0..).find(|list| !used.contains(list)).unwrap_or_default();
            if list_of[i] == lists.len() {
                lists.push(Vec::new());
            }
            lists[list_of[i]].push(i);
        }
        lists
    }
}

#[cfg(test)]
mod tests {
    use super::ElementKind;
    use crate::scene::scenes::CartPendulum;

    #[test]
    fn coordinates_of_a_long_chain_are_uncoupled_in_few_lists() {
        for links in [1, 300] {
            let system = CartPendulum::with_links(links).scene().compile().expect("a scene");
            let lists = system.uncoupled_coordinates(&[ElementKind::Kinetic]);
            assert!(lists.len() <= 3, "{}", lists.len());
            let mut all = lists.concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..system.n()));
            for energy in system.formulas.elements.iter().filter(|element| element.kind() == ElementKind::Kinetic) {
                let shared = |list: &Vec<usize>| list.iter().filter(|i| energy.q.contains(i)).count();
                assert!(lists.iter().all(|list| shared(list) <= 1));
            }
        }
    }
}
