//! The command-line example: its numbers against the 128-bit references, its JSON, its refusals.

#[path = "../examples/cart_pendulum.rs"]
#[expect(dead_code, reason = "the example's main")]
mod cart_pendulum;

use cart_pendulum::{Failure, answer};
use serde_json::Value;

fn run(arguments: &str) -> Result<String, Failure> {
    answer(&arguments.split_whitespace().map(String::from).collect::<Vec<_>>())
}

fn numbers(json: &Value, key: &str) -> Vec<f64> {
    let number = |value: &Value| value.as_f64().expect("a number");
    match &json[key] {
        Value::Array(list) => list.iter().map(number).collect(),
        value => vec![number(value)],
    }
}

fn relative_error(ours: &[f64], reference: &[f64]) -> f64 {
    assert_eq!(ours.len(), reference.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |a: f64, x| a.max(x.abs()));
    let error = largest(&mut ours.iter().zip(reference).map(|(a, b)| a - b));
    error / largest(&mut reference.iter().copied())
}

fn compare(arguments: &str, reference: &str) {
    let ours: Value = serde_json::from_str(&run(arguments).expect("an answer")).expect("JSON");
    let reference: Value = serde_json::from_str(reference).expect("JSON");
    for (own_key, key) in [("cost", "J"), ("final_angles", "phi_final"), ("gradient", "grad")] {
        let error = relative_error(&numbers(&ours, own_key), &numbers(&reference, key));
        println!("{arguments}: relative error of {own_key} {error:.1e}");
        assert!(error <= 1e-12, "{own_key}: {error:.1e}");
    }
    for key in ["newton_iterations", "phi_max", "phi_dot_max", "forward_s", "value_and_gradient_s"] {
        assert!(numbers(&ours, key)[0] > 0.0, "{key}");
    }
}

#[test]
fn the_defaults_agree_with_the_128_bit_reference() {
    compare("", include_str!("data/truth_k3_cr0_const10.json"));
}

#[test]
fn ten_links_agree_with_the_128_bit_reference() {
    compare("--links 10 --dt 0.01 --force 10 --repeat 3", include_str!("data/truth_k10_cr0_const10.json"));
}

#[test]
fn controls_from_a_file_are_those_of_the_same_constant_force() {
    let file = format!("{}/controls.txt", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&file, "# force in N\n\n2.5 # first\n 2.5\n2.5e0\n2.5\n").expect("a file");
    let gradient = |arguments: &str| {
        let json = serde_json::from_str(&run(arguments).expect("an answer")).expect("JSON");
        numbers(&json, "gradient")
    };
    assert_eq!(gradient(&format!("--steps 3 --controls {file}")), gradient("--steps 3 --force 2.5"));

    std::fs::write(&file, "1\n2\nthree\n").expect("a file");
    let refused = run(&format!("--steps 2 --controls {file}"));
    assert_eq!(refused, Err(Failure::Usage(format!("{file}:3: `three` is not a number"))));
    let refused = run(&format!("--steps 2 --controls {file}.missing"));
    assert!(matches!(refused, Err(Failure::Usage(message)) if message.starts_with(&file)));
    std::fs::write(&file, "1\n2\n").expect("a file");
    let refused = run(&format!("--steps 2 --controls {file}"));
    assert_eq!(refused, Err(Failure::Usage(format!("{file}: 2 numbers, but 2 steps need 3"))));
}

#[test]
fn wrong_arguments_are_refused_by_name() {
    for (arguments, said) in [
        ("--linkz 3", "unknown argument `--linkz`"),
        ("--links", "--links needs a value"),
        ("--links three", "--links: `three` is not a whole number from 0 up"),
        ("--links 0", "--links must be at least 1"),
        ("--force inf", "--force: `inf` is not a number"),
        ("--length -1", "--length -1: a link must be longer than 0"),
        ("--links 2 --friction-joint 2", "--friction-joint 2: 2 links have the joints 0 to 1"),
        ("--force 1 --controls file", "give --force or --controls, not both"),
    ] {
        assert_eq!(run(arguments), Err(Failure::Usage(said.into())), "{arguments}");
    }
}

#[test]
fn a_simulation_that_fails_says_where() {
    let Err(Failure::Simulation(message)) = run("--dt 5 --force 1e200") else { panic!("a force of 1e200 N succeeded") };
    assert!(message.contains("step 1") && message.contains("overflowed"), "{message}");
}

#[test]
fn help_names_every_argument() {
    let help = run("--links 5 --help").expect("help");
    for flag in ["--links", "--length", "--friction-joint", "--steps", "--dt", "--controls", "--force", "--repeat"] {
        assert!(help.contains(flag), "{flag}");
    }
}
