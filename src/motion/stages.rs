//! States of a motion at the stages between nodes, one column each.

use nalgebra::DMatrix;

use super::column::{column, column_mut};
use crate::number::Real;
use crate::system::NodeView;

/// States at the inner stages of all steps. (The last stage of a step is a node.) For a scheme with S stages, stage s of the step that ends
/// at node i is column i (S − 1) + s − 1; the columns of node 0 are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Stages<R = f64> {
    /// Times, s.
    pub times: Vec<R>,
    /// Coordinates, m or rad.
    pub q: DMatrix<R>,
    /// Velocities, m/s or rad/s.
    pub v: DMatrix<R>,
    /// Augmented momenta, N s or N m s.
    pub p_star: DMatrix<R>,
    /// Rates ṗ* of the augmented momenta, N or N m.
    pub p_star_dot: DMatrix<R>,
    /// Lagrange multipliers σ, N s or N m s.
    pub sigma: DMatrix<R>,
    /// Controls, linear between nodes.
    pub u: DMatrix<R>,
}

/// Mutable state of a node or stage, with the controls of a stage between nodes.
pub(crate) struct ColumnsMut<'a, R> {
    pub(crate) time: &'a mut R,
    pub(crate) q: &'a mut [R],
    pub(crate) v: &'a mut [R],
    pub(crate) p_star: &'a mut [R],
    pub(crate) p_star_dot: &'a mut [R],
    pub(crate) sigma: &'a mut [R],
    pub(crate) u: &'a [R],
}

impl<R: Real> Stages<R> {
    pub(crate) fn zeros((n, m, k): (usize, usize, usize), columns: usize) -> Self {
        let state = |rows| DMatrix::from_element(if columns > 0 { rows } else { 0 }, columns, R::zero());
        let times = vec![R::zero(); columns];
        Stages { times, q: state(n), v: state(n), p_star: state(n), p_star_dot: state(n), sigma: state(m), u: state(k) }
    }

    /// Resizes to a number of columns; existing columns keep their values.
    pub(crate) fn resize(&mut self, columns: usize) {
        if columns == self.times.len() {
            return;
        }
        self.times.resize(columns, R::zero());
        self.times.shrink_to_fit();
        for matrix in [&mut self.q, &mut self.v, &mut self.p_star, &mut self.p_star_dot, &mut self.sigma, &mut self.u] {
            let old = std::mem::replace(matrix, DMatrix::from_element(0, 0, R::zero()));
            *matrix = old.resize_horizontally(columns, R::zero());
        }
    }

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

    pub(crate) fn columns_mut(&mut self, i: usize) -> ColumnsMut<'_, R> {
        ColumnsMut {
            time: &mut self.times[i],
            q: column_mut(&mut self.q, i),
            v: column_mut(&mut self.v, i),
            p_star: column_mut(&mut self.p_star, i),
            p_star_dot: column_mut(&mut self.p_star_dot, i),
            sigma: column_mut(&mut self.sigma, i),
            u: column(&self.u, i),
        }
    }
}
