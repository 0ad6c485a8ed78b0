//! Reasons to stop that are true: minima from steep starts, constraints without multipliers, and constraints that contradict each other.

use super::{Function, Given};
use hamiltonian_adjoint::optimize::{
    Free, Guess, Interval, Iterate, MotionProblem, Options, Outcome, Problem, Reason, Variables, augmented_lagrangian,
    interior_point, silent, solve,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Cost, CostPoint, Error, Grid, Inputs, Scalar, Scene, Settings, Sum, Warning};
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

/// cosh(x − 1) + (y + 2)², least at (1, −2).
fn steep(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    g.copy_from_slice(&[(x[0] - 1.0).sinh(), 2.0 * (x[1] + 2.0)]);
    (x[0] - 1.0).cosh() + (x[1] + 2.0).powi(2)
}

/// 100 (y − x²)² + (1 − x)², least at (1, 1).
fn valley(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    let (a, b) = (x[1] - x[0] * x[0], 1.0 - x[0]);
    g.copy_from_slice(&[-400.0 * a * x[0] - 2.0 * b, 200.0 * a]);
    100.0 * a * a + b * b
}

/// A gradient of 1e9 at the start, or of 1e35, does not make another one of 1e2, or of 1e28, small.
#[test]
fn a_minimum_does_not_depend_on_the_slope_at_the_start() {
    for (function, least) in [(steep as Function, [1.0, -2.0]), (valley, [1.0, 1.0])] {
        for bound in [Interval::FREE, Interval::at_least(-5.0)] {
            for from in [1.5, 10.0, 30.0, 100.0] {
                let mut problem = Given::new(function, vec![bound; 2], vec![]);
                let outcome = interior_point(&mut problem, &[from; 2], &Options::default(), &mut silent).expect("fits");
                assert_eq!(outcome.reason, Reason::Stationary, "{from}: {outcome}");
                let far = outcome.x.iter().zip(least).any(|(x, of)| (x - of).abs() > 1e-5);
                assert!(!far, "{from}: {:?} is not {least:?}", outcome.x);
            }
        }
    }
}

/// x² + 4 y² with x + y = 2, least at (1.6, 0.4), or with its square.
fn line(x: &[f64], c: &mut [f64], g: &mut [f64], is_square: bool) -> f64 {
    let h = x[0] + x[1] - 2.0;
    let slope = if is_square { 2.0 * h } else { 1.0 };
    c[0] = if is_square { h * h } else { h };
    g.copy_from_slice(&[2.0 * x[0], 8.0 * x[1], slope, slope]);
    x[0] * x[0] + 4.0 * x[1] * x[1]
}

/// y beside circles about (±1, 0) that touch at the origin, the only feasible point.
fn circles(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    for (j, centre) in [1.0, -1.0].into_iter().enumerate() {
        let d = [x[0] - centre, x[1]];
        c[j] = 0.5 * (d[0] * d[0] + d[1] * d[1] - 1.0);
        g[2 + 2 * j..][..2].copy_from_slice(&d);
    }
    g[..2].copy_from_slice(&[0.0, 1.0]);
    x[1]
}

#[test]
fn constraints_without_multipliers_are_named() {
    let once: Function = |x, c, g| line(x, c, g, false);
    let twice: Function = |x, c, g| line(x, c, g, true);
    let cases = [
        (once, 1, Reason::Stationary, [1.6, 0.4]),
        (twice, 1, Reason::Degenerate, [1.6, 0.4]),
        (circles, 2, Reason::Degenerate, [0.0, 0.0]),
    ];
    for (function, constraints, reason, least) in cases {
        for start in [[3.0, -1.0], [0.1, 0.2], [-4.0, 7.0]] {
            let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![Interval::ZERO; constraints]);
            let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert_eq!(outcome.reason, reason, "{outcome}");
            // A violation of 1e-9 is a distance of 3e-5.
            assert!(outcome.x.iter().zip(least).all(|(x, of)| (x - of).abs() < 1e-4), "{:?}", outcome.x);
            let says = outcome.to_string().contains("no multiplier") && outcome.to_string().contains("constraint 0");
            assert_eq!(says, reason == Reason::Degenerate, "{outcome}");
            let by_gradients = augmented_lagrangian(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert_eq!(by_gradients.reason == Reason::Stationary, reason == Reason::Stationary, "{by_gradients}");
        }
    }
}

/// A cart that swings a link up in 2 s with the least effort, with φ = π/2 or ½ (φ − π/2)² = 0 at the end.
fn swing(is_square: bool) -> MotionProblem {
    let mut cart = CartPendulum::with_links(1).mechanism();
    cart.scene.effort("effort", cart.force, 0.01);
    let angle = cart.links[0].coordinates[2];
    let square = cart.scene.output("square");
    cart.scene.term(square, "square", AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
    let end = cart.scene.end_state(angle);
    let system = cart.scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.04));
    let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force).scaled(10.0)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let (output, value) = if is_square { (square, 0.0) } else { (end.position, FRAC_PI_2) };
    problem.constrain(output, Interval::equal(value));
    problem
}

#[test]
fn an_angle_whose_square_must_vanish_has_no_multiplier() {
    let least = solve(&mut swing(false), Guess::Inputs, &Options::default(), &mut silent).expect("fits").outcome;
    assert_eq!(least.reason, Reason::Stationary, "{least}");
    for (stationarity, start) in [(1e-3, 0.0), (1e-5, 1.0), (1e-5, 5.0)] {
        let mut problem = swing(true);
        let (x, options) = (vec![start; problem.variables()], Options { stationarity, ..Options::default() });
        let found = interior_point(&mut problem, &x, &options, &mut silent).expect("fits");
        assert_eq!(found.reason, Reason::Degenerate, "{found}");
        assert!((found.value / least.value - 1.0).abs() < 1e-4 && found.to_string().contains("`square`"), "{found}");
    }
}

/// An arm of 1 m with a motor of at most 20 N m, which must reach a height of 1.5 m above its shoulder in 1 s.
fn reach() -> MotionProblem {
    raise(1.5, 20.0)
}

/// An arm of 1 m that must reach a height above its shoulder in 1 s with a largest torque.
fn raise(height: f64, torque: f64) -> MotionProblem {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let arm = scene.body("arm", 1.0, 0.1, [1.0, 0.0, 0.0]);
    scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), arm.at(-1.0, 0.0));
    let motor = scene.control("torque");
    scene.torque_actuator("motor", Body::GROUND, arm, motor);
    scene.effort("effort", motor, 0.01);
    let [x, y] = [0, 1].map(|i| scene.end_state(arm.coordinates[i]));
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.02));
    let variables = Variables::new(&system, &inputs, vec![Free::control(motor).within(-torque, torque)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(x.position, Interval::equal(0.0));
    problem.constrain(y.position, Interval::equal(height));
    problem
}

/// A cart that must end at 1 m and stay below 0.5 m at all nodes.
fn beyond_its_rail() -> MotionProblem {
    let mut cart = CartPendulum::with_links(1).mechanism();
    let x = cart.cart.coordinates[0];
    let end = cart.scene.end_state(x);
    cart.scene.effort("effort", cart.force, 0.01);
    let places: Vec<_> = (0..=40).map(|node| cart.scene.reading(&format!("place {node}"), x, node, 0.0, 1.0)).collect();
    let system = cart.scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
    let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force).scaled(10.0)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(end.position, Interval::equal(1.0));
    places.iter().for_each(|place| problem.constrain(*place, Interval::at_most(0.5)));
    problem
}

/// The least sum of squares leaves 0.5 m of the height, or 0.25 m of the place and of its limit each.
#[test]
fn motions_that_cannot_be_are_infeasible() {
    for (mut problem, left, names) in [(reach(), 0.5, ["arm.y", "1.5"]), (beyond_its_rail(), 0.25, ["cart.x", "place 40"])] {
        let start = problem.start();
        let single = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        let mut problem = if left == 0.5 { reach() } else { beyond_its_rail() };
        let solved = solve(&mut problem, Guess::Straight, &Options::default(), &mut silent).expect("fits");
        let iterations: usize = solved.attempts.iter().map(|of| of.iterations).sum();
        assert!(iterations < 1000, "{solved}");
        for outcome in [&single, &solved.outcome] {
            assert_eq!(outcome.reason, Reason::Infeasible, "{outcome}");
            assert!(outcome.iterations < 200 && (outcome.violation - left).abs() < 1e-2, "{outcome}");
            assert!(outcome.violated.is_sorted_by(|one, other| one.by() >= other.by()), "{outcome}");
            for text in [outcome.to_string(), solved.to_string()] {
                assert!(names.iter().all(|name| text.contains(name)), "{text}");
            }
        }
    }
}

/// The way back, m.
struct Back;

impl Cost<1> for Back {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        -at.q[0]
    }
}

/// The greatest distance of a body on a rail after 1 s, less an effort with a weight; it comes to rest, if asked.
fn farthest(weight: f64, is_at_rest: bool) -> MotionProblem {
    let mut scene = Scene::new();
    let body = scene.body("body", 1.0, 1.0, [0.0; 3]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.0), 0.0);
    let force = scene.control("force");
    scene.actuator("drive", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.0), force);
    scene.cost("way back", Back, Sum::Terminal, [body.coordinates[0]], [], [], []);
    scene.effort("effort", force, weight);
    let end = scene.end_state(body.coordinates[0]);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.05));
    let variables = Variables::new(&system, &inputs, vec![Free::control(force)]).expect("free");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    if is_at_rest {
        problem.constrain(end.rate, Interval::ZERO);
    }
    problem
}

#[test]
fn a_value_without_bound_ends_solve() {
    for (is_at_rest, guess) in
        [(false, Guess::Straight), (true, Guess::Straight), (false, Guess::Inputs), (true, Guess::Inputs)]
    {
        let found = solve(&mut farthest(0.0, is_at_rest), guess.starts(5), &Options::default(), &mut silent).expect("fits");
        println!("{found}");
        assert!(found.outcome.reason == Reason::Unbounded && found.attempts.len() == 1, "{found}");
        // Far away, but not without bound.
        for weight in [1.0, 1e-6] {
            let found =
                solve(&mut farthest(weight, is_at_rest), Guess::Straight, &Options::default(), &mut silent).expect("fits");
            assert!(found.outcome.reason == Reason::Stationary && found.outcome.value < 0.0, "{found}");
        }
    }
}

#[test]
fn torques_that_are_too_weak_are_named() {
    let at_bounds = |outcome: &Outcome| {
        outcome.warnings.iter().find(|warning| matches!(warning, Warning::AtBounds { .. })).map(ToString::to_string)
    };
    // The arm weighs 9.81 N.
    let solved = solve(&mut raise(1.0, 5.0), Guess::Straight, &Options::default(), &mut silent).expect("fits");
    println!("{solved}");
    assert!(!solved.outcome.reason.is_converged(), "{solved}");
    let warning = at_bounds(&solved.outcome).expect("a warning");
    assert!(warning.contains("torque is at its bounds in ") && warning.contains(" of 51 variables"), "{warning}");
    assert!(solved.to_string().contains(&warning), "{solved}");
    for height in [1.5, 1.0] {
        let solved = solve(&mut raise(height, 40.0), Guess::Straight, &Options::default(), &mut silent).expect("fits");
        assert!(at_bounds(&solved.outcome).is_none(), "{solved}");
    }
}

/// ½ ‖x − d‖² with constraints aᵀx + ½ k (bᵀx)².
struct Curved {
    d: Vec<f64>,
    constraints: Vec<(Vec<f64>, Vec<f64>, f64)>,
    intervals: Vec<Interval>,
    bounds: Vec<Interval>,
    x: Vec<f64>,
    weights: (f64, Vec<f64>),
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Curved {
    /// A problem that a random point satisfies, and a start. If it is convex, the sum of squares of violations has no other local minima.
    fn feasible(random: &mut impl FnMut() -> f64, is_convex: bool) -> (Self, Vec<f64>) {
        let n = 2 + (random().abs() * 4.0) as usize;
        let mut some = |n: usize, size: f64| Vec::from_iter((0..n).map(|_| size * random()));
        let (inside, d, start) = (some(n, 1.0), some(n, 3.0), some(n, 10.0));
        let bounds = inside.iter().zip(some(n, 1.0)).map(|(x, by)| match by {
            by if by < -0.3 => Interval::at_least(x + by),
            by if by > 0.3 => Interval::new(x - by, x + 2.0 * by),
            _ => Interval::FREE,
        });
        let bounds = bounds.collect();
        let mut problem =
            Curved { d, constraints: Vec::new(), intervals: Vec::new(), bounds, x: inside, weights: (0.0, Vec::new()) };
        // Fewer equalities than variables.
        for j in 0..2 * n - 2 {
            let (a, b, numbers) = (some(n, 1.0), some(n, 1.0), some(2, 1.0));
            let is_equality = j < n - 1 && numbers[0] < 0.0;
            let k = if is_convex { if is_equality { 0.0 } else { numbers[1].abs() } } else { 2.0 * numbers[1] };
            problem.constraints.push((a, b, k));
            let c = problem.constraint(j);
            problem.intervals.push(if is_equality {
                Interval::equal(c)
            } else {
                Interval::at_most(c + 0.05 + numbers[0].max(0.0))
            });
        }
        (problem, start)
    }

    fn constraint(&self, j: usize) -> f64 {
        let (a, b, k) = &self.constraints[j];
        dot(a, &self.x) + 0.5 * k * dot(b, &self.x).powi(2)
    }

    /// The sum of squares of the violations at a point moved into the bounds.
    fn violations(&mut self, x: &[f64]) -> f64 {
        self.x = x.iter().zip(&self.bounds).map(|(x, of)| of.nearest(*x)).collect();
        (0..self.intervals.len()).map(|j| self.intervals[j].violation(self.constraint(j)).powi(2)).sum()
    }
}

impl Problem for Curved {
    fn variables(&self) -> usize {
        self.d.len()
    }
    fn bounds(&self) -> Vec<Interval> {
        self.bounds.clone()
    }
    fn constraints(&self) -> Vec<Interval> {
        self.intervals.clone()
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.x = x.to_vec();
        c.iter_mut().enumerate().for_each(|(j, c)| *c = self.constraint(j));
        Ok(0.5 * x.iter().zip(&self.d).map(|(x, d)| (x - d).powi(2)).sum::<f64>())
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.weights = (f, c.to_vec());
        for (i, g) in gradient.iter_mut().enumerate() {
            let of = |((a, b, k), w): (&(Vec<f64>, Vec<f64>, f64), &f64)| w * (a[i] + k * dot(b, &self.x) * b[i]);
            *g = f * (self.x[i] - self.d[i]) + self.constraints.iter().zip(c).map(of).sum::<f64>();
        }
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        for (i, to) in product.iter_mut().enumerate() {
            let of = |((_, b, k), w): (&(Vec<f64>, Vec<f64>, f64), &f64)| w * k * dot(b, direction) * b[i];
            *to = self.weights.0 * direction[i] + self.constraints.iter().zip(&self.weights.1).map(of).sum::<f64>();
        }
        Ok(())
    }
}

/// Pseudorandom numbers between −1 and 1.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[test]
fn feasible_problems_are_not_called_infeasible() {
    let (mut random, mut solved, mut infeasible) = (numbers(), 0, 0);
    for k in 0..400 {
        let is_convex = k % 2 == 0;
        let (mut problem, start) = Curved::feasible(&mut random, is_convex);
        let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        solved += usize::from(outcome.reason == Reason::Stationary);
        assert!(!is_convex || outcome.reason != Reason::Infeasible, "{k}: {outcome}");
        if outcome.reason == Reason::Infeasible {
            infeasible += 1;
            let here = problem.violations(&outcome.x);
            for size in [1e-3, 1e-2, 1e-1] {
                for _ in 0..100 {
                    let near: Vec<f64> = outcome.x.iter().map(|x| x + size * random()).collect();
                    let there = problem.violations(&near);
                    assert!(there > (1.0 - 1e-3) * here, "{k}: {there} < {here} at a distance of {size}: {outcome}");
                }
            }
        }
    }
    println!("{solved} of 400 solved, {infeasible} at a local minimum of the violations");
    assert!(solved > 350, "{solved}");
}

#[test]
fn the_iteration_limit_says_whether_more_iterations_help() {
    let limited = |iterations| Options { iterations, ..Options::default() };
    let says = |outcome: &Outcome, what: &str| {
        assert!(outcome.reason == Reason::Iterations && outcome.to_string().contains(what), "{outcome}");
        outcome.is_improving()
    };
    // The gradient falls by a factor e in each iteration.
    let mut problem = Given::new(steep, vec![Interval::FREE; 2], vec![]);
    let outcome = interior_point(&mut problem, &[100.0; 2], &limited(50), &mut silent).expect("fits");
    assert!(says(&outcome, "more iterations are likely to help"));
    // A violation that stays at ½ while the stationarity falls.
    let stuck = outcome.history.iter().map(|it| Iterate { violation: 0.5, ..*it });
    let stuck = Outcome { history: stuck.collect(), ..outcome };
    assert!(!says(&stuck, "the violation stayed at 0.5") && !says(&stuck, "more iterations are unlikely to help"));
    // A run that converged has nothing to say.
    let outcome =
        interior_point(&mut Given::new(steep, vec![Interval::FREE; 2], vec![]), &[2.0; 2], &limited(50), &mut silent);
    assert!(!outcome.expect("fits").to_string().contains("iterations,"));
}
