//! Rigid bodies in space as data: bodies, markers, and the frames of joints.

mod bodies;
mod components;
mod inertia;
mod marker;
mod vectors;

pub(crate) use bodies::{Bodies, BodyPart, Carried, Connection, ConnectionKind, Cut, Following, Frame, Joint, Motion};
pub use components::Components;
pub use inertia::Inertia;
pub(crate) use inertia::{Moments, principal};
#[cfg(feature = "files")]
pub(crate) use marker::Axes;
pub use marker::{Body, Marker, Quantity};
pub(crate) use vectors::{Matrix, Vector, add, apply, negated, plus, scaled, transposed, zero};
