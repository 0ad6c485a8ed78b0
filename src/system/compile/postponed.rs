//! Groups that must be eliminated later than their order says, because constraints of later groups determine their coordinates.
//!
//! A coordinate without inertia has no pivot before these constraints. With the block D of a group when its turn comes, and its couplings C to
//! later groups, the elimination of K(0) = [M Φ_qᵀ; Φ_q 0] shows
//!
//! ```text
//!   D w = 0, C w ≠ 0     the group and the later ones of C w are joined
//!   D w = 0, C w = 0     no order helps: constraints depend on each other, or nothing determines a coordinate; S = −C D⁺ Cᵀ is added as usual
//! ```

use nalgebra::DMatrix;
use std::collections::{BTreeMap, BTreeSet};

use crate::linear::{Pattern, Symbolic, eigen};
use crate::system::formula::Entry;

/// Eigenvalues, and products with null vectors, below this fraction of their terms are rounding.
const ROUNDING: f64 = 1e-8;

/// Analyses a pattern after joining its groups until all of these matrices K(0), given by their entries on and below the diagonal, can be
/// eliminated in order.
pub(super) fn analyse(pattern: &mut Pattern, matrices: &[Vec<Entry>]) -> Symbolic {
    loop {
        let (symbolic, group_of) = (Symbolic::analyse(pattern), pattern.group_of());
        let is_new = |[own, later]: &[usize; 2]| own != later || !pattern.groups[group_of[*own]].chooses_pivots;
        let found = matrices.iter().map(|entries| Elimination::new(&symbolic, entries).run());
        let Some(joins) = found.into_iter().find(|joins| joins.iter().any(is_new)) else { return symbolic };
        for [own, later] in joins {
            if symbolic.position(own) < symbolic.condensed() {
                pattern.constant[own] = false;
            } else {
                pattern.join(group_of[own], group_of[later]);
            }
        }
    }
}

/// An entry of K, and the sum of the magnitudes that were added up in it.
#[derive(Clone, Copy, Default)]
struct Term {
    sum: f64,
    magnitude: f64,
}

impl Term {
    fn add(&mut self, x: f64) {
        self.sum += x;
        self.magnitude += x.abs();
    }

    /// The sum; zero if it is rounding.
    fn value(&self) -> f64 {
        if self.sum.abs() <= ROUNDING * self.magnitude { 0.0 } else { self.sum }
    }
}

/// The elimination of K, group by group.
struct Elimination {
    rows: Vec<BTreeMap<usize, Term>>,
    /// The unknowns that are eliminated at each turn, and the turn of each unknown.
    unknowns: Vec<Vec<usize>>,
    turn_of: Vec<usize>,
}

impl Elimination {
    fn new(symbolic: &Symbolic, entries: &[Entry]) -> Self {
        let sizes = std::iter::repeat_n(1, symbolic.condensed()).chain(symbolic.nodes().map(|(size, _)| size));
        let mut turns = sizes.enumerate().flat_map(|(turn, size)| std::iter::repeat_n(turn, size));
        let size = symbolic.size();
        let mut elimination =
            Elimination { rows: vec![BTreeMap::new(); size], unknowns: vec![Vec::new(); size], turn_of: vec![0; size] };
        for position in 0..size {
            let (unknown, turn) = (symbolic.unknown(position), turns.next().unwrap_or_default());
            elimination.turn_of[unknown] = turn;
            elimination.unknowns[turn].push(unknown);
        }
        for &Entry { row, col, value } in entries {
            elimination.add(row, col, value);
            if row != col {
                elimination.add(col, row, value);
            }
        }
        elimination
    }

    fn add(&mut self, row: usize, col: usize, x: f64) {
        self.rows[row].entry(col).or_default().add(x);
    }

    /// Eliminates all groups. Returns pairs of unknowns whose groups must be joined; a group that must choose its pivots is paired with itself.
    fn run(mut self) -> Vec<[usize; 2]> {
        let mut joins = Vec::new();
        for turn in 0..self.unknowns.len() {
            let own = std::mem::take(&mut self.unknowns[turn]);
            let is_later = |other: &usize| self.turn_of[*other] > turn;
            let later: BTreeSet<usize> = own.iter().flat_map(|u| self.rows[*u].keys().copied().filter(is_later)).collect();
            let later = Vec::from_iter(later);
            let [mut d, mut c] = [&own, &later].map(|rows| self.block(rows, &own));
            scale(&mut d, &mut c);
            if has_hidden_pivot(d.clone()) {
                joins.push([own[0]; 2]);
            }
            let Some(found) = eigen(d) else { continue };
            let (values, along, terms) = (found.eigenvalues, &c * &found.eigenvectors, c.abs() * found.eigenvectors.abs());
            let (null, regular): (Vec<usize>, Vec<usize>) =
                (0..own.len()).partition(|k| values[*k].abs() <= ROUNDING * values.amax());
            let is_needed = |i: &usize| null.iter().any(|&k| along[(*i, k)].abs() > ROUNDING * terms[(*i, k)]);
            let needed = BTreeSet::from_iter((0..later.len()).filter(is_needed).map(|i| self.turn_of[later[i]]));
            if let Some(&last) = needed.last() {
                self.unknowns[turn] = own;
                joins.extend(needed.into_iter().rev().skip(1).chain([turn]).map(|turn| self.postpone(turn, last)));
                continue;
            }
            for ((i, &row), (j, &col)) in
                later.iter().enumerate().flat_map(|i| later.iter().enumerate().map(move |j| (i, j)))
            {
                regular.iter().for_each(|&k| self.add(row, col, -along[(i, k)] * along[(j, k)] / values[k]));
            }
        }
        joins
    }

    fn block(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        let value = |i: usize, j: usize| self.rows[rows[i]].get(&columns[j]).map_or(0.0, Term::value);
        DMatrix::from_fn(rows.len(), columns.len(), value)
    }

    /// Moves the unknowns of one turn to a later one, and returns one of either.
    fn postpone(&mut self, turn: usize, later: usize) -> [usize; 2] {
        let unknowns = std::mem::take(&mut self.unknowns[turn]);
        let pair = [unknowns[0], self.unknowns[later][0]];
        unknowns.iter().for_each(|u| self.turn_of[*u] = later);
        self.unknowns[later].extend(unknowns);
        pair
    }
}

/// True if the elimination of D in its order comes to a zero pivot beside another zero on the diagonal.
///
/// In K(h), this pivot is of order h², and loses the digits of later groups without a trace on this diagonal.
fn has_hidden_pivot(mut d: DMatrix<f64>) -> bool {
    let size = d.nrows();
    for k in 0..size {
        let is_zero = |x: f64| x.abs() <= ROUNDING;
        if is_zero(d[(k, k)]) {
            return (k + 1..size).any(|i| is_zero(d[(i, i)]) && !is_zero(d[(i, k)]));
        }
        for j in k + 1..size {
            let factor = d[(k, j)] / d[(k, k)];
            (k + 1..size).for_each(|i| d[(i, j)] -= d[(i, k)] * factor);
        }
    }
    false
}

/// Scales the unknowns of the symmetric matrix D, and the columns of C, so that the rows of D have lengths of about 1 for any units of the unknowns.
fn scale(d: &mut DMatrix<f64>, c: &mut DMatrix<f64>) {
    for _ in 0..12 {
        let roots = Vec::from_iter(d.row_iter().map(|row| row.norm().sqrt()));
        for (i, root) in roots.into_iter().enumerate().filter(|(_, root)| *root > 0.0) {
            d.row_mut(i).unscale_mut(root);
            d.column_mut(i).unscale_mut(root);
            c.column_mut(i).unscale_mut(root);
        }
    }
}
