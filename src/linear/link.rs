//! The kernel for a node of one, two or three unknowns that couples to at most one later node of equal size: a link of a chain.
//!
//! Everything fits into registers, and rows are not interchanged: the velocities of a node come before its
//! multipliers, whose pivots −Φ_q M⁻¹ Φ_qᵀ are sums of one sign. If a pivot nevertheless loses digits, the
//! node is passed to the kernel with pivoting.
//!
//! Often the first unknown of one of the two nodes, the angle of a link, is not coupled to the other node (see [`Shape`]), which
//! saves a third of the work: the loops begin at own unknown a and at unknown b of the later node.

// Loops over constant index ranges are unrolled; the indices are those of the formulas.
#![expect(clippy::needless_range_loop)]

use super::lu::{Cancelled, IN_ORDER, MOST_LOSS, is_buried};
use super::node::{Node, Shape};
use super::node_kernel::{NodeKernel, State, eliminate_with_interchanges};
use super::size::Fixed;
use crate::number::{copy_singly, larger, minus_product, plus_product, singly};
use std::marker::PhantomData;

/// The kernel for links of a chain.
#[derive(Debug)]
pub(super) struct Link<const S: usize>;

type Matrix<const S: usize> = [[f64; S]; S];

/// D by columns, U by columns, L by rows.
struct Panel<const S: usize> {
    d: Matrix<S>,
    u: Matrix<S>,
    l: Matrix<S>,
}

#[inline(always)]
fn load<const S: usize>(values: &[f64]) -> Matrix<S> {
    let mut matrix = [[0.0; S]; S];
    matrix.as_flattened_mut().copy_from_slice(&values[..S * S]);
    matrix
}

#[inline(always)]
fn store<const S: usize>(matrix: &Matrix<S>, values: &mut [f64]) {
    values[..S * S].copy_from_slice(matrix.as_flattened());
}

/// The kernel that interchanges rows.
type Pivoting<const S: usize> = PhantomData<Fixed<S>>;

impl<const S: usize> Link<S> {
    // The start of U and of L in the panel of a node that has a later one.
    const U: usize = S * S;
    const L: usize = 2 * S * S;

    /// D = L U in place, with reciprocal pivots; returns the worst loss of digits, or None if it is too large.
    #[inline(always)]
    fn factor(d: &mut Matrix<S>, scale: &[f64]) -> Option<f64> {
        let mut worst = 1.0f64;
        for k in 0..S {
            let summands = (0..k).fold(0.0, |sum, m| sum + (d[m][k] * d[k][m]).abs());
            let inverse = 1.0 / d[k][k];
            let loss = (d[k][k].abs() + (summands + scale[k])) * inverse.abs();
            // False for NaN.
            if loss < MOST_LOSS && !is_buried(scale[k], summands) {
                worst = larger(worst, loss);
            } else {
                return None;
            }
            d[k][k] = inverse;
            for i in k + 1..S {
                d[k][i] *= inverse;
            }
            for c in k + 1..S {
                for i in k + 1..S {
                    d[c][i] = minus_product(d[c][i], d[k][i], d[c][k]);
                }
            }
        }
        Some(worst)
    }

    /// U := L_D⁻¹ U and L := L U_D⁻¹, from own unknown `a` and later unknown `b` on.
    #[inline(always)]
    fn eliminate_sides(panel: &mut Panel<S>, a: usize, b: usize) {
        let Panel { d, u, l } = panel;
        for column in &mut u[b..] {
            for k in a..S {
                for i in k + 1..S {
                    column[i] = minus_product(column[i], d[k][i], column[k]);
                }
            }
        }
        for row in &mut l[b..] {
            for k in a..S {
                for m in a..k {
                    row[k] = minus_product(row[k], row[m], d[k][m]);
                }
                row[k] *= d[k][k];
            }
        }
    }

    /// Subtracts L U from D of the later node, and adds the magnitudes to those of its diagonal.
    #[inline(always)]
    fn update(panel: &Panel<S>, d: &mut [f64], scale: &mut [f64], a: usize, b: usize) {
        let (d, scale) = (&mut d[..S * S], &mut scale[..S]);
        for c in b..S {
            for r in b..S {
                d[c * S + r] -= product(&panel.l[r], &panel.u[c], a);
            }
            scale[c] += magnitude(&panel.l[c], &panel.u[c], a);
        }
    }

    /// Eliminates a node whose unknowns before `a` are not coupled to the later node, and which is not coupled to that node's unknowns before `b`.
    /// Returns None, without changing anything, if a pivot loses too many digits.
    #[inline(always)]
    fn eliminate_from(node: &Node, state: &mut State<'_>, a: usize, b: usize) -> Option<f64> {
        let (square, behind) = state.values[node.start..].split_at_mut(S * S);
        let (own, after) = state.scale[node.first..].split_at_mut(S);
        let mut d = load(square);
        let worst = Self::factor(&mut d, own)?;
        store(&d, square);
        if let [later] = node.later.as_slice() {
            let (sides, rest) = behind.split_at_mut(2 * S * S);
            let (u, l) = sides.split_at_mut(S * S);
            let mut panel = Panel { d, u: load(u), l: load(l) };
            Self::eliminate_sides(&mut panel, a, b);
            store(&panel.u, u);
            store(&panel.l, l);
            Self::update(&panel, &mut rest[later.diagonal..], &mut after[later.first..], a, b);
        }
        state.swaps[node.first] = IN_ORDER;
        Some(worst)
    }

    #[inline(always)]
    fn forward_from(node: &Node, values: &[f64], x: &mut [f64], a: usize, b: usize) {
        let values = &values[node.start..];
        let (own, later) = x[node.first..].split_at_mut(S);
        let mut y = vector::<S>(own);
        solve_lower(&load(values), &mut y);
        scatter(node, (values, Self::L), &y, later, a, b);
        copy_singly(&y, own);
    }

    #[inline(always)]
    fn backward_from(node: &Node, values: &[f64], x: &mut [f64], a: usize, b: usize) {
        let values = &values[node.start..];
        let (own, later) = x[node.first..].split_at_mut(S);
        let mut y = vector::<S>(own);
        gather(node, (values, Self::U), later, &mut y, a, b);
        let d: Matrix<S> = load(values);
        for k in (0..S).rev() {
            y[k] *= d[k][k];
            for i in 0..k {
                y[i] = minus_product(y[i], d[k][i], y[k]);
            }
        }
        copy_singly(&y, own);
    }

    #[inline(always)]
    fn forward_transposed_from(node: &Node, values: &[f64], x: &mut [f64], a: usize, b: usize) {
        let values = &values[node.start..];
        let (own, later) = x[node.first..].split_at_mut(S);
        let mut y = vector::<S>(own);
        let d: Matrix<S> = load(values);
        for k in 0..S {
            for m in 0..k {
                y[k] = minus_product(y[k], d[k][m], y[m]);
            }
            y[k] *= d[k][k];
        }
        scatter(node, (values, Self::U), &y, later, a, b);
        copy_singly(&y, own);
    }

    #[inline(always)]
    fn backward_transposed_from(node: &Node, values: &[f64], x: &mut [f64], a: usize, b: usize) {
        let values = &values[node.start..];
        let (own, later) = x[node.first..].split_at_mut(S);
        let mut y = vector::<S>(own);
        gather(node, (values, Self::L), later, &mut y, a, b);
        let d: Matrix<S> = load(values);
        for k in (0..S).rev() {
            for i in k + 1..S {
                y[k] = minus_product(y[k], d[k][i], y[i]);
            }
        }
        copy_singly(&y, own);
    }
}

/// The scalar product from unknown `a` on, with at least one term; starting from zero would cost another addition.
#[inline(always)]
fn product<const S: usize>(x: &[f64; S], y: &[f64; S], a: usize) -> f64 {
    let mut sum = x[a] * y[a];
    for k in a + 1..S {
        sum = plus_product(sum, x[k], y[k]);
    }
    sum
}

/// The sum of the magnitudes of the terms of [`product`].
#[inline(always)]
fn magnitude<const S: usize>(x: &[f64; S], y: &[f64; S], a: usize) -> f64 {
    (a + 1..S).fold((x[a] * y[a]).abs(), |sum, k| sum + (x[k] * y[k]).abs())
}

#[inline(always)]
fn vector<const S: usize>(x: &[f64]) -> [f64; S] {
    let mut vector = [0.0; S];
    copy_singly(&x[..S], &mut vector);
    vector
}

/// x_b −= (lines of b)·y for the later node, if there is one; `side` is the start of the lines in the panel.
#[inline(always)]
fn scatter<const S: usize>(
    node: &Node,
    (panel, side): (&[f64], usize),
    y: &[f64; S],
    later: &mut [f64],
    a: usize,
    b: usize,
) {
    let [next] = node.later.as_slice() else { return };
    let (lines, x): (Matrix<S>, _) = (load(&panel[side..]), &mut later[next.first..][..S]);
    for c in b..S {
        x[c] -= product(&lines[c], y, a);
        singly();
    }
}

/// y −= (lines of b)ᵀ·x_b for the later node, if there is one.
#[inline(always)]
fn gather<const S: usize>(node: &Node, (panel, side): (&[f64], usize), later: &[f64], y: &mut [f64; S], a: usize, b: usize) {
    let [next] = node.later.as_slice() else { return };
    let (lines, x): (Matrix<S>, _) = (load(&panel[side..]), &later[next.first..][..S]);
    for c in b..S {
        for k in a..S {
            y[k] = minus_product(y[k], lines[c][k], x[c]);
        }
    }
}

/// y := L⁻¹ y.
#[inline(always)]
fn solve_lower<const S: usize>(d: &Matrix<S>, y: &mut [f64; S]) {
    for k in 0..S {
        for i in k + 1..S {
            y[i] = minus_product(y[i], d[k][i], y[k]);
        }
    }
}

impl<const S: usize> NodeKernel for Link<S> {
    #[inline(always)]
    fn eliminate(node: &Node, state: &mut State<'_>) -> Result<f64, Cancelled> {
        let worst = match node.shape {
            Shape::Outer => Self::eliminate_from(node, state, 0, 1),
            Shape::Inner => Self::eliminate_from(node, state, 1, 0),
            _ => Self::eliminate_from(node, state, 0, 0),
        };
        worst.map_or_else(|| eliminate_with_interchanges::<Fixed<S>>(node, state), Ok)
    }

    #[inline(always)]
    fn forward(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]) {
        match node.shape {
            _ if swaps[node.first] != IN_ORDER => Pivoting::<S>::forward(node, values, swaps, x),
            Shape::Outer => Self::forward_from(node, values, x, 0, 1),
            Shape::Inner => Self::forward_from(node, values, x, 1, 0),
            _ => Self::forward_from(node, values, x, 0, 0),
        }
    }

    // Interchanges mix the rows of U, so rows that were zero may fill; columns that were zero stay zero.

    #[inline(always)]
    fn backward(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]) {
        match node.shape {
            Shape::Outer => Self::backward_from(node, values, x, 0, 1),
            Shape::Inner if swaps[node.first] == IN_ORDER => Self::backward_from(node, values, x, 1, 0),
            _ => Self::backward_from(node, values, x, 0, 0),
        }
    }

    #[inline(always)]
    fn forward_transposed(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]) {
        match node.shape {
            Shape::Outer => Self::forward_transposed_from(node, values, x, 0, 1),
            Shape::Inner if swaps[node.first] == IN_ORDER => Self::forward_transposed_from(node, values, x, 1, 0),
            _ => Self::forward_transposed_from(node, values, x, 0, 0),
        }
    }

    #[inline(always)]
    fn backward_transposed(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]) {
        match node.shape {
            _ if swaps[node.first] != IN_ORDER => Pivoting::<S>::backward_transposed(node, values, swaps, x),
            Shape::Outer => Self::backward_transposed_from(node, values, x, 0, 1),
            Shape::Inner => Self::backward_transposed_from(node, values, x, 1, 0),
            _ => Self::backward_transposed_from(node, values, x, 0, 0),
        }
    }
}
