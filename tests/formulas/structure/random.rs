//! Random scenes whose coefficients vanish, saturate and are undefined in places: traced and opaque formulas give the same.
//!
//! `RANDOM_STRUCTURES=20000 cargo test --release --test formulas structure -- --nocapture` tries more of them.

use super::*;

/// A sequence of numbers that look random.
pub(super) struct Random(pub(super) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
    pub(super) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A coefficient made of a design variable.
#[derive(Clone, Copy, Debug)]
enum Coefficient {
    Constant(f64),
    Zero,
    Linear(f64),
    Tanh(f64),
    Sigmoid(f64),
    Softplus(f64),
    Bump(f64),
    Root(f64),
    Logarithm(f64),
    Square(f64),
}

impl Coefficient {
    fn random(random: &mut Random) -> Self {
        // The scene is compiled far below the threshold, and runs above it.
        let c = random.between(1.5, 2.5);
        match random.below(10) {
            0 => Coefficient::Constant(random.between(-1.0, 1.0)),
            1 => Coefficient::Zero,
            2 => Coefficient::Linear(random.between(-0.4, 0.4)),
            3 => Coefficient::Tanh(c),
            4 => Coefficient::Sigmoid(c),
            5 => Coefficient::Softplus(c),
            6 => Coefficient::Bump(random.between(2.8, 3.2)),
            7 => Coefficient::Root(c),
            8 => Coefficient::Logarithm(c),
            _ => Coefficient::Square(if random.below(2) == 0 { 0.0 } else { c }),
        }
    }

    fn at<S: Scalar>(self, b: S) -> S {
        match self {
            Coefficient::Constant(c) => S::from(c),
            Coefficient::Zero => S::zero(),
            Coefficient::Linear(c) => b * c,
            Coefficient::Tanh(c) => ((b - c) * 30.0).tanh() * 0.5 + 0.5,
            Coefficient::Sigmoid(c) => ((-(b - c) * 500.0).exp() + 1.0).recip(),
            Coefficient::Softplus(c) => ((b - c) * 40.0).exp().ln_1p() * 0.02,
            Coefficient::Bump(c) => (-((b - c) * 40.0).powi(2)).exp(),
            Coefficient::Root(c) => (b - c).sqrt(),
            Coefficient::Logarithm(c) => (b - c).ln() + 1.0,
            Coefficient::Square(c) => (b - c).powi(2) * 0.1,
        }
    }
}

/// What a coefficient multiplies, of inputs x_i and x_j.
#[derive(Clone, Copy, Debug)]
enum Shape {
    One,
    Linear,
    Product,
    Square,
    Difference,
    Sine,
    Cosine,
    Exponential,
    Root,
    Quotient,
    Cube,
}

const SHAPES: [Shape; 11] = [
    Shape::One,
    Shape::Linear,
    Shape::Product,
    Shape::Square,
    Shape::Difference,
    Shape::Sine,
    Shape::Cosine,
    Shape::Exponential,
    Shape::Root,
    Shape::Quotient,
    Shape::Cube,
];

#[derive(Clone, Copy, Debug)]
struct Term {
    coefficient: Coefficient,
    /// Which of the two design variables.
    b: usize,
    shape: Shape,
    i: usize,
    j: usize,
}

impl Term {
    /// Of `inputs` inputs, polynomials of degree two at most every other time.
    fn random(random: &mut Random, inputs: usize) -> Self {
        let shapes = if random.below(2) == 0 { 5 } else { SHAPES.len() };
        let shape = SHAPES[random.below(shapes)];
        let (b, i, j) = (random.below(2), random.below(inputs), random.below(inputs));
        Term { coefficient: Coefficient::random(random), b, shape, i, j }
    }

    fn at<S: Scalar>(&self, x: &[S], b: &[S]) -> S {
        let (u, w) = (x[self.i], x[self.j]);
        let shape = match self.shape {
            Shape::One => S::one(),
            Shape::Linear => u,
            Shape::Product => u * w,
            Shape::Square => u * u,
            Shape::Difference => (u - w).powi(2),
            Shape::Sine => u.sin(),
            Shape::Cosine => u.cos(),
            Shape::Exponential => (u * 0.5).exp(),
            Shape::Root => (u * u + w * w + 0.3).sqrt(),
            Shape::Quotient => u / (w * w + 1.0),
            Shape::Cube => u * u * w * 0.3,
        };
        shape * self.coefficient.at(b[self.b])
    }
}

#[derive(Clone, Debug)]
struct Formula(Vec<Term>);

impl Formula {
    fn random(random: &mut Random, inputs: usize) -> Self {
        Formula((0..1 + random.below(3)).map(|_| Term::random(random, inputs)).collect())
    }

    fn at<S: Scalar>(&self, x: &[S], b: &[S]) -> S {
        self.0.iter().map(|term| term.at(x, b)).sum()
    }
}

/// T = Σ v_i² + 0.1 f(v_0 v_1, …): positive, with the couplings of f.
#[derive(Clone)]
struct Coupled(Formula);
impl KineticEnergy<3, 2> for Coupled {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 3>, v: &SVector<S, 3>, b: &SVector<S, 2>) -> S {
        let bilinear = |term: &Term| {
            let factor = if matches!(term.shape, Shape::Sine) { q[term.i].sin() } else { S::one() };
            v[term.i] * v[term.j] * factor * term.coefficient.at(b[term.b]) * 0.1
        };
        v.dot(v) + self.0.0.iter().map(bilinear).sum::<S>()
    }
}

#[derive(Clone)]
struct Potential(Formula);
impl PotentialEnergy<3, 2> for Potential {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, _t: S) -> S {
        self.0.at(q.as_slice(), b.as_slice())
    }
}

/// Three components of (q, v).
#[derive(Clone)]
struct Forces([Formula; 3]);
impl Force<3, 0, 2> for Forces {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 0>, b: &SVector<S, 2>) -> SVector<S, 3> {
        let x: Vec<S> = at.q.iter().chain(at.v.iter()).copied().collect();
        SVector::from_fn(|i, _| self.0[i].at(&x, b.as_slice()) * 0.3)
    }
}

/// Φ = 2 q_2 + 0.3 (f(q) − f(0)), so that q = 0 is a start for every design.
#[derive(Clone)]
struct Joint(Formula);
impl Constraint<3, 1, 2> for Joint {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, _t: S) -> SVector<S, 1> {
        let zero = [S::zero(); 3];
        SVector::from([q[2] * 2.0 + (self.0.at(q.as_slice(), b.as_slice()) - self.0.at(&zero, b.as_slice())) * 0.3])
    }
}

#[derive(Clone)]
struct Price(Formula);
impl Cost<3, 0, 0, 2> for Price {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, b: &SVector<S, 2>) -> S {
        let x: Vec<S> = at.q.iter().chain(at.v.iter()).copied().collect();
        self.0.at(&x, b.as_slice())
    }
}

/// The scene of a number: its elements traced or opaque, compiled with one design and run with another.
fn scene(seed: u64, opaque: bool, compiled: [f64; 2]) -> Scene {
    let mut random = Random(seed);
    let mut s = Scene::new();
    let q = if random.below(2) == 0 {
        s.coordinates("all", ["x", "y", "z"])
    } else {
        let ([x], [y], [z]) = (s.coordinates("a", ["x"]), s.coordinates("b", ["y"]), s.coordinates("c", ["z"]));
        [x, y, z]
    };
    let b = [s.design("b", compiled[0]).into(), s.design("c", compiled[1]).into()];
    macro_rules! add {
        ($method:ident, $name:literal, $element:expr $(, $list:expr)*) => {{
            let element = $element;
            if opaque {
                _ = s.$method($name, Opaque(element) $(, $list)*, b);
            } else {
                _ = s.$method($name, element $(, $list)*, b);
            }
        }};
    }
    add!(kinetic_energy, "T", Coupled(Formula::random(&mut random, 3)), q);
    add!(potential_energy, "V", Potential(Formula::random(&mut random, 3)), q);
    add!(force, "Q", Forces(std::array::from_fn(|_| Formula::random(&mut random, 6))), q, []);
    if random.below(2) == 0 {
        add!(constraint, "joint", Joint(Formula::random(&mut random, 3)), q);
    }
    add!(cost, "price", Price(Formula::random(&mut random, 6)), Sum::Trapezoidal, q, [], []);
    s.cost("squares", Squares, Sum::Terminal, q, [], [], []);
    s
}

fn outcome(seed: u64, opaque: bool, compiled: [f64; 2]) -> Result<Gradient, Error> {
    run(scene(seed, opaque, compiled), |inputs| {
        inputs.design.copy_from_slice(&[3.0, 2.9]);
        // p* may be anything, and v follows from it and the constraint.
        let q = inputs.start.q().clone();
        let p_star = nalgebra::DVector::from_column_slice(&[0.9, -0.4, 0.3]);
        inputs.start = hamiltonian_adjoint::Start::Momentum { q, p_star };
    })
}

#[test]
fn traced_and_opaque_formulas_give_the_same_motion_and_gradient() {
    let scenes: u64 = std::env::var("RANDOM_STRUCTURES").ok().and_then(|n| n.parse().ok()).unwrap_or(1_000);
    let (mut compared, mut worst) = (0, 0.0f64);
    for seed in 0..scenes {
        // The reference knows the design; the other one is compiled where coefficients are zero, saturated or no numbers.
        let reference = outcome(seed, true, [3.0, 2.9]);
        let traced = outcome(seed, false, if seed % 2 == 0 { [0.0, 0.0] } else { [-3.0, 0.5] });
        match (reference, traced) {
            (Ok(reference), Ok(traced)) => {
                let error = distance(&reference, &traced);
                assert!(error < 1e-9, "scene {seed}: {error:e}");
                compared += 1;
                worst = worst.max(error);
            }
            (Err(a), Err(b)) => {
                assert_eq!(std::mem::discriminant(&a), std::mem::discriminant(&b), "scene {seed}: {a} / {b}")
            }
            (Ok(_), Err(error)) => panic!("scene {seed} is refused: {error}"),
            (Err(error), Ok(_)) => panic!("scene {seed} without trace is refused: {error}"),
        }
    }
    println!("{scenes} scenes, {compared} compared, largest difference {worst:.1e}");
    assert!(compared as f64 > 0.9 * scenes as f64);
}
