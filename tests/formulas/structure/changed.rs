//! Formulas that read something besides their arguments: what changes after a scene has been compiled is taken over, or refused by name.

use super::*;
use hamiltonian_adjoint::{Grid, Solver};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A number that formulas share with a test.
#[derive(Clone, Default)]
struct Cell(Arc<AtomicU64>);

impl Cell {
    fn set(&self, value: f64) {
        self.0.store(value.to_bits(), Ordering::Relaxed);
    }
    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// V = c sin²x + ½ d x².
struct Hills(Cell, Cell);
impl PotentialEnergy<1> for Hills {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> S {
        q[0].sin().powi(2) * self.0.get() + q[0] * q[0] * self.1.get() * 0.5
    }
}

/// V = ½ c (x − y)².
struct Spring(Cell);
impl PotentialEnergy<2> for Spring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> S {
        (q[0] - q[1]).powi(2) * self.0.get() * 0.5
    }
}

/// J = x² + c v².
struct Energy(Cell);
impl Cost<1> for Energy {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] * at.q[0] + at.v[0] * at.v[0] * self.0.get()
    }
}

/// V = ½ (1 + cos c) x² by c = 3 and by looking at x.
struct Looking(Cell);
impl PotentialEnergy<1> for Looking {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> S {
        if self.0.get() > 0.0 && q[0].re() > 0.3 { q[0] * q[0] * q[0] } else { q[0] * q[0] }
    }
}

/// V = x max(x, c) + min(x, c) + |c x|.
struct Limits(Cell);
impl PotentialEnergy<1> for Limits {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> S {
        let c = S::from(self.0.get());
        q[0] * q[0].max(c) + q[0].min(c) + (q[0] * c).abs()
    }
}

fn masses(add: impl FnOnce(&mut Scene, [hamiltonian_adjoint::Coordinate; 2])) -> hamiltonian_adjoint::System {
    let mut scene = Scene::new();
    let ([x], [y]) = (scene.coordinates("a", ["x"]), scene.coordinates("b", ["y"]));
    scene.kinetic_energy("mx", Mass, [x], [1.0.into()]);
    scene.kinetic_energy("my", Mass, [y], [2.0.into()]);
    scene.cost("squares", Squares, Sum::Terminal, [x, y], [], [], []);
    add(&mut scene, [x, y]);
    scene.compile().expect("a scene")
}

fn inputs(system: &hamiltonian_adjoint::System) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(20, 0.05));
    inputs.start.q_mut()[0] = 0.7;
    inputs
}

#[track_caller]
fn assert_refused(solver: &mut Solver, inputs: &Inputs, name: &str) {
    let error = solver.simulate(inputs).expect_err("another formula");
    assert_eq!(error, Error::Changed { element: name.into() });
    assert!(error.to_string().contains(name), "{error}");
}

#[test]
fn a_constant_that_changes_but_not_what_it_means_is_taken_over_by_the_next_run() {
    let (c, d) = (Cell::default(), Cell::default());
    c.set(2.0);
    d.set(1.0);
    let system = masses(|scene, [x, _]| scene.potential_energy("hills", Hills(c.clone(), d.clone()), [x], []));
    let spring = Cell::default();
    spring.set(1.5);
    let linear = masses(|scene, q| scene.potential_energy("spring", Spring(spring.clone()), q, []));
    let (mut of_hills, mut of_spring) =
        (Solver::new(&system, Settings::default()), Solver::new(&linear, Settings::default()));
    let values = |solvers: [&mut Solver; 2]| {
        let all = inputs(&system);
        solvers.map(|solver| {
            solver.simulate(&all).expect("a motion");
            solver.gradient().expect("a gradient").clone()
        })
    };
    let before = values([&mut of_hills, &mut of_spring]);
    c.set(3.0);
    d.set(0.5);
    spring.set(4.0);
    let after = values([&mut of_hills, &mut of_spring]);
    let fresh = values([&mut Solver::new(&system, Settings::default()), &mut Solver::new(&linear, Settings::default())]);
    for ((before, after), fresh) in before.iter().zip(&after).zip(&fresh) {
        assert_eq!(after, fresh);
        assert!(distance(before, after) > 1e-3);
    }
}

#[test]
fn limits_that_change_are_taken_over_too() {
    let c = Cell::default();
    c.set(0.3);
    let make = || masses(|scene, [x, _]| scene.potential_energy("limits", Limits(c.clone()), [x], []));
    let system = make();
    let all = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    let before = solver.simulate(&all).expect("a motion").clone();
    c.set(1.8);
    let after = solver.simulate(&all).expect("a motion").clone();
    assert_eq!(after, *Solver::new(&make(), Settings::default()).simulate(&all).expect("a motion"));
    assert!((&after.q - &before.q).amax() > 1e-2);
}

#[test]
fn a_formula_that_is_another_one_than_was_compiled_is_refused_by_name() {
    let (c, d) = (Cell::default(), Cell::default());
    d.set(1.0);
    let system = masses(|scene, [x, _]| scene.potential_energy("hills", Hills(c.clone(), d), [x], []));
    let all = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    let before = solver.simulate(&all).expect("a motion").clone();
    c.set(5.0);
    assert_refused(&mut solver, &all, "hills");
    assert_refused(&mut Solver::new(&system, Settings::default()), &all, "hills");
    c.set(0.0);
    assert_eq!(*solver.simulate(&all).expect("the same formula again"), before);
}

#[test]
fn an_entry_that_has_no_place_is_refused_by_name() {
    let c = Cell::default();
    let system = masses(|scene, q| scene.potential_energy("spring", Spring(c.clone()), q, []));
    let all = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&all).expect("a motion");
    c.set(5.0);
    assert_refused(&mut solver, &all, "spring");
}

#[test]
fn a_cost_that_depends_on_more_than_when_it_was_compiled_is_refused_by_name() {
    let c = Cell::default();
    let system = masses(|scene, [x, _]| scene.cost("energy", Energy(c.clone()), Sum::Terminal, [x], [], [], []));
    let all = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&all).expect("a motion");
    c.set(5.0);
    assert_refused(&mut solver, &all, "energy");
}

#[test]
fn a_formula_that_begins_to_look_at_values_is_refused_by_name() {
    let c = Cell::default();
    let system = masses(|scene, [x, _]| scene.potential_energy("looking", Looking(c.clone()), [x], []));
    let all = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&all).expect("a motion");
    c.set(1.0);
    assert_refused(&mut solver, &all, "looking");
}

/// J = x², or with c ≠ 0 the square of the acceleration.
struct Other(Cell);
impl Cost<1> for Other {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        if self.0.get() == 0.0 { at.q[0] * at.q[0] } else { at.v_dot[0] * at.v_dot[0] }
    }
}

/// Without programs, too: what it depends on was read off its formula, and accelerations are not computed where they are not needed.
#[test]
fn a_cost_without_a_program_that_depends_on_more_is_refused_by_name() {
    let c = Cell::default();
    let mut scene = Scene::new();
    let [x] = scene.coordinates("a", ["x"]);
    scene.kinetic_energy("mx", Mass, [x], [1.0.into()]);
    scene.cost("other", Other(c.clone()), Sum::Integral, [x], [], [], []);
    let system = scene.compile_without_programs().expect("a scene");
    let all = inputs(&system);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&all).expect("a motion");
    c.set(1.0);
    let changed = || Error::Changed { element: "other".into() };
    assert_eq!(solver.gradient().expect_err("a motion without accelerations"), changed());
    assert_eq!(solver.cost().expect_err("no accelerations"), changed());
    assert_eq!(solver.outputs().expect_err("no accelerations"), changed());
    assert_eq!(solver.push_forward(&all.no_change()).expect_err("no accelerations"), changed());
    assert_eq!(solver.hessian_product(&all.no_change()).expect_err("no accelerations"), changed());
    assert_refused(&mut solver, &all, "other");
}

/// J, its gradient and its Hessian are those of the cost as it is when they are asked for.
#[test]
fn costs_that_change_between_a_motion_and_its_gradient_are_taken_over() {
    let c = Cell::default();
    c.set(1.0);
    let make = || masses(|scene, [x, _]| scene.cost("energy", Energy(c.clone()), Sum::Integral, [x], [], [], []));
    let system = make();
    let all = inputs(&system);
    let mut along = all.no_change();
    along.start.rate_mut().fill(1.0);
    let results = |solver: &mut Solver| {
        let j = solver.cost().expect("J");
        let gradient = solver.gradient().expect("a gradient").clone();
        assert!((gradient.value - j).abs() <= 1e-14 * j.abs(), "{} {j}", gradient.value);
        (gradient, solver.hessian_product(&along).expect("a product").clone())
    };
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&all).expect("a motion");
    for value in [1.0, 100.0, 1.0] {
        c.set(value);
        let mut fresh = Solver::new(&system, Settings::default());
        fresh.simulate(&all).expect("a motion");
        assert_eq!(results(&mut solver), results(&mut fresh), "{value}");
    }
}
