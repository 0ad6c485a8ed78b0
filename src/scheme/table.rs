//! [`Scheme`]: a diagonally implicit Runge–Kutta method as a table.

use crate::Error;

/// A diagonally implicit Runge–Kutta method, whose first stage is the beginning of the step and whose last stage is its end.
///
/// ```text
///   0   | 0
///   c_1 | a_10  a_11                  x_s = x_n + Δt Σ_{j ≤ s} a_sj ẋ_j,      x = (q, p*)
///   …   | …     …     …
///   1   | a_S0  a_S1  …  a_SS         x_{n+1} = x_S
/// ```
///
/// All methods solve the same equations at each of S stages per step. The gradient is exact for the discrete motion of each method.
///
/// | | stages S | order | |
/// |---|---|---|---|
/// | [`TRAPEZOIDAL`](Self::TRAPEZOIDAL) | 1 | 2 | symmetric, A-stable; the paper's scheme, and the default |
/// | [`TR_BDF2`](Self::TR_BDF2) | 2 | 2 | L-stable |
/// | [`ESDIRK3`](Self::ESDIRK3) | 3 | 3 | L-stable |
/// | [`ESDIRK4`](Self::ESDIRK4) | 5 | 4 | L-stable |
/// | [`ESDIRK5`](Self::ESDIRK5) | 7 | 5 | L-stable |
///
/// An L-stable method damps components whose decay time is much shorter than a step, and does so within one step; with the trapezoidal rule they
/// oscillate undamped. L-stable methods also remove energy from fast vibrations. Use the trapezoidal rule, or a [`Composition`](crate::Composition)
/// of it, for long conservative motions.
///
/// Controls are linear between nodes. [`Sum::Integral`](crate::Sum::Integral) sums a running cost with the order of the method.
///
/// You can define a scheme by its own Butcher tableau. It is validated before a motion is computed; the validation includes the quadrature conditions
/// for the orders of the method and of the embedded method.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Scheme, Settings, gradient, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
/// let settings = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
/// let gradient = gradient(&system, &inputs, settings)?;
/// assert_eq!(gradient.controls.ncols(), 21);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Name of the method in reports.
    pub name: &'static str,
    /// The order of convergence.
    pub order: usize,
    /// The rows a_s0 … a_ss of the stages s = 1 … S.
    pub rows: &'static [&'static [f64]],
    /// Weights b̂_0 … b̂_S of an embedded method of another order with the same stages, which estimates the error of a step; empty if there
    /// is none.
    pub embedded: &'static [f64],
    /// The order of the embedded method.
    pub embedded_order: usize,
}

/// Relative tolerance for the sum of the weights, which is exact up to rounding.
const ROUNDING: f64 = 1e-12;
/// Relative tolerance for the other conditions, since tables are printed with ten digits or more.
const DIGITS: f64 = 1e-8;

impl Scheme {
    /// Number S of stages solved per step.
    pub const fn stages(&self) -> usize {
        self.rows.len()
    }

    /// Number of stages between the nodes.
    pub(crate) const fn inner(&self) -> usize {
        self.rows.len() - 1
    }

    /// The coefficient a_sj.
    #[inline]
    pub(crate) fn a(&self, s: usize, j: usize) -> f64 {
        self.rows[s - 1][j]
    }

    /// The abscissa c_s of stage `s`: 0 at the beginning of the step, 1 at its end.
    pub fn c(&self, s: usize) -> f64 {
        match s {
            0 => 0.0,
            s if s == self.stages() => 1.0,
            s => self.rows[s - 1].iter().sum(),
        }
    }

    /// The weight of stage `s` in an integral over a step, from the last row.
    pub(crate) fn weight(&self, s: usize) -> f64 {
        self.rows[self.inner()][s]
    }

    /// True if the method is the trapezoidal rule, which has no stages between the nodes.
    pub(crate) fn is_trapezoidal(&self) -> bool {
        *self.rows == *Scheme::TRAPEZOIDAL.rows
    }

    /// Checks that the table is one of a diagonally implicit method of the stated orders.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let refused = |what: &str, value: f64, must_be| {
            Err(Error::Parameter { what: format!("`{}`: {what}", self.name), value, must_be })
        };
        let Some(&last) = self.rows.last() else {
            return refused("the number of stages", 0.0, "1 or more");
        };
        for (s, row) in self.rows.iter().enumerate() {
            let s = s + 1;
            if row.len() != s + 1 {
                return refused(&format!("the length of row {s}"), row.len() as f64, "one more than its number");
            }
            if let Some(&value) = row.iter().find(|x| !x.is_finite()) {
                return refused(&format!("an entry of row {s}"), value, "finite");
            }
            if row[s] == 0.0 {
                return refused(&format!("the diagonal entry of row {s}"), 0.0, "nonzero, because stages are implicit");
            }
        }
        if self.order == 0 {
            return refused("the order", 0.0, "1 or more");
        }
        if let Some((power, sum)) = self.missed(last, self.order) {
            return match power {
                0 => refused("the sum of the last row", sum, "1, because the last stage is the end of the step"),
                _ => refused(&format!("Σ b c^{power} with the last row"), sum, "1/(k + 1) for c^k, with k below the order"),
            };
        }
        if self.embedded.is_empty() {
            return Ok(());
        }
        if self.embedded.len() != self.stages() + 1 {
            return refused("the number of embedded weights", self.embedded.len() as f64, "one more than the stages, or 0");
        }
        if let Some(&value) = self.embedded.iter().find(|x| !x.is_finite()) {
            return refused("an embedded weight", value, "finite");
        }
        if self.embedded_order == 0 {
            return refused("the order of the embedded weights", 0.0, "1 or more");
        }
        match self.missed(self.embedded, self.embedded_order) {
            Some((0, sum)) => refused("the sum of the embedded weights", sum, "1"),
            Some((power, sum)) => {
                let what = format!("Σ b c^{power} with the embedded weights");
                refused(&what, sum, "1/(k + 1) for c^k, with k below their order")
            }
            None if self.embedded == last => refused(
                "the largest difference of the embedded weights from the last row",
                0.0,
                "more than 0, because it estimates the error of a step",
            ),
            None => Ok(()),
        }
    }

    /// The first power k below the order for which Σ b cᵏ differs from ∫₀¹ cᵏ dc = 1/(k + 1), and this sum.
    fn missed(&self, weights: &[f64], order: usize) -> Option<(i32, f64)> {
        let sum = |power: i32| -> f64 { weights.iter().enumerate().map(|(s, b)| b * self.c(s).powi(power)).sum() };
        let is_missed = |(power, sum): &(i32, f64)| {
            let off = (sum * f64::from(power + 1) - 1.0).abs();
            off.is_nan() || off > if *power == 0 { ROUNDING } else { DIGITS }
        };
        (0..order as i32).map(|power| (power, sum(power))).find(is_missed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rooted tree, given by its subtrees; Φ and γ as in Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, II.2.
    struct Tree(Vec<Tree>);

    impl Tree {
        fn order(&self) -> usize {
            1 + self.0.iter().map(Tree::order).sum::<usize>()
        }

        fn density(&self) -> f64 {
            self.order() as f64 * self.0.iter().map(Tree::density).product::<f64>()
        }

        /// At each stage s, the product over the subtrees of Σ_j a_sj w_j, with the weights w of the subtree.
        fn weights(&self, scheme: &Scheme) -> Vec<f64> {
            let of_subtrees: Vec<Vec<f64>> = self.0.iter().map(|tree| tree.weights(scheme)).collect();
            let at = |s: usize, values: &[f64]| match s {
                0 => 0.0,
                s => (0..=s).map(|j| scheme.a(s, j) * values[j]).sum(),
            };
            (0..=scheme.stages()).map(|s| of_subtrees.iter().map(|values| at(s, values)).product()).collect()
        }

        fn clone(&self) -> Tree {
            Tree(self.0.iter().map(Tree::clone).collect())
        }
    }

    /// All rooted trees of an order, with subtrees in non-increasing order.
    fn trees(order: usize) -> Vec<Tree> {
        fn forests(nodes: usize, largest: usize) -> Vec<Vec<Tree>> {
            if nodes == 0 {
                return vec![Vec::new()];
            }
            let mut found = Vec::new();
            for size in (1..=nodes.min(largest)).rev() {
                for (k, first) in trees(size).iter().enumerate() {
                    for rest in forests(nodes - size, size) {
                        // Subtrees of equal size keep the order of their list.
                        let position = |tree: &Tree| trees(size).iter().position(|t| key(t) == key(tree)).unwrap_or(0);
                        if rest.first().is_none_or(|tree| tree.order() < size || position(tree) >= k) {
                            found.push(std::iter::once(first.clone()).chain(rest).collect());
                        }
                    }
                }
            }
            found
        }
        forests(order - 1, order - 1).into_iter().map(Tree).collect()
    }

    fn key(tree: &Tree) -> String {
        format!("[{}]", tree.0.iter().map(key).collect::<String>())
    }

    /// The largest violation of the order conditions of all trees of an order.
    fn violation(scheme: &Scheme, b: &[f64], order: usize) -> f64 {
        let of = |tree: &Tree| {
            let sum: f64 = tree.weights(scheme).iter().zip(b).map(|(weight, b)| weight * b).sum();
            (sum - tree.density().recip()).abs()
        };
        trees(order).iter().map(of).fold(0.0, f64::max)
    }

    #[test]
    fn there_are_as_many_trees_as_the_book_says() {
        assert_eq!((1..=6).map(|order| trees(order).len()).collect::<Vec<_>>(), [1, 1, 2, 4, 9, 20]);
    }

    #[test]
    fn tables_fulfil_the_conditions_of_their_orders_and_no_more() {
        for scheme in Scheme::ALL {
            scheme.check().expect("a table");
            let last = scheme.rows[scheme.inner()];
            let methods = [(last, scheme.order), (scheme.embedded, scheme.embedded_order)];
            for (b, order) in methods.into_iter().filter(|(b, _)| !b.is_empty()) {
                for lower in 1..=order {
                    assert!(violation(&scheme, b, lower) < 2e-13, "{} {order}: {lower}", scheme.name);
                }
                assert!(violation(&scheme, b, order + 1) > 1e-5, "{} is better than order {order}", scheme.name);
            }
        }
    }

    #[test]
    fn stages_share_one_diagonal_value_and_all_but_the_trapezoidal_rule_are_l_stable() {
        for scheme in Scheme::ALL {
            let diagonal = |s: usize| scheme.a(s, s);
            assert!((1..=scheme.stages()).all(|s| diagonal(s) == diagonal(1)), "{}", scheme.name);
            // x_S for ẋ = λ x and Δt = 1.
            let growth = |lambda: f64| {
                let mut x = vec![1.0];
                for s in 1..=scheme.stages() {
                    let known = 1.0 + lambda * (0..s).map(|j| scheme.a(s, j) * x[j]).sum::<f64>();
                    x.push(known / (1.0 - lambda * scheme.a(s, s)));
                }
                x[scheme.stages()].abs()
            };
            let decays = growth(-1e8) < 1e-6;
            assert_eq!(decays, !scheme.is_trapezoidal(), "{}: {}", scheme.name, growth(-1e8));
            assert!((1..400).all(|k| growth(-0.05 * 1.05f64.powi(k)) <= 1.0), "{}", scheme.name);
        }
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let rows: [&'static [&'static [f64]]; 5] = [&[], &[&[0.5]], &[&[1.0, 0.0]], &[&[0.5, 0.4]], &[&[f64::NAN, 0.5]]];
        for rows in rows {
            let scheme = Scheme { rows, ..Scheme::TRAPEZOIDAL };
            assert!(matches!(scheme.check(), Err(Error::Parameter { .. })), "{rows:?}");
        }
        assert!(Scheme { embedded: &[1.0], ..Scheme::TRAPEZOIDAL }.check().is_err());
        let wrong: [(Scheme, &str); 8] = [
            (Scheme { order: 0, ..Scheme::TRAPEZOIDAL }, "the order is 0"),
            (Scheme { order: 3, ..Scheme::TRAPEZOIDAL }, "Σ b c^2 with the last row"),
            (Scheme { embedded: &[0.5, 0.5], embedded_order: 2, ..Scheme::TRAPEZOIDAL }, "difference"),
            (Scheme { embedded: &[f64::NAN, 0.5], embedded_order: 1, ..Scheme::TRAPEZOIDAL }, "an embedded weight is NaN"),
            (Scheme { embedded: &[0.6, 0.5], embedded_order: 1, ..Scheme::TRAPEZOIDAL }, "the sum of the embedded weights"),
            (Scheme { embedded: &[0.6, 0.4], embedded_order: 2, ..Scheme::TRAPEZOIDAL }, "Σ b c^1 with the embedded"),
            (Scheme { embedded: &[0.6, 0.4], embedded_order: 0, ..Scheme::TRAPEZOIDAL }, "the order of the embedded"),
            (Scheme { embedded_order: 4, ..Scheme::ESDIRK4 }, "Σ b c^3 with the embedded"),
        ];
        for (scheme, words) in wrong {
            let error = scheme.check().expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
        Scheme { embedded: &[0.6, 0.4], embedded_order: 1, ..Scheme::TRAPEZOIDAL }.check().expect("an estimate of order 1");
    }
}
