//! What several test files share. Each file is a crate of its own and uses a part of it.
#![allow(dead_code)]

pub mod bench;
pub mod files;
pub mod products;

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{Error, Inputs, Settings, System, gradient};

/// The largest |ours − reference| relative to the largest |reference|; infinite if any number is not finite.
pub fn relative_error(ours: &[f64], reference: &[f64]) -> f64 {
    let error = largest_difference(ours, reference);
    let scale = reference.iter().fold(0.0f64, |s, x| s.max(x.abs()));
    if error == 0.0 { 0.0 } else { error / scale }
}

/// The largest |ours − reference|; infinite if any number is not finite.
pub fn largest_difference(ours: &[f64], reference: &[f64]) -> f64 {
    assert_eq!(ours.len(), reference.len());
    let size = |(a, b): (&f64, &f64)| if (a - b).is_finite() { (a - b).abs() } else { f64::INFINITY };
    ours.iter().zip(reference).map(size).fold(0.0, f64::max)
}

/// The largest |x|; infinite if any number is not finite.
pub fn largest(x: &[f64]) -> f64 {
    largest_difference(x, &vec![0.0; x.len()])
}

/// Asserts that errors at step lengths of which each is half the one before fall with this order, from the second halving on.
pub fn assert_order(what: &str, errors: &[f64], order: f64, within: f64) {
    let found: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    let errors: Vec<String> = errors.iter().map(|error| format!("{error:.2e}")).collect();
    println!("{what}: errors {}, orders {found:.3?}", errors.join(", "));
    for order_found in &found[1..] {
        assert!((order_found - order).abs() <= within, "{what}: errors {errors:?}, orders {found:.3?}");
    }
}

/// The array of numbers called `key` in a reference file.
pub fn numbers(file: &str, key: &str) -> Vec<f64> {
    let quoted = format!("\"{key}\"");
    let after = &file[file.find(&quoted).expect("key") + quoted.len()..];
    let start = after.find(':').expect("value") + 1;
    let value = after[start..].trim_start();
    let end = if value.starts_with('[') { value.find(']') } else { value.find([',', '}']) };
    let list = value[..end.expect("end")].trim_start_matches('[');
    list.split(',').map(|x| x.trim().parse().expect("a number")).collect()
}

/// Inputs of one kind are compared with each other's size: a force has another than an angle.
fn kind(input: &Input) -> &'static str {
    match input {
        Input::Control { .. } => "controls",
        Input::Design(_) => "design variables",
        Input::Coordinate(_) => "q0",
        Input::Rate(_) => "v0 or p*0",
        Input::Step(_) => "step lengths",
    }
}

/// Asserts for every input that a derivative equals the reference, to 1e-12 of the largest one of its kind.
pub fn assert_same_derivatives(what: &str, all: &[Input], ours: &[f64], reference: &[f64]) {
    assert_same_derivatives_to(1e-12, what, all, ours, reference);
}

/// The same to another part of the largest one.
pub fn assert_same_derivatives_to(within: f64, what: &str, all: &[Input], ours: &[f64], reference: &[f64]) {
    for name in ["controls", "design variables", "q0", "v0 or p*0", "step lengths"] {
        let of_kind = |values: &[f64]| -> Vec<f64> {
            all.iter().zip(values).filter(|(input, _)| kind(input) == name).map(|(_, x)| *x).collect()
        };
        let error = relative_error(&of_kind(ours), &of_kind(reference));
        println!("{what}: {name}: {error:.1e}");
        assert!(error <= within, "{what}: {name}: relative error {error:.2e}");
    }
}

/// Asserts that the adjoint gives the derivatives with respect to all inputs that complex step gives.
pub fn assert_gradient_is_exact(what: &str, system: &System, inputs: &Inputs) {
    assert_gradient_is_exact_with(what, system, inputs, Settings::default());
}

/// The same with other settings.
pub fn assert_gradient_is_exact_with(what: &str, system: &System, inputs: &Inputs, settings: Settings) {
    assert_gradient_is_exact_to(1e-12, what, system, inputs, settings);
}

/// The same for motions that amplify rounding.
pub fn assert_gradient_is_exact_to(within: f64, what: &str, system: &System, inputs: &Inputs, settings: Settings) {
    let all = Input::all(inputs);
    let gradient = gradient(system, inputs, settings).unwrap_or_else(|error| panic!("{what}: {error}"));
    let adjoint: Vec<f64> = all.iter().map(|input| input.in_gradient(&gradient)).collect();
    let mut reference = complex_step(system, inputs, settings, &all).unwrap_or_else(|error| panic!("{what}: {error}"));
    // The derivative of u² at u = 0 by complex step is its step, 1e-30, so that √(u²) has none there.
    reference.iter_mut().filter(|x| x.abs() < 1e-28).for_each(|x| *x = 0.0);
    assert_same_derivatives_to(within, what, &all, &adjoint, &reference);
}

/// Asserts that a message contains these words, and prints it to be read.
pub fn assert_says(error: &Error, words: &[&str]) {
    let message = error.to_string();
    println!("{message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}
