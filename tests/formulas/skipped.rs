//! What recorded formulas say is constant, linear, sinusoidal or absent is so: whole motions and gradients against the plain formulas, of which nothing
//! is skipped, and against dual numbers at every point.

use crate::files;
use crate::scenes::pieces::Piece;
use crate::scenes::strings::{Order, string};
use crate::scenes::{elements, formulas, pairs, pieces, points, ready_parts, structures};
use hamiltonian_adjoint::check::{Input, tangent};
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Error, Force, ForcePoint, Grid, Inputs, KineticEnergy, LiftedSolver, PotentialEnergy,
    Scalar, Scene, Settings, Sum, gradient,
};
use nalgebra::{DMatrix, SVector};
use num_dual::Dual64;

/// A sum of formulas that a recording might take for less than they are.
struct Traps;

impl PotentialEnergy<3> for Traps {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 3>, _b: &SVector<S, 0>, t: S) -> S {
        let [x, y, z] = [q[0], q[1], q[2]];
        let terms = [
            (x - y) * (x + y) - x * x + y * z,
            x.powi(3) - x * x * x,
            (x * 2.0).sin() + (x - 0.3).sin() * (-y).cos(),
            (x + y * y * 0.0).cos() + z,
            (x * x + 1.0).sqrt() * z,
            y / (z * z + 1.0) + x.tanh(),
            (x.exp() * y).atan() - t * t,
            y.atan2(z * z + 1.0) + t * x,
            (x.hypot(y + 5.0)).ln_1p() * z,
            (x - 0.25).abs() * y + x.max(z) * 0.5 - (y - z).min(x * x),
        ];
        terms.into_iter().sum()
    }
}

/// Takes one of two formulas by a sign.
struct Kink;

impl Force<1> for Kink {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        let v = at.v[0];
        SVector::from([if v.re() > 0.0 { -v } else { -v * v * 0.5 }])
    }
}

/// ½ v².
struct Heavy;

impl KineticEnergy<1> for Heavy {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// Σ x².
struct Squares;

impl Cost<3> for Squares {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q.dot(&at.q)
    }
}

/// The largest difference in SI units, relative to the largest number where that is above 1.
fn difference(plain: &DMatrix<Dual64>, ours: &DMatrix<f64>) -> f64 {
    let worst = plain.iter().zip(ours.iter()).fold(0.0f64, |worst, (a, b)| worst.max((a.re - b).abs()));
    worst / ours.iter().fold(1.0f64, |size, x| size.max(x.abs()))
}

/// Asserts that a scene is the same after it was written and read.
fn assert_comes_back(name: &str, scene: &Scene, dt: f64) {
    files::compared(name, scene, &|_, system| {
        let mut inputs = Inputs::at_rest(system, Grid::uniform(8, dt));
        inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 1.0 + (i as f64).sin());
        inputs
    });
}

/// A motion and a gradient of the compiled scene against the plain formulas.
fn against_plain(name: &str, scene: Scene) {
    assert_comes_back(name, &scene, 0.01);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.01));
    for (i, u) in inputs.controls.iter_mut().enumerate() {
        *u = 1.0 + (i as f64).sin();
    }
    let settings = Settings::default();
    let mut plain = LiftedSolver::<Dual64>::new(&system, &inputs, settings).expect("a motion");
    let motion = plain.simulate(&inputs.lift()).expect("the same motion").clone();
    let ours = plain.real().trajectory();
    let differences = [
        ("q", difference(&motion.q, &ours.q)),
        ("v", difference(&motion.v, &ours.v)),
        ("p*", difference(&motion.p_star, &ours.p_star)),
        ("dp*/dt", difference(&motion.p_star_dot, &ours.p_star_dot)),
        ("sigma", difference(&motion.sigma, &ours.sigma)),
    ];
    // Where constraints depend on each other, σ is rounding but for what Φ_qᵀσ, and so p*, has of it.
    let determined = if ours.compliance.is_empty() { &differences[..] } else { &differences[..4] };
    for (what, difference) in determined {
        assert!(*difference <= 1e-11, "{name}: {what} differs by {difference:.1e}");
    }

    let ours = gradient(&system, &inputs, settings).expect("a gradient");
    let mut some = vec![Input::Step(7), Input::Step(20)];
    some.extend((0..system.k()).flat_map(|channel| [0, 9, 20].map(|node| Input::Control { channel, node })));
    some.extend((0..system.designs()).map(Input::Design));
    some.extend((0..system.n().min(6)).map(Input::Coordinate));
    let size = Input::all(&inputs).iter().fold(0.0f64, |size, input| size.max(input.in_gradient(&ours).abs()));
    for input in some {
        let ours = input.in_gradient(&ours);
        let what = format!("{name}: {}", input.name(&system));
        let plain = tangent(&system, &inputs, settings, &[input]).unwrap_or_else(|error| panic!("{what}: {error}"))[0];
        assert!((ours - plain).abs() <= 1e-10 * size, "{what}: {ours} and {plain}");
    }
}

fn all_elements() -> impl Iterator<Item = (&'static str, Scene)> {
    elements::all().into_iter().chain(ready_parts::all())
}

#[test]
fn every_kind_of_element_moves_as_its_plain_formula() {
    for (name, scene) in all_elements() {
        against_plain(name, scene);
    }
}

#[test]
fn scenes_with_and_without_each_thing_move_as_their_plain_formulas() {
    for comparison in pairs::all() {
        for (name, scene) in comparison.rows {
            against_plain(&format!("{}: {name}", comparison.thing), scene);
        }
    }
}

#[test]
fn points_that_are_tied_together_move_as_their_plain_formulas() {
    points::all().into_iter().for_each(|(name, scene)| against_plain(&name, scene));
}

#[test]
fn chains_trees_and_ladders_move_as_their_plain_formulas() {
    against_plain("chain", structures::chain(30));
    against_plain("tree", structures::binary_tree(5));
    against_plain("ladder", structures::ladder(10));
    against_plain("doubled hinges", structures::string(5, 2));
    against_plain("open ladder", structures::open_ladder(10));
}

/// The gradient of a scene compiled to programs against that of the same scene with dual numbers at every point.
fn against_dual_numbers(name: &str, scenes: [Scene; 2], dt: f64) {
    let [with, without] = scenes;
    assert_comes_back(name, &with, dt);
    let systems = [with.compile().expect("a scene"), without.compile_without_programs().expect("a scene")];
    assert!(systems[0].without_programs().count() <= 1 && systems[1].without_programs().count() > 0, "{name}");
    let projected = Settings { drift_bound: 0.0, ..Settings::default() };
    for settings in [Settings::default(), projected] {
        let [ours, plain] = systems.each_ref().map(|system| {
            let mut inputs = Inputs::at_rest(system, Grid::uniform(20, dt));
            inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 1.0 + (i as f64).sin());
            let gradient = gradient(system, &inputs, settings).map_err(|error: Error| error.to_string())?;
            let inputs = Input::all(&inputs);
            let slopes = inputs.iter().map(|input| input.in_gradient(&gradient));
            Ok::<Vec<f64>, String>(slopes.chain([gradient.value]).collect())
        });
        if settings != projected {
            assert!(ours.is_ok(), "{name}: {ours:?}");
        }
        let (Ok(ours), Ok(plain)) = (&ours, &plain) else {
            assert_eq!(ours, plain, "{name}");
            continue;
        };
        let size = plain.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        for (ours, plain) in ours.iter().zip(plain) {
            assert!((ours - plain).abs() <= 1e-10 * size, "{name}: {ours} and {plain}");
        }
    }
}

#[test]
fn programs_give_the_gradient_that_dual_numbers_give() {
    for ((name, scene), (_, again)) in all_elements().zip(all_elements()) {
        against_dual_numbers(name, [scene, again], 0.01);
    }
    for (comparison, again) in pairs::all().into_iter().zip(pairs::all()) {
        for ((name, scene), (_, again)) in comparison.rows.into_iter().zip(again.rows) {
            against_dual_numbers(&format!("{}: {name}", comparison.thing), [scene, again], 0.01);
        }
    }
    for ((name, scene, dt), (_, again, _)) in formulas::all().into_iter().zip(formulas::all()) {
        against_dual_numbers(name, [scene, again], dt);
    }
    for ((name, scene), (_, again)) in points::all().into_iter().zip(points::all()) {
        against_dual_numbers(&name, [scene, again], 0.01);
    }
    against_dual_numbers("chain", [(); 2].map(|()| structures::chain(30)), 0.01);
    against_dual_numbers("tree", [(); 2].map(|()| structures::binary_tree(5)), 0.01);
    against_dual_numbers("ladder", [(); 2].map(|()| structures::ladder(10)), 0.01);
}

#[test]
fn formulas_that_are_less_than_they_seem_move_as_their_plain_formulas() {
    let scene = || {
        let mut scene = Scene::new();
        let q = scene.coordinates("traps", ["x", "y", "z"]);
        for (k, q) in q.into_iter().enumerate() {
            scene.place(q, 0.2 + 0.1 * k as f64);
            scene.kinetic_energy(&format!("mass {k}"), Heavy, [q], []);
        }
        scene.potential_energy("traps", Traps, q, []);
        scene.force("kink", Kink, [q[1]], [], []);
        scene.cost("squares", Squares, Sum::Integral, q, [], [], []);
        scene
    };
    let compiled = scene().compile().expect("a scene");
    assert!(
        compiled.without_programs().eq([("kink", "its formula depends on a plain value (`re()`, a comparison, a branch)")])
    );
    assert!(compiled.program("traps").expect("an element").contains("second derivatives of `traps`"));
    against_plain("traps", scene());
    against_dual_numbers("traps", [scene(), scene()], 0.01);
}

/// c + gᵀx + ½ xᵀA x in the coordinates and velocities, or with a cube, which is no quadratic form.
struct Form(bool);

impl Cost<7> for Form {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 7, 0, 0>, _b: &SVector<S, 0>) -> S {
        let mut sum = S::from(0.7);
        for i in 0..7 {
            let row: S = (0..7).map(|j| at.q[j] * f64::from(7 * i + 3 * j as i32).sin() + at.v[j] * 0.1).sum();
            sum += at.q[i as usize] * row * 0.5 + at.v[i as usize] * f64::from(i) * 0.2;
        }
        if self.0 { sum + at.q[3].powi(3) } else { sum }
    }
}

fn seven_masses() -> (Scene, [Coordinate; 7]) {
    let mut scene = Scene::new();
    let q = scene.coordinates("seven", ["a", "b", "c", "d", "e", "f", "g"]);
    for (k, q) in q.into_iter().enumerate() {
        scene.place(q, 0.3 - 0.1 * k as f64);
        scene.kinetic_energy(&format!("mass {k}"), Heavy, [q], []);
    }
    (scene, q)
}

#[test]
fn quadratic_forms_of_many_arguments_are_what_dual_numbers_make_of_them() {
    for (cubic, sum) in [(false, Sum::Terminal), (false, Sum::Trapezoidal), (false, Sum::Integral), (true, Sum::Trapezoidal)]
    {
        let scene = || {
            let (mut scene, q) = seven_masses();
            scene.potential_energy("traps", Traps, [q[0], q[1], q[2]], []);
            scene.cost("form", Form(cubic), sum, q, [], [], []);
            scene
        };
        against_plain("form", scene());
        against_dual_numbers("form", [scene(), scene()], 0.01);
    }
}

/// ½ (x y + c p*_x − b)² + (dp*_y/dt + u̇ t) v_x.
struct Near;

impl Cost<2, 0, 1, 2> for Near {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 1>, b: &SVector<S, 2>) -> S {
        let miss = at.q[0] * at.q[1] + b[1] * at.p_star[0] - b[0];
        miss * miss * 0.5 + (at.p_star_dot[1] + at.u_dot[0] * at.t) * at.v[0]
    }
}

/// Costs with one program are evaluated side by side if they are summed alike.
#[test]
fn like_costs_may_be_any_number_and_summed_in_any_way() {
    let sums = [Sum::Trapezoidal, Sum::Integral, Sum::AllNodes, Sum::Node(7), Sum::Terminal];
    for count in [1, 2, 5, 9, 14, 17, 30] {
        for ways in [1, 5] {
            let scene = || {
                let (mut scene, q) = seven_masses();
                let (u, b) = (scene.control("u"), scene.design("b", 0.4));
                scene.potential_energy("traps", Traps, [q[0], q[1], q[2]], []);
                scene.force("diagonal", Steps, [q[0], q[1]], [u], []);
                for k in 0..count {
                    let b = [b * (1.0 + 0.37 * k as f64), (0.11 * k as f64).into()];
                    scene.cost(&format!("near {k}"), Near, sums[k % ways], [q[k % 7], q[(3 * k + 1) % 7]], [], [u], b);
                }
                scene
            };
            let name = format!("{count} costs summed in {ways} ways");
            against_plain(&name, scene());
            against_dual_numbers(&name, [scene(), scene()], 0.01);
        }
    }
}

/// Angles of points on an axis and on a diagonal, which step, and of which no derivative shows anything.
struct Steps;

impl Force<2, 1> for Steps {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, _b: &SVector<S, 0>) -> SVector<S, 2> {
        SVector::from([at.u[0].atan2(at.u[0]), at.q[0].atan2(S::zero())])
    }
}

impl PotentialEnergy<2> for Steps {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> S {
        S::zero().atan2(q[0]) * q[1]
    }
}

impl Cost<7> for Steps {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 7, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q.dot(&at.q) + at.q[6].atan2(at.q[6])
    }
}

#[test]
fn angles_that_step_are_not_taken_for_constants() {
    let scene = || {
        let (mut scene, q) = seven_masses();
        let u = scene.control("u");
        scene.force("diagonal", Steps, [q[0], q[1]], [u], []);
        scene.potential_energy("axis", Steps, [q[5], q[2]], []);
        scene.cost("squares", Steps, Sum::Trapezoidal, q, [], [], []);
        scene
    };
    against_plain("steps", scene());
    against_dual_numbers("steps", [scene(), scene()], 0.01);
}

/// Programs run for several elements side by side, whose places in the scene they know as lists or as equal distances.
#[test]
fn like_elements_may_be_any_number_and_stand_anywhere() {
    for bodies in [2, 3, 5, 6, 8, 9, 10, 13, 14, 16, 17, 18, 22, 30, 34] {
        for order in [Order::Forwards, Order::Backwards, Order::Mixed] {
            let name = |coordinates: usize| format!("{bodies} bodies of {coordinates} coordinates, {order:?}");
            against_dual_numbers(&name(1), [(); 2].map(|()| string::<1>(bodies, order)), 0.01);
            against_dual_numbers(&name(2), [(); 2].map(|()| string::<2>(bodies, order)), 0.01);
            against_dual_numbers(&name(3), [(); 2].map(|()| string::<3>(bodies, order)), 0.01);
            against_dual_numbers(&name(4), [(); 2].map(|()| string::<4>(bodies, order)), 0.01);
        }
    }
}

#[test]
fn what_is_linear_in_pieces_is_not_taken_for_linear() {
    // Of two coordinates K is constant; but their equations are not linear, so that they are not eliminated once for all.
    let beside = pieces::scene(Piece::Beside).compile().expect("a scene");
    assert_eq!(beside.elimination().iter().map(|[size, _]| size).sum::<usize>(), 3);
    for piece in Piece::ALL {
        // A single dual number takes 0 · ∞ for the slope of a root that is cut off.
        if !matches!(piece, Piece::Root) {
            against_plain(&format!("{piece:?}"), pieces::scene(piece));
        }
        against_dual_numbers(&format!("{piece:?}"), [(); 2].map(|()| pieces::scene(piece)), 0.01);
    }
}
