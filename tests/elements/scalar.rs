//! A model function is written once and gives the same value on every number type.

use hamiltonian_adjoint::planar::Revolute;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{Constraint, Cx, Force, ForcePoint, Grid, Inputs, Scalar, Scene, Settings, Sum, check, gradient};
use nalgebra::SVector;
use num_dual::{Dual, Dual2_64, Dual2SVec, Dual2SVec64, Dual64, DualSVec, DualSVec64};

/// Every function of `Scalar`, in a formula that is smooth where it is used.
struct Model;

impl Constraint<3, 3, 2> for Model {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, t: S) -> SVector<S, 3> {
        let (sin, cos) = (q[0] * b[0]).sin_cos();
        let trigonometric = sin + cos.powi(3) + (q[1] * 0.3).tan() + (q[2] * 0.4).asin() + (q[2] * 0.2).acos() + q[0].atan();
        let growing = (q[1] * q[1] + b[1]).sqrt() + (-q[0]).exp() + q[1].exp_m1() + q[2].ln_1p() + (q[0] + 1.0).ln();
        let other = q[0].sinh() + q[1].cosh() + q[2].tanh() + q[1].atan2(q[0]) + q[0].hypot(q[2]) + q[2].powf(2.5);
        let branching = q[0].abs() + q[1].max(q[2]) + q[1].min(q[2]) + (q[0] + 2.0).recip();
        let branching = branching + (-q[0]).signum() * q[1] + q[1].clamp(0.1, b[1]) + (q[2] - 2.0).clamp(-q[1], 1.0);
        let turned = q[1].rotation() * SVector::from([q[0], b[0]]);
        let branching = branching + turned[0] * turned[1] + q[0].pow(q[1]);
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

/// All functions and operators of numbers; the second one may be left out.
fn all<S: Scalar>(x: S, y: S) -> Vec<(String, S)> {
    let mut all: Vec<(String, S)> = Vec::new();
    macro_rules! put {
        ($($value:expr;)*) => { $(all.push((stringify!($value).to_string(), $value));)* };
    }
    put! {
        x + y; x - y; x * y; x / y; -x; x + 1.5; x - 1.5; x * 0.0; x * -2.0; x / 3.0; x / 0.0; x.recip(); x.sqrt(); x.exp(); x.exp_m1(); x.ln();
        x.ln_1p(); x.sin(); x.cos(); x.sin_cos().0; x.sin_cos().1; x.tan(); x.asin(); x.acos(); x.atan(); x.sinh(); x.cosh(); x.tanh(); x.abs();
        x.max(y); x.min(y); x.atan2(y); x.hypot(y); x * x; x * x - y * y; (x * y).sqrt(); (x / y).atan(); (-x.recip()).exp() * y;
        y * x.exp() / (x.exp() + 1.0);
    }
    for n in [-5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 40, -40] {
        all.push((format!("x.powi({n})"), x.powi(n)));
    }
    for n in [-3.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 7.0] {
        all.push((format!("x.powf({n})"), x.powf(n)));
    }
    all
}

const SPECIAL: [f64; 27] = [
    0.0,
    -0.0,
    1e-300,
    -1e-300,
    1e-40,
    -1e-40,
    0.3,
    -0.3,
    1.0,
    -1.0,
    1.5,
    -1.5,
    std::f64::consts::FRAC_PI_2,
    2.0,
    -2.0,
    30.0,
    710.0,
    -710.0,
    1e30,
    -1e30,
    1e154,
    1e300,
    -1e300,
    f64::MAX,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Holds the real values of all functions of special numbers to those of `f64`.
fn assert_real<S: Scalar>(name: &str, lift: impl Fn(f64) -> S, is_same: fn(f64, f64) -> bool) {
    for x in SPECIAL {
        for y in SPECIAL {
            for ((what, lifted), (_, plain)) in all(lift(x), lift(y)).into_iter().zip(all(x, y)) {
                let re = lifted.re();
                assert!(is_same(re, plain), "{what} of {name} at x = {x:?}, y = {y:?}: {re:?} instead of {plain:?}");
            }
        }
    }
}

fn is_equal(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

#[test]
fn real_parts_are_those_of_real_numbers_also_where_these_are_infinite_or_no_numbers() {
    assert_real("Cx", |x| Cx::new(x, 1e-30), is_equal);
    assert_real("Cx with a negative step", |x| Cx::new(x, -1e-40), is_equal);
    assert_real("Cx without a step", Cx::from, is_equal);
    // num-dual divides by multiplying with 1/x, and makes powers of others.
    let is_close = |a: f64, b: f64| is_equal(a, b) || b != 0.0 && b.is_finite() && (a - b).abs() <= 1e-14 * b.abs();
    assert_real("Dual64", |x| Dual64::new(x, 1.0), is_close);
    assert_real("DualSVec64<2>", |x| DualSVec64::<2>::from_re(x).derivative(0), is_close);
    assert_real("Dual2SVec64<1>", |x| Dual2SVec64::<1>::from_re(x).derivative(0), is_close);
    assert_real("DualSVec<Cx, 1>", |x| DualSVec::<Cx, 1>::from_re(Cx::new(x, 1e-30)).derivative(0), is_close);
    assert_real(
        "Dual<DualSVec<Cx, 1>>",
        |x| Dual::new(DualSVec::<Cx, 1>::from_re(Cx::new(x, 1e-30)).derivative(0), DualSVec::from_re(Cx::from(0.5))),
        is_close,
    );
}

/// A formula that branches where it is infinite.
fn branches<S: Scalar>(q: S, t: S) -> S {
    if (q / t).re() > 10.0 { q * 2.0 } else { q * 3.0 }
}

#[test]
fn a_complex_step_takes_the_branch_of_real_numbers_where_a_value_is_infinite() {
    for (q, t) in [(0.7, 0.0), (-0.7, 0.0), (0.7, -0.0), (0.0, 0.0), (1e-300, 1e-320), (0.7, 0.01), (0.7, 1.0)] {
        let (plain, complex) = (branches(q, t), branches(Cx::new(q, 1e-30), Cx::from(t)));
        let slope = if plain == 2.0 * q && q != 0.0 { 2.0 } else { 3.0 };
        assert!(complex.0.re == plain && (complex.0.im / 1e-30 - slope).abs() < 1e-15, "{q} {t}: {complex:?}");
        assert_eq!(branches(Dual64::new(q, 1.0), Dual64::from(t)).re, plain);
    }
}

#[test]
fn a_complex_step_has_no_derivative_of_a_root_of_what_vanishes_with_its_slope() {
    let x = Cx::new(0.0, 1e-30);
    for root in [(x * x).sqrt(), x.powi(2).sqrt(), x.hypot(x * 2.0), (x * x * x * x).sqrt()] {
        assert!(root.0.re == 0.0 && !root.0.im.is_finite(), "{root:?}");
    }
    for square in [x * x, x.powi(2), x.powi(3), x.powf(2.0), x.powf(1.5), x.sin() * x.tan()] {
        assert!(square.0.re == 0.0 && (square.0.im / 1e-30).abs() < 1e-14, "{square:?}");
    }
}

/// f' by complex step, by dual numbers and by the closed form.
fn agree(name: &str, x: f64, expected: f64, f: impl Fn(Cx) -> Cx, g: impl Fn(Dual64) -> Dual64) {
    let h = 1e-30;
    let complex = f(Cx::new(x, h)).0.im / h;
    let dual = g(Dual64::new(x, 1.0)).eps;
    for (how, got) in [("complex step", complex), ("dual", dual)] {
        let error = (got - expected).abs() / expected.abs().max(1.0);
        assert!(error < 1e-14, "{name}'({x}) by {how}: {got}, expected {expected}");
    }
}

macro_rules! derivative {
    ($f:ident, $x:expr, $expected:expr) => {
        agree(stringify!($f), $x, $expected, |x| Scalar::$f(&x), |x| Scalar::$f(&x))
    };
}

#[test]
fn derivatives_by_complex_step_and_dual_numbers_are_the_closed_forms() {
    for x in [-0.7f64, -1e-9, 0.0, 0.3, 0.9] {
        let r = (1.0 - x * x).sqrt();
        derivative!(asin, x, 1.0 / r);
        derivative!(acos, x, -1.0 / r);
        derivative!(atan, x, 1.0 / (1.0 + x * x));
        derivative!(tanh, x, 1.0 - x.tanh() * x.tanh());
        derivative!(sinh, x, x.cosh());
        derivative!(exp_m1, x, x.exp());
        derivative!(ln_1p, x, 1.0 / (1.0 + x));
        derivative!(tan, x, 1.0 / (x.cos() * x.cos()));
    }
    for x in [-800.0, -400.0, 400.0, 800.0] {
        derivative!(tanh, x, 0.0);
    }
    for x in [-4.0, -1.0, 1.0, 4.0f64] {
        derivative!(atan, x, 1.0 / (1.0 + x * x));
        agree("powi -3", x, -3.0 * x.powi(-4), |x| Scalar::powi(&x, -3), |x| Scalar::powi(&x, -3));
        agree("powi 5", x, 5.0 * x.powi(4), |x| Scalar::powi(&x, 5), |x| Scalar::powi(&x, 5));
    }
}

#[test]
fn atan2_has_its_value_and_derivative_in_every_direction() {
    for k in 0..16 {
        let angle = f64::from(k) * std::f64::consts::PI / 8.0 - 3.1;
        let (y, x) = angle.sin_cos();
        let value = Scalar::atan2(&y, x);
        assert!((value - y.atan2(x)).abs() < 1e-15);
        let tangent = Scalar::atan2(&Dual64::new(y, x), Dual64::new(x, -y));
        assert!((tangent.eps - 1.0).abs() < 1e-14, "{angle}: {tangent}");
    }
    assert_eq!(Scalar::atan2(&Dual64::new(1.0, 0.0), Dual64::new(0.0, 1.0)).eps, -1.0);
}

#[test]
fn a_high_power_at_zero_is_zero_with_zero_derivatives() {
    let x = Dual2_64::new(0.0, 1.0, 0.0);
    let y = Scalar::powf(&x, 3.5);
    assert_eq!((y.re, y.v1, y.v2), (0.0, 0.0, 0.0));
}
/// Clamped, signed and turned numbers, and powers with an exponent that moves; b = [bound, exponent].
struct Shaped;

impl Force<2, 0, 2> for Shaped {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 2>) -> SVector<S, 2> {
        let stretch = (at.q.dot(&at.q) + 1.0).pow(b[1] * at.q[0]);
        at.q[1].rotation() * SVector::from([-(stretch * 0.1), at.q[0].clamp(-0.1, b[0]) * at.q[1].signum()])
    }
}

/// Programs, dual numbers and complex step take the same side of each branch, and the formula has a program.
#[test]
fn clamped_signed_and_turned_numbers_have_exact_gradients() {
    for q in [[0.05, 0.7], [0.9, -0.4], [-0.6, 0.3]] {
        let build = || {
            let mut scene = Scene::new();
            let bob = scene.particle("bob", 1.3, q);
            let b = [scene.design("bound", 0.2), scene.design("exponent", 1.7)];
            scene.force("shaped", Shaped, bob.coordinates, [], b.map(Into::into));
            scene.cost("place", AngleError, Sum::AllNodes, [bob.coordinates[0]], [], [], [0.3.into()]);
            scene
        };
        let system = build().compile().expect("a scene");
        assert_eq!(system.without_programs().count(), 0);
        let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.02));
        let plain = build().compile_without_programs().expect("a scene");
        let [with, without] =
            [&system, &plain].map(|system| gradient(system, &inputs, Settings::default()).expect("a gradient"));
        assert!((&with.design - &without.design).amax() <= 1e-14 * with.design.amax());
        check::gradient(&system, &inputs, Settings::default()).run().expect("a report").assert_passed();
    }
}
