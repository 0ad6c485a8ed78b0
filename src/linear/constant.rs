//! The constant part of the matrix and the elimination of the condensed unknowns.

use super::block_lu::Breakdown;
use super::symbolic::{Step, Symbolic};

/// A condensed pivot must exceed this fraction of the magnitudes that were added up in it.
///
/// Other entries of its row have other units and say nothing about it.
const SMALLEST_PIVOT: f64 = 1e-13;

/// Constant entries, reduced by the condensed unknowns.
///
/// A condensed unknown c with pivot p keeps [1/p, row K_cj, column K_jc/p] over its neighbours j.
#[derive(Debug, Clone)]
pub(super) struct Constant {
    entries: Vec<f64>,
    scale: Vec<f64>,
    panels: usize,
    worst: f64,
}

impl Constant {
    /// The zero matrix.
    pub(super) fn new(symbolic: &Symbolic) -> Self {
        Self {
            entries: vec![0.0; symbolic.stored_len()],
            scale: vec![0.0; symbolic.size()],
            panels: symbolic.values_len(),
            worst: 1.0,
        }
    }

    /// What the panels hold before the varying entries are added.
    pub(super) fn image(&self) -> &[f64] {
        &self.entries[..self.panels]
    }

    /// Magnitudes that the condensation added to the diagonal entries, per position.
    pub(super) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// The largest ratio of the magnitudes added up in a pivot to the pivot.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }

    /// The reciprocal pivots of the condensed unknowns.
    pub(super) fn reciprocal_pivots<'a>(&'a self, symbolic: &'a Symbolic) -> impl Iterator<Item = f64> + 'a {
        symbolic.steps().iter().map(|step| self.entries[step.start])
    }

    /// Sums up triplets (row, column, value) and eliminates the condensed unknowns:
    /// K_ij −= K_ic K_cj / K_cc for all neighbours i, j of c.
    ///
    /// # Errors
    /// A pivot that vanishes, or vanishes against its summands.
    pub(super) fn set(&mut self, symbolic: &Symbolic, triplets: &[(usize, usize, f64)]) -> Result<(), Breakdown> {
        self.entries.fill(0.0);
        self.scale.fill(0.0);
        self.worst = 1.0;
        for &(row, col, value) in triplets {
            let place = symbolic.place(row, col);
            debug_assert!(place.is_some(), "({row}, {col}) is not in the pattern");
            if let Some(place) = place {
                self.entries[place] += value;
            }
        }
        for (position, step) in symbolic.steps().iter().enumerate() {
            self.eliminate(position, step).map_err(|(pivot, scale)| {
                let unknown = symbolic.unknown(position);
                Breakdown { unknown, pivot, scale }
            })?;
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
        *pivot = 1.0 / *pivot;
        let mut places = step.targets.iter();
        for ((factor, &u), &i) in column.iter_mut().zip(&*row).zip(&step.neighbours) {
            *factor *= *pivot;
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

    /// [1/p], row and column of a condensed unknown.
    fn parts(&self, step: &Step) -> (f64, &[f64], &[f64]) {
        let own = &self.entries[step.run()];
        let (row, column) = own[1..].split_at(step.neighbours.len());
        (own[0], row, column)
    }

    /// x_j −= (K_jc/p) x_c.
    pub(super) fn forward(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (c, step) in symbolic.steps().iter().enumerate() {
            let (_, _, column) = self.parts(step);
            scatter(x[c], column, step, x);
        }
    }

    /// x_c := (x_c − Σ K_cj x_j) / p.
    pub(super) fn backward(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (c, step) in symbolic.steps().iter().enumerate().rev() {
            let (inverse, row, _) = self.parts(step);
            x[c] = (x[c] - gather(row, step, x)) * inverse;
        }
    }

    /// x_c := x_c / p, then x_j −= K_cj x_c.
    pub(super) fn forward_transposed(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (c, step) in symbolic.steps().iter().enumerate() {
            let (inverse, row, _) = self.parts(step);
            x[c] *= inverse;
            scatter(x[c], row, step, x);
        }
    }

    /// x_c −= Σ (K_jc/p) x_j.
    pub(super) fn backward_transposed(&self, symbolic: &Symbolic, x: &mut [f64]) {
        for (c, step) in symbolic.steps().iter().enumerate().rev() {
            let (_, _, column) = self.parts(step);
            x[c] -= gather(column, step, x);
        }
    }
}

#[inline]
fn scatter(factor: f64, line: &[f64], step: &Step, x: &mut [f64]) {
    for (&j, entry) in step.neighbours.iter().zip(line) {
        x[j] -= entry * factor;
    }
}

#[inline]
fn gather(line: &[f64], step: &Step, x: &[f64]) -> f64 {
    (step.neighbours.iter().zip(line)).map(|(&j, entry)| entry * x[j]).sum()
}
