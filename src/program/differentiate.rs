//! Derivatives of a graph, added to it as nodes by the chain rule, in forward and in reverse mode.

use super::expression::{Expression, Node};
use super::function::Function;
use super::graph::Graph;

impl Graph {
    /// ∂y/∂x w for a node y and its `k`-th argument x; `None` if it vanishes everywhere.
    ///
    /// The condition of w is applied after the multiplication by the slope, which may be infinite, like that of √max(x, 0) for x < 0.
    fn partial_times(&mut self, y: Node, k: usize, w: Node) -> Option<Node> {
        match self.expression(y) {
            Expression::Add(..) | Expression::Subtract(..) | Expression::Of(Function::Negative, _) => {
                self.slope_times(y, k, w)
            }
            _ => self.behind_condition(w, |graph, w| graph.slope_times(y, k, w)),
        }
    }

    /// Applies `make` to w without its condition, and applies the condition to the result.
    fn behind_condition(&mut self, w: Node, make: impl FnOnce(&mut Graph, Node) -> Option<Node>) -> Option<Node> {
        let Some(condition) = self.condition(w) else { return make(self, w) };
        let kept = self.unconditional(w);
        make(self, kept).map(|made| self.keep_where(condition, made))
    }

    fn slope_times(&mut self, y: Node, k: usize, w: Node) -> Option<Node> {
        use Expression::*;
        Some(match (self.expression(y), k) {
            (Constant(_) | Parameter(_) | Input(_) | Less(..), _) => return None,
            (Add(..), _) | (Subtract(..), 0) => w,
            (Subtract(..), _) => self.function(Function::Negative, w),
            (Multiply(_, factor), 0) | (Multiply(factor, _), _) => self.multiply(w, factor),
            (Divide(_, below), 0) => self.divide(w, below),
            (Divide(_, below), _) => {
                let (quotient, slope) = (self.divide(w, below), self.function(Function::Negative, y));
                self.multiply(slope, quotient)
            }
            (IntegerPower(x, n), _) => {
                let (factor, power) = (self.constant(f64::from(n)), self.integer_power(x, n.saturating_sub(1)));
                let slope = self.multiply(factor, power);
                self.multiply(slope, w)
            }
            (Power(x, n), 0) => {
                let is_smooth = self.value(n) > Some(1.0);
                let slope = self.slope_of_power((x, n), if is_smooth { Graph::slope_power } else { Graph::power });
                self.multiply(slope, w)
            }
            // The slope of x^1.5 has an infinite slope at 0, but not along directions in which x is constant.
            (SlopePower(x, n), 0) => {
                let slope = self.slope_of_power((x, n), Graph::slope_power);
                if self.is_cusp(y) { self.vanishing(slope, w) } else { self.multiply(slope, w) }
            }
            // The exponent is a constant of the formula.
            (Power(..) | SlopePower(..), _) => return None,
            (Atan2(above, right), _) => {
                let (squares, x) = ([self.multiply(above, above), self.multiply(right, right)], [right, above][k]);
                let square = self.add(squares[0], squares[1]);
                let quotient = self.divide(x, square);
                let slope = if k == 0 { quotient } else { self.function(Function::Negative, quotient) };
                self.multiply(slope, w)
            }
            (Max(x, z), _) => self.select((x, z), k, w),
            (Min(x, z), _) => self.select((z, x), k, w),
            (Where(..), 0) => return None,
            (Where(condition, _), _) => self.keep_where(condition, w),
            (Vanishing(_, y), 0) => self.vanishing(w, y),
            (Vanishing(x, _), _) => self.vanishing(x, w),
            (Of(function, x), _) => {
                let slope = function.derivative(self, x, y)?;
                self.multiply(slope, w)
            }
        })
    }

    /// Whether the slope of y may be infinite where its factor vanishes: xⁿ with n < 1 in the slope of a higher power.
    fn is_cusp(&self, y: Node) -> bool {
        matches!(self.expression(y), Expression::SlopePower(_, n) if self.value(n) < Some(1.0))
    }

    /// n xⁿ⁻¹.
    fn slope_of_power(&mut self, (x, n): (Node, Node), power: fn(&mut Graph, Node, Node) -> Node) -> Node {
        let one = self.constant(1.0);
        let less = self.subtract(n, one);
        let power = power(self, x, less);
        self.multiply(n, power)
    }

    /// w where argument `k` of a maximum or minimum is selected, 0 elsewhere: the second is selected where `low` < `high`, otherwise the first.
    fn select(&mut self, (low, high): (Node, Node), k: usize, w: Node) -> Node {
        let (one, second) = (self.constant(1.0), self.less(low, high));
        let first = self.subtract(one, second);
        self.keep_where([first, second][k], w)
    }

    /// Σ wᵢ ∂yᵢ/∂x for each x (reverse mode).
    ///
    /// Cusps are differentiated in forward mode, which detects whether their arguments vary: those of (b t)^0.5 do not vary with b at t = 0.
    pub(crate) fn reverse(&mut self, weighted: &[(Node, Node)], with_respect_to: &[Node]) -> Vec<Node> {
        let order = self.reachable(weighted.iter().map(|(y, _)| *y));
        let (zero, one, len) = (self.constant(0.0), self.constant(1.0), self.len());
        let mut cusps: Vec<(Node, Node)> = Vec::new();
        let mut depends = vec![false; len];
        with_respect_to.iter().for_each(|x| depends[x.0 as usize] = true);
        for &y in &order {
            depends[y.0 as usize] |= self.expression(y).arguments().any(|x| depends[x.0 as usize]);
        }
        let mut adjoint = vec![zero; len];
        for &(y, w) in weighted {
            adjoint[y.0 as usize] = self.add(adjoint[y.0 as usize], w);
        }
        for &y in order.iter().rev().filter(|y| depends[y.0 as usize]) {
            let w = adjoint[y.0 as usize];
            if self.is_zero(w) {
                continue;
            }
            if self.is_cusp(y) {
                cusps.push((y, w));
                continue;
            }
            for (k, x) in self.expression(y).arguments().enumerate().filter(|(_, x)| depends[x.0 as usize]) {
                if let Some(part) = self.partial_times(y, k, w) {
                    adjoint[x.0 as usize] = self.add(adjoint[x.0 as usize], part);
                }
            }
        }
        let behind_cusps = |x: &Node| {
            cusps.iter().fold(adjoint[x.0 as usize], |sum, &(y, w)| {
                let slope = self.forward(&[y], &[(*x, one)])[0];
                let part = self.behind_condition(w, |graph, w| Some(graph.multiply(w, slope)));
                part.map_or(sum, |part| self.add(sum, part))
            })
        };
        with_respect_to.iter().map(behind_cusps).collect()
    }

    /// The directional derivatives of nodes, given the tangents of inputs or parameters (forward mode).
    pub(crate) fn forward(&mut self, of: &[Node], tangents: &[(Node, Node)]) -> Vec<Node> {
        let order = self.reachable(of.iter().copied());
        let mut tangent = vec![self.constant(0.0); self.len()];
        for &(x, dot) in tangents {
            tangent[x.0 as usize] = dot;
        }
        for &y in &order {
            for (k, x) in self.expression(y).arguments().enumerate() {
                let dot = tangent[x.0 as usize];
                if self.is_zero(dot) {
                    continue;
                }
                if let Some(part) = self.partial_times(y, k, dot) {
                    tangent[y.0 as usize] = self.add(tangent[y.0 as usize], part);
                }
            }
        }
        of.iter().map(|y| tangent[y.0 as usize]).collect()
    }
}
