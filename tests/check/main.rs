//! Checks of derivatives: right ones pass, wrong ones are found and named, in any units.

mod blocks_units;
mod elements;
mod features;
mod gradient;
mod hand;
#[cfg(feature = "serde")]
mod json;
mod limits;
mod mutations;
mod reports;
mod sensitivity;
mod step;
mod stiff;
mod units;
