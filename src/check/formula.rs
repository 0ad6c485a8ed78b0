//! Functions whose Jacobians are checked: [`Function`] for the user's, and those formed from the functions of an element.

use num_dual::{Dual, Dual64, DualNum};
use std::rc::Rc;

use super::point::{Part, Places};
use crate::number::Real;
use crate::program::{Graph, Node, Symbol, record_branch};
use crate::{Cx, Scalar};

/// A vector function y = f(x), generic over the number type.
pub trait Function {
    /// f(x).
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S>;
}

/// A vector function on the number types of the references; it may contain derivatives itself.
pub(crate) trait Formula {
    fn value<R: Real>(&self, x: &[R]) -> Vec<R>;

    /// The function from which this one is formed by arithmetic and differentiation, evaluated with symbols.
    fn symbols(&self, x: &[Symbol]) -> Vec<Symbol>;

    /// s f(x), where s = 1 is the last argument: the derivatives by x are those of f, and the derivative by s is f itself.
    fn times_last<R: Real>(&self, x: &[R]) -> Vec<R> {
        let Some((&s, x)) = x.split_last() else { return Vec::new() };
        self.value(x).into_iter().map(|y| y * s).collect()
    }

    /// The nodes of f, formed from the recorded results of its function. `None` if f cannot be recorded.
    fn nodes(&self, _graph: &mut Graph, _made_of: Vec<Node>) -> Option<Vec<Node>> {
        None
    }
}

/// The product of a formula and its last argument, for any number type: its values, and its directional derivatives by two reference methods.
pub(crate) trait Differentiable {
    fn real(&self, x: &[f64]) -> Vec<f64>;
    /// The values, and their derivatives along a direction by dual numbers.
    fn by_dual(&self, x: &[f64], direction: &[f64]) -> (Vec<f64>, Vec<f64>);
    fn by_complex_step(&self, x: &[f64], direction: &[f64]) -> Vec<f64>;
    /// Graph of the formula without its last argument, and the nodes of its results. `None` if it cannot be recorded.
    fn derived_graph(&self, x: &[f64]) -> Option<(Graph, Vec<Node>)>;
    /// Graph and results of the function underlying the formula, recorded at a point; fixed arguments are constants. `None` if it panics.
    fn recorded(&self, x: &[f64], is_fixed: &[bool]) -> Option<(Graph, Vec<Node>)>;
}

impl<F: Formula> Differentiable for F {
    fn real(&self, x: &[f64]) -> Vec<f64> {
        self.times_last(x)
    }

    fn by_dual(&self, x: &[f64], direction: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let x: Vec<Dual64> = x.iter().zip(direction).map(|(&x, &d)| Dual64::new(x, d)).collect();
        self.times_last(&x).iter().map(|y| (y.re, y.eps)).unzip()
    }

    fn by_complex_step(&self, x: &[f64], direction: &[f64]) -> Vec<f64> {
        // Far below rounding, and far above underflow even for coordinates of size 1e±6.
        const STEP: f64 = 1e-40;
        let x: Vec<Cx> = x.iter().zip(direction).map(|(&x, &d)| Cx::new(x, d * STEP)).collect();
        self.times_last(&x).iter().map(|y| y.0.im / STEP).collect()
    }

    fn derived_graph(&self, x: &[f64]) -> Option<(Graph, Vec<Node>)> {
        let (mut graph, made_of) = self.recorded(x, &vec![false; x.len()])?;
        let results = self.nodes(&mut graph, made_of)?;
        Some((graph, results))
    }

    fn recorded(&self, x: &[f64], is_fixed: &[bool]) -> Option<(Graph, Vec<Node>)> {
        let (graph, results) = record_branch(|put| {
            let symbol = |(k, &x): (usize, &f64)| if is_fixed[k] { Symbol::from(x) } else { Symbol::input(k, x) };
            // The last argument is the factor of all values.
            let x: Vec<Symbol> = x[..x.len() - 1].iter().enumerate().map(symbol).collect();
            self.symbols(&x).into_iter().for_each(put);
        })?;
        Some(graph.without_signs(&results))
    }
}

/// The quantity formed from a function f before it is differentiated.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Derived {
    /// The arguments that contribute to the rate: q contributes f_q v, and t contributes f_t; if the list is empty, f itself is used.
    pub rate: &'static [Part],
    /// The argument x if the quantity is the gradient (σᵀ y)_x, with y = f or the rate of f; y is a scalar if there are no equations.
    pub gradient: Option<Part>,
}

impl<F: Function> Formula for &F {
    fn value<R: Real>(&self, x: &[R]) -> Vec<R> {
        Function::value(*self, x)
    }

    fn nodes(&self, _: &mut Graph, made_of: Vec<Node>) -> Option<Vec<Node>> {
        Some(made_of)
    }

    fn symbols(&self, x: &[Symbol]) -> Vec<Symbol> {
        Function::value(*self, x)
    }
}

/// A function of an element's arguments, and the quantity formed from it.
pub(crate) struct Made<F> {
    pub function: Rc<F>,
    pub places: Places,
    pub derived: Derived,
}

impl<F: Function> Formula for Made<F> {
    fn symbols(&self, x: &[Symbol]) -> Vec<Symbol> {
        self.function.value(x)
    }

    fn value<R: Real>(&self, x: &[R]) -> Vec<R> {
        let Some(by) = self.derived.gradient else { return self.rate(x) };
        let mut lifted: Vec<Dual<R>> = x.iter().map(|&x| Dual::new(x, R::zero())).collect();
        let component = |i: usize| {
            lifted[i].eps = R::one();
            let slopes = self.rate(&lifted);
            lifted[i].eps = R::zero();
            self.times_sigma(slopes.into_iter().map(|y| y.eps), x)
        };
        self.places.of(by).map(component).collect()
    }

    fn nodes(&self, graph: &mut Graph, mut results: Vec<Node>) -> Option<Vec<Node>> {
        if !self.derived.rate.is_empty() {
            let (v, mut tangents) = (self.places.of(Part::V).start, Vec::new());
            for &part in self.derived.rate {
                for (k, i) in self.places.of(part).enumerate() {
                    let slope = if part == Part::Q { graph.input(v + k) } else { graph.constant(1.0) };
                    tangents.push((graph.input(i), slope));
                }
            }
            results = graph.forward(&results, &tangents);
        }
        if let Some(by) = self.derived.gradient {
            let one = graph.constant(1.0);
            let mut inputs = |part| self.places.of(part).map(|i| graph.input(i)).collect::<Vec<Node>>();
            let (weights, by) = (if self.places.m == 0 { vec![one] } else { inputs(Part::Sigma) }, inputs(by));
            let weighted: Vec<(Node, Node)> = results.into_iter().zip(weights).collect();
            results = graph.reverse(&weighted, &by);
        }
        Some(results)
    }
}

impl<F: Function> Made<F> {
    /// f, or the ε-part of f(q + ε v, t + ε).
    fn rate<D: DualNum<Primitive = f64> + Copy>(&self, x: &[D]) -> Vec<D> {
        if self.derived.rate.is_empty() {
            return self.function.value(x);
        }
        let v = self.places.of(Part::V).start;
        let mut lifted: Vec<Dual<D>> = x.iter().map(|&x| Dual::new(x, D::zero())).collect();
        for &part in self.derived.rate {
            for (k, i) in self.places.of(part).enumerate() {
                lifted[i].eps = if part == Part::Q { x[v + k] } else { D::one() };
            }
        }
        self.function.value(&lifted).iter().map(|y| y.eps).collect()
    }

    /// σᵀ y, or y itself if there are no equations.
    fn times_sigma<R: Real>(&self, mut y: impl Iterator<Item = R>, x: &[R]) -> R {
        match self.places.m {
            0 => y.next().unwrap_or(R::zero()),
            _ => y.zip(&x[self.places.of(Part::Sigma)]).fold(R::zero(), |sum, (y, &sigma)| sum + y * sigma),
        }
    }
}
