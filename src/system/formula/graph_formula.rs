//! [`GraphFormula`]: a formula that is a graph, as it is read from a file.

use super::applied::{Applied, ForceFormula};
use super::energy::{Kinetic, KineticFormula, Potential, PotentialFormula};
use super::holonomic::{ConstraintFormula, Holonomic};
use super::kind::ElementKind;
use super::on_numbers::{AnyElement, Read, Recordable, SEEDS, Values, with_copies};
use super::placed::Placed;
use super::shape::{Place, Shape, Slot};
use crate::Scalar;
use crate::program::{Expression, Graph, Node, Obstacle, Symbol, Template, record};
use std::sync::Arc;

/// A formula as a graph. Inputs have the numbers that the shape gives them, and parameters those of the constants.
pub struct GraphFormula {
    graph: Graph,
    results: Vec<Node>,
    shape: Shape,
}

impl GraphFormula {
    /// Records a formula whose arguments are symbols; `first` are created before all others.
    pub fn record(
        shape: Shape,
        first: &[Slot],
        formula: impl FnOnce(&dyn Fn(Slot) -> Symbol, &mut dyn FnMut(Symbol)),
    ) -> Result<Self, Obstacle> {
        let symbol = |slot: Slot| match slot {
            Slot::B(p) => Symbol::parameter(p, 1.0),
            _ => Symbol::input(shape.number(slot), 0.5),
        };
        let (graph, results) = record(|put| {
            first.iter().for_each(|slot| _ = symbol(*slot));
            formula(&symbol, put);
        })?;
        let (graph, results) = graph.tidied(&results);
        Ok(GraphFormula { graph, results, shape })
    }

    pub fn graph(&self) -> (&Graph, &[Node]) {
        (&self.graph, &self.results)
    }

    /// The argument that an input or a parameter of the graph is.
    pub fn slot(&self, of: Expression) -> Option<Slot> {
        match of {
            Expression::Parameter(p) => Some(Slot::B(p as usize)),
            Expression::Input(which) => match self.shape.place(which as usize) {
                Place::Of(slot) => Some(slot),
                _ => None,
            },
            _ => None,
        }
    }

    /// The arguments on which the results depend, in the order of their nodes.
    pub fn arguments(&self) -> Vec<Slot> {
        let nodes = self.graph.reachable(self.results.iter().copied());
        nodes.into_iter().filter_map(|node| self.slot(self.graph.expression(node))).collect()
    }

    /// The element of this formula; the shape is that of the formula.
    pub fn element(self, kind: ElementKind) -> Arc<dyn AnyElement> {
        let Shape { n, m, k, p } = self.shape;
        match kind {
            ElementKind::Kinetic => Arc::new(Kinetic::<_, SEEDS> { energy: self, n, p }),
            ElementKind::Potential => Arc::new(Potential::<_, SEEDS> { energy: self, n, p }),
            ElementKind::Applied => Arc::new(Applied::<_, SEEDS> { force: self, n, k, p }),
            ElementKind::Holonomic => Arc::new(Holonomic::<_, SEEDS> { constraint: self, n, m, p }),
        }
    }

    fn first<S: Scalar>(&self, read: Read<S>) -> S {
        // Without a zero to begin with, which would be recorded as a part of the formula.
        let mut first = None;
        self.values(read, &mut |value| first = first.or(Some(value)));
        first.unwrap_or_else(S::zero)
    }
}

impl<S: Scalar> Values<S> for GraphFormula {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let value = |expression: Expression, values: &[S]| {
            let at = |node: Node| values[node.index()];
            match (self.slot(expression), expression) {
                (Some(slot), _) => read(slot),
                // Reading the value of an exponent would be a branch.
                (_, Expression::Power(x, n)) => at(x).powf(self.graph.value(n).unwrap_or(f64::NAN)),
                _ => expression.value(at, &[], &[]),
            }
        };
        let Some(first) = self.graph.expressions().next() else { return };
        // Zeros would be recorded as a part of the formula.
        with_copies(value(first, &[]), self.graph.len(), &mut |values: &mut [S]| {
            for (k, expression) in self.graph.expressions().enumerate().skip(1) {
                values[k] = value(expression, values);
            }
            self.results.iter().for_each(|node| put(values[node.index()]));
        });
    }
}

impl KineticFormula for GraphFormula {
    fn kinetic_energy<S: Scalar>(&self, _: Shape, read: Read<S>) -> S {
        self.first(read)
    }
}

impl PotentialFormula for GraphFormula {
    fn potential_energy<S: Scalar>(&self, _: Shape, read: Read<S>) -> S {
        self.first(read)
    }
}

impl ForceFormula for GraphFormula {
    fn force<S: Scalar>(&self, _: Shape, read: Read<S>, put: &mut dyn FnMut(S)) {
        self.values(read, put);
    }
}

impl ConstraintFormula for GraphFormula {
    fn phi<S: Scalar>(&self, _: Shape, read: Read<S>, put: &mut dyn FnMut(S)) {
        self.values(read, put);
    }
}

impl<F: Recordable + ?Sized> Placed<F> {
    /// The formula as a graph, in which constants that are numbers remain constants of the element if `keeps_constants`; otherwise they may simplify it.
    pub fn as_graph(&self, keeps_constants: bool) -> Result<GraphFormula, Obstacle> {
        GraphFormula::record(self.shape, &[], |symbol, put| {
            let number = |slot: Slot| match slot {
                Slot::B(p) if !keeps_constants => self.to.b[p].constant(),
                _ => None,
            };
            self.formula.values(&|slot| number(slot).map_or_else(|| symbol(slot), Symbol::from), put);
        })
    }

    /// Another formula with the same arguments.
    pub fn with(&self, formula: GraphFormula) -> Placed<GraphFormula> {
        let Placed { name, shape, to, slots, .. } = self;
        let (name, to, slots) = (name.clone(), to.clone(), slots.clone());
        Placed { name, formula: Arc::new(formula), shape: *shape, to, slots, depends: None, is_graph: true }
    }

    /// What the library compiles: the graph of the formula, and the numbers in it that like formulas need not share.
    pub fn template(&self) -> Result<(Template, Vec<f64>), Obstacle> {
        let value = |slot: Slot| match slot {
            Slot::B(p) => self.to.b[p].constant().unwrap_or(1.0),
            _ => 0.5,
        };
        let (graph, results) = record(|put| self.put_symbols(&value, put))?;
        Ok(Template::new(&graph, &results, self.shape.p))
    }
}
