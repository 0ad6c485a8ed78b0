//! Wrong files, arguments and outputs end with a message and a status, and leave old files as they were.

mod program;

use std::fs::{self, File, OpenOptions};
use std::process::Stdio;

use hamiltonian_adjoint::scenes::CartPendulum;
use program::{Folder, Run};

/// A folder with the paper's example.
fn paper(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("scene.json", &CartPendulum::default().scene().to_json().expect("a scene"));
    folder.run(&["inputs", "scene.json", "--steps", "400", "--dt", "0.02", "-o", "inputs.json"]).succeeded();
    folder
}

#[test]
fn wrong_files_are_named() {
    let folder = paper("files");
    let inputs = folder.read("inputs.json");
    fs::write(folder.path().join("bytes.json"), [0xff, 0xfe, 0x00]).expect("a file");
    // A file of zeros without data on the disk.
    File::create(folder.path().join("huge.json")).and_then(|file| file.set_len((1 << 30) + 1)).expect("a file");
    folder.write("empty.json", "");
    folder.write("deep.json", &"[".repeat(100_000));
    folder.write("other.json", &inputs.replace("force on the cart", "push"));
    folder.write("short.json", &inputs.replacen("0.0,", "", 1));
    folder.write("null.json", &inputs.replacen("0.02", "null", 1));
    folder.write("long.json", &inputs.replacen("0.02", "1e999", 1));
    let missing = if cfg!(windows) { "missing.json: " } else { "missing.json: No such file" };
    for (file, expected) in [
        ("missing.json", missing),
        (".", ".: "),
        ("", ": "),
        ("bytes.json", "bytes.json: stream did not contain valid UTF-8"),
        ("huge.json", "huge.json: more than 1073741824 bytes"),
        ("empty.json", "empty.json: "),
        ("deep.json", "deep.json: "),
    ] {
        folder.run(&["describe", file]).failed(2, &["error: ", expected]);
        folder.run(&["gradient", file, "inputs.json"]).failed(2, &["error: ", expected]);
        folder.run(&["gradient", "scene.json", file]).failed(2, &["error: ", expected]);
        folder.run(&["hessian-product", "scene.json", "inputs.json", "--along", file]).failed(2, &["error: ", expected]);
        folder
            .run(&["inputs", "scene.json", "--steps", "1", "--dt", "1", "--controls", file])
            .failed(2, &["error: ", expected]);
    }
    for (file, expected) in [
        ("scene.json", "scene.json: inputs, "),
        ("other.json", "there is no value for `force on the cart`"),
        ("short.json", "short.json: "),
        ("null.json", "null.json: inputs, line "),
        ("long.json", "number out of range"),
    ] {
        folder.run(&["simulate", "scene.json", file]).failed(2, &["error: ", expected]);
    }
    folder.run(&["simulate", "-", "-"]).failed(2, &["standard input"]);
    folder.run_with(&["simulate", "scene.json", "-"], &inputs).succeeded();
}

#[test]
fn wrong_directions_are_named() {
    let folder = paper("directions");
    folder.run(&["gradient", "scene.json", "inputs.json", "-o", "gradient.json"]).succeeded();
    let gradient = folder.read("gradient.json");
    let run = |text: &str| {
        folder.write("along.json", text);
        folder.run(&["hessian-product", "scene.json", "inputs.json", "--along", "along.json"])
    };
    run(&gradient).succeeded();
    for (old, new, expected) in [
        ("force on the cart", "push", "there is no value for `force on the cart`"),
        ("\"start\": \"velocity\"", "\"start\": \"momentum\"", "`momentum`"),
        ("\"steps\"", "\"lengths\"", "unknown field `lengths`"),
        ("adjoint gradient", "adjoint inputs", "expected `hamiltonian-adjoint gradient`"),
        ("\"steps\": [", "\"steps\": [1.0,", "time steps"),
    ] {
        run(&gradient.replacen(old, new, 1)).failed(2, &["along.json: ", expected]);
    }
    let longer = gradient.replacen("\"force on the cart\": [", "\"force on the cart\": [1.0,", 1);
    run(&longer).failed(2, &["along.json: direction, `controls`, `force on the cart`: 402 values for 401 nodes"]);
}

#[test]
fn wrong_arguments_end_with_status_2() {
    let folder = paper("arguments");
    let motion = |options: &[&str]| folder.run(&[&["simulate", "scene.json", "inputs.json"], options].concat());
    for options in [
        &["--scheme", "euler"][..],
        &["--tolerance", "NaN"],
        &["--tolerance", "inf"],
        &["--tolerance=-1"],
        &["--max-iterations", "0"],
        &["--max-iterations", "99999999999999999999"],
        &["--drift-bound", "x"],
        &["--colour"],
        &["third.json"],
    ] {
        motion(options).failed(2, &["error: "]);
    }
    folder.run(&[]).failed(2, &["Usage"]);
    folder.run(&["simulate"]).failed(2, &["<SCENE>"]);
    for (steps, dt, expected) in [
        ("18446744073709551615", "0.1", "at most"),
        ("100000000", "0.1", "at most"),
        ("3", "NaN", "NaN"),
        ("3", "inf", "inf"),
        ("3", "0", "0"),
        ("3", "1e308", "--dt 1e308: "),
        ("-3", "1", "-3"),
    ] {
        let run = folder.run(&["inputs", "scene.json", "--steps", steps, "--dt", dt]);
        run.failed(2, &["error: ", expected]);
    }
    folder.run(&["inputs", "scene.json", "--steps", "3", "--dt", "-0.1"]).succeeded();
}

#[test]
fn what_cannot_be_written_is_reported_and_old_files_stay() {
    let folder = paper("outputs");
    let to = |file: &str| folder.run(&["simulate", "scene.json", "inputs.json", "-o", file]);
    to(".").failed(2, &[".: this is a folder"]);
    to("missing/motion.json").failed(2, &["missing/motion.json: its folder does not exist"]);
    to("inputs.json/motion.json").failed(2, &["its folder does not exist"]);
    to("").failed(2, &[": "]);
    to(&format!("{}.json", "long".repeat(100))).failed(1, &["error: longlong"]);
    to("motion.json").succeeded();
    let motion = folder.read("motion.json");
    folder.run(&["simulate", "scene.json", "missing.json", "-o", "motion.json"]).failed(2, &["missing.json"]);
    assert_eq!(folder.read("motion.json"), motion);
    let names = fs::read_dir(folder.path()).expect("a folder").map(|file| file.expect("a file").file_name());
    let mut names: Vec<_> = names.collect();
    names.sort();
    assert_eq!(names, ["inputs.json", "motion.json", "scene.json"], "no temporary file remains");
}

#[cfg(unix)]
#[test]
fn closed_pipes_full_disks_and_links() {
    use std::os::unix::fs::{PermissionsExt, symlink};

    let folder = paper("devices");
    let simulate = ["simulate", "scene.json", "inputs.json"];
    // More than a pipe holds.
    let mut child = folder.command(&simulate).spawn().expect("the program");
    drop(child.stdout.take());
    Run::of(&simulate, child.wait_with_output().expect("the program")).failed(1, &["error: standard output: "]);
    let full = || OpenOptions::new().write(true).open("/dev/full");
    if let Ok(full) = full() {
        let output = folder.command(&["--help"]).stdout(full).output().expect("the program");
        Run::of(&["--help"], output).failed(1, &["error: standard output: "]);
    }
    if let Ok(full) = full() {
        let output = folder.command(&["describe", "missing.json"]).stderr(Stdio::from(full)).output().expect("the program");
        assert_eq!(output.status.code(), Some(2), "messages that cannot be printed change nothing");
    }
    folder.write("old.json", "old");
    fs::set_permissions(folder.path().join("old.json"), fs::Permissions::from_mode(0o640)).expect("permissions");
    symlink("old.json", folder.path().join("link.json")).expect("a link");
    folder.run(&[&simulate[..], &["-o", "link.json"]].concat()).succeeded();
    assert!(folder.path().join("link.json").is_symlink());
    assert!(folder.read("old.json").starts_with("{\"format\":\"hamiltonian-adjoint trajectory\""));
    let mode = fs::metadata(folder.path().join("old.json")).expect("a file").permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    let shell = |script: &str| {
        let program = env!("CARGO_BIN_EXE_hamiltonian-adjoint");
        let output = std::process::Command::new("sh").args(["-c", script, program]).current_dir(folder.path()).output();
        Run::of(&[script], output.expect("a shell"))
    };
    // Devices and pipes are not replaced.
    let through_a_pipe = "mkfifo pipe; cat pipe > copy.json & \"$0\" simulate scene.json inputs.json -o pipe; test -p pipe || { kill $!; exit 1; }; wait; rm pipe";
    shell(through_a_pipe).succeeded();
    assert_eq!(folder.read("copy.json"), folder.read("old.json"));
    // A file that may not become longer than a block, as on a full disk.
    let before = folder.read("old.json");
    let limited = "trap '' XFSZ; ulimit -f 1; exec \"$0\" simulate scene.json inputs.json -o old.json";
    shell(limited).failed(1, &["error: old.json: "]);
    assert_eq!(folder.read("old.json"), before, "nothing is overwritten in part");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 5, "no temporary file remains");
}
