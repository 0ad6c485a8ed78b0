//! Files that are read within a limit of their size, and written completely or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use crate::Failure;

/// Largest size of a file that is read.
pub const MOST_BYTES: usize = 1 << 30;

/// The name of a file in messages.
pub fn name(path: &Path) -> String {
    if path == "-" { "standard input".into() } else { path.display().to_string() }
}

/// Reads a whole file, or standard input for `-`.
pub fn read(path: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    // A device has no length; its data are limited, too.
    let limit = MOST_BYTES as u64 + 1;
    let length = match path == "-" {
        true => io::stdin().take(limit).read_to_string(&mut text),
        false => File::open(path).and_then(|file| match file.metadata()?.len() < limit {
            true => file.take(limit).read_to_string(&mut text),
            false => Ok(usize::MAX),
        }),
    };
    match length.map_err(|error| Failure::wrong(name(path), error))? {
        0..=MOST_BYTES => Ok(text),
        _ => Err(Failure::wrong(name(path), format!("more than {MOST_BYTES} bytes, which is not supported"))),
    }
}

/// Prints a line to standard error; unlike `eprintln!` it does not panic if standard error is closed.
pub fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints a text to standard output.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Failure::failed("standard output", error))
}

/// Where the result of a command is written.
#[derive(Args)]
pub struct Output {
    /// File for the result, which replaces an existing one only when it is complete [default: standard output]
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    file: Option<PathBuf>,
}

impl Output {
    pub fn is_csv(&self) -> bool {
        self.file.as_ref().and_then(|file| file.extension()).is_some_and(|end| end.eq_ignore_ascii_case("csv"))
    }

    /// Returns an error, before anything is computed, if the file is a folder or if its folder does not exist.
    pub fn check(&self) -> Result<(), Failure> {
        match &self.file {
            Some(file) if file.is_dir() => Err(Failure::wrong(name(file), "this is a folder; name a file in it")),
            Some(file) if !folder(file).is_dir() => Err(Failure::wrong(name(file), "its folder does not exist")),
            _ => Ok(()),
        }
    }

    /// Writes the result with a line break at its end.
    pub fn write(&self, text: &str) -> Result<(), Failure> {
        let text = format!("{}\n", text.trim_end_matches('\n'));
        match &self.file {
            None => print(&text),
            Some(file) => replace(file, text.as_bytes()).map_err(|error| Failure::failed(name(file), error)),
        }
    }
}

fn folder(file: &Path) -> &Path {
    file.parent().filter(|folder| *folder != "").unwrap_or(Path::new("."))
}

/// Writes a temporary file beside the file and renames it. Devices and pipes are written directly.
fn replace(file: &Path, contents: &[u8]) -> io::Result<()> {
    let known = fs::metadata(file).ok();
    if known.as_ref().is_some_and(|known| !known.is_file()) {
        return OpenOptions::new().write(true).open(file)?.write_all(contents);
    }
    // A symbolic link remains a link.
    let file = fs::canonicalize(file).unwrap_or(file.to_path_buf());
    let part = folder(&file).join(format!(".hamiltonian-adjoint.{}", std::process::id()));
    let written = File::create_new(&part).and_then(|mut open| {
        open.write_all(contents)?;
        // A full disk may be reported only here.
        open.sync_all()?;
        known.map_or(Ok(()), |known| open.set_permissions(known.permissions()))?;
        fs::rename(&part, &file)
    });
    written.inspect_err(|_| drop(fs::remove_file(&part)))
}
