//! Handles to the parts of a scene; each remembers which scene it belongs to.

use std::sync::atomic::{AtomicU64, Ordering};

/// A part of a scene, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Handle {
    scene: u64,
    pub(crate) index: usize,
}

/// A number that no other scene of the program has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SceneTag(u64);

impl Default for SceneTag {
    fn default() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        SceneTag(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

impl SceneTag {
    pub(crate) fn handle(self, index: usize) -> Handle {
        Handle { scene: self.0, index }
    }

    pub(crate) fn owns(self, handle: &Handle) -> bool {
        handle.scene == self.0
    }
}

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct $name(pub(crate) Handle);

        impl $name {
            /// Its index in the vectors and matrices of the compiled system.
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
    /// The Lagrange multiplier (impulse σ) of one constraint equation.
    Multiplier;
}
