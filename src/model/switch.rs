//! [`Switch`]: a constraint equation that opens, closes or is hit at an event.

use super::Param;

/// What an event does to a constraint equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    Open,
    Close,
    /// Closes at the present value of Φ.
    Hold,
    /// An impact with this coefficient of restitution.
    Impact(Param),
}

/// A change of a constraint equation at an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Switch {
    pub(crate) event: usize,
    pub(crate) equation: usize,
    pub(crate) action: Action,
}

/// The gap of a rigid contact, as a constraint equation and as an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gap {
    pub(crate) event: usize,
    pub(crate) equation: usize,
}
