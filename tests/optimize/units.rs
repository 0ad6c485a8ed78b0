//! Problems whose cost, constraints and variables are given in other units are solved by the same iterates: powers of two as factors change no digit.

use std::cell::Cell;
use std::ops::ControlFlow;

use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::{
    Interval, Iterate, Options, Outcome, Problem, Reason, augmented_lagrangian, homotopy, lbfgs, levenberg_marquardt, silent,
};

/// Factors of cost, constraints and variables.
#[derive(Clone, Copy, Debug)]
struct Units {
    f: f64,
    c: f64,
    x: f64,
}

const PLAIN: Units = Units { f: 1.0, c: 1.0, x: 1.0 };

fn others() -> Vec<Units> {
    let of = |exponent: i32| {
        let factor = 2f64.powi(exponent);
        let each = [Units { f: factor, ..PLAIN }, Units { c: factor, ..PLAIN }, Units { x: factor, ..PLAIN }];
        each.into_iter().chain([Units { f: factor, c: factor.recip(), x: factor }])
    };
    [-40, -20, -10, 10, 20, 40].into_iter().flat_map(of).collect()
}

/// Which problem, and its bounds and constraints.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Rosenbrock's valley.
    Valley,
    /// The same with an offset, which ends where rounding hides the slope.
    Offset,
    /// The same with x₀ ≤ ½.
    Bounded,
    /// x₀² + x₁² = 2 and x₀ ≥ x₁ + ½.
    Constrained,
    /// From x = 0, where f = 0.
    Origin,
    /// |x|: no slope at its end.
    Kink,
    /// x₀² + x₁² ≤ 3/2, from where it holds.
    Inside,
}

const KINDS: [Kind; 7] =
    [Kind::Valley, Kind::Offset, Kind::Bounded, Kind::Constrained, Kind::Origin, Kind::Kink, Kind::Inside];

struct Scaled {
    kind: Kind,
    units: Units,
    /// How much of the constraints there is, for homotopies.
    s: f64,
    at: [f64; 2],
    /// Of f and of the first constraint in the last gradient.
    weights: [f64; 2],
}

impl Scaled {
    fn new(kind: Kind, units: Units) -> Self {
        Scaled { kind, units, s: 1.0, at: [0.0; 2], weights: [0.0; 2] }
    }

    fn start(&self) -> Vec<f64> {
        let start = match self.kind {
            Kind::Origin => [0.0, 0.0],
            Kind::Inside => [-0.5, 0.5],
            _ => [-1.2, 1.0],
        };
        start.map(|x| x * self.units.x).into()
    }
}

impl Problem for Scaled {
    fn variables(&self) -> usize {
        2
    }

    fn bounds(&self) -> Vec<Interval> {
        let most = if matches!(self.kind, Kind::Bounded) { 0.5 * self.units.x } else { f64::INFINITY };
        vec![Interval::at_most(most), Interval::FREE]
    }

    fn constraints(&self) -> Vec<Interval> {
        match self.kind {
            Kind::Constrained => vec![Interval::ZERO, Interval::at_least(0.5 * self.units.c)],
            Kind::Inside => vec![Interval::at_most(-0.5 * self.units.c), Interval::FREE],
            _ => Vec::new(),
        }
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.at = [x[0] / self.units.x, x[1] / self.units.x];
        let [x, y] = self.at;
        if !c.is_empty() {
            c[0] = (x * x + y * y - 1.0 - self.s) * self.units.c;
            c[1] = (x - y) * self.units.c;
        }
        let valley = 100.0 * (y - x * x).powi(2) + (1.0 - x).powi(2);
        let f = match self.kind {
            Kind::Offset => valley + 1e5,
            Kind::Origin => valley - 1.0,
            Kind::Kink => (x - 0.3).abs() + (y - 0.2).powi(2) + 0.1,
            _ => valley,
        };
        Ok(f * self.units.f)
    }

    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let [x, y] = self.at;
        let of_f = match self.kind {
            Kind::Kink => [(x - 0.3).signum(), 2.0 * (y - 0.2)],
            _ => [-400.0 * x * (y - x * x) - 2.0 * (1.0 - x), 200.0 * (y - x * x)],
        };
        gradient.iter_mut().zip(of_f).for_each(|(g, of_f)| *g = f * self.units.f * of_f);
        if let [first, second] = c {
            gradient[0] += self.units.c * (first * 2.0 * x + second);
            gradient[1] += self.units.c * (first * 2.0 * y - second);
        }
        gradient.iter_mut().for_each(|g| *g /= self.units.x);
        self.weights = [f, c.first().copied().unwrap_or(0.0)];
        Ok(())
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let ([x, y], [f, c], Units { f: of_f, c: of_c, x: of_x }) = (self.at, self.weights, self.units);
        let (f, c) = (f * of_f / (of_x * of_x), 2.0 * c * of_c / (of_x * of_x));
        let [xx, xy, yy] = [1200.0 * x * x - 400.0 * y + 2.0, -400.0 * x, 200.0];
        product[0] = (f * xx + c) * direction[0] + f * xy * direction[1];
        product[1] = f * xy * direction[0] + (f * yy + c) * direction[1];
        Ok(())
    }
}

/// What an outcome is without units.
#[derive(Debug, PartialEq)]
struct Way {
    x: Vec<f64>,
    values: Vec<f64>,
    evaluations: usize,
    gradients: usize,
    reason: Reason,
}

impl Way {
    fn of(outcome: &Outcome, of_x: f64, of_value: f64) -> Self {
        let Outcome { evaluations, gradients, reason, .. } = *outcome;
        let x = outcome.x.iter().map(|x| x / of_x).collect();
        let values = outcome.history.iter().map(|it| it.value / of_value).collect();
        Way { x, values, evaluations, gradients, reason }
    }

    /// Where nothing but a length in units of the variables could tell how long the first step should be, ways differ, but not their end.
    fn is_like(&self, of: &Way, kind: Kind) -> bool {
        let near = self.x.iter().zip(&of.x).all(|(x, of)| (x - of).abs() < 1e-6);
        if matches!(kind, Kind::Origin) { near && self.reason == of.reason } else { self == of }
    }
}

/// `of_value` is the unit of the values that are minimised.
fn assert_same(run: impl Fn(Kind, Units, &Options) -> Option<Outcome>, of_value: fn(Units) -> f64) {
    for kind in KINDS {
        let options = |units: Units| Options { violation: 1e-9 * units.c, iterations: 300, ..Options::default() };
        let Some(plain) = run(kind, PLAIN, &options(PLAIN)) else { continue };
        let plain = Way::of(&plain, 1.0, 1.0);
        assert!(plain.reason.is_converged() || matches!(kind, Kind::Kink), "{kind:?}: {plain:?}");
        for units in others() {
            let found = run(kind, units, &options(units)).expect("an outcome");
            let found = Way::of(&found, units.x, of_value(units));
            assert!(found.is_like(&plain, kind), "{kind:?}: {units:?}: {found:?} is not {plain:?}");
        }
    }
}

#[test]
fn lbfgs_goes_the_same_way() {
    let run = |kind, units, options: &Options| {
        let mut problem = Scaled::new(kind, units);
        let start = problem.start();
        problem.constraints().is_empty().then(|| lbfgs(&mut problem, &start, options, &mut silent).expect("an outcome"))
    };
    assert_same(run, |units| units.f);
}

#[test]
fn the_augmented_lagrangian_goes_the_same_way() {
    let run = |kind, units, options: &Options| {
        let mut problem = Scaled::new(kind, units);
        let start = problem.start();
        Some(augmented_lagrangian(&mut problem, &start, options, &mut silent).expect("an outcome"))
    };
    assert_same(run, |units| units.f);
}

/// The residuals 10 (y − x²) and 1 − x, and their sum.
struct Residuals(Scaled, usize);

impl Problem for Residuals {
    fn variables(&self) -> usize {
        2
    }

    fn bounds(&self) -> Vec<Interval> {
        self.0.bounds()
    }

    fn constraints(&self) -> Vec<Interval> {
        [Interval::ZERO, Interval::ZERO, Interval::equal(0.1 * self.0.units.c)][..self.1].into()
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        let Units { c: unit, x: of, .. } = self.0.units;
        self.0.at = [x[0] / of, x[1] / of];
        let [x, y] = self.0.at;
        let all = [10.0 * (y - x * x), 1.0 - x, 10.0 * (y - x * x) + 1.0 - x];
        c.iter_mut().zip(all).for_each(|(c, r)| *c = r * unit);
        Ok(0.0)
    }

    fn gradient(&mut self, _: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let (x, third) = (self.0.at[0], c.get(2).copied().unwrap_or(0.0));
        let second = c.get(1).copied().unwrap_or(0.0);
        let unit = self.0.units.c / self.0.units.x;
        gradient[0] = unit * (-20.0 * x * (c[0] + third) - (second + third));
        gradient[1] = unit * 10.0 * (c[0] + third);
        Ok(())
    }
}

#[test]
fn levenberg_marquardt_goes_the_same_way() {
    for count in 1..=3 {
        let run = |kind, units, options: &Options| {
            let mut problem = Residuals(Scaled::new(kind, units), count);
            let start = problem.0.start();
            Some(levenberg_marquardt(&mut problem, &start, options, &mut silent).expect("an outcome").outcome)
        };
        assert_same(run, |units| units.c * units.c);
    }
}

/// Problems of a homotopy are solved to a part of how far the constraints of the first were off, whatever their unit is.
#[test]
fn homotopies_hold_constraints_on_the_way() {
    for c in [1.0, 2f64.powi(-20), 2f64.powi(-40)] {
        let units = Units { c, ..PLAIN };
        let mut problem = Scaled::new(Kind::Constrained, units);
        let start = problem.start();
        let options = Options { violation: 1e-9 * c, ..Options::default() };
        let (s, mut all) = (Cell::new(0.0), Vec::new());
        let mut set = |problem: &mut Scaled, now: f64| {
            problem.s = now;
            s.set(now);
            Ok(())
        };
        let mut watch = |it: &Iterate, _: &[f64]| {
            all.push((s.get(), it.violation / c));
            ControlFlow::Continue(())
        };
        homotopy(&mut problem, &start, &options, &mut set, &mut watch).expect("an outcome");
        let problems: Vec<_> = all.chunk_by(|one, other| one.0 == other.0).collect();
        let [first, .., _] = problems[..] else { panic!("{all:?}") };
        for problem in &problems {
            let (_, end) = problem[problem.len() - 1];
            assert!(end <= 1e-5 * first[0].1, "{c:e}: {all:?}");
        }
    }
}
