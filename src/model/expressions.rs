//! The expressions of the scenes under construction, one graph per scene.
//!
//! Design variables and parameters are copied like numbers and hold no reference to their scene, so that `m * l * l / 12.0` can be written. Each
//! operation is recorded here, under the number of the scene, until the scene is compiled or dropped. Input `p` of a graph is design variable `p`.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::program::Graph;

static GRAPHS: Mutex<BTreeMap<u64, Graph>> = Mutex::new(BTreeMap::new());

fn graphs() -> MutexGuard<'static, BTreeMap<u64, Graph>> {
    // Every operation leaves its graph consistent, so a poisoned lock may still be used.
    GRAPHS.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn begin(scene: u64) {
    graphs().insert(scene, Graph::default());
}

/// Applies `work` to the graph of a scene; `None` if the scene has been compiled or dropped.
pub(super) fn with<T>(scene: u64, work: impl FnOnce(&mut Graph) -> T) -> Option<T> {
    graphs().get_mut(&scene).map(work)
}

/// Removes and returns the graph of a scene.
pub(super) fn take(scene: u64) -> Graph {
    graphs().remove(&scene).unwrap_or_default()
}
