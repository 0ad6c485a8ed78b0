//! Programs of all functions and of thousands of random formulas, compared with num-dual on the same formulas.

use nalgebra::SVector;
use std::sync::Arc;

use super::verify::{Compared, Draw};
use crate::model::{Design, Param, SceneTag};
use crate::system::formula::{
    AnyElement, Applied, Block, Connections, Covector, Element, ElementKind, Entry, Fixed, Holonomic, Kinetic, NodeValues,
    NodeView, PlacedElement, Potential, Recordings, Restricted, Shape,
};
use crate::system::tangent::Constants;
use crate::{Constraint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar};

/// A random formula: a list of operations on earlier results, which can be evaluated on any number type.
#[derive(Clone, Debug)]
pub(in crate::system) struct Random {
    operations: Vec<(usize, [usize; 2], f64)>,
}

/// The number of kinds of operations.
const KINDS: usize = 40;

fn operate<S: Scalar>(kind: usize, x: S, y: S, c: f64) -> S {
    let positive = x * x + 0.1;
    let small = x.sin() * 0.9;
    match kind {
        0 | 1 => x + y,
        2 | 3 => x - y,
        4 | 5 => x * y,
        6 => x / (y * y + 0.3),
        7 => x / (y + c),
        8 => -x,
        9 => x * c,
        10 => x + c,
        11 => x * S::from([0.0, 1.0, -1.0, 2.0, 0.5][(c.abs() * 4.99) as usize]),
        12 => S::from(c) - x * S::zero(),
        13 => x.sin(),
        14 => x.cos(),
        15 => x.sin_cos().0 * y.sin_cos().1,
        16 => small.tan(),
        17 => positive.sqrt(),
        18 => positive.ln(),
        19 => positive.ln_1p(),
        20 => x.sin().exp(),
        21 => x.cos().exp_m1(),
        22 => small.asin(),
        23 => small.acos(),
        24 => x.atan(),
        25 => small.sinh(),
        26 => small.cosh(),
        27 => x.tanh(),
        28 => positive.recip(),
        29 => positive.powf(3.0 * c),
        30 => (x + c).powi((4.0 * c) as i32 + 1),
        // Avoids the angle of a zero, which depends on its sign, and one over zero.
        31 => (x + c).atan2(y),
        32 => x.hypot(y),
        33 => x.abs(),
        34 => x.max(y),
        35 => x.min(y * c),
        36 => (-small).acos() + (-small).asin() - (-x).atan(),
        37 => (-small).sinh() + (-small).cosh() * (-y).tanh(),
        38 => (-x).abs() * (-positive).recip() + (-x).sin() * (-y).cos() - (-small).tan(),
        _ => (-x).sin().exp() + (-small).ln_1p() + (-x).sin().exp_m1(),
    }
}

impl Random {
    pub(in crate::system) fn new(draw: &mut Draw, inputs: usize, len: usize) -> Self {
        let mut below = |n: usize| ((draw.number() + 1.0) * 0.5 * n as f64) as usize % n;
        let shape: Vec<_> = (0..len).map(|k| (below(KINDS), [below(inputs + k), below(inputs + k)])).collect();
        Random { operations: shape.into_iter().map(|(kind, of)| (kind, of, draw.number())).collect() }
    }

    fn values<S: Scalar>(&self, inputs: &[S]) -> Vec<S> {
        let mut values = inputs.to_vec();
        for &(kind, [x, y], c) in &self.operations {
            values.push(operate(kind, values[x], values[y], c));
        }
        values
    }

    /// The last values, which depend on all inputs.
    pub(in crate::system) fn last<S: Scalar, const M: usize>(&self, inputs: &[S]) -> SVector<S, M> {
        let values = self.values(inputs);
        SVector::from_fn(|j, _| values[values.len() - 1 - j])
    }
}

impl KineticEnergy<2, 2> for Random {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 2>) -> S {
        self.last::<S, 1>(&[q[0], q[1], v[0], v[1], b[0], b[1]])[0]
    }
}

impl PotentialEnergy<3, 2> for Random {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, t: S) -> S {
        self.last::<S, 1>(&[q[0], q[1], q[2], b[0], b[1], t])[0]
    }
}

impl Force<2, 1, 2> for Random {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 2>) -> SVector<S, 2> {
        self.last(&[at.q[0], at.q[1], at.v[0], at.v[1], at.u[0], at.t, b[0], b[1]])
    }
}

impl Constraint<3, 2, 2> for Random {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, t: S) -> SVector<S, 2> {
        self.last(&[q[0], q[1], q[2], b[0], b[1], t])
    }
}

/// An element with its own coordinates, multipliers and controls.
fn placed<const P: usize>(
    formula: impl AnyElement + 'static,
    there: &'static [usize],
    name: &str,
    b: [Param; P],
) -> PlacedElement {
    let formula: Arc<dyn AnyElement> =
        if there.is_empty() { Arc::new(formula) } else { Arc::new(Restricted { inner: Arc::new(formula), there }) };
    let Shape { n, m, k, p } = formula.shape();
    assert_eq!(p, P);
    let to = Connections { q: (0..n).collect(), sigma: (0..m).collect(), u: (0..k).collect(), b: b.to_vec() };
    PlacedElement::new(name, formula, to)
}

/// Summary of a comparison: the number of conclusive points, and whether some derivatives represent others.
pub(in crate::system) struct Held {
    pub(in crate::system) points: usize,
    pub(in crate::system) is_relative: bool,
}

/// Compares a formula as one kind of element at random points.
pub(in crate::system) fn hold<const P: usize>(
    (formula, there): (impl AnyElement + 'static, &'static [usize]),
    draw: &mut Draw,
    name: &str,
    (b, design): ([Param; P], &[f64]),
) -> Held {
    let element = placed(formula, there, name, b);
    let (kind, shape) = (element.formula.kind(), element.formula.shape());
    let Shape { n, m, k, .. } = shape;
    let zeros = || vec![0.1; 8];
    let (q, v, sigma, u) = (zeros(), zeros(), zeros(), zeros());
    let at = NodeView::of_equations([&q, &v, &sigma], (&u, 0.2, design));
    let (formula, numbers) = Recordings::default().formula((kind, shape), element.to.bound(), || element.record(&at));
    assert!(formula.kernels.is_some(), "{name}");
    let is_relative = formula.varying.iter().any(|entry| entry.len() > 1);
    let recorded = element.element((0, 0), formula, numbers);
    assert_sines(&recorded, design, draw, name);
    let mut points = 0;
    for _ in 0..4 {
        let mut random = |len: usize| (0..len).map(|_| 1.5 * draw.number()).collect::<Vec<_>>();
        let (q, v, sigma, u, t) = (random(n), random(n), random(m), random(k), random(1)[0]);
        let point = NodeValues { q, v, sigma, u, t, design: design.to_vec(), of_costs: Default::default() };
        let (c, d, e) = (draw.numbers(n), draw.numbers(n), draw.numbers(m));
        let compare = |at: &NodeValues<f64>| element.compare(&recorded, at, &Covector { c: &c, d: &d, e: &e });
        let pairs = compare(&point);
        // Estimates the effect of rounding: the change of the result for relative changes of 1e-11 of every argument.
        let mut noise = 0.0f64;
        for _ in 0..3 {
            let mut nearby = point.clone();
            let lists = [&mut nearby.q, &mut nearby.v, &mut nearby.sigma, &mut nearby.u, &mut nearby.design];
            lists.into_iter().flatten().for_each(|x| *x *= 1.0 + 1e-11 * draw.number());
            let changes = compare(&nearby).into_iter().zip(&pairs).map(|(there, here)| (there.dual - here.dual).abs());
            noise = changes.fold(noise, f64::max);
        }
        let largest = pairs.iter().fold(1.0, |size: f64, pair| size.max(pair.dual.abs()));
        let is_moderate = largest < 1e8 && pairs.iter().all(|pair| pair.dual.is_finite());
        points += usize::from(is_moderate);
        let is_close = |pair: &Compared| (pair.program - pair.dual).abs() <= 100.0 * noise + 1e-8 * largest;
        let far = || pairs.iter().filter(|pair| !is_close(pair));
        let show = || far().map(|pair| format!("{} {}\n", pair.program, pair.dual)).collect::<String>();
        assert!(!is_moderate || pairs.iter().all(is_close), "{name}\n{point:?} {noise}\n{}", show());
    }
    Held { points, is_relative }
}

/// The first design variable.
pub(in crate::system) fn bound() -> Param {
    Param::from(Design(SceneTag::default().handle(0))).resolve(&[0.0.into(); 3], &mut |_| 0)
}

/// Compares the coefficients of a sinusoidal constraint with its slopes at a random angle.
fn assert_sines(element: &Element, design: &[f64], draw: &mut Draw, name: &str) {
    let Some(kernels) = element.formula.kernels.as_ref().filter(|_| element.formula.sinusoidal) else { return };
    let (parameters, angle) = (element.parameters(design), 3.0 * draw.number());
    let mut constants = Constants::new(element.to.q.len());
    element.add_constants(&parameters, &mut constants);
    let (_, slopes) = kernels.at_state(&parameters, |which| if which < element.to.q.len() { angle } else { 0.0 });
    let varying = element.formula.varying.iter().map(|relative| &relative.entry);
    let phi_q = varying.zip(slopes).filter(|(entry, _)| entry.block == Block::PhiQ);
    for ((entry, slope), wave) in phi_q.zip(&constants.waves) {
        let at = |e: &&Entry| (e.row, e.col) == (entry.row, entry.col);
        let linear: f64 = constants.phi_q.iter().filter(at).map(|e| e.value).sum();
        let sum = linear + wave.sine * angle.cos() - wave.cosine * angle.sin();
        assert!((slope - sum).abs() < 1e-12, "{name}: {slope} and {sum}");
    }
}

/// Compares the programs of an element with `P` constants with num-dual: for numbers, for some zeros, and for one bound constant.
///
/// Of its coordinates only those in `there` are there, all if it is empty.
pub(crate) fn hold_element<E: AnyElement + 'static, const P: usize>(
    make: impl Fn() -> E,
    there: &'static [usize],
    name: &str,
) {
    hold_element_with::<E, P>(make, there, name, &[]);
}

/// The same for an element some of whose constants may not be zero.
pub(crate) fn hold_element_with<E: AnyElement + 'static, const P: usize>(
    make: impl Fn() -> E,
    there: &'static [usize],
    name: &str,
    positive: &[usize],
) {
    let mut draw = Draw(name.len() as u64);
    let (mut said, mut tried) = (0, 0);
    // If there are few constants, all combinations of bound constants; otherwise each constant bound alone, and some further combinations.
    let few = |zeros: &usize| P <= 6 || zeros.count_ones() <= 1 || zeros.is_multiple_of(61);
    for zeros in (0..1usize << P).filter(few) {
        tried += 1;
        let design = [0.6 + 0.5 * draw.number()];
        let b: [Param; P] = std::array::from_fn(|p| match zeros >> p & 1 {
            1 if zeros.count_ones() == 1 => bound(),
            1 if !positive.contains(&p) => Param::from(0.0),
            _ => Param::from(0.8 + 0.5 * draw.number()),
        });
        said += hold::<P>((make(), there), &mut draw, &format!("{name} with {b:?}"), (b, &design)).points;
    }
    assert!(said > 2 * tried, "{name}: {said} points of {}", 4 * tried);
}

/// Angles of directions on the branch cut, where the sign of a zero matters.
struct OnTheCut;

impl Force<2, 0, 1> for OnTheCut {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let left = S::from(-1.0);
        let (d, e) = (at.q[0] - at.q[1], at.q[1] - at.q[0]);
        let angle = |y: S| y.atan2(left * b[0]);
        SVector::from([angle(d) + angle(e) * 10.0 + d * e, angle(-d) + angle(e * b[0]) * 10.0 + angle(-(d * b[0])) * 100.0])
    }
}

#[test]
fn angles_are_on_the_same_side_of_the_cut() {
    let element = placed(Applied::<Fixed<_, 2, 0, 0, 1>, 2>::fixed(OnTheCut), &[], "on the cut", [Param::from(0.7)]);
    let q = [0.3, 0.3];
    let at = NodeView::of_equations([&q, &[0.0; 2], &[]], (&[], 0.0, &[]));
    let shape = Shape { n: 2, m: 0, k: 0, p: 1 };
    let record = || element.record(&at);
    let (formula, numbers) = Recordings::default().formula((ElementKind::Applied, shape), element.to.bound(), record);
    let parameters = element.element((0, 0), formula.clone(), numbers).parameters(&[]);
    let kernels = formula.kernels.as_ref().expect("programs");
    let plain = OnTheCut.force(&ForcePoint { q: q.into(), v: [0.0; 2].into(), u: SVector::zeros(), t: 0.0 }, &[0.7].into());
    assert_eq!(kernels.at_state(&parameters, |which| q[which]).0, plain.as_slice());
}

#[test]
fn programs_of_random_formulas_are_what_num_dual_makes_of_them() {
    let (mut draw, mut said) = (Draw(7), 0);
    let formulas = std::env::var("RANDOM_FORMULAS").ok().and_then(|n| n.parse().ok()).unwrap_or(1500);
    for k in 0..formulas {
        let mut random = |inputs: usize| Random::new(&mut draw, inputs, 3 + k % 22);
        let (kinetic, potential, applied, holonomic) = (random(6), random(6), random(8), random(6));
        let name = |formula: &Random| format!("formula {k}: {formula:?}");
        let names = [name(&kinetic), name(&potential), name(&applied), name(&holonomic)];
        let design = [0.7 * draw.number()];
        let b = [bound(), Param::from(draw.number())];
        let with = (b, design.as_slice());
        said += hold((Kinetic::<Fixed<_, 2, 0, 0, 2>, 2>::fixed(kinetic), &[]), &mut draw, &names[0], with).points;
        said += hold((Potential::<Fixed<_, 3, 0, 0, 2>, 3>::fixed(potential), &[]), &mut draw, &names[1], with).points;
        said += hold((Applied::<Fixed<_, 2, 0, 1, 2>, 2>::fixed(applied), &[]), &mut draw, &names[2], with).points;
        said += hold((Holonomic::<Fixed<_, 3, 2, 0, 2>, 3>::fixed(holonomic), &[]), &mut draw, &names[3], with).points;
    }
    assert!(said > 12 * formulas, "{said} of {} points are conclusive", 16 * formulas);
}
