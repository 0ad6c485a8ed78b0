//! A model function is written once and gives the same value on every number type.

use hamiltonian_adjoint::planar::Revolute;
use hamiltonian_adjoint::{Constraint, Cx, Scalar};
use nalgebra::SVector;
use num_dual::{Dual, Dual2SVec, Dual64, DualSVec, DualSVec64};

/// Every function of `Scalar`, in a formula that is smooth where it is used.
struct Model;

impl Constraint<3, 3, 2> for Model {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, t: S) -> SVector<S, 3> {
        let (sin, cos) = (q[0] * b[0]).sin_cos();
        let trigonometric = sin + cos.powi(3) + (q[1] * 0.3).tan() + (q[2] * 0.4).asin() + (q[2] * 0.2).acos() + q[0].atan();
        let growing = (q[1] * q[1] + b[1]).sqrt() + (-q[0]).exp() + q[1].exp_m1() + q[2].ln_1p() + (q[0] + 1.0).ln();
        let other = q[0].sinh() + q[1].cosh() + q[2].tanh() + q[1].atan2(q[0]) + q[0].hypot(q[2]) + q[2].powf(2.5);
        let branching = q[0].abs() + q[1].max(q[2]) + q[1].min(q[2]) + (q[0] + 2.0).recip();
        SVector::from([trigonometric * t, growing - other, branching / (t + 1.0)])
    }
}

const Q: [f64; 3] = [0.7, 0.4, 0.9];
const B: [f64; 2] = [1.3, 0.8];
const TIME: f64 = 0.6;

/// The real values of the model on numbers of type S, made from reals by `lift`.
fn values<S: Scalar>(lift: impl Fn(f64) -> S) -> [f64; 3] {
    let (q, b) = (SVector::from(Q.map(&lift)), SVector::from(B.map(&lift)));
    Model.phi(&q, &b, lift(TIME)).map(|phi| phi.re()).into()
}

/// An input with derivative parts, so that no part is zero by chance.
fn assert_same<S: Scalar>(name: &str, lift: impl Fn(f64) -> S) {
    let (plain, lifted) = (values(|x| x), values(lift));
    for (a, b) in plain.iter().zip(&lifted) {
        assert!((a - b).abs() <= 4.0 * f64::EPSILON * a.abs(), "{name}: {lifted:?} instead of {plain:?}");
    }
}

#[test]
fn a_model_has_the_same_value_on_every_number_type() {
    assert_same("Cx", |x| Cx::new(x, 1e-30));
    assert_same("Dual64", |x| Dual64::new(x, 1.0));
    assert_same("DualSVec64<6>", |x| DualSVec64::<6>::from_re(x).derivative(2));
    assert_same("Dual<DualSVec<Cx, 6>>", |x| {
        let inner: DualSVec<Cx, 6> = DualSVec::from_re(Cx::new(x, 1e-30)).derivative(1);
        Dual::new(inner, DualSVec::from_re(Cx::from(0.5)))
    });
    assert_same("Dual2SVec<Dual64, 2>", |x| {
        let number: Dual2SVec<Dual64, 2> = Dual2SVec::from_re(Dual64::new(x, 1.0)).derivative(0);
        number
    });
}

/// ∂Φ₀/∂q₁, ∂Φ₁/∂q₁, ∂Φ₂/∂q₁ by an input that only q₁ carries.
fn slope<S: Scalar>(lift: impl Fn(f64) -> S, seed: S, part: impl Fn(S) -> f64) -> [f64; 3] {
    let mut q = SVector::from(Q.map(&lift));
    q[1] = seed;
    Model.phi(&q, &SVector::from(B.map(&lift)), lift(TIME)).map(part).into()
}

#[test]
fn a_model_has_the_same_derivative_on_every_number_type() {
    let reference = slope(Dual64::from_re, Dual64::new(Q[1], 1.0), |x| x.eps);
    let complex = slope(Cx::from, Cx::new(Q[1], 1e-30), |x| x.0.im / 1e-30);
    let vector =
        slope(DualSVec64::<6>::from_re, DualSVec64::from_re(Q[1]).derivative(4), |x| x.eps.0.map_or(0.0, |eps| eps[4]));
    let nested = slope(
        |x| Dual::from_re(DualSVec::<Cx, 6>::from_re(Cx::from(x))),
        Dual::from_re(DualSVec::<Cx, 6>::from_re(Cx::new(Q[1], 1e-30))),
        |x| x.re.re.0.im / 1e-30,
    );
    for (name, slope) in [("Cx", complex), ("DualSVec64", vector), ("nested", nested)] {
        for (a, b) in reference.iter().zip(&slope) {
            assert!((a - b).abs() <= 1e-14 * a.abs(), "{name}: {slope:?} instead of {reference:?}");
        }
    }
}

#[test]
fn a_shipped_joint_can_be_called_on_every_number_type() {
    let q = [0.1, 0.2, 0.3, 0.9, -0.4, 1.1];
    let b = [0.5, 0.0, -0.5, 0.1];
    let plain = Revolute.phi(&SVector::from(q), &SVector::from(b), 0.0);
    let complex = Revolute.phi(&SVector::from(q.map(Cx::from)), &SVector::from(b.map(Cx::from)), Cx::from(0.0));
    assert!((complex.map(|phi| phi.re()) - plain).norm() < 1e-15);
}
