//! Handles to the parts of a scene; each remembers which scene it belongs to.

use std::sync::atomic::{AtomicU64, Ordering};

use super::expressions;
use crate::program::{Graph, Node};

/// A part of a scene, identified by the numbers of the scene and of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Handle {
    scene: u64,
    pub(crate) index: usize,
}

/// Number of a scene, unique within the program. Dropping it discards the recorded expressions of the scene.
#[derive(Debug)]
pub(crate) struct SceneTag(u64);

impl Default for SceneTag {
    fn default() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let scene = NEXT.fetch_add(1, Ordering::Relaxed);
        expressions::begin(scene);
        SceneTag(scene)
    }
}

impl SceneTag {
    pub(crate) fn handle(&self, index: usize) -> Handle {
        Handle { scene: self.0, index }
    }

    pub(crate) fn owns(&self, handle: &Handle) -> bool {
        handle.scene == self.0
    }

    /// The number of the scene.
    pub(crate) fn number(&self) -> u64 {
        self.0
    }

    /// Removes and returns the recorded expressions of the scene; no further ones can be added.
    pub(crate) fn take_expressions(&self) -> Graph {
        expressions::take(self.0)
    }
}

impl Drop for SceneTag {
    fn drop(&mut self) {
        self.take_expressions();
    }
}

impl Handle {
    /// The handle of part `index` of the scene with the given number.
    pub(crate) fn of(scene: u64, index: usize) -> Self {
        Handle { scene, index }
    }

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
}
