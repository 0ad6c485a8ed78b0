//! Another solver behind [`Factorization`], to check ours by: the sparse LU of faer, which interchanges rows where it likes.

use super::factorization::{Breakdown, Factorization, RightSide};
use super::node::PanelEntry;
use super::symbolic::Symbolic;
use faer::MatMut;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Lu;
use faer::sparse::{SparseColMat, Triplet};

/// faer's factors of the values; allocates at every factorisation.
pub(crate) struct SparseLu {
    values: Vec<f64>,
    condensed: usize,
    ones: Vec<f64>,
    factors: Option<Lu<usize, f64>>,
}

impl Factorization for SparseLu {
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
        let both = |entry: &PanelEntry| {
            let [[i, j], [upper, lower]] = [entry.at, entry.stored].map(|pair| pair.map(|x| x as usize));
            [(i, j, upper)].into_iter().chain((i != j).then_some((j, i, lower)))
        };
        let entries: Vec<_> = (symbolic.panel_entries().iter().flat_map(both))
            .map(|(i, j, slot)| Triplet::new(i - self.condensed, j - self.condensed, self.values[slot]))
            .collect();
        let matrix = SparseColMat::try_new_from_triplets(size, size, &entries).expect("positions in range");
        let singular = Breakdown { unknown: 0, pivot: 0.0, scale: 1.0 };
        self.factors = (size > 0).then(|| matrix.sp_lu()).transpose().map_err(|_| singular)?;
        match with {
            RightSide::None => {}
            RightSide::Of(x) => self.solve(symbolic, x),
            RightSide::OfTransposed(x) => self.solve_transposed(symbolic, x),
        }
        Ok(())
    }

    fn solve(&self, _: &Symbolic, x: &mut [f64]) {
        let (Some(factors), free) = (&self.factors, &mut x[self.condensed..]) else { return };
        let rows = free.len();
        factors.solve_in_place(MatMut::from_column_major_slice_mut(free, rows, 1));
    }

    fn solve_transposed(&self, _: &Symbolic, x: &mut [f64]) {
        let (Some(factors), free) = (&self.factors, &mut x[self.condensed..]) else { return };
        let rows = free.len();
        factors.solve_transpose_in_place(MatMut::from_column_major_slice_mut(free, rows, 1));
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
