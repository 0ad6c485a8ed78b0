//! Accelerations and reactions of an element without a program: f, g and their derivatives by num-dual, ε₂ along the motion and ε₁ along an argument.

use nalgebra::SVector;

use super::along::seed;
use super::batch::Pair;
use super::cost::CostRows;
use super::item::PlacedElement;
use super::jet::{Jet, Local};
use super::view::NodeView;
use crate::number::{Hyper, hyper, hyper_parts};

/// The direction in which time goes on.
fn motion<'a>(at: &NodeView<'a, f64>, (v_dot, lambda): (&'a [f64], &'a [f64])) -> NodeView<'a, f64> {
    NodeView::of_equations([at.v, v_dot, lambda], (&[], 1.0, &[]))
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// Adds f and g where v̇ = 0 and λ = 0.
    pub fn add_acceleration(&self, at: &NodeView<f64>, right: &mut Pair) {
        let first = self.first_along(at, &motion(at, (&[], &[])), |_, _| {});
        for (i, &coordinate) in self.q.iter().enumerate() {
            right.v[coordinate] += hyper_parts(&first.force[i])[0] - hyper_parts(&first.l_v[i])[2];
        }
        for (j, phi_dot) in first.phi_dot.iter().enumerate() {
            right.sigma[self.sigma[j]] -= hyper_parts(phi_dot)[2];
        }
    }

    /// Adds the derivatives of c·f + e·g.
    pub fn pull_back_acceleration(&self, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        let slope = |seed: &dyn Fn(&mut Local<Hyper, N, M, K>, &mut SVector<Hyper, P>)| {
            let first = self.first_along(at, &motion(at, (at.v_dot, at.lambda)), seed);
            let momenta =
                (0..N).map(|i| with.v[self.q[i]] * (hyper_parts(&first.force[i])[1] - hyper_parts(&first.l_v[i])[3]));
            let equations = (0..M).map(|j| with.sigma[self.sigma[j]] * -hyper_parts(&first.phi_dot[j])[3]);
            momenta.chain(equations).sum::<f64>()
        };
        for (i, &coordinate) in self.q.iter().enumerate() {
            rows.q[coordinate] += slope(&|local, _| seed(&mut local.q[i]));
            // The velocity is the rate of the coordinate, too.
            rows.v[coordinate] += slope(&|local, _| {
                seed(&mut local.v[i]);
                let [q, along, rate, _] = hyper_parts(&local.q[i]);
                local.q[i] = hyper(q, along, rate, 1.0);
            });
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
