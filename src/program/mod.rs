//! From a formula to a program: a small compiler for user-defined elements.
//!
//! 1. **Record** ([`symbol`]): the formula is evaluated once on [`Symbol`]s, which record every operation in a [`Graph`].
//! 2. **Differentiate** ([`differentiate`]): its derivatives become more nodes of the graph, by the chain rule.
//! 3. **Simplify** ([`simplify`]): every node when it is created. Equal nodes are merged, constants are folded, zeros vanish. Once all nodes are known,
//!    products share their factors ([`factors`]).
//! 4. **Schedule** ([`schedule`]): the required nodes become a list of instructions on few registers, a [`Program`].
//! 5. **Run** ([`program`], [`kernel`], [`lanes`]): the program runs for several elements side by side.
//!
//! Every program is compared with num-dual on the plain formula.

mod canonical;
mod conditions;
mod dependence;
mod differentiate;
mod evaluate;
mod expression;
mod factors;
mod function;
mod graph;
mod kernel;
mod kinks;
mod lanes;
mod places;
#[expect(clippy::module_inception, reason = "the result has the name of the room")]
mod program;
mod registers;
mod schedule;
mod simplify;
mod symbol;
mod template;
mod text;

pub(crate) use expression::{Expression, Node};
pub(crate) use function::Function;
pub(crate) use graph::Graph;
pub(crate) use kernel::Kernel;
pub(crate) use lanes::Lanes;
pub(crate) use places::Places;
pub(crate) use program::Program;
pub(crate) use symbol::{Obstacle, Symbol, record, record_branch};
pub(crate) use template::Template;
