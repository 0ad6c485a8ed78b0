//! Parameters as text: `mass * length ^ 2 / 12`, where names are those of design variables.

use super::{Param, Source};
use crate::model::expressions;
use crate::program::{Expression, Function};
use crate::text::{Mistake, Name, OfTwo, Parts, Reader, Term, Text, quoted, write};

impl Param {
    /// The parameter as text; `None` if text cannot represent it.
    pub(crate) fn text(&self, designs: &[&str]) -> Option<String> {
        let times = |what: String| match self.factor {
            1.0 => what,
            -1.0 => format!("-{what}"),
            factor => format!("{factor:?} * {what}"),
        };
        match self.of {
            Source::One => Some(format!("{:?}", self.factor)),
            Source::Design(design) => Some(times(quoted(designs[design.index()])?)),
            Source::Expression(expression) => {
                let name = |input: Expression| quoted(designs.get(input.input()?)?);
                let text = expressions::with(expression.scene, |graph| {
                    let (graph, of) = graph.canonical(&[expression.node]);
                    write(&graph, &of, Parts::Long, &name)
                });
                let Text { parts, results } = text.flatten()?;
                let parts: String = parts.into_iter().map(|part| part + "; ").collect();
                Some(parts + &times(results[0].as_factor()))
            }
            Source::Gravity(_) | Source::Value(_) | Source::Foreign => None,
        }
    }

    /// Parses a parameter from text.
    ///
    /// # Errors
    /// The first mistake.
    pub(crate) fn read(text: &str, design: impl Fn(&str) -> Option<Param>) -> Result<Param, Mistake> {
        let lookup = |name: Name| match name {
            Name::Word(name) => design(name).ok_or_else(|| format!("no design variable is called `{name}`")),
            Name::Entry { list, .. } => {
                Err(format!("`{list}[…]` is not a constant; parameters depend on design variables alone"))
            }
        };
        Reader::new(&lookup).read(text)
    }
}

impl Term for Param {
    fn constant(self) -> Option<f64> {
        Param::constant(&self)
    }
    fn integer_power(self, n: i32) -> Self {
        self.powi(n)
    }
    fn power(self, n: f64) -> Self {
        self.powf(n)
    }
    fn function(self, function: Function) -> Self {
        self.apply(|x| function.value(x), |graph, x| graph.function(function, x))
    }
    fn of_two(self, function: OfTwo, other: Self) -> Self {
        self.combine(other, |x, y| function.value(x, y), |graph, x, y| function.node(graph, x, y))
    }
}
