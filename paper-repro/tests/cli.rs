//! Tests of the command-line program: invalid arguments, lost output, interruptions.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The files of a figure.
const FILES: &[&str] = match cfg!(feature = "png") {
    true => &["fig4.csv", "fig4.png", "fig4.svg", "fig4.txt"],
    false => &["fig4.csv", "fig4.svg", "fig4.txt"],
};

const BINARY: &str = env!("CARGO_BIN_EXE_paper-repro");

fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(BINARY);
    command.args(arguments).stdin(Stdio::null());
    command
}

/// A folder of this test that does not exist yet.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-{name}-{}", std::process::id()));
    assert!(!folder.exists());
    folder
}

/// Asserts the exit status and one line on standard error that contains these words.
#[track_caller]
fn assert_fails(output: &Output, status: i32, words: &[&str]) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{said}");
    assert!(said.starts_with("error: ") && said.lines().count() == 1, "{said}");
    for word in words {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
}

#[test]
fn wrong_arguments_are_refused_in_one_line_with_what_is_allowed() {
    let cases: [(&[&str], &str); 25] = [
        (&["--linkz", "3"], "--linkz"),
        (&["--links", "1000000000"], "1..=50"),
        (&["--links", "51"], "1..=50"),
        (&["--links", "-1"], "1..=50"),
        (&["--links", ""], "--links"),
        (&["--links", "2", "--links", "2"], "multiple times"),
        (&["--links", "2", "--friction-joint", "2"], "hinge"),
        (&["--iterations", "4294967295"], "1..=100000"),
        (&["--iterations", "0"], "1..=100000"),
        (&["--length", "NaN"], "finite"),
        (&["--length", "0"], "positive"),
        (&["--length", "-1e-3"], "positive"),
        (&["--gravity", "inf"], "finite"),
        (&["--gravity", "--links"], "not a number"),
        (&["--alpha", "-1"], "positive"),
        (&["--armijo", "1"], "between 0 and 1"),
        (&["--backtrack", "0.999999999999"], "at most 0.99"),
        (&["--out"], "--out"),
        (&["fig7"], "[possible values: fig1, fig2"),
        (&["fig1", "--out", "a", "--out", "b"], "multiple times"),
        (&["jacobians", "--short"], "--short"),
        (&["jacobians", "--out"], "--out"),
        (&["work-precision", "--links", "2"], "--links"),
        (&["--links", "2", "stress"], "`stress` does not take --links"),
        (&["stress", "--short", "--short"], "multiple times"),
    ];
    for (arguments, word) in cases {
        let output = program(arguments).output().expect("runs");
        assert_fails(&output, 2, &[word, "(try --help)"]);
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn help_and_version_are_answers() {
    for arguments in [&["--help"][..], &["--version"], &["stress", "--help"], &["help", "jacobians"]] {
        let output = program(arguments).output().expect("runs");
        assert!(output.status.success() && output.stderr.is_empty() && !output.stdout.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_folder_that_cannot_be_is_named_before_anything_is_computed() {
    let file = folder("file");
    fs::write(&file, "in the way").expect("a file");
    for below in [file.clone(), file.join("below")] {
        for part in [&["fig1"][..], &["jacobians"], &["work-precision"], &["stress"]] {
            let start = Instant::now();
            for is_before in [false, true] {
                let mut run = program(if is_before { &[] } else { part });
                run.arg("--out").arg(&below).args(if is_before { part } else { &[] });
                assert_fails(&run.output().expect("runs"), 1, &[below.to_str().expect("text"), "--out"]);
            }
            assert!(start.elapsed() < Duration::from_secs(20), "{part:?}");
        }
    }
    assert_eq!(fs::read_to_string(&file).expect("still there"), "in the way");
    fs::remove_file(file).expect("removed");
}

#[test]
fn files_are_whole_and_nothing_is_left_beside_them() {
    let out = folder("files");
    let output = program(&["fig4", "--out"]).arg(&out).output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut names: Vec<_> = fs::read_dir(&out).expect("made").map(|entry| entry.expect("entry").file_name()).collect();
    names.sort();
    assert_eq!(names, [FILES, &["summary.json"]].concat());
    let summary: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("summary.json")).expect("read")).expect("JSON");
    assert_eq!(summary["warnings"], serde_json::json!([]));
    fs::remove_dir_all(out).expect("removed");
}

#[test]
fn a_descent_that_ends_early_says_why() {
    let out = folder("early");
    // At the length at which the line search ends, the first step is still far too long.
    let output = program(&["fig3", "--alpha", "1e300", "--iterations", "2", "--out"]).arg(&out).output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary = fs::read_to_string(out.join("summary.json")).expect("read");
    assert!(summary.contains("after 0 iterations, after which no step of the line search lowers J"), "{summary}");
    fs::remove_dir_all(out).expect("removed");
}

#[test]
fn warnings_of_the_motions_are_told_and_kept() {
    let out = folder("warnings");
    // Steps are halved, so that the motion has more nodes than the inputs.
    let output = program(&["fig4", "--gravity", "15000", "--out"]).arg(&out).output().expect("runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.lines().any(|line| line.starts_with("warning: some steps had no solution and were halved")), "{said}");
    let summary: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("summary.json")).expect("read")).expect("JSON");
    for warning in summary["warnings"].as_array().expect("a list") {
        assert!(said.contains(warning.as_str().expect("a text")));
    }
    fs::remove_dir_all(out).expect("removed");
}

#[cfg(target_os = "linux")]
mod linux {
    use super::*;
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    fn full() -> Stdio {
        fs::File::options().write(true).open("/dev/full").expect("a full disk").into()
    }

    #[test]
    fn lost_output_is_a_failure() {
        let out = folder("full");
        for arguments in [&["--help"][..], &["--version"], &["fig1", "--out", out.to_str().expect("text")]] {
            let output = program(arguments).stdout(full()).stderr(Stdio::piped()).output().expect("runs");
            assert_fails(&output, 1, &["cannot write to standard output", "No space"]);
        }
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = program(&["fig1", "--out"]).arg(&out).stdout(writer).output().expect("runs");
        assert_fails(&output, 1, &["cannot write to standard output", "Broken pipe"]);
        // The files exist; only the printed output is lost.
        assert!(out.join("summary.json").exists());
        // The error message is lost, but the exit status reports the failure.
        assert_eq!(program(&["--linkz"]).stderr(full()).status().expect("runs").code(), Some(2));
        fs::remove_dir_all(out).expect("removed");
    }

    #[test]
    fn arguments_that_are_no_text_are_refused_and_paths_need_not_be() {
        let wild = OsStr::from_bytes(b"wild-\xff");
        for flag in ["", "--links", "--length"] {
            let mut command = program(&[]);
            if !flag.is_empty() {
                command.arg(flag);
            }
            let output = command.arg(wild).output().expect("runs");
            assert_fails(&output, 2, &["(try --help)"]);
        }
        let parent = folder("wild");
        let out = parent.join(wild);
        let output = program(&["fig1", "--out"]).arg(&out).output().expect("runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(out.join("fig1.csv").exists());
        fs::remove_dir_all(parent).expect("removed");
    }

    /// The system kills a process that exceeds the file size limit, here in the middle of each file.
    #[test]
    fn a_run_that_is_killed_while_it_writes_leaves_no_half_written_file() {
        let out = folder("killed");
        assert!(program(&["fig4", "--out"]).arg(&out).output().expect("runs").status.success());
        let names = [FILES, &["summary.json"]].concat();
        let read = |name: &&str| fs::read(out.join(name)).expect("there");
        let whole: Vec<Vec<u8>> = names.iter().map(read).collect();
        let last = names.len() - 1;
        // The captions are too short to be cut.
        let long = whole[..last].iter().filter(|contents| contents.len() > 2048);
        let mut limits: Vec<usize> = long.map(|contents| contents.len() / 512 - 2).collect();
        limits.sort();
        assert!(limits.len() > 1);
        for limit in limits {
            names.iter().for_each(|name| fs::write(out.join(name), "old").expect("written"));
            let script = format!("ulimit -c 0; ulimit -f {limit}; exec {} fig4 --out {}", BINARY, out.display());
            let status = Command::new("sh").args(["-c", &script]).status().expect("runs");
            assert_eq!(status.code(), None, "{limit} blocks: not killed");
            let found: Vec<Vec<u8>> = names.iter().map(read).collect();
            let state = |k: usize| (found[k] == whole[k], found[k] == b"old");
            let sizes: Vec<usize> = found.iter().map(Vec::len).collect();
            assert!((0..=last).all(|k| state(k) != (false, false)), "{limit} blocks: {sizes:?}");
            assert!(found[last] == b"old");
        }
        fs::remove_dir_all(out).expect("removed");
    }

    /// Disks with space for some files and a part of the next one; skipped if such a disk cannot be mounted.
    #[test]
    fn a_disk_that_fills_up_keeps_whole_files_only() {
        let out = folder("small");
        assert!(program(&["fig4", "--out"]).arg(&out).output().expect("runs").status.success());
        let size = |path: PathBuf| fs::metadata(path).expect("there").len();
        let whole: Vec<(&str, u64)> = FILES.iter().map(|name| (*name, size(out.join(name)))).collect();
        // Pictures as PNG are optional.
        let all: u64 = whole.iter().map(|(_, size)| size).sum();
        for kilobytes in [4, 12, 24, 48].into_iter().filter(|kilobytes| 1024 * kilobytes < all) {
            let script = format!(
                "mount -t tmpfs -o size={kilobytes}k none {0} || exit 99; {1} fig4 --out {0}; echo $?; cd {0}; wc -c .[!.]* *",
                out.display(),
                BINARY,
            );
            let Ok(output) = Command::new("unshare").args(["-rm", "sh", "-c", &script]).output() else { return };
            let found = String::from_utf8_lossy(&output.stdout);
            if output.status.code() == Some(99) || found.is_empty() {
                return;
            }
            println!("{kilobytes} kB: {found}");
            assert_eq!(found.lines().next(), Some("1"), "{found}");
            let said = String::from_utf8_lossy(&output.stderr);
            let line = said.lines().next().unwrap_or_default();
            assert!(line.starts_with("error: cannot write ") && line.contains("No space"), "{said}");
            for line in found.lines().skip(1) {
                let Some((bytes, name)) = line.trim().split_once(' ') else { continue };
                let bytes: u64 = bytes.parse().expect("a number");
                assert!(name == "total" || whole.contains(&(name, bytes)), "{kilobytes} kB: {line}");
            }
        }
        fs::remove_dir_all(out).expect("removed");
    }
}
