//! Texts about a compiled system: programs, formulas that are not finite, lost derivatives; and programs compared with num-dual.

#[cfg(test)]
mod difference_tests;
mod locate_nonfinite;
mod lost_derivatives;
mod print;
mod verify;
#[cfg(test)]
pub(crate) mod verify_tests;

pub(crate) use lost_derivatives::Order;
pub(in crate::system) use lost_derivatives::find_readers;
#[cfg(test)]
pub(in crate::system) use verify::Draw;
