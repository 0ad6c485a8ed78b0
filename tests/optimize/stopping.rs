//! Reasons to stop that are true: minima from steep starts.

use super::{Function, Given};
use hamiltonian_adjoint::optimize::{Interval, Options, Reason, interior_point, silent};

/// cosh(x − 1) + (y + 2)², least at (1, −2).
fn steep(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    g.copy_from_slice(&[(x[0] - 1.0).sinh(), 2.0 * (x[1] + 2.0)]);
    (x[0] - 1.0).cosh() + (x[1] + 2.0).powi(2)
}

/// 100 (y − x²)² + (1 − x)², least at (1, 1).
fn valley(x: &[f64], _: &mut [f64], g: &mut [f64]) -> f64 {
    let (a, b) = (x[1] - x[0] * x[0], 1.0 - x[0]);
    g.copy_from_slice(&[-400.0 * a * x[0] - 2.0 * b, 200.0 * a]);
    100.0 * a * a + b * b
}

/// A gradient of 1e9 at the start, or of 1e35, does not make another one of 1e2, or of 1e28, small.
#[test]
fn a_minimum_does_not_depend_on_the_slope_at_the_start() {
    for (function, least) in [(steep as Function, [1.0, -2.0]), (valley, [1.0, 1.0])] {
        for bound in [Interval::FREE, Interval::at_least(-5.0)] {
            for from in [1.5, 10.0, 30.0, 100.0] {
                let mut problem = Given::new(function, vec![bound; 2], vec![]);
                let outcome = interior_point(&mut problem, &[from; 2], &Options::default(), &mut silent).expect("fits");
                assert_eq!(outcome.reason, Reason::Stationary, "{from}: {outcome}");
                let far = outcome.x.iter().zip(least).any(|(x, of)| (x - of).abs() > 1e-5);
                assert!(!far, "{from}: {:?} is not {least:?}", outcome.x);
            }
        }
    }
}
