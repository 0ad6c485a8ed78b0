//! Derivatives that a formula loses: it takes the value of an argument by `re()`, as to look it up in a table, and goes on with a plain number. Its values
//! change with the argument then, its derivatives do not, and nothing else would tell.

use super::argument::Argument;
use super::formula::Component;
use super::item::PlacedElement;
use super::jet::ElementKind;
use super::placed_cost::PlacedCost;
use super::typed::{OnNumbers, Slot, Values};
use super::view::NodeView;
use crate::number::{Hyper, Slope, guarded, hyper, hyper_parts, slope};
use crate::program::Obstacle;
use crate::{System, Warning};

/// So many points are tried; at so many of them, and wherever differences tell, a derivative that is lost must not be what values change by.
const POINTS: usize = 12;
const ENOUGH: usize = 3;
/// The step of differences, in units of an argument or of 1.
const STEP: f64 = 1e-6;
/// Derivatives that differ from differences by more than this share are not those of the values.
const DIFFERS: f64 = 1e-3;
/// The share of values that may be rounding, generously.
const ROUNDED: f64 = 1e-12;

/// How far point k is aside of argument i, which is x.
fn aside(k: usize, i: usize, x: f64) -> f64 {
    let share = 0.02 * k as f64 * (0.6 + (1.7 * (i + 5 * k) as f64).sin());
    share * x.abs().max(1.0)
}

/// Whether the derivative of a value by an argument x is lost there; nothing where differences do not tell: beside rounding, or where shorter steps tell
/// something else.
fn is_lost(value: impl Fn(f64) -> f64, x: f64, derivative: f64) -> Option<bool> {
    let [difference, shorter] = [STEP, STEP / 3.0].map(|step| {
        let step = step * x.abs().max(1.0);
        let [up, down] = [x + step, x - step].map(&value);
        let difference = (up - down) / (2.0 * step);
        let most = difference.abs().max(derivative.abs());
        (most > ROUNDED / DIFFERS * (up.abs() + down.abs()) / step).then_some(difference)
    });
    let (difference, shorter) = (difference?, shorter?);
    let most = difference.abs().max(derivative.abs());
    let tells = (difference - shorter).abs() <= 0.1 * DIFFERS * most;
    tells.then(|| (difference - derivative).abs() > DIFFERS * most)
}

/// Whether it is at all points at which differences tell.
fn is_lost_everywhere(at_point: impl Fn(usize) -> Option<bool>) -> bool {
    let told: Vec<bool> = (0..POINTS).filter_map(at_point).collect();
    told.len() >= ENOUGH && told.into_iter().all(|lost| lost)
}

impl PlacedElement {
    /// The first argument by which it loses derivatives.
    fn find_lost(&self, at: &NodeView<f64>) -> Option<Argument> {
        let of_q = self.q.iter().enumerate();
        let of_q = of_q.flat_map(|(i, &q)| [(Slot::Q(i), Argument::Coordinate(q)), (Slot::V(i), Argument::Velocity(q))]);
        let of_u = self.u.iter().enumerate().map(|(k, &u)| (Slot::U(k), Argument::Control(u)));
        let of_b = self.b.iter().enumerate().filter_map(|(p, b)| Some((Slot::B(p), Argument::Design(b.bound()?.0))));
        let mut all = of_q.chain(of_u).chain([(Slot::T, Argument::Time)]).chain(of_b);
        let found = all.find(|(slot, _)| {
            is_lost_everywhere(|k| self.loses_value(at, *slot, k)) || is_lost_everywhere(|k| self.loses_slope(at, *slot, k))
        });
        found.map(|(_, argument)| argument)
    }

    fn read_aside(&self, at: &NodeView<f64>, k: usize, slot: Slot) -> f64 {
        let x = self.read(at, slot);
        if let Slot::B(_) = slot { x } else { x + aside(k, self.formula.shape().number(slot), x) }
    }

    /// Of T, −V and σᵀΦ, which 𝓛_v and 𝓛_q are made of.
    fn loses_value(&self, at: &NodeView<f64>, slot: Slot, k: usize) -> Option<bool> {
        use ElementKind::{Holonomic, Kinetic, Potential};
        let kind = self.formula.kind();
        let component = match (kind, slot) {
            (Kinetic, Slot::V(i)) | (Holonomic, Slot::Q(i)) => Component::Momentum(i),
            (Kinetic | Potential, Slot::Q(i)) => Component::Force(i),
            _ => return None,
        };
        let read = |other| self.read_aside(at, k, other);
        let value = |x: f64| {
            let (mut j, mut sum) = (0, 0.0);
            Values::<f64>::values(&*self.formula, &|other| if other == slot { x } else { read(other) }, &mut |value| {
                let weight = match kind {
                    Holonomic => read(Slot::Sigma(j)),
                    Potential => -1.0,
                    _ => 1.0,
                };
                (j, sum) = (j + 1, sum + weight * value);
            });
            sum
        };
        let mut derivative = 0.0;
        OnNumbers::<f64>::first(&*self.formula, &read, &mut |of, x| {
            if of == component {
                derivative += x;
            }
        });
        is_lost(value, read(slot), derivative)
    }

    /// Of 𝓛_v, 𝓛_q + Q and dΦ/dt.
    fn loses_slope(&self, at: &NodeView<f64>, slot: Slot, k: usize) -> Option<bool> {
        let read = |other| self.read_aside(at, k, other);
        let weight = |j: usize| 1.0 + 0.3 * (j as f64).sin();
        let value = |x: f64| {
            let (mut j, mut sum) = (0, 0.0);
            let read = |other| if other == slot { x } else { read(other) };
            OnNumbers::<f64>::first(&*self.formula, &read, &mut |_, value| {
                (j, sum) = (j + 1, sum + weight(j) * value);
            });
            sum
        };
        let (mut j, mut derivative) = (0, 0.0);
        let seeded = |other| {
            let x = Slope::from_re(read(other));
            if other == slot { x.derivative(0) } else { x }
        };
        OnNumbers::<Slope>::first(&*self.formula, &seeded, &mut |_, x| {
            (j, derivative) = (j + 1, derivative + weight(j) * slope(&x));
        });
        is_lost(value, read(slot), derivative)
    }
}

impl PlacedCost {
    /// The first argument by which it loses derivatives.
    fn find_lost(&self, at: &NodeView<f64>) -> Option<Argument> {
        let found = (0..self.shape.len()).find(|&i| {
            is_lost_everywhere(|k| {
                let read = |i: usize| {
                    let x = self.argument(at, i);
                    x + aside(k, i, x)
                };
                let constant = |p: usize| self.b[p].value(at.design);
                let value =
                    |x: f64| self.evaluate::<f64>(&*self.cost, |other| if other == i { x } else { read(other) }, constant);
                let seeded = |other: usize| hyper(read(other), if other == i { 1.0 } else { 0.0 }, 0.0, 0.0);
                let there = self.evaluate::<Hyper>(&*self.cost, seeded, |p| hyper(constant(p), 0.0, 0.0, 0.0));
                is_lost(value, read(i), hyper_parts(&there)[1])
            })
        });
        found.map(|i| Argument::of_cost(self.shape.places[i]))
    }
}

impl System {
    /// What the derivatives of its formulas do not know of.
    pub(crate) fn lost_derivatives(&self) -> &[Warning] {
        &self.lost_derivatives
    }

    /// Looks at the formulas that look at values.
    pub(super) fn find_lost_derivatives(&self) -> Vec<Warning> {
        let zeros = vec![0.0; self.n.max(self.m).max(self.k)];
        let design = self.parameters.values(&self.design);
        let (v, sigma, u) = (&zeros[..self.n], &zeros[..self.m], &zeros[..self.k]);
        let at = NodeView::of_equations([&self.initial, v, sigma], (u, 0.0, &design));
        let branches = |obstacle: Option<Obstacle>| obstacle == Some(Obstacle::Branches);
        let elements = self.formulas.elements.iter().filter(|element| branches(element.formula.obstacle));
        let elements = elements.filter_map(|element| {
            let lost = guarded(|| self.item(element.place).find_lost(&at)).flatten();
            lost.map(|argument| (&element.name, argument))
        });
        let costs = self.costs.items().iter().filter(|cost| branches(cost.obstacle));
        let costs =
            costs.filter_map(|cost| guarded(|| cost.find_lost(&at)).flatten().map(|argument| (&cost.name, argument)));
        let warning = |(name, argument): (&String, Argument)| Warning::LostDerivative {
            element: name.clone(),
            argument: self.argument_name(argument),
        };
        elements.chain(costs).map(warning).collect()
    }
}
