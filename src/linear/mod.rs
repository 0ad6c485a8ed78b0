//! Direct solution of a sequence of sparse systems K x = r and Kᵀ x = r with one fixed pattern.
//!
//! K is structurally symmetric, numerically unsymmetric, and may have structurally zero diagonal
//! entries, like a saddle point matrix [A Bᵀ; B 0]. The work falls into three parts:
//!
//! * [`Symbolic`], once per [`Pattern`]: which constant unknowns are condensed, the order in which the
//!   groups of the others are eliminated, and where every entry is stored;
//! * [`Matrix::set_constant`], once per set of constant values: the elimination of the condensed unknowns;
//! * [`Factorization::factor`], at every iteration: the factorisation of the remaining part. [`BlockLu`] does it node by node; it can be replaced.
//!
//! Rows are interchanged only within a node, so the diagonal block of every node must be regular when
//! the node is eliminated; callers ensure this with [`Group::after`].

mod block_lu;
mod condense;
mod constant;
mod eigen;
mod equilibrate;
mod factorization;
mod fill;
mod gmres;
mod graph;
mod kernel;
mod link;
mod lu;
mod matrix;
mod node;
mod node_kernel;
mod order;
mod pattern;
mod products;
mod size;
mod symbolic;
mod waiting;

#[cfg(test)]
mod dense_lu;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests;

pub(crate) use block_lu::BlockLu;
#[cfg(test)]
pub(crate) use dense_lu::DenseLu;
pub(crate) use eigen::{eigen, eigenvalues};
pub(crate) use equilibrate::equilibrate;
pub(crate) use factorization::{Breakdown, Factorization};
pub(crate) use gmres::gmres;
pub(crate) use matrix::Matrix;
pub(crate) use pattern::{Branch, Group, Pattern};
pub(crate) use symbolic::Symbolic;
