//! From a formula to a program: a small compiler for what a researcher wrote as an element.
//!
//! 1. **Record** ([`symbol`]): the formula is evaluated once on [`Symbol`]s, which note every operation in a [`Graph`].
//! 2. **Differentiate** ([`differentiate`]): its derivatives become more nodes of the graph, by the chain rule.
//! 3. **Simplify** ([`graph`]): every node as it is made. Equal nodes are one, constants are folded, zeros vanish. When all are known, products share
//!    their factors ([`factors`]).
//! 4. **Schedule** ([`schedule`]): the nodes that are needed become a list of instructions on few registers, a [`Program`].
//! 5. **Run** ([`program`], [`kernel`], [`lanes`]): for several elements side by side.
//!
//! num-dual on the plain formula is what every program is compared with.

mod conditions;
mod dependence;
mod differentiate;
mod evaluate;
mod expression;
mod factors;
mod function;
mod graph;
mod kernel;
mod lanes;
mod places;
#[expect(clippy::module_inception, reason = "the result has the name of the room")]
mod program;
mod registers;
mod schedule;
mod symbol;
mod template;

pub(crate) use expression::{Expression, Node};
pub(crate) use function::Function;
pub(crate) use graph::Graph;
pub(crate) use kernel::Kernel;
pub(crate) use lanes::Lanes;
pub(crate) use places::Places;
pub(crate) use program::Program;
pub(crate) use symbol::{Obstacle, Symbol, record, record_branch};
pub(crate) use template::Template;
