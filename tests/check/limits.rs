//! Checks at their limits: settings that tell nothing, formulas with kinks and ends, values, bumps beside a given point, names.

use crate::hand::*;
use hamiltonian_adjoint::check::{self, Function, Input, Mistake, Part, Verdict};
use hamiltonian_adjoint::paper_system::Equation::{F3, F4, F5};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{Q, V};
use hamiltonian_adjoint::planar::Revolute;
use hamiltonian_adjoint::{
    Error, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Start, Sum, gradient,
    scenes::CartPendulum, simulate,
};
use nalgebra::{DMatrix, DVector, SVector};

struct Square;
impl PotentialEnergy<1> for Square {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _: &SVector<S, 0>, _: S) -> S {
        q[0] * q[0]
    }
}

/// A function of one input.
struct One<F>(#[allow(dead_code)] F);
macro_rules! one {
    ($name:ident, $x:ident, $value:expr) => {
        struct $name;
        impl Function for One<$name> {
            fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
                let $x = x[0];
                vec![$value]
            }
        }
    };
}
/// f = (a b, a sin c, 10⁻¹² d², 10¹² b + a).
struct Steep;
impl Function for Steep {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x[0] * x[1], x[2].sin() * x[0], x[3] * x[3] * 1e-12, x[1] * 1e12 + x[0]]
    }
}

#[test]
fn an_order_that_is_the_given_one_is_no_other() {
    let hand = |x: &[f64]| {
        let of_q = [x[2].sin(), 1e-9, x[2].cos() * x[0], 0.0];
        [[x[1], x[0], 0.0, 0.0], of_q, [0.0, 0.0, 0.0, 2e-12 * x[3]], [1.0, 1e12, 0.0, 0.0]]
    };
    let report = check::function(&Steep, ["a", "b", "c", "d"], ["p", "q", "r", "s"]).jacobian(hand).run();
    println!("{report}");
    assert_eq!(report.verdict(), Verdict::Wrong);
    assert!(!report.to_string().contains("order"));
}

/// f = (a b + sin c, a² c + b², eᵃ b + c³).
struct Dense;
impl Function for Dense {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let [a, b, c] = [x[0], x[1], x[2]];
        vec![a * b + c.sin(), a * a * c + b * b, a.exp() * b + c.powi(3)]
    }
}

#[test]
fn right_values_in_wrong_rows_and_columns_are_told_by_their_names() {
    let jacobian = |x: &[f64]| {
        let [a, b, c] = [x[0], x[1], x[2]];
        [[b, a, c.cos()], [2.0 * a * c, 2.0 * b, a * a], [a.exp() * b, a.exp(), 3.0 * c * c]]
    };
    // Where the value of entry (i, j) is taken from.
    type From = fn(usize, usize) -> (usize, usize);
    let cases: [(From, &str); 6] = [
        (|i, j| ([1, 0, 2][i], j), "the rows of `p` and `q` are exchanged"),
        (|i, j| (i, [0, 2, 1][j]), "the columns of `b` and `c` are exchanged"),
        (|i, j| ([1, 2, 0][i], j), "the rows are in another order: they belong to `q`, `r`, `p`"),
        (|i, j| (i, [2, 0, 1][j]), "the columns are in another order: they belong to `c`, `a`, `b`"),
        (|i, j| ([2, 1, 2][i], j), "the values of the row of `r` are in the row of `p`"),
        (|i, j| (i, [0, 1, 0][j]), "the values of the column of `a` are in the column of `c`"),
    ];
    for (from, text) in cases {
        let hand = move |x: &[f64]| {
            let all = jacobian(x);
            DMatrix::from_fn(3, 3, |i, j| all[from(i, j).0][from(i, j).1])
        };
        let report = check::function(&Dense, ["a", "b", "c"], ["p", "q", "r"]).jacobian(hand).run();
        let [diagnosis] = &report.blocks[0].diagnoses[..] else { panic!("{report}") };
        assert_eq!((diagnosis.mistake, diagnosis.text.as_str()), (Mistake::Swapped, text));
    }
}

one!(Diode, x, (x * 20.0).exp());
one!(Bump, x, (-((x - 0.3) / 1e-4).powi(2)).exp() + x);
one!(Abs, x, x.abs());
one!(Stop, x, (x - 0.3).max(S::from(0.0)) * 1e5);
one!(Root, x, x.sqrt());
one!(Never, x, (-x * x - 1.0).sqrt());

fn verdict<F>(f: &F, at: Option<f64>, hand: impl Fn(f64) -> f64) -> check::Report
where
    F: Function,
{
    let check = check::function(f, ["x"], ["y"]);
    let check = if let Some(x) = at { check.at(&[x]) } else { check };
    let report = check.jacobian(move |x: &[f64]| [[hand(x[0])]]).run();
    println!("{report}");
    report
}

#[test]
fn a_tolerance_that_tells_nothing_is_refused() {
    let cart = CartPendulum::with_links(1).scene().compile().expect("scene");
    let inputs = Inputs::at_rest(&cart, Grid::uniform(5, 0.02));
    let motion = simulate(&cart, &inputs, Settings::default()).expect("motion");
    let paper = PaperSystem::new(&cart, &inputs, &motion).expect("complete");
    for tolerance in [f64::NAN, f64::INFINITY, -1e-9, 1.0, 1e300] {
        let element = check::potential_energy(&Square, []).tolerance(tolerance).v_q(|_| [7.0]).run();
        let step = check::step(&paper).tolerance(tolerance).f_y(F5, V, |at| at.terms().phi_q).run();
        for report in [element, step] {
            assert_eq!(report.verdict(), Verdict::Refused);
            assert!(matches!(report.refused, Some(Error::Parameter { .. })) && !report.passed(), "{report}");
        }
        let refused = check::gradient(&cart, &inputs, Settings::default()).tolerance(tolerance).run();
        assert!(matches!(refused, Err(Error::Parameter { .. })));
    }
    for size in [f64::NAN, f64::INFINITY] {
        let report = check::potential_energy(&Square, []).magnitudes(|m| m.q[0] = size).v_q(|_| [7.0]).run();
        assert!(matches!(report.refused, Some(Error::Parameter { .. })), "{report}");
    }
    let report = check::function(&One(Diode), ["x"], ["y"]).magnitudes(&[1.0, 2.0]).jacobian(|_: &[f64]| [[0.0]]).run();
    assert!(matches!(report.refused, Some(Error::Size { expected: 1, found: 2, .. })), "{report}");
}

#[test]
fn a_step_below_rounding_is_refused() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.02));
    inputs.controls.fill(1.0);
    let input = [Input::Control { channel: 0, node: 1 }];
    let by = |step| check::central_differences(&system, &inputs, Settings::default(), &input, step);
    for step in [0.0, 1e-300, 1e-17, f64::NAN, f64::INFINITY] {
        assert!(matches!(by(step), Err(Error::Parameter { .. })), "{step}");
    }
    let exact = gradient(&system, &inputs, Settings::default()).expect("gradient").controls[(0, 1)];
    assert!((by(1e-4).expect("differences")[0] - exact).abs() < 1e-6 * exact.abs());
    let mut direction = inputs.no_change();
    direction.controls[(0, 2)] = f64::NAN;
    let refused = check::direct_differentiation(&system, &inputs, Settings::default(), &direction);
    assert!(matches!(refused, Err(Error::NotFinite { .. })));
}

#[test]
fn what_a_diode_is_at_the_end_of_its_range_hides_nothing_at_the_other() {
    let right = |x: f64| 20.0 * (20.0 * x).exp();
    verdict(&One(Diode), None, right).assert_passed();
    for wrong in [1e-3, 1e-6] {
        let report = verdict(&One(Diode), None, |x| right(x) + wrong);
        assert_eq!(report.verdict(), Verdict::Wrong, "{wrong}");
    }
    assert_eq!(verdict(&One(Diode), None, |x| if x < 0.0 { 0.0 } else { right(x) }).verdict(), Verdict::Wrong);
}

#[test]
fn a_bump_beside_a_given_point_is_found() {
    let bump = |x: f64| (-((x - 0.3) / 1e-4).powi(2)).exp();
    let right = |x: f64| 1.0 - 2.0 * (x - 0.3) / 1e-8 * bump(x);
    let report = verdict(&One(Bump), Some(0.3), right);
    report.assert_passed();
    assert!(report.blocks[0].points == 1 && report.blocks[0].bends > 0);
    // At the point itself the bump is flat.
    assert_eq!(verdict(&One(Bump), Some(0.3), |_| 1.0).verdict(), Verdict::Wrong);
}

#[test]
fn a_kink_is_named_and_blames_nobody() {
    let report = verdict(&One(Abs), Some(0.0), f64::signum);
    assert!(report.verdict() == Verdict::ReferencesDisagree && report.blocks[0].notes[0].contains("kink"));
    let both = check::function(&One(Abs), ["x"], ["y"]).at(&[0.0]).at(&[0.2]).jacobian(|x: &[f64]| [[x[0].signum()]]).run();
    both.assert_passed();
    assert!(both.to_string().contains("kink"));
    let stop = |x: f64| if x > 0.3 { 1e5 } else { 0.0 };
    verdict(&One(Abs), None, f64::signum).assert_passed();
    verdict(&One(Stop), None, stop).assert_passed();
    for beside in [0.3 - 1e-9, 0.3 + 1e-9, 0.3 + 1e-6, 0.3 - 1e-4] {
        let report = verdict(&One(Stop), Some(beside), stop);
        assert_ne!(report.verdict(), Verdict::Wrong, "{beside}");
    }
}

/// Exactly at a kink, rounding of the arguments changes the derivative as much as it jumps: that is no rounding of the formula.
#[test]
fn a_kink_at_a_given_point_hides_no_wrong_block() {
    struct Beside(f64);
    impl Function for Beside {
        fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
            vec![-(x[0] - self.0).abs()]
        }
    }
    for at in [3.0, -0.7, 1e5] {
        for wrong in [40.0, -1.0, 1e-3] {
            let report = verdict(&Beside(at), Some(at), |_| wrong);
            assert_eq!(report.verdict(), Verdict::ReferencesDisagree, "{report}");
            assert!(report.to_string().contains("kink"), "{report}");
        }
    }
}

#[test]
fn points_outside_of_the_domain_are_drawn_again_and_counted() {
    let report = verdict(&One(Root), None, |x| 0.5 / x.sqrt());
    report.assert_passed();
    assert!(report.blocks[0].points == 12 && report.notes[0].contains("left out"), "{report}");
    let report = verdict(&One(Never), None, |_| 0.0);
    assert!(report.verdict() == Verdict::Refused && matches!(report.refused, Some(Error::NoPoint { drawn }) if drawn > 0));
    // A given point is used wherever it is.
    assert_eq!(verdict(&One(Root), Some(-1.0), |_| 0.0).verdict(), Verdict::ReferencesDisagree);
}

#[test]
fn values_are_compared_too() {
    let b = [0.5, 0.1, -0.4, 0.2];
    let hinge = || check::constraint(&Revolute, b).equations(["x", "y"]);
    hinge().phi(|at| between(&at.q, &b)).phi_dot(|at| hinge_q(&at.q, &b) * at.v).run().assert_passed();
    let wrong = hinge().phi(|at| -between(&at.q, &b)).run();
    println!("{wrong}");
    assert_eq!(wrong.blocks[0].diagnoses[0].mistake, Mistake::SignFlipped);
    check::function(&One(Diode), ["x"], ["y"]).value(|x: &[f64]| [(20.0 * x[0]).exp()]).run().assert_passed();
    let wrong = check::function(&One(Diode), ["x"], ["y"]).value(|x: &[f64]| [(20.0 * x[0]).exp() - 1.0]).run();
    assert_eq!(wrong.verdict(), Verdict::Wrong);
    check::kinetic_energy(&DoublePendulum, [0.8, 0.4, 1.1, 0.9])
        .t(|at| 0.5 * (at.v.transpose() * pendulum_mass(&at.q, &at.b) * at.v)[0])
        .run()
        .assert_passed();
    check::potential_energy(&Square, []).v(|at| at.q[0] * at.q[0]).run().assert_passed();
}

/// The double pendulum in its two angles: all of 𝓛_q that depends on v is T_q.
#[test]
fn a_residual_by_hand_is_compared_and_t_q_has_its_name() {
    let b = [0.8, 0.4, 1.1, 0.9];
    let mut scene = Scene::new();
    let q = scene.coordinates("pendulum", ["φ_1", "φ_2"]);
    scene.kinetic_energy("T", DoublePendulum, q, b.map(Into::into));
    scene.potential_energy("V", DoublePendulum, q, b.map(Into::into));
    scene.cost("end", End, Sum::Terminal, [q[0]], [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    inputs.start = Start::Velocity { q: DVector::from_vec(vec![0.4, 0.9]), v: DVector::from_vec(vec![2.0, -3.0]) };
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let four = Four::from(b);
    let two = |x: &DVector<f64>| SVector::<f64, 2>::from_column_slice(x.as_slice());
    let third = |at: &check::StepPoint| pendulum_mass(&two(&at.y.q), &four) * two(&at.y.v) - two(&at.y.p_star);
    check::step(&paper).f(F3, third).run().assert_passed();
    let wrong = check::step(&paper).f(F3, |at| third(at) + two(&at.y.p_star) * 2.0).run();
    println!("{wrong}");
    assert_eq!(wrong.verdict(), Verdict::Wrong);

    let f4_q = |at: &check::StepPoint| {
        let t = at.terms();
        t.force_q + t.force_v * at.gamma
    };
    check::step(&paper).f_y(F4, Q, f4_q).run().assert_passed();
    let names = |report: check::Report| {
        println!("{report}");
        assert_eq!(report.blocks[0].diagnoses[0].mistake, Mistake::TermMissing);
        report.blocks[0].diagnoses[0].text.clone()
    };
    let all = names(check::step(&paper).f_y(F4, Q, |at| f4_q(at) - at.terms().t_qq - at.terms().t_qv * at.gamma).run());
    assert!(all.contains("T_qq + γ T_qv") && !all.contains("Q_v"), "{all}");
    let half = names(check::step(&paper).f_y(F4, Q, |at| f4_q(at) - at.terms().t_qv * at.gamma).run());
    assert!(half.contains("missing: γ T_qv"), "{half}");
}

/// φ_1 at the end.
struct End;
impl hamiltonian_adjoint::Cost<1> for End {
    fn cost<S: Scalar>(&self, at: &hamiltonian_adjoint::CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

#[test]
fn equations_have_the_names_one_gives_them_and_times_are_called_t() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.02));
    inputs.controls.fill(1.0);
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let names = ["rail y", "rail φ", "hinge x", "hinge y"];
    let wrong = |at: &check::StepPoint| {
        assert!((at.t - 0.02 * at.node as f64).abs() < 1e-12);
        -at.terms().phi_q
    };
    let report = check::step(&paper).equations(names).f_y_previous(F5, V, |at| -wrong(at)).run();
    assert_eq!(report.blocks[0].name, "∂f5_i/∂v_(i−1)");
    assert!(report.blocks[0].entries.iter().all(|entry| names.iter().any(|name| entry.row.contains(name))), "{report}");
    let report = check::step(&paper).equations(["one"]).f_y_previous(F5, V, wrong).run();
    assert!(matches!(report.refused, Some(Error::Size { expected: 4, found: 1, .. })), "{report}");
}

#[test]
fn a_wrong_gradient_of_ones_own_is_a_row_of_the_table() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    inputs.controls.fill(1.0);
    let right: Vec<f64> =
        gradient(&system, &inputs, Settings::default()).expect("gradient").controls.iter().copied().collect();
    let wrong = right.iter().map(|g| -g).collect::<Vec<_>>();
    let check = check::gradient(&system, &inputs, Settings::default());
    let check = check.own("mine", Part::Controls, right).own("theirs", Part::Controls, wrong);
    let report = check.own("short", Part::Controls, [1.0]).run().expect("motion");
    let text = report.to_string();
    println!("{text}");
    assert!(report.verdict() == Verdict::Wrong && report.own[0].verdict == Verdict::Right);
    let row = |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).expect("a row").to_string();
    assert!(row("mine").ends_with("right") && row("theirs").ends_with("WRONG") && row("short").ends_with("WRONG"));
    assert!(text.lines().next().is_some_and(|line| line.contains(": right; but see")));
    assert!(text.contains("enough: more than 1.5 is required"));
}

/// Three values.
struct Three;

impl Function for Three {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x[0] * x[1], x[0].sin(), x[1] * x[1]]
    }
}

#[test]
fn a_function_with_another_number_of_values_than_names_is_refused() {
    // The third row is wrong, and nobody would look at it.
    let rows = |x: &[f64]| [[x[1], x[0]], [x[0].cos(), 0.0], [7.0, 7.0]];
    let two = check::function(&Three, ["x", "y"], ["f", "g"]).jacobian(rows).run();
    let four = check::function(&Three, ["x", "y"], ["f", "g", "h", "k"]).jacobian(rows).run();
    let given = check::function(&Three, ["x", "y"], ["f", "g"]).at(&[0.3, 0.4]).jacobian(rows).run();
    for (report, expected) in [(two, "expected 2"), (four, "expected 4"), (given, "expected 2")] {
        println!("{report}");
        assert_eq!(report.verdict(), Verdict::Refused);
        assert!(report.to_string().contains(expected) && report.to_string().contains("found 3"));
    }
}

/// ½ vᵀ M v with a coupling of two velocities.
struct Coupled;

impl KineticEnergy<2, 1> for Coupled {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        (v[0] * v[0] * 3.0 + v[0] * v[1] * (q[0] - q[1]).cos() + v[1] * v[1] * b[0]) * 0.5
    }
}

#[test]
fn an_error_in_the_last_digits_is_called_that_and_nothing_else() {
    let mass = |q: &SVector<f64, 2>, last: f64| {
        let coupling = 0.5 * (q[0] - q[1]).cos();
        nalgebra::Matrix2::new(3.0, coupling, coupling, last)
    };
    for error in [2e-11, 5e-11, 1e-10, 1e-9, 1e-8] {
        let whole = check::kinetic_energy(&Coupled, [0.7]).mass(|at| mass(&at.q, 0.7) * (1.0 + error));
        let one = check::kinetic_energy(&Coupled, [1.0]).mass(|at| mass(&at.q, 1.0 + error));
        let other = check::function(&Three, ["x", "y"], ["f", "g", "h"])
            .jacobian(|x| [[x[1], x[0]], [x[0].cos() * (1.0 + error), 0.0], [0.0, 2.0 * x[1]]]);
        for report in [whole.run(), one.run(), other.run()] {
            println!("{error:e}: {report}");
            let found = &report.blocks[0].diagnoses;
            assert!(!report.passed() && found.iter().all(|d| d.mistake == Mistake::FewDigits), "{found:?}");
        }
    }
}

/// A spring whose force is a table, linear between its entries: x + x³ at every tenth of a metre.
struct Tabled;
impl hamiltonian_adjoint::Force<1, 0, 1> for Tabled {
    fn force<S: Scalar>(&self, at: &hamiltonian_adjoint::ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        let entry = |i: f64| 0.1 * i + (0.1 * i).powi(3);
        let (x, first) = (at.q[0] * 10.0, (10.0 * at.q[0].re()).floor());
        let force = (x - first) * (entry(first + 1.0) - entry(first)) + entry(first);
        SVector::from([-(b[0] * force)])
    }
}
/// q² + q̇²/10.
struct Swing;
impl hamiltonian_adjoint::Cost<1> for Swing {
    fn cost<S: Scalar>(&self, at: &hamiltonian_adjoint::CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0].powi(2) + at.v[0].powi(2) * 0.1
    }
}

#[test]
fn a_motion_over_kinks_has_no_taylor_remainder_of_second_order_and_a_right_gradient() {
    let mut scene = Scene::new();
    let cart = scene.particle("cart", 1.0, [0.93, 0.0]);
    let stiffness = scene.design("stiffness", 3.0);
    scene.force("table", Tabled, [cart.coordinates[0]], [], [stiffness.into()]);
    scene.cost("swing", Swing, Sum::Integral, [cart.coordinates[0]], [], [], []);
    let system = scene.compile().expect("scene");
    let (mut bent, mut wrong) = (0, 0);
    for steps in 60..90 {
        let inputs = Inputs::at_rest(&system, Grid::uniform(steps, 2.0 / steps as f64));
        let report = check::gradient(&system, &inputs, Settings::default()).run().expect("check");
        bent += usize::from(report.taylor.slope.is_some_and(|slope| slope <= 1.5) && report.passed());
        wrong += usize::from(report.verdict() == Verdict::Wrong);
    }
    println!("of 30 gradients over kinks {bent} have remainders of lower order, and {wrong} are called wrong");
    assert!(bent > 0 && wrong == 0);
}

/// x² + y² = 1, and how far the motion is off it, to the fourth power.
struct Circle;
impl hamiltonian_adjoint::Constraint<2, 1> for Circle {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([q[0] * q[0] + q[1] * q[1] - 1.0])
    }
}
struct Off;
impl hamiltonian_adjoint::Cost<2> for Off {
    fn cost<S: Scalar>(&self, at: &hamiltonian_adjoint::CostPoint<S, 2, 0, 0>, _: &SVector<S, 0>) -> S {
        (at.q[0] * at.q[0] + at.q[1] * at.q[1] - 1.0).powi(4)
    }
}

#[test]
fn a_hessian_of_rounding_alone_is_not_wrong_and_a_failed_check_says_right_nowhere() {
    let mut scene = Scene::new();
    let body = scene.particle("bob", 2.0, [0.6, -0.8]);
    scene.constraint("circle", Circle, body.coordinates, []);
    scene.cost("off", Off, Sum::Integral, body.coordinates, [], [], []);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
    inputs.start = Start::Velocity { q: DVector::from_vec(vec![0.6, -0.8]), v: DVector::from_vec(vec![1.6, 1.2]) };
    let report = check::hessian(&system, &inputs, Settings::default()).run().expect("motion");
    println!("{report}");
    assert_eq!(report.verdict(), Verdict::NothingCompared);
    assert!(!report.to_string().contains("right"));
}

#[test]
fn a_direction_may_be_next_to_nothing_or_huge() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    inputs.controls.fill(10.0);
    let mut solver = hamiltonian_adjoint::Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("motion");
    let mut product = |size: f64| {
        let mut push = inputs.no_change();
        push.controls.fill(size);
        solver.hessian_product(&push).expect("product").controls.clone() / size
    };
    let usual = product(1.0);
    for size in [1e-307, 1e-200, 1e200, 1e300] {
        assert!((product(size) - &usual).amax() < 1e-12 * usual.amax(), "{size:e}");
    }
}
