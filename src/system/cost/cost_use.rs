//! [`CostUse`]: the arguments that a cost needs, and [`Term`]: a cost without its formula.

use crate::model::element::Sum;
use crate::program::Obstacle;
use crate::system::formula::{Connections, LISTS, Slot};

/// Description of a cost without its formula.
pub struct Term<'a> {
    pub name: &'a str,
    /// 0 for J, or 1 + the number of the output.
    pub output: usize,
    pub sum: Sum,
    pub uses: CostUse,
    pub has_program: bool,
    /// The reason why the cost has no program, unless programs were disabled.
    pub obstacle: Option<Obstacle>,
    pub to: &'a Connections,
}

/// Whether a cost depends on a quantity; `Perhaps` if its formula cannot be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Depends {
    Never,
    Perhaps,
    Always,
}

/// Whether costs depend on each list of arguments.
#[derive(Clone, Copy, Debug)]
pub struct CostUse([Depends; LISTS]);

impl CostUse {
    pub const NONE: Self = CostUse([Depends::Never; LISTS]);
    pub const UNKNOWN: Self = CostUse([Depends::Perhaps; LISTS]);

    /// The lists that contain these arguments.
    pub fn of(arguments: impl Iterator<Item = Slot>) -> Self {
        let mut uses = CostUse::NONE;
        arguments.for_each(|of| uses.0[of.place().0] = Depends::Always);
        uses
    }

    /// The lists needed by either of two costs.
    pub fn and(self, other: CostUse) -> Self {
        CostUse(std::array::from_fn(|list| self.0[list].max(other.0[list])))
    }

    fn any<const L: usize>(&self, lists: [fn(usize) -> Slot; L]) -> Depends {
        lists.iter().fold(Depends::Never, |depends, of| depends.max(self.0[of(0).place().0]))
    }

    /// Whether v̇ or λ is needed.
    pub fn accelerations(&self) -> Depends {
        self.any([Slot::VDot, Slot::Lambda])
    }

    /// Whether u̇ is needed.
    pub fn control_rates(&self) -> Depends {
        self.any([Slot::UDot])
    }

    pub fn time(&self) -> Depends {
        self.any([|_| Slot::T])
    }

    /// Whether arguments other than q, v and constants are needed.
    pub fn more_than_states(&self) -> Depends {
        let others: [fn(usize) -> Slot; 8] =
            [Slot::PStar, Slot::PStarDot, Slot::VDot, Slot::Lambda, Slot::Sigma, Slot::U, Slot::UDot, |_| Slot::T];
        self.any(others)
    }

    /// Whether σ, or p* or ṗ*, which contain it, is needed.
    pub fn multipliers(&self) -> Depends {
        self.any([Slot::Sigma, Slot::PStar, Slot::PStarDot])
    }
}
