//! Random formulas that branch on values: trees of operations, of which many read values and lose no derivative.

use hamiltonian_adjoint::Scalar;
use hamiltonian_adjoint::check::Random;

/// A formula of numbered arguments.
#[derive(Clone, Debug)]
pub enum Tree {
    Argument(usize),
    Number(f64),
    /// One of the functions of [`Scalar`].
    Function(usize, Box<Tree>),
    /// One of the operations of two numbers.
    Operation(usize, Box<Tree>, Box<Tree>),
    /// One of the ways to read a value without losing a derivative.
    Reading(usize, Box<Tree>, Box<Tree>),
}

pub const FUNCTIONS: usize = 10;
pub const OPERATIONS: usize = 7;
pub const READINGS: usize = 12;

/// How many derivatives are to be right of what values are found by iterations or given with slopes.
#[derive(Clone, Copy, Debug)]
pub struct Slopes(pub i32);

impl Tree {
    /// A formula of so many levels; it reads a value at the top.
    pub fn new(random: &mut Random, arguments: usize, levels: usize) -> Self {
        let [x, y] = [0; 2].map(|_| Box::new(Tree::below(random, arguments, levels)));
        Tree::Reading(random.below(READINGS), x, y)
    }

    fn below(random: &mut Random, arguments: usize, levels: usize) -> Self {
        if levels == 0 || random.below(6) == 0 {
            return if random.below(5) == 0 {
                Tree::Number(random.uniform(-2.0, 2.0))
            } else {
                Tree::Argument(random.below(arguments))
            };
        }
        let x = Box::new(Tree::below(random, arguments, levels - 1));
        match random.below(3) {
            0 => Tree::Function(random.below(FUNCTIONS), x),
            1 => Tree::Operation(random.below(OPERATIONS), x, Box::new(Tree::below(random, arguments, levels - 1))),
            _ => Tree::Reading(random.below(READINGS), x, Box::new(Tree::below(random, arguments, levels - 1))),
        }
    }

    /// Its value, with this many derivatives.
    pub fn value<S: Scalar>(&self, of: &[S], slopes: Slopes) -> S {
        match self {
            Tree::Argument(i) => of[*i],
            Tree::Number(x) => S::from(*x),
            Tree::Function(which, x) => function(*which, x.value(of, slopes)),
            Tree::Operation(which, x, y) => operation(*which, x.value(of, slopes), y.value(of, slopes)),
            Tree::Reading(which, x, y) => reading(*which, x.value(of, slopes), y.value(of, slopes), slopes),
        }
    }
}

fn function<S: Scalar>(which: usize, x: S) -> S {
    match which {
        0 => x.sin(),
        1 => x.cos(),
        2 => x.tanh(),
        3 => x.atan(),
        4 => (x * x + 0.5).sqrt(),
        5 => (x * x + 1.0).ln(),
        6 => x.tanh().exp(),
        7 => x.abs() * 0.5,
        8 => (x * x + 0.3).recip(),
        _ => (x * x + 0.1).powf(1.5).tanh(),
    }
}

fn operation<S: Scalar>(which: usize, x: S, y: S) -> S {
    match which {
        0 => x + y,
        1 => x - y,
        2 => x.sin() * y,
        3 => x / (y * y + 1.0),
        4 => x.max(y),
        5 => x.min(y),
        _ => x.atan2(y * y + 0.2),
    }
}

/// Lines between values of sin at every fifth.
pub fn lines<S: Scalar>(x: S) -> S {
    let from = (x.re() * 5.0).floor() / 5.0;
    let (low, high) = (from.sin(), (from + 0.2).sin());
    (x - from) * ((high - low) / 0.2) + low
}

/// y + y³ = x.
fn root(x: f64) -> f64 {
    let newton = |y: f64| y - (y + y * y * y - x) / (1.0 + 3.0 * y * y);
    (0..60).fold(x.cbrt(), |y, _| newton(y))
}

fn reading<S: Scalar>(which: usize, x: S, y: S, slopes: Slopes) -> S {
    match which {
        0 => {
            if x.re() > 0.3 {
                x - 0.3
            } else {
                y * 0.5
            }
        }
        1 => {
            if x.re() > y.re() {
                x * 2.0 - y
            } else {
                x
            }
        }
        2 => lines(x) + y,
        // The branch of a periodic function, and signs.
        3 => (x - (x.re() / 3.0).round() * 3.0).tanh() + y,
        4 => x * x.re().signum() + y,
        5 => y * S::from((x.re() * 4.0).floor().clamp(-3.0, 3.0)),
        // √(x² + y² + ε) by ratios to the larger, and ln(eˣ + eʸ) by the larger.
        6 => {
            let largest = x.re().abs().max(y.re().abs()).max(1e-3);
            ((x / largest).powi(2) + (y / largest).powi(2) + 1e-3 / largest.powi(2)).sqrt() * largest
        }
        7 => {
            let largest = x.re().max(y.re());
            ((x - largest).exp() + (y - largest).exp()).ln() + largest
        }
        // A root, found by values and corrected until it has derivatives.
        8 => {
            let corrected = |y: S| y - (y + y * y * y - x) / (y * y * 3.0 + 1.0);
            (0..slopes.0.max(1)).fold(S::from(root(x.re())), |y, _| corrected(y)) + y
        }
        // A function by its values and derivatives.
        9 => {
            let (x0, mut sum, mut power) = (x.re(), S::zero(), S::one());
            for k in 0..=slopes.0 {
                sum += power * [x0.sin(), x0.cos(), -0.5 * x0.sin(), -x0.cos() / 6.0, x0.sin() / 24.0][k as usize];
                power *= x - x0;
            }
            sum + y
        }
        10 => match (x.re() < -0.5, y.re() < 0.5) {
            (true, true) => x * y,
            (true, false) => y.sin() - x,
            (false, true) => x + y,
            (false, false) => y,
        },
        _ => {
            if x.is_zero() || x == y {
                y
            } else {
                x.tanh() - y
            }
        }
    }
}
