//! Holonomic constraints: σᵀ dΦ/dt and all its derivatives, from Φ(q, t) alone.
//!
//! Seed q with v and t with 1 in a dual number, q + ε v, t + ε. The ε-part of Φ is then dΦ/dt = Φ_q v + Φ_t. With these numbers as the
//! inner numbers of a second-order dual in q, one evaluation of Φ yields
//!
//! ```text
//!   real part:  Φ, Φ_q, Φ_qq          ε-part:  dΦ/dt, (dΦ/dt)_q, (dΦ/dt)_qq
//! ```

use nalgebra::SVector;
use num_dual::{Dual, Dual2SVec, Dual64, DualSVec};

use super::jet::{FirstDerivatives, Jet, Local};
use super::kind::{ElementKind, Number};
use super::typed::{each, vector};
use crate::{Constraint, Scalar};

/// q + ε v, each component seeded with its own derivative. Compiled once per size rather than once per element.
fn moving<R: Number, const N: usize>(q: &SVector<R, N>, v: &SVector<R, N>) -> SVector<Dual<DualSVec<R, N>>, N> {
    vector(|i| Dual::new(DualSVec::from_re(q[i]).derivative(i), DualSVec::from_re(v[i])))
}

/// As [`moving`], with second derivatives.
fn seeded<const N: usize>(q: &SVector<f64, N>, v: &SVector<f64, N>) -> SVector<Dual2SVec<Dual64, N>, N> {
    vector(|i| Dual2SVec::from_re(Dual64::new(q[i], v[i])).derivative(i))
}

/// A holonomic constraint: 𝓛_v = Φ_qᵀσ, 𝓛_q = (dΦ/dt)_qᵀσ.
pub struct Holonomic<E>(pub E);

impl<E, const N: usize, const M: usize, const P: usize> Jet<N, M, 0, P> for Holonomic<E>
where
    E: Constraint<N, M, P>,
{
    const KIND: ElementKind = ElementKind::Holonomic;

    fn first<R: Number>(&self, at: &Local<R, N, M, 0>, b: &SVector<R, P>) -> FirstDerivatives<R, N, M> {
        let (q, b) = (moving(&at.q, &at.v), each(b, |b| Dual::from_re(DualSVec::from_re(b))));
        let one = DualSVec::from_re(R::one());
        let phi = self.0.phi(&q, &b, Dual::new(DualSVec::from_re(at.t), one));
        let mut sums = FirstDerivatives::zero();
        for (j, phi) in phi.iter().enumerate() {
            sums.phi_dot[j] = phi.eps.re;
            if let Some(phi_q) = phi.re.eps.0 {
                sums.l_v += phi_q * at.sigma[j];
            }
            if let Some(phi_dot_q) = phi.eps.eps.0 {
                sums.force += phi_dot_q * at.sigma[j];
            }
        }
        sums
    }

    fn phi<R: Number>(&self, q: &SVector<R, N>, b: &SVector<R, P>, t: R) -> SVector<R, M> {
        // On the numbers for which the formula is compiled anyway.
        let still = |x: &SVector<R, N>| each(x, |x| Dual::from_re(DualSVec::<R, N>::from_re(x)));
        let b = each(b, |b| Dual::from_re(DualSVec::from_re(b)));
        each(&self.0.phi(&still(q), &b, Dual::from_re(DualSVec::from_re(t))), |phi| phi.re.re)
    }

    fn values<S: Scalar>(&self, at: &Local<S, N, M, 0>, b: &SVector<S, P>, put: &mut dyn FnMut(S)) {
        self.0.phi(&at.q, b, at.t).iter().for_each(|phi| put(*phi));
    }

    fn blocks(
        &self,
        at: &Local<f64, N, M, 0>,
        b: &SVector<f64, P>,
        first: &mut FirstDerivatives<f64, N, M>,
        blocks: &mut [f64],
    ) {
        let phi = self.0.phi(&seeded(&at.q, &at.v), &each(b, From::from), Dual2SVec::from_re(Dual64::new(at.t, 1.0)));

        blocks.fill(0.0);
        let (phi_qq, rest) = blocks.split_at_mut(N * N);
        let (phi_dot_qq, rest) = rest.split_at_mut(N * N);
        let (phi_q, phi_dot_q) = rest.split_at_mut(M * N);
        for (j, phi) in phi.iter().enumerate() {
            let sigma = at.sigma[j];
            first.phi_dot[j] += phi.re.eps;
            if let Some(gradient) = phi.v1.0 {
                for i in 0..N {
                    first.l_v[i] += gradient[i].re * sigma;
                    first.force[i] += gradient[i].eps * sigma;
                    phi_q[j * N + i] = gradient[i].re;
                    phi_dot_q[j * N + i] = gradient[i].eps;
                }
            }
            if let Some(hessian) = phi.v2.0 {
                for ((entry, entry_dot), second) in phi_qq.iter_mut().zip(phi_dot_qq.iter_mut()).zip(hessian.iter()) {
                    *entry += second.re * sigma;
                    *entry_dot += second.eps * sigma;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Φ = (x sin y, y² + t x), with all derivatives by hand.
    struct Sample;
    impl Constraint<2, 2> for Sample {
        fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, t: S) -> SVector<S, 2> {
            SVector::from([q[0] * q[1].sin(), q[1] * q[1] + t * q[0]])
        }
    }

    #[test]
    fn blocks_are_the_hand_derived_ones_and_agree_with_the_plain_formula() {
        let (x, y, dx, dy, t) = (0.7, 0.4, -1.3, 2.1, 0.9);
        let sigma = SVector::from([1.5, -0.25]);
        let at = Local { q: SVector::from([x, y]), v: SVector::from([dx, dy]), sigma, u: SVector::zeros(), t };
        let jet = Holonomic(Sample);
        let mut first = FirstDerivatives::zero();
        let mut blocks = [0.0; 16];
        jet.blocks(&at, &SVector::zeros(), &mut first, &mut blocks);
        let plain = jet.first(&at, &SVector::zeros());
        assert!((first.l_v - plain.l_v).norm() < 1e-15 && (first.force - plain.force).norm() < 1e-15);
        assert!((first.phi_dot - plain.phi_dot).norm() < 1e-15);

        let (s, c) = f64::sin_cos(y);
        let expected = [
            [0.0, c * sigma[0], c * sigma[0], -x * s * sigma[0] + 2.0 * sigma[1]],
            [0.0, -s * dy * sigma[0], -s * dy * sigma[0], (-dx * s - x * c * dy) * sigma[0]],
            [s, x * c, t, 2.0 * y],
            [c * dy, dx * c - x * s * dy, 1.0, 2.0 * dy],
        ];
        for (got, expected) in blocks.iter().zip(expected.as_flattened()) {
            assert!((got - expected).abs() < 1e-15, "{blocks:?}");
        }
    }
}
