//! What reports say: no true cause is hidden behind another, nothing is left without a word.

use hamiltonian_adjoint::Scalar;
use hamiltonian_adjoint::check::{self, Function, Verdict};

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
