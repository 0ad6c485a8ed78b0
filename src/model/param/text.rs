//! Parameters as text: `mass * length ^ 2 / 12`. Names of design variables that are not words are written in backticks.
//!
//! Parts of a long formula precede it, each followed by a semicolon: in `mass * length; $1 * $1 / 12`, `$1` is the first part.

use std::collections::HashMap;

use super::{Param, Source};
use crate::Scalar;
use crate::model::expressions;
use crate::program::{Expression, Function, Graph, Node};

/// Deepest nesting of parentheses and functions that is read.
const DEEPEST: usize = 60;
/// A longer or more deeply nested part of a formula is written once, before the formula, and referred to by its number.
const LONGEST_PART: usize = 1000;
const DEEPEST_PART: usize = 20;

/// A function of two arguments: its name, its value, and its node in a graph.
type OfTwo = (&'static str, fn(f64, f64) -> f64, fn(&mut Graph, Node, Node) -> Node);

const OF_TWO: [OfTwo; 3] = [
    ("atan2", f64::atan2, Graph::atan2),
    ("max", |x, y| Scalar::max(&x, y), Graph::max),
    ("min", |x, y| Scalar::min(&x, y), Graph::min),
];

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
                let text = expressions::with(expression.scene, |graph| {
                    Writer { graph, designs, written: HashMap::new(), parts: Vec::new() }.write(expression.node)
                });
                let (parts, Written { text, binding }) = text.flatten()?;
                Some(parts + &times(bracketed(&text, binding, Binding::Factor)))
            }
            Source::Gravity(_) | Source::Value(_) | Source::Foreign => None,
        }
    }

    /// Parses a parameter from text.
    ///
    /// # Errors
    /// The column of the mistake, and its description.
    pub(crate) fn read(text: &str, design: impl Fn(&str) -> Option<Param>) -> Result<Param, (usize, String)> {
        let mut reader = Reader { text, at: 0, design: &design, depth: 0, parts: Vec::new() };
        loop {
            let result = reader.sum()?;
            match reader.next() {
                None => return Ok(result),
                Some(';') => reader.at += 1,
                Some(other) => return Err(reader.wrong(&format!("`{other}` found where the formula should end"))),
            }
            reader.parts.push(result);
        }
    }
}

/// A name as it is written in a formula.
fn quoted(name: &str) -> Option<String> {
    let is_word = name.chars().all(|c| c.is_alphanumeric() || c == '_') && name.starts_with(|c: char| !c.is_numeric());
    match is_word {
        true => Some(name.to_string()),
        false if name.contains('`') => None,
        false => Some(format!("`{name}`")),
    }
}

/// A number as it is written in a formula.
fn finite(x: f64) -> Option<String> {
    x.is_finite().then(|| format!("{x:?}"))
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

/// Precedence of the outermost operator of a text, in increasing order.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Binding {
    Sum,
    Product,
    Factor,
    Whole,
}

fn bracketed(text: &str, binding: Binding, least: Binding) -> String {
    if binding < least { format!("({text})") } else { text.to_string() }
}

/// The text of a node.
struct Written {
    text: String,
    binding: Binding,
}

struct Writer<'a> {
    graph: &'a Graph,
    designs: &'a [&'a str],
    written: HashMap<Node, Written>,
    /// The parts that precede the formula.
    parts: Vec<String>,
}

impl Writer<'_> {
    /// The parts, and the formula itself. Nodes are written before those that depend on them, without recursion, so deep formulas need no deep stack.
    fn write(mut self, node: Node) -> Option<(String, Written)> {
        for node in self.graph.reachable([node]) {
            let (mut text, mut binding) = self.formula(node)?;
            if text.len() > LONGEST_PART || deepest(&text) > DEEPEST_PART {
                self.parts.push(text + "; ");
                (text, binding) = (format!("${}", self.parts.len()), Binding::Whole);
            }
            self.written.insert(node, Written { text, binding });
        }
        Some((self.parts.concat(), self.written.remove(&node)?))
    }

    fn formula(&self, node: Node) -> Option<(String, Binding)> {
        use Binding::{Factor, Product, Sum, Whole};
        use Expression::*;
        let call = |name: &str, x: Node, y: Node| Some(format!("{name}({}, {})", self.part(x, Sum)?, self.part(y, Sum)?));
        Some(match self.graph.expression(node) {
            Constant(bits) if f64::from_bits(bits).is_sign_negative() => (finite(f64::from_bits(bits))?, Sum),
            Constant(bits) => (finite(f64::from_bits(bits))?, Whole),
            Input(which) => (quoted(self.designs.get(which as usize)?)?, Whole),
            Add(x, y) => (format!("{} + {}", self.part(x, Sum)?, self.part(y, Product)?), Sum),
            Subtract(x, y) => (format!("{} - {}", self.part(x, Sum)?, self.part(y, Product)?), Sum),
            Multiply(x, y) => (format!("{} * {}", self.part(x, Product)?, self.part(y, Factor)?), Product),
            Divide(x, y) => (format!("{} / {}", self.part(x, Product)?, self.part(y, Factor)?), Product),
            Of(Function::Negative, x) => (format!("-{}", self.part(x, Factor)?), Sum),
            Of(Function::Reciprocal, x) => (format!("1.0 / {}", self.part(x, Factor)?), Product),
            Of(function, x) => (format!("{}({})", function.name(), self.part(x, Sum)?), Whole),
            IntegerPower(x, n) => (format!("{} ^ {n}", self.part(x, Whole)?), Factor),
            Power(x, n) => (format!("{} ^ {}", self.part(x, Whole)?, finite(self.graph.value(n)?)?), Factor),
            Atan2(y, x) => (call("atan2", y, x)?, Whole),
            Max(x, y) => (call("max", x, y)?, Whole),
            Min(x, y) => (call("min", x, y)?, Whole),
            // Formulas that branch, and formulas of derivatives.
            Parameter(_) | Less(..) | Where(..) | SlopePower(..) | Vanishing(..) => return None,
        })
    }

    fn part(&self, node: Node, least: Binding) -> Option<String> {
        self.written.get(&node).map(|Written { text, binding }| bracketed(text, *binding, least))
    }
}

/// Parses sums of products of powers, from left to right.
struct Reader<'a> {
    text: &'a str,
    at: usize,
    design: &'a dyn Fn(&str) -> Option<Param>,
    depth: usize,
    parts: Vec<Param>,
}

type Read<T> = Result<T, (usize, String)>;

impl Reader<'_> {
    fn wrong(&self, problem: &str) -> (usize, String) {
        (self.text[..self.at].chars().count() + 1, problem.to_string())
    }

    /// The next character that is not a space.
    fn next(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let is_there = self.next() == Some(wanted);
        self.at += if is_there { wanted.len_utf8() } else { 0 };
        is_there
    }

    fn expect(&mut self, wanted: char) -> Read<()> {
        if self.take(wanted) { Ok(()) } else { Err(self.wrong(&format!("`{wanted}` is missing"))) }
    }

    fn sum(&mut self) -> Read<Param> {
        let mut sum = self.product()?;
        loop {
            if self.take('+') {
                sum = sum + self.product()?;
            } else if self.take('-') {
                sum = sum - self.product()?;
            } else {
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Read<Param> {
        let mut product = self.signed()?;
        loop {
            if self.take('*') {
                product = product * self.signed()?;
            } else if self.take('/') {
                product = product / self.signed()?;
            } else {
                return Ok(product);
            }
        }
    }

    /// A power preceded by a sign: −x² is −(x²).
    fn signed(&mut self) -> Read<Param> {
        let mut is_negative = false;
        while self.take('-') {
            is_negative = !is_negative;
        }
        let power = self.power()?;
        Ok(if is_negative { -power } else { power })
    }

    fn power(&mut self) -> Read<Param> {
        let base = self.whole()?;
        if !self.take('^') {
            return Ok(base);
        }
        let is_negative = self.take('-');
        let Some(n) = self.whole()?.constant() else { return Err(self.wrong("the exponent must be a number")) };
        let n = if is_negative { -n } else { n };
        // The conversion is exact: the bounds ±i32::MAX are representable in both types.
        Ok(if n.fract() == 0.0 && n.abs() <= f64::from(i32::MAX) { base.powi(n as i32) } else { base.powf(n) })
    }

    fn whole(&mut self) -> Read<Param> {
        match self.next() {
            Some('(') => {
                self.at += 1;
                self.within(Self::sum)
            }
            Some('`') => {
                let name = &self.text[self.at + 1..];
                let Some(end) = name.find('`') else { return Err(self.wrong("this backtick is not closed")) };
                let result = self.variable(&name[..end])?;
                self.at += end + 2;
                Ok(result)
            }
            Some('$') => {
                let digits = &self.text[self.at + 1..];
                let digits = &digits[..digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len())];
                let part = digits.parse().ok().and_then(|which: usize| self.parts.get(which.checked_sub(1)?)).copied();
                let part = part.ok_or_else(|| self.wrong(&format!("no part `${digits}` precedes it")))?;
                self.at += 1 + digits.len();
                Ok(part)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.word(),
            Some(other) => Err(self.wrong(&format!("`{other}` found where a number, a name or `(` is expected"))),
            None => Err(self.wrong("the formula ends too early")),
        }
    }

    fn within<T>(&mut self, read: impl FnOnce(&mut Self) -> Read<T>) -> Read<T> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.wrong(&format!("more than {DEEPEST} nested parentheses")));
        }
        let result = read(self)?;
        self.depth -= 1;
        self.expect(')')?;
        Ok(result)
    }

    fn number(&mut self) -> Read<Param> {
        let rest = &self.text[self.at..];
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let mut length = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        if let Some(exponent) = rest[length..].strip_prefix(['e', 'E']) {
            let size = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
            // Without digits, the letter does not belong to the number.
            length = if digits(size) > 0 { rest.len() - size.len() + digits(size) } else { length };
        }
        match rest[..length].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.at += length;
                Ok(number.into())
            }
            _ => Err(self.wrong("this is not a finite number")),
        }
    }

    fn word(&mut self) -> Read<Param> {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let word = &rest[..length];
        let is_function = rest[length..].trim_start().starts_with('(');
        if !is_function {
            let result = self.variable(word)?;
            self.at += length;
            return Ok(result);
        }
        if let Some(function) = Function::NAMED.into_iter().find(|function| function.name() == word) {
            self.at += length;
            self.expect('(')?;
            let x = self.within(Self::sum)?;
            return Ok(x.apply(|x| function.value(x), |graph, x| graph.function(function, x)));
        }
        if let Some((_, number, node)) = OF_TWO.into_iter().find(|(name, ..)| *name == word) {
            self.at += length;
            self.expect('(')?;
            let (x, y) = self.within(|reader| {
                let x = reader.sum()?;
                reader.expect(',')?;
                Ok((x, reader.sum()?))
            })?;
            return Ok(x.combine(y, number, node));
        }
        let of_one = Function::NAMED.map(Function::name).into_iter();
        let known: Vec<String> = of_one.chain(OF_TWO.map(|(name, ..)| name.to_string())).collect();
        Err(self.wrong(&format!("unknown function `{word}`; known functions are {}", known.join(", "))))
    }

    fn variable(&self, name: &str) -> Read<Param> {
        (self.design)(name).ok_or_else(|| self.wrong(&format!("no design variable is called `{name}`")))
    }
}
