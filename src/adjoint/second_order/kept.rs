//! [`KeptFactors`]: the factors of K(h) at the stages of a motion, reused in products along other directions and in their backward sweeps.

use crate::System;
use crate::linear::{BlockLu, Breakdown, Factorization};
use crate::motion::Motion;
use crate::node::Linearisation;

/// If a motion would need more bytes than this, no factors are stored.
const MOST_BYTES: usize = 1 << 26;

/// Two factorisations for each stage: of its K, and of K at the end of a step that precedes an event.
#[derive(Default)]
pub(super) struct KeptFactors(Vec<Kept>);

struct Kept {
    factors: BlockLu,
    is_known: bool,
}

impl KeptFactors {
    /// Begins another motion.
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

    /// Exchanges the current factors for those of a stage; false if these are unknown.
    pub(super) fn lend(
        &mut self,
        system: &System,
        linearisation: &mut Linearisation,
        (at, h): (Place, f64),
    ) -> Result<bool, Breakdown> {
        let Some(kept) = self.0.get_mut(at.index()).filter(|kept| kept.is_known) else { return Ok(false) };
        linearisation.select_step(system, h)?;
        linearisation.exchange_factors(&mut kept.factors);
        Ok(true)
    }

    /// Stores the current factors for the stage to which they belong.
    pub(super) fn take_back(&mut self, linearisation: &mut Linearisation, at: Place) {
        if let Some(kept) = self.0.get_mut(at.index()) {
            linearisation.exchange_factors(&mut kept.factors);
            kept.is_known = true;
        }
    }
}

/// The column of second derivatives of a stage; true if the stage is the end of a step that precedes an event.
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
