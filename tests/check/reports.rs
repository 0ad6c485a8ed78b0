//! What reports say: no true cause is hidden behind another, nothing is left without a word.

use hamiltonian_adjoint::check::{self, Function, Part, Verdict};
use hamiltonian_adjoint::element::CostPoint;
use hamiltonian_adjoint::planar::Distance;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Constraint, Cost, Grid, Inputs, Scalar, Scene, Scheme, Settings, Sum, System, gradient};
use nalgebra::{SVector, Vector1};

fn cart() -> (System, Inputs) {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    inputs.controls.fill(10.0);
    (system, inputs)
}

/// The diagnosis of a gradient of one's own with these numbers half as large again.
fn half_more(part: Part, of: impl Fn(usize, usize) -> bool) -> String {
    let (system, inputs) = cart();
    let right = gradient(&system, &inputs, Settings::default()).expect("gradient");
    let values = if part == Part::Controls { right.controls.as_slice() } else { right.start.rate().as_slice() };
    let more = |(j, g): (usize, &f64)| if of(j, values.len()) { 1.5 * g } else { *g };
    let values: Vec<f64> = values.iter().enumerate().map(more).collect();
    let report = check::gradient(&system, &inputs, Settings::default()).own("mine", part, values).run().expect("motion");
    report.own[0].diagnoses[0].text.clone()
}

#[test]
fn only_what_follows_in_time_has_ends() {
    let is_end = |j: usize, count: usize| j == 0 || j + 1 == count;
    assert!(half_more(Part::Controls, is_end).contains("how the sweep starts and ends"));
    // x of the cart, and the angle of the link.
    let of_rates = half_more(Part::Rates, is_end);
    assert!(!of_rates.contains("sweep"), "{of_rates}");
}

/// Initial coordinates are moved off the constraints by more than they may drift: the motion would start anew where it did not.
#[test]
fn a_motion_that_starts_anew_elsewhere_is_no_witness() {
    let (system, inputs) = cart();
    let settings = Settings { drift_bound: 1e-6, scheme: Scheme::ESDIRK4, ..Settings::default() };
    let report = check::gradient(&system, &inputs, settings).run().expect("motion");
    println!("{report}");
    report.assert_passed();
    // What remains are steps so short that no step of the Taylor remainder is.
    assert!(report.to_string().contains("no neighbouring motion could be computed"));
    check::hessian(&system, &inputs, settings).run().expect("motion").assert_passed();
}

#[test]
fn a_product_that_cannot_be_compared_is_told_of() {
    struct Way;
    impl Cost<1> for Way {
        fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
            at.q[0]
        }
    }
    let mut scene = Scene::new();
    let body = scene.particle("particle", 2.0, [0.3, 0.4]);
    scene.cost("way", Way, Sum::Terminal, [body.coordinates[0]], [], [], []);
    let system = scene.compile().expect("scene");
    // By the initial coordinates and one step J is bilinear.
    let inputs = Inputs::at_rest(&system, Grid::uniform(0, 0.1));
    let check = check::hessian(&system, &inputs, Settings::default());
    let report = check.own("mine", Part::Coordinates, inputs.no_change(), [7.0, 7.0]).run().expect("motion");
    println!("{report}");
    assert_eq!((report.verdict(), report.own.len()), (Verdict::NothingCompared, 1));
    assert!(report.to_string().contains("mine") && report.to_string().contains("nothing to compare with"));
}

/// f = x y.
struct Product;
impl Function for Product {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x[0] * x[1]]
    }
}

/// |x| for x and |y| for y is wrong where x y has one sign, which it must not have at all points.
#[test]
fn products_of_arguments_have_both_signs() {
    for seed in 0..40 {
        for sign in [1.0, -1.0] {
            let hand = |x: &[f64]| if sign * x[0] * x[1] > 0.0 { [[x[1], x[0]]] } else { [[-x[1], -x[0]]] };
            let report = check::function(&Product, ["x", "y"], ["f"]).random_points(8, seed).jacobian(hand).run();
            assert_eq!(report.verdict(), Verdict::Wrong, "seed {seed}, sign {sign}");
        }
    }
}

/// f = 10¹² + y, whatever x is.
struct Without;
impl Function for Without {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x[1] + 1e12]
    }
}

#[test]
fn an_offset_hides_no_entry_that_should_be_zero() {
    let report = check::function(&Without, ["x", "y"], ["f"]).jacobian(|_: &[f64]| [[7.0, 1.0]]).run();
    assert_eq!(report.blocks[0].diagnoses[0].text, "not zero where it should be, in d(`f`)/d(`x`)");
    check::function(&Without, ["x", "y"], ["f"]).jacobian(|_: &[f64]| [[0.0, 1.0]]).run().assert_passed();
}

/// f = max(x − 0.9, 0).
struct Stop;
impl Function for Stop {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![(x[0] - 0.9).max(S::from(0.0))]
    }
}

#[test]
fn a_stop_near_the_usual_size_is_met_where_no_point_is_behind_it() {
    for seed in 0..40 {
        let report = check::function(&Stop, ["x"], ["f"]).random_points(2, seed).jacobian(|_: &[f64]| [[0.0]]).run();
        assert_eq!(report.verdict(), Verdict::Wrong, "seed {seed}");
    }
}

/// f = x² y.
struct Square;
impl Function for Square {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![x[0] * x[0] * x[1]]
    }
}

#[test]
fn every_argument_has_a_name() {
    let hand = |x: &[f64]| [[2.0 * x[0] * x[1], 1.0]];
    let report = check::function(&Square, ["x", "y"], ["f"]).jacobian(hand).run();
    assert_eq!(report.blocks[0].diagnoses[0].text, "1 is used instead of `x` in d(`f`)/d(`y`)");
}

/// f = (e³ʸ/3, 0).
struct OneSided;
impl Function for OneSided {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![(x[1] * 3.0).exp() / 3.0, x[0] * 0.0]
    }
}

#[test]
fn a_transpose_has_rounding_where_the_block_is_zero() {
    let hand = |x: &[f64]| [[0.0, 0.0], [x[1].exp().powi(3), 0.0]];
    let report = check::function(&OneSided, ["x", "y"], ["f", "g"]).jacobian(hand).run();
    assert_eq!(report.blocks[0].diagnoses[0].text, "transposed in the whole block");
}

/// An offset + a fifth of the angle of (x, y), or, if it `loses` a derivative, + sin x + y with a constant sine.
struct Offset {
    size: f64,
    loses: bool,
}
impl Function for Offset {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let (x, y) = (x[0], x[1]);
        vec![if self.loses { S::from(x.re().sin()) + y } else { y.atan2(x) * 0.2 } + self.size]
    }
}

/// Beside the origin an angle turns within steps that 10¹² leaves few digits of: enough to tell on whose side they are.
#[test]
fn a_formula_under_a_large_offset_is_accused_only_if_it_loses_a_derivative() {
    let names = (["x", "y"], ["f"]);
    for k in 0..10 {
        let scale = 10f64.powf(-8.9 - 0.01 * f64::from(k));
        let hand = |x: &[f64]| {
            let square = x[0] * x[0] + x[1] * x[1];
            [[-0.2 * x[1] / square, 0.2 * x[0] / square]]
        };
        let check = check::function(&Offset { size: 1e12, loses: false }, names.0, names.1).at(&[3.0 * scale, -2.0 * scale]);
        check.jacobian(hand).run().assert_passed();
    }
    let lost = |size: f64| {
        check::function(&Offset { size, loses: true }, names.0, names.1).jacobian(|_: &[f64]| [[0.0, 1.0]]).run()
    };
    assert_eq!(lost(1e6).verdict(), Verdict::ReferencesDisagree);
    // Here only the longest steps see anything.
    let hidden = lost(1e10);
    println!("{hidden}");
    assert!(hidden.blocks[0].notes.iter().any(|note| note.contains("or the formula loses a derivative")));
}

/// (x + y)², of the inputs and nothing else.
struct SquareOfSum;
impl Function for SquareOfSum {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let [a, b] = x else { panic!("{} inputs", x.len()) };
        vec![(*a + *b).powi(2)]
    }
}

#[test]
fn a_function_is_given_its_inputs_alone() {
    let check = check::function(&SquareOfSum, ["x", "y"], ["z"]).value(|x| (x[0] + x[1]).powi(2));
    check.jacobian(|x| [[2.0 * (x[0] + x[1]); 2]]).run().assert_passed();
}

#[test]
fn a_wrong_one_of_the_user_s_own_is_not_hidden_by_one_that_compares_nothing() {
    let (system, inputs) = cart();
    let zeros = vec![0.0; inputs.controls.len()];
    let check = check::gradient(&system, &inputs, Settings::default());
    let report = check.own("none", Part::Design, []).own("zeros", Part::Controls, zeros).run().expect("motion");
    assert_eq!(report.verdict(), Verdict::Wrong);
    // It is not the differences that are to blame.
    let check = check::hessian(&system, &inputs, Settings::default());
    let report = check.own("none", Part::Design, inputs.no_change(), []).run().expect("motion");
    assert_eq!(report.verdict(), Verdict::NothingCompared);
    assert!(report.to_string().contains("right; but see your own product"), "{report}");
}

#[test]
fn what_is_nearly_right_is_not_moved_by_nothing() {
    let (system, inputs) = cart();
    let right = gradient(&system, &inputs, Settings::default()).expect("gradient");
    let nearly = right.start.rate().map(|g| g * (1.0 + 3e-9));
    let check = check::gradient(&system, &inputs, Settings::default()).own("mine", Part::Rates, nearly.iter().copied());
    let found = &check.run().expect("motion").own[0].diagnoses[0];
    assert!(found.text.contains("digits only"), "{found:?}");
}

/// e²⁰ˣ.
struct Steep;
impl Function for Steep {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        vec![(x[0] * 20.0).exp()]
    }
}

#[test]
fn the_largest_error_is_that_of_all_points() {
    let slope = |x: f64| 20.0 * (20.0 * x).exp();
    let check = check::function(&Steep, ["x"], ["y"]).at(&[0.1]).at(&[1.4]);
    let report = check.jacobian(move |x| slope(x[0]) * (1.0 + 1e-9) + 1e-3).run();
    let off = slope(1.4) * 1e-9;
    assert!(report.blocks[0].absolute_error > 0.99 * off, "{report}");
}

/// An element made of another.
struct Doubled<E>(E);
impl<E: Constraint<6, 1, 5>> Constraint<6, 1, 5> for Doubled<E> {
    fn phi<S: Scalar>(&self, q: &SVector<S, 6>, b: &SVector<S, 5>, t: S) -> Vector1<S> {
        self.0.phi(q, b, t) * S::from(2.0)
    }
}

#[test]
fn an_element_made_of_another_has_its_own_name() {
    let report = check::constraint(&Doubled(Distance), [0.1, 0.2, 0.3, 0.4, 0.7]).phi_t(|_| 0.0).run();
    assert_eq!(report.title, "constraint `Doubled`");
}
