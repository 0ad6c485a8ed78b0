//! Accelerations and reactions of an element without a program: f, g and their derivatives by num-dual, ε₂ along the motion and ε₁ along an argument.

use super::along::Seed;
use super::batch::Pair;
use super::cost::CostRows;
use super::formula::Component;
use super::item::PlacedElement;
use super::typed::Slot;
use super::view::NodeView;

/// The direction in which time goes on.
fn motion<'a>(at: &NodeView<'a, f64>, (v_dot, lambda): (&'a [f64], &'a [f64])) -> NodeView<'a, f64> {
    NodeView::of_equations([at.v, v_dot, lambda], (&[], 1.0, &[]))
}

impl PlacedElement {
    /// Adds f and g where v̇ = 0 and λ = 0.
    pub fn add_acceleration(&self, at: &NodeView<f64>, right: &mut Pair) {
        let mut put = |of: Component, [value, _, rate, _]: [f64; 4]| match of {
            Component::Momentum(i) => right.v[self.q[i]] -= rate,
            Component::Force(i) => right.v[self.q[i]] += value,
            Component::Equation(j) => right.sigma[self.sigma[j]] -= rate,
        };
        self.first_along((at, &motion(at, (&[], &[]))), Seed::None, &mut put);
    }

    /// Adds the derivatives of c·f + e·g.
    pub fn pull_back_acceleration(&self, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        let slope = |seed: Seed| {
            let mut sum = 0.0;
            let mut put = |of: Component, [_, slope, _, rate]: [f64; 4]| match of {
                Component::Momentum(i) => sum -= with.v[self.q[i]] * rate,
                Component::Force(i) => sum += with.v[self.q[i]] * slope,
                Component::Equation(j) => sum -= with.sigma[self.sigma[j]] * rate,
            };
            self.first_along((at, &motion(at, (at.v_dot, at.lambda))), seed, &mut put);
            sum
        };
        for (i, &coordinate) in self.q.iter().enumerate() {
            rows.q[coordinate] += slope(Seed::Of(Slot::Q(i)));
            // The velocity is the rate of the coordinate, too.
            rows.v[coordinate] += slope(Seed::Rate(i));
        }
        self.pull_back_inputs_along(rows, &|slot| slope(Seed::Of(slot)));
    }
}
