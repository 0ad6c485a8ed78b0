//! Files that are written completely or not at all, and standard output whose errors are reported.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::Error;

/// The output folder, created if necessary: the requested one, else `out` in the folder of this package or, if that is missing, in the current one.
pub fn folder(asked: Option<&Path>) -> Result<PathBuf, Error> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let usual = || if package.is_dir() { package.join("out") } else { "out".into() };
    let folder = asked.map_or_else(usual, Path::to_owned);
    let probe = part_of(&folder.join("probe"));
    let tried = fs::create_dir_all(&folder).and_then(|()| fs::write(&probe, "")).and_then(|()| fs::remove_file(&probe));
    tried.map_err(|source| Error::File { path: folder.clone(), source }).map(|()| folder)
}

/// Writes a temporary file and renames it, so that an interrupted run leaves either the old file or the new one.
pub fn write(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Error> {
    replace(path, contents.as_ref()).map_err(|source| Error::File { path: path.to_owned(), source })
}

pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let json = serde_json::to_string_pretty(value).map_err(io::Error::from);
    write(path, json.map_err(|source| Error::File { path: path.to_owned(), source })? + "\n")
}

pub fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(Error::Output)
}

/// Prints a line to standard error; unlike `eprintln!` it does not panic if standard error is closed.
pub fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

fn replace(path: &Path, contents: &[u8]) -> io::Result<()> {
    let part = part_of(path);
    let written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(contents)?;
        // A full disk may be reported only here.
        file.sync_all()
    });
    let moved = written.and_then(|()| fs::rename(&part, path));
    if moved.is_err() {
        let _ = fs::remove_file(&part);
    }
    moved
}

/// Path of the temporary file: a hidden name in the same folder, unique to this process.
fn part_of(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{}.{name}", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_written_leaves_the_old_one_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("paper-repro-files-{}", std::process::id()));
        let folder = super::folder(Some(&folder)).unwrap();
        let path = folder.join("a.csv");
        write(&path, "old").unwrap();
        // A folder has the name of the temporary file, which can then be neither created nor written.
        fs::create_dir(part_of(&path)).unwrap();
        let message = write(&path, "new").unwrap_err().to_string();
        assert!(message.contains("a.csv") && message.contains("--out"), "{message}");
        fs::remove_dir(part_of(&path)).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        write(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        // A folder has the name of the file.
        fs::create_dir(folder.join("b.csv")).unwrap();
        assert!(write(&folder.join("b.csv"), "new").is_err());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
        // A file has the name of the folder.
        assert!(super::folder(Some(&path)).is_err());
        fs::remove_dir_all(folder).unwrap();
    }
}
