//! How often the formulas of a scene are called: those whose derivatives are constant never in a step, and the sweep back calls a
//! formula only for what its derivatives with respect to inputs need.

use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, levenberg_marquardt};
use hamiltonian_adjoint::{
    Constraint, Control, Coordinate, Cost, CostPoint, Design, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy,
    LiftedSolver, Param, PotentialEnergy, Scalar, Scene, Settings, Solver, Sum, System,
};
use nalgebra::{SVector, Vector1, Vector2};
use num_dual::Dual64;
use std::ops::{ControlFlow, RangeInclusive};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How often a formula was called.
#[derive(Clone, Default)]
struct Calls(Arc<AtomicUsize>);

impl Calls {
    fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn take(&self) -> usize {
        self.0.swap(0, Ordering::Relaxed)
    }
}

/// An element that counts the calls of its formula.
struct Counted<E>(E, Calls);

impl<E: KineticEnergy<N, P>, const N: usize, const P: usize> KineticEnergy<N, P> for Counted<E> {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, N>, v: &SVector<S, N>, b: &SVector<S, P>) -> S {
        self.1.add();
        self.0.kinetic_energy(q, v, b)
    }
}

impl<E: PotentialEnergy<N, P>, const N: usize, const P: usize> PotentialEnergy<N, P> for Counted<E> {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, P>, t: S) -> S {
        self.1.add();
        self.0.potential_energy(q, b, t)
    }
}

impl<E: Force<N, K, P>, const N: usize, const K: usize, const P: usize> Force<N, K, P> for Counted<E> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, N, K>, b: &SVector<S, P>) -> SVector<S, N> {
        self.1.add();
        self.0.force(at, b)
    }
}

impl<E: Constraint<N, M, P>, const N: usize, const M: usize, const P: usize> Constraint<N, M, P> for Counted<E> {
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, P>, t: S) -> SVector<S, M> {
        self.1.add();
        self.0.phi(q, b, t)
    }
}

impl<E: Cost<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> Cost<N, M, K, P> for Counted<E> {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, M, K>, b: &SVector<S, P>) -> S {
        self.1.add();
        self.0.cost(at, b)
    }
}

/// T = ½ m v².
struct Mass;
impl KineticEnergy<1, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &Vector1<S>, v: &Vector1<S>, b: &Vector1<S>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}

/// T = ½ m (1 + q²) v².
struct GrowingMass;
impl KineticEnergy<1, 1> for GrowingMass {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector1<S>, v: &Vector1<S>, b: &Vector1<S>) -> S {
        b[0] * (q[0] * q[0] + 1.0) * v[0] * v[0] * 0.5
    }
}

/// V = ½ c (q − 1)².
struct Spring;
impl PotentialEnergy<1, 1> for Spring {
    fn potential_energy<S: Scalar>(&self, q: &Vector1<S>, b: &Vector1<S>, _t: S) -> S {
        b[0] * (q[0] - 1.0).powi(2) * 0.5
    }
}

/// V = ¼ c (q − 1)⁴.
struct HardSpring;
impl PotentialEnergy<1, 1> for HardSpring {
    fn potential_energy<S: Scalar>(&self, q: &Vector1<S>, b: &Vector1<S>, _t: S) -> S {
        b[0] * (q[0] - 1.0).powi(4) * 0.25
    }
}

/// Q = u − d v.
struct Pushed;
impl Force<1, 1, 1> for Pushed {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &Vector1<S>) -> Vector1<S> {
        at.u - at.v * b[0]
    }
}

/// Q = u cos q − d v.
struct PushedAskew;
impl Force<1, 1, 1> for PushedAskew {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &Vector1<S>) -> Vector1<S> {
        at.u * at.q[0].cos() - at.v * b[0]
    }
}

/// Q = d sin t.
struct Shaken;
impl Force<1, 0, 1> for Shaken {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &Vector1<S>) -> Vector1<S> {
        Vector1::new(b[0] * at.t.sin())
    }
}

/// Φ = x − b y.
struct Geared;
impl Constraint<2, 1, 1> for Geared {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector1<S>, _t: S) -> Vector1<S> {
        Vector1::new(q[0] - b[0] * q[1])
    }
}

/// Φ = x − b sin y.
struct Waved;
impl Constraint<2, 1, 1> for Waved {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector1<S>, _t: S) -> Vector1<S> {
        Vector1::new(q[0] - b[0] * q[1].sin())
    }
}

/// Φ = x − b y².
struct Bent;
impl Constraint<2, 1, 1> for Bent {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector1<S>, _t: S) -> Vector1<S> {
        Vector1::new(q[0] - b[0] * q[1] * q[1])
    }
}

/// ½ b q².
struct Distance;
impl Cost<1, 0, 0, 1> for Distance {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &Vector1<S>) -> S {
        b[0] * at.q[0] * at.q[0] * 0.5
    }
}

/// Two masses, pulled and driven, to which a test adds a counted element.
struct Bench {
    scene: Scene,
    x: Coordinate,
    y: Coordinate,
    drive: Control,
    constant: Param,
    bound: Design,
}

/// The calls of the counted element in a simulation and in the gradient after it, for n steps.
fn calls(add: &impl Fn(&mut Bench, Calls), steps: usize) -> (usize, usize) {
    calls_of(add, steps, Scene::compile)
}

fn calls_of(add: &impl Fn(&mut Bench, Calls), steps: usize, compile: fn(Scene) -> Result<System, Error>) -> (usize, usize) {
    calls_with(add, steps, compile, Settings::default())
}

/// The same for a scene that is compiled in another way, or moves in another.
fn calls_with(
    add: &impl Fn(&mut Bench, Calls),
    steps: usize,
    compile: fn(Scene) -> Result<System, Error>,
    settings: Settings,
) -> (usize, usize) {
    let mut scene = Scene::new();
    let [x, y] = scene.coordinates("masses", ["x", "y"]);
    scene.kinetic_energy("mass of x", Mass, [x], [1.3.into()]);
    scene.kinetic_energy("mass of y", Mass, [y], [0.7.into()]);
    scene.potential_energy("pull", Spring, [y], [0.4.into()]);
    let drive = scene.control("drive");
    scene.force("drive", Pushed, [y], [drive], [0.1.into()]);
    let bound = scene.design("b", 0.5);
    let mut bench = Bench { scene, x, y, drive, constant: 0.5.into(), bound };
    let calls = Calls::default();
    add(&mut bench, calls.clone());
    let system = compile(bench.scene).expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.01));
    inputs.controls.fill(0.3);
    let mut solver = Solver::new(&system, settings);
    // The first run evaluates what is constant for this design.
    solver.simulate(&inputs).expect("a motion");
    calls.take();
    solver.simulate(&inputs).expect("a motion");
    let simulation = calls.take();
    solver.gradient().expect("a gradient");
    (simulation, calls.take())
}

/// How the calls in a simulation and those in a gradient grow from 20 to 40 steps.
fn growth(add: impl Fn(&mut Bench, Calls)) -> (usize, usize) {
    let ((simulation, sweep), (longer_simulation, longer_sweep)) = (calls(&add, 20), calls(&add, 40));
    (longer_simulation - simulation, longer_sweep - sweep)
}

/// The same where dual numbers differentiate every element at every point; a sweep has something to solve where a cost depends on the end.
fn growth_by_dual_numbers(add: impl Fn(&mut Bench, Calls)) -> (usize, usize) {
    let with_cost = |bench: &mut Bench, calls: Calls| {
        bench.scene.cost("end", Distance, Sum::Terminal, [bench.x], [], [], [0.3.into()]);
        add(bench, calls);
    };
    let [shorter, longer] = [20, 40].map(|steps| calls_of(&with_cost, steps, Scene::compile_without_programs));
    (longer.0 - shorter.0, longer.1 - shorter.1)
}

/// The calls in a gradient over 20 steps.
fn sweep(add: impl Fn(&mut Bench, Calls)) -> usize {
    calls(&add, 20).1
}

fn kinetic(s: &mut Bench, n: Calls) {
    s.scene.kinetic_energy("e", Counted(Mass, n), [s.x], [s.constant]);
}

fn kinetic_bound(s: &mut Bench, n: Calls) {
    s.scene.kinetic_energy("e", Counted(Mass, n), [s.x], [s.bound.into()]);
}

fn growing_mass(s: &mut Bench, n: Calls) {
    s.scene.kinetic_energy("e", Counted(GrowingMass, n), [s.x], [s.constant]);
}

fn spring(s: &mut Bench, n: Calls) {
    s.scene.potential_energy("e", Counted(Spring, n), [s.x], [s.constant]);
}

fn hard_spring(s: &mut Bench, n: Calls) {
    s.scene.potential_energy("e", Counted(HardSpring, n), [s.x], [s.constant]);
}

fn pushed(s: &mut Bench, n: Calls) {
    s.scene.force("e", Counted(Pushed, n), [s.x], [s.drive], [s.constant]);
}

fn pushed_bound(s: &mut Bench, n: Calls) {
    s.scene.force("e", Counted(Pushed, n), [s.x], [s.drive], [s.bound.into()]);
}

fn pushed_askew(s: &mut Bench, n: Calls) {
    s.scene.force("e", Counted(PushedAskew, n), [s.x], [s.drive], [s.constant]);
}

fn shaken(s: &mut Bench, n: Calls) {
    s.scene.force("e", Counted(Shaken, n), [s.x], [], [s.constant]);
}

fn geared(s: &mut Bench, n: Calls) {
    s.scene.constraint("e", Counted(Geared, n), [s.x, s.y], [s.constant]);
}

fn waved(s: &mut Bench, n: Calls) {
    s.scene.constraint("e", Counted(Waved, n), [s.x, s.y], [s.constant]);
}

fn waved_bound(s: &mut Bench, n: Calls) {
    s.scene.constraint("e", Counted(Waved, n), [s.x, s.y], [s.bound.into()]);
}

fn bent(s: &mut Bench, n: Calls) {
    s.scene.constraint("e", Counted(Bent, n), [s.x, s.y], [s.constant]);
}

#[test]
fn a_formula_with_constant_derivatives_is_called_in_no_step_and_no_sweep() {
    for add in [kinetic, spring, pushed, geared] {
        assert_eq!((growth(add), sweep(add)), ((0, 0), 0));
    }
}

#[test]
fn a_constraint_of_sines_and_cosines_is_called_in_no_step_and_no_sweep() {
    assert_eq!((growth(waved), sweep(waved)), ((0, 0), 0));
}

#[test]
fn a_formula_with_a_program_is_called_in_no_step_and_no_sweep() {
    for add in [growing_mass, hard_spring, bent, pushed_askew, shaken, pushed_bound, waved_bound, kinetic_bound] {
        assert_eq!((growth(add), sweep(add)), ((0, 0), 0));
    }
}

#[test]
fn restarts_and_projections_call_no_formula_with_a_program() {
    let every = Settings { rebase_every: 1, ..Settings::default() };
    for settings in [every, Settings { drift_bound: 1e-3, ..every }, Settings { drift_bound: 0.0, ..every }] {
        for add in [kinetic, spring, geared, waved, waved_bound, bent] {
            let [shorter, longer] = [20, 40].map(|steps| calls_with(&add, steps, Scene::compile, settings));
            assert_eq!(shorter, longer, "but at the start and at the end: {settings:?}");
        }
    }
}

#[test]
fn without_programs_a_formula_is_called_in_every_step_and_by_the_sweep_for_its_inputs() {
    for add in [kinetic, growing_mass, spring, hard_spring, waved, bent] {
        assert!(growth_by_dual_numbers(add).0 >= 20);
    }
    // With respect to time, to the control, and to the constant where it is bound.
    assert_eq!(growth_by_dual_numbers(shaken).1, 20);
    assert_eq!(growth_by_dual_numbers(pushed_askew).1, 2 * 20);
    assert_eq!(growth_by_dual_numbers(pushed_bound).1, 3 * 20);
}

#[test]
fn a_cost_is_called_by_dual_numbers_alone_and_where_it_counts() {
    let cost = |sum| move |s: &mut Bench, n| s.scene.cost("e", Counted(Distance, n), sum, [s.x], [], [], [s.constant]);
    for sum in [Sum::Terminal, Sum::Plain, Sum::Rectangle, Sum::Trapezoidal] {
        // A gradient asks once whether the formula is still the same.
        assert_eq!((growth(cost(sum)), sweep(cost(sum))), ((0, 0), 1));
        // For q, v, p*, its rate, v̇ and t, four at a time, at each node with a weight.
        assert_eq!(growth_by_dual_numbers(cost(sum)), (0, if sum == Sum::Terminal { 0 } else { 2 * 20 }));
    }
    let bound = |s: &mut Bench, n| {
        s.scene.cost("e", Counted(Distance, n), Sum::Terminal, [s.x], [], [], [s.bound.into()]);
    };
    assert_eq!(calls_of(&bound, 20, Scene::compile_without_programs).1, 1 + 2);
}

/// Q = −q³; it keeps the size of the largest numbers that it is called with.
struct Weighed(Calls);
impl Force<1> for Weighed {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> Vector1<S> {
        self.0.0.fetch_max(size_of::<S>(), Ordering::Relaxed);
        Vector1::new(-at.q[0].powi(3))
    }
}

#[test]
fn tangents_call_formulas_on_numbers_with_one_derivative() {
    let (mut scene, largest) = (Scene::new(), Calls::default());
    let [x] = scene.coordinates("mass", ["x"]);
    scene.kinetic_energy("mass", Mass, [x], [2.0.into()]);
    scene.force("spring", Weighed(largest.clone()), [x], [], []);
    let system = scene.compile().expect("scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    let mut solver = LiftedSolver::<Dual64>::new(&system, &inputs, Settings::default()).expect("motion");
    largest.take();
    solver.simulate(&inputs.lift()).expect("tangent");
    // A value, its derivative, and whether there is one, as processors align them.
    assert!((size_of::<[f64; 2]>()..=size_of::<[f64; 3]>()).contains(&largest.take()));
}

/// q̈, and q.
struct Acceleration;
impl Cost<1> for Acceleration {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v_dot[0]
    }
}
struct Place;
impl Cost<1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

/// A mass that is pushed askew against a spring of a free stiffness, with outputs on its acceleration after so many steps, and on its place after others.
fn measured(accelerations: RangeInclusive<usize>, places: RangeInclusive<usize>) -> (System, Calls, [Free; 2]) {
    let (mut scene, calls) = (Scene::new(), Calls::default());
    let [x] = scene.coordinates("mass", ["x"]);
    let (drive, stiffness) = (scene.control("drive"), scene.design("stiffness", 2.0));
    scene.kinetic_energy("mass", Counted(GrowingMass, calls.clone()), [x], [1.3.into()]);
    scene.potential_energy("spring", Counted(HardSpring, calls.clone()), [x], [stiffness.into()]);
    scene.force("drive", Counted(PushedAskew, calls.clone()), [x], [drive], [0.1.into()]);
    for node in accelerations {
        let output = scene.output(&format!("acceleration {node}"));
        scene.term(output, &format!("acceleration {node}"), Acceleration, Sum::Node(node), [x], [], [], []);
    }
    for node in places {
        let output = scene.output(&format!("place {node}"));
        scene.term(output, &format!("place {node}"), Place, Sum::Node(node), [x], [], [], []);
    }
    (scene.compile().expect("a scene"), calls, [Free::control(drive), Free::design(stiffness)])
}

/// 20 steps of a mass that is pushed.
fn pushed_inputs(system: &System) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(20, 0.01));
    inputs.controls.fill(0.3);
    inputs
}

#[test]
fn push_forwards_call_formulas_as_often_for_many_outputs_on_accelerations_as_for_one() {
    let calls_for = |nodes: RangeInclusive<usize>| {
        let (system, calls, _) = measured(nodes, 20..=20);
        let inputs = pushed_inputs(&system);
        let mut direction = inputs.no_change();
        direction.controls.fill(1.0);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        let first = solver.push_forward(&direction).expect("changes");
        calls.take();
        assert_eq!(solver.push_forward(&direction), Ok(first.clone()));
        let count = calls.take();
        // The plain formulas, on dual numbers, change alike.
        let mut lifted = inputs.lift::<Dual64>();
        lifted.controls.iter_mut().for_each(|u| u.eps = 1.0);
        let mut plain = LiftedSolver::<Dual64>::new(&system, &inputs, Settings::default()).expect("a motion");
        plain.simulate(&lifted).expect("the same motion");
        let plain = plain.outputs().expect("outputs").map(|output| output.eps);
        assert!((&plain - &first).amax() < 1e-12 * plain.amax(), "{first} {plain}");
        count
    };
    assert_eq!(calls_for(1..=1), calls_for(1..=20));
}

/// How many sweeps a Jacobian of all outputs takes.
fn sweeps(system: &System, of: Vec<Free>) -> usize {
    let inputs = pushed_inputs(system);
    let variables = Variables::new(system, &inputs, of).expect("variables");
    let mut problem = MotionProblem::new(system, Settings::default(), inputs, variables).expect("a problem");
    let (start, options) = (problem.start(), Options { iterations: 0, ..Options::default() });
    let fit = levenberg_marquardt(&mut problem, &start, &options, &mut |_, _| ControlFlow::Continue(()));
    fit.expect("a fit").outcome.gradients
}

#[test]
fn a_jacobian_is_made_of_rows_or_columns_whichever_take_less_work() {
    let (system, _, [drive, stiffness]) = measured(1..=20, 17..=20);
    // 24 rows beside 21 columns: rows go back from their nodes, columns need all accelerations.
    assert_eq!(sweeps(&system, vec![drive]), 24);
    assert_eq!(sweeps(&system, vec![stiffness]), 1);
}
