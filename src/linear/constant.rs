//! The constant part of the matrix and the elimination of the condensed unknowns.

use super::factorization::Breakdown;
use super::node::PanelEntry;
use super::symbolic::{Step, Symbolic};
use crate::number::minus_product;

/// Smallest accepted ratio of a condensed pivot to the sum of the magnitudes of its terms.
///
/// Other entries of the row have other units and are therefore not compared with the pivot.
const SMALLEST_PIVOT: f64 = 1e-13;

/// Constant entries after condensation: S = K_ff − K_fc K_cc⁻¹ K_cf, where c are the condensed unknowns and f the others.
#[derive(Debug, Clone)]
pub(super) struct Constant {
    /// S by panels, followed by the entries used to eliminate each condensed unknown: [pivot, row, column].
    entries: Vec<f64>,
    /// The diagonal of S, from the first unknown that is not condensed on, and the other nonzero entries of S.
    diagonal: Vec<f64>,
    reduced: Vec<Coupling>,
    /// 1/p of the condensed unknowns.
    inverse: Vec<f64>,
    /// K_cj/p and K_jc/p for each condensed unknown c with pivot p and its neighbours j when it is eliminated, in the order of elimination.
    couplings: Vec<Coupling>,
    scale: Vec<f64>,
    panels: usize,
    worst: f64,
}

/// The entries (c, j) and (j, c) of a matrix, by position.
#[derive(Debug, Clone, Copy)]
struct Coupling {
    c: u32,
    j: u32,
    row: f64,
    column: f64,
}

impl Coupling {
    fn is_zero(&self) -> bool {
        self.row == 0.0 && self.column == 0.0
    }
}

impl Constant {
    /// The zero matrix.
    pub(super) fn new(symbolic: &Symbolic) -> Self {
        Self {
            entries: vec![0.0; symbolic.stored_len()],
            diagonal: vec![0.0; symbolic.size() - symbolic.condensed()],
            reduced: Vec::with_capacity(symbolic.values_len()),
            inverse: vec![0.0; symbolic.condensed()],
            couplings: Vec::with_capacity(symbolic.steps().iter().map(|step| step.neighbours.len()).sum()),
            scale: vec![0.0; symbolic.size()],
            panels: symbolic.values_len(),
            worst: 1.0,
        }
    }

    /// The values of the panels before the varying entries are added.
    pub(super) fn image(&self) -> &[f64] {
        &self.entries[..self.panels]
    }

    /// Sums of magnitudes that the condensation added to the diagonal entries, by position.
    pub(super) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// The largest ratio of the magnitudes added up in a condensed pivot to the pivot.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }

    /// The reciprocal pivots of the condensed unknowns.
    pub(super) fn reciprocal_pivots(&self) -> impl Iterator<Item = f64> + '_ {
        self.inverse.iter().copied()
    }

    /// Sums the entries by place and eliminates the condensed unknowns:
    /// K_ij −= K_ic K_cj / K_cc for all neighbours i, j of c.
    ///
    /// # Errors
    /// A pivot vanishes or is negligible compared with its terms.
    pub(super) fn set(&mut self, symbolic: &Symbolic, entries: impl Iterator<Item = (usize, f64)>) -> Result<(), Breakdown> {
        self.entries.fill(0.0);
        self.scale.fill(0.0);
        self.worst = 1.0;
        entries.for_each(|(place, value)| self.entries[place] += value);
        self.couplings.clear();
        for (position, step) in symbolic.steps().iter().enumerate() {
            self.eliminate(position, step).map_err(|(pivot, scale)| {
                let unknown = symbolic.unknown(position);
                Breakdown { unknown, pivot, scale }
            })?;
            self.couple(position, step);
        }
        self.reduced.clear();
        for PanelEntry { at: [c, j], stored } in symbolic.panel_entries() {
            let [row, column] = stored.map(|place| self.entries[place as usize]);
            if c == j {
                self.diagonal[*c as usize - self.inverse.len()] = row;
            } else if row != 0.0 || column != 0.0 {
                self.reduced.push(Coupling { c: *c, j: *j, row, column });
            }
        }
        Ok(())
    }

    fn eliminate(&mut self, position: usize, step: &Step) -> Result<(), (f64, f64)> {
        let (targets, own) = self.entries.split_at_mut(step.start);
        let (own, later) = own.split_at_mut(step.run().len());
        let [pivot, sides @ ..] = own else {
            return Ok(());
        };
        let (row, column) = sides.split_at_mut(step.neighbours.len());
        let scale = pivot.abs() + self.scale[position];
        if !pivot.is_finite() || pivot.abs() <= SMALLEST_PIVOT * scale {
            return Err((*pivot, scale));
        }
        self.worst = self.worst.max(scale / pivot.abs());
        let inverse = 1.0 / *pivot;
        self.inverse[position] = inverse;
        let mut places = step.targets.iter();
        for ((factor, &u), &i) in column.iter_mut().zip(&*row).zip(&step.neighbours) {
            *factor *= inverse;
            self.scale[i] += (*factor * u).abs();
            for (&u, &place) in row.iter().zip(&mut places) {
                let target = match place.checked_sub(step.run().end) {
                    Some(behind) if place >= step.start => &mut later[behind],
                    _ => &mut targets[place],
                };
                *target -= *factor * u;
            }
        }
        Ok(())
    }

    /// Stores the couplings of an eliminated unknown.
    fn couple(&mut self, position: usize, step: &Step) {
        let (row, column) = self.entries[step.run()][1..].split_at(step.neighbours.len());
        let inverse = self.inverse[position];
        let sides = row.iter().zip(column).zip(&step.neighbours);
        let c = position as u32;
        let couplings = sides.map(|((row, column), &j)| Coupling { c, j: j as u32, row: row * inverse, column: *column });
        self.couplings.extend(couplings.filter(|coupling| !coupling.is_zero()));
    }

    /// y_f −= S x_f.
    pub(super) fn subtract_reduced_product(&self, x: &[f64], y: &mut [f64]) {
        let y = &mut y[..x.len()];
        let free = self.inverse.len()..;
        for (y, (s, x)) in y[free.clone()].iter_mut().zip(self.diagonal.iter().zip(&x[free])) {
            *y = minus_product(*y, *s, *x);
        }
        for at in &self.reduced {
            let (c, j) = (at.c as usize, at.j as usize);
            y[c] = minus_product(y[c], at.row, x[j]);
            y[j] = minus_product(y[j], at.column, x[c]);
        }
    }

    /// The largest |S_ij x_j| times the weight of row i (rows are numbered without the condensed unknowns).
    pub(super) fn largest_reduced_product(&self, x: &[f64], weight: impl Fn(usize) -> f64) -> f64 {
        let first = self.inverse.len();
        let mut largest = 0.0f64;
        let mut add = |row: usize, product: f64| largest = largest.max((weight(row) * product).abs());
        for (row, (s, x)) in self.diagonal.iter().zip(&x[first..]).enumerate() {
            add(row, s * x);
        }
        for at in &self.reduced {
            let (c, j) = (at.c as usize, at.j as usize);
            add(c - first, at.row * x[j]);
            add(j - first, at.column * x[c]);
        }
        largest
    }

    // Let c be a condensed unknown and j its neighbours (condensed later, or not at all). In the order of elimination,
    //   forward: x_j −= (K_jc/p) x_c;   backward, in reverse order: x_c := (x_c − Σ K_cj x_j)/p.
    // Only its own pivot scales x_c, so all reciprocals may be applied first, or last.

    /// x_f −= K_fc K_cc⁻¹ x_c; x_c is left partly eliminated, as `backward` requires.
    pub(super) fn forward(&self, x: &mut [f64]) {
        for at in &self.couplings {
            x[at.j as usize] = minus_product(x[at.j as usize], at.column, x[at.c as usize]);
        }
    }

    /// x_c := K_cc⁻¹ (x_c − K_cf x_f), after `forward`.
    pub(super) fn backward(&self, x: &mut [f64]) {
        self.scale_condensed(x);
        for at in self.couplings.iter().rev() {
            x[at.c as usize] = minus_product(x[at.c as usize], at.row, x[at.j as usize]);
        }
    }

    /// As `forward`, for Kᵀ.
    pub(super) fn forward_transposed(&self, x: &mut [f64]) {
        for at in &self.couplings {
            x[at.j as usize] = minus_product(x[at.j as usize], at.row, x[at.c as usize]);
        }
        self.scale_condensed(x);
    }

    /// As `backward`, for Kᵀ.
    pub(super) fn backward_transposed(&self, x: &mut [f64]) {
        for at in self.couplings.iter().rev() {
            x[at.c as usize] = minus_product(x[at.c as usize], at.column, x[at.j as usize]);
        }
    }

    fn scale_condensed(&self, x: &mut [f64]) {
        x.iter_mut().zip(&self.inverse).for_each(|(x, inverse)| *x *= inverse);
    }
}
