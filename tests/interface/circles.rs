//! The structure of the library: at most three files import from each other in a circle.

use std::collections::{BTreeMap, BTreeSet};

use crate::sources::{Library, ROOT};

/// Largest number of files in a circle.
const MOST_FILES: usize = 3;

/// For each file, the files that it needs, with the names that it needs from them.
type Arrows<'a> = BTreeMap<&'a str, BTreeMap<&'a str, BTreeSet<&'a str>>>;

fn arrows(library: &Library) -> Arrows<'_> {
    let mut arrows = Arrows::new();
    for module in library.modules().filter(|module| *module != ROOT) {
        let to = arrows.entry(module).or_default();
        library.needs(module).for_each(|(name, of)| _ = to.entry(of).or_default().insert(name));
    }
    arrows
}

/// All files that a file needs, also through others.
fn reached<'a>(arrows: &Arrows<'a>, from: &'a str) -> BTreeSet<&'a str> {
    let (mut reached, mut ahead) = (BTreeSet::new(), vec![from]);
    while let Some(next) = ahead.pop() {
        let to = arrows.get(next).into_iter().flat_map(BTreeMap::keys);
        ahead.extend(to.copied().filter(|to| reached.insert(*to)));
    }
    reached
}

/// The largest sets of files of which each needs all others.
fn circles<'a>(arrows: &Arrows<'a>) -> BTreeSet<BTreeSet<&'a str>> {
    let reached: BTreeMap<&str, _> = arrows.keys().map(|from| (*from, reached(arrows, from))).collect();
    let circle = |from: &str| -> BTreeSet<&'a str> {
        reached[from].iter().copied().filter(|to| reached.get(to).is_some_and(|back| back.contains(from))).collect()
    };
    arrows.keys().map(|from| circle(from)).filter(|circle| circle.len() > MOST_FILES).collect()
}

/// The folder that contains all files of a circle.
fn folder(circle: &BTreeSet<&str>) -> String {
    let [first, last] = [circle.first(), circle.last()].map(|module| module.into_iter().flat_map(|m| m.split("::")));
    first.zip(last).take_while(|(a, b)| a == b).map(|(a, _)| a).collect::<Vec<_>>().join("::")
}

/// The files of a circle, with the names that they import from each other.
fn describe(arrows: &Arrows, circle: &BTreeSet<&str>) -> String {
    let mut text = format!("{} files of {} import from each other:\n", circle.len(), folder(circle));
    for module in circle {
        for (of, names) in arrows[module].iter().filter(|(of, _)| circle.contains(*of)) {
            let names = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            text += &format!("  {module} imports {names} of {of}\n");
        }
    }
    text
}

#[test]
fn few_files_import_from_each_other() {
    let library = Library::read();
    let arrows = arrows(&library);
    let count: usize = arrows.values().map(BTreeMap::len).sum();
    assert!(count > 1000, "only {count} pairs of files were found");
    let wrong: String = circles(&arrows).iter().map(|circle| describe(&arrows, circle)).collect();
    assert!(wrong.is_empty(), "{wrong}");
}
