//! The expressions of the existing scenes, one graph for each scene and its clones.
//!
//! Design variables and parameters are copied like numbers and hold no reference to their scene, so that `m * l * l / 12.0` can be written. Each
//! operation is recorded here, under the numbers of the scene, as long as scenes or systems with these numbers exist. Input `p` of a graph is design
//! variable `p`.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::program::Graph;

/// For every number, the numbers of its scene up to this one, ascending, and, for the first number of a scene, the graph.
static NOTES: Mutex<BTreeMap<u64, (Vec<u64>, Graph)>> = Mutex::new(BTreeMap::new());

fn notes() -> MutexGuard<'static, BTreeMap<u64, (Vec<u64>, Graph)>> {
    // Every operation leaves its graph consistent, so a poisoned lock may still be used.
    NOTES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Records a new number of a scene, the last one of these.
pub(super) fn begin(numbers: &[u64]) {
    notes().insert(numbers[numbers.len() - 1], (numbers.to_vec(), Graph::default()));
}

/// Discards the last one of these numbers.
pub(super) fn end(numbers: &[u64]) {
    notes().remove(&numbers[numbers.len() - 1]);
}

/// The number of an expression of parts with these numbers; `None` if no scene has all of them.
pub(super) fn common(mut numbers: impl Iterator<Item = u64> + Clone) -> Option<u64> {
    let (last, notes) = (numbers.clone().max()?, notes());
    let (known, _) = notes.get(&last)?;
    numbers.all(|number| known.contains(&number)).then_some(last)
}

/// Applies `work` to the graph of a number; `None` if its scenes and systems no longer exist.
pub(super) fn with<T>(number: u64, work: impl FnOnce(&mut Graph) -> T) -> Option<T> {
    let mut notes = notes();
    let first = notes.get(&number)?.0[0];
    notes.get_mut(&first).map(|(_, graph)| work(graph))
}
