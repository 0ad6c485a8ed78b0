//! [`Layout`]: the layout of a point, a list of all arguments of all elements and costs.

use super::connections::Connections;
use super::differentiated::Component;
use super::element::Element;
use super::shape::{Place, Shape, Slot};
use super::vectors::Covector;
use super::view::NodeView;

/// The shape of a scene: a point contains its arguments in the order of their numbers.
pub(crate) type Layout = Shape;

impl Layout {
    /// The index of an argument of a formula in a point.
    pub(crate) fn source(self, to: &Connections, place: Place) -> usize {
        match place {
            Place::Of(slot) => self.number(to.argument(slot).0),
            Place::C(i) => self.c() + to.q[i],
            Place::D(i) => self.d() + to.q[i],
            Place::E(j) => self.e() + to.sigma[j],
            Place::Rate(slot) => self.rate(to.argument(slot).0),
        }
    }

    /// The index of a component of an element among all sums.
    pub(crate) fn sum(self, element: &Element, component: Component) -> usize {
        component.place((&element.to.q, &element.to.sigma), self.n)
    }

    /// Stores the arguments of the equations.
    pub(crate) fn load(self, at: &NodeView<f64>, point: &mut [f64]) {
        let Shape { n, m, k, .. } = self;
        point[..n].copy_from_slice(at.q);
        point[n..2 * n].copy_from_slice(at.v);
        let rest = &mut point[5 * n + m..];
        rest[..m].copy_from_slice(at.sigma);
        rest[m..m + k].copy_from_slice(at.u);
        point[self.c() - 1] = at.t;
    }

    /// Stores the lists of arguments that are read.
    #[inline]
    pub(in crate::system) fn load_lists(self, at: &NodeView<f64>, is_read: impl Fn(usize) -> bool, mut point: &mut [f64]) {
        for (which, len) in self.lengths().into_iter().enumerate() {
            let (own, rest) = point.split_at_mut(len);
            if is_read(which) {
                own.iter_mut().zip(at.list(which)).for_each(|(own, x)| *own = *x);
            }
            point = rest;
        }
    }

    /// Stores v̇ and λ.
    pub(crate) fn load_accelerations(self, at: &NodeView<f64>, point: &mut [f64]) {
        let lists = [Slot::VDot(0), Slot::Lambda(0)].map(|slot| slot.place().0);
        self.load_lists(at, |list| lists.contains(&list), point);
    }

    /// Stores a direction of all arguments and parameters as rates.
    pub(crate) fn load_direction(self, along: &NodeView<f64>, point: &mut [f64]) {
        self.load_lists(along, |_| true, &mut point[self.rates()..]);
    }

    pub(crate) fn load_covector(self, with: &Covector, point: &mut [f64]) {
        let (c, rest) = point[self.c()..].split_at_mut(self.n);
        let (d, rest) = rest.split_at_mut(self.n);
        let (e, _) = rest.split_at_mut(self.m);
        c.copy_from_slice(with.c);
        d.copy_from_slice(with.d);
        e.copy_from_slice(with.e);
    }
}
