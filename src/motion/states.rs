//! [`States`]: states of a motion at nodes or at stages, one column each.

use nalgebra::DMatrix;

use super::column::{column, column_mut};
use crate::number::Real;
use crate::system::NodeView;

/// States y_i = (v, ṗ*, q, p*, σ)_i, one column each: those at the nodes of a motion, or those at the stages between nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct States<R = f64> {
    /// Times, s.
    pub times: Vec<R>,
    /// Coordinates, m or rad (n rows).
    pub q: DMatrix<R>,
    /// Velocities, m/s or rad/s.
    pub v: DMatrix<R>,
    /// Augmented momenta, N s or N m s.
    pub p_star: DMatrix<R>,
    /// Rates ṗ* = 𝓛_q + Q of the augmented momenta, N or N m.
    pub p_star_dot: DMatrix<R>,
    /// Lagrange multipliers σ (impulses), N s or N m s (m rows).
    pub sigma: DMatrix<R>,
    /// Controls at stages, linear between nodes. No rows for nodes, whose controls are part of the [`Inputs`](crate::Inputs).
    pub u: DMatrix<R>,
}

/// Mutable state of a node or stage, with the controls of a stage.
pub(crate) struct ColumnsMut<'a, R> {
    pub(crate) q: &'a mut [R],
    pub(crate) v: &'a mut [R],
    pub(crate) p_star: &'a mut [R],
    pub(crate) p_star_dot: &'a mut [R],
    pub(crate) sigma: &'a mut [R],
    pub(crate) time: &'a mut R,
    pub(crate) u: &'a [R],
}

impl<R: Real> ColumnsMut<'_, R> {
    /// Sets q, v, p*, ṗ* and σ to zero.
    pub(crate) fn clear(self) {
        [self.q, self.v, self.p_star, self.p_star_dot, self.sigma].into_iter().for_each(|list| list.fill(R::zero()));
    }
}

/// Numbers of rows of q, v, p*, ṗ*, σ, u for n coordinates, m multipliers and k controls.
pub(crate) fn rows_of_states(n: usize, m: usize, k: usize) -> [usize; 6] {
    [n, n, n, n, m, k]
}

impl<R> States<R> {
    /// From times and the matrices q, v, p*, ṗ*, σ, u.
    pub(crate) fn new(times: Vec<R>, [q, v, p_star, p_star_dot, sigma, u]: [DMatrix<R>; 6]) -> Self {
        States { times, q, v, p_star, p_star_dot, sigma, u }
    }

    /// The matrices q, v, p*, ṗ*, σ, u.
    pub(crate) fn matrices(&self) -> [&DMatrix<R>; 6] {
        [&self.q, &self.v, &self.p_star, &self.p_star_dot, &self.sigma, &self.u]
    }

    /// The matrices q, v, p*, ṗ*, σ, u, to be written.
    pub(crate) fn matrices_mut(&mut self) -> [&mut DMatrix<R>; 6] {
        [&mut self.q, &mut self.v, &mut self.p_star, &mut self.p_star_dot, &mut self.sigma, &mut self.u]
    }

    /// (name, expected, found) of the numbers of rows and columns of all matrices, with their names.
    pub(crate) fn sizes(
        &self,
        names: [[&'static str; 2]; 6],
        rows: [usize; 6],
        columns: usize,
    ) -> impl Iterator<Item = (&'static str, usize, usize)> {
        let all = self.matrices().into_iter().zip(names).zip(rows);
        let of_lists = all.flat_map(move |((matrix, [row, column]), rows)| {
            [(row, rows, matrix.nrows()), (column, columns, matrix.ncols())]
        });
        of_lists.chain([(names[0][1], columns, self.times.len())])
    }
}

impl<R: Real> States<R> {
    pub(crate) fn zeros(rows: [usize; 6], columns: usize) -> Self {
        let zeros = |rows| DMatrix::from_element(rows, columns, R::zero());
        States::new(vec![R::zero(); columns], rows.map(zeros))
    }

    /// Resizes to a number of columns; existing columns keep their values.
    pub(crate) fn resize(&mut self, columns: usize) {
        self.times.resize(columns, R::zero());
        self.times.shrink_to_fit();
        for matrix in self.matrices_mut() {
            let old = std::mem::replace(matrix, DMatrix::from_element(0, 0, R::zero()));
            *matrix = old.resize_horizontally(columns, R::zero());
        }
    }

    #[inline]
    pub(crate) fn columns(&self, i: usize) -> NodeView<'_, R> {
        NodeView {
            t: self.times[i],
            q: column(&self.q, i),
            v: column(&self.v, i),
            p_star: column(&self.p_star, i),
            p_star_dot: column(&self.p_star_dot, i),
            v_dot: &[],
            lambda: &[],
            sigma: column(&self.sigma, i),
            u: column(&self.u, i),
            u_dot: &[],
            design: &[],
        }
    }

    #[inline]
    pub(crate) fn columns_mut(&mut self, i: usize) -> ColumnsMut<'_, R> {
        ColumnsMut {
            q: column_mut(&mut self.q, i),
            v: column_mut(&mut self.v, i),
            p_star: column_mut(&mut self.p_star, i),
            p_star_dot: column_mut(&mut self.p_star_dot, i),
            sigma: column_mut(&mut self.sigma, i),
            time: &mut self.times[i],
            u: column(&self.u, i),
        }
    }

    /// Moves `count` columns, the first of which is `from`, to the front.
    pub(crate) fn move_to_front(&mut self, from: usize, count: usize) {
        self.times.copy_within(from..from + count, 0);
        for matrix in self.matrices_mut() {
            let rows = matrix.nrows();
            matrix.as_mut_slice().copy_within(from * rows..(from + count) * rows, 0);
        }
    }

    /// Appends the numbers of column `i` to a list.
    pub(crate) fn append_column(&self, i: usize, to: &mut Vec<R>) {
        to.push(self.times[i]);
        self.matrices().into_iter().for_each(|matrix| to.extend_from_slice(column(matrix, i)));
    }

    /// Sets column `i` from a list that [`append_column`](Self::append_column) wrote.
    pub(crate) fn set_column(&mut self, i: usize, from: &[R]) {
        let (time, mut rest) = from.split_at(1);
        self.times[i] = time[0];
        for matrix in self.matrices_mut() {
            let (own, after) = rest.split_at(matrix.nrows());
            column_mut(matrix, i).copy_from_slice(own);
            rest = after;
        }
    }

    /// Combines each number with that of other states.
    pub(crate) fn zip_map<A: Real, B: Real>(&self, other: &States<A>, make: impl Fn(R, A) -> B + Copy) -> States<B> {
        let times = self.times.iter().zip(&other.times).map(|(x, y)| make(*x, *y)).collect();
        let (own, others) = (self.matrices(), other.matrices());
        States::new(times, std::array::from_fn(|j| own[j].zip_map(others[j], make)))
    }
}
