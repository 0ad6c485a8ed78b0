//! [`Factors`]: factorisation of the KKT matrix of a problem in stages, stage by stage (Riccati recursion); its cost is linear in the number of
//! stages.
//!
//! ```text
//!   min Σ ½ v_kᵀ(H_k + δ E_k) v_k + g_kᵀv_k    s_{k+1} = D_k v_k + d_k,   C_k v_k + e_k = 0,   s_0 = 0 except for its free entries,   v_k = (s_k, w_k)
//!
//!   P_K = H_K + ρ C_KᵀC_K,   M_k = H_k + δ E_k + ρ C_kᵀC_k + D_kᵀP_{k+1}D_k,   P_k = M_ss − M_sw M_ww⁻¹ M_ws
//! ```
//!
//! The rows C are satisfied exactly by a Schur complement. The matrix has the inertia of a minimum if all Cholesky factors exist for some ρ.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::problem::{Multipliers, Residuals};

/// Weights ρ of the rows C in the recursion. The solution does not depend on them, but a small one does not outweigh negative curvature across rows
/// with small derivatives, and a large one loses digits.
pub(super) const ROWS: [f64; 2] = [1e3, 1e6];
/// The Schur complement of rows that depend on each other is singular; this fraction of its largest entry is added to its diagonal.
const DEPENDENT: f64 = 1e-12;

/// The matrices of one stage.
pub(super) struct Blocks {
    /// H_k.
    pub hessian: DMatrix<f64>,
    /// D_k; without rows for the end.
    pub dynamics: DMatrix<f64>,
    /// C_k.
    pub rows: DMatrix<f64>,
    /// Diagonal of E_k: entries of v that a shift δ affects.
    pub shifted: DVector<f64>,
}

/// The right-hand sides, or the residuals, of all stages: g_k, and d_k and e_k.
#[derive(Clone)]
pub(super) struct Sides {
    pub gradients: Vec<DVector<f64>>,
    pub residuals: Residuals,
}

/// The solution: v, and the multipliers of the dynamics and of the rows C.
pub(super) struct Direction {
    pub v: Vec<DVector<f64>>,
    pub multipliers: Multipliers,
}

/// Factors of one stage.
struct Stage {
    /// Cholesky factor of M_ww.
    own: Cholesky<f64, Dyn>,
    /// L⁻¹ M_ws.
    coupling: DMatrix<f64>,
}

/// The factorised KKT matrix.
pub(super) struct Factors<'b> {
    blocks: &'b [Blocks],
    /// Free entries of s_0.
    free: &'b [usize],
    shift: f64,
    /// ρ.
    weight: f64,
    stages: Vec<Stage>,
    /// P_1 … P_K.
    values: Vec<DMatrix<f64>>,
    /// Cholesky factor of the free entries of P_0.
    start: Cholesky<f64, Dyn>,
    /// Cholesky factor of the Schur complement of the rows, if there are any.
    rows: Option<Cholesky<f64, Dyn>>,
}

impl<'b> Factors<'b> {
    /// Factorises with the first weight for which the inertia is that of a minimum; `None` if there is none. All stages but the last have dynamics.
    pub(super) fn new(blocks: &'b [Blocks], free: &'b [usize], shift: f64) -> Option<Self> {
        let has_rows = blocks.iter().any(|of| of.rows.nrows() > 0);
        let weights = &ROWS[..if has_rows { ROWS.len() } else { 1 }];
        weights.iter().find_map(|weight| Self::weighted(blocks, free, shift, *weight))
    }

    /// As [`new`](Self::new), with this weight of the rows.
    pub(super) fn weighted(blocks: &'b [Blocks], free: &'b [usize], shift: f64, weight: f64) -> Option<Self> {
        let (end, before) = blocks.split_last()?;
        let mut value = shifted(end, shift, weight);
        let (mut stages, mut values) = (Vec::with_capacity(before.len()), Vec::with_capacity(before.len()));
        for of in before.iter().rev() {
            let states = value.nrows();
            let mut m = shifted(of, shift, weight);
            m += of.dynamics.tr_mul(&(&value * &of.dynamics));
            let own = m.ncols() - states;
            let factor = Cholesky::new(m.view((states, states), (own, own)).into_owned())?;
            let mut coupling = m.view((states, 0), (own, states)).into_owned();
            if own > 0 && !factor.l_dirty().solve_lower_triangular_mut(&mut coupling) {
                return None;
            }
            let mut next = m.view((0, 0), (states, states)).into_owned();
            next.gemm_tr(-1.0, &coupling, &coupling, 1.0);
            next = 0.5 * (&next + next.transpose());
            values.push(std::mem::replace(&mut value, next));
            stages.push(Stage { own: factor, coupling });
        }
        stages.reverse();
        values.reverse();
        let start = Cholesky::new(DMatrix::from_fn(free.len(), free.len(), |i, j| value[(free[i], free[j])]))?;
        let factors = Factors { blocks, free, shift, weight, stages, values, start, rows: None };
        factors.with_rows()
    }

    /// Adds the Schur complement −C (…)⁻¹ Cᵀ of all rows.
    fn with_rows(mut self) -> Option<Self> {
        let counts: Vec<usize> = self.blocks.iter().map(|of| of.rows.nrows()).collect();
        let total: usize = counts.iter().sum();
        if total == 0 {
            return Some(self);
        }
        let (mut schur, mut column) = (DMatrix::zeros(total, total), 0);
        let zero = self.zero();
        for (k, count) in counts.iter().enumerate() {
            for i in 0..*count {
                let mut side = zero.clone();
                side.gradients[k] = self.blocks[k].rows.row(i).transpose();
                let v = self.sweep(&side).v;
                schur.set_column(column, &-self.rows_times(&v));
                column += 1;
            }
        }
        schur = 0.5 * (&schur + schur.transpose());
        let regular = DEPENDENT * schur.amax();
        (0..total).for_each(|i| schur[(i, i)] += regular);
        self.rows = Some(Cholesky::new(schur)?);
        Some(self)
    }

    /// Right-hand sides that are zero.
    pub(super) fn zero(&self) -> Sides {
        let of = |size: fn(&Blocks) -> usize| self.blocks.iter().map(|of| DVector::zeros(size(of))).collect::<Vec<_>>();
        let mut defects = of(|of| of.dynamics.nrows());
        defects.pop();
        Sides { gradients: of(|of| of.hessian.nrows()), residuals: Residuals { defects, rows: of(|of| of.rows.nrows()) } }
    }

    /// The direction for these right-hand sides, refined once.
    pub(super) fn solve(&self, sides: &Sides) -> Direction {
        let mut direction = self.solve_once(sides);
        let correction = self.solve_once(&self.residuals(sides, &direction));
        direction.v.iter_mut().zip(&correction.v).for_each(|(v, by)| *v += by);
        direction.multipliers.add(1.0, &correction.multipliers);
        direction
    }

    fn solve_once(&self, sides: &Sides) -> Direction {
        let mut of = sides.clone();
        for ((g, e), block) in of.gradients.iter_mut().zip(&sides.residuals.rows).zip(self.blocks) {
            g.gemv_tr(self.weight, &block.rows, e, 1.0);
        }
        let Some(schur) = &self.rows else { return self.sweep(&of) };
        let mut missing = self.rows_times(&self.sweep(&of).v);
        missing += DVector::from_iterator(missing.len(), sides.residuals.rows.iter().flat_map(|e| e.iter().copied()));
        schur.solve_mut(&mut missing);
        let (mut first, mut rows) = (0, Vec::with_capacity(self.blocks.len()));
        for (g, block) in of.gradients.iter_mut().zip(self.blocks) {
            let own = missing.rows(first, block.rows.nrows()).into_owned();
            g.gemv_tr(1.0, &block.rows, &own, 1.0);
            first += own.len();
            rows.push(own);
        }
        let mut direction = self.sweep(&of);
        direction.multipliers.rows = rows;
        direction
    }

    /// The minimum without the rows C but with their weight: backwards for the linear terms, forwards for v.
    fn sweep(&self, sides: &Sides) -> Direction {
        let end = self.stages.len();
        let mut linear = vec![sides.gradients[end].clone()];
        let mut steps = Vec::with_capacity(end);
        for k in (0..end).rev() {
            let (Stage { own, coupling }, next) = (&self.stages[k], &linear[linear.len() - 1]);
            let states = coupling.ncols();
            let ahead = next + &self.values[k] * &sides.residuals.defects[k];
            let q = &sides.gradients[k] + self.blocks[k].dynamics.tr_mul(&ahead);
            let mut step = q.rows(states, q.len() - states).into_owned();
            own.l_dirty().solve_lower_triangular_mut(&mut step);
            let mut here = q.rows(0, states).into_owned();
            here.gemv_tr(-1.0, coupling, &step, 1.0);
            linear.push(here);
            steps.push(step);
        }
        linear.reverse();
        steps.reverse();
        let mut s = DVector::zeros(linear[0].len());
        let mut free = DVector::from_iterator(self.free.len(), self.free.iter().map(|&i| -linear[0][i]));
        self.start.solve_mut(&mut free);
        self.free.iter().zip(free.iter()).for_each(|(&i, x)| s[i] = *x);
        let (mut all, mut costates) = (Vec::with_capacity(end + 1), Vec::with_capacity(end));
        for k in 0..end {
            let Stage { own, coupling } = &self.stages[k];
            let mut w = -(&steps[k] + coupling * &s);
            own.l_dirty().tr_solve_lower_triangular_mut(&mut w);
            let v = DVector::from_iterator(s.len() + w.len(), s.iter().chain(w.iter()).copied());
            s = &self.blocks[k].dynamics * &v + &sides.residuals.defects[k];
            costates.push(&self.values[k] * &s + &linear[k + 1]);
            all.push(v);
        }
        all.push(s);
        Direction { v: all, multipliers: Multipliers { costates, rows: self.zero().residuals.rows } }
    }

    /// C v of all stages.
    fn rows_times(&self, v: &[DVector<f64>]) -> DVector<f64> {
        let all: Vec<f64> =
            self.blocks.iter().zip(v).flat_map(|(of, v)| (&of.rows * v).iter().copied().collect::<Vec<_>>()).collect();
        DVector::from_vec(all)
    }

    /// Residuals of all equations of a direction.
    pub(super) fn residuals(&self, sides: &Sides, of: &Direction) -> Sides {
        let (mut left, Multipliers { costates, rows }) = (sides.clone(), &of.multipliers);
        for (k, block) in self.blocks.iter().enumerate() {
            let (v, g) = (&of.v[k], &mut left.gradients[k]);
            g.gemv(1.0, &block.hessian, v, 1.0);
            *g += self.shift * block.shifted.component_mul(v);
            g.gemv_tr(1.0, &block.rows, &rows[k], 1.0);
            if let Some(costate) = costates.get(k) {
                g.gemv_tr(1.0, &block.dynamics, costate, 1.0);
                left.residuals.defects[k] += &block.dynamics * v - of.v[k + 1].rows(0, costate.len());
            }
            match k.checked_sub(1) {
                Some(before) => {
                    let costate = &costates[before];
                    let mut states = g.rows_mut(0, costate.len());
                    states -= costate;
                }
                None => {
                    let states = self.values.first().map_or(v.len(), |value| value.nrows());
                    (0..states).filter(|i| !self.free.contains(i)).for_each(|i| g[i] = 0.0);
                }
            }
            left.residuals.rows[k] += &block.rows * v;
        }
        left
    }
}

/// H + δ E + ρ CᵀC.
fn shifted(of: &Blocks, shift: f64, weight: f64) -> DMatrix<f64> {
    let mut m = of.hessian.clone();
    m.gemm_tr(weight, &of.rows, &of.rows, 1.0);
    of.shifted.iter().enumerate().for_each(|(i, e)| m[(i, i)] += shift * e);
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The KKT matrix of all stages as one, and its solution by LU.
    fn dense(blocks: &[Blocks], free: &[usize], shift: f64, sides: &Sides) -> DVector<f64> {
        let states = blocks[blocks.len() - 1].hessian.nrows();
        let sizes: Vec<usize> = blocks.iter().map(|of| of.hessian.nrows()).collect();
        let at = |k: usize| sizes[..k].iter().sum::<usize>();
        let (n, rows) = (at(blocks.len()), blocks.iter().map(|of| of.rows.nrows()).sum::<usize>());
        let fixed: Vec<usize> = (0..states).filter(|i| !free.contains(i)).collect();
        let total = n + (blocks.len() - 1) * states + rows + fixed.len();
        let (mut matrix, mut side) = (DMatrix::zeros(total, total), DVector::zeros(total));
        let mut row = n;
        for (k, of) in blocks.iter().enumerate() {
            let first = at(k);
            let h = &of.hessian + DMatrix::from_diagonal(&(&of.shifted * shift));
            matrix.view_mut((first, first), h.shape()).copy_from(&h);
            side.rows_mut(first, sizes[k]).copy_from(&-&sides.gradients[k]);
            let mut add = |block: &DMatrix<f64>, rhs: &DVector<f64>, next: Option<usize>| {
                matrix.view_mut((row, first), block.shape()).copy_from(block);
                matrix.view_mut((first, row), (block.ncols(), block.nrows())).copy_from(&block.transpose());
                side.rows_mut(row, rhs.len()).copy_from(&-rhs);
                for i in 0..next.map_or(0, |_| states) {
                    let next = next.unwrap_or(0);
                    matrix[(row + i, next + i)] = -1.0;
                    matrix[(next + i, row + i)] = -1.0;
                }
                row += block.nrows();
            };
            if k + 1 < blocks.len() {
                add(&of.dynamics, &sides.residuals.defects[k], Some(at(k + 1)));
            }
            add(&of.rows, &sides.residuals.rows[k], None);
        }
        for i in fixed {
            (matrix[(row, i)], matrix[(i, row)]) = (1.0, 1.0);
            row += 1;
        }
        matrix.lu().solve(&side).expect("regular")
    }

    #[test]
    fn the_direction_is_that_of_the_whole_matrix() {
        let mut count = 0.0;
        let mut next = || {
            count += 1.0;
            f64::sin(count * count)
        };
        let mut matrix = |rows: usize, columns: usize| DMatrix::from_fn(rows, columns, |_, _| next());
        let (states, own, rows) = (4, [3, 2, 0, 5, 0], [0, 1, 0, 2, 1]);
        let blocks: Vec<Blocks> = (0..5)
            .map(|k| {
                let size = states + own[k];
                let h = matrix(size, size);
                Blocks {
                    hessian: h.tr_mul(&h) + 0.1 * DMatrix::identity(size, size),
                    dynamics: matrix(if k < 4 { states } else { 0 }, size),
                    rows: matrix(rows[k], size),
                    shifted: DVector::from_fn(size, |i, _| (i % 2) as f64),
                }
            })
            .collect();
        let free = [1, 3];
        let factors = Factors::new(&blocks, &free, 0.3).expect("convex");
        let mut sides = factors.zero();
        for part in [&mut sides.gradients, &mut sides.residuals.defects, &mut sides.residuals.rows] {
            part.iter_mut().for_each(|of| *of = matrix(of.len(), 1).column(0).into_owned());
        }
        let found = factors.solve(&sides);
        let exact = dense(&blocks, &free, 0.3, &sides);
        let v: Vec<f64> = found.v.iter().flat_map(|v| v.iter().copied()).collect();
        let multipliers = (0..5).flat_map(|k| {
            let costates = found.multipliers.costates.get(k).map_or(&[][..], |of| of.as_slice());
            costates.iter().chain(found.multipliers.rows[k].as_slice()).copied().collect::<Vec<_>>()
        });
        let all = v.into_iter().chain(multipliers);
        all.zip(exact.iter()).for_each(|(x, y)| assert!((x - y).abs() < 1e-9 * exact.amax(), "{x} {y}"));
    }

    #[test]
    fn negative_curvature_across_rows_needs_no_shift() {
        // Of the two states at the end, the row determines the first one, along which the curvature is negative.
        let blocks = [
            Blocks {
                hessian: DMatrix::identity(4, 4),
                dynamics: DMatrix::from_row_slice(2, 4, &[1.0, 0.3, 0.5, -0.2, 0.1, 1.0, 0.4, 0.6]),
                rows: DMatrix::zeros(0, 4),
                shifted: DVector::from_element(4, 1.0),
            },
            Blocks {
                hessian: DMatrix::from_diagonal(&DVector::from_vec(vec![-50.0, 1.0])),
                dynamics: DMatrix::zeros(0, 2),
                rows: DMatrix::from_row_slice(1, 2, &[0.05, 0.0]),
                shifted: DVector::zeros(2),
            },
        ];
        let factors = Factors::new(&blocks, &[], 0.0).expect("a minimum");
        let mut sides = factors.zero();
        sides.gradients.iter_mut().for_each(|g| g.fill(1.0));
        sides.residuals.rows[1].fill(0.1);
        let (found, exact) = (factors.solve(&sides), dense(&blocks, &[], 0.0, &sides));
        let v = found.v.iter().flat_map(|v| v.iter());
        v.zip(exact.iter()).for_each(|(x, y)| assert!((x - y).abs() < 1e-9 * exact.amax(), "{x} {y}"));
    }

    #[test]
    fn a_maximum_has_no_factors() {
        let block = |curvature: f64| Blocks {
            hessian: DMatrix::from_diagonal_element(2, 2, curvature),
            dynamics: DMatrix::from_row_slice(1, 2, &[1.0, 1.0]),
            rows: DMatrix::zeros(0, 2),
            shifted: DVector::from_element(2, 1.0),
        };
        let end = || Blocks {
            hessian: DMatrix::identity(1, 1),
            dynamics: DMatrix::zeros(0, 1),
            rows: DMatrix::zeros(0, 1),
            shifted: DVector::zeros(1),
        };
        assert!(Factors::new(&[block(1.0), end()], &[], 0.0).is_some());
        assert!(Factors::new(&[block(-2.0), end()], &[], 0.0).is_none());
        assert!(Factors::new(&[block(-2.0), end()], &[], 3.0).is_some());
    }
}
