//! More equations than variables: where they contradict each other, the least sum of squares is what Gauss and Newton find.

use super::{Function, Given};
use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::{
    Interval, Options, Outcome, Problem, Reason, augmented_lagrangian, interior_point, levenberg_marquardt, silent,
};

struct Random(u64);

impl Random {
    /// Between −1 and 1.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| 1.5 * self.next()).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// size (sin s + t/2 + 0.3 s t − target) of s = aᵀx and t = bᵀx.
struct Row {
    a: Vec<f64>,
    b: Vec<f64>,
    target: f64,
    size: f64,
}

impl Row {
    fn value(&self, x: &[f64]) -> f64 {
        let (s, t) = (dot(&self.a, x), dot(&self.b, x));
        self.size * (s.sin() + 0.5 * t + 0.3 * s * t - self.target)
    }

    fn add_gradient(&self, x: &[f64], weight: f64, gradient: &mut [f64]) {
        let (s, t) = (dot(&self.a, x), dot(&self.b, x));
        let (by_s, by_t) = (s.cos() + 0.3 * t, 0.5 + 0.3 * s);
        let of = self.a.iter().zip(&self.b).map(|(a, b)| weight * self.size * (by_s * a + by_t * b));
        gradient.iter_mut().zip(of).for_each(|(g, x)| *g += x);
    }

    fn add_product(&self, x: &[f64], weight: f64, d: &[f64], product: &mut [f64]) {
        let (s, ds, dt) = (dot(&self.a, x), dot(&self.a, d), dot(&self.b, d));
        let (by_s, by_t) = (-s.sin() * ds + 0.3 * dt, 0.3 * ds);
        let of = self.a.iter().zip(&self.b).map(|(a, b)| weight * self.size * (by_s * a + by_t * b));
        product.iter_mut().zip(of).for_each(|(p, x)| *p += x);
    }
}

/// ½ κ ‖x‖² with rows that must be zero.
struct Rows {
    rows: Vec<Row>,
    stiffness: f64,
    bounds: Vec<Interval>,
    x: Vec<f64>,
    asked: (f64, Vec<f64>),
}

impl Problem for Rows {
    fn variables(&self) -> usize {
        self.bounds.len()
    }
    fn bounds(&self) -> Vec<Interval> {
        self.bounds.clone()
    }
    fn constraints(&self) -> Vec<Interval> {
        vec![Interval::ZERO; self.rows.len()]
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.x = x.to_vec();
        c.iter_mut().zip(&self.rows).for_each(|(c, row)| *c = row.value(x));
        Ok(0.5 * self.stiffness * dot(x, x))
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.asked = (f, c.to_vec());
        gradient.iter_mut().zip(&self.x).for_each(|(g, x)| *g = f * self.stiffness * x);
        self.rows.iter().zip(c).for_each(|(row, w)| row.add_gradient(&self.x, *w, gradient));
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let (f, c) = &self.asked;
        product.iter_mut().zip(direction).for_each(|(p, d)| *p = f * self.stiffness * d);
        self.rows.iter().zip(c).for_each(|(row, w)| row.add_product(&self.x, *w, direction, product));
        Ok(())
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Kind {
    /// Whether some x fulfils all rows.
    is_consistent: bool,
    /// Whether the last two variables do the same.
    is_deficient: bool,
    is_bounded: bool,
    /// Powers of ten that the units of rows differ by, up and down.
    decades: f64,
}

/// Rows of 2 to 4 variables, one to four more than those, and a point that fulfils them, or nearly.
fn random(random: &mut Random, kind: Kind) -> (Rows, Vec<f64>) {
    let n = 2 + (random.next().abs() * 3.0) as usize;
    let (m, root) = (n + 1 + (random.next().abs() * 4.0) as usize, random.vector(n));
    let rows = (0..m).map(|_| {
        let (mut a, mut b, error) = (random.vector(n), random.vector(n), 0.7 * random.next());
        if kind.is_deficient {
            (a[n - 1], b[n - 1]) = (a[n - 2], b[n - 2]);
        }
        let mut row = Row { a, b, target: 0.0, size: 1.0 };
        row.target = row.value(&root) + if kind.is_consistent { 0.0 } else { error };
        row.size = 10f64.powf(kind.decades * random.next());
        row
    });
    let rows = Vec::from_iter(rows);
    let stiffness = 10f64.powf(2.0 * random.next());
    let bound = |x: &f64| if kind.is_bounded { Interval::new(x - 0.5, x + 0.5) } else { Interval::FREE };
    let bounds = root.iter().map(bound).collect();
    (Rows { rows, stiffness, bounds, x: vec![], asked: (0.0, vec![]) }, root)
}

fn half_square(outcome: &Outcome) -> f64 {
    0.5 * dot(&outcome.constraints, &outcome.constraints)
}

/// Gradients at the start were taken for units, so that what hardly changed there was to hold first: of 300 points 287 were called infeasible where a
/// smaller violation was next to them.
#[test]
fn what_is_infeasible_is_nowhere_less_violated_nearby() {
    let kind = |is_consistent, is_deficient, is_bounded, decades| Kind { is_consistent, is_deficient, is_bounded, decades };
    let contradict = [kind(false, false, false, 0.0), kind(false, true, false, 0.0), kind(false, false, true, 0.0)];
    let agree = [kind(true, false, false, 0.0), kind(true, true, false, 0.0), kind(true, false, true, 0.0)];
    for kind in [&contradict[..], &agree, &[kind(false, false, false, 2.0), kind(true, false, false, 2.0)]].concat() {
        for (name, method) in [("augmented Lagrangian", augmented_lagrangian as super::Method), ("interior", interior_point)]
        {
            let (mut numbers, mut infeasible, mut feasible, mut evaluations) = (Random(0x9e37_79b9_7f4a_7c15), 0, 0, 0);
            for case in 0..100 {
                let (mut problem, root) = random(&mut numbers, kind);
                let start = Vec::from_iter(root.iter().map(|x| x + 0.7 * numbers.next()));
                let outcome = method(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
                evaluations += outcome.evaluations;
                feasible += usize::from(outcome.reason.is_converged());
                assert!(!outcome.reason.is_converged() || outcome.violation < 1e-8, "{name} {kind:?} {case}: {outcome}");
                if outcome.reason != Reason::Infeasible {
                    continue;
                }
                infeasible += 1;
                let exact = Options { stationarity: 0.0, ..Options::default() };
                let fit = levenberg_marquardt(&mut problem, &outcome.x, &exact, &mut silent).expect("fits");
                let (here, nearby) = (half_square(&outcome), fit.outcome.value);
                assert!(nearby > 0.99 * here, "{name} {kind:?} {case}: {nearby:e} beside {here:e} of {outcome}");
            }
            println!("{name} {kind:?}: {infeasible} infeasible, {feasible} found, {evaluations} evaluations");
            let told = if kind.is_consistent { feasible } else { infeasible };
            assert!(told >= 80, "{name} {kind:?}: {infeasible} infeasible, {feasible} found");
            assert!(evaluations < 100 * 250, "{name} {kind:?}: {evaluations} evaluations");
        }
    }
}

/// c₁ = 1.5e-8 (u + 4336) hardly changes with u; its share of the penalty drew u to −4336, where c₂ = 0.26 atan u is 0.41.
#[test]
fn what_hardly_changes_draws_nothing_away() {
    let flat: Function = |u, c, g| {
        (c[0], c[1]) = (1.5e-8 * (u[0] + 4336.0), 0.26 * u[0].atan());
        g.copy_from_slice(&[1e-3 * u[0], 1.5e-8, 0.26 / (1.0 + u[0] * u[0])]);
        0.5e-3 * u[0] * u[0]
    };
    for start in [-3.0, 0.5, 2.0] {
        let mut problem = Given::new(flat, vec![Interval::FREE], vec![Interval::ZERO; 2]);
        let outcome = augmented_lagrangian(&mut problem, &[start], &Options::default(), &mut silent).expect("fits");
        println!("{outcome}: u = {}", outcome.x[0]);
        assert_eq!(outcome.reason, Reason::Infeasible, "{outcome:?}");
        assert!(outcome.violation < 6.6e-5 && outcome.x[0].abs() < 1e-3, "{outcome:?}");
        assert_eq!(outcome.multipliers, [0.0, 0.0], "there are none");
    }
}

/// Twice the same in two units, and a root that is double: constraints that hold are found to hold.
#[test]
fn equations_that_say_the_same_twice_are_fulfilled() {
    let again: Function = |x, c, g| {
        let square = x[0] * x[0] + x[1] * x[1] - 2.0;
        c.copy_from_slice(&[square, 1e3 * square, x[0] - x[1], (x[0] - x[1]) * 1e-2]);
        let (by_x, by_y) = (2.0 * x[0], 2.0 * x[1]);
        g.copy_from_slice(&[1.0, 0.0, by_x, by_y, 1e3 * by_x, 1e3 * by_y, 1.0, -1.0, 1e-2, -1e-2]);
        x[0]
    };
    for start in [[2.0, 0.3], [0.5, 1.5], [3.0, -1.0]] {
        let mut problem = Given::new(again, vec![Interval::FREE; 2], vec![Interval::ZERO; 4]);
        let outcome = augmented_lagrangian(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        let is_there = (outcome.x[0].abs() - 1.0).abs() < 1e-8 && (outcome.x[0] - outcome.x[1]).abs() < 1e-7;
        assert!(outcome.reason == Reason::Stationary && is_there, "{outcome:?}");
    }
}
