//! Functions that are hard to difference: the references must still agree, and the right derivative must pass.

use hamiltonian_adjoint::Scalar;
use hamiltonian_adjoint::check::{self, Function, Verdict};

struct Hard;

impl Function for Hard {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let [a, b] = [x[0], x[1]];
        vec![
            (a * 50.0).sin() * b,
            (a * 1e3).tanh() + b * b,
            (a * a + 1e-4).recip() * b,
            (a * b * 20.0).exp_m1(),
            a.abs() * b,
            (a - 0.7).max(S::from(0.0)) * b * 3.0,
            (b * b + 1e-6).sqrt() + a * 1e9,
            (a + 1e6) * (a + 1e6) * b,
            b.atan2(a),
            (a * 1e-4).powi(3) + 5.0,
        ]
    }
}

fn by_hand(x: &[f64]) -> [[f64; 2]; 10] {
    let [a, b] = [x[0], x[1]];
    let (t, r) = ((1e3 * a).tanh(), 1.0 / (a * a + 1e-4));
    let sech = 1.0 / (1e3 * a).cosh();
    let _ = t;
    [
        [50.0 * (50.0 * a).cos() * b, (50.0 * a).sin()],
        [1e3 * sech * sech, 2.0 * b],
        [-2.0 * a * r * r * b, r],
        [20.0 * b * (20.0 * a * b).exp(), 20.0 * a * (20.0 * a * b).exp()],
        [a.signum() * b, a.abs()],
        [if a > 0.7 { 3.0 * b } else { 0.0 }, (a - 0.7).max(0.0) * 3.0],
        [1e9, b / (b * b + 1e-6).sqrt()],
        [2.0 * (a + 1e6) * b, (a + 1e6) * (a + 1e6)],
        [-b / (a * a + b * b), a / (a * a + b * b)],
        [3e-12 * a * a, 0.0],
    ]
}

#[test]
fn hard_functions_raise_no_false_alarm() {
    let names = ["sin", "tanh", "1/x²", "exp", "abs", "max", "sqrt", "large", "atan2", "small"];
    let (mut wrong, mut undecided) = (0, 0);
    for seed in 0..200 {
        // From tiny arguments to large ones.
        let size = [1e-3, 0.1, 1.0, 3.0][seed % 4];
        let check = check::function(&Hard, ["a", "b"], names).random_points(4, seed as u64).magnitudes(&[size, size]);
        let report = check.jacobian(by_hand).run();
        if !report.passed() {
            println!("size {size}, seed {seed}\n{report}");
        }
        wrong += usize::from(report.verdict() == Verdict::Wrong);
        undecided += usize::from(report.verdict() == Verdict::ReferencesDisagree);
    }
    println!("200 right Jacobians of hard functions: {wrong} called wrong, {undecided} undecided");
    assert_eq!((wrong, undecided), (0, 0));
}
