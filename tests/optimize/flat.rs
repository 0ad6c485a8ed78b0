//! Convex quadratic programs whose solutions are known, from curved to nearly straight: bounds and constraints limit the way then, not curvature.

use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::{
    Interval, Options, Problem, Reason, augmented_lagrangian, interior_point, lbfgs, silent,
};
use nalgebra::{DMatrix, DVector};

/// ½ xᵀH x + gᵀx subject to bounds of x and of A x.
pub struct Quadratic {
    h: DMatrix<f64>,
    g: DVector<f64>,
    a: DMatrix<f64>,
    bounds: Vec<Interval>,
    constraints: Vec<Interval>,
    x: DVector<f64>,
    weight: f64,
}

impl Quadratic {
    /// Without constraints.
    pub fn new(h: DMatrix<f64>, g: &[f64], bounds: Vec<Interval>) -> Self {
        let n = g.len();
        let (a, x) = (DMatrix::zeros(0, n), DVector::zeros(n));
        Quadratic { h, g: DVector::from_column_slice(g), a, bounds, constraints: vec![], x, weight: 1.0 }
    }

    fn value(&self, x: &DVector<f64>) -> f64 {
        0.5 * x.dot(&(&self.h * x)) + self.g.dot(x)
    }
}

impl Problem for Quadratic {
    fn variables(&self) -> usize {
        self.g.len()
    }
    fn bounds(&self) -> Vec<Interval> {
        self.bounds.clone()
    }
    fn constraints(&self) -> Vec<Interval> {
        self.constraints.clone()
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.x.copy_from_slice(x);
        c.copy_from_slice((&self.a * &self.x).as_slice());
        Ok(self.value(&self.x))
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.weight = f;
        let of_c = self.a.tr_mul(&DVector::from_column_slice(c));
        gradient.copy_from_slice(((&self.h * &self.x + &self.g) * f + of_c).as_slice());
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        product.copy_from_slice((&self.h * DVector::from_column_slice(direction) * self.weight).as_slice());
        Ok(())
    }
}

/// Numbers between −1 and 1 (xorshift64*).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn below(&mut self, count: usize) -> usize {
        (((self.next() + 1.0) * 0.5 * count as f64) as usize).min(count - 1)
    }

    /// An interval that a value at the solution is in, and the multiplier that belongs to it.
    fn interval(&mut self, value: f64) -> (Interval, f64) {
        let (room, force) = (1.0 + self.next(), 0.1 + 2.0 * self.next().abs());
        match self.below(6) {
            0 => (Interval::FREE, 0.0),
            1 => (Interval::equal(value), 2.0 * self.next()),
            2 => (Interval::new(value, value + 0.1 + room), -force),
            3 => (Interval::new(value - 0.1 - room, value), force),
            4 => (Interval::at_least(value), -force),
            _ => (Interval::new(value - 0.1 - room, value + 0.1 + self.next().abs()), 0.0),
        }
    }
}

/// A problem with such curvature, and its solution: multipliers say what the gradient must be there.
fn known(random: &mut Random, curvature: f64) -> (Quadratic, DVector<f64>) {
    let (n, m) = (1 + random.below(3), random.below(3));
    let root = DMatrix::from_fn(n, n, |_, _| 2.0 * random.next());
    let h = (&root * root.transpose() + DMatrix::identity(n, n) * 0.1) * curvature;
    let (a, x) = (DMatrix::from_fn(m, n, |_, _| 2.0 * random.next()), DVector::from_fn(n, |_, _| 2.0 * random.next()));
    let (mut gradient, c) = (-(&h * &x), &a * &x);
    let mut bounds = Vec::new();
    for i in 0..n {
        let (of, force) = random.interval(x[i]);
        bounds.push(of);
        gradient[i] -= force;
    }
    let mut constraints = Vec::new();
    for j in 0..m {
        let (of, force) = random.interval(c[j]);
        constraints.push(of);
        gradient -= a.row(j).transpose() * force;
    }
    let mut problem = Quadratic::new(h, gradient.as_slice(), bounds);
    (problem.a, problem.constraints) = (a, constraints);
    (problem, x)
}

/// The same problem with its constraints in other units, up to so many powers of ten.
fn in_other_units(problem: &mut Quadratic, random: &mut Random, decades: usize) {
    for j in 0..problem.constraints.len() {
        let unit = 10f64.powi(random.below(2 * decades + 1) as i32 - decades as i32);
        problem.a.row_mut(j).scale_mut(unit);
        let of = problem.constraints[j];
        problem.constraints[j] = Interval { least: of.least * unit, most: of.most * unit };
    }
}

/// With one penalty for all, constraints in large units hid from view what those in small ones were violated by: 6 of 2,000 problems were called infeasible
/// with units up to 1e4, 11 with units up to 1e6.
#[test]
fn units_of_constraints_are_no_matter_to_the_augmented_lagrangian() {
    for decades in [0, 2, 4, 6] {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for case in 0..400 {
            let (mut problem, x) = known(&mut random, 1.0);
            in_other_units(&mut problem, &mut random, decades);
            let start: Vec<f64> = x.iter().map(|_| 2.0 * random.next()).collect();
            let outcome = augmented_lagrangian(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            let above = (outcome.value - problem.value(&x)).abs();
            let holds = match outcome.reason {
                // What may be left of a constraint is a number in its own unit.
                Reason::Stationary => outcome.violation <= 1e-9 && above < 1e-8 * 10f64.powi(decades as i32),
                // Rounding may be more than that.
                Reason::NoLowerValue => above < 1e-9,
                _ => false,
            };
            assert!(holds, "{decades} decades, {case}: {outcome:?}, above the least value by {above:e}");
        }
    }
}

/// Less than half of them were called so: the violations whose sum of squares was least were not those that were looked at.
#[test]
fn constraints_that_contradict_each_other_are_called_infeasible_in_any_units() {
    for decades in [0, 2, 4, 6] {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for case in 0..100 {
            let (mut problem, x) = known(&mut random, 1.0);
            let row = DMatrix::from_fn(1, x.len(), |_, _| 2.0 * random.next());
            let rows = problem.a.row_iter().chain(row.row_iter()).map(|row| row.into_owned());
            let both = rows.chain([row.row(0) * 1.7]).collect::<Vec<_>>();
            problem.a = DMatrix::from_rows(&both);
            let least = random.next();
            problem.constraints.extend([Interval::at_least(least + 0.5), Interval::at_most(1.7 * least)]);
            in_other_units(&mut problem, &mut random, decades);
            let start: Vec<f64> = x.iter().map(|_| 2.0 * random.next()).collect();
            let outcome = augmented_lagrangian(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert_eq!(outcome.reason, Reason::Infeasible, "{decades} decades, {case}: {outcome:?}");
        }
    }
}

/// x² where x is to be 1, beside a value that nothing is asked of and that has no derivative.
struct LookedAt(f64);
impl Problem for LookedAt {
    fn variables(&self) -> usize {
        1
    }
    fn constraints(&self) -> Vec<Interval> {
        vec![Interval::equal(1.0), Interval::FREE]
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.0 = x[0];
        c.copy_from_slice(&[x[0], x[0].abs().sqrt()]);
        Ok(x[0] * x[0])
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = if c[1] == 0.0 { 2.0 * f * self.0 + c[0] } else { f64::NAN };
        Ok(())
    }
}

#[test]
fn values_that_nothing_is_asked_of_need_no_derivative() {
    let outcome = augmented_lagrangian(&mut LookedAt(0.0), &[0.0], &Options::default(), &mut silent).expect("fits");
    assert!(outcome.reason == Reason::Stationary && (outcome.x[0] - 1.0).abs() < 1e-8, "{outcome:?}");
}

#[test]
fn solutions_are_found_however_straight_the_objective_is() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for case in 0..150 {
        let curvature = 10f64.powi(-(case % 10));
        let (mut problem, x) = known(&mut random, curvature);
        let start: Vec<f64> = x.iter().map(|_| 2.0 * random.next()).collect();
        let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        let above = outcome.value - problem.value(&x);
        assert_eq!(outcome.reason, Reason::Stationary, "{case}: {outcome:?}, above the least value by {above:e}");
        assert!(above.abs() < 1e-5 * (1.0 + outcome.value.abs()), "{case}: {above:e}, {:?} for {x}", outcome.x);
    }
}

/// The step to where the parabola is least was a unit of 1e7: all was small beside it.
#[test]
fn bounds_limit_the_unit_of_variables() {
    for curvature in [1e-3, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 0.0] {
        let h = DMatrix::from_element(1, 1, 2.0 * curvature);
        let bounds = [Interval::new(0.0, 1.0), Interval::at_least(0.0), Interval::FREE];
        for (bound, constraint) in [(bounds[0], None), (bounds[1], None), (bounds[2], Some(bounds[0]))] {
            let mut problem = Quadratic::new(h.clone(), &[1.0], vec![bound]);
            if let Some(of) = constraint {
                (problem.a, problem.constraints) = (DMatrix::identity(1, 1), vec![of]);
            }
            let outcome = interior_point(&mut problem, &[0.5], &Options::default(), &mut silent).expect("fits");
            assert!(outcome.reason == Reason::Stationary && outcome.x[0].abs() < 1e-6, "{curvature:e}: {outcome:?}");
        }
    }
}

/// As above for a length that equalities pass on to a variable with bounds, from where everything is zero.
#[test]
fn bounds_limit_the_unit_of_variables_that_depend_on_others() {
    for curvature in [1e-6, 1e-8, 1e-9] {
        let h = DMatrix::from_diagonal(&DVector::from_vec(vec![curvature, 0.0]));
        let mut problem = Quadratic::new(h, &[1.0, 0.0], vec![Interval::FREE, Interval::new(-1.0, 1.0)]);
        (problem.a, problem.constraints) = (DMatrix::from_row_slice(1, 2, &[1.0, -1.0]), vec![Interval::ZERO]);
        let outcome = interior_point(&mut problem, &[0.0; 2], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason == Reason::Stationary && (outcome.x[0] + 1.0).abs() < 1e-6, "{outcome:?}");
    }
}

/// Changes of the gradient of what a bound holds were taken for curvature along the steps of the others.
#[test]
fn what_is_held_does_not_slow_down_what_is_free() {
    let h = DMatrix::from_row_slice(3, 3, &[401.0, 10.0, 10.0, 10.0, 1.0, 0.0, 10.0, 0.0, 2.0]);
    for bound in [Interval::equal(1.0), Interval::at_least(1.0)] {
        let mut problem = Quadratic::new(h.clone(), &[200.0, 0.3, -0.7], vec![bound, Interval::FREE, Interval::FREE]);
        let outcome = lbfgs(&mut problem, &[1.0, 5.0, 4.0], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason == Reason::Stationary && outcome.history.len() < 15, "{outcome:?}");
        assert!((outcome.x[1] + 10.3).abs() < 1e-4 && (outcome.x[2] + 4.65).abs() < 1e-4, "{:?}", outcome.x);
    }
}
