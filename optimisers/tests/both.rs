//! The adapters compared with the library's own methods, and the errors that they return.

use argmin::core::Executor;
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use argmin::solver::trustregion::{Steihaug, TrustRegion};
use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, Options, Outcome, Problem, Reason, Variables, interior_point, silent,
};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Error, Grid, Inputs, Output, Settings, System};
use optimisers::{Argmin, Failure, HAS_IPOPT, Hessian, ipopt};
use std::f64::consts::FRAC_PI_2;

/// A cart with one link that is upright at the end with the least effort, or as upright as possible.
fn system(is_constrained: bool) -> (System, Vec<Free>, Vec<Output>) {
    let mut cart = CartPendulum::with_links(1).mechanism();
    let mut upright = Vec::new();
    if is_constrained {
        upright.push(cart.scene.end_state(cart.links[0].coordinates[2]).position);
    }
    cart.scene.effort("effort", cart.force, 1e-4);
    let scene = if is_constrained { cart.scene } else { CartPendulum::with_links(1).scene() };
    let system = scene.compile().expect("a system");
    let free = vec![Free::control(system.control(0))];
    (system, free, upright)
}

fn problem((system, free, upright): &(System, Vec<Free>, Vec<Output>), bound: f64) -> MotionProblem {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(40, 0.025));
    inputs.controls.fill(5.0);
    let free = free.iter().map(|of| of.clone().within(-bound, bound)).collect();
    let variables = Variables::new(system, &inputs, free).expect("free");
    let mut problem = MotionProblem::new(system, Settings::default(), inputs, variables).expect("a problem");
    upright.iter().for_each(|output| problem.constrain(*output, Interval::equal(FRAC_PI_2)));
    problem
}

#[test]
fn argmin_finds_the_swing_up_by_gradients_and_by_hessians() {
    let parts = system(false);
    let mut problem = problem(&parts, f64::INFINITY);
    let start = problem.start();
    let argmin = Argmin::new(&mut problem).expect("no constraints");
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), 30);
    let run = Executor::new(argmin, solver).configure(|state| state.param(start.clone()).max_iters(200).target_cost(1e-10));
    let run = run.run().expect("a run");
    assert!(run.state().get_best_cost() < 1e-8, "{}", run.state().get_best_cost());
    let argmin = Argmin::new(&mut problem).expect("no constraints");
    let solver = TrustRegion::new(Steihaug::new().with_max_iters(60)).with_radius(10.0).expect("a radius");
    let run = Executor::new(argmin, solver.with_max_radius(500.0).expect("a radius"));
    let run = run.configure(|state| state.param(start).max_iters(100).target_cost(1e-10)).run().expect("a run");
    assert!(run.state().get_best_cost() < 1e-8, "{}", run.state().get_best_cost());
}

#[test]
fn ipopt_ends_where_the_interior_point_method_does() {
    let parts = system(true);
    for bound in [f64::INFINITY, 40.0] {
        let mut problem = problem(&parts, bound);
        let start = problem.start();
        let options = Options { stationarity: 1e-7, iterations: 500, ..Options::default() };
        let own = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
        for hessian in [Hessian::Exact, Hessian::LimitedMemory] {
            let found = ipopt(&mut problem, &start, &options, hessian);
            if !HAS_IPOPT {
                assert!(found.expect_err("no IPOPT").to_string().contains("coinor-libipopt-dev"));
                continue;
            }
            let found = found.expect("a solution");
            assert!(found.reason.is_converged() && found.violation < 1e-8, "{:?}", found.reason);
            assert!((found.value - own.value).abs() < 1e-4 * own.value, "{hessian:?}: {} {}", found.value, own.value);
            assert!((found.multipliers[0] - own.multipliers[0]).abs() < 1e-2 * own.multipliers[0].abs());
            assert_eq!(found.products > 0, hessian == Hessian::Exact);
            assert_eq!(problem.solver.cost().expect("a motion"), found.value);
        }
    }
}

/// √x, which fails or panics for x < 0.
struct Edge {
    at: f64,
    panics: bool,
}
impl Problem for Edge {
    fn variables(&self) -> usize {
        1
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        assert!(!self.panics || x[0] == 4.0, "a panic of the user's own");
        self.at = x[0];
        if x[0] < 0.0 { Err(Error::EmptyScene) } else { Ok(x[0] - x[0].sqrt()) }
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = f * (1.0 - 0.5 / self.at.sqrt());
        Ok(())
    }
}

#[test]
fn what_goes_wrong_does_not_go_through_ipopt() {
    let parts = system(true);
    assert!(matches!(Argmin::new(&mut problem(&parts, f64::INFINITY)).err(), Some(Failure::Constrained)));
    if !HAS_IPOPT {
        return;
    }
    let options = Options { iterations: 200, ..Options::default() };
    let run = |at: f64, panics| ipopt(&mut Edge { at, panics }, &[at], &options, Hessian::LimitedMemory);
    assert!((run(4.0, false).expect("a minimum").x[0] - 0.25).abs() < 1e-5);
    assert!(matches!(run(-1.0, false), Err(Failure::Problem(Error::EmptyScene))));
    // A panic counts as a failed evaluation, and IPOPT stops.
    assert!(run(4.0, true).is_err() || !run(4.0, true).expect("an end").reason.is_converged());
    let error = ipopt(&mut Edge { at: 0.0, panics: false }, &[], &options, Hessian::Exact).expect_err("no variables");
    assert!(error.to_string().contains("expected 1"), "{error}");
}

#[test]
fn threads_wait_for_each_other() {
    if !HAS_IPOPT {
        return;
    }
    let options = Options { iterations: 200, ..Options::default() };
    std::thread::scope(|scope| {
        for k in 0..8 {
            let options = &options;
            scope.spawn(move || {
                let at = 1.0 + f64::from(k);
                let edge =
                    ipopt(&mut Edge { at, panics: false }, &[at], options, Hessian::LimitedMemory).expect("a minimum");
                assert!((edge.x[0] - 0.25).abs() < 1e-5, "{:?}", edge.x);
            });
        }
    });
}

/// A problem that calls IPOPT.
struct Inner;
impl Problem for Inner {
    fn variables(&self) -> usize {
        1
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        let inner = ipopt(&mut Edge { at: 1.0, panics: false }, &[1.0], &Options::default(), Hessian::LimitedMemory);
        match inner {
            // Before the outer call begins, this is an ordinary call.
            Ok(found) => Ok(found.value + x[0] * x[0]),
            Err(error) => {
                assert!(error.to_string().contains("IPOPT itself"));
                Err(Error::EmptyScene)
            }
        }
    }
    fn gradient(&mut self, _: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient.fill(0.0);
        Ok(())
    }
}

#[test]
fn a_problem_that_calls_it_again_does_not_hang() {
    if HAS_IPOPT {
        let options = Options { iterations: 5, ..Options::default() };
        let ended = ipopt(&mut Inner, &[1.0], &options, Hessian::LimitedMemory);
        assert!(ended.is_err() || ended.is_ok_and(|outcome| outcome.failures > 0 || outcome.history.len() <= 1));
    }
}

/// (x + 1)² within x ≥ least, with x ≥ 1 as a constraint, and second derivatives if they are enabled.
struct Line {
    at: f64,
    least: f64,
    knows_products: bool,
    weight: f64,
}
impl Problem for Line {
    fn variables(&self) -> usize {
        1
    }
    fn bounds(&self) -> Vec<Interval> {
        vec![Interval::at_least(self.least)]
    }
    fn constraints(&self) -> Vec<Interval> {
        vec![Interval::at_least(1.0)]
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.at = x[0];
        c[0] = x[0];
        if x[0] < self.least - 1e-6 { Err(Error::EmptyScene) } else { Ok((x[0] + 1.0).powi(2)) }
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.weight = f;
        gradient[0] = f * 2.0 * (self.at + 1.0) + c[0];
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        product[0] = 2.0 * self.weight * direction[0];
        if self.knows_products { Ok(()) } else { Err(Error::NoSecondDerivatives { of: "this line".into() }) }
    }
}

#[test]
fn ipopt_answers_for_the_point_that_it_gives() {
    if !HAS_IPOPT {
        return;
    }
    for (least, nearest) in [(-5.0, 1.0), (1.0, 1.0), (2.0, 2.0)] {
        let mut line = Line { at: 0.0, least, knows_products: true, weight: 0.0 };
        // A start outside the bounds, which cannot be evaluated, is moved into them.
        let found = ipopt(&mut line, &[-9.0], &Options::default(), Hessian::Exact).expect("a minimum");
        assert!(found.reason.is_converged() && (found.x[0] - nearest).abs() < 1e-6, "{found:?}");
        assert_eq!((found.value, found.constraints[0]), ((found.x[0] + 1.0).powi(2), found.x[0]));
        assert!(found.x[0] >= least && found.violation <= Options::default().violation, "{}", found.violation);
    }
}

#[test]
fn ipopt_says_what_the_problem_says() {
    if !HAS_IPOPT {
        return;
    }
    let mut line = Line { at: 0.0, least: 0.0, knows_products: false, weight: 0.0 };
    let error = ipopt(&mut line, &[3.0], &Options::default(), Hessian::Exact).expect_err("no second derivatives");
    assert!(error.to_string().contains("this line"), "{error}");
    let error = ipopt(&mut line, &[f64::NAN], &Options::default(), Hessian::Exact).expect_err("no start");
    assert!(error.to_string().contains("start"), "{error}");
}

/// x⁴, and 1/x where it is below 0.
struct Flat(f64);
impl Problem for Flat {
    fn variables(&self) -> usize {
        1
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        self.0 = x[0];
        Ok(if x[0] < 0.0 { f64::NAN } else { x[0].powi(4) })
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = f * 4.0 * self.0.powi(3);
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        product[0] = 12.0 * self.0 * self.0 * direction[0];
        Ok(())
    }
}

#[test]
fn what_is_asked_for_is_what_is_given() {
    use argmin::core::CostFunction;
    let mut flat = Flat(0.0);
    assert_eq!(Argmin::new(&mut flat).expect("no constraints").cost(&vec![-1.0]).expect("no number"), f64::INFINITY);
    if HAS_IPOPT {
        // The tolerance is relative to the gradient at the start, which is 4; IPOPT's acceptable tolerance is not used.
        let options = Options { stationarity: 1e-30, ..Options::default() };
        let found = ipopt(&mut flat, &[1.0], &options, Hessian::Exact).expect("a minimum");
        assert!(found.reason.is_converged() && found.x[0].powi(3) <= 1e-30, "{found:?}");
    }
}

/// −x.
struct Fall;
impl Problem for Fall {
    fn variables(&self) -> usize {
        1
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        Ok(-x[0])
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = -f;
        Ok(())
    }
    fn product(&mut self, _: &[f64], product: &mut [f64]) -> Result<(), Error> {
        product.fill(0.0);
        Ok(())
    }
}

#[test]
fn what_falls_without_end_is_unbounded() {
    let found = interior_point(&mut Fall, &[1.0], &Options::default(), &mut silent).expect("an answer");
    assert_eq!(found.reason, Reason::Unbounded, "{found:?}");
    if HAS_IPOPT {
        let found = ipopt(&mut Fall, &[1.0], &Options::default(), Hessian::Exact).expect("an answer");
        assert_eq!(found.reason, Reason::Unbounded, "{found:?}");
    }
}

/// Rosenbrock's valley in some unit with x₀ as a constraint; it is stopped, or has no gradient, after the given number of values or gradients.
struct Valley {
    at: [f64; 2],
    weights: f64,
    unit: f64,
    bounds: Vec<Interval>,
    constraints: Vec<Interval>,
    left: [usize; 2],
}

impl Valley {
    fn new(bounds: Vec<Interval>, constraints: Vec<Interval>) -> Self {
        Valley { at: [0.0; 2], weights: 0.0, unit: 1.0, bounds, constraints, left: [usize::MAX; 2] }
    }
    fn free() -> Self {
        Valley::new(vec![Interval::FREE; 2], vec![])
    }
    fn solve(&mut self, options: &Options, hessian: Hessian) -> Result<Outcome, Failure> {
        ipopt(self, &[-1.2, 1.0], options, hessian)
    }
}

impl Problem for Valley {
    fn variables(&self) -> usize {
        2
    }
    fn bounds(&self) -> Vec<Interval> {
        self.bounds.clone()
    }
    fn constraints(&self) -> Vec<Interval> {
        self.constraints.clone()
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.left[0] = self.left[0].checked_sub(1).ok_or(Error::Interrupted { done: 1, of: 2 })?;
        self.at = [x[0], x[1]];
        c.fill(x[0]);
        Ok(self.unit * (100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2)))
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let none = Error::NotFinite { what: "the valley's slope".into(), value: f64::NAN };
        self.left[1] = self.left[1].checked_sub(1).ok_or(none)?;
        let [x, y] = self.at;
        self.weights = f * self.unit;
        gradient[0] = self.weights * (-400.0 * x * (y - x * x) - 2.0 * (1.0 - x)) + c.iter().sum::<f64>();
        gradient[1] = self.weights * 200.0 * (y - x * x);
        Ok(())
    }
    fn product(&mut self, d: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let [x, y] = self.at;
        product[0] = self.weights * ((1200.0 * x * x - 400.0 * y + 2.0) * d[0] - 400.0 * x * d[1]);
        product[1] = self.weights * (-400.0 * x * d[0] + 200.0 * d[1]);
        Ok(())
    }
}

const HESSIANS: [Hessian; 2] = [Hessian::Exact, Hessian::LimitedMemory];

/// Regression: IPOPT continued for some 50 more simulations and called satisfied constraints infeasible.
#[test]
fn whoever_stops_a_simulation_stops_ipopt_and_argmin() {
    use argmin::core::CostFunction;
    for hessian in HESSIANS {
        for left in [1, 6, 15].into_iter().filter(|_| HAS_IPOPT) {
            let mut valley = Valley::new(vec![Interval::FREE; 2], vec![Interval::at_most(0.5)]);
            valley.left[0] = left;
            let found = valley.solve(&Options::default(), hessian).expect("the best so far");
            assert_eq!(found.reason, Reason::Interrupted, "{found:?}");
            assert!(found.value <= 24.2 && found.constraints[0] == found.x[0] && found.evaluations <= left + 2, "{found:?}");
            assert!(matches!(found.first_failure, Some(Error::Interrupted { .. })), "{found:?}");
        }
    }
    let mut valley = Valley { left: [0; 2], ..Valley::free() };
    let error = Argmin::new(&mut valley).expect("no constraints").cost(&vec![0.0; 2]).expect_err("stopped");
    assert!(error.to_string().contains("stopped by the progress callback"), "{error}");
}

/// Regression: the best point was lost with the error.
#[test]
fn where_derivatives_end_ipopt_keeps_its_point() {
    for hessian in HESSIANS.into_iter().filter(|_| HAS_IPOPT) {
        let mut valley = Valley { left: [usize::MAX, 15], ..Valley::free() };
        let found = valley.solve(&Options::default(), hessian).expect("the best so far");
        assert!(found.reason == Reason::NoDerivative && found.value < 24.2 && found.failures == 1, "{found:?}");
        assert!(found.first_failure.expect("why").to_string().contains("the valley's slope"));
        let mut valley = Valley { left: [usize::MAX, 0], ..Valley::free() };
        let error = valley.solve(&Options::default(), hessian).expect_err("no gradient at the start");
        assert!(error.to_string().contains("the valley's slope"), "{error}");
    }
}

/// Regression: costs in small units were called stationary at the start.
#[test]
fn ipopt_finds_the_same_in_any_unit_of_the_cost() {
    for hessian in HESSIANS.into_iter().filter(|_| HAS_IPOPT) {
        for constraints in [vec![], vec![Interval::at_most(0.5)]] {
            let ends = [0, -40, -20, 20, 40].map(|exponent| {
                let unit = 2f64.powi(exponent);
                let mut valley = Valley { unit, ..Valley::new(vec![Interval::FREE; 2], constraints.clone()) };
                valley.solve(&Options::default(), hessian).expect("a minimum")
            });
            for end in &ends {
                assert!(end.reason.is_converged(), "{end:?}");
                assert!(end.x.iter().zip(&ends[0].x).all(|(x, of)| (x - of).abs() < 1e-5), "{end:?}");
                assert!(end.history.len() <= 2 * ends[0].history.len(), "{end:?}");
                let steepest = end.history[0].stationarity / end.history[0].value * ends[0].history[0].value;
                assert!((steepest / ends[0].history[0].stationarity - 1.0).abs() < 1e-6, "{end:?}");
            }
        }
    }
}

#[test]
fn ipopt_refuses_by_name_what_every_method_refuses() {
    let refused = |mut valley: Valley, options: &Options, words: &str| {
        let error = valley.solve(options, Hessian::Exact).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    if !HAS_IPOPT {
        return;
    }
    let of = Options::default();
    refused(Valley::free(), &Options { stationarity: f64::NAN, ..of }, "`Options::stationarity` is NaN");
    refused(Valley::free(), &Options { violation: -1.0, ..of }, "`Options::violation` is -1");
    let none = Interval::new(2.0, 1.0);
    refused(Valley::new(vec![Interval::FREE, none], vec![]), &of, "the upper bound of `x1`, whose lower bound is 2, is 1");
    refused(
        Valley::new(vec![Interval::FREE; 2], vec![none]),
        &of,
        "the upper bound of constraint 0, whose lower bound is 2, is 1",
    );
    refused(Valley::new(vec![Interval::at_least(f64::NAN), Interval::FREE], vec![]), &of, "`x0`");
    refused(Valley::new(vec![Interval::FREE; 3], vec![]), &of, "expected 2 entries, found 3");
}

/// Regression: IPOPT rejects tolerances of 0 and used its defaults.
#[test]
fn nothing_less_than_rounding_can_be_asked_of_ipopt() {
    if HAS_IPOPT {
        let options = Options { stationarity: 0.0, violation: 0.0, ..Options::default() };
        let found = Valley::free().solve(&options, Hessian::Exact).expect("a minimum");
        assert!(found.x.iter().all(|x| (x - 1.0).abs() < 1e-14), "{found:?}");
    }
}

#[test]
fn without_anything_free_ipopt_tells_of_the_start() {
    if HAS_IPOPT {
        let mut valley = Valley::new(vec![Interval::equal(0.5), Interval::equal(2.0)], vec![Interval::at_least(0.3)]);
        let found = valley.solve(&Options::default(), Hessian::Exact).expect("a point");
        assert!(
            found.reason.is_converged() && found.history.len() == 1 && found.history[0].value == found.value,
            "{found:?}"
        );
    }
}

#[test]
fn argmin_is_told_why_a_point_has_no_gradient() {
    use argmin::core::{CostFunction, Gradient};
    let mut valley = Valley::free();
    let argmin = Argmin::new(&mut valley).expect("no constraints");
    let error = argmin.cost(&vec![0.0; 1]).expect_err("too few");
    assert!(error.to_string().contains("expected 2 entries, found 1"), "{error}");
    assert!(argmin.gradient(&vec![0.0; 3]).is_err());
    // 1 − ½/√x is not finite at 0 and undefined at −1.
    let mut edge = Edge { at: 0.0, panics: false };
    let argmin = Argmin::new(&mut edge).expect("no constraints");
    for (x, words) in [(0.0, "derivative"), (-1.0, &*Error::EmptyScene.to_string())] {
        let error = argmin.gradient(&vec![x]).expect_err("no gradient");
        assert!(error.to_string().contains(words), "{error}");
    }
}
