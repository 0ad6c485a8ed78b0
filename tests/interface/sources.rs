//! The files of the library, and the names that they import from each other.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The root of the library's modules.
pub const ROOT: &str = "crate";

/// The files of the library by their modules, `crate::forward::motion`.
pub struct Library(BTreeMap<String, Source>);

/// A file.
struct Source {
    /// True for `mod.rs` and `lib.rs`, whose public imports are only other paths to the names of their folder.
    is_door: bool,
    imports: Vec<Import>,
    /// The full paths of imported names.
    names: BTreeMap<String, String>,
}

/// A name that a file imports, or writes with its path.
struct Import {
    kind: Kind,
    path: String,
    name: String,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// `crate::a::b` in the code.
    Path,
    /// `use crate::a::b;`
    Use,
    /// `pub use crate::a::b;`
    PublicUse,
}

impl Library {
    pub fn read() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut library = BTreeMap::new();
        for path in files(&root) {
            let own = path.strip_prefix(&root).expect("inside").with_extension("");
            let parts = own.iter().map(|part| part.to_str().expect("a name")).filter(|part| !["lib", "mod"].contains(part));
            let module = [ROOT].into_iter().chain(parts).collect::<Vec<_>>().join("::");
            let is_door = own.ends_with("mod") || own.ends_with("lib");
            library.insert(module, Source { is_door, imports: imports(&code(&path)), names: BTreeMap::new() });
        }
        let modules: Vec<String> = library.keys().cloned().collect();
        for (module, source) in &mut library {
            source.imports.retain_mut(|import| match full(&modules, module, &import.path) {
                Some(path) => {
                    import.path = path;
                    true
                }
                None => false,
            });
            // A macro may import a name of its own file for its callers.
            let is_other =
                |import: &&Import| import.kind != Kind::Path && import.path != format!("{module}::{}", import.name);
            let others = source.imports.iter().filter(is_other);
            source.names = others.map(|import| (import.name.clone(), import.path.clone())).collect();
        }
        Library(library)
    }

    pub fn modules(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// The names that a file imports, with the modules of the files that define them.
    pub fn imports(&self, module: &str) -> impl Iterator<Item = (&str, &str)> {
        self.0[module].imports.iter().map(|import| (import.name.as_str(), self.defining(&import.path)))
    }

    /// The names that a file needs from other files; names that a folder only passes on are not among them.
    pub fn needs(&self, module: &str) -> impl Iterator<Item = (&str, &str)> {
        let Source { is_door, imports, .. } = &self.0[module];
        let needed = imports.iter().filter(|import| !(*is_door && import.kind == Kind::PublicUse));
        needed.map(|import| (import.name.as_str(), self.defining(&import.path))).filter(move |(_, of)| *of != module)
    }

    /// The module of the file that defines the name at a path.
    pub fn defining(&self, path: &str) -> &str {
        let mut path = path.to_string();
        loop {
            let (module, rest) = self.split(&path);
            let (name, behind) = rest.split_once("::").unwrap_or((rest, ""));
            match self.0[module].names.get(name) {
                Some(there) if behind.is_empty() => path = there.clone(),
                Some(there) => path = format!("{there}::{behind}"),
                None => return module,
            }
        }
    }

    /// The longest part of a path that is a module, and the rest.
    fn split<'a>(&self, path: &'a str) -> (&str, &'a str) {
        let ends = path.rmatch_indices("::").map(|(at, _)| at);
        let known = [path.len()].into_iter().chain(ends).find_map(|end| Some((end, self.0.get_key_value(&path[..end])?.0)));
        let (end, module) = known.unwrap_or_else(|| panic!("`{path}` is outside of the library"));
        (module, path[end..].trim_start_matches("::"))
    }
}

/// All files with code in a folder and its folders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let (folders, found): (Vec<PathBuf>, Vec<PathBuf>) = entries.partition(|path| path.is_dir());
    let found = found.into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "rs"));
    found.chain(folders.iter().flat_map(|folder| files(folder))).collect()
}

/// The code of a file without comments and without its unit tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a source file");
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// A path from the root, for a path that is written in a module; `None` for names of other crates.
fn full(modules: &[String], module: &str, path: &str) -> Option<String> {
    let (first, rest) = path.split_once("::").unwrap_or((path, ""));
    let inside = |module: &str| if rest.is_empty() { module.to_string() } else { format!("{module}::{rest}") };
    match first {
        ROOT => Some(path.to_string()),
        "self" => Some(inside(module)),
        "super" => {
            let above = module.rsplit_once("::")?.0;
            if rest.starts_with("super") { full(modules, above, rest) } else { Some(inside(above)) }
        }
        _ => {
            let child = format!("{module}::{first}");
            modules.contains(&child).then(|| inside(&child))
        }
    }
}

/// The names that the code of a file imports or writes with their paths; paths as they are written.
fn imports(code: &str) -> Vec<Import> {
    let mut found = Vec::new();
    for statement in code.split(';') {
        let last_line = |before: &str| before.rsplit('\n').next().unwrap_or_default().trim().to_string();
        let is_use = |at: &usize| {
            let line = last_line(&statement[..*at]);
            line.is_empty() || line == "pub" || line.starts_with("pub(") && line.ends_with(')')
        };
        let at = statement.match_indices("use ").map(|(at, _)| at).find(is_use);
        let (text, tree) = statement.split_at(at.unwrap_or(statement.len()));
        for root in ["crate::", "super::"] {
            for (at, _) in text.match_indices(root) {
                // Neither the middle of a path nor the scope of `pub(in super::super)`.
                if !text[..at].ends_with(|c: char| c == ':' || is_of_name(c)) && !text[..at].ends_with("(in ") {
                    let path: String = text[at..].chars().take_while(|c| *c == ':' || is_of_name(*c)).collect();
                    add("", path.trim_end_matches(':'), Kind::Path, &mut found);
                }
            }
        }
        let kind = if last_line(text).is_empty() { Kind::Use } else { Kind::PublicUse };
        add("", tree.trim_start_matches("use "), kind, &mut found);
    }
    found
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Adds the names of a tree of paths, `a::{b, c as d}`.
fn add(before: &str, tree: &str, kind: Kind, found: &mut Vec<Import>) {
    let tree = tree.trim();
    if let Some((path, list)) = tree.strip_suffix('}').and_then(|tree| tree.split_once('{')) {
        let mut depth = 0;
        let between = |c: char| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            c == ',' && depth == 0
        };
        list.split(between).for_each(|part| add(&format!("{before}{path}"), part, kind, found));
    } else if !tree.is_empty() {
        let (path, alias) = tree.split_once(" as ").unwrap_or((tree, ""));
        let path = format!("{before}{path}");
        let path = path.trim_end_matches("::self").trim_end_matches("::*");
        let name = if alias.is_empty() { path.rsplit("::").next().unwrap_or_default() } else { alias };
        found.push(Import { kind, path: path.to_string(), name: name.to_string() });
    }
}
