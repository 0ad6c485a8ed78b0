//! An element along a direction of its arguments, by num-dual: ε₂ along the direction, ε₁ along an argument.

use nalgebra::SVector;

use super::batch::{Covector, Sums};
use super::cost::CostRows;
use super::item::PlacedElement;
use super::jet::{FirstDerivatives, Jet, Local};
use super::view::NodeView;
use crate::number::{Hyper, hyper, hyper_parts};

/// Differentiates by a number.
pub(super) fn seed(x: &mut Hyper) {
    let [value, _, rate, mixed] = hyper_parts(x);
    *x = hyper(value, 1.0, rate, mixed);
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// 𝓛_v, 𝓛_q + Q and dΦ/dt with derivatives along a direction (what it does not have is zero) and along what `seed` chooses.
    pub(super) fn first_along(
        &self,
        at: &NodeView<f64>,
        along: &NodeView<f64>,
        seed: impl FnOnce(&mut Local<Hyper, N, M, K>, &mut SVector<Hyper, P>),
    ) -> FirstDerivatives<Hyper, N, M> {
        let moving = |x: &[f64], rate: &[f64], i: usize| hyper(x[i], 0.0, rate.get(i).copied().unwrap_or(0.0), 0.0);
        let mut local = Local {
            q: SVector::from_fn(|i, _| moving(at.q, along.q, self.q[i])),
            v: SVector::from_fn(|i, _| moving(at.v, along.v, self.q[i])),
            sigma: SVector::from_fn(|j, _| moving(at.sigma, along.sigma, self.sigma[j])),
            u: SVector::from_fn(|k, _| moving(at.u, along.u, self.u[k])),
            t: hyper(at.t, 0.0, along.t, 0.0),
        };
        let mut b = SVector::from_fn(|p, _| {
            let rate = |(place, factor): (usize, f64)| along.design.get(place).map_or(0.0, |rate| factor * rate);
            hyper(self.b[p].value(at.design), 0.0, self.b[p].bound().map_or(0.0, rate), 0.0)
        });
        seed(&mut local, &mut b);
        self.jet.first(&local, &b)
    }

    /// Adds the changes of 𝓛_v, 𝓛_q + Q and dΦ/dt along the inputs of a direction.
    pub fn add_changes(&self, at: &NodeView<f64>, along: &NodeView<f64>, sums: &mut Sums<f64>) {
        let inputs = NodeView { q: &[], v: &[], sigma: &[], ..*along };
        let first = self.first_along(at, &inputs, |_, _| {});
        let [l_v, force, phi_dot] = sums.parts_mut();
        for (i, &coordinate) in self.q.iter().enumerate() {
            l_v[coordinate] += hyper_parts(&first.l_v[i])[2];
            force[coordinate] += hyper_parts(&first.force[i])[2];
        }
        for (j, &equation) in self.sigma.iter().enumerate() {
            phi_dot[equation] += hyper_parts(&first.phi_dot[j])[2];
        }
    }

    /// Adds the derivatives of the change of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt along a direction.
    pub fn pull_back_along(&self, (at, along): (&NodeView<f64>, &NodeView<f64>), with: &Covector, rows: &mut CostRows) {
        let slope = |seed: &dyn Fn(&mut Local<Hyper, N, M, K>, &mut SVector<Hyper, P>)| {
            hyper_parts(&self.pair(&self.first_along(at, along, seed), with))[3]
        };
        for (i, &coordinate) in self.q.iter().enumerate() {
            rows.q[coordinate] += slope(&|local, _| seed(&mut local.q[i]));
            rows.v[coordinate] += slope(&|local, _| seed(&mut local.v[i]));
        }
        for (j, &equation) in self.sigma.iter().enumerate() {
            rows.sigma[equation] += slope(&|local, _| seed(&mut local.sigma[j]));
        }
        for (k, &channel) in self.u.iter().enumerate() {
            rows.u[channel] += slope(&|local, _| seed(&mut local.u[k]));
        }
        for (p, b) in self.b.iter().enumerate() {
            if let Some((design, factor)) = b.bound() {
                rows.design[design] += factor * slope(&|_, b| seed(&mut b[p]));
            }
        }
        rows.time += slope(&|local, _| seed(&mut local.t));
    }
}
