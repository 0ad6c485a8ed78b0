//! Zeros have signs, which decide on which side of its cut an angle is and which infinity a reciprocal: programs keep them as `f64` does.
//!
//! `RANDOM_ZEROS=20000 cargo test --release --test formulas -- --nocapture` tries more formulas.

use super::random::Random;
use super::*;
use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Grid, Solver};

/// One operation on zeros and small whole numbers, which are exact.
fn operate<S: Scalar>(kind: usize, x: S, y: S, number: f64) -> S {
    match kind {
        0 => x + y,
        1 => x - y,
        2 => x * y,
        3 => x / (y * y + 1.0),
        4 => -x,
        5 => x * number,
        6 => x + number,
        7 => x - number,
        8 => S::from(number) - x,
        9 => S::from(number) * -1.0,
        10 => S::from(number) / (x + y),
        11 => (-x).abs() + (-x).powi(3),
        12 => x.max(y),
        13 => (-x).min(y),
        14 => (x * x).sqrt() * y,
        15 => -(x - y),
        16 => (y - x).tanh(),
        17 => (-x).sin() * x.cos(),
        18 => x * 2.0 - y * 2.0,
        _ => x.atan2(y).atan2(-x),
    }
}

/// A list of operations on arguments and on what was computed before.
#[derive(Clone, Debug)]
struct Zeros(Vec<(usize, [usize; 2], f64)>);

impl Zeros {
    fn random(random: &mut Random, inputs: usize, len: usize) -> Self {
        let number = |random: &mut Random| [0.0, -0.0, 1.0, -1.0][random.below(4)];
        let operation = |k| (random.below(20), [random.below(inputs + k), random.below(inputs + k)], number(random));
        Zeros((0..len).map(operation).collect())
    }
}

impl Cost<1, 0, 0, 4> for Zeros {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 4>) -> S {
        let mut values = [&[at.q[0]], b.as_slice()].concat();
        for &(kind, [x, y], number) in &self.0 {
            values.push(operate(kind, values[x], values[y], number));
        }
        let y = values[values.len() - 1];
        y.atan2(S::from(-1.0)) + (y * b[0]).recip().atan() * 10.0 + at.q[0].atan2(-b[1] * b[1]) * 100.0
    }
}

#[test]
fn programs_keep_the_signs_of_zeros_that_functions_see() {
    let formulas: u64 = std::env::var("RANDOM_ZEROS").ok().and_then(|n| n.parse().ok()).unwrap_or(1500);
    let mut compared = 0;
    for seed in 0..formulas {
        let mut random = Random(seed);
        let zeros = Zeros::random(&mut random, 5, 1 + seed as usize % 9);
        let numbers: [f64; 5] = std::array::from_fn(|_| [0.0, -0.0, 1.0, -1.0][random.below(4)]);
        let mut s = Scene::new();
        let [x] = s.coordinates("a", ["x"]);
        s.place(x, numbers[0]);
        s.kinetic_energy("m", Mass, [x], [1.0.into()]);
        // Two of the constants are numbers.
        let b = [s.design("b", numbers[1]).into(), s.design("c", numbers[2]).into(), numbers[3].into(), numbers[4].into()];
        s.cost("zeros", zeros.clone(), Sum::Node(0), [x], [], [], b);
        let inputs = |system: &System| Inputs::at_rest(system, Grid::uniform(1, 0.1));
        files::compared("a formula of zeros", &s, &|_, system| inputs(system));
        let system = s.compile().expect("a scene");
        let inputs = inputs(&system);
        let mut solver = Solver::new(&system, Settings::default());
        // A sum may have changed the sign of a coordinate that is zero.
        let q = solver.simulate(&inputs).expect("a motion").q[(0, 0)];
        let [_, b @ ..] = numbers;
        let at = |q: f64| CostPoint {
            q: [q].into(),
            v: SVector::zeros(),
            p_star: SVector::zeros(),
            p_star_dot: SVector::zeros(),
            v_dot: SVector::zeros(),
            sigma: SVector::zeros(),
            lambda: SVector::zeros(),
            u: SVector::zeros(),
            u_dot: SVector::zeros(),
            t: 0.0,
        };
        let plain: f64 = zeros.cost(&at(q), &b.into());
        if plain.is_nan() {
            continue;
        }
        let program = solver.cost().expect("a number");
        assert!((program - plain).abs() < 1e-9, "formula {seed}, {zeros:?} of {numbers:?}: {program} for {plain}");
        compared += 1;
    }
    assert!(2 * compared > formulas, "{compared} of {formulas}");
}

/// V = atan2(±0, −b²) q, of which the sign is made in many ways.
struct Side(usize);

const SIDES: usize = 12;

impl PotentialEnergy<1, 1> for Side {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, t: S) -> S {
        let (b, q, zero) = (b[0], q[0], S::zero());
        let y = match self.0 {
            0 => S::from(-0.0),
            1 => zero * -1.0,
            2 => b * -0.0,
            3 => zero / -b,
            4 => {
                let same = b;
                -(b - same) * 1.0
            }
            5 => -(b * 0.0),
            6 => (b * -0.0) + (zero * -b),
            7 => zero - b * 0.0,
            8 => (b * -0.0).sin(),
            9 => -(q * 0.0).powi(2) - zero,
            10 => (-b * zero).atan2(b),
            _ => (zero - b * 0.0) * -b * (t + 1.0),
        };
        y.atan2(-(b * b)) * q
    }
}

#[test]
fn angles_on_the_cut_are_those_of_the_plain_formula() {
    for which in 0..SIDES {
        let [program, plain] = [true, false].map(|with_programs| {
            let mut s = Scene::new();
            let [x] = s.coordinates("a", ["x"]);
            let b = s.design("b", 0.5);
            s.kinetic_energy("m", Mass, [x], [1.0.into()]);
            s.potential_energy("V", Side(which), [x], [b.into()]);
            s.cost("squares", Squares, Sum::Terminal, [x], [], [], []);
            let system = if with_programs { s.compile() } else { s.compile_without_programs() }.expect("a scene");
            let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.1));
            let first = gradient(&system, &inputs, Settings::default()).expect("a gradient");
            let by_step = complex_step(&system, &inputs, Settings::default(), &[Input::Design(0)]).expect("a motion");
            assert!((by_step[0] - first.design[0]).abs() < 1e-12, "form {which}: {by_step:?} for {:?}", first.design);
            let mut solver = Solver::new(&system, Settings::default());
            solver.simulate(&inputs).expect("a motion");
            let mut direction = inputs.no_change();
            direction.design[0] = 1.0;
            [solver.hessian_product(&direction).expect("a product").clone(), first]
        });
        for (program, plain) in program.iter().zip(&plain) {
            let far = distance(program, plain);
            assert!(far < 1e-12, "form {which}: {far:e}, {} for {}", program.value, plain.value);
        }
        // dJ/dx₀ has the sign of the motion, J has not.
        assert_eq!(program[1].start.q()[0] > 0.0, plain[1].start.q()[0] > 0.0);
    }
}

/// J = arctan(1/(0 − x y z)) + (x y)² x: the factors of both products are shared.
struct Shared;
impl Cost<3> for Shared {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _b: &SVector<S, 0>) -> S {
        let [x, y, z] = [at.q[0], at.q[1], at.q[2]];
        (S::zero() - x * z * y).recip().atan() + x * y * (y * x) * x
    }
}

#[test]
fn products_with_shared_factors_keep_the_signs_of_zeros() {
    for z in [0.0, -0.0] {
        let mut s = Scene::new();
        let q = s.coordinates("a", ["x", "y", "z"]);
        for (q, (name, place)) in q.into_iter().zip([("mx", 1.0), ("my", 1.0), ("mz", z)]) {
            s.kinetic_energy(name, Mass, [q], [1.0.into()]);
            s.place(q, place);
        }
        s.cost("shared", Shared, Sum::Node(0), q, [], [], []);
        let system = s.compile().expect("a scene");
        let mut solver = Solver::new(&system, Settings::default());
        let z = solver.simulate(&Inputs::at_rest(&system, Grid::uniform(1, 0.1))).expect("a motion").q[(2, 0)];
        let expected = (0.0 - z).recip().atan() + 1.0;
        assert!((solver.cost().expect("J") - expected).abs() < 1e-14, "{z:?}");
    }
}
