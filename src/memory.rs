//! Checks of available memory before an allocation, because a failed allocation would end the process.

use std::hint::black_box;

use crate::Error;

/// Returns an error if the system cannot provide memory for `count` items of this size.
pub(crate) fn check(what: &'static str, count: usize, size: usize) -> Result<(), Error> {
    let bytes = count.saturating_mul(size);
    // Reserved and released at once; the compiler must not assume that it succeeded.
    let granted = black_box(&mut Vec::<u8>::new()).try_reserve_exact(bytes);
    granted.map_err(|_| Error::OutOfMemory { what, bytes })
}

/// Like `check`, for callers that cannot return an error.
///
/// # Panics
/// If the memory is not available.
#[track_caller]
pub(crate) fn require(what: &'static str, count: usize, size: usize) {
    if let Err(error) = check(what, count, size) {
        panic!("{error}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_granted_and_what_cannot_is_refused_with_its_size() {
        assert_eq!(check("a list", 1000, 8), Ok(()));
        // More than any address space, and more than a number can express.
        for (count, bytes) in [(usize::MAX / 16 + 1, usize::MAX / 2 + 1), (usize::MAX, usize::MAX)] {
            assert_eq!(check("a list", count, 8), Err(Error::OutOfMemory { what: "a list", bytes }));
        }
        assert!(std::panic::catch_unwind(|| require("a list", usize::MAX, 8)).is_err());
    }
}
