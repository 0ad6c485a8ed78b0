//! Detects formulas that branch on the value of an argument and therefore cannot be recorded as a graph.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    /// True if a formula has read the value of a number that depends on its arguments (to branch on it).
    static LOOKED: Cell<bool> = const { Cell::new(false) };
}

/// The value of a formula that may not be defined here; `None` if it panics.
pub(crate) fn guarded<T>(formula: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(formula)).ok()
}

/// Records that a formula has read a value that depends on its arguments.
pub(crate) fn note_look() {
    LOOKED.set(true);
}

/// True if a formula has read a value that depends on its arguments since the last call.
pub(crate) fn take_look() -> bool {
    LOOKED.take()
}
