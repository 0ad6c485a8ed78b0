//! [`Restarting`]: the state of the restarts so far, for the next one (`forward/restart.rs`).

use crate::node::Point;

/// σ₋: the multipliers at the last end of a macro step, after a restart there.
#[derive(Default)]
pub(crate) struct LastEnd {
    pub(crate) node: usize,
    pub(crate) sigma: Vec<f64>,
}

/// State of the restarts so far that the next one needs.
pub(crate) struct Restarting {
    /// The largest range of σ between two restarts, as estimated so far.
    pub(crate) most_range: f64,
    pub(crate) last_end: LastEnd,
    pub(super) point: Point,
}

impl Restarting {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Restarting { most_range: 0.0, last_end: LastEnd { node: 0, sigma: vec![0.0; m] }, point: Point::new(n, m) }
    }
}
