//! What goes out and comes in: pages, files, programs in other languages, progress. Files and programs want `--features files`.

#[path = "../common/mod.rs"]
mod common;

mod animation;
mod extremes;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "files")]
mod formulas;
#[cfg(feature = "files")]
mod pipe;
mod progress;
#[cfg(feature = "files")]
mod ready_costs;
#[cfg(feature = "files")]
mod scenes;
#[cfg(feature = "files")]
mod schema;
mod space;
#[cfg(feature = "files")]
mod space_files;
#[cfg(feature = "files")]
mod study;
#[cfg(feature = "files")]
mod worksheet;
