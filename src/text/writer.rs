//! Writes graphs as text.

use std::collections::HashMap;

use super::is_word;
use crate::program::{Expression, Function, Graph, Node};

/// A longer or more deeply nested part of a formula is written once, before the formula, and referred to by its number.
const LONGEST_PART: usize = 1000;
const DEEPEST_PART: usize = 20;

/// Which nodes become parts that precede the formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Parts {
    /// Those whose text is too long or too deeply nested.
    Long,
    /// All operations and numbers, so that they are read in the order of the graph.
    All,
}

/// Precedence of the outermost operator of a text, in increasing order.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Binding {
    Sum,
    Product,
    Factor,
    Whole,
}

/// The text of a node.
#[derive(Clone)]
pub(crate) struct Written {
    text: String,
    binding: Binding,
}

impl Written {
    pub(crate) fn into_text(self) -> String {
        self.text
    }

    /// The text as a factor of a product.
    pub(crate) fn as_factor(&self) -> String {
        self.bracketed(Binding::Factor)
    }

    fn bracketed(&self, least: Binding) -> String {
        if self.binding < least { format!("({})", self.text) } else { self.text.clone() }
    }
}

/// The text of some nodes.
pub(crate) struct Text {
    pub(crate) parts: Vec<String>,
    pub(crate) results: Vec<Written>,
}

/// The text of the given nodes. `name` returns that of an input or a parameter. `None` if text cannot represent them.
pub(crate) fn write(
    graph: &Graph,
    results: &[Node],
    which: Parts,
    name: &dyn Fn(Expression) -> Option<String>,
) -> Option<Text> {
    let mut writer = Writer { graph, name, which, written: HashMap::new() };
    let mut parts = Vec::new();
    // Nodes are written before those that depend on them, without recursion, so deep formulas need no deep stack.
    for node in graph.reachable(results.iter().copied()) {
        let mut written = writer.formula(node)?;
        let is_named = matches!(graph.expression(node), Expression::Input(_) | Expression::Parameter(_));
        let is_part = match which {
            Parts::Long => written.text.len() > LONGEST_PART || deepest(&written.text) > DEEPEST_PART,
            Parts::All => !is_named,
        };
        if is_part {
            parts.push(written.text);
            written = Written { text: format!("${}", parts.len()), binding: Binding::Whole };
        }
        writer.written.insert(node, written);
    }
    let results = results.iter().map(|node| writer.written.get(node).cloned()).collect::<Option<_>>()?;
    Some(Text { parts, results })
}

struct Writer<'a> {
    graph: &'a Graph,
    name: &'a dyn Fn(Expression) -> Option<String>,
    which: Parts,
    written: HashMap<Node, Written>,
}

impl Writer<'_> {
    fn formula(&self, node: Node) -> Option<Written> {
        use Binding::{Factor, Product, Sum, Whole};
        use Expression::*;
        let call = |name: &str, x: Node, y: Node| Some(format!("{name}({}, {})", self.part(x, Sum)?, self.part(y, Sum)?));
        let (text, binding) = match self.graph.expression(node) {
            // Only formulas, which alone are written so, may contain them.
            Constant(bits) if self.which == Parts::All && !f64::from_bits(bits).is_finite() => {
                (undefined(f64::from_bits(bits)).into(), Product)
            }
            Constant(bits) if f64::from_bits(bits).is_sign_negative() => (finite(f64::from_bits(bits))?, Sum),
            Constant(bits) => (finite(f64::from_bits(bits))?, Whole),
            named @ (Input(_) | Parameter(_)) => ((self.name)(named)?, Whole),
            Add(x, y) => (format!("{} + {}", self.part(x, Sum)?, self.part(y, Product)?), Sum),
            Subtract(x, y) => (format!("{} - {}", self.part(x, Sum)?, self.part(y, Product)?), Sum),
            Multiply(x, y) => (format!("{} * {}", self.part(x, Product)?, self.part(y, Factor)?), Product),
            Divide(x, y) => (format!("{} / {}", self.part(x, Product)?, self.part(y, Factor)?), Product),
            Of(Function::Negative, x) => (format!("-{}", self.part(x, Factor)?), Sum),
            Of(Function::Reciprocal, x) => (format!("1.0 / {}", self.part(x, Factor)?), Product),
            Of(function, x) => (format!("{}({})", function.name(), self.part(x, Sum)?), Whole),
            IntegerPower(x, n) => (format!("{} ^ {n}", self.part(x, Whole)?), Factor),
            Power(x, n) => {
                let n = self.graph.value(n)?;
                match n.fract() == 0.0 {
                    // An integer after `^` would be another operation.
                    true => (format!("pow({}, {})", self.part(x, Sum)?, finite(n)?), Whole),
                    false => (format!("{} ^ {}", self.part(x, Whole)?, finite(n)?), Factor),
                }
            }
            Atan2(y, x) => (call("atan2", y, x)?, Whole),
            Max(x, y) => (call("max", x, y)?, Whole),
            Min(x, y) => (call("min", x, y)?, Whole),
            Less(x, y) => (call("less", x, y)?, Whole),
            Where(condition, x) => (call("where", condition, x)?, Whole),
            // Only in derivatives.
            SlopePower(..) | Vanishing(..) => return None,
        };
        Some(Written { text, binding })
    }

    fn part(&self, node: Node, least: Binding) -> Option<String> {
        self.written.get(&node).map(|written| written.bracketed(least))
    }
}

/// A name as it is written in a formula.
pub(crate) fn quoted(name: &str) -> Option<String> {
    match is_word(name) {
        true => Some(name.to_string()),
        false if name.contains('`') => None,
        false => Some(format!("`{name}`")),
    }
}

/// A number as it is written in a formula.
fn finite(x: f64) -> Option<String> {
    x.is_finite().then(|| format!("{x:?}"))
}

/// A number that is not finite as a quotient, which is read as this number.
fn undefined(x: f64) -> &'static str {
    match x {
        f64::INFINITY => "1.0 / 0.0",
        f64::NEG_INFINITY => "-1.0 / 0.0",
        _ => "0.0 / 0.0",
    }
}

/// Depth of nested parentheses, without those in names.
fn deepest(text: &str) -> usize {
    let formula = text.split('`').step_by(2).flat_map(str::chars);
    let depths = formula.scan(0usize, |depth, c| {
        *depth = if c == '(' { *depth + 1 } else { depth.saturating_sub(usize::from(c == ')')) };
        Some(*depth)
    });
    depths.max().unwrap_or(0)
}
