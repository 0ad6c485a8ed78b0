//! Elements seen through automatic differentiation: what each kind contributes to the equations of a step.

use nalgebra::SVector;
use num_dual::{Derivative, DualNum, DualSVec, DualSVec64};

use crate::Scalar;

/// A number with one derivative, or without: num-dual's `Dual64` cannot tell a derivative that vanishes from none, and the root of a constant
/// zero has a derivative that is zero, while that of a number that vanishes has not.
pub type Slope = DualSVec64<1>;

/// The derivative.
#[inline]
pub fn slope(x: &Slope) -> f64 {
    x.eps.0.map_or(0.0, |eps| eps[0])
}

/// A number with derivatives along two directions and the mixed one, each there or not: ε₁ inside, ε₂ outside.
pub type Hyper = DualSVec<Slope, 1>;

/// A hyper-dual number by its parts; what vanishes counts as none.
pub fn hyper(re: f64, eps1: f64, eps2: f64, eps1eps2: f64) -> Hyper {
    let with = |x: f64, slope: f64| {
        let eps = if slope == 0.0 { Derivative::none() } else { Derivative::some(SVector::from([slope])) };
        Slope::new(x, eps)
    };
    let is_none = eps2 == 0.0 && eps1eps2 == 0.0;
    let eps = if is_none { Derivative::none() } else { Derivative::some(SVector::from([with(eps2, eps1eps2)])) };
    Hyper::new(with(re, eps1), eps)
}

/// The value and the derivatives along ε₁, ε₂ and both.
#[inline]
pub fn hyper_parts(x: &Hyper) -> [f64; 4] {
    let [eps2, mixed] = x.eps.0.map_or([0.0; 2], |eps| [eps[0].re, slope(&eps[0])]);
    [x.re.re, slope(&x.re), eps2, mixed]
}

/// A number that formulas and their derivatives are evaluated with.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

/// The arguments of one element.
#[derive(Clone, Copy, Debug)]
pub struct Local<R, const N: usize, const M: usize, const K: usize> {
    pub q: SVector<R, N>,
    pub v: SVector<R, N>,
    pub sigma: SVector<R, M>,
    pub u: SVector<R, K>,
    pub t: R,
}

impl<const N: usize, const M: usize, const K: usize> Local<f64, N, M, K> {
    /// The same with room for one derivative.
    pub fn lift(&self) -> Local<Slope, N, M, K> {
        Local {
            q: self.q.map(Slope::from_re),
            v: self.v.map(Slope::from_re),
            sigma: self.sigma.map(Slope::from_re),
            u: self.u.map(Slope::from_re),
            t: Slope::from_re(self.t),
        }
    }
}

/// What one element adds to 𝓛_v, to 𝓛_q + Q and to dΦ/dt.
#[derive(Clone, Copy)]
pub struct FirstDerivatives<R, const N: usize, const M: usize> {
    pub l_v: SVector<R, N>,
    pub force: SVector<R, N>,
    pub phi_dot: SVector<R, M>,
}

impl<R: Number, const N: usize, const M: usize> FirstDerivatives<R, N, M> {
    pub fn zero() -> Self {
        FirstDerivatives { l_v: SVector::zeros(), force: SVector::zeros(), phi_dot: SVector::zeros() }
    }
}

/// Which second derivatives a kind of element has, besides qq (𝓛_qq + Q_q).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementKind {
    /// Kinetic energy: 𝓛_vv, 𝓛_vq = 𝓛_qvᵀ, 𝓛_qq.
    Kinetic,
    /// Potential energy: 𝓛_qq.
    Potential,
    /// Applied force: Q_v, Q_q.
    Applied,
    /// Constraint: 𝓛_vq = 𝓛_qv = σᵀΦ_qq, 𝓛_qq = σᵀ(dΦ/dt)_qq, Φ_q, (dΦ/dt)_q.
    Holonomic,
}

impl ElementKind {
    /// How many a × a blocks it has.
    pub const fn squares(self) -> usize {
        match self {
            ElementKind::Kinetic => 3,
            ElementKind::Potential => 1,
            ElementKind::Applied | ElementKind::Holonomic => 2,
        }
    }

    /// The length of the blocks of an element with `a` active coordinates and `m` equations.
    pub const fn length(self, a: usize, m: usize) -> usize {
        self.squares() * a * a + if matches!(self, ElementKind::Holonomic) { 2 * a * m } else { 0 }
    }
}

/// One kind of element: N coordinates, M constraint equations, K controls, P physical constants.
///
/// `first` is the plain formula, generic in the number the simulation runs on. `blocks` gives the same together with
/// all second derivatives, in real numbers.
pub trait Jet<const N: usize, const M: usize, const K: usize, const P: usize>: Send + Sync + 'static {
    const KIND: ElementKind;

    fn first<R: Number>(&self, at: &Local<R, N, M, K>, b: &SVector<R, P>) -> FirstDerivatives<R, N, M>;

    /// Φ itself.
    fn phi<R: Number>(&self, _q: &SVector<R, N>, _b: &SVector<R, P>, _t: R) -> SVector<R, M> {
        SVector::zeros()
    }

    /// The formula itself: T, V, Q or Φ.
    fn values<S: Scalar>(&self, at: &Local<S, N, M, K>, b: &SVector<S, P>, put: &mut dyn FnMut(S));

    /// Adds the first derivatives to `first` and writes the second ones to `blocks`.
    ///
    /// Order: vv, vq, qq (kinetic); qq (potential); Q_v, Q_q (applied); σᵀΦ_qq, σᵀ(dΦ/dt)_qq, Φ_q, (dΦ/dt)_q (holonomic), each by rows.
    fn blocks(
        &self,
        at: &Local<f64, N, M, K>,
        b: &SVector<f64, P>,
        first: &mut FirstDerivatives<f64, N, M>,
        blocks: &mut [f64],
    );
}
