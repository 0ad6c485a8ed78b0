//! Coordinates without kinetic energy that constraints determine, compared with scenes in which they are eliminated by hand.

use crate::common::bench::{from_velocity, lively};
use crate::common::{assert_gradient_is_exact_with, assert_says, largest_difference};
use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, LongSolver, Scalar,
    Scene, Scheme, Settings, Solver, Start, Sum, System, check, gradient, simulate,
};
use nalgebra::SVector;

/// ½ b v².
struct Inertia;
impl KineticEnergy<1, 1> for Inertia {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        v[0] * v[0] * b[0] * 0.5
    }
}

/// A spring and a force u along a function f(q; r) of this name: Q = (u − 4 f) ∂f/∂q.
struct Along(&'static str);
impl<const N: usize> Force<N, 1, 1> for Along {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, N, 1>, b: &SVector<S, 1>) -> SVector<S, N> {
        let (q, last, r, one) = (at.q[0], at.q[N - 1], b[0], S::from(1.0));
        let (f, slope) = match self.0 {
            "own" => (q, [one, one]),
            "cos" => (r * q.cos(), [-r * q.sin(), one]),
            "sin" => (r * q.sin(), [r * q.cos(), one]),
            "twice" => (r * (r * q.cos()).sin(), [-r * r * q.sin() * (r * q.cos()).cos(), one]),
            "span" => (r * (last.cos() - q.cos() + 2.0), [r * q.sin(), -r * last.sin()]),
            _ => (last - q, [-one, one]),
        };
        SVector::from_fn(|i, _| slope[i] * (at.u[0] - f * 4.0))
    }
}

/// The first equations of some that have this name.
struct Row(&'static str);
impl<const N: usize, const M: usize> Constraint<N, M, 1> for Row {
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, 1>, _t: S) -> SVector<S, M> {
        let (x, y, angle, r) = (q[0], q[1], q[N - 1], b[0]);
        let half = r * (y.sin() - angle.sin() * 0.8);
        let phi = match self.0 {
            "cosine" => [x - r * angle.cos(), half],
            "sine" => [x - r * angle.sin(), half],
            "circle" => [x * x + y * y - r * r, half],
            "plus" => [x + y - r * (angle.cos() + angle.sin()), half],
            "minus" => [x - y - r * (angle.cos() - angle.sin()), half],
            "relative" => [(x - angle + y).sin(), half],
            "loop" => [x - r * (angle.cos() - y.cos() + 2.0), half],
            _ => [r * (x.sin() - y.sin() * 0.8), half],
        };
        SVector::from_fn(|j, _| phi[j])
    }
}

/// Depends on all arguments of a cost.
struct Everything;
impl<const M: usize> Cost<1, M, 1, 1> for Everything {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, M, 1>, b: &SVector<S, 1>) -> S {
        let sigma = at.sigma.iter().fold(S::from(0.0), |sum, sigma| sum + *sigma * (at.q[0] + *sigma));
        let momenta = at.p_star[0] * at.v[0] + at.p_star_dot[0] * at.q[0];
        (at.q[0] * (at.v[0] + at.t)).sin() * b[0] + sigma + momenta * 0.2 + at.u[0] * (at.u[0] + at.v[0])
    }
}

/// A slider declared after or before its crank; two light coordinates in one group or two, determined by two constraints together; the relative
/// angle of two bodies; a length in a closed loop; a light coordinate that determines another one.
const KINDS: [&str; 7] = ["slider", "slider first", "pair", "apart", "angle", "loop", "train"];

/// A mechanism with its constraints given so many times, and without its light coordinates for 0 times; and its heavy coordinates. If the constraints
/// are given twice, the light coordinates have inertias, which are 0.
fn mechanism(kind: &str, times: usize) -> (System, Vec<Coordinate>) {
    let mut scene = Scene::new();
    scene.gravity(0.3, -9.81);
    let (r, j, u, none) = (scene.design("r", 0.6), scene.design("J", 0.2), scene.control("u"), scene.design("none", 0.0));
    let angles = [0.7, (0.7f64.sin() / 0.8).asin()];
    let [x, y] = [0.6 * 0.7f64.cos(), 0.6 * 0.7f64.sin()];
    let (places, by_hand): (&[f64], &[&'static str]) = match kind {
        "pair" | "apart" => (&[x, y], &["cos", "sin"]),
        "angle" => (&[0.0], &["difference"]),
        "loop" => (&[0.6 * (angles[1].cos() - angles[0].cos() + 2.0)], &["span"]),
        "train" => (&[0.6 * x.sin(), x], &["twice", "cos"]),
        _ => (&[x], &["cos"]),
    };
    let add_light = |scene: &mut Scene| {
        let names = &["light", "lighter"][..places.len()];
        let q: Vec<Coordinate> = match kind {
            "pair" => scene.coordinates("pair", ["a", "b"]).to_vec(),
            _ => names.iter().map(|name| scene.coordinates(name, ["q"])[0]).collect(),
        };
        for ((&q, &place), name) in q.iter().zip(places).zip(names) {
            scene.place(q, place);
            scene.force(&format!("spring of {name}"), Along("own"), [q], [u], [r.into()]);
            scene.cost(name, Everything, Sum::Integral, [q], [], [u], [r.into()]);
            (1..times).for_each(|_| scene.kinetic_energy(name, Inertia, [q], [none.into()]));
        }
        q
    };
    let l = if times > 0 && kind != "slider" { add_light(&mut scene) } else { Vec::new() };
    let h = if kind == "angle" {
        let (a, b) = (scene.body("a", 0.8, j, [0.3, 0.0, 0.0]), scene.body("b", 0.5, 0.03, [1.0, 0.0, 0.0]));
        scene.revolute("elbow", a.at(0.3, 0.0), b.at(-0.4, 0.0));
        vec![a.coordinates[2], b.coordinates[2]]
    } else {
        let crank = |k: usize| {
            let [q] = scene.coordinates(&format!("crank {k}"), ["q"]);
            scene.place(q, angles[k]);
            scene.kinetic_energy(&format!("inertia {k}"), Inertia, [q], [j.into()]);
            q
        };
        (0..if kind == "loop" { 2 } else { 1 }).map(crank).collect()
    };
    let l = if times > 0 && kind == "slider" { add_light(&mut scene) } else { l };
    let b = [r.into()];
    for (along, k) in by_hand.iter().zip(0..).filter(|_| times == 0) {
        match h[..] {
            [q] => scene.force(&format!("spring {k}"), Along(along), [q], [u], b),
            _ => scene.force(&format!("spring {k}"), Along(along), [h[0], h[1]], [u], b),
        }
    }
    if times == 0 && kind == "loop" {
        let [_] = scene.constraint("loop", Row("closed"), [h[0], h[1]], b);
    }
    for time in 0..times {
        let [one, two] = ["first", "second"].map(|name| format!("{name} {time}"));
        match kind {
            "pair" => [_] = scene.constraint(&one, Row("circle"), [l[0], l[1]], b),
            "apart" => [_] = scene.constraint(&one, Row("minus"), [l[0], l[1], h[0]], b),
            "train" => [_] = scene.constraint(&one, Row("sine"), [l[0], l[1]], b),
            _ => {}
        }
        let sigma = match kind {
            "apart" => scene.constraint(&two, Row("plus"), [l[0], l[1], h[0]], b),
            "angle" => scene.constraint(&two, Row("relative"), [l[0], h[0], h[1]], b),
            "loop" => [scene.constraint::<_, 3, 2, 1>(&two, Row("loop"), [l[0], h[0], h[1]], b)[0]],
            _ => scene.constraint(&two, Row("cosine"), [l[usize::from(kind == "train")], h[0]], b),
        };
        (times..2).for_each(|_| scene.cost("reaction", Everything, Sum::Trapezoidal, [h[0]], sigma, [u], b));
    }
    (scene.compile().unwrap_or_else(|error| panic!("{kind}: {error}")), h)
}

#[test]
fn motions_are_those_of_the_heavy_coordinates_alone() {
    let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
    for kind in KINDS {
        let [alone, once, twice] = [0, 1, 2].map(|times| {
            let (system, heavy) = mechanism(kind, times);
            let mut inputs = Inputs::at_rest(&system, Grid::uniform(200, 0.0025));
            inputs.controls.fill(0.7);
            let motion = simulate(&system, &inputs, settings).unwrap_or_else(|error| panic!("{kind}: {error}"));
            Vec::from_iter(heavy.iter().map(|q| motion.q[(q.index(), 200)]))
        });
        let error = largest_difference(&once, &alone).max(largest_difference(&twice, &alone));
        assert!(error < 1e-11, "{kind}: {error:e}");
    }
}

#[test]
fn derivatives_are_exact_also_if_every_constraint_is_there_twice() {
    for (kind, times) in KINDS.into_iter().flat_map(|kind| [(kind, 1), (kind, 2)]) {
        let ((system, heavy), plain) = (mechanism(kind, times), Settings::default());
        let given = lively(&system, 6, 0.02);
        let held = Inputs { start: Start::assembled(&system).hold(&heavy[..1]), ..given.clone() };
        for inputs in [&given, &from_velocity(&system, &given), &held] {
            let restarted = Scheme::ALL.map(|scheme| Settings { scheme, rebase_every: 1, ..plain });
            for settings in [plain, Settings { drift_bound: 0.0, ..plain }].into_iter().chain(restarted) {
                assert_gradient_is_exact_with(&format!("{kind}, {times}"), &system, inputs, settings);
            }
        }
        check::hessian(&system, &given, plain).run().expect("a report").assert_passed();
        let expected = gradient(&system, &given, plain).expect("a gradient");
        assert!(*LongSolver::new(&system, plain, 30_000).gradient(&given).expect("a gradient") == expected, "{kind}");
    }
}

#[test]
fn short_steps_lose_no_digits() {
    for (kind, k) in KINDS.into_iter().flat_map(|kind| (2..12).map(move |k| (kind, k))) {
        let (system, _) = mechanism(kind, 1);
        let (mut solver, inputs) = (Solver::new(&system, Settings::default()), lively(&system, 8, 0.1f64.powi(k)));
        solver.simulate(&inputs).expect("a motion");
        assert!(solver.report().worst_pivot > 1e-4, "{kind}, {k}: {:e}", solver.report().worst_pivot);
        assert_gradient_is_exact_with(&format!("{kind}, steps of 1e-{k} s"), &system, &inputs, Settings::default());
    }
}

#[test]
fn light_coordinates_that_constraints_leave_free_are_named() {
    let mut scene = Scene::new();
    let [[x], [y], [q]] = ["slide", "lift", "crank"].map(|name| scene.coordinates(name, ["q"]));
    scene.place(y, 0.6);
    scene.kinetic_energy("inertia", Inertia, [q], [0.2.into()]);
    let [_] = scene.constraint("plus", Row("plus"), [x, y, q], [0.6.into()]);
    let system = scene.compile().expect("a scene");
    let inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.01));
    let error =
        simulate(&system, &inputs, Settings::default()).map(drop).expect_err("an equation for two coordinates").error;
    assert!(matches!(&error, Error::SingularMass { coordinates, .. } if coordinates.len() == 2), "{error:?}");
    assert_says(&error, &["`slide.q`", "`lift.q`", "neither inertia nor a joint that determines them"]);
}
