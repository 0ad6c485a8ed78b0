//! Handles to the parts of a scene; each remembers which scene it belongs to.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::expressions;
use crate::program::{Graph, Node};

/// A part of a scene, identified by the numbers of the scene and of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Handle {
    scene: u64,
    pub(crate) index: usize,
}

/// The numbers of a scene, each unique within the program; handles carry the last one. A clone has the same numbers until a part is added to one of the two.
#[derive(Clone, Debug)]
pub(crate) struct SceneTag(Arc<Numbers>);

/// Numbers shared by a scene, its clones and their systems. Dropping them discards the recorded expressions.
#[derive(Debug)]
struct Numbers {
    all: Vec<u64>,
    _before: Option<SceneTag>,
}

impl Default for SceneTag {
    fn default() -> Self {
        SceneTag::after(None)
    }
}

impl SceneTag {
    fn after(before: Option<SceneTag>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let mut all = before.as_ref().map_or(Vec::new(), |before| before.numbers().to_vec());
        all.push(NEXT.fetch_add(1, Ordering::Relaxed));
        expressions::begin(&all);
        SceneTag(Arc::new(Numbers { all, _before: before }))
    }

    pub(crate) fn numbers(&self) -> &[u64] {
        &self.0.all
    }

    pub(crate) fn handle(&self, index: usize) -> Handle {
        Handle { scene: self.0.all[self.0.all.len() - 1], index }
    }

    pub(crate) fn owns(&self, handle: &Handle) -> bool {
        self.0.all.contains(&handle.scene)
    }

    /// Takes a new number before a part is added, if others share the present ones.
    pub(crate) fn begin_part(&mut self) {
        if Arc::get_mut(&mut self.0).is_none() {
            *self = SceneTag::after(Some(self.clone()));
        }
    }

    /// The recorded expressions of the scene and its clones.
    pub(crate) fn expressions(&self) -> Graph {
        expressions::with(self.0.all[0], |graph| graph.clone()).unwrap_or_default()
    }
}

impl Drop for Numbers {
    fn drop(&mut self) {
        expressions::end(&self.all);
    }
}

impl Handle {
    pub(crate) fn scene(&self) -> u64 {
        self.scene
    }
}

/// A node of a scene's expressions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Expression {
    pub(crate) scene: u64,
    pub(crate) node: Node,
}

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct $name(pub(crate) Handle);

        impl $name {
            /// The index of the quantity with this handle in the vectors and matrices of the compiled system.
            pub fn index(&self) -> usize {
                self.0.index
            }
        }
    )*};
}

handles! {
    /// A generalized coordinate.
    Coordinate;
    /// A control channel.
    Control;
    /// A design variable.
    Design;
    /// An output: a scalar result of a motion in addition to J.
    Output;
    /// The Lagrange multiplier (impulse σ) of one constraint equation.
    Multiplier;
    /// A function of the state whose zero is an event ([`Scene::event`](crate::Scene::event)).
    Event;
}
