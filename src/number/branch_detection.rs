//! Formulas that ask for values: on numbers that are not known before a run, they branch where nobody knows.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    /// Whether a formula has asked for the value of a number that depends on its arguments (to branch on it).
    static LOOKED: Cell<bool> = const { Cell::new(false) };
}

/// What a formula gives where it may not be defined: nothing if it panics.
pub(crate) fn guarded<T>(formula: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(formula)).ok()
}

/// Notes that a formula has asked for a value that is not known before a run.
pub(crate) fn note_look() {
    LOOKED.set(true);
}

/// Whether a formula has asked for such a value since this was called last.
pub(crate) fn take_look() -> bool {
    LOOKED.take()
}
