//! A model function is written once and gives the same value on every number type.

use hamiltonian_adjoint::planar::Revolute;
use hamiltonian_adjoint::{Constraint, Cx, Scalar};
use nalgebra::SVector;
use num_dual::{Dual, Dual2SVec, Dual2SVec64, Dual64, DualSVec, DualSVec64};

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

/// A value and its derivative.
type Tangent = (f64, f64);

/// Value and derivative at x on a vector dual, which knows whether it has a derivative.
fn at<F: Fn(DualSVec64<1>) -> DualSVec64<1>>(x: f64, f: F) -> Tangent {
    let y = f(DualSVec64::from_re(x).derivative(0));
    (y.re, y.eps.0.map_or(0.0, |eps| eps[0]))
}

#[test]
fn functions_have_the_derivatives_that_exist_at_the_ends_of_their_domains() {
    use std::f64::consts::{FRAC_PI_2, PI};
    const INF: f64 = f64::INFINITY;
    let ends: [(&str, Tangent, Tangent); 18] = [
        ("x^1.5", at(0.0, |x| x.powf(1.5)), (0.0, 0.0)),
        ("x^2.5", at(0.0, |x| x.powf(2.5)), (0.0, 0.0)),
        ("x^3.0", at(0.0, |x| x.powf(3.0)), (0.0, 0.0)),
        ("x^1.0", at(0.0, |x| x.powf(1.0)), (0.0, 1.0)),
        ("x^0.0", at(0.0, |x| x.powf(0.0)), (1.0, 0.0)),
        ("x^0.3", at(0.0, |x| x.powf(0.3)), (0.0, INF)),
        ("x^-0.5", at(0.0, |x| x.powf(-0.5)), (INF, -INF)),
        ("x^-1", at(0.0, |x| x.powi(-1)), (INF, -INF)),
        ("√x", at(0.0, |x| x.sqrt()), (0.0, INF)),
        ("ln x", at(0.0, |x| x.ln()), (-INF, INF)),
        ("ln(1 + x)", at(-1.0, |x| x.ln_1p()), (-INF, INF)),
        ("asin 1", at(1.0, |x| x.asin()), (FRAC_PI_2, INF)),
        ("asin -1", at(-1.0, |x| x.asin()), (-FRAC_PI_2, INF)),
        ("acos 1", at(1.0, |x| x.acos()), (0.0, -INF)),
        ("acos -1", at(-1.0, |x| x.acos()), (PI, -INF)),
        // Where x^(n − 3) overflows, and with it what num-dual makes of it.
        ("x^1.5", at(1e-220, |x| x.powf(1.5)), (0.0, 1.5e-110)),
        ("x^-1", at(1e-120, |x| x.powi(-1)), (1e120, -1e240)),
        ("x^0.5", at(1e250, |x| x.powf(0.5)), (1e125, 0.5e-125)),
    ];
    for (name, (value, slope), expected) in ends {
        let close = |a: f64, b: f64| a == b || (a - b).abs() <= 1e-14 * b.abs();
        assert!(close(value, expected.0) && close(slope, expected.1), "{name}: {value}, {slope} instead of {expected:?}");
    }
    // No direction is a derivative of the distance from a point, or of the angle about it, there.
    assert!(at(0.0, |x| x.hypot(x)).1.is_nan() && at(0.0, |x| x.atan2(x)).1.is_nan());
    assert_eq!((at(0.0, |x| x.hypot(x)).0, at(0.0, |x| x.atan2(x)).0), (0.0, 0.0));
}

#[test]
fn second_derivatives_that_exist_at_zero_are_returned() {
    let second = |n: f64| {
        let y = Scalar::powf(&Dual2SVec64::<1>::from_re(0.0).derivative(0), n);
        (y.re, y.v1.0.map_or(0.0, |v| v[0]), y.v2.0.map_or(0.0, |v| v[0]))
    };
    assert_eq!(second(2.5), (0.0, 0.0, 0.0));
    assert_eq!(second(2.0), (0.0, 0.0, 2.0));
    assert_eq!(second(3.5), (0.0, 0.0, 0.0));
    assert!(!second(1.5).2.is_finite());
}

#[test]
fn a_power_of_zero_has_derivatives_that_vanish_and_not_none() {
    // x² and x^1.25: no rule says what becomes of 0 · ∞.
    assert!(at(0.0, |x| x.powf(2.5).powf(0.8)).1.is_nan() && at(0.0, |x| x.powf(2.5).sqrt()).1.is_nan());
    assert!(at(0.0, |x| x.sqrt().powf(2.5)).1.is_nan());
}

#[test]
fn what_does_not_depend_on_an_argument_has_no_derivative_where_functions_have_none() {
    // max picks the constant.
    let none = |f: fn(DualSVec64<1>) -> DualSVec64<1>| at(-0.5, |x| f(x.max(DualSVec64::from(0.0)))).1;
    let one = |f: fn(DualSVec64<1>) -> DualSVec64<1>| at(1.5, |x| f(x.min(DualSVec64::from(1.0)))).1;
    let functions: [fn(DualSVec64<1>) -> DualSVec64<1>; 5] =
        [|x| x.sqrt(), |x| x.powf(0.5), |x| x.powf(1.5), |x| x.hypot(x), |x| x.ln()];
    for f in functions {
        assert_eq!(none(f), 0.0);
    }
    assert_eq!((one(|x| x.asin()), one(|x| x.acos())), (0.0, 0.0));
}

#[test]
fn complex_numbers_have_the_values_of_real_ones_at_the_ends_of_domains() {
    let pairs = [
        (Scalar::asin(&Cx::from(1.0)), 1f64.asin()),
        (Scalar::asin(&Cx::from(-1.0)), -(1f64.asin())),
        (Scalar::acos(&Cx::from(1.0)), 0.0),
        (Scalar::recip(&Cx::from(0.0)), f64::INFINITY),
        (Scalar::sqrt(&Cx::from(0.0)), 0.0),
        (Scalar::powf(&Cx::from(0.0), 1.5), 0.0),
        (Scalar::atan2(&Cx::from(0.0), Cx::from(0.0)), 0.0),
    ];
    for (k, (value, expected)) in pairs.into_iter().enumerate() {
        assert!(value.0.re == expected && value.0.im == 0.0, "{k}: {value:?}");
    }
}

#[test]
fn whole_powers_of_negative_numbers_have_a_complex_step() {
    for x in [-3.0, -0.7] {
        for n in [1.0, 2.0, 3.0, -1.0, -4.0, 40.0] {
            let (slope, exact) = (Scalar::powf(&Cx::new(x, 1e-30), n).0.im / 1e-30, n * f64::powf(x, n - 1.0));
            assert!((slope - exact).abs() <= 1e-14 * exact.abs(), "{x}^{n}: {slope} for {exact}");
        }
    }
}

#[test]
fn functions_of_complex_numbers_have_values_where_those_of_real_ones_do() {
    fn functions<S: Scalar>(x: S) -> [S; 9] {
        [x.sqrt(), x.ln(), x.powf(1.5), x.powf(2.0), x.ln_1p(), x.asin(), x.acos(), x.powi(-3), x.max(x.sqrt())]
    }
    for x in [-2.5, -1.2, -0.3, 0.4, 0.9, 1.7] {
        for (k, (real, complex)) in functions(x).into_iter().zip(functions(Cx::new(x, 1e-30))).enumerate() {
            let re = complex.0.re;
            let is_same = real == re || real.is_nan() && re.is_nan() || (real - re).abs() <= 4e-16 * real.abs();
            assert!(is_same, "function {k} of {x}: {real}, {re}");
        }
    }
}
