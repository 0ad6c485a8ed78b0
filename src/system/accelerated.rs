//! Accelerations and reactions of an element without a program: f, g and their derivatives by num-dual, ε₂ along the motion and ε₁ along an argument.

use nalgebra::SVector;

use super::batch::Pair;
use super::cost::CostRows;
use super::item::PlacedElement;
use super::jet::{FirstDerivatives, Hyper, Jet, Local, hyper, hyper_parts};
use super::view::NodeView;

/// Differentiates by a number.
fn seed(x: &mut Hyper) {
    let [value, _, rate, mixed] = hyper_parts(x);
    *x = hyper(value, 1.0, rate, mixed);
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// 𝓛_v, 𝓛_q + Q and dΦ/dt at σ = 0, with derivatives along the motion and along what `seed` chooses.
    fn along_motion(
        &self,
        at: &NodeView<f64>,
        (v_dot, lambda): (&[f64], &[f64]),
        seed: impl FnOnce(&mut Local<Hyper, N, M, K>, &mut SVector<Hyper, P>),
    ) -> FirstDerivatives<Hyper, N, M> {
        let of = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        let moving = |re: f64, rate: f64| hyper(re, 0.0, rate, 0.0);
        let mut local = Local {
            q: SVector::from_fn(|i, _| moving(at.q[self.q[i]], at.v[self.q[i]])),
            v: SVector::from_fn(|i, _| moving(at.v[self.q[i]], of(v_dot, self.q[i]))),
            sigma: SVector::from_fn(|j, _| moving(0.0, of(lambda, self.sigma[j]))),
            u: SVector::from_fn(|k, _| moving(at.u[self.u[k]], 0.0)),
            t: moving(at.t, 1.0),
        };
        let mut b = self.b(at.design).map(|b| moving(b, 0.0));
        seed(&mut local, &mut b);
        self.jet.first(&local, &b)
    }

    /// Adds f and g where v̇ = 0 and λ = 0.
    pub fn add_acceleration(&self, at: &NodeView<f64>, right: &mut Pair) {
        let first = self.along_motion(at, (&[], &[]), |_, _| {});
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
            let first = self.along_motion(at, (at.v_dot, at.lambda), seed);
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
