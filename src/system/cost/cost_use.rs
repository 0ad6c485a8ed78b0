//! [`CostUse`]: the arguments that a cost needs, and [`Term`]: a cost without its formula.

use crate::model::element::Sum;
use crate::program::Obstacle;
use crate::system::formula::{Connections, Slot};

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

/// Quantities of a node, other than y and u, that costs need.
#[derive(Clone, Copy, Debug)]
pub struct CostUse {
    /// v̇ or λ.
    pub accelerations: Depends,
    /// u̇.
    pub control_rates: Depends,
    /// t.
    pub time: Depends,
    /// σ, or p* or ṗ*, which contain it.
    pub multipliers: Depends,
}

impl CostUse {
    pub const NONE: Self = CostUse::all(Depends::Never);
    pub const UNKNOWN: Self = CostUse::all(Depends::Perhaps);

    const fn all(depends: Depends) -> Self {
        CostUse { accelerations: depends, control_rates: depends, time: depends, multipliers: depends }
    }

    /// The quantities needed by a cost that depends on these arguments.
    pub fn of(arguments: impl Iterator<Item = Slot>) -> Self {
        arguments.fold(CostUse::NONE, |uses, of| match of {
            Slot::VDot(_) | Slot::Lambda(_) => CostUse { accelerations: Depends::Always, ..uses },
            Slot::UDot(_) => CostUse { control_rates: Depends::Always, ..uses },
            Slot::T => CostUse { time: Depends::Always, ..uses },
            Slot::Sigma(_) | Slot::PStar(_) | Slot::PStarDot(_) => CostUse { multipliers: Depends::Always, ..uses },
            _ => uses,
        })
    }

    /// The quantities needed by either of two costs.
    pub fn and(self, other: CostUse) -> Self {
        CostUse {
            accelerations: self.accelerations.max(other.accelerations),
            control_rates: self.control_rates.max(other.control_rates),
            time: self.time.max(other.time),
            multipliers: self.multipliers.max(other.multipliers),
        }
    }
}
