//! A compiled scene: batches of elements of equal type, their constant part, and the structure of the tangent matrix.

mod compile;
mod compiled;
mod cost;
mod cost_terms;
mod formula;
mod kinks;
mod plain;
mod report;
mod rounding_rows;
mod switches;
mod tangent;
mod uncoupled;

pub(crate) use compile::{Parts, Required};
pub use compiled::System;
pub(crate) use cost::{
    Beside, CostFactors, CostPrograms, CostRows, Depends, EVENTS, GivenWeights, Occurring, PlacedCost, Weights,
};
pub(crate) use formula::{
    AnyCost, AnyElement, Applied, Connections, CostOfLists, Covector, Entry, Fixed, Holonomic, InputRows, Kinetic, Lists,
    NodeValues, NodeView, Pair, PlacedElement, Positions, Potential, Restricted, SEEDS, Shape, StateRows, Sums, Within,
};
#[cfg(feature = "files")]
pub(crate) use formula::{ElementKind, GraphFormula, Placed, Recordable, Slot, Values};
pub(crate) use kinks::Kinks;
pub(crate) use report::Order;
#[cfg(test)]
pub(crate) use report::verify_tests;
pub(crate) use tangent::{
    AccelerationEquations, AccelerationSecondOrder, Constants, Entries, Formulas, Given, KnownPart, PositionConstraints,
    Row, SecondOrderEquations, Sines, Variable, Wanted, Workspace, acceleration_tangent, all, of_force, row_q,
};
