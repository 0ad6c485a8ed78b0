//! The command-line examples: their numbers against the 128-bit references, their JSON, their refusals.

#[path = "../../examples/cart_pendulum.rs"]
#[expect(dead_code, reason = "the example's main")]
mod cart_pendulum;

#[path = "../../examples/arm.rs"]
#[expect(dead_code, reason = "the example's main")]
mod arm;

use std::fs::File;
use std::io::{self, Write};

use cart_pendulum::{Failure, answer, print};
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
    compare("", include_str!("../data/truth_k3_cr0_const10.json"));
}

#[test]
fn ten_links_agree_with_the_128_bit_reference() {
    compare("--links 10 --dt 0.01 --force 10 --repeat 3", include_str!("../data/truth_k10_cr0_const10.json"));
}

#[test]
fn controls_from_a_file_are_those_of_the_same_constant_force() {
    let file = format!("{}/controls.txt", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&file, "\u{feff}2.5\r\n# force in N\n\n 2.5 # second\n2.5e0\n2.5\n").expect("a file");
    let gradient = |arguments: &str| {
        let json = serde_json::from_str(&run(arguments).expect("an answer")).expect("JSON");
        numbers(&json, "gradient")
    };
    assert_eq!(gradient(&format!("--steps 3 --controls {file}")), gradient("--steps 3 --force 2.5"));

    std::fs::write(&file, "1\n2\nthree\n").expect("a file");
    let refused = run(&format!("--steps 2 --controls {file}"));
    assert_eq!(refused, Err(Failure::Usage(format!("{file}:3: `three` is not a finite number"))));
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
        ("--links three", "--links: `three` is not a whole number of at least 0"),
        ("--links 0", "--links must be at least 1"),
        ("--force inf", "--force: `inf` is not a finite number"),
        ("--length -1", "--length -1: a link must be longer than 0"),
        ("--links 2 --friction-joint 2", "--friction-joint 2: 2 links have the joints 0 to 1"),
        ("--force 1 --controls file", "give --force or --controls, not both"),
        ("--links 2 --steps 3 --links 2", "--links is given twice"),
        ("--force 1 --force 1", "--force is given twice"),
        ("--dt NaN", "--dt: `NaN` is not a finite number"),
        ("--dt 0", "--dt 0: a step must have a length"),
        ("--steps -1", "--steps: `-1` is not a whole number of at least 0"),
        ("--repeat 1e18", "--repeat: `1e18` is not a whole number of at least 0"),
        ("stray", "unknown argument `stray`"),
    ] {
        assert_eq!(run(arguments), Err(Failure::Usage(said.into())), "{arguments}");
    }
    assert_eq!(answer(&["--controls", ""]), Err(Failure::Usage("--controls needs the name of a file".into())));
}

#[test]
fn sizes_that_nothing_can_hold_are_refused_with_what_is_allowed() {
    for (arguments, allowed) in [
        ("--links 20001", "at most 20000"),
        ("--links 18446744073709551615 --steps 18446744073709551615", "at most 20000"),
        ("--friction-joint 18446744073709551615", "3 links have the joints 0 to 2"),
        ("--steps 18446744073709551615", "at most 1254371 with 3 links"),
        ("--steps 99999999999999999999999999999999999999999999", "at most 1254371 with 3 links"),
        ("--links 20000 --steps 354", "at most 353 with 20000 links"),
        ("--repeat 18446744073709551615", "at most 333333 with 3 links and 100 steps"),
        // The most links and steps, which are too many only to be computed again and again.
        ("--links 20000 --steps 353 --repeat 15", "at most 14 with 20000 links and 353 steps"),
    ] {
        let Err(Failure::Usage(message)) = run(arguments) else { panic!("{arguments}: not refused") };
        assert!(message.contains(allowed) && !message.contains('\n'), "{arguments}: {message}");
    }
}

#[test]
fn what_is_no_text_or_has_no_end_is_refused_in_one_short_line() {
    let long = "9".repeat(1_000_000);
    for arguments in [vec!["--links", "a\nb"], vec![long.as_str()], vec!["--dt", "\u{7}"], vec!["--controls", "/dev/zero"]] {
        let Err(Failure::Usage(message)) = answer(&arguments) else { panic!("not refused") };
        assert!(message.len() < 200 && !message.contains(char::is_control), "{message}");
    }
    #[cfg(unix)]
    {
        use std::ffi::{OsStr, OsString};
        use std::os::unix::ffi::OsStrExt;
        let wild = OsStr::from_bytes(b"\xff");
        for flag in ["", "--links", "--controls", "--force"] {
            let arguments: Vec<&OsStr> = [OsStr::new(flag), wild].into_iter().filter(|text| !text.is_empty()).collect();
            assert!(matches!(answer(&arguments), Err(Failure::Usage(message)) if !message.is_empty()), "{flag}");
        }
        for arguments in [vec![wild], vec![OsStr::new("--steps"), wild]] {
            let refused = arm::answer(arguments.into_iter().map(OsString::from));
            assert!(matches!(&refused, Err(arm::Failure::Usage(said)) if said.contains("`\u{fffd}`")), "{refused:?}");
        }
    }
}

#[test]
fn wrong_arguments_of_the_arm_are_refused_as_such() {
    let long = "9".repeat(1_000_000);
    for (arguments, said) in [
        ("--steps", "--steps needs a value"),
        ("--steps 0", "--steps: `0` is not a whole number from 1 to 1000000"),
        ("--repeat -1", "--repeat: `-1` is not a whole number from 1 to 1000000"),
        ("--steps NaN", "--steps: `NaN` is not a whole number from 1 to 1000000"),
        ("--steps 1 --steps 2", "--steps is given twice"),
        ("--num-dual --num-dual", "--num-dual is given twice"),
        ("--print --num-dual", "give --num-dual or --print, not both: with --num-dual there are no programs to print"),
        ("stray", "unknown argument `stray`"),
        (long.as_str(), &format!("unknown argument `{}`", "9".repeat(60))),
    ] {
        let refused = arm::answer(arguments.split_whitespace().map(Into::into));
        assert_eq!(refused, Err(arm::Failure::Usage(said.into())));
    }
}

/// A disk with room for so many bytes.
struct Disk(usize);

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = bytes.len().min(self.0);
        self.0 -= written;
        if written == 0 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(written) }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_result_that_is_lost_is_a_failure() {
    let text = run("--steps 2").expect("an answer");
    assert_eq!(print(&text, &mut Disk(text.len())), Ok(()));
    for room in [0, 1, text.len() - 1] {
        assert!(matches!(print(&text, &mut Disk(room)), Err(Failure::Output(message)) if message.contains("cannot print")));
    }
    if let Ok(mut full) = File::options().write(true).open("/dev/full") {
        assert!(matches!(print(&text, &mut full), Err(Failure::Output(_))));
    }
}

#[test]
fn warnings_of_the_run_are_in_the_json() {
    let warnings = |arguments: &str| {
        let json: Value = serde_json::from_str(&run(arguments).expect("an answer")).expect("JSON");
        let text = |warning: &Value| warning.as_str().expect("a text").to_string();
        json["warnings"].as_array().expect("a list").iter().map(text).collect::<Vec<_>>()
    };
    assert_eq!(warnings(""), [""; 0]);
    let told = warnings("--dt 1").join("\n");
    assert!(told.contains("turns by"), "{told}");
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
    assert!(help.contains("Limits: 20000 links") && help.contains("1.2 million with 3 links"));
}
