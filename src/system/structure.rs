//! The pattern of the tangent matrix K, found once when a scene is compiled.
//!
//! Unknowns are numbered v (n), then σ (m). An entry is constant, or is written by an element at every iteration.

use std::ops::Range;

use super::batch::AnyBatch;
use super::constants::Constants;
use super::groups::{self, Groups};
use super::jet::ElementKind;
use super::sines::{Places, Sines};
use super::view::NodeView;
use crate::linear::{Pattern, Symbolic};

type Batches = [Box<dyn AnyBatch>];

/// The constant derivatives of all elements for a start.
pub(super) fn constants(batches: &Batches, start: &NodeView<f64>, into: &mut Constants) {
    into.clear();
    batches.iter().for_each(|batch| batch.constants(start, into));
    into.compress();
}

/// What is known of K when a scene has been compiled.
pub(super) struct Analysis {
    pub(super) symbolic: Symbolic,
    pub(super) sines: Sines,
    /// The constraint equations that close loops: the only ones that can depend on others.
    pub(super) loop_equations: Vec<usize>,
}

/// Analyses K and tells every varying element where its entries are stored.
pub(super) fn analyse(
    batches: &mut Batches,
    blocks: &[Range<usize>],
    (n, m): (usize, usize),
    at: &NodeView<f64>,
) -> Analysis {
    let (mut entries, mut constant) = entries(batches, (n, m), at);
    let Groups { groups, loop_equations } = groups::groups(batches, blocks, (n, m), at);
    // Room for a compliance, should the loops depend on each other.
    for &j in &loop_equations {
        entries.push((n + j, n + j));
        constant[n + j] = false;
    }
    let symbolic = Symbolic::analyse(&Pattern { size: n + m, entries, constant, groups });
    // Row and column of a varying entry vary, so neither is condensed.
    let slot = |row, col| symbolic.slot(row, col).unwrap_or_default();
    batches.iter_mut().for_each(|batch| batch.place(&slot, n));
    let mut values = Constants::new(n);
    constants(batches, at, &mut values);
    let position = |unknown| symbolic.position(unknown);
    let sines = Sines::new(values.waves, &Places { n, position, slot });
    Analysis { symbolic, sines, loop_equations }
}

/// Structural nonzeros of K, and which unknowns have only constant entries in row and column.
fn entries(batches: &Batches, (n, m): (usize, usize), at: &NodeView<f64>) -> (Vec<(usize, usize)>, Vec<bool>) {
    let mut entries = Vec::new();
    batches.iter().for_each(|batch| batch.constant_entries(at, n, &mut entries));
    let mut constant = vec![true; n + m];
    for footprint in batches.iter().flat_map(|batch| batch.footprints()) {
        for &row in &footprint.active {
            constant[row] = false;
            let mixed = footprint.active.iter().filter(|&&col| col == row || !footprint.separable);
            entries.extend(mixed.map(|&col| (row, col)));
            if footprint.form == ElementKind::Holonomic {
                entries.extend(footprint.sigma.iter().map(|j| (n + j, row)));
                footprint.sigma.iter().for_each(|j| constant[n + j] = false);
            }
        }
    }
    (entries, constant)
}
