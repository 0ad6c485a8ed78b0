//! The program, run in a folder of its own.
#![allow(dead_code)]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A temporary folder, removed at the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("hamiltonian-adjoint-cli {name} {}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        Folder(folder)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn write(&self, file: &str, text: &str) {
        fs::write(self.0.join(file), text).expect("a file");
    }

    pub fn read(&self, file: &str) -> String {
        fs::read_to_string(self.0.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    /// The program with these arguments, not yet started.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hamiltonian-adjoint"));
        command.args(arguments).current_dir(&self.0).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(arguments, self.command(arguments).output().expect("the program"))
    }

    /// Runs the program with a text as standard input.
    pub fn run_with(&self, arguments: &[&str], input: &str) -> Run {
        let mut child = self.command(arguments).stdin(Stdio::piped()).spawn().expect("the program");
        child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("it is read");
        Run::of(arguments, child.wait_with_output().expect("the program"))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Output and exit status of a run.
pub struct Run {
    arguments: String,
    pub status: Option<i32>,
    pub printed: String,
    pub errors: String,
}

impl Run {
    pub fn of(arguments: &[&str], Output { status, stdout, stderr }: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
        Run { arguments: arguments.join(" "), status: status.code(), printed: text(stdout), errors: text(stderr) }
    }

    /// Standard output of a run that succeeded.
    #[track_caller]
    pub fn succeeded(&self) -> String {
        assert_eq!(self.status, Some(0), "{}\n{}", self.arguments, self.errors);
        self.printed.trim_end().to_string()
    }

    /// Asserts a failure with this status, whose messages contain these texts.
    #[track_caller]
    pub fn failed(&self, status: i32, texts: &[&str]) {
        assert_eq!(self.status, Some(status), "{}\n{}", self.arguments, self.errors);
        for text in texts {
            assert!(self.errors.contains(text), "{}: `{text}` is not in\n{}", self.arguments, self.errors);
        }
        assert!(!self.errors.contains("panicked"), "{}", self.errors);
    }
}
