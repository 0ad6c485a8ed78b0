//! Directional derivatives of an element by num-dual: ε₂ for the direction, ε₁ for one argument.

use crate::number::{Hyper, hyper, hyper_parts};
use crate::system::cost::CostRows;
use crate::system::formula::{Component, Covector, NodeView, OnNumbers, Pair, PlacedElement, Slot, Sums};

/// The variable of differentiation: none, an argument, or a velocity together with the coordinate whose rate it is.
#[derive(Clone, Copy)]
enum Seed {
    None,
    Of(Slot),
    Rate(usize),
}

impl PlacedElement {
    /// An argument and its derivative along a direction; components that the direction lacks count as zero.
    fn moving(&self, at: &NodeView<f64>, along: &NodeView<f64>, slot: Slot) -> [f64; 2] {
        [self.to.read(at, slot), self.to.rate(along, slot)]
    }

    /// Evaluates 𝓛_v, 𝓛_q + Q and dΦ/dt with derivatives along a direction and with respect to `seed`.
    fn first_along(
        &self,
        (at, along): (&NodeView<f64>, &NodeView<f64>),
        seed: Seed,
        put: &mut dyn FnMut(Component, [f64; 4]),
    ) {
        let read = |slot: Slot| {
            let [value, rate] = self.moving(at, along, slot);
            match (seed, slot) {
                (Seed::Of(of), _) if of == slot => hyper(value, 1.0, rate, 0.0),
                (Seed::Rate(i), Slot::V(of)) if of == i => hyper(value, 1.0, rate, 0.0),
                (Seed::Rate(i), Slot::Q(of)) if of == i => hyper(value, 0.0, rate, 1.0),
                _ => hyper(value, 0.0, rate, 0.0),
            }
        };
        OnNumbers::<Hyper>::first(&*self.formula, &read, &mut |of, x| put(of, hyper_parts(&x)));
    }

    /// Adds the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt caused by the changes of the inputs u, t and b in a direction.
    pub fn add_changes(&self, at: &NodeView<f64>, along: &NodeView<f64>, sums: &mut Sums<f64>) {
        let inputs = NodeView { q: &[], v: &[], sigma: &[], ..*along };
        self.first_along((at, &inputs), Seed::None, &mut |of, parts| *self.place(of, sums) += parts[2]);
    }

    /// Adds the derivatives of the change of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt along a direction.
    pub fn pull_back_along(&self, at: (&NodeView<f64>, &NodeView<f64>), with: &Covector, rows: &mut CostRows) {
        let slope = |seed: Slot| {
            let mut sum = 0.0;
            self.first_along(at, Seed::Of(seed), &mut |of, parts| sum += parts[3] * self.weight(of, with));
            sum
        };
        for (i, &coordinate) in self.to.q.iter().enumerate() {
            rows.q[coordinate] += slope(Slot::Q(i));
            rows.v[coordinate] += slope(Slot::V(i));
        }
        for (j, &equation) in self.to.sigma.iter().enumerate() {
            rows.sigma[equation] += slope(Slot::Sigma(j));
        }
        self.pull_back_inputs_along(rows, &slope);
    }

    /// Adds the derivatives with respect to controls, parameters and time; `slope` computes each of them.
    fn pull_back_inputs_along(&self, rows: &mut CostRows, slope: &dyn Fn(Slot) -> f64) {
        for (k, &channel) in self.to.u.iter().enumerate() {
            rows.u[channel] += slope(Slot::U(k));
        }
        for (p, b) in self.to.b.iter().enumerate() {
            if let Some((design, factor)) = b.bound() {
                rows.design[design] += factor * slope(Slot::B(p));
            }
        }
        rows.time += slope(Slot::T);
    }
}

/// The direction in which the state moves with time.
fn motion<'a>(at: &NodeView<'a, f64>, (v_dot, lambda): (&'a [f64], &'a [f64])) -> NodeView<'a, f64> {
    NodeView::of_equations([at.v, v_dot, lambda], (&[], 1.0, &[]))
}

/// Accelerations and reactions: f, g and their derivatives, with ε₂ along the motion.
impl PlacedElement {
    /// Adds f and g for v̇ = 0 and λ = 0.
    pub fn add_acceleration(&self, at: &NodeView<f64>, right: &mut Pair) {
        let mut put = |of: Component, [value, _, rate, _]: [f64; 4]| match of {
            Component::Momentum(i) => right.v[self.to.q[i]] -= rate,
            Component::Force(i) => right.v[self.to.q[i]] += value,
            Component::Equation(j) => right.sigma[self.to.sigma[j]] -= rate,
        };
        self.first_along((at, &motion(at, (&[], &[]))), Seed::None, &mut put);
    }

    /// Adds the changes of f and g along a direction at fixed v̇ and λ; ε₁ represents this direction.
    pub fn add_acceleration_change(&self, (at, along): (&NodeView<f64>, &NodeView<f64>), changes: &mut Pair) {
        let (fixed, motion) = (NodeView { sigma: &[], ..*along }, motion(at, (at.v_dot, at.lambda)));
        let read = |slot: Slot| {
            let [[value, change], [_, rate]] = [&fixed, &motion].map(|direction| self.moving(at, direction, slot));
            // The rate of a coordinate is its velocity, which also changes along the direction.
            hyper(value, change, rate, if let Slot::Q(i) = slot { along.v[self.to.q[i]] } else { 0.0 })
        };
        OnNumbers::<Hyper>::first(&*self.formula, &read, &mut |of, x| match (of, hyper_parts(&x)) {
            (Component::Momentum(i), [.., rate]) => changes.v[self.to.q[i]] -= rate,
            (Component::Force(i), [_, change, ..]) => changes.v[self.to.q[i]] += change,
            (Component::Equation(j), [.., rate]) => changes.sigma[self.to.sigma[j]] -= rate,
        });
    }

    /// Adds the derivatives of c·f + e·g.
    pub fn pull_back_acceleration(&self, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        let slope = |seed: Seed| {
            let mut sum = 0.0;
            let mut put = |of: Component, [_, slope, _, rate]: [f64; 4]| match of {
                Component::Momentum(i) => sum -= with.v[self.to.q[i]] * rate,
                Component::Force(i) => sum += with.v[self.to.q[i]] * slope,
                Component::Equation(j) => sum -= with.sigma[self.to.sigma[j]] * rate,
            };
            self.first_along((at, &motion(at, (at.v_dot, at.lambda))), seed, &mut put);
            sum
        };
        for (i, &coordinate) in self.to.q.iter().enumerate() {
            rows.q[coordinate] += slope(Seed::Of(Slot::Q(i)));
            // A velocity is also the rate of its coordinate.
            rows.v[coordinate] += slope(Seed::Rate(i));
        }
        self.pull_back_inputs_along(rows, &|slot| slope(Seed::Of(slot)));
    }
}
