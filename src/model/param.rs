//! Physical constants of elements: numbers, multiples of a design variable, or expressions of several.

#[cfg(feature = "files")]
mod text;

use num_traits::Zero;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::handle::Expression;
use super::{Design, expressions};
use crate::number::Arithmetic;
use crate::program::{Function, Graph, Node};

/// A physical constant of an element: a number, a design variable, or an expression of design variables of the scene.
///
/// Numbers and [`Design`] handles convert into it, and arithmetic works on both: `length * 0.5`, `-length`, `m * l * l / 12.0`, `a + 0.1`,
/// `(a * a + b * b).sqrt()`. For other functions use [`Scene::parameter`](crate::Scene::parameter). dJ/db is exact for every design
/// variable used. An expression of constants is a constant and costs nothing.
///
/// ```
/// use hamiltonian_adjoint::{Scene, planar::Body};
///
/// let mut scene = Scene::new();
/// let (m, l) = (scene.design("mass", 0.4), scene.design("length", 1.0));
/// let rod = scene.body("rod", m, m * l * l / 12.0, [0.0, -0.5, 0.0]);
/// scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(0.0, l * 0.5));
/// let system = scene.compile()?;
/// assert_eq!(system.designs(), 2);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    of: Source,
    factor: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    One,
    Design(Design),
    /// A vertex of the graph of the scene's expressions.
    Expression(Expression),
    /// A component of the scene's gravity, which may be set after the bodies.
    Gravity(usize),
    /// An entry of the values of a compiled system's parameters.
    Value(usize),
    /// A combination of design variables of several scenes, or of a scene that has already been compiled.
    Foreign,
}

impl From<f64> for Param {
    fn from(value: f64) -> Self {
        Param { of: Source::One, factor: value }
    }
}

impl From<Design> for Param {
    fn from(design: Design) -> Self {
        Param { of: Source::Design(design), factor: 1.0 }
    }
}

impl Neg for Param {
    type Output = Param;
    fn neg(self) -> Param {
        Param { factor: -self.factor, ..self }
    }
}

impl Neg for Design {
    type Output = Param;
    fn neg(self) -> Param {
        -Param::from(self)
    }
}

/// An operator between numbers, design variables and parameters in every combination.
macro_rules! operators {
    ($($operator:ident $method:ident $made:ident;)*) => {$(
        operators! { $operator $method $made: Param, Param; Param, Design; Param, f64; Design, Param; Design, Design; Design, f64; f64, Param; f64, Design; }
    )*};
    ($operator:ident $method:ident $made:ident: $($left:ty, $right:ty;)*) => {$(
        impl $operator<$right> for $left {
            type Output = Param;
            fn $method(self, other: $right) -> Param {
                Param::from(self).$made(Param::from(other))
            }
        }
    )*};
}

operators! {
    Add add sum;
    Sub sub difference;
    Mul mul product;
    Div div quotient;
}

/// Functions of parameters and of design variables.
macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty)?) $number:expr, $node:expr;)*) => {
        impl Param {$(
            $(#[$doc])*
            pub fn $name(self $(, $argument: $type)?) -> Param {
                self.apply($number, $node)
            }
        )*}

        impl Design {$(
            $(#[$doc])*
            pub fn $name(self $(, $argument: $type)?) -> Param {
                Param::from(self).$name($($argument)?)
            }
        )*}
    };
}

functions! {
    /// √x.
    sqrt() f64::sqrt, |graph, x| graph.function(Function::Sqrt, x);
    /// eˣ.
    exp() f64::exp, |graph, x| graph.function(Function::Exp, x);
    /// The natural logarithm.
    ln() f64::ln, |graph, x| graph.function(Function::Ln, x);
    /// Sine.
    sin() f64::sin, |graph, x| graph.function(Function::Sin, x);
    /// Cosine.
    cos() f64::cos, |graph, x| graph.function(Function::Cos, x);
    /// Tangent.
    tan() f64::tan, |graph, x| graph.function(Function::Tan, x);
    /// Arctangent.
    atan() f64::atan, |graph, x| graph.function(Function::Atan, x);
    /// 1/x.
    recip() f64::recip, |graph, x| graph.function(Function::Reciprocal, x);
    /// xⁿ for an integer n.
    powi(n: i32) |x| x.powi(n), |graph, x| graph.integer_power(x, n);
    /// xⁿ for x ≥ 0.
    powf(n: f64) |x| x.powf(n), |graph, x| { let n = graph.constant(n); graph.power(x, n) };
}

impl Design {
    /// The angle of the point (x, y), where `self` is y.
    pub fn atan2(self, x: impl Into<Param>) -> Param {
        Param::from(self).atan2(x)
    }
}

impl Param {
    /// The angle of the point (x, y), where `self` is y.
    pub fn atan2(self, x: impl Into<Param>) -> Param {
        self.combine(x.into(), f64::atan2, Graph::atan2)
    }

    /// The value of a constant; otherwise the factor of the design variable or expression.
    pub(crate) fn factor(&self) -> f64 {
        self.factor
    }

    fn sum(self, other: Param) -> Param {
        self.combine(other, f64::add, Graph::add)
    }

    fn difference(self, other: Param) -> Param {
        self.combine(other, f64::sub, Graph::subtract)
    }

    fn product(self, other: Param) -> Param {
        match (self.constant(), other.constant()) {
            (Some(number), _) => other.scaled(number),
            (_, Some(number)) => self.scaled(number),
            _ => self.combine(other, f64::mul, Graph::multiply),
        }
    }

    fn quotient(self, other: Param) -> Param {
        match other.constant() {
            Some(number) => Param { factor: self.factor / number, ..self },
            None => self.combine(other, f64::div, Graph::divide),
        }
    }

    fn apply(self, number: impl Fn(f64) -> f64, node: impl Fn(&mut Graph, Node) -> Node) -> Param {
        match self.of {
            Source::One => Param::from(number(self.factor)),
            _ => Param::expression(&[self], &|graph, of| node(graph, of[0])),
        }
    }

    fn combine(
        self,
        other: Param,
        number: impl Fn(f64, f64) -> f64,
        node: impl Fn(&mut Graph, Node, Node) -> Node,
    ) -> Param {
        match (self.of, other.of) {
            (Source::One, Source::One) => Param::from(number(self.factor, other.factor)),
            _ => Param::expression(&[self, other], &|graph, of| node(graph, of[0], of[1])),
        }
    }

    /// The parameter that `formula` computes from other parameters.
    pub(crate) fn expression(of: &[Param], formula: &dyn Fn(&mut Graph, &[Node]) -> Node) -> Param {
        let foreign = Param { of: Source::Foreign, factor: 1.0 };
        let scenes = of.iter().map(|param| match param.of {
            Source::One => Ok(None),
            Source::Design(design) => Ok(Some(design.0.scene())),
            Source::Expression(expression) => Ok(Some(expression.scene)),
            Source::Gravity(_) | Source::Value(_) | Source::Foreign => Err(()),
        });
        let Ok(scenes) = scenes.collect::<Result<Vec<_>, ()>>() else { return foreign };
        let Some(scene) = expressions::common(scenes.into_iter().flatten()) else { return foreign };
        let noted = expressions::with(scene, |graph| {
            let of: Vec<Node> = of.iter().map(|param| param.node(graph)).collect();
            let node = formula(graph, &of);
            // A leading number becomes the factor of the parameter, as when a text is read.
            let (factor, node) = graph.number_times(node).unwrap_or((1.0, node));
            (factor, node, graph.value(node))
        });
        match noted {
            Some((factor, _, Some(number))) => Param::from(factor * number),
            Some((factor, node, None)) => Param { of: Source::Expression(Expression { scene, node }), factor },
            None => foreign,
        }
    }

    fn node(self, graph: &mut Graph) -> Node {
        let node = match self.of {
            Source::Design(design) => graph.input(design.index()),
            Source::Expression(expression) => expression.node,
            _ => graph.constant(1.0),
        };
        let factor = graph.constant(self.factor);
        graph.multiply(factor, node)
    }

    pub(crate) fn gravity(axis: usize) -> Self {
        Param { of: Source::Gravity(axis), factor: 1.0 }
    }

    /// True if all design variables and expressions in it belong to a scene with these numbers.
    pub(crate) fn belongs_to(&self, scene: &[u64]) -> bool {
        match self.of {
            Source::Design(design) => scene.contains(&design.0.scene()),
            Source::Expression(expression) => scene.contains(&expression.scene),
            Source::Foreign => false,
            Source::One | Source::Gravity(_) | Source::Value(_) => true,
        }
    }

    /// Inserts gravity, and the indices of design variables and expressions (by `place`) among the values of a compiled system.
    pub(crate) fn resolve(self, gravity: &[Param; 3], place: &mut dyn FnMut(Node) -> usize) -> Self {
        match self.of {
            Source::Gravity(axis) => gravity[axis].scaled(self.factor).resolve(&[Param::from(0.0); 3], place),
            Source::Expression(expression) => Param { of: Source::Value(place(expression.node)), ..self },
            Source::Design(design) => Param { of: Source::Value(design.index()), ..self },
            _ => self,
        }
    }

    /// The parameter times a number.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Param { factor: self.factor * factor, ..self }
    }

    /// The value of a constant; `None` if it depends on design variables.
    pub(crate) fn constant(&self) -> Option<f64> {
        match self.of {
            Source::One => Some(self.factor),
            _ => None,
        }
    }

    /// The value of a parameter of a scene, for these design variables and values of the nodes of the scene's expressions.
    pub(crate) fn present_value(&self, designs: &[f64], expressions: &[f64]) -> f64 {
        let of = match self.of {
            Source::One => 1.0,
            Source::Design(design) => designs[design.index()],
            Source::Expression(expression) => expressions[expression.node.index()],
            // A part of a scene contains none of these.
            Source::Gravity(_) | Source::Value(_) | Source::Foreign => 0.0,
        };
        self.factor * of
    }

    /// For each parameter, true if it is not a constant.
    pub(crate) fn which_are_bound(all: &[Param]) -> Vec<bool> {
        all.iter().map(|param| param.constant().is_none()).collect()
    }

    /// For a parameter that is not a constant: the index among the values of a compiled system's parameters, and the factor.
    pub(crate) fn bound(&self) -> Option<(usize, f64)> {
        match self.of {
            Source::Value(place) => Some((place, self.factor)),
            _ => None,
        }
    }

    /// The value, given the values of a compiled system's parameters.
    pub(crate) fn value<R: From<f64> + Copy + Zero + Arithmetic<f64>>(&self, parameters: &[R]) -> R {
        match self.of {
            Source::One => R::from(self.factor),
            Source::Value(place) => parameters[place] * self.factor,
            // A compiled system contains none of these.
            Source::Design(_) | Source::Expression(_) | Source::Gravity(_) | Source::Foreign => R::zero(),
        }
    }
}
