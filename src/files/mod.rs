//! Inputs, gradients and motions as text that others can read and write: JSON and CSV, with the names of the scene.
//!
//! What is read may come from anybody: sizes are bounded by that of the text, and what does not fit is named with its place.

mod gradient;
mod inputs;
mod names;
mod report;
mod scene;
mod table;
mod trajectory;

pub use scene::SceneFile;
pub use table::Table;
