//! [`Layout`]: the layout of a point, a list of all arguments of all elements.

use super::connections::Connections;
use super::differentiated::Component;
use super::element::Element;
use super::shape::{Place, Slot};
use super::vectors::Covector;
use super::view::NodeView;

/// The numbers of coordinates, equations and controls of a scene. A point contains q, v, σ, u, t, then c, d, e, then the rates of q, v, σ, u, t and,
/// for second derivatives, the rates of the parameters.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) n: usize,
    pub(crate) m: usize,
    pub(crate) k: usize,
}

impl Layout {
    fn t(&self) -> usize {
        2 * self.n + self.m + self.k
    }

    fn rates(&self) -> usize {
        self.t() + 1 + 2 * self.n + self.m
    }

    pub(crate) fn len(&self) -> usize {
        self.rates() + self.t() + 1
    }

    /// The index of an argument of an element in a point.
    pub(crate) fn source(&self, element: &Element, place: Place) -> usize {
        let n = self.n;
        let adjoint = self.t() + 1;
        match place {
            Place::Of(slot) => self.state(&element.to, slot),
            Place::C(i) => adjoint + element.to.q[i],
            Place::D(i) => adjoint + n + element.to.q[i],
            Place::E(j) => adjoint + 2 * n + element.to.sigma[j],
            Place::Rate(Slot::B(p)) => self.len() + element.to.b[p].bound().map_or(0, |(place, _)| place),
            Place::Rate(slot) => self.rates() + self.state(&element.to, slot),
        }
    }

    /// The index of an argument among q, v, σ, u and t; constants and the arguments of costs have none.
    fn state(&self, to: &Connections, slot: Slot) -> usize {
        match slot {
            Slot::Q(i) => to.q[i],
            Slot::V(i) => self.n + to.q[i],
            Slot::Sigma(j) => 2 * self.n + to.sigma[j],
            Slot::U(k) => 2 * self.n + self.m + to.u[k],
            _ => self.t(),
        }
    }

    /// The index of a component of an element among all sums.
    pub(crate) fn sum(&self, element: &Element, component: Component) -> usize {
        component.place((&element.to.q, &element.to.sigma), self.n)
    }

    pub(crate) fn load(&self, at: &NodeView<f64>, point: &mut [f64]) {
        let (q, rest) = point.split_at_mut(self.n);
        let (v, rest) = rest.split_at_mut(self.n);
        let (sigma, rest) = rest.split_at_mut(self.m);
        let (u, rest) = rest.split_at_mut(self.k);
        q.copy_from_slice(at.q);
        v.copy_from_slice(at.v);
        sigma.copy_from_slice(at.sigma);
        u.copy_from_slice(at.u);
        rest[0] = at.t;
    }

    /// Stores v̇ and λ as the rates of v and σ.
    pub(crate) fn load_accelerations(&self, at: &NodeView<f64>, point: &mut [f64]) {
        let (v_dot, rest) = point[self.rates() + self.n..].split_at_mut(self.n);
        v_dot.copy_from_slice(at.v_dot);
        rest[..self.m].copy_from_slice(at.lambda);
    }

    /// Stores a direction of q, v, u, t and of the parameters next to v̇ and λ; the direction of v is stored in the place of d.
    pub(crate) fn load_direction_beside_accelerations(&self, along: &NodeView<f64>, point: &mut [f64]) {
        let d = self.t() + 1 + self.n;
        point[d..d + self.n].copy_from_slice(along.v);
        let (q, rest) = point[self.rates()..].split_at_mut(self.n);
        q.copy_from_slice(along.q);
        let others = along.u.iter().chain([&along.t]).chain(along.design);
        rest[self.n + self.m..].iter_mut().zip(others).for_each(|(rate, x)| *rate = *x);
    }

    /// Stores a direction of all arguments and parameters as rates.
    pub(crate) fn load_direction(&self, along: &NodeView<f64>, point: &mut [f64]) {
        let mut rest = &mut point[self.rates()..];
        for part in [along.q, along.v, along.sigma, along.u, &[along.t], along.design] {
            rest.iter_mut().zip(part).for_each(|(rate, x)| *rate = *x);
            rest = rest.get_mut(part.len()..).unwrap_or_default();
        }
    }

    pub(crate) fn load_covector(&self, with: &Covector, point: &mut [f64]) {
        let (c, rest) = point[self.t() + 1..].split_at_mut(self.n);
        let (d, rest) = rest.split_at_mut(self.n);
        let (e, _) = rest.split_at_mut(self.m);
        c.copy_from_slice(with.c);
        d.copy_from_slice(with.d);
        e.copy_from_slice(with.e);
    }
}
