//! Random formulas whose maxima and minima cut off branches that are infinite or no numbers: programs have the derivatives of first and second order
//! that num-dual makes.
//!
//! `RANDOM_CUTS=20000 cargo test --release --test formulas -- --nocapture` tries more of them.

use super::random::Random;
use super::*;
use hamiltonian_adjoint::{Grid, ParameterFormula, Solver, Start};

/// What is no number, or infinite, for x < 0.
#[derive(Clone, Copy, Debug)]
enum Branch {
    Root,
    Power(f64),
    Logarithm,
    Arcsine,
    RootOfRoot,
    Overflow,
    Pole,
}

impl Branch {
    fn random(random: &mut Random) -> Self {
        match random.below(9) {
            0 => Branch::Root,
            1 => Branch::Power(0.5),
            2 => Branch::Power(1.5),
            3 => Branch::Power(2.5),
            4 => Branch::Logarithm,
            5 => Branch::Arcsine,
            6 => Branch::RootOfRoot,
            7 => Branch::Overflow,
            _ => Branch::Pole,
        }
    }

    fn at<S: Scalar>(self, x: S, y: S) -> S {
        match self {
            Branch::Root => x.sqrt() * y,
            Branch::Power(n) => x.powf(n),
            Branch::Logarithm => x.ln() + y,
            Branch::Arcsine => (x - 1.0).asin(),
            Branch::RootOfRoot => (x.sqrt() + y * y).powf(1.5),
            Branch::Overflow => (x * -4000.0).exp(),
            Branch::Pole => (x.abs() + x).recip() * (y * y + 1.0),
        }
    }

    /// Whether a maximum cuts it off too: it is no number.
    fn is_nan(self) -> bool {
        !matches!(self, Branch::Overflow | Branch::Pole)
    }
}

/// A formula of arguments, the first of which is negative.
#[derive(Clone, Debug)]
enum Tree {
    Argument(usize),
    Number(f64),
    Sum(Box<[Tree; 2]>),
    Difference(Box<[Tree; 2]>),
    Product(Box<[Tree; 2]>),
    Sine(Box<Tree>),
    Root(Box<Tree>),
    Magnitude(Box<Tree>),
    /// The value, whatever the branch would be.
    Cut {
        value: Box<Tree>,
        branch: Branch,
        y: usize,
        is_minimum: bool,
    },
}

impl Tree {
    fn random(random: &mut Random, depth: usize) -> Self {
        let leaf = |random: &mut Random| match random.below(4) {
            0 => Tree::Number(random.between(-1.0, 1.0)),
            _ => Tree::Argument(1 + random.below(3)),
        };
        if depth == 0 {
            return leaf(random);
        }
        let of = |random: &mut Random| Box::new(Tree::random(random, depth - 1));
        let pair = |random: &mut Random| Box::new([Tree::random(random, depth - 1), Tree::random(random, depth - 1)]);
        match random.below(11) {
            0 => leaf(random),
            1 => Tree::Sum(pair(random)),
            2 => Tree::Difference(pair(random)),
            3 | 4 => Tree::Product(pair(random)),
            5 => Tree::Sine(of(random)),
            6 => Tree::Root(of(random)),
            7 => Tree::Magnitude(of(random)),
            _ => {
                let (branch, value) = (Branch::random(random), of(random));
                let is_minimum = !branch.is_nan() || random.below(2) == 0;
                Tree::Cut { value, branch, y: 1 + random.below(3), is_minimum }
            }
        }
    }

    fn at<S: Scalar>(&self, x: &[S; 4]) -> S {
        match self {
            Tree::Argument(which) => x[*which],
            Tree::Number(number) => S::from(*number),
            Tree::Sum(of) => of[0].at(x) + of[1].at(x),
            Tree::Difference(of) => of[0].at(x) - of[1].at(x),
            Tree::Product(of) => of[0].at(x) * of[1].at(x),
            Tree::Sine(of) => of.at(x).sin(),
            Tree::Root(of) => (of.at(x).powi(2) + 1.0).sqrt(),
            Tree::Magnitude(of) => (of.at(x) + 0.3).abs(),
            Tree::Cut { value, branch, y, is_minimum } => {
                let (value, other) = (value.at(x), branch.at(x[0], x[*y]));
                if *is_minimum { value.min(other) } else { value.max(other) }
            }
        }
    }
}

/// Where the formula stands, and which argument of it is negative.
#[derive(Clone, Debug)]
struct Cut {
    tree: Tree,
    /// Of q₀, v₀ or b₀, t − 9.
    negative: usize,
}

impl Cut {
    fn at<S: Scalar>(&self, q: &[S], v: &[S], b: &[S], t: S) -> S {
        let x = [q[0] - 0.9, v[0] - 0.9, b[0], t - 9.0][self.negative];
        self.tree.at(&[x, q[1], if v.len() > 1 { v[1] } else { q[0] }, b[1]])
    }
}

impl KineticEnergy<2, 2> for Cut {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 2>) -> S {
        v.dot(v) + v[0] * v[1] * self.at(q.as_slice(), q.as_slice(), b.as_slice(), S::zero()).sin() * 0.3
    }
}

impl PotentialEnergy<2, 2> for Cut {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 2>, t: S) -> S {
        self.at(q.as_slice(), q.as_slice(), b.as_slice(), t)
    }
}

impl Force<2, 0, 2> for Cut {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 2>) -> SVector<S, 2> {
        let f = self.at(at.q.as_slice(), at.v.as_slice(), b.as_slice(), at.t);
        SVector::from([f, f * at.q[0]])
    }
}

/// Φ = z − f(x, y, b, t).
impl Constraint<3, 1, 2> for Cut {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 2>, t: S) -> SVector<S, 1> {
        SVector::from([q[2] - self.at(&q.as_slice()[..2], &q.as_slice()[..2], b.as_slice(), t)])
    }
}

impl Cost<2, 0, 0, 2> for Cut {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, b: &SVector<S, 2>) -> S {
        self.at(at.q.as_slice(), at.v.as_slice(), b.as_slice(), at.t)
            + at.v_dot[0] * self.at(at.q.as_slice(), at.v_dot.as_slice(), b.as_slice(), at.t)
    }
}

impl ParameterFormula<2> for Cut {
    fn value<S: Scalar>(&self, b: &SVector<S, 2>) -> S {
        let x = [b[1], b[0] * 0.7];
        self.at(&x, &x, b.as_slice(), S::zero())
    }
}

/// V = f(b) sin q₀ q₁, with a parameter or without.
struct Stiffness(Option<Cut>);
impl PotentialEnergy<2, 2> for Stiffness {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 2>, _t: S) -> S {
        let stiffness = self.0.as_ref().map_or(b[0], |cut| ParameterFormula::value(cut, b));
        stiffness * q[0].sin() * q[1]
    }
}

const KINDS: [&str; 6] = ["T", "V", "Q", "joint", "cost", "parameter"];

/// The gradient, and the product of the Hessian with a direction.
fn outcome(cut: &Cut, kind: &str, with_programs: bool) -> Result<[Gradient; 2], Error> {
    let mut s = Scene::new();
    let [[x], [y], [z]] = [s.coordinates("a", ["x"]), s.coordinates("b", ["y"]), s.coordinates("c", ["z"])];
    for (name, q, mass) in [("mx", x, 1.0), ("my", y, 1.3), ("mz", z, 0.8)] {
        s.kinetic_energy(name, Mass, [q], [mass.into()]);
    }
    let b = [s.design("b", -0.5).into(), s.design("c", 0.8).into()];
    match kind {
        "T" => s.kinetic_energy(kind, cut.clone(), [x, y], b),
        "V" => s.potential_energy(kind, cut.clone(), [x, y], b),
        "Q" => s.force(kind, cut.clone(), [x, y], [], b),
        "joint" => _ = s.constraint(kind, cut.clone(), [x, y, z], b),
        "cost" => s.cost(kind, cut.clone(), Sum::Trapezoidal, [x, y], [], [], b),
        _ if with_programs => {
            let stiffness = s.parameter("stiffness", cut.clone(), b);
            s.potential_energy("V", Stiffness(None), [x, y], [stiffness, 0.0.into()]);
        }
        _ => s.potential_energy("V", Stiffness(Some(cut.clone())), [x, y], b),
    }
    s.cost("squares", Squares, Sum::Trapezoidal, [x, y, z], [], [], []);
    if with_programs {
        files::compared("a branch that is cut off", &s, &|_, system| Inputs::at_rest(system, Grid::uniform(3, 0.01)));
    }
    let system = if with_programs { s.compile() } else { s.compile_without_programs() }?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(3, 0.01));
    let mut q = nalgebra::DVector::from_column_slice(&[0.3, -0.4, 0.1]);
    if kind == "joint" {
        q[2] = cut.at(&[q[0], q[1]], &[q[0], q[1]], &[-0.5, 0.8], 0.0);
    }
    inputs.start = Start::Momentum { q, p_star: nalgebra::DVector::from_column_slice(&[0.6, -0.4, 0.3]) };
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let mut direction = inputs.no_change();
    direction.design.copy_from_slice(&[0.7, -0.3]);
    direction.start.q_mut().copy_from_slice(&[0.2, 0.5, 0.1]);
    direction.start.rate_mut().copy_from_slice(&[-0.4, 0.3, 0.6]);
    let product = solver.hessian_product(&direction)?.clone();
    Ok([solver.gradient()?.clone(), product])
}

#[test]
fn branches_that_are_cut_off_have_no_part_in_derivatives_of_any_order() {
    let formulas: u64 = std::env::var("RANDOM_CUTS").ok().and_then(|n| n.parse().ok()).unwrap_or(150);
    let (mut compared, mut tried) = (0, 0);
    for seed in 0..formulas {
        let mut random = Random(seed);
        let tree = Tree::random(&mut random, 3);
        for kind in KINDS {
            let cut = Cut { tree: tree.clone(), negative: if kind == "parameter" { 2 } else { random.below(4) } };
            let [program, dual] = [true, false].map(|with| outcome(&cut, kind, with));
            tried += 1;
            let Ok(dual) = dual else { continue };
            let program = program.unwrap_or_else(|error| panic!("formula {seed}, {cut:?}, as {kind}: {error}"));
            for (order, (program, dual)) in program.iter().zip(&dual).enumerate() {
                let far = distance(program, dual);
                assert!(far < 1e-9, "formula {seed}, {cut:?}, as {kind}, order {}: {far:e}", order + 1);
            }
            compared += 1;
        }
    }
    println!("{compared} of {tried} compared");
    assert!(compared as f64 > 0.8 * tried as f64, "{compared} of {tried}");
}
