//! The structure of the library: every folder imports only from those above it in this list, also through the names that `lib.rs` exports.

use std::fs;
use std::path::Path;

use crate::sources::Library;

/// From what knows nothing of the others to what knows them all.
const ROOMS: &[&str] = &[
    "error",
    "warning",
    "memory",
    "number",
    "program",
    "text",
    "scheme",
    "settings",
    "linear",
    "model",
    "system",
    "scene",
    "motion",
    "node",
    "redundancy",
    "assembly",
    "accelerations",
    "event",
    "adjoint",
    "forward",
    "paper_system",
    "solver",
    "operating_point",
    "estimate",
    "optimize",
    "check",
    "files",
    "animation",
    "lib",
];

/// At the root of `src` stand only so many files.
const MOST_FILES: usize = 10;

fn rank(room: &str) -> usize {
    ROOMS.iter().position(|known| *known == room).unwrap_or_else(|| panic!("`{room}` has no place in the list of rooms"))
}

/// The room of a file.
fn room(module: &str) -> &str {
    module.split("::").nth(1).unwrap_or("lib")
}

#[test]
fn every_room_imports_only_from_those_above_it() {
    let library = Library::read();
    assert_eq!(room(library.defining("crate::Solver")), "solver", "the parser has lost its way");
    let (mut arrows, mut wrong) = (0, Vec::new());
    for module in library.modules() {
        let own = room(module);
        for (name, of) in library.imports(module) {
            arrows += 1;
            let target = room(of);
            if target != own && rank(target) >= rank(own) {
                wrong.push(format!("{module} imports `{name}` of `{target}`"));
            }
        }
    }
    assert!(arrows > 1000, "only {arrows} imports were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn few_files_stand_outside_of_the_rooms() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = fs::read_dir(root).expect("src").filter(|entry| entry.as_ref().is_ok_and(|entry| entry.path().is_file()));
    assert!(files.count() <= MOST_FILES);
}
