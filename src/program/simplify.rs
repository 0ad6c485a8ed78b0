//! Rules by which operations are simplified as they are recorded: constants are folded, signs and fixed factors move outwards.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

impl Graph {
    /// Creates the node of an expression, simplified.
    pub(super) fn make(&mut self, expression: Expression) -> Node {
        use Expression::*;
        match expression {
            Constant(_) | Parameter(_) | Input(_) => self.put(expression),
            Of(function, x) => self.function(function, x),
            Add(x, y) => self.add(x, y),
            Subtract(x, y) => self.subtract(x, y),
            Multiply(x, y) => self.multiply(x, y),
            Divide(x, y) => self.divide(x, y),
            IntegerPower(x, n) => self.integer_power(x, n),
            Power(x, n) => self.power(x, n),
            SlopePower(x, n) => self.slope_power(x, n),
            Atan2(y, x) => self.atan2(y, x),
            Max(x, y) => self.max(x, y),
            Min(x, y) => self.min(x, y),
            Less(x, y) => self.less(x, y),
            Where(condition, x) => self.keep_where(condition, x),
            Vanishing(x, y) => self.vanishing(x, y),
        }
    }

    /// Whether x + number is x. If signs of zeros matter, 0 is excluded, because −0 + 0 is 0.
    fn adds_nothing(&self, number: f64) -> bool {
        number == 0.0 && (self.is_loose || number.is_sign_negative())
    }

    fn negative(&mut self, x: Node) -> Node {
        self.function(Function::Negative, x)
    }

    pub(crate) fn add(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(number), None) if self.adds_nothing(number) => return y,
            (None, Some(number)) if self.adds_nothing(number) => return x,
            _ => {}
        }
        if x == y {
            let two = self.constant(2.0);
            return self.multiply(two, x);
        }
        for (x, y) in [(x, y), (y, x)] {
            if let Some(y) = self.negated(y) {
                return self.subtract(x, y);
            }
        }
        if let Some((condition, [x, y])) = self.both_where(x, y) {
            let sum = self.add(x, y);
            return self.keep_where(condition, sum);
        }
        let sum = self.put(Expression::Add(x.min(y), x.max(y)));
        self.note_condition(sum, [x, y]);
        sum
    }

    pub(crate) fn subtract(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x - y),
            (Some(number), None) if self.adds_nothing(number) => return self.negative(y),
            (None, Some(number)) if self.adds_nothing(-number) => return x,
            _ => {}
        }
        if x == y {
            return self.constant(0.0);
        }
        if let Some(y) = self.negated(y) {
            return self.add(x, y);
        }
        if let Some(x) = self.negated(x).filter(|_| self.is_loose) {
            let sum = self.add(x, y);
            return self.negative(sum);
        }
        if let Some((condition, [x, y])) = self.both_where(x, y) {
            let difference = self.subtract(x, y);
            return self.keep_where(condition, difference);
        }
        if let Some(&difference) = self.numbers.get(&Expression::Subtract(y, x)).filter(|_| self.is_loose) {
            return self.negative(difference);
        }
        let difference = self.put(Expression::Subtract(x, y));
        self.note_condition(difference, [x, y]);
        difference
    }

    pub(crate) fn multiply(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x * y),
            (Some(0.0), None) | (None, Some(0.0)) if self.is_loose => return self.constant(0.0),
            (Some(number), None) | (None, Some(number)) if number == 1.0 || number < 0.0 || self.adds_nothing(number) => {
                let other = if self.value(x).is_some() { y } else { x };
                if number == 1.0 {
                    return other;
                }
                // Signs move outwards, so that products with x and −x are one node.
                let size = self.constant(-number);
                let product = self.multiply(size, other);
                return self.negative(product);
            }
            _ => {}
        }
        for (x, y) in [(x, y), (y, x)] {
            if let Some(x) = self.negated(x) {
                let product = self.multiply(x, y);
                return self.negative(product);
            }
        }
        // Fixed factors are collected in front, so that they are multiplied once.
        for (x, y) in [(x, y), (y, x)] {
            if let Some((factor, y)) = self.fixed_factor(y) {
                let rest = if self.is_fixed(x) { (self.multiply(x, factor), y) } else { (factor, self.multiply(x, y)) };
                return self.multiply(rest.0, rest.1);
            }
        }
        let place = |node: Node| (!self.is_fixed(node), node);
        let (x, y) = if place(x) <= place(y) { (x, y) } else { (y, x) };
        self.put(Expression::Multiply(x, y))
    }

    pub(crate) fn divide(&mut self, x: Node, y: Node) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => return self.constant(x / y),
            (Some(0.0), None) if self.is_loose => return x,
            (Some(1.0), None) => return self.function(Function::Reciprocal, y),
            _ => {}
        }
        if self.is_fixed(y) {
            let reciprocal = self.function(Function::Reciprocal, y);
            return self.multiply(reciprocal, x);
        }
        if let Some(x) = self.negated(x) {
            let quotient = self.divide(x, y);
            return self.negative(quotient);
        }
        if let Some(y) = self.negated(y) {
            let quotient = self.divide(x, y);
            return self.negative(quotient);
        }
        self.put(Expression::Divide(x, y))
    }

    pub(crate) fn function(&mut self, function: Function, x: Node) -> Node {
        if let Some(value) = self.value(x) {
            return self.constant(function.value(value));
        }
        match (function, self.expression(x)) {
            (Function::Negative, Expression::Of(Function::Negative, x)) => return x,
            (_, Expression::Of(Function::Negative, x)) if function.is_odd() => {
                let y = self.function(function, x);
                return self.negative(y);
            }
            (_, Expression::Of(Function::Negative, x)) if function.is_even() => return self.function(function, x),
            _ => {}
        }
        self.put(Expression::Of(function, x))
    }

    pub(crate) fn integer_power(&mut self, x: Node, n: i32) -> Node {
        if let Some(value) = self.value(x) {
            return self.constant(value.powi(n));
        }
        match n {
            0 => self.constant(1.0),
            1 => x,
            2 => self.multiply(x, x),
            3 => {
                let square = self.multiply(x, x);
                self.multiply(square, x)
            }
            -1 => self.function(Function::Reciprocal, x),
            _ => self.put(Expression::IntegerPower(x, n)),
        }
    }

    pub(crate) fn power(&mut self, x: Node, n: Node) -> Node {
        match self.value(n) {
            Some(0.0) => self.constant(1.0),
            Some(1.0) => x,
            _ => self.folded([x, n], f64::powf, Expression::Power),
        }
    }

    /// xⁿ in the slope of a higher power.
    pub(super) fn slope_power(&mut self, x: Node, n: Node) -> Node {
        match self.value(n) {
            Some(0.0 | 1.0) => self.power(x, n),
            // An infinite slope remains a node, so that its product with 0 is 0.
            Some(exponent) if self.value(x).is_some_and(|x| x.powf(exponent).is_finite()) => self.power(x, n),
            _ => self.put(Expression::SlopePower(x, n)),
        }
    }

    /// The node of an operation on two nodes, or its value for two constants.
    fn folded(&mut self, [x, y]: [Node; 2], value: fn(f64, f64) -> f64, expression: fn(Node, Node) -> Expression) -> Node {
        match (self.value(x), self.value(y)) {
            (Some(x), Some(y)) => self.constant(value(x, y)),
            _ => self.put(expression(x, y)),
        }
    }

    pub(crate) fn atan2(&mut self, y: Node, x: Node) -> Node {
        self.folded([y, x], f64::atan2, Expression::Atan2)
    }

    pub(crate) fn max(&mut self, x: Node, y: Node) -> Node {
        self.folded([x, y], |x, y| if y > x { y } else { x }, Expression::Max)
    }

    pub(crate) fn min(&mut self, x: Node, y: Node) -> Node {
        self.folded([x, y], |x, y| if y < x { y } else { x }, Expression::Min)
    }

    pub(crate) fn less(&mut self, x: Node, y: Node) -> Node {
        self.folded([x, y], |x, y| f64::from(u8::from(x < y)), Expression::Less)
    }

    /// x y, which is 0 where y is, even if x is infinite.
    pub(super) fn vanishing(&mut self, x: Node, y: Node) -> Node {
        if self.value(x).or(self.value(y)).is_some() { self.multiply(x, y) } else { self.put(Expression::Vanishing(x, y)) }
    }
}
