//! Accelerations and reactions of an element without a program: f, g and their derivatives by num-dual, ε₂ along the motion and ε₁ along an argument.

use nalgebra::SVector;
use num_dual::HyperDual64;

use super::batch::Pair;
use super::cost::CostRows;
use super::item::PlacedElement;
use super::jet::{FirstDerivatives, Jet, Local};
use super::view::NodeView;

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// 𝓛_v, 𝓛_q + Q and dΦ/dt at σ = 0, with derivatives along the motion and along what `seed` chooses.
    fn along_motion(
        &self,
        at: &NodeView<f64>,
        (v_dot, lambda): (&[f64], &[f64]),
        seed: impl FnOnce(&mut Local<HyperDual64, N, M, K>, &mut SVector<HyperDual64, P>),
    ) -> FirstDerivatives<HyperDual64, N, M> {
        let of = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        let moving = |re: f64, rate: f64| HyperDual64::new(re, 0.0, rate, 0.0);
        let mut local = Local {
            q: SVector::from_fn(|i, _| moving(at.q[self.q[i]], at.v[self.q[i]])),
            v: SVector::from_fn(|i, _| moving(at.v[self.q[i]], of(v_dot, self.q[i]))),
            sigma: SVector::from_fn(|j, _| moving(0.0, of(lambda, self.sigma[j]))),
            u: SVector::from_fn(|k, _| HyperDual64::from(at.u[self.u[k]])),
            t: moving(at.t, 1.0),
        };
        let mut b = self.b(at.design).map(HyperDual64::from);
        seed(&mut local, &mut b);
        self.jet.first(&local, &b)
    }

    /// Adds f and g where v̇ = 0 and λ = 0.
    pub fn add_acceleration(&self, at: &NodeView<f64>, right: &mut Pair) {
        let first = self.along_motion(at, (&[], &[]), |_, _| {});
        for (i, &coordinate) in self.q.iter().enumerate() {
            right.v[coordinate] += first.force[i].re - first.l_v[i].eps2;
        }
        for (j, phi_dot) in first.phi_dot.iter().enumerate() {
            right.sigma[self.sigma[j]] -= phi_dot.eps2;
        }
    }

    /// Adds the derivatives of c·f + e·g.
    pub fn pull_back_acceleration(&self, at: &NodeView<f64>, with: &Pair, rows: &mut CostRows) {
        let slope = |seed: &dyn Fn(&mut Local<HyperDual64, N, M, K>, &mut SVector<HyperDual64, P>)| {
            let first = self.along_motion(at, (at.v_dot, at.lambda), seed);
            let momenta = (0..N).map(|i| with.v[self.q[i]] * (first.force[i].eps1 - first.l_v[i].eps1eps2));
            let equations = (0..M).map(|j| with.sigma[self.sigma[j]] * -first.phi_dot[j].eps1eps2);
            momenta.chain(equations).sum::<f64>()
        };
        for (i, &coordinate) in self.q.iter().enumerate() {
            rows.q[coordinate] += slope(&|local, _| local.q[i].eps1 = 1.0);
            // The velocity is the rate of the coordinate, too.
            rows.v[coordinate] += slope(&|local, _| (local.v[i].eps1, local.q[i].eps1eps2) = (1.0, 1.0));
        }
        for (k, &channel) in self.u.iter().enumerate() {
            rows.u[channel] += slope(&|local, _| local.u[k].eps1 = 1.0);
        }
        for (p, b) in self.b.iter().enumerate() {
            if let Some((design, factor)) = b.bound() {
                rows.design[design] += factor * slope(&|_, b| b[p].eps1 = 1.0);
            }
        }
        rows.time += slope(&|local, _| local.t.eps1 = 1.0);
    }
}
