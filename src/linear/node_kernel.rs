//! The arithmetic on the panel of one node, compiled separately for each of the small sizes.
//!
//! With P D = L_D U_D, the elimination replaces U by L_D⁻¹P U and L by L U_D⁻¹, and subtracts the
//! products of their lines from the later panels.

use super::lu::{self, Cancelled, Interchanges};
use super::node::{Later, Node, Pair};
use super::products::{minus_dot, subtract, subtract_products};
use super::size::Size;
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::Range;

/// The parts of the numerical state that a kernel changes.
#[derive(Debug)]
pub(super) struct State<'a> {
    /// All panels.
    pub(super) values: &'a mut [f64],
    /// Row interchanges, by position.
    pub(super) swaps: &'a mut [usize],
    /// Magnitudes added to the diagonal entries, by position.
    pub(super) scale: &'a mut [f64],
}

/// The operations on one node, compiled for each of the sizes.
pub(super) trait NodeKernel: Debug + Sync {
    /// Factorises the panel, updates the later ones and returns the worst ratio of `lu::factor`.
    fn eliminate(node: &Node, state: &mut State<'_>) -> Result<f64, Cancelled>;
    /// x_a := L_D⁻¹P x_a, then x_b −= L_b x_a.
    fn forward(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]);
    /// x_a := U_D⁻¹ (x_a − U x_later).
    fn backward(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]);
    /// x_a := U_D⁻ᵀ x_a, then x_b −= U_bᵀ x_a.
    fn forward_transposed(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]);
    /// x_a := PᵀL_D⁻ᵀ (x_a − Lᵀ x_later).
    fn backward_transposed(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]);
}

/// Eliminates a node, with or without interchanges of rows. After an error without them, a panel of fixed size is unchanged.
#[inline(always)]
fn eliminate<N: Size>(node: &Node, state: &mut State<'_>, interchanges: Interchanges) -> Result<f64, Cancelled> {
    let n = N::new(node.size);
    let s = n.get();
    let (panel, rest) = state.values[node.start..].split_at_mut(node.panel_len());
    let (d, sides) = panel.split_at_mut(s * s);
    let (u, l) = sides.split_at_mut(s * node.width);
    let swaps = &mut state.swaps[node.first..][..s];
    let (own, scale) = state.scale[node.first..].split_at_mut(s);

    let worst = n.on_square(d, |d| {
        let worst = lu::factor(n, &mut lu::Rows { d, u, swaps, scale: own, interchanges, mixed: 0..0 })?;
        for column in u.chunks_exact_mut(s) {
            n.on_vector(column, |y| lu::solve_lower(n, d, y));
        }
        for row in l.chunks_exact_mut(s) {
            n.on_vector(row, |y| lu::solve_upper_transposed(n, d, y));
        }
        Ok(worst)
    })?;
    for b in &node.later {
        update(n, b, lines(n, u, &b.lines), lines(n, l, &b.lines), rest, scale);
    }
    for Pair { b, c, upper, lower } in &node.pairs {
        subtract_products(s, &mut rest[*upper..], lines(n, u, c), lines(n, l, b));
        subtract_products(s, &mut rest[*lower..], lines(n, l, c), lines(n, u, b));
    }
    Ok(worst)
}

/// Kept out of line, because most nodes need no interchanges.
#[cold]
#[inline(never)]
pub(super) fn eliminate_with_interchanges<N: Size>(node: &Node, state: &mut State<'_>) -> Result<f64, Cancelled> {
    eliminate::<N>(node, state, Interchanges::IfNeeded { first: node.chosen })
}

impl<N: Size> NodeKernel for PhantomData<N> {
    fn eliminate(node: &Node, state: &mut State<'_>) -> Result<f64, Cancelled> {
        match N::FIXED {
            true => {
                eliminate::<N>(node, state, Interchanges::Never).or_else(|_| eliminate_with_interchanges::<N>(node, state))
            }
            false => eliminate::<N>(node, state, Interchanges::IfNeeded { first: node.chosen }),
        }
    }

    fn forward(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]) {
        let n = N::new(node.size);
        let (d, _, l) = parts(n, node, values);
        let (own, rest) = x[node.first..].split_at_mut(n.get());
        lu::permute(&swaps[node.first..][..n.get()], own);
        n.on_vector(own, |own| {
            lu::solve_lower(n, d, own);
            scatter(n, node, l, own, rest);
        });
    }

    fn backward(node: &Node, values: &[f64], _: &[usize], x: &mut [f64]) {
        let n = N::new(node.size);
        let (d, u, _) = parts(n, node, values);
        let (own, rest) = x[node.first..].split_at_mut(n.get());
        n.on_vector(own, |own| {
            gather(n, node, u, own, rest);
            lu::solve_upper(n, d, own);
        });
    }

    fn forward_transposed(node: &Node, values: &[f64], _: &[usize], x: &mut [f64]) {
        let n = N::new(node.size);
        let (d, u, _) = parts(n, node, values);
        let (own, rest) = x[node.first..].split_at_mut(n.get());
        n.on_vector(own, |own| {
            lu::solve_upper_transposed(n, d, own);
            scatter(n, node, u, own, rest);
        });
    }

    fn backward_transposed(node: &Node, values: &[f64], swaps: &[usize], x: &mut [f64]) {
        let n = N::new(node.size);
        let (d, _, l) = parts(n, node, values);
        let (own, rest) = x[node.first..].split_at_mut(n.get());
        n.on_vector(own, |own| {
            gather(n, node, l, own, rest);
            lu::solve_lower_transposed(n, d, own);
        });
        lu::permute_back(&swaps[node.first..][..n.get()], own);
    }
}

/// Subtracts the products of the lines of a later neighbour from its D and sums up their magnitudes.
#[inline(always)]
fn update<N: Size>(n: N, b: &Later, u: &[f64], l: &[f64], rest: &mut [f64], scale: &mut [f64]) {
    let s = n.get();
    if b.lines.len() == s {
        n.subtract_products(&mut rest[b.diagonal..], u, l);
    } else {
        subtract_products(s, &mut rest[b.diagonal..], u, l);
    }
    let pairs = u.chunks_exact(s).zip(l.chunks_exact(s));
    for (scale, (u, l)) in scale[b.first..].iter_mut().zip(pairs) {
        *scale += u.iter().zip(l).map(|(u, l)| (u * l).abs()).sum::<f64>();
    }
}

/// D, U and L of a node.
#[inline(always)]
fn parts<'a, N: Size>(n: N, node: &Node, values: &'a [f64]) -> (&'a [f64], &'a [f64], &'a [f64]) {
    let s = n.get();
    let (d, sides) = values[node.start..][..node.panel_len()].split_at(s * s);
    let (u, l) = sides.split_at(s * node.width);
    (d, u, l)
}

/// The given columns of U or rows of L.
#[inline(always)]
fn lines<'a, N: Size>(n: N, side: &'a [f64], lines: &Range<usize>) -> &'a [f64] {
    &side[lines.start * n.get()..lines.end * n.get()]
}

/// x_b −= (lines of b)·x_a for all later neighbours b.
#[inline(always)]
fn scatter<N: Size>(n: N, node: &Node, side: &[f64], own: &[f64], rest: &mut [f64]) {
    for b in &node.later {
        let lines = lines(n, side, &b.lines).chunks_exact(n.get());
        for (x, line) in rest[b.first..].iter_mut().zip(lines) {
            *x = minus_dot(*x, line, own);
        }
    }
}

/// x_a −= (lines of b)ᵀ·x_b for all later neighbours b.
#[inline(always)]
fn gather<N: Size>(n: N, node: &Node, side: &[f64], own: &mut [f64], rest: &[f64]) {
    for b in node.later.iter().rev() {
        let lines = lines(n, side, &b.lines).chunks_exact(n.get());
        for (&x, line) in rest[b.first..][..b.lines.len()].iter().zip(lines).rev() {
            subtract(x, line, own);
        }
    }
}
