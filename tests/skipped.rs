//! What tracing found to be constant, linear, sinusoidal or absent is so: by automatic differentiation at random points, and by
//! holding whole motions and gradients against the plain formulas, of which nothing is skipped.

#[path = "scenes/elements.rs"]
mod elements;
#[path = "scenes/pairs.rs"]
mod pairs;
#[path = "scenes/structures.rs"]
mod structures;

use hamiltonian_adjoint::check::{Input, tangent};
use hamiltonian_adjoint::planar::*;
use hamiltonian_adjoint::trace::{Structure, Trace};
use hamiltonian_adjoint::{
    Constraint, Force, ForcePoint, Grid, Inputs, KineticEnergy, LiftedSolver, PotentialEnergy, Scalar, Scene, Settings,
    gradient,
};
use nalgebra::{DMatrix, SVector, Vector1};
use num_dual::{Dual3_64, Dual64, HyperDual64};

use elements::{AirDrag, ArmsWeight, ConstantMass, CoupledArms, Magnet, Parabola, Shoulder};
use pairs::{Gusts, ShakenRail};

/// A formula of inputs x with constants b.
trait Formula {
    fn inputs(&self) -> usize;
    fn constants(&self) -> usize;
    fn values<S: Scalar>(&self, x: &[S], b: &[S]) -> Vec<S>;
}

/// T(q, v).
struct Kinetic<E, const N: usize, const P: usize>(E);
/// V(q, t).
struct Potential<E, const N: usize, const P: usize>(E);
/// Q(q, v, u, t).
struct Applied<E, const N: usize, const K: usize, const P: usize>(E);
/// Φ(q, t).
struct Holonomic<E, const N: usize, const M: usize, const P: usize>(E);

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> Formula for Kinetic<E, N, P> {
    fn inputs(&self) -> usize {
        2 * N
    }
    fn constants(&self) -> usize {
        P
    }
    fn values<S: Scalar>(&self, x: &[S], b: &[S]) -> Vec<S> {
        let [q, v] = [&x[..N], &x[N..]].map(SVector::from_column_slice);
        vec![self.0.kinetic_energy(&q, &v, &SVector::from_column_slice(b))]
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> Formula for Potential<E, N, P> {
    fn inputs(&self) -> usize {
        N + 1
    }
    fn constants(&self) -> usize {
        P
    }
    fn values<S: Scalar>(&self, x: &[S], b: &[S]) -> Vec<S> {
        vec![self.0.potential_energy(&SVector::from_column_slice(&x[..N]), &SVector::from_column_slice(b), x[N])]
    }
}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> Formula for Applied<E, N, K, P> {
    fn inputs(&self) -> usize {
        2 * N + K + 1
    }
    fn constants(&self) -> usize {
        P
    }
    fn values<S: Scalar>(&self, x: &[S], b: &[S]) -> Vec<S> {
        let [q, v] = [&x[..N], &x[N..2 * N]].map(SVector::from_column_slice);
        let at = ForcePoint { q, v, u: SVector::from_column_slice(&x[2 * N..2 * N + K]), t: x[2 * N + K] };
        self.0.force(&at, &SVector::from_column_slice(b)).as_slice().to_vec()
    }
}

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> Formula for Holonomic<E, N, M, P> {
    fn inputs(&self) -> usize {
        N + 1
    }
    fn constants(&self) -> usize {
        P
    }
    fn values<S: Scalar>(&self, x: &[S], b: &[S]) -> Vec<S> {
        self.0.phi(&SVector::from_column_slice(&x[..N]), &SVector::from_column_slice(b), x[N]).as_slice().to_vec()
    }
}

/// Pseudo-random numbers, the same in every run.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn points(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.between(-2.0, 2.0)).collect()
    }
}

const POINTS: usize = 5;

/// Second derivatives of all values with respect to inputs i and j, by hyper-dual numbers.
fn second<F: Formula>(formula: &F, x: &[f64], b: &[f64], i: usize, j: usize) -> Vec<HyperDual64> {
    let mut x: Vec<HyperDual64> = x.iter().map(|&x| x.into()).collect();
    x[i] = x[i].derivative1();
    x[j] = x[j].derivative2();
    formula.values(&x, &b.iter().map(|&b| b.into()).collect::<Vec<_>>())
}

/// Derivatives up to the third with respect to input i.
fn third<F: Formula>(formula: &F, x: &[f64], b: &[f64], i: usize) -> Vec<Dual3_64> {
    let mut x: Vec<Dual3_64> = x.iter().map(|&x| x.into()).collect();
    x[i] = x[i].derivative();
    formula.values(&x, &b.iter().map(|&b| b.into()).collect::<Vec<_>>())
}

/// Traced as a scene does it: a constant is known if it is a number, and only then.
fn trace<F: Formula>(formula: &F, b: &[f64], bound: bool) -> Structure {
    trace_shifted(formula, b, bound, &[])
}

/// The same with some inputs that grow together.
fn trace_shifted<F: Formula>(formula: &F, b: &[f64], bound: bool, shifted: &[usize]) -> Structure {
    let number = |b: &f64| if bound { Trace::unknown_constant(*b) } else { Trace::from(*b) };
    let b: Vec<Trace> = b.iter().map(number).collect();
    let input = |i| if shifted.contains(&i) { Trace::input(0.3, i).shifted() } else { Trace::input(0.3, i) };
    let x: Vec<Trace> = (0..formula.inputs()).map(input).collect();
    Structure::of(|| formula.values(&x, &b))
}

/// Holds a structure against the derivatives at random points.
fn assert_holds<F: Formula>(name: &str, formula: &F, structure: &Structure, b: &[f64], random: &mut Random) {
    let inputs = formula.inputs();
    let close = |a: f64, b: f64, what: &str| {
        assert!((a - b).abs() <= 1e-12 * (1.0 + a.abs()), "{name}: {what}: {a} and {b}, {structure:?}");
    };
    let points: Vec<Vec<f64>> = (0..POINTS).map(|_| random.points(inputs)).collect();
    for (i, j) in (0..inputs).flat_map(|i| (i..inputs).map(move |j| (i, j))) {
        let at: Vec<Vec<HyperDual64>> = points.iter().map(|x| second(formula, x, b, i, j)).collect();
        for (values, first) in at.iter().flat_map(|values| values.iter().zip(&at[0])) {
            if !structure.depends_on(i) {
                close(values.eps1, 0.0, "an input it does not depend on");
            }
            if !structure.is_bent_in(i) || !structure.is_bent_in(j) || structure.degree <= 1 {
                close(values.eps1eps2, 0.0, "linear");
            }
            if structure.degree <= 2 {
                close(values.eps1eps2, first.eps1eps2, "of degree two");
            }
            if structure.sinusoidal && i != j {
                close(values.eps1eps2, 0.0, "a sum over single inputs");
            }
        }
    }
    for i in (0..inputs).filter(|_| structure.sinusoidal) {
        // f = a x + α sin x + β cos x has f′ + f‴ = a.
        let at: Vec<Vec<Dual3_64>> = points.iter().map(|x| third(formula, x, b, i)).collect();
        for (values, first) in at.iter().flat_map(|values| values.iter().zip(&at[0])) {
            close(values.v1 + values.v3, first.v1 + first.v3, "sinusoidal");
        }
    }
}

/// What a formula changes by if two of its inputs grow by the same amount, at random points, held against what its trace says.
fn assert_unmoved<F: Formula>(name: &str, formula: &F, b: &[f64], bound: bool, random: &mut Random) -> usize {
    let inputs = formula.inputs();
    let mut count = 0;
    for (i, j) in (0..inputs).flat_map(|i| (0..i).map(move |j| (i, j))) {
        if !trace_shifted(formula, b, bound, &[i, j]).unmoved {
            continue;
        }
        count += 1;
        for _ in 0..POINTS {
            let x = random.points(inputs);
            for values in second(formula, &x, b, i, j) {
                let size = 1.0 + values.eps1.abs();
                assert!((values.eps1 + values.eps2).abs() <= 1e-12 * size, "{name}: inputs {i} and {j}: {values:?}");
            }
        }
    }
    count
}

/// Traces a formula with numbers, with zeros among them, and with bound constants, and holds each against derivatives.
fn check<F: Formula>(name: &str, formula: F) {
    let mut random = Random(name.bytes().fold(1, |seed, byte| seed.wrapping_mul(31).wrapping_add(byte.into())));
    let numbers: Vec<f64> = (0..formula.constants()).map(|_| random.between(0.3, 1.5)).collect();
    for zeros in 0..1usize << formula.constants() {
        let b: Vec<f64> = numbers.iter().enumerate().map(|(p, &b)| if zeros >> p & 1 == 1 { 0.0 } else { b }).collect();
        // A formula that is not defined with this zero (the length of a rod) is none.
        let x = random.points(formula.inputs());
        if formula.values(&x, &b).iter().all(|y| y.is_finite()) {
            assert_holds(name, &formula, &trace(&formula, &b, false), &b, &mut random);
            assert_unmoved(name, &formula, &b, false, &mut random);
        }
    }
    // Bound: the structure must hold for any other value, zero and one included.
    let structure = trace(&formula, &numbers, true);
    for _ in 0..POINTS {
        let b: Vec<f64> = numbers.iter().map(|_| random.between(0.3, 1.5)).collect();
        assert_holds(name, &formula, &structure, &b, &mut random);
        assert_unmoved(name, &formula, &b, true, &mut random);
    }
    assert_holds(name, &formula, &structure, &vec![1.0; numbers.len()], &mut random);
}

macro_rules! check_between_bodies {
    ($($kind:ident, $element:expr, $m:literal, $p:literal;)*) => {$(
        check(stringify!($element), $kind::<_, 6, $m, $p>($element));
        check(concat!(stringify!($element), " from ground"), $kind::<_, 3, $m, $p>(FromGround($element)));
        check(concat!(stringify!($element), " to ground"), $kind::<_, 3, $m, $p>(ToGround($element)));
    )*};
}

#[test]
fn joints_are_what_their_traces_say() {
    check_between_bodies! {
        Holonomic, Revolute, 2, 4;
        Holonomic, Prismatic, 2, 6;
        Holonomic, Weld, 3, 5;
        Holonomic, Distance, 1, 5;
        Holonomic, DrivenAngle(ConstantSpeed), 1, 2;
        Holonomic, DrivenAngle(Harmonic), 1, 4;
    }
}

#[test]
fn forces_are_what_their_traces_say() {
    check_between_bodies! {
        Applied, Damper, 0, 5;
        Applied, JointFriction, 0, 1;
        Applied, SlidingFriction, 0, 6;
        Applied, Actuator, 1, 5;
        Applied, TorqueActuator, 1, 0;
    }
}

#[test]
fn energies_are_what_their_traces_say() {
    check("RigidBody", Kinetic::<_, 3, 2>(RigidBody));
    check("Weight", Potential::<_, 2, 3>(Weight));
    check("LinearSpring", Potential::<_, 6, 6>(LinearSpring));
    check("LinearSpring from ground", Potential::<_, 3, 6>(FromGround(LinearSpring)));
    check("LinearSpring to ground", Potential::<_, 3, 6>(ToGround(LinearSpring)));
    check("TorsionalSpring", Potential::<_, 6, 2>(TorsionalSpring));
    check("TorsionalSpring from ground", Potential::<_, 3, 2>(FromGround(TorsionalSpring)));
    check("TorsionalSpring to ground", Potential::<_, 3, 2>(ToGround(TorsionalSpring)));
}

/// Formulas that a trace might take for less than they are.
struct Traps;

impl Constraint<3, 9> for Traps {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, _b: &SVector<S, 0>, t: S) -> SVector<S, 9> {
        let [x, y, z] = [q[0], q[1], q[2]];
        SVector::from([
            (x - y) * (x + y) - x * x + y * z,
            x.powi(3) - x * x * x,
            (x * 2.0).sin() + (x - 0.3).sin() * (-y).cos(),
            (x + y * y * 0.0).cos() + z,
            (x * x + 1.0).sqrt() * z,
            y / (z * z + 1.0) + x.tanh(),
            (x.exp() * y).atan() - t * t,
            y.atan2(z * z + 1.0) + t * x,
            (x.hypot(y + 5.0)).ln_1p() * z,
        ])
    }
}

/// One equation of the traps alone, so that no other hides it.
struct Trap(usize);

impl Constraint<3, 1> for Trap {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 0>, t: S) -> Vector1<S> {
        Vector1::new(Traps.phi(q, b, t)[self.0])
    }
}

/// Takes one of two formulas by a sign.
struct Kink;

impl Force<1, 0> for Kink {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> Vector1<S> {
        let v = at.v[0];
        Vector1::new(if v.re() > 0.0 { -v } else { -v * v * 0.5 })
    }
}

#[test]
fn elements_of_ones_own_are_what_their_traces_say() {
    check("ConstantMass", Kinetic::<_, 2, 0>(ConstantMass));
    check("CoupledArms", Kinetic::<_, 2, 0>(CoupledArms));
    check("ArmsWeight", Potential::<_, 2, 0>(ArmsWeight));
    check("Magnet", Potential::<_, 2, 2>(Magnet));
    check("Parabola", Holonomic::<_, 2, 1, 2>(Parabola));
    check("ShakenRail", Holonomic::<_, 2, 2, 2>(ShakenRail));
    check("AirDrag", Applied::<_, 2, 0, 1>(AirDrag));
    check("Shoulder", Applied::<_, 1, 1, 0>(Shoulder));
    check("Gusts", Applied::<_, 1, 0, 2>(Gusts));
    check("Kink", Applied::<_, 1, 0, 0>(Kink));
    check("all traps", Holonomic::<_, 3, 9, 0>(Traps));
    for equation in 0..9 {
        check(&format!("trap {equation}"), Holonomic::<_, 3, 1, 0>(Trap(equation)));
    }
}

#[test]
fn a_wrong_structure_is_found_out() {
    let none = trace(&Holonomic::<_, 2, 1, 2>(Parabola), &[0.0, 0.0], false);
    let wrong = std::panic::catch_unwind(|| {
        assert_holds("wrong", &Holonomic::<_, 2, 1, 2>(Parabola), &none, &[0.4, 0.1], &mut Random(1));
    });
    assert!(wrong.is_err());
}

#[test]
fn what_acts_between_two_bodies_is_seen_to_depend_on_the_differences_of_their_positions() {
    let mut random = Random(7);
    let b = [0.4, -0.2, 0.3, 0.5, 0.7, 0.6];
    // x and y, among the coordinates alone (and the time that a joint does not depend on) or among the velocities too.
    let pairs = |depends: usize, count: usize, name: &str| assert!(count >= depends, "{name}: {count} pairs");
    pairs(2, assert_unmoved("spring", &Potential::<_, 6, 6>(LinearSpring), &b, true, &mut random), "spring");
    pairs(2, assert_unmoved("rod", &Holonomic::<_, 6, 1, 5>(Distance), &b[..5], true, &mut random), "rod");
    pairs(2, assert_unmoved("slider", &Holonomic::<_, 6, 2, 6>(Prismatic), &b, true, &mut random), "slider");
    pairs(4, assert_unmoved("damper", &Applied::<_, 6, 0, 5>(Damper), &b[..5], true, &mut random), "damper");
    pairs(4, assert_unmoved("friction", &Applied::<_, 6, 0, 6>(SlidingFriction), &b, true, &mut random), "friction");
}

/// The largest difference in SI units, relative to the largest number where that is above 1.
fn difference(plain: &DMatrix<Dual64>, ours: &DMatrix<f64>) -> f64 {
    let worst = plain.iter().zip(ours.iter()).fold(0.0f64, |worst, (a, b)| worst.max((a.re - b).abs()));
    worst / ours.iter().fold(1.0f64, |size, x| size.max(x.abs()))
}

/// A motion and a gradient of the compiled scene against the plain formulas.
fn against_plain(name: &str, scene: Scene) {
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    for (i, u) in inputs.controls.iter_mut().enumerate() {
        *u = 1.0 + (i as f64).sin();
    }
    let settings = Settings::default();
    let mut plain = LiftedSolver::<Dual64>::new(&system, &inputs, settings).expect("a motion");
    let motion = plain.simulate(&inputs.lift()).expect("the same motion").clone();
    let ours = plain.real().trajectory();
    let differences = [
        ("q", difference(&motion.q, &ours.q)),
        ("v", difference(&motion.v, &ours.v)),
        ("p*", difference(&motion.p_star, &ours.p_star)),
        ("dp*/dt", difference(&motion.p_star_dot, &ours.p_star_dot)),
        ("sigma", difference(&motion.sigma, &ours.sigma)),
    ];
    // Where constraints depend on each other, σ is rounding but for what Φ_qᵀσ, and so p*, has of it.
    let determined = if ours.compliance.is_empty() { &differences[..] } else { &differences[..4] };
    for (what, difference) in determined {
        assert!(*difference <= 1e-11, "{name}: {what} differs by {difference:.1e}");
    }

    let ours = gradient(&system, &inputs, settings).expect("a gradient");
    let mut some = vec![Input::Step(7), Input::Step(20)];
    some.extend((0..system.k()).flat_map(|channel| [0, 9, 20].map(|node| Input::Control { channel, node })));
    some.extend((0..system.designs()).map(Input::Design));
    some.extend((0..system.n().min(6)).map(Input::Coordinate));
    let size = Input::all(&inputs).iter().fold(0.0f64, |size, input| size.max(input.in_gradient(&ours).abs()));
    for input in some {
        let ours = input.in_gradient(&ours);
        let what = format!("{name}: {}", input.name(&system));
        let plain = tangent(&system, &inputs, settings, &[input]).unwrap_or_else(|error| panic!("{what}: {error}"))[0];
        assert!((ours - plain).abs() <= 1e-10 * size, "{what}: {ours} and {plain}");
    }
}

#[test]
fn every_kind_of_element_moves_as_its_plain_formula() {
    for (name, scene) in elements::all() {
        against_plain(name, scene);
    }
}

#[test]
fn scenes_with_and_without_each_thing_move_as_their_plain_formulas() {
    for comparison in pairs::all() {
        for (name, scene) in comparison.rows {
            against_plain(&format!("{}: {name}", comparison.thing), scene);
        }
    }
}

#[test]
fn chains_trees_and_ladders_move_as_their_plain_formulas() {
    against_plain("chain", structures::chain(30));
    against_plain("tree", structures::binary_tree(5));
    against_plain("ladder", structures::ladder(10));
    against_plain("doubled hinges", structures::string(5, 2));
    against_plain("open ladder", structures::open_ladder(10));
}
