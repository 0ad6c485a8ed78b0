//! The structure of the library: every folder imports only from those above it in this list, also through the names that `lib.rs` exports.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// From what knows nothing of the others to what knows them all.
const ROOMS: &[&str] = &[
    "error",
    "warning",
    "memory",
    "number",
    "program",
    "scheme",
    "settings",
    "linear",
    "model",
    "system",
    "scene",
    "motion",
    "node",
    "forward",
    "adjoint",
    "paper_system",
    "solver",
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

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file without comments and without its unit tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a source file");
    let lines = text.lines().take_while(|line| !line.starts_with("#[cfg(test)]") || !text.contains("mod tests {"));
    lines.filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The first names of a list in braces, `a::b, {c, d}::e` giving `a` and so on, or of a single path.
fn first_names(tree: &str) -> Vec<String> {
    let name = |path: &str| path.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let Some(list) = tree.strip_prefix('{') else { return vec![name(tree)] };
    let (mut depth, mut names, mut item) = (0, Vec::new(), String::new());
    for c in list.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(name(&std::mem::take(&mut item))),
            _ => {}
        }
        if c != ',' || depth > 0 {
            item.push(c);
        }
    }
    names.push(name(&item));
    names.retain(|name| !name.is_empty());
    names
}

/// The room that each name exported by `lib.rs` comes from.
fn exports(lib: &str) -> BTreeMap<String, String> {
    let mut rooms = BTreeMap::new();
    for statement in lib.split("pub use ").skip(1) {
        let statement = statement.split(';').next().unwrap_or_default();
        let room: String = statement.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let last = statement.rsplit_once("::{").map_or_else(
            || statement.rsplit("::").next().map(str::to_string).into_iter().collect(),
            |(path, list)| {
                let mut names = first_names(&format!("{{{list}"));
                names.extend(path.rsplit("::").next().map(str::to_string));
                names
            },
        );
        last.into_iter().for_each(|name| drop(rooms.insert(name, room.clone())));
    }
    rooms
}

#[test]
fn every_room_imports_only_from_those_above_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let exports = exports(&code(&root.join("lib.rs")));
    assert_eq!(exports.get("Solver").map(String::as_str), Some("solver"), "the parser has lost its way");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let (mut arrows, mut wrong) = (0, Vec::new());
    for path in &files {
        let own = path.strip_prefix(&root).expect("inside");
        let room = own.iter().next().and_then(|room| room.to_str()).expect("a name").trim_end_matches(".rs").to_string();
        let text = code(path);
        for tree in text.split("crate::").skip(1) {
            for name in first_names(tree) {
                let target = if ROOMS.contains(&name.as_str()) { Some(&name) } else { exports.get(&name) };
                // Names of other crates' items behind a macro's `$crate::` do not occur.
                let Some(target) = target else { continue };
                arrows += 1;
                if *target != room && rank(target) >= rank(&room) {
                    wrong.push(format!("{} imports `{name}` of `{target}`", own.display()));
                }
            }
        }
    }
    assert!(arrows > 300, "only {arrows} imports were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn few_files_stand_outside_of_the_rooms() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = fs::read_dir(root).expect("src").filter(|entry| entry.as_ref().is_ok_and(|entry| entry.path().is_file()));
    assert!(files.count() <= MOST_FILES);
}
