//! Constraints of any size, that say the same, that leave nothing free, or that contradict each other.

use super::{Function, Given, hs71};
use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, Options, Outcome, Problem, Reason, Variables, augmented_lagrangian, interior_point,
    lbfgs, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Error, Grid, Inputs, Output, Settings};

fn solve(problem: &mut impl Problem, start: &[f64]) -> Outcome {
    interior_point(problem, start, &Options { iterations: 200, ..Options::default() }, &mut silent).expect("fits")
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    let far = found.iter().zip(expected).any(|(x, of)| (x - of).abs() > tolerance * of.abs().max(1.0));
    assert!(!far && found.len() == expected.len(), "{found:?} is not {expected:?}");
}

/// ½ ‖x‖², with the first constraint in hundred thousandths and the second in hundred thousands of what it is.
fn sizes(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    (c[0], c[1]) = (1e-5 * (x[0] + x[1] - 2.0), 1e5 * (x[1] - x[2] - 1.0));
    g.copy_from_slice(&[x, &[1e-5, 1e-5, 0.0, 0.0, 1e5, -1e5]].concat());
    0.5 * x.iter().map(|x| x * x).sum::<f64>()
}

/// (x − 3)² + y² in one unit, with x + y = 2 and x − 0.3 y² ≤ ½ in another.
fn in_units(x: &[f64], c: &mut [f64], g: &mut [f64], of_cost: f64, of_constraints: f64) -> f64 {
    (c[0], c[1]) = ((x[0] + x[1] - 2.0) * of_constraints, (x[0] - 0.3 * x[1] * x[1] - 0.5) * of_constraints);
    g.copy_from_slice(&[2.0 * (x[0] - 3.0), 2.0 * x[1], 1.0, 1.0, 1.0, -0.6 * x[1]]);
    g[..2].iter_mut().for_each(|g| *g *= of_cost);
    g[2..].iter_mut().for_each(|g| *g *= of_constraints);
    ((x[0] - 3.0).powi(2) + x[1] * x[1]) * of_cost
}

/// A cost a billion times as large was told to have no point where its constraints hold.
#[test]
fn penalties_do_not_depend_on_units() {
    const LARGE: f64 = (1u64 << 30) as f64;
    const KILO: f64 = 1024.0;
    let functions: [(Function, f64); 5] = [
        (|x, c, g| in_units(x, c, g, 1.0, 1.0), 1.0),
        (|x, c, g| in_units(x, c, g, LARGE, 1.0), 1.0),
        (|x, c, g| in_units(x, c, g, 1.0 / LARGE, 1.0), 1.0),
        (|x, c, g| in_units(x, c, g, 1.0, 1.0 / KILO), 1.0 / KILO),
        (|x, c, g| in_units(x, c, g, LARGE, KILO), KILO),
    ];
    for start in [[0.0, 0.0], [2.0, -1.0], [-1.2, 1.0]] {
        let found = functions.map(|(function, unit)| {
            let constraints = vec![Interval::ZERO, Interval::at_most(0.0)];
            let mut problem = Given::new(function, vec![Interval::FREE; 2], constraints);
            let options = Options { violation: 1e-9 * unit, ..Options::default() };
            let outcome = augmented_lagrangian(&mut problem, &start, &options, &mut silent).expect("fits");
            (outcome.reason, outcome.x, outcome.evaluations)
        });
        assert!(found[0].0.is_converged(), "{found:?}");
        assert!(found.iter().all(|of| *of == found[0]), "{found:?}");
    }
}

#[test]
fn steps_do_not_depend_on_the_unit_of_the_cost() {
    const LARGE: f64 = (1u64 << 30) as f64;
    let functions: [Function; 3] = [
        |x, c, g| in_units(x, c, g, 1.0, 1.0),
        |x, c, g| in_units(x, c, g, LARGE, 1.0),
        |x, c, g| in_units(x, c, g, 1.0 / LARGE, 1.0),
    ];
    for bound in [Interval::FREE, Interval::at_least(-0.5), Interval::new(-3.0, 0.5)] {
        for constraints in [[Interval::ZERO, Interval::at_most(0.0)], [Interval::FREE; 2]] {
            for start in [[0.0, 0.0], [2.0, -1.0], [-1.2, 1.0]] {
                let found = functions.map(|function| {
                    let mut problem = Given::new(function, vec![Interval::FREE, bound], constraints.to_vec());
                    let outcome = solve(&mut problem, &start);
                    (outcome.reason, outcome.x, outcome.evaluations, outcome.products)
                });
                assert!(found.iter().all(|of| *of == found[0]), "{found:?}");
            }
        }
    }
}

/// Slacks were far from their bounds at a distance of 1, in whatever unit.
#[test]
fn steps_do_not_depend_on_the_unit_of_constraints() {
    const MEGA: f64 = (1u64 << 20) as f64;
    let functions: [(Function, f64); 3] = [
        (|x, c, g| in_units(x, c, g, 1.0, 1.0), 1.0),
        (|x, c, g| in_units(x, c, g, 1.0, MEGA), MEGA),
        (|x, c, g| in_units(x, c, g, 1.0, 1.0 / MEGA), 1.0 / MEGA),
    ];
    for constraints in [[Interval::ZERO, Interval::at_most(0.0)], [Interval::at_most(0.0); 2], [Interval::new(-1.0, 0.5); 2]]
    {
        for start in [[0.0, 0.0], [2.0, -1.0], [-1.2, 1.0]] {
            let found = functions.map(|(function, unit)| {
                let constraints = constraints.map(|of| Interval::new(of.least * unit, of.most * unit));
                let mut problem = Given::new(function, vec![Interval::FREE; 2], constraints.to_vec());
                let options = Options { violation: 1e-9 * unit, ..Options::default() };
                interior_point(&mut problem, &start, &options, &mut silent).expect("fits")
            });
            assert!(found[0].reason.is_converged(), "{found:?}");
            for other in &found[1..] {
                // Logarithms of distances are rounded otherwise.
                assert_near(&other.x, &found[0].x, 1e-10);
                let way = |of: &Outcome| (of.reason, of.evaluations, of.history.len());
                assert_eq!(way(other), way(&found[0]), "{found:?}");
            }
        }
    }
}

/// The same with variables in another unit.
fn with_variables(x: &[f64], c: &mut [f64], g: &mut [f64], unit: f64) -> f64 {
    let value = in_units(&[x[0] / unit, x[1] / unit], c, g, 1.0, 1.0);
    g.iter_mut().for_each(|g| *g /= unit);
    value
}

/// Distances from bounds were small beside 1, and so a point far from the minimum was called stationary where all variables were.
#[test]
fn what_is_stationary_does_not_depend_on_the_unit_of_variables() {
    const KILO: f64 = 1024.0;
    const MEGA: f64 = KILO * KILO;
    let functions: [(Function, f64); 5] = [
        (|x, c, g| with_variables(x, c, g, 1.0), 1.0),
        (|x, c, g| with_variables(x, c, g, 1.0 / KILO), 1.0 / KILO),
        (|x, c, g| with_variables(x, c, g, 1.0 / MEGA), 1.0 / MEGA),
        (|x, c, g| with_variables(x, c, g, KILO), KILO),
        (|x, c, g| with_variables(x, c, g, MEGA), MEGA),
    ];
    for (bounds, constraints, expected) in [
        ([Interval::at_least(-4.0), Interval::at_least(0.5)], [Interval::FREE; 2], [3.0, 0.5]),
        ([Interval::at_most(2.0), Interval::at_least(0.5)], [Interval::FREE; 2], [2.0, 0.5]),
        ([Interval::FREE, Interval::new(0.5, 3.0)], [Interval::at_most(0.0), Interval::FREE], [1.5, 0.5]),
        ([Interval::at_least(0.0), Interval::at_least(0.0)], [Interval::ZERO, Interval::FREE], [2.0, 0.0]),
    ] {
        for start in [[1.0, 1.0], [2.0, -1.0], [-1.2, 1.0]] {
            let found = functions.map(|(function, unit)| {
                let bounds = bounds.map(|of| Interval::new(of.least * unit, of.most * unit));
                let mut problem = Given::new(function, bounds.to_vec(), constraints.to_vec());
                // Differences along a direction are as long for any unit, not as exact.
                let outcome = solve(&mut problem, &start.map(|x| x * unit));
                (outcome.reason, outcome.evaluations, [outcome.x[0] / unit, outcome.x[1] / unit])
            });
            for (reason, evaluations, x) in &found {
                assert_eq!((reason, evaluations), (&Reason::Stationary, &found[0].1), "{found:?}");
                assert_near(x, &expected, 1e-5);
            }
        }
    }
}

#[test]
fn constraints_of_any_size_count_alike() {
    for least in [f64::NEG_INFINITY, 0.0] {
        // x + y ≤ 2 does not hold anything; x + y = 2 does, with y − z ≥ 1.
        let sum = if least == 0.0 { Interval::ZERO } else { Interval::at_most(0.0) };
        let mut problem = Given::new(sizes, vec![Interval::FREE; 3], vec![sum, Interval::at_least(0.0)]);
        let outcome = solve(&mut problem, &[3.0, -1.0, 4.0]);
        assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
        let expected = if least == 0.0 { [1.0, 1.0, 0.0] } else { [0.0, 0.5, -0.5] };
        assert_near(&outcome.x, &expected, 1e-4);
    }
}

#[test]
fn constraints_that_say_the_same_leave_as_much_free_as_one() {
    // The point of x + y + z = 3 that is nearest to (4, 0, 2), asked for four times.
    let again: Function = |x, c, g| {
        let sum = x.iter().sum::<f64>() - 3.0;
        c.iter_mut().enumerate().for_each(|(j, c)| *c = (1.0 + j as f64) * sum);
        let apart = [x[0] - 4.0, x[1], x[2] - 2.0];
        g[..3].copy_from_slice(&apart);
        (0..4).for_each(|j| g[3 * (j + 1)..][..3].fill(1.0 + j as f64));
        0.5 * apart.iter().map(|x| x * x).sum::<f64>()
    };
    let outcome = solve(&mut Given::new(again, vec![Interval::FREE; 3], vec![Interval::ZERO; 4]), &[0.0; 3]);
    assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
    assert_near(&outcome.x, &[3.0, -1.0, 1.0], 1e-7);
    let pull: f64 = outcome.multipliers.iter().enumerate().map(|(j, w)| (1.0 + j as f64) * w).sum();
    assert!((pull - 1.0).abs() < 1e-7, "{:?}", outcome.multipliers);
}

#[test]
fn where_constraints_leave_nothing_free_their_point_is_the_minimum() {
    let point: Function = |x, c, g| {
        (c[0], c[1]) = (0.2 * x[0] - 0.2 * x[1] - 0.1, 0.05 * x[0] + 0.3 * x[1]);
        g.copy_from_slice(&[x[0] + 0.9, x[1] - 0.5, 0.2, -0.2, 0.05, 0.3]);
        0.5 * (x[0] + 0.9).powi(2) + 0.5 * (x[1] - 0.5).powi(2)
    };
    let bounds = vec![Interval::FREE, Interval::new(-1.2, 1.3)];
    for start in [[3.0 / 7.0, -0.5 / 7.0], [3.0, 1.0]] {
        let outcome = solve(&mut Given::new(point, bounds.clone(), vec![Interval::ZERO; 2]), &start);
        assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
        assert_near(&outcome.x, &[3.0 / 7.0, -0.5 / 7.0], 1e-8);
        // 0 = ∇f + Jᵀw, not that with a barrier.
        let [v, w] = [outcome.multipliers[0], outcome.multipliers[1]];
        let [x, y] = [outcome.x[0], outcome.x[1]];
        assert_near(&[0.2 * v + 0.05 * w, -0.2 * v + 0.3 * w], &[-0.9 - x, 0.5 - y], 1e-6);
    }
}

#[test]
fn an_equality_beside_the_same_inequality_leaves_slacks_no_room_and_does_no_harm() {
    // The point of x + y + z = 1 that is nearest to (2, −1, 3), where x − y ≤ 1 holds.
    let plane: Function = |x, c, g| {
        let (sum, apart) = (x.iter().sum::<f64>() - 1.0, [x[0] - 2.0, x[1] + 1.0, x[2] - 3.0]);
        c.copy_from_slice(&[sum, sum, -sum, x[0] - x[1]]);
        let ones = [1.0; 3];
        g.copy_from_slice(&[&apart[..], &ones, &ones, &ones.map(|x| -x), &[1.0, -1.0, 0.0]].concat());
        0.5 * apart.iter().map(|x| x * x).sum::<f64>()
    };
    let (least, most) = (Interval::at_least(0.0), Interval::at_most(1.0));
    for constraints in [vec![Interval::ZERO, least, Interval::FREE, most], vec![Interval::FREE, least, least, most]] {
        for start in [[0.0; 3], [3.0, -4.0, 0.5], [-7.0, 2.0, 9.0]] {
            let outcome = solve(&mut Given::new(plane, vec![Interval::FREE; 3], constraints.clone()), &start);
            assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
            assert!(outcome.evaluations < 60, "{}", outcome.evaluations);
            assert_near(&outcome.x, &[0.0, -1.0, 2.0], 1e-5);
        }
    }
}

/// A cart that swings a link up on a rail, in 2 s with a force of at most so many newtons, at rest at the end.
fn on_a_rail(steps: usize, force: f64, solve: impl FnOnce(&mut MotionProblem, &[Output])) {
    let mut cart = CartPendulum::with_links(1).mechanism();
    let end = cart.scene.end_state(cart.links[0].coordinates[2]);
    let x = cart.cart.coordinates[0];
    cart.scene.effort("effort", cart.force, 0.01);
    let places: Vec<_> = (0..=steps).map(|node| cart.scene.reading(&format!("place {node}"), x, node, 0.0, 1.0)).collect();
    let free = vec![Free::control(cart.force).within(-force, force).scaled(10.0)];
    let system = cart.scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(steps, 2.0 / steps as f64));
    let variables = Variables::new(&system, &inputs, free).expect("variables");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    problem.constrain(end.position, Interval::equal(std::f64::consts::FRAC_PI_2));
    problem.constrain(end.rate, Interval::equal(0.0));
    solve(&mut problem, &places);
}

#[test]
fn a_rail_that_holds_the_cart_at_many_nodes_is_followed() {
    // Of the rails that a force of 40 N cannot swing the link up on, the least violation is an answer.
    for (rail, force, most, reason) in [
        (Interval::new(-1.0, 1.0), 40.0, 400, Reason::Stationary),
        (Interval::new(0.0, 1.5), 120.0, 400, Reason::Stationary),
        (Interval::new(0.0, 1.0), 120.0, 600, Reason::Stationary),
        (Interval::new(-0.4, 0.4), 40.0, 400, Reason::Infeasible),
    ] {
        on_a_rail(50, force, |problem, places| {
            places.iter().for_each(|place| problem.constrain(*place, rail));
            let options = Options { stationarity: 1e-6, iterations: 300, ..Options::default() };
            let start = vec![1.0; problem.variables()];
            let outcome = interior_point(problem, &start, &options, &mut silent).expect("fits");
            println!("{rail:?}, {force} N: {:?} {} {}", outcome.reason, outcome.value, outcome.evaluations);
            assert_eq!(outcome.reason, reason, "{rail:?}, {force} N");
            assert!(outcome.evaluations < most, "{}", outcome.evaluations);
            assert_eq!(outcome.violation < 1e-8, reason == Reason::Stationary, "{}", outcome.violation);
            // Nothing is said of constraints that come closer slowly.
            for iterations in [1, 19, 20, 21, 25, 32, 40, 50, 60].into_iter().filter(|_| reason == Reason::Stationary) {
                let options = Options { iterations, ..options };
                let outcome = interior_point(problem, &start, &options, &mut silent).expect("fits");
                assert_eq!((outcome.reason, outcome.history.len() <= iterations + 1), (Reason::Iterations, true));
            }
        });
    }
}

#[test]
fn where_a_constraint_is_nearest_to_zero_it_is_infeasible_and_where_it_vanishes_twice_it_is_not() {
    let cubic: Function = |x, c, g| {
        c[0] = x[0].powi(3) - 2.0 * x[0] + 2.0;
        (g[0], g[1]) = (2.0 * x[0], 3.0 * x[0] * x[0] - 2.0);
        x[0] * x[0]
    };
    let solve = |f, start| solve(&mut Given::new(f, vec![Interval::FREE], vec![Interval::ZERO]), &[start]);
    let outcome = solve(cubic, 0.8);
    assert_eq!(outcome.reason, Reason::Infeasible, "{outcome:?}");
    assert_near(&outcome.x, &[(2.0f64 / 3.0).sqrt()], 1e-3);
    assert_near(&solve(cubic, -1.0).x, &[-1.769_292_354_238_631_4], 1e-6);
    let twice: Function = |x, c, g| {
        c[0] = (x[0] - 1.0).powi(2);
        (g[0], g[1]) = (2.0 * x[0], 2.0 * (x[0] - 1.0));
        x[0] * x[0]
    };
    let outcome = solve(twice, 3.0);
    assert!(outcome.reason != Reason::Infeasible && outcome.violation < 1e-8, "{outcome:?}");
}

#[test]
fn a_bound_where_a_motion_starts_holds_nothing() {
    // A cart that starts at the end of its rail.
    on_a_rail(20, 60.0, |problem, places| {
        let outcomes = [Interval::new(-2.0, 0.0), Interval::FREE].map(|of_start| {
            for (node, place) in places.iter().enumerate() {
                problem.constrain(*place, if node == 0 { of_start } else { Interval::new(-2.0, 0.0) });
            }
            let start = vec![1.0; problem.variables()];
            solve(problem, &start)
        });
        let [with, without] = &outcomes;
        assert_eq!((with.reason, without.reason), (Reason::Stationary, Reason::Stationary), "{with:?}, {without:?}");
        assert!((with.value - without.value).abs() < 1e-5, "{} {}", with.value, without.value);
        assert!(with.evaluations < 2 * without.evaluations, "{} {}", with.evaluations, without.evaluations);
    });
}

#[test]
fn constraints_alone_are_solved_from_afar() {
    // Newton's method alone goes farther and farther away.
    let bend: Function = |x, c, g| {
        c[0] = x[0].atan();
        g.copy_from_slice(&[0.0, 1.0 / (1.0 + x[0] * x[0])]);
        0.0
    };
    let outcome = solve(&mut Given::new(bend, vec![Interval::FREE], vec![Interval::ZERO]), &[20.0]);
    assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
    assert!(outcome.x[0].abs() < 1e-8, "{outcome:?}");
}

/// A problem whose gradients are differences.
struct Differences(Given);

impl Differences {
    fn weighted(&mut self, x: &[f64], f: f64, c: &[f64]) -> f64 {
        let mut values = vec![0.0; c.len()];
        f * self.0.evaluate(x, &mut values).expect("a value") + values.iter().zip(c).map(|(c, w)| c * w).sum::<f64>()
    }
}

impl Problem for Differences {
    fn variables(&self) -> usize {
        self.0.variables()
    }
    fn constraints(&self) -> Vec<Interval> {
        self.0.constraints()
    }
    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.0.evaluate(x, c)
    }
    fn gradient(&mut self, f: f64, c: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let x = self.0.x.clone();
        for (i, g) in gradient.iter_mut().enumerate() {
            let [ahead, behind] = [1e-5, -1e-5].map(|step| {
                let mut x = x.clone();
                x[i] += step;
                self.weighted(&x, f, c)
            });
            *g = (ahead - behind) / 2e-5;
        }
        self.weighted(&x, f, c);
        self.0.gradient(f, c, &mut vec![0.0; gradient.len()])
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.0.product(direction, product)
    }
}

/// ½ ‖x − (1, 2, 3)‖², and x − 2 y, which must be 0 and 1, beside x + y + z = 1.
fn contradiction(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    let apart = [x[0] - 1.0, x[1] - 2.0, x[2] - 3.0];
    c.copy_from_slice(&[x[0] - 2.0 * x[1], x[0] - 2.0 * x[1] - 1.0, x.iter().sum::<f64>() - 1.0]);
    g.copy_from_slice(&[&apart[..], &[1.0, -2.0, 0.0, 1.0, -2.0, 0.0, 1.0, 1.0, 1.0]].concat());
    0.5 * apart.iter().map(|x| x * x).sum::<f64>()
}

#[test]
fn of_contradictions_the_least_violation_is_found_by_any_gradients() {
    let given = || Given::new(contradiction, vec![Interval::FREE; 3], vec![Interval::ZERO; 3]);
    for outcome in [solve(&mut given(), &[0.3, -2.0, 0.7]), solve(&mut Differences(given()), &[0.3, -2.0, 0.7])] {
        assert_eq!(outcome.reason, Reason::Infeasible, "{outcome:?}");
        assert!(outcome.evaluations < 100, "{}", outcome.evaluations);
        assert_near(&outcome.constraints, &[0.5, -0.5, 0.0], 1e-4);
    }
}

/// Constraints that leave a single point: towards them alone it ended where its barrier did, twice, and called that the least violation.
#[test]
fn sets_that_touch_are_not_infeasible() {
    // x ≤ 0, and a circle about (1, 0) through the origin.
    let touch: Function = |x, c, g| {
        c[0] = 0.5 * (x[0] * x[0] + x[1] * x[1]) - x[0];
        g.copy_from_slice(&[x[0] - 0.3, x[1], x[0] - 1.0, x[1]]);
        0.5 * (x[0] * x[0] + x[1] * x[1]) - 0.3 * x[0]
    };
    for start in [[1.0, -2.0], [1.0, 2.0], [0.0, 1.0], [-1.0, 10.0], [1.26, -1.98]] {
        let bounds = vec![Interval::at_most(0.0), Interval::FREE];
        let outcome = solve(&mut Given::new(touch, bounds, vec![Interval::at_most(0.0)]), &start);
        assert!(outcome.reason.is_converged() && outcome.violation < 1e-9, "{outcome:?}");
        assert_near(&outcome.x, &[0.0, 0.0], 1e-4);
    }
}

/// Where constraints leave no room multipliers are of any size: slopes that were small beside them were taken for none.
#[test]
fn what_falls_without_end_is_not_stationary() {
    // x − y with 0 ≤ x ≤ 0, half of it as a constraint.
    let slope: Function = |x, c, g| {
        c[0] = x[0];
        g.copy_from_slice(&[1.0, -1.0, 1.0, 0.0]);
        x[0] - x[1]
    };
    for start in [[1.0, 1.0], [5.0, 5.0], [0.01, 0.0]] {
        let bounds = vec![Interval::at_least(0.0), Interval::FREE];
        let outcome = solve(&mut Given::new(slope, bounds, vec![Interval::at_most(0.0)]), &start);
        assert!(
            !outcome.reason.is_converged() && outcome.reason != Reason::Infeasible,
            "{:?} {:?}",
            outcome.reason,
            outcome.x
        );
    }
}

/// (y − 1)² − 0.3 x in a unit of variables, with exact products.
struct Slope {
    unit: f64,
    bounds: [Interval; 2],
    y: f64,
    weight: f64,
}

impl Problem for Slope {
    fn variables(&self) -> usize {
        2
    }
    fn bounds(&self) -> Vec<Interval> {
        self.bounds.map(|of| Interval::new(of.least * self.unit, of.most * self.unit)).to_vec()
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        self.y = x[1] / self.unit;
        Ok((self.y - 1.0).powi(2) - 0.3 * x[0] / self.unit)
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.weight = f / self.unit;
        gradient.copy_from_slice(&[-0.3 * self.weight, 2.0 * (self.y - 1.0) * self.weight]);
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        product.copy_from_slice(&[0.0, 2.0 * self.weight / self.unit * direction[1]]);
        Ok(())
    }
}

/// What was large was small beside where it had gone, and so was taken for stationary.
#[test]
fn what_falls_without_end_is_unbounded_in_any_unit() {
    for unit in [1.0, 1.0 / 1024.0, 1024.0] {
        for first in [Interval::FREE, Interval::at_least(-1.0)] {
            for second in [Interval::FREE, Interval::at_least(0.0), Interval::new(-1.0, 2.0)] {
                for start in [[0.0, 0.0], [1.0, 2.0], [-1.0, 0.0], [0.5, -3.0], [0.0, 1.5], [2.0, 1.0], [5.0, 5.0]] {
                    let mut problem = Slope { unit, bounds: [first, second], y: 0.0, weight: 0.0 };
                    let Outcome { reason, value, .. } = solve(&mut problem, &start.map(|x| x * unit));
                    assert_eq!(reason, Reason::Unbounded, "{unit} {first:?} {second:?} {start:?} {value}");
                    assert!(!reason.is_converged() && value < -1e14, "{value}");
                }
            }
        }
    }
}

/// What rounding bends a straight slope by was taken for a curvature, and all of a bounded interval was small beside where that would be least.
#[test]
fn rounding_is_no_curvature() {
    let straight: Function = |x, _, g| {
        g[0] = (x[0] + 3.0) / 3.0 - x[0] / 3.0;
        x[0]
    };
    for start in [1.0, 0.7, 1.9] {
        let outcome = solve(&mut Given::new(straight, vec![Interval::new(0.0, 2.0)], vec![]), &[start]);
        assert_eq!(outcome.reason, Reason::Stationary, "{outcome:?}");
        assert!(outcome.x[0] < 1e-6, "{outcome:?}");
    }
}

/// Slopes were small beside those of what is fixed.
#[test]
fn what_cannot_move_makes_no_slope_small() {
    let valley: Function = |x, _, g| {
        g.copy_from_slice(&[1e9, 2.0 * (x[1] - 3.0)]);
        1e9 * x[0] + (x[1] - 3.0).powi(2)
    };
    let outcome = solve(&mut Given::new(valley, vec![Interval::equal(1.0), Interval::FREE], vec![]), &[1.0, 0.0]);
    assert!(outcome.reason.is_converged(), "{:?}", outcome.reason);
    assert_near(&outcome.x, &[1.0, 3.0], 1e-6);
}

/// The augmented Lagrangian was content where constraints held, with multipliers of some that were not at their bounds.
#[test]
fn a_constraint_with_a_multiplier_is_at_its_bound() {
    // 0.4 x + 0.66 y ≥ 0 and y ≤ 0; least at the origin.
    let corner: Function = |x, c, g| {
        c[0] = -0.4 * x[0] - 0.66 * x[1];
        let slope = [0.25 + 0.33 * x[0] - 0.17 * x[1], -0.25 - 0.17 * x[0] + 0.63 * x[1]];
        g.copy_from_slice(&[slope[0], slope[1], -0.4, -0.66]);
        0.5 * ((slope[0] + 0.25) * x[0] + (slope[1] - 0.25) * x[1])
    };
    for start in [[0.3, -0.5], [0.5, -1.0], [0.45, -7.2]] {
        let bounds = vec![Interval::new(-0.2, 1.0), Interval::new(-1.4, 0.0)];
        let mut problem = Given::new(corner, bounds, vec![Interval::at_most(0.0)]);
        let outcome = augmented_lagrangian(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason.is_converged(), "{outcome:?}");
        assert_near(&outcome.x, &[0.0, 0.0], 1e-6);
        assert_near(&outcome.multipliers, &[0.625], 1e-5);
    }
}

/// x + y with x² + y² ≤ 0: the violation falls as the square of the penalty's reciprocal, and was still above 1e-9 at the largest.
#[test]
fn constraints_that_still_come_closer_are_not_infeasible() {
    let single: Function = |x, c, g| {
        c[0] = x[0] * x[0] + x[1] * x[1];
        g.copy_from_slice(&[1.0, 1.0, 2.0 * x[0], 2.0 * x[1]]);
        x[0] + x[1]
    };
    for to in [Interval::ZERO, Interval::at_most(0.0)] {
        let mut problem = Given::new(single, vec![Interval::FREE; 2], vec![to]);
        let outcome = augmented_lagrangian(&mut problem, &[1.0, 0.5], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason == Reason::NoLowerValue && outcome.violation < 1e-8, "{outcome:?}");
    }
}

#[test]
fn what_falls_without_end_is_unbounded_by_gradients_alone() {
    let slope: Function = |x, _, g| {
        g.copy_from_slice(&[1.0, 1e-3]);
        x[0] + 1e-3 * x[1]
    };
    for (least, start) in [(f64::NEG_INFINITY, [0.0, 0.0]), (0.0, [0.0, 0.0]), (-1e3, [1e3, 1e5])] {
        let mut problem = Given::new(slope, vec![Interval::at_least(least), Interval::FREE], Vec::new());
        let outcome = lbfgs(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason == Reason::Unbounded && outcome.value < -1e12, "{outcome:?}");
    }
}

/// Where no step brought constraints closer than to rounding, the way towards them alone began beside bounds again, ended farther off, and was called infeasible.
#[test]
fn more_than_rounding_leaves_is_not_asked_of_constraints() {
    for (violation, stationarity) in [(1e-15, 1e-10), (0.0, 1e-7), (0.0, 0.0)] {
        for start in [[1.0; 4], [5.0; 4], [2.0, 3.0, 4.0, 2.0], [1.0, 4.0, 4.0, 1.5]] {
            let constraints = vec![Interval::at_least(25.0), Interval::equal(40.0)];
            let mut problem = Given::new(hs71, vec![Interval::new(1.0, 5.0); 4], constraints);
            let options = Options { violation, stationarity, ..Options::default() };
            let outcome = interior_point(&mut problem, &start, &options, &mut silent).expect("fits");
            let is_end = outcome.reason.is_converged() || outcome.reason == Reason::NoLowerValue;
            assert!(is_end && outcome.violation < 1e-12, "{start:?} {outcome:?}");
        }
    }
}

/// ½ (aᵀx)² + gᵀx.
struct Valley {
    a: Vec<f64>,
    g: Vec<f64>,
    x: Vec<f64>,
}

impl Valley {
    /// Some numbers from −1 to 1, the same for the same k.
    fn numbers(k: usize, count: usize) -> Vec<f64> {
        (0..count).map(|i| (12.9898 * (k * count + i + 1) as f64).sin()).collect()
    }

    fn along(&self, x: &[f64]) -> f64 {
        self.a.iter().zip(x).map(|(a, x)| a * x).sum()
    }
}

impl Problem for Valley {
    fn variables(&self) -> usize {
        self.a.len()
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        self.x = x.to_vec();
        Ok(0.5 * self.along(x).powi(2) + self.g.iter().zip(x).map(|(g, x)| g * x).sum::<f64>())
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let slope = self.along(&self.x);
        gradient.iter_mut().zip(self.a.iter().zip(&self.g)).for_each(|(to, (a, g))| *to = f * (a * slope + g));
        Ok(())
    }
    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        let bend = self.along(direction);
        product.iter_mut().zip(&self.a).for_each(|(to, a)| *to = a * bend);
        Ok(())
    }
}

#[test]
fn a_valley_that_falls_without_end_has_no_stationary_point() {
    for k in 0..400 {
        let numbers = Valley::numbers(k, 6);
        for method in [lbfgs, augmented_lagrangian] {
            let mut problem = Valley { a: numbers[..2].to_vec(), g: numbers[2..4].to_vec(), x: Vec::new() };
            let start = [3.0 * numbers[4], 3.0 * numbers[5]];
            let outcome = method(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert!(!outcome.reason.is_converged(), "{k}: {outcome:?}");
        }
    }
}

/// ½ xᵀHx + gᵀx.
struct Quadratic {
    h: [[f64; 2]; 2],
    g: [f64; 2],
    x: [f64; 2],
}

impl Quadratic {
    fn bend(&self, x: &[f64]) -> [f64; 2] {
        self.h.map(|row| row[0] * x[0] + row[1] * x[1])
    }
}

impl Problem for Quadratic {
    fn variables(&self) -> usize {
        2
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        self.x.copy_from_slice(x);
        let bend = self.bend(x);
        Ok((0..2).map(|i| self.g[i] * x[i] + 0.5 * x[i] * bend[i]).sum())
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        let [x, y] = self.x;
        (0..2).for_each(|i| gradient[i] = f * (self.g[i] + self.h[i][0] * x + self.h[i][1] * y));
        Ok(())
    }
}

/// Along valleys without a floor it goes so far that gradients are rounding: as large as at the start, or none at all.
#[test]
fn no_minimum_is_found_where_gradients_are_rounding() {
    let some = [76, 108, 161, 270]
        .map(|k| Valley::numbers(k, 6))
        .map(|of| ([of[0], of[1]], [of[2], of[3]], [3.0 * of[4], 3.0 * of[5]]));
    let none = [([0.1, 0.1], [-0.7, 0.0], [2.0, 1.0]), ([0.3, 0.6], [0.2, 0.6], [-1.0, 3.0])];
    for (a, g, start) in some.into_iter().chain(none) {
        for method in [lbfgs, augmented_lagrangian] {
            let mut problem = Quadratic { h: a.map(|x| a.map(|y| x * y)), g, x: start };
            let outcome = method(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
            assert!(!outcome.reason.is_converged(), "{a:?} {g:?}: {outcome:?}");
        }
    }
}

#[test]
fn a_minimum_may_be_far_from_the_start() {
    for far in [1e3, 1e9, 1e14, 1e18, 1e30] {
        for method in [lbfgs, augmented_lagrangian] {
            let mut problem = Far { place: far, x: 0.0 };
            let outcome = method(&mut problem, &[1.0], &Options::default(), &mut silent).expect("fits");
            assert!(outcome.reason == Reason::Stationary && (outcome.x[0] / far - 1.0).abs() < 1e-6, "{outcome:?}");
        }
    }
}

/// ½ (x/place − 1)² − 1.
struct Far {
    place: f64,
    x: f64,
}

impl Problem for Far {
    fn variables(&self) -> usize {
        1
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        self.x = x[0];
        Ok(0.5 * (x[0] / self.place - 1.0).powi(2) - 1.0)
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient[0] = f * (self.x / self.place - 1.0) / self.place;
        Ok(())
    }
}

/// The value falls along a variable that the constraint does not know; steps along it moved the other one by their rounding.
#[test]
fn what_falls_without_end_beside_a_constraint_is_not_infeasible() {
    let slope: Function = |x, c, g| {
        c[0] = -0.9114795162804326 * x[1];
        g.copy_from_slice(&[0.63, 0.856, 0.0, -0.9114795162804326]);
        0.63 * x[0] + 0.856 * x[1]
    };
    for start in [[1.56, 0.0], [0.0, 0.0], [-3.0, 2.0]] {
        let mut problem = Given::new(slope, vec![Interval::FREE; 2], vec![Interval::equal(0.5507297814304394)]);
        let outcome = interior_point(&mut problem, &start, &Options::default(), &mut silent).expect("fits");
        assert_eq!(outcome.reason, Reason::Unbounded, "{outcome:?}");
    }
}

#[test]
fn the_floor_of_a_valley_is_where_it_is_found_again() {
    for k in 0..100 {
        let numbers = Valley::numbers(k, 9);
        let a = numbers[..3].to_vec();
        let slope = a[0] * 0.3 - a[1] * 0.7 + a[2] * 0.2;
        let mut problem = Valley { g: a.iter().map(|a| a * slope).collect(), a, x: Vec::new() };
        let found = solve(&mut problem, &[2.0 * numbers[3], 2.0 * numbers[4], 2.0 * numbers[5]]);
        let again = solve(&mut problem, &found.x);
        assert!(found.reason.is_converged() && again.reason.is_converged(), "{k}: {found:?} {again:?}");
    }
}

#[test]
fn a_constraint_with_room_has_no_multiplier_where_variables_are_at_their_bounds() {
    let first: Function = |x, c, g| {
        (c[0], g[0], g[1]) = (x[0], 1.0, 1.0);
        x[0]
    };
    for method in [interior_point, augmented_lagrangian] {
        let mut problem = Given::new(first, vec![Interval::new(0.0, 1.0)], vec![Interval::new(-1.0, 3.0)]);
        let outcome = method(&mut problem, &[0.5], &Options::default(), &mut silent).expect("fits");
        assert!(outcome.reason.is_converged() && outcome.multipliers[0].abs() < 1e-6, "{outcome:?}");
    }
}

#[test]
fn a_fit_does_not_depend_on_the_units_of_variables() {
    // p + s k = 1 and p = s k, for k in units of 1 to 1e16.
    let residuals: [Function; 5] = [units::<0>, units::<4>, units::<8>, units::<12>, units::<16>];
    for (power, function) in residuals.into_iter().enumerate() {
        let unit = 10f64.powi(4 * power as i32);
        let mut problem = Given::new(function, vec![Interval::FREE; 2], vec![Interval::ZERO; 3]);
        let fit = levenberg_marquardt(&mut problem, &[0.2, 0.1 * unit], &Options::default(), &mut silent).expect("fits");
        assert!(fit.outcome.reason == Reason::Stationary && fit.outcome.history.len() < 8, "{unit:e}: {fit:?}");
        assert_near(&[fit.outcome.x[0], fit.outcome.x[1] / unit], &[0.5, 0.5], 1e-6);
    }
}

/// f = 0 and the residuals p + s k − 1, p − s k, ½ p + s k − ¾ with s = 10^−POWER.
fn units<const POWER: i32>(x: &[f64], c: &mut [f64], g: &mut [f64]) -> f64 {
    let s = 10f64.powi(-POWER);
    let (p, k) = (x[0], s * x[1]);
    c.copy_from_slice(&[p + k - 1.0, p - k, 0.5 * p + k - 0.75]);
    g.copy_from_slice(&[0.0, 0.0, 1.0, s, 1.0, -s, 0.5, s]);
    0.0
}
