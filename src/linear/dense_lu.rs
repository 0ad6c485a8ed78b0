//! Reference implementation of [`Factorization`] for tests: nalgebra's dense LU, which may interchange any rows.

use super::factorization::{Breakdown, Factorization};
use super::kernel::RightSide;
use super::symbolic::Symbolic;
use nalgebra::{DMatrix, DVectorViewMut, Dyn, LU};

/// Dense factors of S and of Sᵀ; allocates in every factorisation.
pub(crate) struct DenseLu {
    values: Vec<f64>,
    condensed: usize,
    ones: Vec<f64>,
    factors: Option<[LU<f64, Dyn, Dyn>; 2]>,
}

impl Factorization for DenseLu {
    fn new(symbolic: &Symbolic) -> Self {
        Self {
            values: vec![0.0; symbolic.values_len()],
            condensed: symbolic.condensed(),
            ones: vec![1.0; symbolic.size()],
            factors: None,
        }
    }

    fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    fn factor(&mut self, symbolic: &Symbolic, _: &[f64], with: RightSide<'_>) -> Result<(), Breakdown> {
        let size = symbolic.size() - self.condensed;
        let mut matrix = DMatrix::zeros(size, size);
        for entry in symbolic.panel_entries() {
            let [[i, j], [upper, lower]] = [entry.at, entry.stored].map(|pair| pair.map(|x| x as usize));
            let (i, j) = (i - self.condensed, j - self.condensed);
            (matrix[(j, i)], matrix[(i, j)]) = (self.values[lower], self.values[upper]);
        }
        let factors = [matrix.transpose(), matrix].map(DMatrix::lu);
        if !factors[1].is_invertible() {
            return Err(Breakdown { unknown: 0, pivot: 0.0, scale: 1.0 });
        }
        self.factors = Some(factors);
        match with {
            RightSide::None => {}
            RightSide::Of(x) => self.solve(symbolic, x),
            RightSide::OfTransposed(x) => self.solve_transposed(symbolic, x),
        }
        Ok(())
    }

    fn solve(&self, _: &Symbolic, x: &mut [f64]) {
        self.solve_with(1, x);
    }

    fn solve_transposed(&self, _: &Symbolic, x: &mut [f64]) {
        self.solve_with(0, x);
    }

    fn worst_loss(&self) -> f64 {
        1.0
    }

    fn magnitudes(&self) -> &[f64] {
        &self.ones
    }

    fn reciprocal_pivots<'a>(&'a self, _: &'a Symbolic) -> impl Iterator<Item = f64> + 'a {
        self.ones[self.condensed..].iter().copied()
    }
}

impl DenseLu {
    /// Solves with the factors of Sᵀ (0) or S (1) for the unknowns that are not condensed.
    fn solve_with(&self, which: usize, x: &mut [f64]) {
        let free = &mut x[self.condensed..];
        let rows = free.len();
        if rows == 0 {
            return;
        }
        let factors = &self.factors.as_ref().expect("factored")[which];
        assert!(factors.solve_mut(&mut DVectorViewMut::from_slice(free, rows)), "singular");
    }
}
