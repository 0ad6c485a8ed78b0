//! Formulas that lose derivatives, each by one argument, and many that read values and lose none.

use hamiltonian_adjoint::check::{self, Random};
use hamiltonian_adjoint::optimize::{
    Free, MotionProblem, MultipleShooting, Options, Problem, Trials, Variables, interior_point, silent,
};
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Cx, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, LiftedSolver, LongSolver, Param,
    ParameterFormula, PotentialEnergy, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System, Warning, gradient,
};
use nalgebra::SVector;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::tree::{Slopes, Tree, lines};

/// How a planted formula reads the value that it computes with.
#[derive(Clone, Copy, Debug)]
enum Form {
    Table,
    Wave,
    Power,
    /// A number of few digits.
    Short,
}

const FORMS: [Form; 4] = [Form::Table, Form::Wave, Form::Power, Form::Short];

/// A loss by one argument, beyond a distance from its value at the start.
#[derive(Clone, Copy, Debug)]
struct Loss {
    argument: usize,
    form: Form,
    start: f64,
    flat: f64,
}

impl Loss {
    fn value<S: Scalar>(&self, of: &[S]) -> S {
        let x = of[self.argument];
        let beyond = |x: f64| (x - self.start).abs() - self.flat;
        S::from(match self.form {
            _ if beyond(x.re()) < 0.0 => 0.0,
            Form::Table => lines(beyond(x.re())),
            Form::Wave => beyond(x.re()) * ((x * 3.0).sin() + 2.0).re(),
            Form::Short => f64::from((beyond(x.re()) as f32).sin()),
            Form::Power => beyond((x * 2.0).re() / 2.0).powi(2) + 0.3 * beyond(x.re()),
        })
    }
}

/// A formula of this file: a tree, and a loss or none.
#[derive(Clone, Debug)]
struct Formula {
    tree: Tree,
    slopes: Slopes,
    loss: Option<Loss>,
}

impl Formula {
    fn value<S: Scalar>(&self, of: &[S]) -> S {
        let tree = self.tree.value(of, self.slopes).tanh() * 0.5;
        self.loss.map_or(tree, |loss| tree * 0.3 + loss.value(of))
    }
}

impl KineticEnergy<2, 1> for Formula {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        v.dot(v) * (self.value(&[q[0], q[1], v[0], v[1], b[0]]) * 0.1 + 0.5)
    }
}
impl PotentialEnergy<2, 1> for Formula {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, t: S) -> S {
        self.value(&[q[0], q[1], t, b[0]]) * (q[0] + 1.5)
    }
}
impl Force<2, 1, 1> for Formula {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let force = self.value(&[at.q[0], at.q[1], at.v[0], at.v[1], at.u[0], at.t, b[0]]);
        SVector::from([force, at.u[0] - force * 0.5])
    }
}
impl Constraint<3, 1, 1> for Formula {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, t: S) -> SVector<S, 1> {
        SVector::from([q[2] - self.value(&[q[0], q[1], t, b[0]]) * 0.3])
    }
}
impl Cost<2, 1, 1, 1> for Formula {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 1, 1>, b: &SVector<S, 1>) -> S {
        let CostPoint { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t } = *at;
        let state = [q[0], q[1], v[0], v[1], p_star[0], p_star_dot[0], v_dot[0]];
        self.value(&[&state[..], &[sigma[0], lambda[0], u[0], u_dot[0], t, b[0]]].concat())
    }
}

/// The kinds of formulas, how many derivatives of each a gradient needs, and the names of its arguments.
const KINDS: usize = 6;
const SLOPES: [i32; KINDS] = [2, 2, 1, 3, 1, 1];
fn arguments(kind: usize) -> &'static [&'static str] {
    const X: &str = "`a.x`";
    const V: &str = "the velocity of `a.x`";
    const W: &str = "the velocity of `a.y`";
    match kind {
        0 => &[X, "`a.y`", V, W, "`b`"],
        1 | 3 => &[X, "`a.y`", "t", "`b`"],
        2 => &[X, "`a.y`", V, W, "`u`", "t", "`b`"],
        _ => &[
            X,
            "`a.y`",
            V,
            W,
            "p* of `a.x`",
            "dp*/dt of `a.x`",
            "the acceleration of `a.x`",
            "σ of `rail`",
            "λ of `rail`",
            "`u`",
            "du/dt of `u`",
            "t",
            "`b`",
        ],
    }
}

/// ½ v², and a track on which the constraint has something to do.
struct Mass;
impl KineticEnergy<1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}
struct Rail;
impl Constraint<2, 1> for Rail {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[1] - q[0].sin() * 0.5])
    }
}
/// 0.4 u + 0.3 on both coordinates.
struct Push;
impl Force<2, 1> for Push {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, _b: &SVector<S, 0>) -> SVector<S, 2> {
        SVector::from([at.u[0] * 0.4 + 3.0, at.u[0] * 0.2 - 2.0])
    }
}

/// 2 x.
struct Double;
impl ParameterFormula<1> for Double {
    fn value<S: Scalar>(&self, x: &SVector<S, 1>) -> S {
        x[0] + x[0]
    }
}

/// Scenes of a few formulas on the same coordinates.
struct Plan {
    formulas: Vec<(usize, Formula)>,
    with_programs: bool,
    /// Whether b is an expression of design variables.
    by_expression: bool,
}

impl Plan {
    fn compile(&self) -> System {
        let mut scene = Scene::new();
        let [x, y] = scene.coordinates("a", ["x", "y"]);
        let z = scene.coordinates("z", ["z"])[0];
        for (name, q) in [("mass x", x), ("mass y", y), ("mass z", z)] {
            scene.kinetic_energy(name, Mass, [q], []);
        }
        [(x, 0.4), (y, -0.3)].into_iter().for_each(|(q, value)| scene.place(q, value));
        let u = scene.control("u");
        let b: Param = if self.by_expression {
            let half = scene.design("half", 0.35);
            scene.parameter("b", Double, [half.into()])
        } else {
            scene.design("b", 0.7).into()
        };
        scene.force("push", Push, [x, y], [u], []);
        let rail = scene.constraint("rail", Rail, [x, z], [])[0];
        for (k, (kind, formula)) in self.formulas.iter().enumerate() {
            let (name, formula) = (format!("formula {k}"), formula.clone());
            match kind {
                0 => scene.kinetic_energy(&name, formula, [x, y], [b]),
                1 => scene.potential_energy(&name, formula, [x, y], [b]),
                2 => scene.force(&name, formula, [x, y], [u], [b]),
                3 => {
                    let w = scene.coordinates(&format!("w{k}"), ["w"])[0];
                    scene.kinetic_energy(&format!("mass {k}"), Mass, [w], []);
                    let _ = scene.constraint(&name, formula, [x, y, w], [b]);
                }
                _ => {
                    let sum = [Sum::Integral, Sum::Trapezoidal, Sum::Plain, Sum::Terminal, Sum::Node(5)][k % 5];
                    if *kind == 4 {
                        scene.cost(&name, formula, sum, [x, y], [rail], [u], [b]);
                    } else {
                        let output = scene.output(&format!("output {k}"));
                        scene.term(output, &name, formula, sum, [x, y], [rail], [u], [b]);
                    }
                }
            }
        }
        let compiled = if self.with_programs { scene.compile() } else { scene.compile_without_programs() };
        compiled.expect("a scene")
    }
}

/// A motion of so many steps; x, y and their velocities begin with these values.
fn inputs(system: &System, steps: usize, [x, y, v, w]: [f64; 4]) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.6 / steps as f64));
    let both = [system.coordinate(0), system.coordinate(1)];
    inputs.start = Start::assembled(system).hold(&both);
    for (coordinate, [q, rate]) in both.into_iter().zip([[x, v], [y, w]]) {
        inputs.start.set_coordinate(coordinate, q);
        inputs.start.set_rate(coordinate, rate);
    }
    inputs.set_control(system.control(0), |t| 0.5 + 2.0 * t + 6.0 * t * t);
    inputs
}

/// The formulas that are said to lose derivatives of an order, and by what.
fn named(warnings: &[Warning], of: usize) -> Vec<(String, String)> {
    let lost = |warning: &Warning| match warning {
        Warning::LostDerivative { element, argument, order } if *order == of => Some((element.clone(), argument.clone())),
        _ => None,
    };
    warnings.iter().filter_map(lost).collect()
}

/// What a motion and its gradient warn of.
fn lost(system: &System, inputs: &Inputs) -> Result<Vec<(String, String)>, Error> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs)?;
    let simulated = named(&solver.report().warnings, 1);
    assert_eq!(named(&solver.gradient()?.warnings, 1), simulated);
    Ok(simulated)
}

/// What a product of the Hessian warns of.
fn lost_by_product(system: &System, inputs: &Inputs) -> Result<Vec<(String, String)>, Error> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs)?;
    Ok(named(&solver.hessian_product(&inputs.no_change())?.warnings, 2))
}

/// Gradients said nothing of most of these: of constants of costs and of constraints, of time in constraints, of what is flat near the start, and of all
/// formulas of scenes without programs.
#[test]
fn every_loss_is_named_with_its_argument() {
    let (mut random, mut count, mut silent) = (Random::new(1), 0, Vec::new());
    for (kind, slopes) in SLOPES.into_iter().enumerate() {
        for (argument, name) in arguments(kind).iter().enumerate() {
            // Constants do not move away from where they are.
            let flat = if *name == "`b`" { 0.0 } else { 0.07 };
            let start = match *name {
                "`a.x`" => 0.4,
                "`a.y`" => -0.3,
                "the velocity of `a.x`" => 0.2,
                "the velocity of `a.y`" => -0.1,
                "`u`" => 0.5,
                _ => 0.0,
            };
            for (form, flat) in FORMS.into_iter().flat_map(|form| [(form, -0.02), (form, flat)]) {
                for with_programs in [true, false] {
                    count += 1;
                    let tree = Tree::new(&mut random, arguments(kind).len(), 1);
                    let loss = Some(Loss { argument, form, start, flat });
                    let formulas = vec![(kind, Formula { tree, slopes: Slopes(slopes), loss })];
                    let by_expression = count % 3 == 0;
                    let plan = Plan { formulas, with_programs, by_expression };
                    let system = plan.compile();
                    let found = lost(&system, &inputs(&system, 20, [0.4, -0.3, 0.2, -0.1]));
                    let of_half = name.replace("`b`", "an expression of `half`");
                    let name = if by_expression { &of_half } else { *name };
                    let expected = vec![("formula 0".to_string(), name.to_string())];
                    if found.as_ref() != Ok(&expected) {
                        println!("{kind} {name} {form:?} {flat} {with_programs} {by_expression}: {found:?}");
                        silent.push((kind, name.to_string()));
                    }
                }
            }
        }
    }
    println!("{count} losses, {} not named", silent.len());
    assert!(silent.is_empty());
}

/// Scenes of formulas that branch, look tables up with their slopes, find roots by iteration …, with so many exact derivatives `more` than gradients need.
fn without_loss(seeds: std::ops::Range<u64>, more: i32) -> (usize, Vec<(String, String)>) {
    let (mut count, mut found) = (0, Vec::new());
    for seed in seeds {
        let mut random = Random::new(seed);
        let formulas: Vec<(usize, Formula)> = (0..30)
            .map(|k| {
                let kind = k % KINDS;
                let tree = Tree::new(&mut random, arguments(kind).len(), 1 + k / 10);
                (kind, Formula { tree, slopes: Slopes(SLOPES[kind] + more), loss: None })
            })
            .collect();
        let plan = Plan { formulas, with_programs: seed % 3 > 0, by_expression: seed % 2 == 0 };
        let system = plan.compile();
        let state = [0; 4].map(|_| if random.below(4) == 0 { 0.0 } else { random.uniform(-1.0, 1.0) });
        let inputs = inputs(&system, 8, state);
        let Ok(all) = (if more > 0 { lost_by_product(&system, &inputs) } else { lost(&system, &inputs) }) else { continue };
        count += plan.formulas.len();
        for (name, argument) in all {
            let which: usize = name.trim_start_matches("formula ").parse().expect("a number");
            println!("{seed} {name} {argument}: {:?}", plan.formulas[which]);
            found.push((name, argument));
        }
    }
    println!("{count} formulas without a loss, {} named", found.len());
    (count, found)
}

#[test]
fn fifteen_thousand_formulas_that_read_values_and_lose_nothing_are_not_named() {
    let (count, found) = without_loss(1..535, 0);
    assert!(count >= 15_000 && found.is_empty());
}

/// A root that one step of Newton's method corrects has first derivatives alone: a force and a cost of it have exact gradients.
#[test]
fn products_of_the_hessian_name_what_loses_second_derivatives_and_nothing_else() {
    let (count, found) = without_loss(1000..1020, 1);
    assert!(count >= 500 && found.is_empty());
    for (kind, argument) in [(2, 0), (2, 5), (4, 2), (5, 12)] {
        let x = || Box::new(Tree::Argument(argument));
        for which in [8, 9] {
            let tree = Tree::Reading(which, x(), Box::new(Tree::Number(0.2)));
            let formulas = vec![(kind, Formula { tree, slopes: Slopes(1), loss: None })];
            let system = Plan { formulas, with_programs: true, by_expression: false }.compile();
            let inputs = inputs(&system, 20, [0.4, -0.3, 0.2, -0.1]);
            assert_eq!(lost(&system, &inputs), Ok(Vec::new()), "{kind} {argument} {which}");
            let expected = ("formula 0".to_string(), arguments(kind)[argument].to_string());
            assert_eq!(lost_by_product(&system, &inputs), Ok(vec![expected]), "{kind} {argument} {which}");
        }
    }
}

/// Formulas that lose a constant of a constraint, time, and a constant of a cost, in a scene with others.
#[test]
fn whatever_computes_a_motion_names_what_its_formulas_lose() {
    let with = |kind: usize, argument: usize| {
        let tree = Tree::Reading(2, Box::new(Tree::Argument(0)), Box::new(Tree::Argument(1)));
        let loss = Some(Loss { argument, form: Form::Table, start: 0.0, flat: 0.05 });
        (kind, Formula { tree, slopes: Slopes(SLOPES[kind]), loss })
    };
    let plan = Plan { formulas: vec![with(3, 3), with(3, 2), with(4, 12)], with_programs: true, by_expression: false };
    let system = plan.compile();
    let inputs = inputs(&system, 40, [0.4, -0.3, 0.2, -0.1]);
    let expected = [(0, "`b`"), (1, "t"), (2, "`b`")].map(|(k, name)| (format!("formula {k}"), name.to_string()));
    let is_expected = |mut found: Vec<(String, String)>| {
        found.sort();
        found == expected
    };
    assert!(lost(&system, &inputs).is_ok_and(is_expected));
    let mut long = LongSolver::new(&system, Settings::default(), 60_000);
    assert!(is_expected(named(&long.gradient(&inputs).expect("a motion").warnings, 1)));
    let lifted = LiftedSolver::<Cx>::new(&system, &inputs, Settings::default()).expect("a motion");
    assert!(is_expected(named(&lifted.real().report().warnings, 1)));
    for scheme in [Scheme::ESDIRK4, Scheme::TR_BDF2] {
        let found = gradient(&system, &inputs, Settings { scheme, ..Settings::default() }).expect("a motion").warnings;
        assert!(is_expected(named(&found, 1)));
    }
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("a motion").warnings;
    assert!(
        expected.iter().all(|(name, _)| report.iter().any(|text| text.contains(&format!("`{name}` loses its derivative"))))
    );
    let variables = Variables::new(&system, &inputs, vec![Free::control(system.control(0))]).expect("a variable");
    let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("a problem");
    let start = problem.start();
    problem.evaluate(&start, &mut []).expect("a motion");
    assert!(is_expected(named(&problem.warnings(), 1)));
}

/// However many segments or trials a formula loses a derivative in.
#[test]
fn segments_and_trials_name_a_loss_once() {
    let tree = Tree::Reading(2, Box::new(Tree::Argument(0)), Box::new(Tree::Argument(1)));
    let loss = Some(Loss { argument: 1, form: Form::Table, start: 0.0, flat: 0.05 });
    let mut scene = Scene::new();
    let q = scene.coordinates("a", ["x", "y"]);
    q.iter().zip(["mass x", "mass y"]).for_each(|(q, name)| scene.kinetic_energy(name, Mass, [*q], []));
    let (u, b) = (scene.control("u"), scene.design("b", 0.7));
    scene.force("force", Formula { tree, slopes: Slopes(1), loss }, q, [u], [b.into()]);
    scene.effort("effort", u, 1.0);
    let states = q.map(|q| scene.end_state(q));
    let system = scene.compile().expect("a scene");
    let (inputs, settings) = (inputs(&system, 40, [0.4, -0.3, 0.2, -0.1]), Settings::default());
    let expected = vec![("force".to_string(), "`a.y`".to_string())];
    let free = || vec![Free::control(u)];
    let mut whole = MultipleShooting::new(&system, settings, inputs.clone(), free(), &states, 4).expect("segments");
    whole.guess(|_, q, v| (q[0], q[1], v[0]) = (0.4, -0.3, 0.2)).expect("a guess");
    let start = whole.start();
    let few = Options { iterations: 2, ..Options::default() };
    let best = interior_point(&mut whole, &start, &few, &mut silent).expect("a problem");
    assert!(whole.segments().all(|segment| named(&segment.warnings(), 1) == expected), "all segments meet it");
    assert_eq!([named(&whole.warnings(), 1), named(&best.warnings, 1)], [expected.clone(), expected.clone()]);
    let motion = || {
        let variables = Variables::new(&system, &inputs, free()).expect("a variable");
        MotionProblem::new(&system, settings, inputs.clone(), variables).expect("a problem")
    };
    let mut trials = Trials::new(vec![motion(), motion()]).expect("trials");
    let mut c = vec![0.0; trials.constraints().len()];
    trials.evaluate(&motion().start(), &mut c).expect("motions");
    assert_eq!(named(&trials.warnings(), 1), expected);
}

/// A force that branches or does not, and counts how often it is recorded.
struct Counted {
    branches: bool,
    count: Arc<AtomicUsize>,
}
impl Force<1> for Counted {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        if std::any::type_name::<S>().contains("Symbol") {
            self.count.fetch_add(1, Ordering::Relaxed);
        }
        let push = at.q[0] * -2.0 + 1.0;
        SVector::from([if self.branches && at.q[0].re() > 0.5 { push * 2.0 } else { push }])
    }
}

#[test]
fn formulas_that_read_no_values_are_not_examined_and_others_at_few_nodes() {
    for (branches, most) in [(false, 0), (true, 2 * 17)] {
        for steps in [20, 200, 2000] {
            let count = Arc::new(AtomicUsize::new(0));
            let mut scene = Scene::new();
            let x = scene.coordinates("a", ["x"]);
            scene.kinetic_energy("mass", Mass, x, []);
            scene.force("force", Counted { branches, count: count.clone() }, x, [], []);
            let system = scene.compile().expect("a scene");
            count.store(0, Ordering::Relaxed);
            let mut solver = Solver::new(&system, Settings::default());
            solver.simulate(&Inputs::at_rest(&system, Grid::uniform(steps, 4.0 / steps as f64))).expect("a motion");
            let recorded = count.load(Ordering::Relaxed);
            println!("branches: {branches}, {steps} steps: recorded {recorded} times");
            let loses = |warning: &Warning| !matches!(warning, Warning::CoarseSteps { .. });
            assert!(recorded <= most && (recorded > 0) == branches && !solver.report().warnings.iter().any(loses));
        }
    }
}
