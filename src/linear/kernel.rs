//! The kernels: operations on consecutive nodes of one kind, chosen by the size of the nodes and their coupling.

use super::link::Link;
use super::lu::Cancelled;
use super::node::{Node, Shape};
use super::node_kernel::{NodeKernel, State};
use super::size::{Fixed, Free};
use crate::number::larger;
use std::fmt::Debug;
use std::marker::PhantomData;

/// The right-hand side that is solved for, in place, together with a factorisation.
#[derive(Debug)]
pub(crate) enum RightSide<'a> {
    None,
    /// r of S x = r.
    Of(&'a mut [f64]),
    /// r of Sᵀ x = r.
    OfTransposed(&'a mut [f64]),
}

/// The operations on consecutive nodes of one kind, with one virtual call for all of them.
pub(super) trait Kernel: Debug + Sync {
    /// Eliminates node after node, also in the right-hand side; the error contains the position of a cancelled pivot.
    fn eliminate(&self, nodes: &[Node], state: &mut State<'_>, with: &mut RightSide<'_>) -> Result<f64, Cancelled>;
    fn forward(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]);
    fn backward(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]);
    fn forward_transposed(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]);
    fn backward_transposed(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]);
}

impl<K: NodeKernel> Kernel for K {
    fn eliminate(&self, nodes: &[Node], state: &mut State<'_>, with: &mut RightSide<'_>) -> Result<f64, Cancelled> {
        let mut worst = 1.0f64;
        for node in nodes {
            let at = |cancelled: Cancelled| Cancelled { column: node.first + cancelled.column, ..cancelled };
            worst = larger(worst, K::eliminate(node, state).map_err(at)?);
            match with {
                RightSide::None => {}
                RightSide::Of(x) => K::forward(node, state.values, state.swaps, x),
                RightSide::OfTransposed(x) => K::forward_transposed(node, state.values, state.swaps, x),
            }
        }
        Ok(worst)
    }

    fn forward(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]) {
        nodes.iter().for_each(|node| K::forward(node, values, swaps, x));
    }

    fn backward(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]) {
        nodes.iter().rev().for_each(|node| K::backward(node, values, swaps, x));
    }

    fn forward_transposed(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]) {
        nodes.iter().for_each(|node| K::forward_transposed(node, values, swaps, x));
    }

    fn backward_transposed(&self, nodes: &[Node], values: &[f64], swaps: &[usize], x: &mut [f64]) {
        nodes.iter().rev().for_each(|node| K::backward_transposed(node, values, swaps, x));
    }
}

/// The kernel for a node.
pub(super) fn kernel(node: &Node) -> &'static dyn Kernel {
    let linked = node.shape != Shape::Any;
    match node.size {
        _ if node.chosen > 0 => &PhantomData::<Free>,
        1 if linked => &Link::<1>,
        2 if linked => &Link::<2>,
        3 if linked => &Link::<3>,
        1 => &PhantomData::<Fixed<1>>,
        2 => &PhantomData::<Fixed<2>>,
        3 => &PhantomData::<Fixed<3>>,
        4 => &PhantomData::<Fixed<4>>,
        5 => &PhantomData::<Fixed<5>>,
        6 => &PhantomData::<Fixed<6>>,
        7 => &PhantomData::<Fixed<7>>,
        8 => &PhantomData::<Fixed<8>>,
        _ => &PhantomData::<Free>,
    }
}
