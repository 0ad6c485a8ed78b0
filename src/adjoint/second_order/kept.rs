//! [`KeptFactors`]: the factors of K(h) at the stages of a motion, for all products along other directions and their ways back.

use crate::System;
use crate::forward::Motion;
use crate::linear::{BlockLu, Breakdown, Factorization};
use crate::node::Newton;

/// Of motions that would need more bytes than this nothing is kept.
const MOST_BYTES: usize = 1 << 26;

/// Two for each stage: of its K, and of that of the end of a step at a node where a restart follows.
#[derive(Default)]
pub(super) struct KeptFactors(Vec<Kept>);

struct Kept {
    factors: BlockLu,
    is_known: bool,
}

impl KeptFactors {
    /// Another motion begins.
    pub(super) fn forget(&mut self) {
        self.0.iter_mut().for_each(|kept| kept.is_known = false);
    }

    /// Makes room for a motion.
    pub(super) fn fit(&mut self, system: &System, motion: &Motion) {
        let symbolic = system.symbolic();
        let bytes = symbolic.values_len() * size_of::<f64>() + symbolic.size() * (size_of::<f64>() + size_of::<usize>());
        let count = 2 * motion.blocks.ncols();
        let count = if count.saturating_mul(bytes) <= MOST_BYTES { count } else { 0 };
        self.0.resize_with(count, || Kept { factors: BlockLu::new(symbolic), is_known: false });
    }

    /// Puts the factors of a stage in the place of those at hand, and says whether they are known.
    pub(super) fn lend(&mut self, system: &System, newton: &mut Newton, (at, h): (Place, f64)) -> Result<bool, Breakdown> {
        let Some(kept) = self.0.get_mut(at.index()).filter(|kept| kept.is_known) else { return Ok(false) };
        newton.select_step(system, h)?;
        newton.exchange_factors(&mut kept.factors);
        Ok(true)
    }

    /// Keeps the factors at hand for the stage that they are of.
    pub(super) fn take_back(&mut self, newton: &mut Newton, at: Place) {
        if let Some(kept) = self.0.get_mut(at.index()) {
            newton.exchange_factors(&mut kept.factors);
            kept.is_known = true;
        }
    }
}

/// A stage by its column of second derivatives, and whether it is the end of a step at a node where a restart follows.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) column: usize,
    pub(super) is_end: bool,
}

impl Place {
    fn index(self) -> usize {
        2 * self.column + usize::from(self.is_end)
    }
}
