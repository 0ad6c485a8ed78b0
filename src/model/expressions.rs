//! The expressions of the scenes that are being built, one graph each.
//!
//! Design variables and parameters are copied about like numbers and know no scene, so that `m * l * l / 12.0` can be written; what such a formula
//! says is noted here, under the number of the scene, until the scene is compiled or dropped. Input `p` of a graph is design variable `p`.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::program::Graph;

static GRAPHS: Mutex<BTreeMap<u64, Graph>> = Mutex::new(BTreeMap::new());

fn graphs() -> MutexGuard<'static, BTreeMap<u64, Graph>> {
    // A graph is whole between two operations on it.
    GRAPHS.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn begin(scene: u64) {
    graphs().insert(scene, Graph::default());
}

/// Works on the graph of a scene, while it is being built.
pub(super) fn with<T>(scene: u64, work: impl FnOnce(&mut Graph) -> T) -> Option<T> {
    graphs().get_mut(&scene).map(work)
}

/// The graph of a scene, which is forgotten here.
pub(super) fn take(scene: u64) -> Graph {
    graphs().remove(&scene).unwrap_or_default()
}
