//! [`Placed`]: a formula in a scene, an element or a cost: how it is recorded, and what it depends on.

use std::sync::Arc;

use super::connections::Connections;
use super::on_numbers::{Read, Recordable};
use super::shape::{Argument, Shape, Slot, distinct};
use super::view::NodeView;
use crate::number::{Fingerprint, guarded};
use crate::program::{Obstacle, Symbol, Template, record, record_branch};

/// A formula and the arguments it is connected to.
pub struct Placed<F: ?Sized> {
    pub name: String,
    pub formula: Arc<F>,
    pub shape: Shape,
    pub to: Connections,
    /// The arguments that the formula may read, without constants.
    pub slots: Vec<Slot>,
    /// Whether it depends on each of them, if anything was concluded from its graph.
    pub depends: Option<Vec<bool>>,
    /// True if the formula is a graph, which is the same in every run.
    pub is_graph: bool,
}

impl<F: ?Sized> Clone for Placed<F> {
    fn clone(&self) -> Self {
        let Placed { name, formula, shape, to, slots, depends, is_graph } = self;
        let (name, formula, to) = (name.clone(), formula.clone(), to.clone());
        Placed { name, formula, shape: *shape, to, slots: slots.clone(), depends: depends.clone(), is_graph: *is_graph }
    }
}

/// Trial values of an argument, used to find out whether it causes a value that is not finite.
const OTHERS: [f64; 6] = [0.5, 1.0, 2.0, -0.5, 1e3, -1e3];

impl<F: Recordable + ?Sized> Placed<F> {
    /// The graph of the formula, and the numbers in it that like formulas need not share.
    pub fn record(&self, at: &NodeView<f64>) -> Result<(Template, Vec<f64>), Obstacle> {
        let (graph, results) = record(|put| self.put_symbols(&|slot| self.to.read(at, slot), put))?;
        Ok(Template::new(&graph, &results, self.shape.p))
    }

    /// As [`record`](Self::record), but of the branch that the formula takes at a state; `None` if it panics.
    pub fn record_branch(&self, at: &NodeView<f64>) -> Option<(Template, Vec<f64>)> {
        let (graph, results) = record_branch(|put| self.put_symbols(&|slot| self.to.read(at, slot), put))?;
        Some(Template::new(&graph, &results, self.shape.p))
    }

    /// Evaluates the formula on symbols with these values.
    pub fn put_symbols(&self, value: Read<f64>, put: &mut dyn FnMut(Symbol)) {
        let symbol = |slot: Slot| {
            let value = value(slot);
            match slot {
                // A constant that is always 0 or ±1 simplifies the formula; a design variable may have any value in the next run.
                Slot::B(p) => match self.to.b[p].constant() {
                    Some(value) if value == 0.0 || value.abs() == 1.0 => Symbol::from(value),
                    _ => Symbol::parameter(p, value),
                },
                _ => Symbol::input(self.shape.number(slot), value),
            }
        };
        self.formula.values(&symbol, put);
    }

    /// Whether a recorded formula depends on each argument that it may read.
    pub fn depends(&self, template: &Template) -> Vec<bool> {
        let all = template.depends(self.shape.c());
        self.slots.iter().map(|slot| all[self.shape.number(*slot)]).collect()
    }

    /// The arguments of a derivative: those that the formula depends on, then the constants that are bound.
    pub fn variables(&self, depends: &[bool]) -> Vec<Slot> {
        let slots = self.slots.iter().zip(depends).filter(|(_, depends)| **depends).map(|(slot, _)| *slot);
        slots.chain(self.bound()).collect()
    }

    /// The constants that are bound to design variables.
    fn bound(&self) -> impl Iterator<Item = Slot> {
        (0..self.shape.p).filter(|&p| self.to.b[p].bound().is_some()).map(Slot::B)
    }

    /// The controls, time, and the constants that are bound.
    pub fn inputs(&self) -> impl Iterator<Item = Slot> {
        (0..self.shape.k).map(Slot::U).chain([Slot::T]).chain(self.bound())
    }

    /// Whether the formula depends on time, unless its graph says that it does not.
    pub fn is_timed(&self) -> bool {
        let Some(depends) = &self.depends else { return true };
        self.slots.iter().zip(depends).any(|(slot, depends)| *slot == Slot::T && *depends)
    }

    /// All variables of the formula at a state, as far as is known.
    fn variables_now(&self, at: &NodeView<f64>) -> Vec<Slot> {
        let template = self.record(at).ok().or_else(|| self.record_branch(at));
        let depends = template.map_or_else(|| vec![true; self.slots.len()], |(template, _)| self.depends(&template));
        self.variables(&depends)
    }

    /// All variables of the formula at a state in the numbering of the scene, as far as is known.
    pub fn arguments(&self, at: &NodeView<f64>) -> Vec<Argument> {
        self.variables_now(at).into_iter().map(|slot| self.to.argument(slot).0).collect()
    }

    /// The arguments that cause the formula not to be finite: those for which some trial value makes it finite, or all if there are none. `None` if it is
    /// finite.
    pub fn to_blame(&self, at: &NodeView<f64>, is_finite: impl Fn(Read<f64>) -> bool) -> Option<Vec<Argument>> {
        let read = |slot: Slot| self.to.read(at, slot);
        if is_finite(&read) {
            return None;
        }
        let all = self.variables_now(at);
        let with = |slot: Slot, x: f64| is_finite(&|other| if other == slot { x } else { read(other) });
        let is_to_blame = |slot: &Slot| OTHERS.iter().any(|&other| with(*slot, other));
        let found: Vec<Slot> = all.iter().copied().filter(is_to_blame).collect();
        let found = if found.is_empty() { all } else { found };
        Some(distinct(found.into_iter().map(|slot| self.to.argument(slot).0).collect()))
    }

    /// True if the formula panics at a state.
    pub fn panics(&self, at: &NodeView<f64>) -> bool {
        guarded(|| self.formula.values(&|slot| self.to.read(at, slot), &mut |_: f64| ())).is_none()
    }

    /// Appends the fingerprint of the formula if anything was concluded from its graph, and if it may differ from run to run.
    pub fn fingerprint(&self, sum: &mut Fingerprint) {
        if self.depends.is_some() && !self.is_graph {
            let input = |slot: Slot| Fingerprint::input(self.shape.number(slot));
            self.formula.values(&input, &mut |value: Fingerprint| sum.join(value));
        }
    }
}
